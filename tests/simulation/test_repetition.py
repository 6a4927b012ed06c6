"""Periodic motion: cases that are searched for a period, the search, and the record filled in from it."""

import importlib
import math
from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
import pytest

from bearingsim import simulate
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import channels, choice, repetition
from bearingsim.simulation.repetition import (
    EXTREMES,
    RECORD_CRITERION,
    PeriodCriterion,
    Repetition,
    Search,
    may_repeat,
    remaining_sum,
    rotated_rows,
    searches_for_period,
)
from tests.scenes.short_cases import FORCES, RING, SLOT, case

KINEMATIC = {"cage": {"motion": "kinematic"}}
SHAFT: dict[str, Any] = {"shaft": {"stiffness": "1e8 N/m", "damping": "1e3 N s/m", "mass": "2 kg"}, **KINEMATIC}
WIDE = SLOT | {"depth": "5 um", "angle": "20 deg"}
SIMULATION = importlib.import_module("bearingsim.simulation.simulate")
INTEGRATION = importlib.import_module("bearingsim.simulation.integration")
RUN_SETUP = importlib.import_module("bearingsim.simulation.run_setup")


def resolved(**fields: Any) -> Case:
    """Return a case with a named method: Verlet by default, if the model has a method."""
    defaults = {} if fields["model"] in ("static", "impulse") else {"method": "verlet"}
    return choice.resolve(case(**defaults | fields))


@pytest.mark.parametrize(
    "fields",
    [
        {"model": "static", "defect": SLOT},
        {"model": "ring"},
        {"model": "rollers", "defects": [SLOT, SLOT | {"angle": "20 deg"}], "clearance": "10 um"},
        {"model": "planar", "defect": SLOT, "method": "rk4", **KINEMATIC},
        {"model": "spatial", "defect": SLOT, "gravity": True, "method": "verlet", **KINEMATIC},
    ],
)
def test_cases_that_are_searched_for_a_period(fields: dict[str, Any]) -> None:
    assert may_repeat(resolved(**fields))


@pytest.mark.parametrize(
    "fields",
    [
        {"model": "rollers", "defect": SLOT | {"race": "inner"}},
        {"model": "rollers", "defects": [SLOT, SLOT | {"race": "roller"}]},
        {"model": "planar", "method": "verlet"},
        {"model": "planar", "method": "verlet", "ramp": {"to": "2000 rpm", "time": "0.1 s"}, **KINEMATIC},
        {"model": "planar", "method": "verlet", "unbalance": {"mass_radius": "1e-4 kg m"}, **SHAFT},
        {"model": "impulse", "defect": SLOT},
        {"model": "rollers", "method": "dop853"},
        {"model": "rollers", "periodic": False},
    ],
)
def test_cases_that_are_not_searched_for_a_period(fields: dict[str, Any]) -> None:
    assert not may_repeat(resolved(**fields))


@pytest.mark.parametrize(
    ("periodic", "step_check", "searched"),
    [(True, True, True), (True, False, True), (False, True, True), (False, False, False), (True, "strict", False)],
)
def test_runs_that_begin_with_a_search(periodic: bool, step_check: bool | str, searched: bool) -> None:
    """The period is used for the record or to check the step; a strict check compares the whole run."""
    test_case = resolved(model="rollers", defect=SLOT, periodic=periodic, step_check=step_check)
    assert searches_for_period(test_case) == searched


def test_case_with_an_unknown_field_is_not_searched() -> None:
    class ExtendedCase(Case):
        wear: float = 0.0

    test_case = resolved(model="ring")
    assert may_repeat(test_case)
    assert not may_repeat(ExtendedCase.model_construct(**dict(test_case)))


def test_model_that_does_not_declare_periodicity_is_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    test_case = resolved(model="ring")
    monkeypatch.setitem(MODELS, "ring", replace(MODELS["ring"], repeats=False))
    assert not may_repeat(test_case)


def test_later_passes_repeat_the_last_period() -> None:
    result = Repetition(computed=7, period=3, difference=0.0)
    assert result.source(np.arange(14)).tolist() == [0, 1, 2, 3, 4, 5, 6, 4, 5, 6, 4, 5, 6, 4]
    assert Repetition(4, 0, 0.0).source(np.arange(4)).tolist() == [0, 1, 2, 3]


def test_roller_has_the_position_of_the_next_one_a_pass_before() -> None:
    rows = channels.recorded_cells(resolved(model="rollers", record=["roller.3.outer_force", "ring.velocity"]))
    previous_rows = rotated_rows(rows, 13, 1)
    assert np.array_equal(previous_rows[: len(channels.FEATURE_CELLS)], np.arange(len(channels.FEATURE_CELLS)))
    assert [int(rows[previous_rows[list(rows).index(lay.Q_O + j)]]) - lay.Q_O for j in (2, 12)] == [3, 0]


