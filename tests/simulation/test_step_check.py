"""The proof of a step on the run's own beginning, and what follows if it does not hold."""

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
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.run_setup import TooChaotic, set_up
from bearingsim.simulation.simulate import SimulationError, simulate
from bearingsim.simulation.step_check import StepCheck
from tests.scenes.short_cases import RATE, SLOT, case

LIGHT = {"contact": {"damping": {"chi": "1 s/m"}}}


def rollers(**fields: Any) -> Any:
    return case(model="rollers", defect=SLOT, **fields)


@pytest.mark.parametrize("race", ["outer", "inner"])
def test_the_error_of_an_automatic_step_is_within_its_bound(race: str) -> None:
    """On an orbit, and on a pilot; against an eighth of the step."""
    test_case = case(model="rollers", method="verlet", defect=SLOT | {"race": race})
    run = simulate(test_case)
    finer = {"step": float(run.info["step_s"]) / 8.0, "step_check": False}
    right = simulate(test_case.model_copy(update=finer)).features
    line = {"outer": "velocity@BPFO", "inner": "velocity@BPFI"}[race]
    for bound, feature in (("line", line), ("rms", "velocity.rms"), ("force", "outer_force.max")):
        error = abs(run.features[feature] / right[feature] - 1.0)
        assert error <= run.features[f"step_error.{bound}"] < STEP_ACCURACY
    assert run.features["chaotic"] == 0.0


OWN = [{"method": "verlet", "step": "0.4 us"}, {"method": "rodas", "tolerance": "0.1 %"}]


@pytest.mark.parametrize("own", OWN)
def test_the_record_of_an_own_step_is_bit_for_bit_that_of_a_run_without_check(own: dict[str, Any]) -> None:
    test_case = rollers(**own)
    checks_step, plain = simulate(test_case), simulate(test_case.model_copy(update={"step_check": False}))
    for name, series in checks_step.series.items():
        assert np.array_equal(series, plain.series[name])
    told = {"chaotic", "rms_scatter", *(f"step_error.{what}" for what in ("line", "rms", "force", "record"))}
    for name in plain.features.keys() - told:
        assert plain.features[name] == pytest.approx(checks_step.features[name], rel=0.0, nan_ok=True)
    assert all(math.isnan(plain.features[name]) for name in told)


@pytest.mark.parametrize(
    "fields",
    [{"step": "0.4 us", "step_check": False}, {"step_check": False}, {"model": "static"}],
)
def test_nothing_is_proven_where_that_is_forbidden_or_there_is_no_step(fields: dict[str, Any]) -> None:
    assert not choice.resolve(case(defect=SLOT, **fields)).checks_step


FAST_SLOT = {"speed": "6000 rpm", "defect": SLOT | {"width": "0.4 mm"}, "duration": "30 ms", "settle": "10 ms"}


def test_a_step_that_is_given_is_proven_and_refused_if_it_does_not_hold() -> None:
    """At 0.85 of its limit Verlet was 3 % off in a line, and nothing was said."""
    test_case = case(model="rollers", method="verlet", **FAST_SLOT)
    long = 0.85 * choice.limits(test_case).at_impact
    with pytest.raises(SimulationError, match="verlet is not within 1%") as caught:
        simulate(test_case.model_copy(update={"step": long}))
    assert "use a shorter `step`" in caught.value.advice
    taken = simulate(test_case.model_copy(update={"step": long, "step_check": False}))
    assert math.isnan(taken.features["step_error.line"])
    assert simulate(test_case.model_copy(update={"step": 0.2 * long})).features["step_error.line"] < 0.004


def test_chaos_is_told_from_a_motion_that_repeats_itself() -> None:
    for fields, chaotic in ((LIGHT, True), ({}, False), ({"clearance": "25 um"}, False)):
        result = step_check.check_step(set_up(choice.resolve(rollers(step_check=True, **fields)), 1.0))
        assert result.chaotic == chaotic


