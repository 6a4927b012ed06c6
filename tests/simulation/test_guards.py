"""Failures of a run: outcome, body, time, reason and advice of each, and limits of CPU time."""

import importlib
from dataclasses import replace
from typing import Any
from unittest import mock

import numba
import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core import outcomes
from bearingsim.core.advance import Monitor, advance_and_sample
from bearingsim.core.defects.crossings import count_missed_crossings, relative_passages
from bearingsim.core.methods.verlet import Verlet
from bearingsim.errors import Refused
from bearingsim.simulation import choice, limits, step_check, time_grid
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import SimulationError, simulate
from tests.scenes.nf308 import ROWS, SLOT, advance_recorded, at_rest
from tests.scenes.short_cases import RATE, case

INTEGRATION = importlib.import_module("bearingsim.simulation.integration")
RUN_SETUP = importlib.import_module("bearingsim.simulation.run_setup")
SIMULATION = importlib.import_module("bearingsim.simulation.simulate")
VERLET = {"model": "ring", "method": "verlet", "step": "1 us", "step_check": False, "defect": SLOT}


def end_of_run(monitor: Monitor, y: np.ndarray | None = None, steps: int = 100) -> tuple[int, int, int]:
    """Return the end of a short run of `ring`: steps, outcome, body."""
    model = set_up(choice.resolve(case(**VERLET))).model
    out = np.empty((len(ROWS), steps))
    return advance_recorded(Verlet(1e-6), model, monitor, 0, at_rest(model) if y is None else y, ROWS, out)


# In the core


def test_too_deep_contact_ends_the_run_and_names_the_roller() -> None:
    test_case = choice.resolve(case(model="rollers", method="verlet"))
    model = set_up(test_case).model
    y = at_rest(model)
    y[lay.RADIAL + 4] += 1e-3
    out = np.empty((len(ROWS), 10))
    result = advance_recorded(Verlet(1e-9), model, Monitor(1, 1.0, approach_bound=5e-4), 0, y, ROWS, out)
    assert result == (1, outcomes.TOO_DEEP, 4)


def test_too_much_kinetic_energy_ends_the_run() -> None:
    model = set_up(choice.resolve(case(model="rollers", method="verlet"))).model
    y, out = at_rest(model), np.empty((len(ROWS), 10))
    y[lay.RADIAL_V + 2] = 10.0
    energy = 0.5 * model.bearing.m_r * 100.0
    for bound, is_stopped in ((0.9 * energy, True), (1.1 * energy, False)):
        result = advance_recorded(
            Verlet(1e-12), model, Monitor(1, 1.0, energy_bound=bound), 0, y.copy(), ROWS, out
        )
        assert result == (
            (1, outcomes.TOO_MUCH_ENERGY, outcomes.NO_BODY) if is_stopped else (10, outcomes.SUCCESS, -1)
        )


@pytest.mark.parametrize("outcome", [outcomes.STEP_TOO_SMALL, outcomes.NEWTON_FAILED, outcomes.TOO_MANY_STEPS])
def test_failure_of_a_method_ends_the_run_at_once(outcome: int) -> None:
    model = set_up(choice.resolve(case(**VERLET))).model
    y = at_rest(model)
    y[lay.FAILED], y[lay.FAILED_BODY] = outcome, 3
    assert end_of_run(Monitor(1000, 1.0), y) == (1, outcome, 3)


# Crossings


@pytest.mark.parametrize("race", ["outer", "inner", "roller"])
@pytest.mark.parametrize("model", ["ring", "rollers"])
def test_number_of_crossings_agrees_with_kinematics(model: str, race: str) -> None:
    test_case = case(model=model, defect=SLOT | {"race": race}, step_check=False, duration="0.2 s")
    info = simulate(test_case).info
    span = float(info["steps"]) * float(info["step_s"])
    frequency = {"outer": RATE, "inner": 13 * 30 - RATE, "roller": 30 * (65 / 12 - 12 / 65)}[race]
    assert abs(int(info["crossings"]) - frequency * span) <= (2 if race == "roller" else 1)