@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("clearance", ["0 um", "10 um"])
@pytest.mark.parametrize("model", ["static", "ring", "rollers", "planar"])
def test_filled_in_record_equals_the_computed_one(model: str, clearance: str, antialias: bool) -> None:
    fields: dict[str, Any] = KINEMATIC if model == "planar" else {}
    fields |= {"model": model, "clearance": clearance, "antialias": antialias, "record": RING + FORCES}
    fields |= {"defect": WIDE, "duration": 0.25, "settle": 0.041, "step_check": False}
    short, full = simulate(case(**fields)), simulate(case(**fields, periodic=False))
    assert float(short.info["passes_computed"]) < 0.5 * float(full.info["passes_computed"])
    assert (short.info["period_passes"], full.info["period_passes"]) == (1, 0)
    for name, series in full.series.items():
        assert np.abs(short.series[name] - series).max() < 1e-6 * np.ptp(series), name
    for name, value in full.features.items():
        size = 1e-3 * full.features.get(f"{name.partition('@')[0]}.rms", 0.0)
        size = 1e-3 if name.startswith("error.start") else size
        if not name.endswith((".phase", "-scatter")):
            assert short.features[name] == pytest.approx(value, rel=1e-6, abs=1e-6 * size, nan_ok=True), name


def test_non_periodic_motion_is_computed_in_full() -> None:
    """Unloaded rollers chatter at this speed."""
    test_case = case(
        model="rollers", defect=WIDE, speed="600 rpm", clearance="10 um", method="verlet", step_check=False
    )
    result = simulate(test_case)
    assert result.info["passes_computed"] == result.info["passes"]
    assert result.info["period_passes"] == 0
    assert float(result.info["last_difference"]) > 1e-7


# The search alone

STEPS = 40


def period_of(
    motion: Callable[[int], np.ndarray],
    passes: int = 40,
    peaks: Callable[[int], np.ndarray] = lambda p: np.ones(5),
    closeness: PeriodCriterion = RECORD_CRITERION,
) -> tuple[int, int]:
    """Return the period of ``motion`` (from pass number to (9, STEPS)) and the passes needed to find it.

    peaks: returns ``EXTREMES`` by pass number.
    """
    setup = RUN_SETUP.set_up(resolved(model="ring"))
    search, y = (
        Search(channels.recorded_cells(setup.case), STEPS, setup.model, False, closeness),
        lay.make_buffer(13, 0.0),
    )
    for p in range(passes):
        window = motion(p)
        y[[lay.POSITION + lay.X, lay.POSITION + lay.Y, lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y]] = window[
            :4, -1
        ]
        result, _ = search.add_pass(window, y, peaks(p))
        if result:
            return result, p + 1
    return 0, passes


def test_passes_are_compared_in_ring_motion_and_recorded_channels_only() -> None:
    """Accelerations jump; loaded rollers and the cage are compared in the state at the end of a pass."""
    setup = RUN_SETUP.set_up(resolved(model="rollers", record=["roller.3.outer_force"]))
    cells = channels.recorded_cells(setup.case)
    search = Search(cells, STEPS, setup.model, False, RECORD_CRITERION)
    ring = [lay.POSITION + lay.X, lay.POSITION + lay.Y, lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y]
    assert cells[search.compared_rows][:5].tolist() == [*ring, lay.Q_O + 2]
    assert set(search.compared_rows) == set(range(len(cells))) - {*range(4, len(channels.FEATURE_CELLS))}


def waves(p: int, period: int = 1) -> np.ndarray:
    return np.sin(2.0 * np.pi * (p + np.linspace(0.0, 1.0, STEPS)) / period + np.arange(9)[:, np.newaxis])


LONG: dict[str, Any] = {"model": "rollers", "defect": SLOT, "duration": "0.6 s", "record": []}


@pytest.fixture
def no_period_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Search, "add_pass", lambda *arguments: (0, 0.1))
    monkeypatch.setattr(choice, "MIN_SAVING", 0.0)


