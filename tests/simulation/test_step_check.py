"""Step check on an orbit or a pilot, and refinement or refusal of a step that is not accurate enough."""

import dataclasses
import math
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.config.names import STEP_ACCURACY
from bearingsim.simulation import choice, comparison, pilot, pricing, refinement, step_check, time_grid
from bearingsim.simulation.accuracy import QUIET_LINE
from bearingsim.simulation.choice import STEP_FRACTIONS
from bearingsim.simulation.integration import Run, integrate
from bearingsim.simulation.run_setup import TooChaotic, set_up
from bearingsim.simulation.simulate import SimulationError, simulate
from bearingsim.simulation.step_check import StepCheck
from tests.scenes.short_cases import RATE, SLOT, case

LIGHT = {"contact": {"damping": {"chi": "1 s/m"}}}


def rollers(**fields: Any) -> Any:
    return case(model="rollers", defect=SLOT, **fields)


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
    assert StepCheck(line=0.5, rms=0.003, chaotic=True).holds
    assert not StepCheck(line=0.5, rms=0.003, chaotic=False).holds
    assert not StepCheck(line=0.0, rms=0.02, chaotic=True).holds
    assert StepCheck(line=0.0, rms=0.02, chaotic=True, noise=0.01).holds  # within the scatter due to chaos
    assert not step_check.UNCHECKED.holds


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
    assert pilot.longer_duration(lightly_damped) > lightly_damped.duration


