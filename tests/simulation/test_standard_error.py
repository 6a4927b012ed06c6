"""Standard error of a mean over ball passes, for sequences with a known scatter of the mean."""

from math import nan, pi

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from bearingsim import signals, simulate
from bearingsim.simulation import settling, start_error
from bearingsim.simulation.accuracy import (
    COSINE_COUNT,
    THREE_SIGMA,
    StandardErrors,
    estimate_standard_errors,
    standard_error,
)
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.recording import first_sample
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.spectral_lines import amplitudes_by_pass, sensor_samples
from tests.scenes.short_cases import RATE, SLOT, case

STUDENT = stdtrit(COSINE_COUNT, THREE_SIGMA) / 3.0


def chains(rho: float, number: int, length: int) -> np.ndarray:
    """Draw chains (number, length) of variance 1, neighbours correlated by ``rho``."""
    noise = np.random.default_rng(3).normal(size=(number, length + 200))
    return lfilter([(1.0 - rho**2) ** 0.5], [1.0, -rho], noise, axis=1)[:, 200:]


def scatter_of_means(rho: float, length: int) -> float:
    """Return the standard deviation of the mean of such a chain, in closed form."""
    within = (1.0 - rho**2) - 2.0 * rho * (1.0 - rho**length) / length
    return float(np.sqrt(within / length) / (1.0 - rho))