@pytest.mark.usefixtures("no_period_found")
def test_non_periodic_case_is_computed_by_another_method() -> None:
    test_case = case(**LONG)
    result = choice.choose_method(test_case)
    assert result.method == "verlet"
    assert 0 < first_attempt(test_case).max_search_passes < 30
    record = simulate(test_case)
    assert record.info["method"] != "verlet"
    assert record.info["passes_computed"] == record.info["passes"]
    full = simulate(test_case.model_copy(update={"method": "verlet"}))
    assert full.info["passes_computed"] == full.info["passes"]
    assert record.features["velocity@BPFO"] == pytest.approx(full.features["velocity@BPFO"], rel=0.01)
    assert record.features["outer_force.max"] == pytest.approx(full.features["outer_force.max"], rel=0.01)


@pytest.mark.usefixtures("no_period_found")
def test_first_method_is_used_again_if_the_others_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    attempts, real_simulate = [], SIMULATION._attempt_simulation

    def failing_simulate(attempt: choice.Attempt, began: float) -> Any:
        attempts.append((attempt.case.method, attempt.max_search_passes, attempt.step_fraction))
        if attempt.case.method != "verlet":
            raise RUN_SETUP.TooSlow("too slow", "wait")
        return real_simulate(attempt, began)

    monkeypatch.setattr(SIMULATION, "_attempt_simulation", failing_simulate)
    record = simulate(case(**LONG))
    assert attempts[0] == ("verlet", first_attempt(case(**LONG)).max_search_passes, 1.0)
    assert attempts[-1][:2] == ("verlet", 0)
    assert len(attempts) == len(set(attempts)) > 2
    assert record.info["method"] == "verlet"


def first_attempt(test_case: Case) -> choice.Attempt:
    """Return the first attempt at a case, limited by the price of the second."""
    first, *others = choice.attempts(test_case)
    return first._replace(limit=min((attempt.cost for attempt in others), default=inf) + choice.MIN_SAVING)


def test_patience_ends_with_the_search_for_a_period() -> None:
    attempt = first_attempt(case(**LONG))._replace(limit=1e-9)
    assert attempt.max_search_passes > 0
    assert attempt._replace(periodic=False).max_search_passes == 0


@pytest.mark.parametrize("change", [{"until": "1 %"}, {"duration": "40 ms"}, {"method": "verlet"}])
def test_cases_without_limited_patience(change: dict[str, Any]) -> None:
    """A record that may end early, a short record, and a given method."""
    assert first_attempt(case(**LONG | change)).max_search_passes == 0


@pytest.mark.parametrize("period", [1, 2, 3, 4])
def test_the_shortest_period_is_found(period: int) -> None:
    assert period_of(lambda p: waves(p, period)) == (period, 2 * period + 1)


def test_period_of_five_passes_is_not_found() -> None:
    assert period_of(lambda p: waves(p, 5)) == (0, 40)


@pytest.mark.parametrize("rho", [0.1, 0.5, 0.9])
def test_period_is_found_once_the_transient_has_decayed(rho: float) -> None:
    """The remaining change is then below 1e-7 of the range."""
    period, passes = period_of(lambda p: (1.0 + rho**p) * waves(p), passes=400)
    assert period == 1
    assert rho ** (passes - 1) < 2e-7


@pytest.mark.parametrize(("rho", "result"), [(1e-5, (1, 2)), (4e-5, (1, 3))])
def test_one_difference_suffices_with_a_known_contraction(rho: float, result: tuple[int, int]) -> None:
    """The first is 5e-4 of the range; ten times ``rho`` of it is 5e-8 or 2e-7, the limit being 1e-7."""
    closeness = RECORD_CRITERION._replace(contraction=rho)
    assert period_of(lambda p: (1.0 + 1e-3 * rho**p) * waves(p), closeness=closeness) == result


def test_very_slow_transient_is_not_periodic() -> None:
    assert period_of(lambda p: (1.0 + 1e-7 * 0.99**p) * waves(p), passes=60) == (0, 60)


