"""Settling: how long a run remembers its start, how the steady motion is extrapolated, and what error is left."""

import sys
from math import log
from typing import Any

import numpy as np
import pytest

from bearingsim import assemble, simulate
from bearingsim.core import layout as lay
from bearingsim.errors import Refused
from bearingsim.simulation import SimulationError, choice, repetition, settling, step_check, time_grid
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.settling import SlowModes
from tests.scenes.short_cases import SLOT, case

HEAVY: dict[str, Any] = {
    "model": "rollers",
    "rig": {"ring_mass": "20 kg"},
    "step_check": False,
    "duration": "0.3 s",
    "defect": SLOT,
}
CELLS = (lay.X, lay.Y)


def auto(**fields: Any) -> Any:
    return case(**{"settle": "auto"} | fields)


@pytest.mark.parametrize("model", ["ring", "rollers", "planar"])
def test_contacts_damp_a_ring_by_its_mass(model: str) -> None:
    """c/2m of contacts in parallel: twice the mass decays half as fast, twice the damping twice as fast."""
    light, heavy = (
        auto(model=model, rig={"ring_mass": mass, "bracket_damping": 0}) for mass in ("20 kg", "40 kg")
    )
    assert settling.slowest_decay(light) == pytest.approx(2.0 * settling.slowest_decay(heavy), rel=0.02)
    damped = auto(model=model, rig={"ring_mass": "20 kg", "bracket_damping": 2000.0})
    added = settling.slowest_decay(damped) - settling.slowest_decay(light)
    assert added == pytest.approx(2000.0 / (2.0 * 20.0), rel=0.03)


def test_auto_is_as_long_as_the_slowest_mode_needs() -> None:
    assert settling.settling(auto()) == settling.MIN_SETTLING
    heavy = auto(**HEAVY)
    assert settling.settling(heavy) == pytest.approx(-log(settling.MAX_TRANSIENT) / settling.slowest_decay(heavy))
    assert settling.remaining_transient(settling.resolve_settling(heavy)) == pytest.approx(settling.MAX_TRANSIENT)
    assert settling.settling(auto(rig={"ring_mass": "2000 kg"})) == settling.MAX_SETTLING
    assert settling.resolve_settling(case(settle="20 ms")).settle == 0.02


def test_a_free_cage_settles_for_five_turns() -> None:
    free = auto(model="planar")
    assert settling.settling(free) == pytest.approx(5.0 * settling.cage_turn(free))
    assert settling.settling(auto(model="planar", cage={"motion": "kinematic"})) == settling.MIN_SETTLING


def test_a_free_cage_settles_for_two_turns_before_a_record_that_may_end_early() -> None:
    """Unless oil drags its rollers: gross slip takes longer."""
    early = {"model": "planar", "record": [], "until": "1 %"}
    dry, oiled = auto(**early), auto(**early, drag={"oil_fraction": 0.1})
    turn = settling.cage_turn(dry)
    assert [settling.settling(variant) for variant in (dry, oiled)] == pytest.approx([2.0 * turn, 5.0 * turn])


def test_models_without_memory_have_no_modes() -> None:
    assert settling.modes(auto(model="static")) == ()
    assert settling.settling(auto(model="static")) == settling.MIN_SETTLING


def test_runs_settle_for_the_time_that_auto_stands_for() -> None:
    heavy = auto(**HEAVY)
    assert simulate(heavy).info["settle_s"] == pytest.approx(settling.settling(heavy))


def decaying(matrix: np.ndarray, passes: int = 40, count: int = 4) -> tuple[SlowModes, np.ndarray]:
    """The extrapolation fed with s' = s_0 + M (s - s_0), s_0 = (1, -1) um; and the state (2,) at its end."""
    model = assemble.model(case(defect=SLOT))
    slow, y, rest = SlowModes(model, count, passes, 1e-9), assemble.empty_buffer(model), np.array([1e-6, -1e-6])
    hidden = np.array([2e-6, 1e-6, 0.0, 3e-6])  # two places, two velocities, as they differ from rest
    cells = np.r_[lay.POSITION + np.array(CELLS), lay.VELOCITY + np.array(CELLS)]
    steady = np.r_[rest, 0.0, 0.0]
    y[cells] = steady + hidden
    for _ in range(passes):
        y[cells] = steady + matrix @ (y[cells] - steady)
        slow.extrapolate(y)
        if slow.converged:
            break
    return slow, y[cells[:2]] - rest


