"""Step check: changes by a shorter step, their bounds, chaos, and refusal of a step."""

import math
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.config.names import QUIET_LINE, STEP_ACCURACY
from bearingsim.simulation import chaos, choice, comparison, pilot, pricing, refinement, step_check, time_grid
from bearingsim.simulation.rounding import NO_ROUNDING
from bearingsim.simulation.run_setup import TooChaotic, set_up
from bearingsim.simulation.simulate import SimulationError, simulate
from bearingsim.simulation.step_check import StepCheck
from tests.scenes.short_cases import SLOT, case
from tests.scenes.step_checks import LIGHT, patched_orbit_check, pilot_check_returning, rollers


@pytest.mark.parametrize("race", ["outer", "inner"])
def test_the_error_of_an_automatic_step_is_within_its_bound(race: str) -> None:
    """Compared with an eighth of the step; checked on an orbit (outer race) and on a pilot (inner race)."""
    test_case = case(model="rollers", method="verlet", defect=SLOT | {"race": race})
    run = simulate(test_case)
    fine_fields = {"step": float(run.info["step_s"]) / 8.0, "step_check": False}
    reference = simulate(test_case.model_copy(update=fine_fields)).features
    line = {"outer": "velocity@BPFO", "inner": "velocity@BPFI"}[race]
    for bound, feature in (("line", line), ("rms", "velocity.rms"), ("force", "outer_force.max")):
        error = abs(run.features[feature] / reference[feature] - 1.0)
        assert error <= run.features[f"step_error.{bound}"] < STEP_ACCURACY
    assert run.features["chaotic"] == 0.0


GIVEN_STEPS = [{"method": "verlet", "step": "0.4 us"}, {"method": "rodas", "tolerance": "0.1 %"}]


@pytest.mark.parametrize("given_step", GIVEN_STEPS)
def test_check_of_a_given_step_leaves_the_record_unchanged(given_step: dict[str, Any]) -> None:
    """Bit for bit; without a check its features are NaN."""
    test_case = rollers(**given_step)
    checked_run, plain = simulate(test_case), simulate(test_case.model_copy(update={"step_check": False}))
    for name, series in checked_run.series.items():
        assert np.array_equal(series, plain.series[name])
    check_features = {
        "chaotic",
        "rms_scatter",
        *(f"step_error.{quantity}" for quantity in ("line", "rms", "force", "record")),
    }
    for name in plain.features.keys() - check_features:
        assert plain.features[name] == pytest.approx(checked_run.features[name], rel=0.0, nan_ok=True)
    assert all(math.isnan(plain.features[name]) for name in check_features)


@pytest.mark.parametrize(
    "fields", [{"step": "0.4 us", "step_check": False}, {"step_check": False}, {"model": "static"}]
)
def test_step_is_not_checked_if_disabled_or_not_used(fields: dict[str, Any]) -> None:
    assert not choice.resolve(case(defect=SLOT, **fields)).checks_step


FAST_SLOT = {"speed": "6000 rpm", "defect": SLOT | {"width": "0.4 mm"}, "duration": "30 ms", "settle": "10 ms"}


def test_given_step_is_checked_and_refused_if_inaccurate() -> None:
    """At 0.85 of its limit Verlet has a line error of 3 %."""
    test_case = case(model="rollers", method="verlet", **FAST_SLOT)
    long_step = 0.85 * choice.limits(test_case).at_impact
    with pytest.raises(SimulationError, match="verlet is not within 1%") as caught:
        simulate(test_case.model_copy(update={"step": long_step}))
    assert "use a shorter `step`" in caught.value.advice
    unchecked = simulate(test_case.model_copy(update={"step": long_step, "step_check": False}))
    assert math.isnan(unchecked.features["step_error.line"])
    assert simulate(test_case.model_copy(update={"step": 0.2 * long_step})).features["step_error.line"] < 0.004