def test_where_the_motion_is_chaotic_only_the_rms_counts() -> None:
    assert StepCheck(line=0.5, rms=0.003, chaotic=True).holds
    assert not StepCheck(line=0.5, rms=0.003, chaotic=False).holds
    assert not StepCheck(line=0.0, rms=0.02, chaotic=True).holds
    assert StepCheck(line=0.0, rms=0.02, chaotic=True, noise=0.01).holds  # no more than chaos does
    assert not step_check.UNCHECKED.holds


def test_a_chaotic_record_says_what_its_rms_is_worth() -> None:
    """Done all the same: the step is fine, the motion is what it is."""
    for scatter in (0.02, math.inf):
        result = StepCheck(line=0.5, rms=0.003, chaotic=True, noise=0.02, scatter=scatter)
        with checked(result):
            told = simulate(case()).features
        assert (told["chaotic"], told["rms_scatter"]) == (1.0, scatter)
    assert simulate(case()).features["rms_scatter"] == 0.0


def test_a_chaotic_record_that_is_too_short_for_its_rms_is_refused_where_strictness_is_asked_for() -> None:
    result = StepCheck(line=0.5, rms=0.003, chaotic=True, noise=0.02, scatter=0.02)
    with (
        mock.patch.object(refinement, "check_on_pilot", side_effect=always(result)),
        pytest.raises(TooChaotic) as caught,
    ):
        simulate(case(step_check="strict"))
    assert "the motion is chaotic, and its RMS over 0.08 s is uncertain by 2.0%" in caught.value.reason
    assert "use a `duration` of 0.32 s" in caught.value.advice
    assert caught.value.duration == pytest.approx(0.32)


def test_chaos_that_has_not_grown_in_the_pilot_is_of_unknown_worth() -> None:
    """Twins that have not parted yet tell nothing of how far they will; the advice is a longer run."""
    chaotic_run = step_check.check_step(set_up(choice.resolve(rollers(**LIGHT)), 1.0))
    growing = choice.resolve(rollers(contact={"damping": {"chi": "10 s/m"}}))
    result = step_check.check_step(set_up(growing, 1.0))
    assert chaotic_run.chaotic
    assert math.isfinite(chaotic_run.scatter)
    assert result.chaotic
    assert math.isinf(result.scatter)
    assert pilot.longer_duration(growing) > growing.duration


def test_what_chaos_does_to_the_rms_is_less_sure_where_one_pass_tells_it() -> None:
    rng = np.random.default_rng(5)
    calm = [np.tile(np.sin(np.linspace(0.0, 6.0, 100)), 21)[:2001] for _ in range(3)]
    noise = [rng.normal(0.0, 0.3, 2001) for _ in range(3)]
    one_pass = np.arange(2001) < 100
    everywhere, once = (
        step_check.scatter([a + b * where for a, b in zip(calm, noise, strict=True)], 20)
        for where in (1.0, one_pass)
    )
    assert everywhere[1] < 3.0 < 8.0 < once[1]
    powers = np.array(
        [
            [np.mean((a + b)[i : i + 100] ** 2) for i in range(0, 2000, 100)]
            for a, b in zip(calm, noise, strict=True)
        ]
    )
    assert everywhere[0] == pytest.approx(
        np.sqrt(0.5 * powers.var(axis=0, ddof=1).mean()) / powers.mean(), rel=0.05
    )