def turning(moduli: tuple[float, float]) -> np.ndarray:
    """A matrix (4, 4) of two pairs of complex modes, mixed with each other."""
    matrix = np.zeros((4, 4))
    for n, (modulus, angle) in enumerate(zip(moduli, (0.8, 2.1), strict=True)):
        c, s = modulus * np.cos(angle), modulus * np.sin(angle)
        matrix[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] = [[c, -s], [s, c]]
    mix = np.eye(4) + 0.3 * np.arange(16).reshape(4, 4) / 16.0
    return np.asarray(mix @ matrix @ np.linalg.inv(mix))


def test_slow_modes_are_taken_off_in_a_few_passes() -> None:
    slow, left = decaying(turning((0.99, 0.97)))
    assert slow.converged
    assert np.abs(left).max() < 1e-13


def test_a_motion_whose_modes_grow_has_no_steady_state() -> None:
    slow, _ = decaying(turning((0.99, 1.002)))
    assert not slow.steady


def test_states_are_compared_with_rollers_in_the_places_of_the_last() -> None:
    """A pattern that stands still while rollers go on from place to place is the same in each pass."""
    model = assemble.model(case(model="rollers", defect=SLOT))
    slow, pattern = SlowModes(model, 4, 40, 1e-9), np.arange(13.0)
    for n in range(3):
        y = assemble.empty_buffer(model)
        y[lay.RADIAL : lay.RADIAL + 13] = np.roll(pattern, -n)  # roller j stands where j + 1 did a pass before
        slow.states.append(y[lay.POSITION : lay.POSITION + 2 * lay.STATE])
    assert np.ptp(slow._aligned_states(), axis=1).max() == 0.0