def test_chaos_is_distinguished_from_periodic_motion() -> None:
    for fields, chaotic in ((LIGHT, True), ({}, False), ({"clearance": "25 um"}, False)):
        result = step_check.check_step(set_up(choice.resolve(rollers(step_check=True, **fields)), 1.0))
        assert result.chaotic == chaotic


def test_only_the_rms_is_checked_if_the_motion_is_chaotic() -> None:
    assert StepCheck(line=0.5, rms=0.003, chaotic=True).is_accepted
    assert not StepCheck(line=0.5, rms=0.003, chaotic=False).is_accepted
    assert not StepCheck(line=0.0, rms=0.02, chaotic=True).is_accepted
    assert StepCheck(line=0.0, rms=0.02, chaotic=True, noise=0.01).is_accepted  # within the scatter due to chaos
    assert not step_check.UNCHECKED.is_accepted


def test_unchecked_force_counts_like_the_largest_accepted_one_in_other_bounds() -> None:
    checked = StepCheck(line=0.001, rms=0.001, force=0.02)
    unchecked = replace(checked, checks_force=False)
    assert unchecked.is_accepted
    assert not checked.is_accepted
    accepted = replace(checked, force=STEP_ACCURACY / checked.bounds.factor)
    assert accepted.is_accepted
    assert unchecked.bound(unchecked.line) == accepted.bound(accepted.line) < checked.bound(checked.line)
    assert unchecked.bound(unchecked.force) == checked.bound(checked.force)
    small = replace(unchecked, force=0.0015)
    assert small.bound(small.line) == replace(small, checks_force=True).bound(small.line)


def test_chaotic_run_reports_rms_scatter() -> None:
    """The job succeeds, because its step is accurate."""
    for scatter in (0.02, math.inf):
        result = StepCheck(line=0.5, rms=0.003, chaotic=True, noise=0.02, scatter=scatter)
        with patched_orbit_check(result):
            features = simulate(case()).features
        assert (features["chaotic"], features["rms_scatter"]) == (1.0, scatter)
    assert simulate(case()).features["rms_scatter"] == 0.0


def test_strict_check_refuses_a_chaotic_record_too_short_for_its_rms() -> None:
    result = StepCheck(line=0.5, rms=0.003, chaotic=True, noise=0.02, scatter=0.02)
    with (
        mock.patch.object(refinement, "check_on_pilot", side_effect=pilot_check_returning(result)),
        pytest.raises(TooChaotic) as caught,
    ):
        simulate(case(step_check="strict"))
    assert "the motion is chaotic, and its RMS over 0.08 s is uncertain by 2.0%" in caught.value.reason
    assert "use a `duration` of 0.32 s" in caught.value.advice
    assert caught.value.duration == pytest.approx(0.32)


def test_rms_scatter_is_infinite_if_pilots_have_not_diverged() -> None:
    """Pilots that are still diverging do not bound the scatter; a longer run is advised."""
    chaotic_run = step_check.check_step(set_up(choice.resolve(rollers(**LIGHT)), 1.0))
    lightly_damped = choice.resolve(rollers(contact={"damping": {"chi": "12 s/m"}}))
    result = step_check.check_step(set_up(lightly_damped, 1.0))
    assert chaotic_run.chaotic
    assert math.isfinite(chaotic_run.scatter)
    assert result.chaotic
    assert math.isinf(result.scatter)
    assert pilot.advised_duration(lightly_damped) > lightly_damped.duration


def test_confidence_factor_is_larger_if_a_single_pass_scatters() -> None:
    rng = np.random.default_rng(5)
    periodic = [np.tile(np.sin(np.linspace(0.0, 6.0, 100)), 21)[:2001] for _ in range(3)]
    noise = [rng.normal(0.0, 0.3, 2001) for _ in range(3)]
    first_pass = np.arange(2001) < 100
    all_passes, single_pass = (
        chaos.estimate_rms_scatter([a + b * weight for a, b in zip(periodic, noise, strict=True)], 20)
        for weight in (1.0, first_pass)
    )
    assert all_passes[1] < 3.0 < 8.0 < single_pass[1]
    powers = np.array(
        [
            [np.mean((a + b)[i : i + 100] ** 2) for i in range(0, 2000, 100)]
            for a, b in zip(periodic, noise, strict=True)
        ]
    )
    assert all_passes[0] == pytest.approx(
        np.sqrt(0.5 * powers.var(axis=0, ddof=1).mean()) / powers.mean(), rel=0.05
    )


