"""Refinement of an automatic step on orbits and on pilots, and the run that results."""

import dataclasses
import math
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.config.names import STEP_ACCURACY
from bearingsim.simulation import choice, comparison, refinement, step_check, time_grid
from bearingsim.simulation.choice import STEP_FRACTIONS
from bearingsim.simulation.integration import Run, integrate
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import SimulationError, simulate
from bearingsim.simulation.step_check import StepCheck
from tests.scenes.short_cases import RATE, SLOT, case
from tests.scenes.step_checks import patched_orbit_check, pilot_check_returning, rollers


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
    check = step_check.check_on_orbit((setup, raw), step_check.run_finer_orbit(setup, raw))
    assert check is not None
    assert check.rms < 1e-3
    assert check.record < 2e-3


def test_raw_values_that_end_before_a_run_is_steady_are_checked_on_a_pilot() -> None:
    test_case = choice.resolve(case(model="rollers", defect=SLOT, **SLOW, record=["roller.1.outer_force"]))
    setup = set_up(test_case)
    raw = integrate(setup)
    finer = step_check.run_finer_orbit(setup, raw)
    start_time = max(comparison.periodic_start(*run) for run in ((setup, raw), finer))
    for count, is_checked in ((comparison.MIN_SAMPLES - 1, False), (comparison.MIN_SAMPLES + 1, True)):
        duration = start_time + count / test_case.sampling - test_case.settle_s
        short = dataclasses.replace(setup, case=test_case.model_copy(update={"duration": duration}))
        assert (step_check.check_on_orbit((short, raw), finer) is not None) == is_checked


def test_a_finer_run_ends_after_two_passes_if_the_coarse_one_shows_how_fast_it_settles() -> None:
    """Its second pass is as close to the orbit as after a further search, to the limit of 1e-5."""
    coarse = set_up(choice.resolve(rollers()), 2.0)
    raw = integrate(coarse, criterion=step_check.ORBIT_CRITERION)
    assert 0.0 < raw.repetition.contraction < 1e-3
    fine, short = step_check.run_finer_orbit(coarse, raw)
    assert short.repetition.computed == 2
    assert short.repetition.contraction == raw.repetition.contraction
    long = integrate(fine, start=step_check.rewound_state(coarse, raw))
    assert long.repetition.computed > 2
    changes = comparison.compare(*(comparison.period_signals(fine, run, 0.0) for run in (short, long)))
    assert max(changes) < 1e-5
    slow = dataclasses.replace(raw, repetition=raw.repetition._replace(contraction=0.9))
    assert step_check.run_finer_orbit(coarse, slow)[1].repetition.computed > 2


def test_the_search_for_a_period_ends_as_close_as_a_finer_run() -> None:
    coarse = set_up(choice.resolve(rollers()), 2.0)
    search = refinement._search(coarse)
    assert search.period == 1
    assert search.passes < integrate(coarse).repetition.computed


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


@pytest.mark.parametrize("settle", ["auto", "8 ms", "0 s"])
def test_record_with_a_transient_is_computed_from_rest(settle: str) -> None:
    """The finer orbit contains no transient, which has decayed after 4 ms, though the search takes longer."""
    test_case = case(model="rollers", method="verlet", defect=SLOT, settle=settle)
    result = refinement.refine_step(choice.Attempt(choice.resolve(test_case), 1.0))
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
    assert result.info["method"] != choice.choose_method(rollers()).method