def test_confidence_factor_is_larger_if_a_single_pass_scatters() -> None:
    rng = np.random.default_rng(5)
    periodic = [np.tile(np.sin(np.linspace(0.0, 6.0, 100)), 21)[:2001] for _ in range(3)]
    noise = [rng.normal(0.0, 0.3, 2001) for _ in range(3)]
    first_pass = np.arange(2001) < 100
    all_passes, single_pass = (
        step_check.scatter([a + b * weight for a, b in zip(periodic, noise, strict=True)], 20)
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
    assert step_check.scatter(correlated, passes)[0] > 2.5 * step_check.scatter(independent, passes)[0]


def test_line_change_is_at_least_the_root_sum_of_squares() -> None:
    reference, errors = np.ones(4, dtype=complex), np.array([0.1, -0.1, 0.1, -0.1])
    assert comparison.line_change(reference + errors, reference) == pytest.approx(0.2)
    assert comparison.line_change(reference + np.abs(errors), reference) == pytest.approx(0.4)


@pytest.mark.parametrize(("signal", "share"), [("fine_velocity", 0.5), ("recorded_velocity", 1.0)])
def test_rms_change_is_that_of_the_record_or_half_of_the_wide_band(signal: str, share: float) -> None:
    test_case = rollers(method="verlet")
    fine, recorded = np.random.default_rng(1).normal(
        size=(2, 4 * time_grid.make_grid(test_case).fine_per_pass + 1)
    )
    rows = recorded[np.newaxis]
    signals = comparison.RunSignals(fine, recorded, rows, rows[:0], np.ones((1, 4), dtype=complex), 1.0)
    changed = signals._replace(**{signal: 1.02 * getattr(signals, signal)})
    with mock.patch.object(step_check, "run_pilot", side_effect=[changed, signals, signals]):
        assert step_check.check_step(set_up(test_case, 1.0)).rms == pytest.approx(share * 0.02)


def test_recorded_channels_are_compared_without_refusing_the_step() -> None:
    test_case = choice.resolve(rollers(record=["ring.velocity", "roller.1.outer_force", "roller.3.radial"]))
    short, passes = pilot.pilot(test_case)
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
        assert result.holds


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


@pytest.mark.parametrize("model", ["ring", "rollers"])
@pytest.mark.parametrize("clearance", ["0 um", "10 um"])
def test_orbit_and_pilot_checks_agree(model: str, clearance: str) -> None:
    """Changes of line, RMS and recorded channels agree within 10 %."""
    defect = SLOT | {"depth": "5 um", "angle": "20 deg"}
    test_case = case(model=model, defect=defect, clearance=clearance, settle=0.05, record=["ring.acceleration"])
    setup = set_up(choice.resolve(test_case))
    raw = integrate(setup)
    assert raw.repetition.period == 1
    on_orbit, on_pilot = step_check.check_step(setup, raw), step_check.check_step(setup)
    assert on_orbit.line == pytest.approx(on_pilot.line, rel=0.1, abs=1e-5)
    assert on_orbit.rms == pytest.approx(on_pilot.rms, rel=0.1, abs=1e-5)
    assert on_orbit.record == pytest.approx(on_pilot.record, rel=0.1, abs=1e-5)
    assert not on_orbit.chaotic


SLOW = {"rig": {"ring_mass": "20 kg"}, "settle": "0 s", "duration": "0.6 s", "method": "verlet"}


@pytest.mark.parametrize("overrides", [{"antialias": False}, {"record": ["roller.1.outer_force"]}])
def test_raw_values_of_a_period_are_compared_once_both_runs_are_steady(overrides: dict[str, Any]) -> None:
    """The run settles in 0.37 s, the finer run started at its end does not: its RMS would differ by 1 %."""
    setup = set_up(choice.resolve(case(model="rollers", defect=SLOT, **SLOW, **overrides)))
    raw = integrate(setup)
    assert raw.repetition.period == 1
    assert raw.repetition.computed > 50
    check = step_check.check_on_orbit((setup, raw), step_check.finer_orbit(setup, raw))
    assert check is not None
    assert check.rms < 1e-3
    assert check.record < 2e-3


def test_raw_values_that_end_before_a_run_is_steady_are_checked_on_a_pilot() -> None:
    test_case = choice.resolve(case(model="rollers", defect=SLOT, **SLOW, record=["roller.1.outer_force"]))
    setup = set_up(test_case)
    raw = integrate(setup)
    finer = step_check.finer_orbit(setup, raw)
    for end, is_checked in ((0.36, False), (0.38, True)):
        with mock.patch.object(step_check, "run_time", return_value=end):
            assert (step_check.check_on_orbit((setup, raw), finer) is not None) == is_checked


def test_a_finer_run_ends_after_two_passes_if_the_coarse_one_shows_how_fast_it_settles() -> None:
    """Its second pass is as close to the orbit as after a further search, to the limit of 1e-5."""
    coarse = set_up(choice.resolve(rollers()), 2.0)
    raw = integrate(coarse, closeness=step_check.ORBIT_CLOSENESS)
    assert 0.0 < raw.repetition.contraction < 1e-3
    fine, short = step_check.finer_orbit(coarse, raw)
    assert short.repetition.computed == 2
    assert short.repetition.contraction == raw.repetition.contraction
    long = integrate(fine, start=step_check.rewound_state(coarse, raw))
    assert long.repetition.computed > 2
    changes = comparison.compare(*(comparison.orbit_signals(fine, run, 0.0) for run in (short, long)))
    assert max(changes) < 1e-5
    slow = dataclasses.replace(raw, repetition=raw.repetition._replace(contraction=0.9))
    assert step_check.finer_orbit(coarse, slow)[1].repetition.computed > 2


def test_the_search_for_a_period_ends_as_close_as_a_finer_run() -> None:
    coarse = set_up(choice.resolve(rollers()), 2.0)
    search = refinement._search(coarse)
    assert search.period == 1
    assert search.passes < integrate(coarse).repetition.computed


def test_motion_that_converges_at_one_step_is_not_perturbed_at_the_next() -> None:
    test_case = choice.resolve(case(model="ring", defect=SLOT | {"race": "inner"}, duration="0.3 s"))
    pilot_run = pilot.pilot(test_case)
    first = step_check.check_on_pilot(test_case, 2.0, *pilot_run)
    assert first.finer.converges
    fraction, real_pilot = first.finer.setup.step_fraction, step_check.run_pilot
    for converges in (True, False):
        with (
            mock.patch.object(step_check, "run_pilot", side_effect=real_pilot) as pilots,
            mock.patch.object(step_check, "MIN_DIVERGENCE", 0.0),
        ):
            previous = first.finer._replace(converges=converges)
            second = step_check.check_on_pilot(test_case, fraction, *pilot_run, previous)
        perturbed = [call for call in pilots.call_args_list if call.kwargs.get("perturbation")]
        assert len(perturbed) == (not converges)
        assert second.finer.converges


def test_a_run_ends_in_phase_with_its_period() -> None:
    """A finer run started there then meets the record's instants in the same pass of the period."""
    setup = set_up(choice.resolve(rollers()))
    for period, passes in ((1, 5), (2, 6), (3, 6), (4, 8)):
        periods = [(0, math.nan)] * 4 + [(period, 0.0)]
        with mock.patch("bearingsim.simulation.integration.Search.add_pass", side_effect=periods):
            assert integrate(setup).repetition[:3] == (passes, period, 0.0)


@pytest.mark.parametrize(("computed", "finer"), [(4, 32), (60, 120), (1342, 600)])
def test_a_long_finer_run_costs_no_more_than_the_run(computed: int, finer: int) -> None:
    """The limit of passes allows for steps shorter by sqrt(5)."""
    raw = integrate(set_up(choice.resolve(rollers())))
    raw = dataclasses.replace(raw, repetition=raw.repetition._replace(computed=computed))
    assert step_check.max_finer_passes(raw) == finer


@pytest.mark.parametrize("roller", [1, 7])
def test_each_roller_is_compared_at_the_same_position(roller: int) -> None:
    """Two runs that end after different numbers of passes have the roller at different positions."""
    defect = SLOT | {"depth": "5 um", "angle": "20 deg"}
    record = [f"roller.{roller}.outer_force"]
    test_case = case(model="rollers", defect=defect, clearance="10 um", record=record, duration=13 / RATE)
    result = simulate(test_case)
    fine_fields = {"step": float(result.info["step_s"]) / 5**0.5, "step_check": False}
    fine_result = simulate(test_case.model_copy(update=fine_fields))
    coarse_rms, fine_rms = (np.std(run.series[record[0]]) for run in (result, fine_result))
    assert result.features["step_error.record"] < 0.01
    assert abs(coarse_rms / fine_rms - 1.0) <= result.features["step_error.record"] + 1e-4


def test_pilot_signals_include_wide_band_and_recorded_velocity() -> None:
    """The low-pass of the record removes most of this velocity; changes of both RMS values limit the step."""
    test_case = choice.resolve(rollers(sampling="1000 Hz", duration="0.3 s"))
    short, passes = pilot.pilot(test_case)
    signals = step_check.run_pilot(set_up(short), passes)
    recorded_rms = simulate(short.model_copy(update={"step_check": False})).features["velocity.rms"]
    assert np.std(signals.recorded_velocity) == pytest.approx(recorded_rms, rel=0.05)
    assert np.std(signals.fine_velocity) > 1.5 * recorded_rms


def test_too_long_automatic_step_is_refined_until_accurate() -> None:
    """Eight steps in a crossing at 12 000 rpm are stable, but the error is 5 %. Refined by factors of 2.24."""
    test_case = case(model="rollers", method="verlet", speed="12000 rpm", defect=SLOT | {"width": "0.15 mm"})
    long_step = choice.limits(test_case).crossing / 8.5
    check = check_with_step(test_case, long_step, 1.0)
    assert check.error > STEP_ACCURACY
    with mock.patch.object(time_grid, "requested_step", return_value=long_step):
        result = simulate(test_case)
    assert float(result.info["step_part"]) < 0.5
    assert max(result.features["step_error.line"], result.features["step_error.rms"]) <= STEP_ACCURACY


def check_with_step(test_case: Any, step: float, step_fraction: float) -> StepCheck:
    """Check a case whose automatic step is replaced by ``step`` (s)."""
    with mock.patch.object(time_grid, "requested_step", return_value=step):
        return step_check.check_step(set_up(test_case, step_fraction))


def patched_orbit_check(check: StepCheck) -> Any:
    """Return a patch that replaces the result of a comparison of two orbits."""
    return mock.patch.object(refinement, "check_on_orbit", return_value=check)


def pilot_check_returning(check: StepCheck) -> Any:
    """Return a comparison of two pilots whose check is replaced; the finer pilot is that of the real one."""
    real_check = step_check.check_on_pilot
    return lambda *args: real_check(*args)._replace(check=check)


def step_fractions(calls: list[Any]) -> list[float]:
    """Return the fractions of the automatic step of the runs compared on orbits, in descending order."""
    return [calls[0].args[0][0].step_fraction, *(call.args[1][0].step_fraction for call in calls)]


def test_job_fails_with_a_reason_if_no_step_is_accurate() -> None:
    inaccurate = StepCheck(line=0.2, rms=0.05, chaotic=False)
    with patched_orbit_check(inaccurate) as orbit_checks, pytest.raises(SimulationError) as caught:
        simulate(case(method="verlet"))
    fractions = step_fractions(orbit_checks.call_args_list)
    assert fractions[0] == refinement.INITIAL_FACTOR
    assert fractions[-2] > STEP_FRACTIONS[-1] >= fractions[-1]
    assert (
        "verlet is not within 1%: a shorter step changes the amplitude at the defect frequency by 20 %"
        in caught.value.reason
    )
    assert "step_check: false" in caught.value.advice


@pytest.mark.parametrize("overrides", [{}, {"defect": SLOT | {"race": "inner"}}], ids=["orbits", "pilots"])
def test_each_step_is_computed_once_and_the_last_is_the_result(overrides: dict[str, Any]) -> None:
    """After two inaccurate steps: four orbits, of which the last is the record, or four pilots."""
    small, large = StepCheck(line=1e-3, rms=4.5e-3), StepCheck(line=0.05, rms=2e-3)
    checks, fractions = iter([large, large, small]), []
    real_begin, real_check = Run.begin, step_check.check_on_pilot

    def recorded_begin(setup: Any, *args: Any, **options: Any) -> Run:
        fractions.append(setup.step_fraction)
        return real_begin(setup, *args, **options)

    with (
        mock.patch.object(refinement, "check_on_orbit", side_effect=checks),
        mock.patch.object(refinement, "check_on_pilot", lambda *a: real_check(*a)._replace(check=next(checks))),
        mock.patch.object(Run, "begin", recorded_begin),
    ):
        record = simulate(case(model="rollers", method="verlet", **overrides))
    assert fractions[:4] == sorted(set(fractions), reverse=True)
    assert len(fractions) == 4
    assert np.allclose(np.divide(fractions[1:], fractions[:-1]), 5**-0.5, rtol=0.2)
    assert record.info["step_part"] == fractions[-1]
    assert float(record.info["steps_taken"]) > 1.5 * float(record.info["steps"])
    assert record.features["step_error.line"] == pytest.approx(2.0 * 0.5 * 4.5e-3 + 5e-4)
    assert record.features["step_error.rms"] == pytest.approx(2.0 * 4.5e-3 + 5e-4)


@pytest.mark.parametrize(
    "overrides",
    [
        {},
        {"until": "1 %", "duration": "1.5 s", "record": []},
        {"method": "dormand-prince"},
        {"defect": SLOT, **LIGHT},
    ],
    ids=["full", "until", "adaptive", "searched"],
)
def test_a_run_continues_its_pilot(overrides: dict[str, Any]) -> None:
    """The record is that of a run from rest, and the steps of the pilot are taken once."""
    test_case = case(**{"model": "rollers", "defect": SLOT | {"race": "inner"}} | overrides)
    record = simulate(test_case)
    with mock.patch.object(refinement, "begins_with_pilot", return_value=False):
        from_rest = simulate(test_case)
    assert record.features.keys() == from_rest.features.keys()
    assert np.array_equal([*record.features.values()], [*from_rest.features.values()], equal_nan=True)
    assert record.info["passes_computed"] == from_rest.info["passes_computed"]
    saved_steps = float(from_rest.info["steps_taken"]) - float(record.info["steps_taken"])
    steps_per_pass = float(record.info["steps"]) / float(record.info["passes_computed"])
    assert saved_steps > 3.0 * steps_per_pass


@pytest.mark.parametrize(
    "fields",
    [
        {"defect": SLOT, "rig": {"ring_mass": "100 kg"}, "settle": "0.1 s"},  # slow modes
        {"record": ["roller.1.outer_force"]},
        {"model": "planar", "ramp": {"to": "3600 rpm", "time": "50 ms"}},
    ],
)
def test_a_run_that_does_not_begin_with_its_pilot_is_computed_from_rest(fields: dict[str, Any]) -> None:
    base = {"model": "rollers", "method": "verlet", "defect": SLOT | {"race": "inner"}}
    assert pricing.begins_with_pilot(choice.resolve(case(**base)))
    assert not pricing.begins_with_pilot(choice.resolve(case(**base | fields)))


def test_the_price_of_a_check_leaves_out_the_beginning_of_the_run() -> None:
    """A run that records contact forces does not begin with its pilot, which is computed in addition."""
    fields = {"model": "rollers", "method": "verlet", "defect": SLOT | {"race": "inner"}}
    continued, separate = (
        choice.resolve(case(**fields, record=record)) for record in (["ring.velocity"], ["roller.1.outer_force"])
    )
    assert pilot.pilot(continued)[1] == pilot.pilot(separate)[1]
    pilot_share = pricing.check_cost(separate) - pricing.check_cost(continued)
    assert pricing.check_cost(continued) == pytest.approx(math.sqrt(5.0) * pilot_share)
    run = simulate(continued).info
    computed_share = float(run["steps_taken"]) / float(run["steps"]) - 1.0
    assert 0.0 < computed_share < pricing.check_cost(continued)


@pytest.mark.parametrize("change", [3.9e-3, 4.1e-3])
def test_non_periodic_run_uses_the_coarse_step_if_its_error_bound_holds(change: float) -> None:
    light_damping = {"contact": {"damping": "kraemer"}}  # stability does not bound its step
    test_case = Case.model_validate(
        dict(case(model="rollers", method="verlet", defect=SLOT | {"race": "inner"})) | light_damping
    )
    small = StepCheck(line=change, rms=1e-4)
    with mock.patch.object(refinement, "check_on_pilot", side_effect=pilot_check_returning(small)):
        record = simulate(test_case)
    is_coarse = 2.5 * change < 0.01
    assert (record.info["step_part"] == refinement.INITIAL_FACTOR) == is_coarse
    factor = 2.5 if is_coarse else 2.0
    assert record.features["step_error.line"] == pytest.approx(factor * change + 5e-4)


@pytest.mark.parametrize("settle", ["auto", "0 s"])
def test_record_with_a_transient_is_computed_from_rest(settle: str) -> None:
    """The finer orbit contains no transient."""
    test_case = case(model="rollers", method="verlet", defect=SLOT, settle=settle)
    result = refinement.refine_step(choice.resolve(test_case), 1.0)
    assert (result.raw is None) == (settle == "0 s")
    record = simulate(test_case)
    fields = {"step": record.info["step_s"], "step_check": False}
    unchecked = simulate(test_case.model_copy(update=fields))
    for name in ("velocity@BPFO", "velocity.rms", "acceleration.kurtosis"):
        assert record.features[name] == pytest.approx(unchecked.features[name], rel=1e-5), name


def test_inaccurate_force_is_reported_without_failing_the_job() -> None:
    """The step is refined to the shortest one, which is used."""
    result = StepCheck(line=1e-4, rms=1e-4, force=0.05)
    with patched_orbit_check(result), mock.patch.object(step_check, "check_step", return_value=result):
        record = simulate(case(method="verlet"))
        given_step = simulate(case(method="verlet", step=2e-7))
    assert float(record.info["step_part"]) <= STEP_FRACTIONS[-1]
    assert record.features["step_error.force"] == pytest.approx(0.1005)
    assert given_step.features["step_error.force"] == pytest.approx(0.12501)


def test_with_auto_other_methods_are_tried_before_the_job_fails() -> None:
    with patched_orbit_check(StepCheck(line=0.2, rms=0.05)):
        result = simulate(rollers())
    assert result.info["method"] != choice.choice(rollers()).method


def test_change_of_a_negligible_line_is_relative_to_the_rms() -> None:
    """A healthy bearing has a negligible line, whose relative change must not fail the run."""
    result = step_check.check_step(set_up(choice.resolve(case(model="rollers")), 1.0))
    assert result.line < 1e-3


def test_pilot_is_short_but_covers_turns_of_defects_through_the_load_zone() -> None:
    fields = {"duration": "4 s", "settle": "0.1 s"}
    run_passes = 4.1 * RATE
    for race, min_passes in (("outer", 0.0), ("inner", RATE / 30.0), ("roller", 13.0)):
        short, passes = pilot.pilot(choice.resolve(case(defect=SLOT | {"race": race}, **fields)))
        assert passes >= max(pilot.MIN_PASSES, min_passes)
        assert 3.0 * (passes + pilot.SKIPPED_PASSES) < 0.25 * run_passes
        assert short.duration * RATE == pytest.approx(passes + 0.5)


def test_pilot_of_a_short_record_covers_the_whole_run() -> None:
    short, passes = pilot.pilot(choice.resolve(case(duration="8 ms", settle="0 s")))
    assert passes == 1
    assert short.settle_s + short.duration <= 3.0 / RATE
    assert simulate(case(duration="8 ms", settle="0 s")).features["step_error.rms"] < 0.01


def pilot_lengths(**fields: Any) -> tuple[float, int]:
    """Return the settling time (s) of a pilot of `rollers` and its number of compared ball passes."""
    short, passes = pilot.pilot(choice.resolve(rollers(duration="0.4 s", **fields)))
    return short.settle_s, passes


def test_the_pilot_of_a_lightly_damped_bearing_settles_as_the_run_does() -> None:
    """From rest, two random scenes seemed periodic: they became chaotic after settling."""
    one_pass = pytest.approx(1.0 / RATE, rel=1e-3)
    assert pilot_lengths(**LIGHT) == (pytest.approx(30e-3), 5)
    assert pilot_lengths() == (one_pass, 5)
    assert pilot_lengths(settle="0 s", **LIGHT) == (one_pass, 4)


def test_strict_check_covers_the_whole_run() -> None:
    """Pilots of random scenes diverged only after two thirds of their records."""
    for damping in (LIGHT, {}):
        assert pilot_lengths(step_check="strict", **damping) == (pytest.approx(30e-3), int(0.4 * RATE))
    assert pilot.pilot(choice.resolve(rollers(step_check="strict", duration="1 s", settle="50 ms")))[1] == 159


def test_step_check_may_exceed_the_cpu_limit_of_a_run() -> None:
    """The finer pilot of a strict check takes more than twice the CPU time of its run."""
    test_case = choice.resolve(rollers(step_check="strict"))
    cpu_time = (test_case.settle_s + test_case.duration) * pricing.cpu_per_second(
        test_case, time_grid.make_grid(test_case).step
    )
    stopped_pilot = mock.patch.object(step_check, "run_pilot", side_effect=InterruptedError)
    with mock.patch.object(time_grid, "MAX_CPU", 1.3 * cpu_time), stopped_pilot, pytest.raises(InterruptedError):
        step_check.check_step(set_up(test_case, 1.0))  # both setups are accepted; the first pilot is started


def test_diverging_pilots_without_visible_chaos_are_repeated_longer() -> None:
    """In six ball passes of this scene the perturbation has not begun to grow. In a similar one the RMS error was
    3 %, the reported one 0.06 %.
    """
    damping = {"law": "kraemer", "beta": 2.2166e-6}
    stiffness = {"law": "constant", "coefficient": 1.50793 * 8.06e4 * 12.0 ** (8.0 / 9.0), "exponent": 10.0 / 9.0}
    test_case = choice.resolve(
        case(
            model="rollers",
            load=29.0,
            clearance=23.4516e-6,
            speed="4541.38 rpm",
            contact={"stiffness": stiffness, "damping": damping},
            defect={"shape": "circular", "length": "12 mm", "width": 0.942375e-3, "depth": 587.092e-6},
            duration="0.15 s",
            settle="50 ms",
        )
    )
    check, is_doubtful, _ = step_check.check_on_pilot(test_case, 1.0, *pilot.pilot(test_case))
    assert is_doubtful
    assert check.holds
    assert not check.chaotic
    assert step_check.check_step(set_up(test_case, 1.0)).chaotic


def test_converging_pilots_are_not_repeated_longer() -> None:
    """In `ring` over an inner slot the step changes velocities by 5 %, and a perturbation decays to 1e-14."""
    test_case = choice.resolve(case(model="ring", defect=SLOT | {"race": "inner"}, duration="0.3 s"))
    check, is_doubtful, _ = step_check.check_on_pilot(test_case, 2.0, *pilot.pilot(test_case))
    assert not check.chaotic
    assert not is_doubtful
    assert pilot.pilot(test_case)[1] < pilot.pilot(test_case, step_check.SECOND_PILOT)[1]


def test_friction_does_not_count_as_roller_damping() -> None:
    """In `planar` the cage limits the step, but the damping ratio is that of a roller between the races."""
    stiff_pockets = {"cage": {"pocket_stiffness": "1e10 N/m"}}
    for fields in ({}, {"speed": "12000 rpm", "load": "20 N"}):
        rollers_ratio, planar_ratio, stiff_pocket_ratio = (
            choice.limits(case(model=model, defect=SLOT, **LIGHT, **fields, **cage)).damping_ratio
            for model, cage in (("rollers", {}), ("planar", {}), ("planar", stiff_pockets))
        )
        assert planar_ratio == stiff_pocket_ratio == pytest.approx(rollers_ratio, rel=1e-3)
        assert rollers_ratio < 0.05


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


def test_pilot_of_a_ramp_runs_at_the_highest_speed() -> None:
    """At the initial low speed it would cover hardly a ball pass."""
    test_case = choice.resolve(case(ramp={"to": "18000 rpm", "time": "1 s"}, model="planar", duration="2 s"))
    short, passes = pilot.pilot(test_case)
    assert short.ramp is None
    assert time_grid.make_grid(short).rate == time_grid.make_grid(test_case).rate == pytest.approx(10.0 * RATE)
    assert passes == pytest.approx(pilot.PILOT_FRACTION * 2.03 * 10.0 * RATE, abs=1.0)


def test_given_tolerance_is_checked_with_a_tenth_of_it() -> None:
    test_case = rollers(method="rodas", tolerance="0.1 %")
    assert test_case.checks_step
    assert assemble.method(test_case, 1e-6, 0.5).rtol == 1e-3
    assert assemble.method(step_check.with_finer_tolerance(test_case), 1e-6).rtol == pytest.approx(1e-4)


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


def test_a_run_as_short_as_its_pilot_is_computed_once_at_each_step() -> None:
    """The features are those of a run whose pilots are computed separately."""
    damping = {"contact": {"damping": {"chi": "5 s/m"}}}  # too weak to become periodic
    short = case(defect=SLOT, duration="10 ms", settle="10 ms", record=[], **damping)
    shared = simulate(short)
    with mock.patch.object(refinement, "begins_with_pilot", return_value=False):
        separate = simulate(short)
    np.testing.assert_array_equal(list(shared.features.values()), list(separate.features.values()))
    assert int(shared.info["steps_taken"]) < 0.75 * int(separate.info["steps_taken"])


def test_a_pilot_continues_a_search_for_a_period() -> None:
    """Its signals are those of a pilot computed separately, whether the search is longer or shorter."""
    coarse = set_up(choice.resolve(rollers(record=["roller.2.radial"], **LIGHT)), 1.0)
    pilot_case, passes = pilot.pilot(coarse.case)
    pilot_setup = set_up(pilot_case.model_copy(update={"periodic": False}), 1.0)
    computed = comparison.pilot_signals(pilot_setup, integrate(pilot_setup), passes)
    for searched_passes in (pilot_setup.grid.passes - 3, pilot_setup.grid.passes + 3):
        runs = refinement.BegunRuns(coarse.case)
        run = runs.runs[1.0] = Run.begin(coarse)
        run.advance(searched_passes)
        raw = runs.beginning(pilot_setup)
        assert raw is not None
        assert run.passes == max(searched_passes, pilot_setup.grid.passes) < coarse.grid.passes
        signals = comparison.pilot_signals(pilot_setup, raw, passes)
        for quantity, value, expected in zip(computed._fields, signals, computed, strict=True):
            np.testing.assert_array_equal(value, expected, quantity)


def test_a_run_that_is_periodic_within_its_pilot_is_not_the_pilot() -> None:
    """The differences of repeated passes, 1e-7, would exceed those by the perturbation of a pilot."""
    coarse = set_up(choice.resolve(case(defect=SLOT)), 1.0)
    pilot_case, _ = pilot.pilot(coarse.case)
    pilot_setup = set_up(pilot_case.model_copy(update={"periodic": False}), 1.0)
    runs = refinement.BegunRuns(coarse.case)
    assert runs.beginning(pilot_setup) is None
    assert 0 < runs.runs[1.0].passes < pilot_setup.grid.passes
    assert integrate(coarse, begun=runs.runs[1.0]).repetition == integrate(coarse).repetition