def test_correlated_passes_increase_the_scatter() -> None:
    rng = np.random.default_rng(7)
    tone = np.sin(np.linspace(0.0, 6.0, 10))
    passes = 1024
    independent, correlated = (
        [
            np.append(np.outer(np.repeat(amplitudes, repeats), tone).ravel(), 0.0)
            for amplitudes in 1.0 + 0.2 * rng.random((3, passes // repeats))
        ]
        for repeats in (1, 16)
    )
    assert (
        chaos.estimate_rms_scatter(correlated, passes)[0]
        > 2.5 * chaos.estimate_rms_scatter(independent, passes)[0]
    )


def test_line_difference_is_at_least_the_root_sum_of_squares() -> None:
    reference, errors = np.ones(4, dtype=complex), np.array([0.1, -0.1, 0.1, -0.1])
    assert comparison.line_difference(reference + errors, reference) == pytest.approx(0.2)
    assert comparison.line_difference(reference + np.abs(errors), reference) == pytest.approx(0.4)


@pytest.mark.parametrize(("signal", "share"), [("fine_velocity", 0.5), ("recorded_velocity", 1.0)])
def test_rms_change_is_that_of_the_record_or_half_of_the_wide_band(signal: str, share: float) -> None:
    test_case = rollers(method="verlet")
    fine, recorded = np.random.default_rng(1).normal(
        size=(2, 4 * time_grid.make_grid(test_case).fine_per_pass + 1)
    )
    rows = recorded[np.newaxis]
    lines, row_rounding = np.ones((1, 4), dtype=complex), (np.zeros(1), np.zeros(0))
    signals = comparison.RunSignals(fine, recorded, rows, rows[:0], lines, 1.0, NO_ROUNDING, row_rounding)
    changed = signals._replace(**{signal: 1.02 * getattr(signals, signal)})
    with mock.patch.object(step_check, "run_pilot", side_effect=[changed, signals, signals]):
        assert step_check.check_step(set_up(test_case, 1.0)).rms == pytest.approx(share * 0.02)


def test_recorded_channels_are_compared_without_refusing_the_step() -> None:
    test_case = choice.resolve(rollers(record=["ring.velocity", "roller.1.outer_force", "roller.3.radial"]))
    short, passes = pilot.make_pilot(test_case)
    signals = step_check.run_pilot(set_up(short), passes)
    assert signals.low_passed.shape == (3 + 1, len(signals.recorded_velocity))
    assert len(signals.raw_values) == 1
    assert np.array_equal(signals.low_passed[1], signals.recorded_velocity)
    amplified = [
        signals._replace(
            raw_values=signals.raw_values.mean() + 1.03 * (signals.raw_values - signals.raw_values.mean())
        )
    ]
    for row in range(4):
        factors = np.where(np.arange(4) == row, 1.03, 1.0)[:, np.newaxis]
        amplified.append(signals._replace(low_passed=signals.low_passed * factors))
    for changed in amplified:
        with mock.patch.object(step_check, "run_pilot", side_effect=[changed, signals, signals]):
            result = step_check.check_step(set_up(test_case, 1.0))
        assert result.record == pytest.approx(0.03, rel=0.02)
        assert result.rms == 0.0
        assert result.is_accepted


def test_step_errors_of_a_chaotic_motion_are_those_that_its_scatter_resolves() -> None:
    """Line and force of two chaotic motions differ at any step; 2.5 times 2 % of scatter hide 1 % of the step."""
    check = StepCheck(3.6, 0.01, 0.5, 0.03, bounds=step_check.COARSE_BOUNDS, chaotic=True, noise=0.02)
    errors = check.step_errors
    assert math.isnan(errors["line"])
    assert math.isnan(errors["force"])
    assert errors["rms"] == pytest.approx(2.5 * 0.02)
    assert errors["record"] == pytest.approx(2.5 * 0.03 + 5e-4)
    assert check.is_accepted  # within the scatter
    assert not replace(check, rms=0.06).is_accepted
    regular = replace(check, chaotic=False).step_errors
    assert regular["line"] == pytest.approx(2.5 * 3.6 + 5e-4)
    assert regular["rms"] == pytest.approx(2.5 * 0.5 * 3.6 + 5e-4)


def test_raw_value_change_detects_a_shifted_impact() -> None:
    """An impact that is shifted by one sample leaves the RMS unchanged."""
    impact, shifted = np.zeros((2, 101))
    impact[50], shifted[51] = 1.0, 1.0
    assert np.std(impact) == pytest.approx(np.std(shifted))
    assert comparison.raw_value_change(impact, shifted) == pytest.approx(0.5 * 2.0**0.5, rel=0.02)
    assert comparison.raw_value_change(1.01 * shifted, shifted) == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize(
    ("width", "load", "speed"), [("1.29 mm", "595 N", "2253 rpm"), ("1.17 mm", "154 N", "1786 rpm")]
)
def test_record_error_bounds_the_rms_of_raw_values(width: str, load: str, speed: str) -> None:
    """This error is up to twelve times that of the low-passed velocity or of the fine samples."""
    damping = {"law": "hunt-crossley", "chi": "50 s/m"}
    defect = {"shape": "circular", "length": "12 mm", "width": width, "depth": "0.05 mm"}
    fields = {"contact": {"damping": damping}, "antialias": False, "settle": "auto"}
    test_case = case(
        model="rollers", load=load, speed=speed, defect=defect, clearance="0 um", duration="0.3 s", **fields
    )
    run = simulate(test_case)
    fine_fields = {"step": float(run.info["step_s"]) / 8.0, "step_check": False, "method": run.info["method"]}
    reference = simulate(test_case.model_copy(update=fine_fields)).features["acceleration.rms"]
    error = abs(run.features["acceleration.rms"] / reference - 1.0)
    assert 1e-4 < error <= run.features["step_error.record"] < 0.01


def test_change_of_a_negligible_line_is_relative_to_the_rms() -> None:
    """A healthy bearing has a negligible line, whose relative change must not fail the run."""
    result = step_check.check_step(set_up(choice.resolve(case(model="rollers")), 1.0))
    assert result.line < 1e-3


def test_step_check_may_exceed_the_cpu_limit_of_a_run() -> None:
    """The finer pilot of a strict check takes more than twice the CPU time of its run."""
    test_case = choice.resolve(rollers(step_check="strict"))
    cpu_time = (test_case.settle_s + test_case.duration) * pricing.cpu_per_second(
        test_case, time_grid.make_grid(test_case).step
    )
    stopped_pilot = mock.patch.object(step_check, "run_pilot", side_effect=InterruptedError)
    with mock.patch.object(time_grid, "MAX_CPU", 1.3 * cpu_time), stopped_pilot, pytest.raises(InterruptedError):
        step_check.check_step(set_up(test_case, 1.0))  # both setups are accepted; the first pilot is started


def test_half_the_step_has_a_tenth_of_the_automatic_tolerance() -> None:
    """An adaptive method whose automatic tolerance follows the step."""
    test_case = rollers(method="rodas")
    h = time_grid.make_grid(test_case).step
    normal, fine = (assemble.method(test_case, h, part) for part in (1.0, 0.5))
    assert fine.rtol == pytest.approx(0.1 * normal.rtol)
    assert fine.atol_q == pytest.approx(0.1 * normal.atol_q)


def test_small_line_must_be_accurate_to_1_percent_too() -> None:
    """A line is a few hundredths of the RMS; only changes under 1e-5 of the RMS are neglected."""
    assert QUIET_LINE * STEP_ACCURACY <= 1e-5


def test_given_tolerance_is_checked_with_a_tenth_of_it() -> None:
    test_case = rollers(method="rodas", tolerance="0.1 %")
    assert test_case.checks_step
    assert assemble.method(test_case, 1e-6, 0.5).rtol == 1e-3
    assert assemble.method(step_check.with_finer_tolerance(test_case), 1e-6).rtol == pytest.approx(1e-4)


@pytest.mark.parametrize(
    ("fields", "fraction"),
    [
        ({"step": "5 us", "sampling": "204800 Hz"}, 1.0),  # a fine sample is shorter than the step
        ({"step": "20 us"}, 1.0),  # a fine sample is little longer than the step
        ({"sampling": "102400 Hz"}, 1.0),
        ({}, 2.0),
    ],
)
def test_shorter_step_is_about_root_five_times_shorter(fields: dict, fraction: float) -> None:
    """The ratio is above 2 for any sampling, so no run is compared with itself or with one of half the step."""
    coarse = set_up(case(model="ring", method="verlet", **fields), fraction)
    fine = set_up(coarse.case, step_check.finer_fraction(coarse))
    assert 2.0 < coarse.grid.step / fine.grid.step <= 3.0
    assert fine.grid.decimation == max(
        2 * coarse.grid.decimation + 1, round(math.sqrt(5.0) * coarse.grid.decimation)
    )


def test_tolerance_is_shortened_like_the_step_whatever_the_grid() -> None:
    """The fraction of an adaptive method scales its tolerance; the grid remains that of the automatic step."""
    coarse = set_up(case(model="rollers", method="dop853"), 0.5)
    decimation = coarse.grid.decimation
    ratio = decimation / max(2 * decimation + 1, round(math.sqrt(5.0) * decimation))
    assert step_check.finer_fraction(coarse) == pytest.approx(0.5 * ratio)


def test_given_step_is_checked_even_if_a_fine_sample_is_shorter() -> None:
    """A step of 1.2 us (5 us are given) changes the RMS by 0.06 %, compared with one of 0.1 us."""
    scene = {"model": "ring", "method": "verlet", "sampling": "204800 Hz", "defect": SLOT}
    fields = scene | {"duration": "30 ms", "settle": "20 ms"}
    checked = simulate(case(step="5 us", **fields | {"step_check": True})).features
    reference = simulate(case(step="0.1 us", **fields)).features
    error = abs(checked["velocity.rms"] / reference["velocity.rms"] - 1.0)
    assert 3e-4 < error <= checked["step_error.rms"]


def test_step_check_detects_the_error_of_a_second_defect() -> None:
    """With half the step, both cusps could stay at the same fraction of a step, and the error would not show."""
    defects = [
        {
            "race": "outer",
            "shape": "rectangular",
            "length": "12 mm",
            "depth": "50 um",
            "width": width,
            "angle": angle,
        }
        for width, angle in (("0.3 mm", "3.0 rad"), ("0.12 mm", "0.01001 rad"))
    ]
    fields = {"speed": "12000 rpm", "load": "300 N", "duration": "20 ms", "settle": "6 ms"}
    test_case = case(model="rollers", defects=defects, method="verlet", **fields)
    check = step_check.check_step(set_up(test_case, 1.0))
    unchecked_case = test_case.model_copy(update={"step_check": False})
    reference = simulate(unchecked_case.model_copy(update={"method": "dop853", "tolerance": 1e-6}))
    result = simulate(unchecked_case)
    error = abs(result.features["velocity.rms"] / reference.features["velocity.rms"] - 1.0)
    assert error > 0.005
    assert check.rms > 0.25 * error
