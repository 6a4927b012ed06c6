"""The standard error of a mean of ball passes, by properties of sequences whose mean is known to scatter so."""

from math import pi

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from bearingsim import signals
from bearingsim.simulation.accuracy import COSINES, THREE_SIGMA, standard_error, standard_errors
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.recording import first_sample
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.spectral_lines import lines_of_passes, sensor_samples
from tests.scenes.short_cases import SLOT, case

STUDENT = stdtrit(COSINES, THREE_SIGMA) / 3.0


def chains(rho: float, number: int, length: int) -> np.ndarray:
    """Draw chains (number, length) of variance 1, neighbours correlated by ``rho``."""
    noise = np.random.default_rng(3).normal(size=(number, length + 200))
    return lfilter([(1.0 - rho**2) ** 0.5], [1.0, -rho], noise, axis=1)[:, 200:]


def scatter_of_means(rho: float, length: int) -> float:
    """Return the standard deviation of the mean of such a chain, in closed form."""
    within = (1.0 - rho**2) - 2.0 * rho * (1.0 - rho**length) / length
    return float(np.sqrt(within / length) / (1.0 - rho))


def errors(some: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Estimate the standard error of each chain."""
    return np.array([standard_error(chain[:, np.newaxis], weights) for chain in some])


@pytest.mark.parametrize("length", [16, 100])
def test_of_independent_passes_the_mean_square_is_right(length: int) -> None:
    right = STUDENT**2 / length
    assert np.mean(errors(chains(0.0, 4000, length)) ** 2) == pytest.approx(right, rel=0.02)


@pytest.mark.parametrize("rho", [-0.9, -0.5, 0.0, 0.5, 0.9])
def test_neighbours_may_be_alike_or_alternate(rho: float) -> None:
    some, right = chains(rho, 1000, 512), scatter_of_means(rho, 512)
    estimates = errors(some)
    assert right < np.median(estimates) < 1.3 * right
    assert np.mean(np.abs(some.mean(axis=1)) < 3.0 * estimates) >= 0.99


def test_passes_alike_for_tens_of_passes() -> None:
    some = chains(np.exp(-1.0 / 30.0), 1000, 1000)
    assert np.mean(np.abs(some.mean(axis=1)) < 3.0 * errors(some)) >= 0.99


@pytest.mark.parametrize("period", [2, 3, 4])
def test_of_a_short_period_only_the_ends_count(period: int) -> None:
    course = np.cos(2.0 * pi * np.arange(12 * 50) / period)
    assert errors(course[np.newaxis])[0] < 3.0 / len(course)


def test_it_has_the_unit_of_the_values_and_no_offset() -> None:
    (chain,) = chains(0.5, 1, 64)
    known = standard_error(chain[:, np.newaxis])
    assert standard_error(1e-6 * (chain[:, np.newaxis] - 7.0)) == pytest.approx(1e-6 * known, rel=1e-9)


def test_the_course_that_all_passes_share_is_no_error() -> None:
    assert standard_error(np.tile([3.0, -1.0, 0.5], (20, 1))) == pytest.approx(0.0, abs=1e-15)


def test_samples_within_passes_do_not_change_that_of_whole_ones() -> None:
    (chain,) = chains(0.0, 1, 200)
    by_pass, by_sample = chain[:, np.newaxis], np.repeat(chain[:, np.newaxis], 10, axis=1)
    assert standard_error(by_sample) == pytest.approx(standard_error(by_pass), rel=0.01)


def test_events_that_the_border_of_two_passes_cuts_are_counted_once() -> None:
    """Impacts of one size whose instants scatter about the border: only the first and the last may be cut."""
    rng, n, M = np.random.default_rng(5), 100, 20
    by_sample, by_pass, means = list[float](), list[float](), list[float]()
    for _ in range(200):
        series = np.zeros((n + 2) * M)
        series[M * np.arange(1, n + 2) + rng.integers(-3, 3, size=n + 1)] = M
        passes = series[M:-M].reshape(n, M)
        means.append(float(passes.mean()))
        by_sample.append(standard_error(passes))
        by_pass.append(standard_error(passes.mean(axis=1, keepdims=True)))
    right = np.std(means)
    assert right < np.median(by_sample) < 2.0 * right
    assert np.median(by_pass) > 2.0 * right


def test_passes_count_by_their_weights() -> None:
    weights = signals.pass_weights(300, neighbours=True)
    some = chains(0.5, 1000, 300)
    scatter = np.average(some, axis=1, weights=weights).std()
    assert scatter < np.median(errors(some, weights)) < 1.3 * scatter


def test_the_line_of_a_kinematic_cage_is_judged_by_the_samples_along_it() -> None:
    chatters = {"angle": "20 deg", "depth": "5 um"}
    fields = {"model": "rollers", "defect": SLOT | chatters, "speed": "1200 rpm", "clearance": "10 um"}
    damping = {"damping": {"law": "kraemer", "beta": "1 us"}}
    setup = set_up(case(**fields, contact=damping, record=[], duration="0.3 s", method="verlet"), 1.0)
    raw = integrate(setup)
    start, M = first_sample(setup.case, setup.cut), setup.cut.fine_per_pass
    passes = len(lines_of_passes(setup.case, setup.model, setup.cut, raw)["velocity"][0])
    velocity = sensor_samples(setup.case, raw, "velocity", start, passes * M)
    angle = (
        setup.case.bearing.rollers * setup.model.bearing.theta_0 + 2.0 * pi * (start + np.arange(passes * M)) / M
    )
    terms = (2.0 * velocity * np.exp(-1j * angle)).reshape(passes, M)
    along = (terms / terms.mean()).real
    stated = standard_errors(setup.case, setup.model, setup.cut, raw).line
    assert stated == pytest.approx(standard_error(along), rel=1e-6)


def test_the_line_of_a_free_cage_is_judged_by_the_passes_that_it_is_read_from() -> None:
    setup = set_up(case(model="planar", defect=SLOT, record=[], duration="0.25 s", method="verlet"), 1.0)
    raw = integrate(setup)
    stated = standard_errors(setup.case, setup.model, setup.cut, raw).line
    lines = lines_of_passes(setup.case, setup.model, setup.cut, raw)["velocity"][0]
    weights = signals.pass_weights(len(lines), neighbours=True)
    line = np.average(lines, weights=weights)
    along = (lines / line).real[:, np.newaxis]
    assert stated == pytest.approx(standard_error(along, weights), rel=1e-9)