def errors(samples: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Estimate the standard error of each chain."""
    return np.array([standard_error(chain[:, np.newaxis], weights) for chain in samples])


@pytest.mark.parametrize("length", [16, 100])
def test_mean_square_error_of_independent_passes(length: int) -> None:
    variance = STUDENT**2 / length
    assert np.mean(errors(chains(0.0, 4000, length)) ** 2) == pytest.approx(variance, rel=0.02)


@pytest.mark.parametrize("rho", [-0.9, -0.5, 0.0, 0.5, 0.9])
def test_error_covers_correlated_and_alternating_passes(rho: float) -> None:
    samples, scatter = chains(rho, 1000, 512), scatter_of_means(rho, 512)
    estimates = errors(samples)
    assert scatter < np.median(estimates) < 1.3 * scatter
    assert np.mean(np.abs(samples.mean(axis=1)) < 3.0 * estimates) >= 0.99


def test_error_covers_correlation_over_tens_of_passes() -> None:
    samples = chains(np.exp(-1.0 / 30.0), 1000, 1000)
    assert np.mean(np.abs(samples.mean(axis=1)) < 3.0 * errors(samples)) >= 0.99


@pytest.mark.parametrize("period", [2, 3, 4])
def test_error_of_a_short_period_is_below_three_over_the_length(period: int) -> None:
    values = np.cos(2.0 * pi * np.arange(12 * 50) / period)
    assert errors(values[np.newaxis])[0] < 3.0 / len(values)


def test_error_scales_with_the_values_and_ignores_an_offset() -> None:
    (chain,) = chains(0.5, 1, 64)
    error = standard_error(chain[:, np.newaxis])
    assert standard_error(1e-6 * (chain[:, np.newaxis] - 7.0)) == pytest.approx(1e-6 * error, rel=1e-9)


def test_variation_common_to_all_passes_is_not_an_error() -> None:
    assert standard_error(np.tile([3.0, -1.0, 0.5], (20, 1))) == pytest.approx(0.0, abs=1e-15)


def test_error_is_independent_of_samples_per_pass() -> None:
    (chain,) = chains(0.0, 1, 200)
    by_pass, by_sample = chain[:, np.newaxis], np.repeat(chain[:, np.newaxis], 10, axis=1)
    assert standard_error(by_sample) == pytest.approx(standard_error(by_pass), rel=0.01)


def test_impacts_at_the_border_of_passes_are_counted_once() -> None:
    """Equal impacts scatter about the border, so only the first and the last may be outside the record."""
    rng, n, M = np.random.default_rng(5), 100, 20
    by_sample, by_pass, means = list[float](), list[float](), list[float]()
    for _ in range(200):
        series = np.zeros((n + 2) * M)
        series[M * np.arange(1, n + 2) + rng.integers(-3, 3, size=n + 1)] = M
        passes = series[M:-M].reshape(n, M)
        means.append(float(passes.mean()))
        by_sample.append(standard_error(passes))
        by_pass.append(standard_error(passes.mean(axis=1, keepdims=True)))
    scatter = np.std(means)
    assert scatter < np.median(by_sample) < 2.0 * scatter
    assert np.median(by_pass) > 2.0 * scatter


def test_error_uses_the_weights_of_passes() -> None:
    weights = signals.pass_weights(300, has_neighbours=True)
    samples = chains(0.5, 1000, 300)
    scatter = np.average(samples, axis=1, weights=weights).std()
    assert scatter < np.median(errors(samples, weights)) < 1.3 * scatter


def test_line_error_of_a_kinematic_cage_uses_samples_in_phase() -> None:
    defect = {"angle": "20 deg", "depth": "5 um"}
    fields = {"model": "rollers", "defect": SLOT | defect, "speed": "1200 rpm", "clearance": "10 um"}
    damping = {"damping": {"law": "kraemer", "beta": "1 us"}}
    setup = set_up(case(**fields, contact=damping, record=[], duration="0.3 s", method="verlet"), 1.0)
    raw = integrate(setup)
    start, M = first_sample(setup.case, setup.grid), setup.grid.fine_per_pass
    pass_lines = amplitudes_by_pass(setup.case, setup.model, setup.grid, raw)
    passes = len(pass_lines["velocity"][0])
    velocity = sensor_samples(setup.case, raw, "velocity", start, passes * M)
    angle = (
        setup.case.bearing.rollers * setup.model.bearing.theta_0 + 2.0 * pi * (start + np.arange(passes * M)) / M
    )
    terms = (2.0 * velocity * np.exp(-1j * angle)).reshape(passes, M)
    in_phase = (terms / terms.mean()).real
    result = estimate_standard_errors(setup.case, setup.model, setup.grid, raw, pass_lines).line
    assert result == pytest.approx(standard_error(in_phase), rel=1e-6)


def test_line_error_of_a_free_cage_uses_lines_of_passes() -> None:
    setup = set_up(case(model="planar", defect=SLOT, record=[], duration="0.25 s", method="verlet"), 1.0)
    raw = integrate(setup)
    pass_lines = amplitudes_by_pass(setup.case, setup.model, setup.grid, raw)
    lines = pass_lines["velocity"][0]
    result = estimate_standard_errors(setup.case, setup.model, setup.grid, raw, pass_lines).line
    weights = signals.pass_weights(len(lines), has_neighbours=True)
    line = np.average(lines, weights=weights)
    in_phase = (lines / line).real[:, np.newaxis]
    assert result == pytest.approx(standard_error(in_phase, weights), rel=1e-9)


def test_random_error_of_few_passes_is_that_of_the_largest_force() -> None:
    """Fewer than 16 passes have no standard error of line and RMS, but the rollers' maxima scatter."""
    forces = np.array([50.0, 52.0, 51.0, 57.0, 50.0, 51.0, 50.0, 53.0])
    motion = start_error.RecordedMotion(np.ones(80), np.ones(80), np.zeros((1, 80)), forces, True)
    result = start_error._random_errors(motion, StandardErrors(np.inf, np.inf), rollers=13, quarter=2)
    excess = [0.0, 1.0, 0.0, 6.0, 0.0, 0.0, 0.0, 2.0]  # above the median of 51 N
    quarters = [52.0, 57.0, 51.0, 53.0]
    scatter = (2.0 * np.mean(np.square(excess)) + np.var(quarters, ddof=1)) ** 0.5
    assert np.isnan([result.line, result.rms]).all()
    assert result.force == pytest.approx(scatter / 57.0)


@pytest.mark.parametrize(("race", "low", "high"), [("roller", 0.003, 0.02), ("outer", 0.1, 0.2)])
def test_largest_force_of_a_defective_roller_has_no_scatter_between_rollers(
    race: str, low: float, high: float
) -> None:
    """One roller of 13 has about 100 N in every revolution, the others 50 N. If all rollers are equal, the
    largest force is that of a rare event."""
    forces = np.full(8 * 13, 50.0)
    forces[::13] += [50.0, 50.4, 50.1, 49.8, 50.3, 51.0, 50.2, 50.0]
    motion = start_error.RecordedMotion(np.ones(8 * 130), np.ones(8 * 130), np.empty((0, 8 * 130)), forces, True)
    of_race = case(bearing="nf308", defect=SLOT | {"race": race, "angle": "0 deg"}, settle="1 s")
    error = start_error._decay_errors(of_race, motion, RATE, StandardErrors(0.0, 0.0)).force
    assert low < error < high


def test_parts_of_a_record_with_an_unbalance_are_whole_revolutions() -> None:
    """The RMS of 14.9 revolutions at 30 Hz is 0.3 % off; quarters of 12 ball passes, 2.26 revolutions, differ by
    more."""
    fields = {"model": "planar", "shaft": {"stiffness": "1e8 N/m", "mass": "2 kg"}}
    rotating = case(settle="1 s", unbalance={"mass_radius": "20 g mm"}, **fields)
    velocity = np.cos(2.0 * pi * 30.0 * np.arange(79 * 20) / (20 * RATE))
    motion = start_error.RecordedMotion(velocity, velocity, np.empty((0, 79 * 20)), np.ones(79), True)
    error = start_error._decay_errors(rotating, motion, RATE, StandardErrors(nan, nan)).rms
    assert 1e-4 < error < 0.005


def motion_of_quarters(quarters: list[float]) -> start_error.RecordedMotion:
    """Return a motion of 48 passes with a line (um/s) of the given amplitude in each quarter, and 10 um/s RMS."""
    velocity = np.repeat(1e-6 * np.array(quarters), 12 * 20) * np.cos(phase := 0.1 * np.pi * np.arange(48 * 20))
    return start_error.RecordedMotion(velocity, np.full(48 * 20, 1e-5), phase[np.newaxis], np.ones(48), False)


@pytest.mark.parametrize("decay", [3.0, 300.0])
def test_changes_that_do_not_decrease_are_not_extrapolated(monkeypatch: pytest.MonkeyPatch, decay: float) -> None:
    """The quarters change by 0.5 and 2, the halves from 2.5 to 3.75, the mean is 3.125 um/s; what is left of the
    slowest mode at rest is the only possible transient."""
    for module in (start_error, settling):
        monkeypatch.setattr(module, "slowest_decay", lambda _: decay)
    passes, unknown = motion_of_quarters([3.0, 2.0, 3.5, 4.0]), StandardErrors(nan, nan)
    settled, unsettled = (
        start_error._decay_errors(case(defect=SLOT, settle=settle), passes, RATE, unknown).line
        for settle in (10.0 / decay, 1.0 / decay)
    )
    r = np.exp(-decay * 24.0 / RATE)
    assert settled == pytest.approx(0.5 * 1.25 / 3.125)
    assert unsettled == pytest.approx(0.5 * 1.25 / 3.125 * (1.0 + r) / (1.0 - r))


def test_line_of_halves_too_short_for_a_window_has_an_unknown_error() -> None:
    """Halves of a record of 5 passes have 2, less than the two periods between the first and the last sample."""
    phase = 0.1 * np.pi * np.arange(5 * 20)
    velocity = np.repeat([1e-6, 2e-6, 3e-6, 4e-6, 5e-6], 20) * np.cos(phase)
    passes = start_error.RecordedMotion(velocity, velocity, phase[np.newaxis], np.ones(5), True)
    result = start_error._decay_errors(case(defect=SLOT, settle="1 s"), passes, RATE, StandardErrors(nan, nan))
    assert np.isnan(result.line)
    assert result.rms > 0.1


@pytest.mark.parametrize("model", ["rollers", "static"])
def test_error_of_less_than_two_turns_of_a_defect_is_unknown(model: str) -> None:
    defect = SLOT | {"race": "inner", "angle": "0 deg"}
    fields = {"model": model, "defect": defect, "step_check": False, "speed": "1800 rpm", "settle": "50 ms"}
    short, long = (simulate(case(**fields, duration=f"{duration} s")).features for duration in (0.05, 0.2))
    for name in ("error.start.rms", "error.start.force"):
        assert np.isnan(short[name])
        assert long[name] > 0.0


def test_scatter_between_the_quarters_of_a_record_is_the_standard_error_of_their_mean(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Quarters of 1, 5, 4 and 2 um/s have the mean 3 um/s in both halves, so nothing decays; RMS 10 um/s."""
    monkeypatch.setattr(start_error, "slowest_decay", lambda _: 1e6)
    quarters, unknown = [1.0, 5.0, 4.0, 2.0], StandardErrors(nan, nan)
    result = start_error._decay_errors(case(defect=SLOT), motion_of_quarters(quarters), RATE, unknown)
    student = stdtrit(6, 0.97725) / 2.0  # a complex amplitude has two degrees of freedom
    assert result.line == pytest.approx(student * np.std(quarters, ddof=1) / 2.0 / 3.0)
    assert result.rms == result.force == 0.0