def test_what_stays_loud_for_a_while_scatters_more_than_its_passes_do() -> None:
    rng = np.random.default_rng(7)
    tone = np.sin(np.linspace(0.0, 6.0, 10))
    passes = 1024
    alone, lasting = (
        [
            np.append(np.outer(np.repeat(loud, each), tone).ravel(), 0.0)
            for loud in 1.0 + 0.2 * rng.random((3, passes // each))
        ]
        for each in (1, 16)
    )
    assert step_check.scatter(lasting, passes)[0] > 2.5 * step_check.scatter(alone, passes)[0]


def test_errors_that_cancel_by_luck_are_not_taken_for_small() -> None:
    calm, errors = np.ones(4, dtype=complex), np.array([0.1, -0.1, 0.1, -0.1])
    assert comparison.line_change(calm + errors, calm) == pytest.approx(0.2)
    assert comparison.line_change(calm + np.abs(errors), calm) == pytest.approx(0.4)


@pytest.mark.parametrize("louder", ["fine_velocity", "recorded_velocity"])
def test_the_rms_of_the_record_and_of_the_wide_band_must_both_hold(louder: str) -> None:
    test_case = rollers(method="verlet")
    fine, recorded = np.random.default_rng(1).normal(size=(2, 4 * time_grid.grid(test_case).fine_per_pass + 1))
    rows = recorded[np.newaxis]
    signals = comparison.RunSignals(fine, recorded, rows, rows[:0], np.ones((1, 4), dtype=complex), 1.0)
    other = signals._replace(**{louder: 1.02 * getattr(signals, louder)})
    with mock.patch.object(step_check, "run_pilot", side_effect=[other, signals, signals]):
        assert step_check.check_step(set_up(test_case, 1.0)).rms == pytest.approx(0.02)


def test_all_that_is_recorded_is_compared_but_does_not_decide() -> None:
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
        times = np.where(np.arange(4) == row, 1.03, 1.0)[:, np.newaxis]
        amplified.append(signals._replace(low_passed=signals.low_passed * times))
    for other in amplified:
        with mock.patch.object(step_check, "run_pilot", side_effect=[other, signals, signals]):
            result = step_check.check_step(set_up(test_case, 1.0))
        assert result.record == pytest.approx(0.03, rel=0.02)
        assert result.rms == 0.0
        assert result.holds


def test_changes_of_raw_values_that_cancel_by_luck_are_not_taken_for_small() -> None:
    """An impact that meets its neighbour's instant leaves the RMS as it is."""
    before, after = np.zeros((2, 101))
    before[50], after[51] = 1.0, 1.0
    assert np.std(before) == pytest.approx(np.std(after))
    assert comparison.raw_value_change(before, after) == pytest.approx(0.5 * 2.0**0.5, rel=0.02)
    assert comparison.raw_value_change(1.01 * after, after) == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize(
    ("width", "load", "speed"), [("1.29 mm", "595 N", "2253 rpm"), ("1.17 mm", "154 N", "1786 rpm")]
)
def test_the_error_of_raw_values_is_their_own(width: str, load: str, speed: str) -> None:
    """That of the low-passed velocity, or of fine samples, is up to a twelfth of it."""
    damping = {"law": "hunt-crossley", "chi": "50 s/m"}
    defect = {"shape": "circular", "length": "12 mm", "width": width, "depth": "0.05 mm"}
    laws = {"contact": {"damping": damping}, "antialias": False, "settle": "auto"}
    test_case = case(
        model="rollers", load=load, speed=speed, defect=defect, clearance="0 um", duration="0.3 s", **laws
    )
    run = simulate(test_case)
    finer = {"step": float(run.info["step_s"]) / 8.0, "step_check": False, "method": run.info["method"]}
    right = simulate(test_case.model_copy(update=finer)).features["acceleration.rms"]
    error = abs(run.features["acceleration.rms"] / right - 1.0)
    assert 1e-4 < error <= run.features["step_error.record"] < 0.01


@pytest.mark.parametrize("model", ["ring", "rollers"])
@pytest.mark.parametrize("clearance", ["0 um", "10 um"])
def test_a_period_tells_of_the_step_what_a_pilot_does(model: str, clearance: str) -> None:
    """And what halving the step changes of the record."""
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


@pytest.mark.parametrize("more", [{"antialias": False}, {"record": ["roller.1.outer_force"]}])
def test_raw_values_of_a_period_are_compared_once_both_runs_are_steady(more: dict[str, Any]) -> None:
    """For 0.37 s the run settles, which its finer twin, started at its end, need not: RMS 1 % apart."""
    setup = set_up(choice.resolve(case(model="rollers", defect=SLOT, **SLOW, **more)))
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
    for ends, is_checked in ((0.36, False), (0.38, True)):
        with mock.patch.object(step_check, "run_time", return_value=ends):
            assert (step_check.check_on_orbit((setup, raw), finer) is not None) == is_checked


def test_a_run_ends_in_phase_with_its_period() -> None:
    """So that a finer run which starts there meets the record's instants in the same pass of the period."""
    setup = set_up(choice.resolve(rollers()))
    for period, ends in ((1, 5), (2, 6), (3, 6), (4, 8)):
        periods = [(0, math.nan)] * 4 + [(period, 0.0)]
        with mock.patch("bearingsim.simulation.integration.Search.add_pass", side_effect=periods):
            assert integrate(setup).repetition == (ends, period, 0.0)


@pytest.mark.parametrize(("computed", "finer"), [(4, 32), (60, 120), (1342, 600)])
def test_a_long_finer_run_costs_no_more_than_the_run(computed: int, finer: int) -> None:
    """Its steps are shorter by sqrt(5)."""
    raw = integrate(set_up(choice.resolve(rollers())))
    raw = dataclasses.replace(raw, repetition=raw.repetition._replace(computed=computed))
    assert step_check.max_finer_passes(raw) == finer


@pytest.mark.parametrize("roller", [1, 7])
def test_each_roller_is_compared_in_its_own_place(roller: int) -> None:
    """Two runs that end after different numbers of passes have it in different places."""
    defect = SLOT | {"depth": "5 um", "angle": "20 deg"}
    record = [f"roller.{roller}.outer_force"]
    test_case = case(model="rollers", defect=defect, clearance="10 um", record=record, duration=13 / RATE)
    result = simulate(test_case)
    finer = {"step": float(result.info["step_s"]) / 5**0.5, "step_check": False}
    other = simulate(test_case.model_copy(update=finer))
    one, two = (np.std(run.series[record[0]]) for run in (result, other))
    assert result.features["step_error.record"] < 0.01
    assert abs(one / two - 1.0) <= result.features["step_error.record"] + 1e-4


def test_the_rms_that_is_proven_is_that_of_the_record() -> None:
    """What the record's low-pass takes away may hold most of the velocity, and need not be held."""
    test_case = choice.resolve(rollers(sampling="1000 Hz", duration="0.3 s"))
    short, passes = pilot.pilot(test_case)
    signals = step_check.run_pilot(set_up(short), passes)
    read = simulate(short.model_copy(update={"step_check": False})).features["velocity.rms"]
    assert np.std(signals.recorded_velocity) == pytest.approx(read, rel=0.05)
    assert np.std(signals.fine_velocity) > 1.5 * read


def test_a_step_that_is_too_long_is_halved_until_it_is_proven() -> None:
    """Eight steps to a crossing at 12 000 rpm are stable, and 5 % wrong: nothing but the proof notices."""
    test_case = case(model="rollers", method="verlet", speed="12000 rpm", defect=SLOT | {"width": "0.15 mm"})
    long = choice.limits(test_case).crossing / 8.5
    first = proof_of(test_case, long, 1.0)
    assert first.error > STEP_ACCURACY
    with mock.patch.object(time_grid, "requested_step", return_value=long):
        result = simulate(test_case)
    assert float(result.info["step_part"]) < 0.5
    assert max(result.features["step_error.line"], result.features["step_error.rms"]) <= STEP_ACCURACY


def proof_of(given: Any, step: float, part: float) -> StepCheck:
    with mock.patch.object(time_grid, "requested_step", return_value=step):
        return step_check.check_step(set_up(given, part))


def checked(check: StepCheck) -> Any:
    """Replace what a comparison of two orbits gives."""
    return mock.patch.object(refinement, "check_on_orbit", return_value=check)


def always(check: StepCheck) -> Any:
    """Replace what a comparison of two pilots gives, but for the finer one."""
    real = step_check.check_on_pilot
    return lambda *given: real(*given)._replace(check=check)


def parts_of(calls: list[Any]) -> list[float]:
    """Fractions of the automatic step of the runs that were compared on orbits, the coarsest first."""
    return [calls[0].args[0][0].step_fraction, *(call.args[1][0].step_fraction for call in calls)]


def test_a_step_that_is_never_accurate_enough_fails_the_job_with_a_reason() -> None:
    hopeless = StepCheck(line=0.2, rms=0.05, chaotic=False)
    with checked(hopeless) as tried, pytest.raises(SimulationError) as caught:
        simulate(case(method="verlet"))
    parts = parts_of(tried.call_args_list)
    assert parts[0] == refinement.INITIAL_FACTOR
    assert parts[-2] > STEP_FRACTIONS[-1] >= parts[-1]
    assert "verlet is not within 1%: a shorter step changes the line of the fault by 20 %" in caught.value.reason
    assert "step_check: false" in caught.value.advice


@pytest.mark.parametrize("given", [{}, {"defect": SLOT | {"race": "inner"}}], ids=["orbits", "pilots"])
def test_each_finer_run_is_stepped_once_and_the_last_is_the_answer(given: dict[str, Any]) -> None:
    """After two refusals: four orbits, the last is recorded; or four pilots, and the run at the last step."""
    small, large = StepCheck(line=1e-3, rms=2e-3), StepCheck(line=0.05, rms=2e-3)
    checks, stepped, real = iter([large, large, small]), [], integrate

    def counted(setup: Any, *args: Any, **more: Any) -> Any:
        raw = real(setup, *args, **more)
        stepped.append((setup.step_fraction, raw))
        return raw

    pilots = step_check.check_on_pilot
    with (
        mock.patch.object(refinement, "check_on_orbit", side_effect=checks),
        mock.patch.object(refinement, "check_on_pilot", lambda *a: pilots(*a)._replace(check=next(checks))),
        mock.patch.object(step_check, "integrate", counted),
        mock.patch.object(refinement, "integrate", counted),
    ):
        record = simulate(case(model="rollers", method="verlet", **given))
    parts = [part for part, _ in stepped]
    assert parts[:4] == sorted(set(parts), reverse=True)
    assert len(parts) == 4
    assert np.allclose(np.divide(parts[1:], parts[:-1]), 5**-0.5, rtol=0.2)
    assert record.info["step_part"] == parts[-1]
    assert float(record.info["steps_taken"]) > 1.5 * float(record.info["steps"])
    assert record.features["step_error.line"] == pytest.approx(2.0 * 1e-3 + 1e-4)
    assert record.features["step_error.rms"] == pytest.approx(2.0 * 2e-3 + 1e-4)


@pytest.mark.parametrize("change", [0.9e-3, 1.1e-3])
def test_a_run_in_full_takes_the_coarse_step_if_hardly_anything_changes(change: float) -> None:
    light = {"contact": {"damping": "kraemer"}}  # stability does not bound its step
    test_case = Case.model_validate(
        dict(case(model="rollers", method="verlet", defect=SLOT | {"race": "inner"})) | light
    )
    small = StepCheck(line=change, rms=1e-4)
    with mock.patch.object(refinement, "check_on_pilot", side_effect=always(small)):
        record = simulate(test_case)
    coarse = change < refinement.NEGLIGIBLE_CHANGE
    assert (record.info["step_part"] == refinement.INITIAL_FACTOR) == coarse
    times = 2.5 if coarse else 2.0
    assert record.features["step_error.line"] == pytest.approx(times * change + 1e-4)


@pytest.mark.parametrize("settle", ["auto", "0 s"])
def test_a_record_that_is_to_hold_a_transient_is_stepped_from_rest(settle: str) -> None:
    """The finer orbit has none."""
    test_case = case(model="rollers", method="verlet", defect=SLOT, settle=settle)
    result = refinement.refine_step(choice.resolve(test_case), 1.0)
    assert (result.raw is None) == (settle == "0 s")
    record = simulate(test_case)
    plain = {"step": record.info["step_s"], "step_check": False}
    at_once = simulate(test_case.model_copy(update=plain))
    for name in ("velocity@BPFO", "velocity.rms", "acceleration.kurtosis"):
        assert record.features[name] == pytest.approx(at_once.features[name], rel=1e-5), name


def test_a_force_that_no_step_holds_is_told_and_fails_no_job() -> None:
    """Steps get shorter for it, and the shortest is taken."""
    result = StepCheck(line=1e-4, rms=1e-4, force=0.05)
    with checked(result), mock.patch.object(step_check, "check_step", return_value=result):
        record = simulate(case(method="verlet"))
        finest = simulate(case(method="verlet", step=2e-7))
    assert float(record.info["step_part"]) <= STEP_FRACTIONS[-1]
    assert record.features["step_error.force"] == pytest.approx(0.1001)
    assert finest.features["step_error.force"] == pytest.approx(0.12501)


def test_with_auto_other_methods_are_tried_before_the_job_fails() -> None:
    with checked(StepCheck(line=0.2, rms=0.05)):
        result = simulate(rollers())
    assert result.info["method"] != choice.choice(rollers()).method


def test_the_line_of_a_healthy_bearing_is_measured_by_its_rms() -> None:
    """A line that is next to nothing must not fail a run, however much of it changes."""
    result = step_check.check_step(set_up(choice.resolve(case(model="rollers")), 1.0))
    assert result.line < 1e-3


def test_a_pilot_is_short_but_sees_defects_turn_through_the_load_zone() -> None:
    long = {"duration": "4 s", "settle": "0.1 s"}
    full = 4.1 * RATE
    for race, turn in (("outer", 0.0), ("inner", RATE / 30.0), ("roller", 13.0)):
        short, passes = pilot.pilot(choice.resolve(case(defect=SLOT | {"race": race}, **long)))
        assert passes >= max(pilot.MIN_PASSES, turn)
        assert 3.0 * (passes + pilot.SKIPPED_PASSES) < 0.25 * full
        assert short.duration * RATE == pytest.approx(passes + 0.5)


def test_the_pilot_of_a_short_record_is_the_record() -> None:
    short, passes = pilot.pilot(choice.resolve(case(duration="8 ms", settle="0 s")))
    assert passes == 1
    assert short.settle_s + short.duration <= 3.0 / RATE
    assert simulate(case(duration="8 ms", settle="0 s")).features["step_error.rms"] < 0.01


def piloted(**fields: Any) -> tuple[float, int]:
    """What a pilot of `rollers` lets settle (s), and how many ball passes of it are compared."""
    short, passes = pilot.pilot(choice.resolve(rollers(duration="0.4 s", **fields)))
    return short.settle_s, passes


def test_the_pilot_of_a_lightly_damped_bearing_settles_as_the_run_does() -> None:
    """From rest, two random scenes seemed to repeat themselves: what came after settling was chaos."""
    one = pytest.approx(1.0 / RATE, rel=1e-3)
    assert piloted(**LIGHT) == (pytest.approx(30e-3), 5)
    assert piloted() == (one, 5)
    assert piloted(settle="0 s", **LIGHT) == (one, 4)


def test_where_strictness_is_asked_for_the_whole_run_is_proven() -> None:
    """Twins of random scenes parted after two thirds of their records."""
    for damping in (LIGHT, {}):
        assert piloted(step_check="strict", **damping) == (pytest.approx(30e-3), int(0.4 * RATE))
    assert pilot.pilot(choice.resolve(rollers(step_check="strict", duration="1 s", settle="50 ms")))[1] == 159


def test_a_proof_may_take_longer_than_a_run_may() -> None:
    """The finer pilot of a strict proof takes more than twice the CPU time of its run."""
    test_case = choice.resolve(rollers(step_check="strict"))
    price = (test_case.settle_s + test_case.duration) * pricing.cpu_per_second(
        test_case, time_grid.grid(test_case).step
    )
    begun = mock.patch.object(step_check, "run_pilot", side_effect=InterruptedError)
    with mock.patch.object(time_grid, "MAX_CPU", 1.3 * price), begun, pytest.raises(InterruptedError):
        step_check.check_step(set_up(test_case, 1.0))  # both pilots were let begin


def test_twins_that_part_without_chaos_are_followed_for_longer() -> None:
    """A random scene whose RMS was 3 % off, 0.06 % said: in six ball passes the nudge had not begun to grow."""
    damping = {"law": "kraemer", "beta": 2.2166e-6}
    stiffness = {"law": "constant", "coefficient": 1.50793 * 8.06e4 * 12.0 ** (8.0 / 9.0), "exponent": 10.0 / 9.0}
    test_case = choice.resolve(
        case(
            model="rollers",
            load=31.2773,
            clearance=23.4516e-6,
            speed="4541.38 rpm",
            contact={"stiffness": stiffness, "damping": damping},
            defect={"shape": "circular", "length": "12 mm", "width": 0.942375e-3, "depth": 587.092e-6},
            duration="0.15 s",
            settle="50 ms",
        )
    )
    first, doubtful, _ = step_check.check_on_pilot(test_case, 1.0, *pilot.pilot(test_case))
    assert doubtful
    assert first.holds
    assert not first.chaotic
    assert step_check.check_step(set_up(test_case, 1.0)).chaotic


def test_friction_is_no_damping_of_what_bounces() -> None:
    """In `planar` the cage limits the step; a roller between the races rings on all the same, however fast."""
    stiff = {"cage": {"pocket_stiffness": "1e10 N/m"}}
    for fields in ({}, {"speed": "12000 rpm", "load": "20 N"}):
        plain, planar, pocket = (
            choice.limits(case(model=model, defect=SLOT, **LIGHT, **fields, **cage)).damping_ratio
            for model, cage in (("rollers", {}), ("planar", {}), ("planar", stiff))
        )
        assert planar == pocket == pytest.approx(plain, rel=1e-3)
        assert plain < 0.05


def test_adaptive_methods_are_proven_by_a_tenth_of_the_tolerance() -> None:
    test_case = rollers(method="rodas")
    h = time_grid.grid(test_case).step
    full, half = (assemble.method(test_case, h, part) for part in (1.0, 0.5))
    assert half.rtol == pytest.approx(0.1 * full.rtol)
    assert half.atol_q == pytest.approx(0.1 * full.atol_q)


def test_a_quiet_line_is_held_to_1_percent_too() -> None:
    """A fault's line is a few hundredths of the RMS: only what is next to nothing is excused."""
    assert QUIET_LINE * STEP_ACCURACY <= 1e-5


def test_a_pilot_of_a_ramp_runs_at_its_highest_speed() -> None:
    """At the low speed that it begins with, hardly a ball pass would be seen."""
    test_case = choice.resolve(case(ramp={"to": "18000 rpm", "time": "1 s"}, model="planar", duration="2 s"))
    short, passes = pilot.pilot(test_case)
    assert short.ramp is None
    assert time_grid.grid(short).rate == time_grid.grid(test_case).rate == pytest.approx(10.0 * RATE)
    assert passes == pytest.approx(pilot.PILOT_FRACTION * 2.03 * 10.0 * RATE, abs=1.0)


def test_a_tolerance_that_is_given_is_proven_by_a_tenth_of_it() -> None:
    test_case = rollers(method="rodas", tolerance="0.1 %")
    assert test_case.checks_step
    assert assemble.method(test_case, 1e-6, 0.5).rtol == 1e-3
    assert assemble.method(step_check.with_finer_tolerance(test_case), 1e-6).rtol == pytest.approx(1e-4)


def test_a_second_defect_out_of_step_is_seen_by_the_proof() -> None:
    """Whole numbers of steps to one would leave both defects where they are in a step, and the error unseen."""
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
    said = step_check.check_step(set_up(test_case, 1.0))
    fast = test_case.model_copy(update={"step_check": False})
    true = simulate(fast.model_copy(update={"method": "dop853", "tolerance": 1e-6}))
    result = simulate(fast)
    off = abs(result.features["velocity.rms"] / true.features["velocity.rms"] - 1.0)
    assert off > 0.005
    assert said.rms > 0.25 * off