def test_difference_that_returns_after_zero_is_not_periodic() -> None:
    """Two identical passes give no rate of decay."""
    assert period_of(lambda p: (1.0 + 1e-8 * (p // 2)) * waves(0)) == (0, 40)


def test_changes_that_decay_within_a_pass_are_detected() -> None:
    def chattering(p: int) -> np.ndarray:
        return waves(p) + 1e-5 * np.random.default_rng(p).normal(size=STEPS) * (np.arange(STEPS) < 30)

    assert period_of(chattering) == (0, 40)


@pytest.mark.parametrize(
    ("name", "mean", "change", "result"),
    [
        ("outer_force.max", 1.0, 0.0, (1, 3)),
        ("outer_force.max", 1.0, 1e-6, (0, 40)),
        ("outer_force.max", 0.0, 1e-12, (0, 40)),
        ("tilt.max", 1.0, 1e-3, (0, 40)),
        ("tilt.max", 0.0, 1e-12, (1, 3)),  # rounding errors of a roller that does not tilt
    ],
)
def test_largest_forces_and_tilts_must_repeat(
    name: str, mean: float, change: float, result: tuple[int, int]
) -> None:
    noise = np.random.default_rng(0).random(40)

    def peaks(p: int) -> np.ndarray:
        return np.where(np.array([*EXTREMES]) == name, mean + change * noise[p], 1.0)

    assert period_of(waves, peaks=peaks) == result


@pytest.mark.parametrize(("change", "result"), [(1e-10, (0, 40)), (1e-15, (1, 3))])
def test_small_tilts_are_compared_with_the_ring_displacement(change: float, result: tuple[int, int]) -> None:
    """Per pass a tilt times the race radius changes by 2e-6 or 2e-11 of 2 um; a speed is no length."""
    scales = np.array([1e-6, 1e-6, 0.1, 0.1, *np.ones(5)])[:, np.newaxis]  # m, m/s

    def peaks(p: int) -> np.ndarray:
        return np.where(np.array([*EXTREMES]) == "tilt.max", change * p, 1.0)

    assert period_of(lambda p: scales * waves(p), peaks=peaks) == result


def test_forces_are_compared_relative_to_the_range_of_all_rollers() -> None:
    """Forces that differ by much of the range in an unloaded position, but not of the range of all, are equal."""
    setup = RUN_SETUP.set_up(resolved(model="rollers", record=["roller.outer_force"]))
    cells = channels.recorded_cells(setup.case)
    search, y = Search(cells, STEPS, setup.model, False, RECORD_CRITERION), lay.make_buffer(13, 0.0)
    noise, periods = np.random.default_rng(0), []
    for p in range(5):
        forces = np.array([np.linspace(0.0, (j + p) % 13 != 5, STEPS) for j in range(13)])
        forces[(5 - p) % 13] = 1e-12 * noise.random(STEPS)
        window = np.vstack([waves(p), forces])
        periods.append(search.add_pass(window, y, np.ones(5))[0])
    assert periods == [0, 0, 1, 1, 1]


def test_remaining_change_is_the_sum_of_a_geometric_series() -> None:
    assert remaining_sum(3.0, 0.9) == pytest.approx(3.0 * sum(0.9**n for n in range(1, 400)))
    assert remaining_sum(3.0, 0.1) == 3.0  # at least the last change
    assert remaining_sum(3.0, 1.0) == remaining_sum(3.0, 1.5) == math.inf


def test_all_rollers_have_one_range() -> None:
    """Each roller passes only its part of the circumference in a ball pass."""
    setup = RUN_SETUP.set_up(resolved(model="rollers", record=["roller.outer_force"]))
    cells = channels.recorded_cells(setup.case)
    search = Search(cells, STEPS, setup.model, False, RECORD_CRITERION)
    recording = np.zeros((len(search.compared_rows), STEPS))
    forces = np.flatnonzero(lay.lane_of(cells[search.compared_rows]) >= 0)
    recording[forces] = np.linspace(10.0, 20.0, len(forces))[:, np.newaxis]
    ranges = search._ranges(recording)[search.compared_rows[forces]]
    assert len(forces) == 13
    assert ranges == pytest.approx(np.full(13, 10.0))


@pytest.mark.parametrize("part", [0.0, 0.95])
@pytest.mark.parametrize("passes", [0, 1, 2, 3])
def test_number_of_stored_passes_is_limited_by_memory(
    passes: int, part: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Periods are searched up to the number of stored passes (doubles); none without a stored pass."""
    setup = RUN_SETUP.set_up(resolved(model="ring"))
    cells = channels.recorded_cells(setup.case)
    monkeypatch.setattr(repetition, "MAX_STORED_BYTES", (passes + part) * 8 * len(cells) * STEPS)
    search = Search(cells, STEPS, setup.model, False, RECORD_CRITERION)
    assert list(search.periods) == list(range(1, passes + 1))


def test_motion_without_memory_is_periodic_from_the_first_pass() -> None:
    setup = RUN_SETUP.set_up(resolved(model="static"))
    search = Search(channels.recorded_cells(setup.case), STEPS, setup.model, True, RECORD_CRITERION)
    assert search.add_pass(waves(0), lay.make_buffer(13, 0.0), np.ones(5)) == (1, 0.0)


def test_difference_at_the_limit_has_converged() -> None:
    assert repetition._has_converged([RECORD_CRITERION.difference_limit], RECORD_CRITERION, 0.0)
    assert not repetition._has_converged([1.01 * RECORD_CRITERION.difference_limit], RECORD_CRITERION, 0.0)