@pytest.mark.parametrize("load", [150.0, 150.01, 180.0])
def test_a_start_near_the_steady_motion_needs_little_extrapolation(
    load: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its changes are small from the first on, or rounding: to be much smaller yet is no condition."""
    setup = set_up(choice.resolve(auto(**HEAVY | {"load": load}, periodic=True)))
    raw, passes, plain = integrate(setup), [0], SlowModes.extrapolate

    def counted(slow: SlowModes, y: np.ndarray) -> bool:
        passes[0] += 1
        return plain(slow, y)

    monkeypatch.setattr(SlowModes, "extrapolate", counted)
    integrate(setup, start=step_check.rewound_state(setup, raw), closeness=step_check.ORBIT_CLOSENESS)
    assert 0 < passes[0] <= settling.WAITING_PASSES + 4 + 2
    passes[0] = 0
    integrate(setup, max_passes=5)
    assert passes[0] == 5


def test_only_slow_modes_of_passes_that_are_alike_are_extrapolated() -> None:
    heavy = choice.resolve(auto(**HEAVY))
    assert settling.slow_modes(heavy) == 4
    for other in (
        choice.resolve(auto()),
        heavy.model_copy(update={"settle": 0.05}),
        choice.resolve(auto(**HEAVY | {"defect": SLOT | {"race": "inner"}})),
        choice.resolve(auto(**HEAVY | {"model": "planar"})),
    ):
        assert settling.slow_modes(other) == 0


def test_a_heavy_ring_that_starts_from_rest_is_told_and_auto_forgets_it() -> None:
    long, short, result = (
        simulate(case(**HEAVY | {"settle": settle}, periodic=periodic))
        for settle, periodic in (("1.5 s", False), ("50 ms", True), ("auto", True))
    )
    for name, column in (("velocity@BPFO", ""), ("velocity.rms", ".rms"), ("outer_force.max", ".force")):
        right = long.features[name]
        assert result.features[name] == pytest.approx(right, rel=1e-5)
        assert result.features[f"error.start{column}"] < 1e-6
        error = abs(short.features[name] / right - 1.0)
        assert error <= 1.2 * short.features[f"error.start{column}"] + 1e-5
        assert short.features[f"error.start{column}"] <= max(5.0 * error, 5e-3)
    assert short.features["error.start.force"] > 2e-4
    assert float(result.info["passes_computed"]) < 20


def test_periodic_or_in_full_the_motion_is_the_same() -> None:
    short, full = (simulate(auto(**HEAVY, periodic=periodic)) for periodic in (True, False))
    assert full.info["passes_computed"] == full.info["passes"]
    for name in ("velocity@BPFO", "velocity.rms", "velocity.kurtosis", "acceleration.peak", "outer_force.max"):
        assert short.features[name] == pytest.approx(full.features[name], rel=1e-6)


def test_no_error_of_a_free_cage_is_under_its_standard_error() -> None:
    result = simulate(auto(model="planar", defect=SLOT, step_check=False, duration="0.3 s")).features
    one = simulate(auto(model="planar", defect=SLOT, duration="0.3 s", step_check=False, seed=1)).features
    assert 1e-4 < result["error.start"] < 0.5
    assert abs(one["velocity@BPFO"] / result["velocity@BPFO"] - 1.0) < 5.0 * result["error.start"]
    assert 1e-5 < result["error.start.force"] < 0.1
    assert abs(one["outer_force.max"] / result["outer_force.max"] - 1.0) < 5.0 * result["error.start.force"]


def test_a_slow_decay_is_no_repetition() -> None:
    """A difference of 1e-8 that shrinks by half, but of a mode that may keep 0.995 of itself, is not the last."""
    observed = [4e-8, 2e-8, 1e-8]
    assert repetition._has_converged(observed, repetition.RECORD_CLOSENESS, 0.0)
    assert not repetition._has_converged(observed, repetition.RECORD_CLOSENESS, 0.995)
    tiny = [1e-9, 1e-9, 0.9e-10]
    assert repetition._has_converged(tiny, repetition.RECORD_CLOSENESS, 0.99)
    assert not repetition._has_converged(tiny, repetition.RECORD_CLOSENESS, 0.9999)


@pytest.mark.parametrize("rig", [{}, {"ring_mass": "20 kg"}])
def test_an_automatic_step_is_the_same_periodic_or_in_full(rig: dict[str, Any]) -> None:
    """Pilots from rest asked for a quarter of the step that holds on the steady motion."""
    defect = SLOT | {"width": "0.35 mm", "angle": "11 deg"}
    fields = {"speed": "1700 rpm", "load": "180 N", "clearance": "8 um", "defect": defect, "duration": "0.25 s"}
    short, full = (simulate(auto(**fields, rig=rig, periodic=periodic)) for periodic in (True, False))
    assert full.info["passes_computed"] == full.info["passes"]
    assert float(short.info["passes_computed"]) < 0.5 * float(full.info["passes"])
    assert full.info["step_s"] == short.info["step_s"]
    assert full.features["step_error.rms"] == short.features["step_error.rms"]
    for name in ("velocity@BPFO", "velocity@3BPFO", "velocity.rms", "velocity.kurtosis", "outer_force.max"):
        assert short.features[name] == pytest.approx(full.features[name], rel=1e-5)


@pytest.mark.parametrize(
    ("settle", "rig", "advice"),
    [
        ("50 ms", {"ring_mass": "60 kg"}, "use a `settle` of 0.48 s"),
        ("auto", {"ring_mass": "20000 kg", "bracket_damping": 0.0}, "use more damping"),
    ],
)
def test_a_strict_check_refuses_before_the_run_what_cannot_settle(
    monkeypatch: pytest.MonkeyPatch, settle: str, rig: dict[str, Any], advice: str
) -> None:
    """Without a strict check it runs, and `error.start` is large."""
    fields = {"model": "planar", "rig": rig, "defect": SLOT, "settle": settle}
    strict = case(**fields, step_check="strict")
    monkeypatch.setattr(sys.modules[simulate.__module__], "integrate", lambda *_, **__: pytest.fail("it ran"))
    with pytest.raises(SimulationError, match="of the initial transient is left after `settle`") as refusal:
        simulate(strict)
    assert advice in refusal.value.advice
    with pytest.raises(Refused, match=advice):
        time_grid.estimate(strict)
    for other in (case(**fields), case(**fields | {"settle": "auto", "rig": {}}, step_check="strict")):
        assert time_grid.estimate(other).cpu_seconds > 0.0
