"""Pilots of a step check: their length, their repetition, and runs that continue them."""

import math
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim.simulation import choice, comparison, pilot, pricing, refinement, step_check, time_grid
from bearingsim.simulation.integration import Run, integrate
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import simulate
from tests.scenes.short_cases import RATE, SLOT, case
from tests.scenes.step_checks import LIGHT, rollers


def test_motion_that_converges_at_one_step_is_not_perturbed_at_the_next() -> None:
    test_case = choice.resolve(case(model="ring", defect=SLOT | {"race": "inner"}, duration="0.3 s"))
    pilot_run = pilot.make_pilot(test_case)
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


def test_pilot_signals_include_wide_band_and_recorded_velocity() -> None:
    """The low-pass of the record removes most of this velocity; changes of both RMS values limit the step."""
    test_case = choice.resolve(rollers(sampling="1000 Hz", duration="0.3 s"))
    short, passes = pilot.make_pilot(test_case)
    signals = step_check.run_pilot(set_up(short), passes)
    recorded_rms = simulate(short.model_copy(update={"step_check": False})).features["velocity.rms"]
    assert np.std(signals.recorded_velocity) == pytest.approx(recorded_rms, rel=0.05)
    assert np.std(signals.fine_velocity) > 1.5 * recorded_rms


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
    assert pilot.make_pilot(continued)[1] == pilot.make_pilot(separate)[1]
    pilot_share = pricing.check_cost_ratio(separate) - pricing.check_cost_ratio(continued)
    assert pricing.check_cost_ratio(continued) == pytest.approx(math.sqrt(5.0) * pilot_share)
    run = simulate(continued).info
    computed_share = float(run["steps_taken"]) / float(run["steps"]) - 1.0
    assert 0.0 < computed_share < pricing.check_cost_ratio(continued)


def test_pilot_is_short_but_covers_turns_of_defects_through_the_load_zone() -> None:
    fields = {"duration": "4 s", "settle": "0.1 s"}
    run_passes = 4.1 * RATE
    for race, min_passes in (("outer", 0.0), ("inner", RATE / 30.0), ("roller", 13.0)):
        short, passes = pilot.make_pilot(choice.resolve(case(defect=SLOT | {"race": race}, **fields)))
        assert passes >= max(pilot.MIN_PASSES, min_passes)
        assert 3.0 * (passes + pilot.SKIPPED_PASSES) < 0.25 * run_passes
        assert short.duration * RATE == pytest.approx(passes + 0.5)


def test_pilot_of_a_short_record_covers_the_whole_run() -> None:
    short, passes = pilot.make_pilot(choice.resolve(case(duration="8 ms", settle="0 s")))
    assert passes == 1
    assert short.settle_s + short.duration <= 3.0 / RATE
    assert simulate(case(duration="8 ms", settle="0 s")).features["step_error.rms"] < 0.01


def pilot_lengths(**fields: Any) -> tuple[float, int]:
    """Return the settling time (s) of a pilot of `rollers` and its number of compared ball passes."""
    short, passes = pilot.make_pilot(choice.resolve(rollers(duration="0.4 s", **fields)))
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
    assert pilot.make_pilot(choice.resolve(rollers(step_check="strict", duration="1 s", settle="50 ms")))[1] == 159


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
    check, is_doubtful, _ = step_check.check_on_pilot(test_case, 1.0, *pilot.make_pilot(test_case))
    assert is_doubtful
    assert check.is_accepted
    assert not check.chaotic
    assert step_check.check_step(set_up(test_case, 1.0)).chaotic


def test_converging_pilots_are_not_repeated_longer() -> None:
    """In `ring` over an inner slot the step changes velocities by 5 %, and a perturbation decays to 1e-14."""
    test_case = choice.resolve(case(model="ring", defect=SLOT | {"race": "inner"}, duration="0.3 s"))
    check, is_doubtful, _ = step_check.check_on_pilot(test_case, 2.0, *pilot.make_pilot(test_case))
    assert not check.chaotic
    assert not is_doubtful
    assert pilot.make_pilot(test_case)[1] < pilot.make_pilot(test_case, step_check.SECOND_PILOT)[1]


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


def test_pilot_of_a_ramp_runs_at_the_highest_speed() -> None:
    """At the initial low speed it would cover hardly a ball pass."""
    test_case = choice.resolve(case(ramp={"to": "18000 rpm", "time": "1 s"}, model="planar", duration="2 s"))
    short, passes = pilot.make_pilot(test_case)
    assert short.ramp is None
    assert time_grid.make_grid(short).rate == time_grid.make_grid(test_case).rate == pytest.approx(10.0 * RATE)
    assert passes == pytest.approx(pilot.PILOT_FRACTION * 2.03 * 10.0 * RATE, abs=1.0)


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
    pilot_case, passes = pilot.make_pilot(coarse.case)
    pilot_setup = set_up(pilot_case.model_copy(update={"periodic": False}), 1.0)
    computed = comparison.pilot_signals(pilot_setup, integrate(pilot_setup), passes)
    for searched_passes in (pilot_setup.grid.passes - 3, pilot_setup.grid.passes + 3):
        runs = refinement.PartialRuns(coarse.case)
        run = runs.runs[1.0] = Run.begin(coarse)
        run.advance(searched_passes)
        raw = runs.beginning(pilot_setup)
        assert raw is not None
        assert run.passes == max(searched_passes, pilot_setup.grid.passes) < coarse.grid.passes
        signals = comparison.pilot_signals(pilot_setup, raw, passes)
        for quantity, value, expected in zip(computed._fields, signals, computed, strict=True):
            np.testing.assert_equal(value, expected, quantity)


def test_a_run_that_is_periodic_within_its_pilot_is_not_the_pilot() -> None:
    """The differences of repeated passes, 1e-7, would exceed those by the perturbation of a pilot."""
    coarse = set_up(choice.resolve(case(defect=SLOT)), 1.0)
    pilot_case, _ = pilot.make_pilot(coarse.case)
    pilot_setup = set_up(pilot_case.model_copy(update={"periodic": False}), 1.0)
    runs = refinement.PartialRuns(coarse.case)
    assert runs.beginning(pilot_setup) is None
    assert 0 < runs.runs[1.0].passes < pilot_setup.grid.passes
    assert integrate(coarse, partial_run=runs.runs[1.0]).repetition == integrate(coarse).repetition


def test_the_search_for_a_period_is_the_run_at_the_first_step() -> None:
    test_case = case(model="rollers", defect=SLOT, **LIGHT)
    fractions, real_begin = [], Run.begin

    def recorded_begin(setup: Any, *args: Any, **options: Any) -> Run:
        fractions.append((setup.step_fraction, setup.case.periodic))
        return real_begin(setup, *args, **options)

    with mock.patch.object(Run, "begin", recorded_begin):
        assert simulate(test_case).features["chaotic"] == 1.0
    assert [fraction for fraction, is_periodic in fractions if is_periodic].count(fractions[0][0]) == 1