def test_unobserved_crossings_are_counted_as_missed() -> None:
    setup = set_up(choice.resolve(case(**VERLET)))
    y = at_rest(setup.model)
    first_passages = [relative_passages(setup.model, 0, 0.0, y)]
    y[lay.DEFECT_CROSSINGS] = y[lay.PAIR_CROSSINGS] = 15.0
    for observed, missed in ((16, 0), (15, 0), (14, 0), (13, 1), (3, 11)):
        y[lay.PAIR_CROSSINGS] = observed
        assert count_missed_crossings(setup.model, 15.5 / RATE, first_passages, y) == missed


def test_missed_crossings_fail_the_run() -> None:
    def advance_without_monitor(method: Any, model: Any, monitor: Monitor, *rest: Any) -> tuple:
        return advance_and_sample(method, model, monitor._replace(stride=10**9), *rest)

    with (
        mock.patch.object(INTEGRATION, "advance_and_sample", advance_without_monitor),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(case(**VERLET))
    assert "steps are too long for" in caught.value.reason
    assert caught.value.time == pytest.approx(5 / RATE, rel=1e-3)  # the ball passes after which it seems to repeat


def test_divergence_in_the_last_steps_fails_the_run() -> None:
    """The monitor checks only every few steps; NaN after its last check must not raise a Python error."""
    diverged = np.array([np.nan])
    with (
        mock.patch.object(INTEGRATION, "_defect_passages", side_effect=[np.zeros(1), diverged]),
        pytest.raises(SimulationError, match="diverged"),
    ):
        simulate(case(**VERLET))


# Reasons and advice


MESSAGES = {
    outcomes.STEP_LIMIT_EXCEEDED: ("roller 3 exceeded the step limit", "use a step under"),
    outcomes.NOT_FINITE: ("diverged", "use a step under"),
    outcomes.TOO_DEEP: ("contact deformation of roller 3 exceeds", "use a step under"),
    outcomes.TOO_MUCH_ENERGY: ("10+ times what load, closing speed and defects explain", "use a step under"),
    outcomes.TOO_SLOW: ("verlet used 12 h of CPU time", "use a shorter `duration`"),
}
ADAPTIVE_MESSAGES = {
    outcomes.STEP_TOO_SMALL: ("the step of dop853 became too short", "use a looser `tolerance`"),
    outcomes.NEWTON_FAILED: (
        "the Newton iteration of dop853 did not converge for roller 3",
        "use a tighter `tolerance`",
    ),
    outcomes.TOO_MANY_STEPS: ("dop853 takes too many steps between two samples", "use a looser `tolerance`"),
}


@pytest.mark.parametrize("outcome", [*MESSAGES, *ADAPTIVE_MESSAGES])
def test_failure_reports_reason_time_body_and_advice(outcome: int) -> None:
    adaptive = outcome in ADAPTIVE_MESSAGES
    test_case = case(model="rollers", defect=SLOT, step_check=False, method="dop853" if adaptive else "verlet")
    test_case = test_case.model_copy(update={"tolerance": 1e-3} if adaptive else {"step": 5e-7})
    with (
        mock.patch.object(INTEGRATION, "advance_and_sample", return_value=(4000, outcome, 2)),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(test_case)
    reason, advice = (MESSAGES | ADAPTIVE_MESSAGES)[outcome]
    caught.match(reason)
    assert caught.value.time == pytest.approx(4000 * time_grid.make_grid(test_case).step, rel=1e-9)
    assert f"{1e3 * float(caught.value.time or 0.0):.4g} ms into the run" in caught.value.reason
    assert advice in caught.value.advice
    assert "or `method: " in caught.value.advice


@pytest.mark.parametrize("outcome", [outcomes.STEP_TOO_SMALL, outcomes.NEWTON_FAILED, outcomes.TOO_MANY_STEPS])
@pytest.mark.parametrize(
    ("model", "m3", "advised"), [("ring", 0, True), ("ring", 1, False), ("rollers", 0, False)]
)
def test_model_with_roller_mass_is_advised_if_contact_damping_needs_it(outcome, model, m3, advised) -> None:
    damping = {"law": "general", "coefficient": 1e3, "indentation_exponent": m3}
    test_case = case(model=model, defect=SLOT, step_check=False, method="rodas", contact={"damping": damping})
    with (
        mock.patch.object(INTEGRATION, "prepare"),
        mock.patch.object(INTEGRATION, "advance_and_sample", return_value=(4000, outcome, 0)),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(test_case)
    with_mass = "use `model: rollers`: a damping force at first contact needs the mass of a roller"
    assert (caught.value.advice == with_mass) == advised
    assert ("or `method: " in caught.value.advice) != advised


def test_severe_case_stays_under_a_tenth_of_the_bounds() -> None:
    """With 60 um of clearance, a defect of 2 mm and little damping."""
    test_case = case(
        model="rollers",
        clearance="60 um",
        defect=SLOT | {"width": "2 mm"},
        contact={"damping": {"chi": "1 s/m"}},
        step_check=False,
    )
    result = choice.limits(test_case)
    assert result.approach_bound < 2e-3
    assert result.energy_bound < 1e3
    for name in ("APPROACH_MARGIN", "ENERGY_MARGIN"):
        with mock.patch.object(limits, name, 0.1 * getattr(limits, name)):
            simulate(test_case)


def forget_limits() -> None:
    """Clear the caches of step limits, which contain the bounds."""
    for cached in (limits.step_limits, limits._common_limits):
        cached.cache_clear()


@pytest.mark.parametrize(
    ("name", "reason"), [("APPROACH_MARGIN", "contact deformation"), ("ENERGY_MARGIN", "kinetic energy exceeds")]
)
def test_exceeded_bound_fails_the_job(name: str, reason: str) -> None:
    test_case = case(model="rollers", method="verlet", step="0.4 us", defect=SLOT)
    forget_limits()
    with mock.patch.object(limits, name, 1e-9), pytest.raises(SimulationError, match=reason) as caught:
        simulate(test_case)
    forget_limits()
    assert caught.value.time is not None


# CPU time


def test_job_over_the_cpu_limit_is_refused_before_the_run() -> None:
    test_case = case(model="rollers", defect=SLOT)
    with mock.patch.object(time_grid, "MAX_CPU", 1e-3):
        with pytest.raises(Refused, match="h of CPU time, over") as caught:
            time_grid.make_grid(test_case)
        assert "shorter `duration`" in caught.value.advice
        time_grid.make_grid(test_case.model_copy(update={"step": 5e-7}))  # a given step is accepted


def test_too_slow_method_is_not_repeated_with_shorter_steps() -> None:
    too_slow = SIMULATION.TooSlow("too slow", "do this", 0.25)
    with (
        mock.patch.object(SIMULATION, "_attempt_simulation", side_effect=too_slow) as attempts,
        pytest.raises(SimulationError),
    ):
        simulate(case())
    methods = [call.args[0].case.method for call in attempts.call_args_list]
    assert len(methods) == len(set(methods)) > 1


def test_cpu_limit_of_a_pilot_is_its_share_of_the_run() -> None:
    test_case = choice.resolve(case(model="rollers", method="dop853", defect=SLOT, duration="1 s"))
    low_limit = mock.patch.object(time_grid, "MAX_CPU", 0.01)
    zero_price = mock.patch.object(time_grid, "cpu_per_second", return_value=0.0)
    with low_limit, zero_price, pytest.raises(SIMULATION.TooSlow) as caught:
        step_check.check_step(set_up(test_case, 1.0))
    assert caught.value.time < 0.02


def test_cpu_time_is_checked_within_a_ball_pass() -> None:
    setup = set_up(choice.resolve(case(**{**VERLET, "step": "auto", "duration": "20 ms"})))
    with pytest.raises(SIMULATION.TooSlow) as caught:
        INTEGRATION.integrate(replace(setup, max_cpu=1e-9))
    assert caught.value.time == pytest.approx(INTEGRATION.FIRST_STEPS * setup.grid.step)


def test_advance_returns_after_a_number_of_evaluations() -> None:
    """An adaptive method may take thousands of internal steps between two recorded instants."""
    setup = set_up(choice.resolve(case(model="rollers", method="dop853", defect=SLOT, duration="20 ms")))
    y, rows = at_rest(setup.model), ROWS
    INTEGRATION.prepare(setup.method, setup.model, 0.0, y)
    monitor = setup.monitor._replace(max_evaluations=1000.0)
    step_count, outcome, _ = advance_recorded(
        setup.method, setup.model, monitor, 0, y, rows, np.empty((len(ROWS), 10_000))
    )
    assert outcome == outcomes.SUCCESS
    assert step_count < 1000
    assert 1000 < y[lay.EVALUATIONS] < 1200


@pytest.mark.parametrize(
    "fields", [{"method": "verlet"}, {"model": "rollers", "method": "dop853"}, {"model": "static"}]
)
def test_cpu_time_checks_do_not_change_the_result(fields: dict[str, str]) -> None:
    test_case = choice.resolve(case(defect=SLOT, duration="20 ms", **fields))
    reference = INTEGRATION.integrate(set_up(test_case))
    with (
        mock.patch.object(INTEGRATION, "STEPS_PER_CALL", 7),
        mock.patch.object(RUN_SETUP, "MAX_EVALUATIONS", 50.0),
    ):
        result = INTEGRATION.integrate(set_up(test_case))
    assert np.array_equal(result.fine, reference.fine)
    assert np.array_equal(result.y, reference.y, equal_nan=True)


def test_run_limits_the_evaluations_of_a_call() -> None:
    test_case = choice.resolve(case(model="rollers", method="dop853", defect=SLOT, duration="20 ms"))
    setup = set_up(test_case)
    assert setup.monitor.max_evaluations == RUN_SETUP.MAX_EVALUATIONS
    with (
        mock.patch.object(RUN_SETUP, "MAX_EVALUATIONS", 1000.0),
        mock.patch.object(INTEGRATION, "advance_and_sample", wraps=advance_and_sample) as mocked,
    ):
        INTEGRATION.integrate(set_up(test_case))
    columns = sum(call.args[6].shape[1] for call in mocked.call_args_list)
    assert columns > setup.grid.passes * setup.grid.steps_per_pass + 1000  # many calls returned early


def test_all_calls_of_the_step_loop_have_one_array_layout() -> None:
    setup = set_up(choice.resolve(case(**VERLET)))
    layouts = []

    def recording_advance(*args: Any) -> Any:
        layouts.append(numba.typeof(args[6]))
        return advance_and_sample(*args)

    with mock.patch.object(INTEGRATION, "advance_and_sample", recording_advance):
        INTEGRATION.integrate(setup)
    assert len(layouts) > 1
    assert len(set(layouts)) == 1


def test_failure_is_reported_rather_than_the_refusal_of_shorter_steps() -> None:
    """The last failure of each method is reported; a refusal only if the method never ran."""
    failure = SIMULATION.MethodFailure("verlet is wrong", "do this", 0.25)
    refusal = Refused("too many steps", "do that")
    test_case = case(method="verlet")
    attempts = mock.patch.object(
        SIMULATION, "_attempt_simulation", side_effect=[failure, refusal, refusal, refusal]
    )
    with attempts, pytest.raises(SimulationError) as caught:
        simulate(test_case)
    assert (caught.value.reason, caught.value.advice, caught.value.time) == ("verlet is wrong", "do this", 0.25)
    with (
        mock.patch.object(SIMULATION, "_attempt_simulation", side_effect=refusal),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(test_case)
    assert (caught.value.reason, caught.value.advice, caught.value.time) == ("too many steps", "do that", None)


def test_only_fixed_steps_are_aligned_with_a_defect() -> None:
    fixed, adaptive = (
        set_up(choice.resolve(case(defect=SLOT, method=name))).model for name in ("verlet", "dop853")
    )
    start_angle = case().start_angle
    assert fixed.bearing.theta_0 != pytest.approx(start_angle, rel=1e-12)
    assert adaptive.bearing.theta_0 == start_angle
