"""Motion that repeats itself: what may, when it is found to, and what is made of it."""

import importlib
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bearingsim import simulate
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import channels, choice, repetition
from bearingsim.simulation.repetition import (
    RECORD_CLOSENESS,
    Repetition,
    Search,
    may_repeat,
    partner_rows,
    remaining_sum,
)
from tests.scenes.short_cases import FORCES, RING, SLOT, case

KINEMATIC = {"cage": {"motion": "kinematic"}}
SHAFT: dict[str, Any] = {"shaft": {"stiffness": "1e8 N/m", "damping": "1e3 N s/m", "mass": "2 kg"}, **KINEMATIC}
WIDE = SLOT | {"depth": "5 um", "angle": "20 deg"}
SIMULATION = importlib.import_module("bearingsim.simulation.simulate")
INTEGRATION = importlib.import_module("bearingsim.simulation.integration")
RUN_SETUP = importlib.import_module("bearingsim.simulation.run_setup")


def resolved(**fields: Any) -> Case:
    """A case whose method is named: Verlet's, if it does not say and the model has any."""
    usual = {} if fields["model"] in ("static", "impulse") else {"method": "verlet"}
    return choice.resolve(case(**usual | fields))


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
def test_what_may_repeat(fields: dict[str, Any]) -> None:
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
def test_what_may_not(fields: dict[str, Any]) -> None:
    assert not may_repeat(resolved(**fields))


def test_a_field_that_nobody_thought_of_is_computed_in_full() -> None:
    class Later(Case):
        wear: float = 0.0

    test_case = resolved(model="ring")
    assert may_repeat(test_case)
    assert not may_repeat(Later.model_construct(**dict(test_case)))


def test_a_model_of_another_package_is_computed_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    test_case = resolved(model="ring")
    monkeypatch.setitem(MODELS, "ring", replace(MODELS["ring"], repeats=False))
    assert not may_repeat(test_case)


def test_passes_are_those_of_the_last_period() -> None:
    result = Repetition(computed=7, period=3, difference=0.0)
    assert result.source(np.arange(14)).tolist() == [0, 1, 2, 3, 4, 5, 6, 4, 5, 6, 4, 5, 6, 4]
    assert Repetition(4, 0, 0.0).source(np.arange(4)).tolist() == [0, 1, 2, 3]


def test_a_roller_stands_where_the_next_stood_a_pass_before() -> None:
    rows = channels.recorded_cells(resolved(model="rollers", record=["roller.3.outer_force", "ring.velocity"]))
    before = partner_rows(rows, 13, 1)
    assert np.array_equal(before[: len(channels.FEATURE_CELLS)], np.arange(len(channels.FEATURE_CELLS)))
    assert [int(rows[before[list(rows).index(lay.Q_O + j)]]) - lay.Q_O for j in (2, 12)] == [3, 0]


@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("clearance", ["0 um", "10 um"])
@pytest.mark.parametrize("model", ["static", "ring", "rollers", "planar"])
def test_what_repeats_is_as_if_it_had_been_computed(model: str, clearance: str, antialias: bool) -> None:
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


def test_a_motion_that_never_repeats_is_computed_in_full() -> None:
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


def period_of(motion: Callable[[int], np.ndarray], passes: int = 40) -> tuple[int, int]:
    """The period found of ``motion`` (of a pass's number: (9, STEPS)), and after how many passes."""
    setup = RUN_SETUP.set_up(resolved(model="ring"))
    search, y = (
        Search(channels.recorded_cells(setup.case), STEPS, setup.model, False, RECORD_CLOSENESS),
        lay.buffer(13, 0.0),
    )
    for p in range(passes):
        window = motion(p)
        y[[lay.POSITION + lay.X, lay.POSITION + lay.Y, lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y]] = window[
            :4, -1
        ]
        result, _ = search.add_pass(window, y, np.ones(5))
        if result:
            return result, p + 1
    return 0, passes


def test_passes_are_compared_in_ring_motion_and_recorded_channels_only() -> None:
    """Accelerations jump; loaded rollers and the cage are compared in the state at the end of a pass."""
    setup = RUN_SETUP.set_up(resolved(model="rollers", record=["roller.3.outer_force"]))
    cells = channels.recorded_cells(setup.case)
    search = Search(cells, STEPS, setup.model, False, RECORD_CLOSENESS)
    ring = [lay.POSITION + lay.X, lay.POSITION + lay.Y, lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y]
    assert cells[search.compared_rows][:5].tolist() == [*ring, lay.Q_O + 2]
    assert set(search.compared_rows) == set(range(len(cells))) - {*range(4, len(channels.FEATURE_CELLS))}


def waves(p: int, period: int = 1) -> np.ndarray:
    return np.sin(2.0 * np.pi * (p + np.linspace(0.0, 1.0, STEPS)) / period + np.arange(9)[:, np.newaxis])


LONG: dict[str, Any] = {"model": "rollers", "defect": SLOT, "duration": "0.6 s", "record": []}


@pytest.fixture
def nothing_repeats(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Search, "add_pass", lambda *given: (0, 0.1))


@pytest.mark.usefixtures("nothing_repeats")
def test_what_has_not_repeated_itself_is_handed_to_another_method() -> None:
    test_case = case(**LONG)
    result = choice.choice(test_case)
    assert result.method == "verlet"
    assert 0 < result.patience < 30
    record = simulate(test_case)
    assert record.info["method"] == next(name for name in result.prices if name != "verlet")
    assert record.info["passes_computed"] == record.info["passes"]
    full = simulate(test_case.model_copy(update={"method": "verlet"}))
    assert full.info["passes_computed"] == full.info["passes"]
    assert record.features["velocity@BPFO"] == pytest.approx(full.features["velocity@BPFO"], rel=0.01)
    assert record.features["outer_force.max"] == pytest.approx(full.features["outer_force.max"], rel=0.01)


@pytest.mark.usefixtures("nothing_repeats")
def test_it_comes_back_if_the_others_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    tried, real = [], SIMULATION._simulate

    def simulated(attempt: choice.Attempt, began: float) -> Any:
        tried.append((attempt.case.method, attempt.patience))
        if attempt.case.method != "verlet":
            raise RUN_SETUP.TooSlow("too slow", "wait")
        return real(attempt, began)

    monkeypatch.setattr(SIMULATION, "_simulate", simulated)
    record = simulate(case(**LONG))
    assert tried[0] == ("verlet", choice.choice(case(**LONG)).patience)
    assert tried[-1] == ("verlet", 0)
    assert len(tried) == len(set(tried)) > 2
    assert record.info["method"] == "verlet"


@pytest.mark.parametrize("change", [{"until": "1 %"}, {"duration": "40 ms"}, {"method": "verlet"}])
def test_what_is_not_handed_over(change: dict[str, Any]) -> None:
    """A record that ends early, one that is over soon, a method that was asked for."""
    assert choice.choice(case(**LONG | change)).patience == 0


@pytest.mark.parametrize("period", [1, 2, 3, 4])
def test_the_shortest_period_is_found(period: int) -> None:
    assert period_of(lambda p: waves(p, period)) == (period, 2 * period + 1)


def test_a_period_of_five_passes_is_none() -> None:
    assert period_of(lambda p: waves(p, 5)) == (0, 40)


@pytest.mark.parametrize("rho", [0.1, 0.5, 0.9])
def test_what_settles_is_waited_for(rho: float) -> None:
    """What is left to come when it is found is under 1e-7 of the range."""
    period, passes = period_of(lambda p: (1.0 + rho**p) * waves(p), passes=400)
    assert period == 1
    assert rho ** (passes - 1) < 2e-7


def test_what_settles_hardly_at_all_is_not_believed() -> None:
    assert period_of(lambda p: (1.0 + 1e-7 * 0.99**p) * waves(p), passes=60) == (0, 60)


def test_a_difference_that_comes_back_after_none_is_not_believed() -> None:
    """Two passes that are equal to the last bit leave nothing to divide by."""
    assert period_of(lambda p: (1.0 + 1e-8 * (p // 2)) * waves(0)) == (0, 40)


def test_what_is_forgotten_by_the_end_of_a_pass_is_seen() -> None:
    def chatters(p: int) -> np.ndarray:
        return waves(p) + 1e-5 * np.random.default_rng(p).normal(size=STEPS) * (np.arange(STEPS) < 30)

    assert period_of(chatters) == (0, 40)


def test_what_is_to_come_is_the_sum_of_a_geometric_series() -> None:
    assert remaining_sum(3.0, 0.9) == pytest.approx(3.0 * sum(0.9**n for n in range(1, 400)))
    assert remaining_sum(3.0, 0.1) == 3.0  # at least the last one
    assert remaining_sum(3.0, 1.0) == remaining_sum(3.0, 1.5) == math.inf


@pytest.mark.parametrize("part", [0.0, 0.95])
@pytest.mark.parametrize("passes", [0, 1, 2, 3])
def test_recordings_are_held_up_to_a_size(passes: int, part: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of doubles: periods are sought as far as the passes before are held; none is found without any."""
    setup = RUN_SETUP.set_up(resolved(model="ring"))
    cells = channels.recorded_cells(setup.case)
    monkeypatch.setattr(repetition, "MAX_STORED", (passes + part) * 8 * len(cells) * STEPS)
    search = Search(cells, STEPS, setup.model, False, RECORD_CLOSENESS)
    assert list(search.periods) == list(range(1, passes + 1))


def test_a_motion_without_memory_is_periodic_from_its_first_pass() -> None:
    setup = RUN_SETUP.set_up(resolved(model="static"))
    search = Search(channels.recorded_cells(setup.case), STEPS, setup.model, True, RECORD_CLOSENESS)
    assert search.add_pass(waves(0), lay.buffer(13, 0.0), np.ones(5)) == (1, 0.0)


def test_a_difference_at_its_limit_counts_as_none() -> None:
    assert repetition._has_converged([RECORD_CLOSENESS.difference_limit], RECORD_CLOSENESS, 0.0)
    assert not repetition._has_converged([1.01 * RECORD_CLOSENESS.difference_limit], RECORD_CLOSENESS, 0.0)
