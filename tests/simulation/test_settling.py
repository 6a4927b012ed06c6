"""Settling: duration of the initial transient, extrapolation of the steady motion, and remaining error."""

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
from bearingsim.simulation.settling import SteadyExtrapolation
from tests.scenes.short_cases import SLOT, case

HEAVY: dict[str, Any] = {
    "model": "rollers",
    "rig": {"ring_mass": "20 kg"},
    "step_check": False,
    "duration": "0.3 s",
    "defect": SLOT,
}
CELLS = (lay.X, lay.Y)


def settled_case(**fields: Any) -> Any:
    return case(**{"settle": "auto"} | fields)


@pytest.mark.parametrize("model", ["ring", "rollers", "planar"])
def test_decay_rate_is_damping_over_twice_the_mass(model: str) -> None:
    """Twice the ring mass halves the decay rate; a bracket damper adds c/2m."""
    light, heavy = (
        settled_case(model=model, rig={"ring_mass": mass, "bracket_damping": 0}) for mass in ("20 kg", "40 kg")
    )
    assert settling.slowest_decay(light) == pytest.approx(2.0 * settling.slowest_decay(heavy), rel=0.02)
    damped = settled_case(model=model, rig={"ring_mass": "20 kg", "bracket_damping": 2000.0})
    added_rate = settling.slowest_decay(damped) - settling.slowest_decay(light)
    assert added_rate == pytest.approx(2000.0 / (2.0 * 20.0), rel=0.03)


@pytest.mark.parametrize("friction", ["static-dynamic", "traction"])
def test_friction_does_not_brake_the_rings(friction: str) -> None:
    """6.18 and 6.22 1/s are those of all coordinates, with friction: the rollers roll along with the ring."""
    loose = {"rig": {"ring_mass": "20 kg"}, "clearance": "20 um", "contact": {"damping": "kraemer"}}
    decay = settling.slowest_decay(settled_case(model="planar", friction=friction, **loose))
    assert decay == pytest.approx({"static-dynamic": 6.183, "traction": 6.216}[friction], rel=0.02)
    assert decay == pytest.approx(settling.slowest_decay(settled_case(model="rollers", **loose)), rel=1e-3)


def test_automatic_settling_follows_the_slowest_mode() -> None:
    assert settling.settling_time(settled_case()) == settling.MIN_SETTLING
    heavy = settled_case(**HEAVY)
    assert settling.settling_time(heavy) == pytest.approx(
        -log(settling.MAX_TRANSIENT) / settling.slowest_decay(heavy)
    )
    assert settling.remaining_transient(settling.resolve_settling(heavy)) == pytest.approx(settling.MAX_TRANSIENT)
    assert settling.settling_time(settled_case(rig={"ring_mass": "2000 kg"})) == settling.MAX_SETTLING
    assert settling.resolve_settling(case(settle="20 ms")).settle == 0.02


def test_a_free_cage_settles_for_five_turns() -> None:
    free_cage = settled_case(model="planar")
    assert settling.settling_time(free_cage) == pytest.approx(5.0 * settling.cage_revolution_time(free_cage))
    assert (
        settling.settling_time(settled_case(model="planar", cage={"motion": "kinematic"})) == settling.MIN_SETTLING
    )


def test_free_cage_settles_for_two_turns_if_the_record_may_end_early() -> None:
    """Except with oil drag on the rollers, because gross slip takes longer."""
    early = {"model": "planar", "record": [], "until": "1 %"}
    dry, oiled = settled_case(**early), settled_case(**early, drag={"oil_fraction": 0.1})
    turn = settling.cage_revolution_time(dry)
    assert [settling.settling_time(variant) for variant in (dry, oiled)] == pytest.approx([2.0 * turn, 5.0 * turn])


def test_models_without_memory_have_no_modes() -> None:
    assert settling.mode_eigenvalues(settled_case(model="static")) == ()
    assert settling.settling_time(settled_case(model="static")) == settling.MIN_SETTLING


def test_run_settles_for_the_automatic_time() -> None:
    heavy = settled_case(**HEAVY)
    assert simulate(heavy).info["settle_s"] == pytest.approx(settling.settling_time(heavy))


def extrapolated(matrix: np.ndarray, passes: int = 40, count: int = 4) -> tuple[SteadyExtrapolation, np.ndarray]:
    """Extrapolate s' = s_0 + M (s - s_0), s_0 = (1, -1) um; return the modes and the final deviation (2,) (m)."""
    model = assemble.model(case(defect=SLOT))
    slow, y, equilibrium = (
        SteadyExtrapolation(model, count, passes, 1e-9),
        assemble.empty_buffer(model),
        np.array([1e-6, -1e-6]),
    )
    deviation = np.array([2e-6, 1e-6, 0.0, 3e-6])  # of two positions and two velocities
    cells = np.r_[lay.POSITION + np.array(CELLS), lay.VELOCITY + np.array(CELLS)]
    steady = np.r_[equilibrium, 0.0, 0.0]
    y[cells] = steady + deviation
    for _ in range(passes):
        y[cells] = steady + matrix @ (y[cells] - steady)
        slow.extrapolate(y)
        if slow.converged:
            break
    return slow, y[cells[:2]] - equilibrium


def rotation_matrix(moduli: tuple[float, float]) -> np.ndarray:
    """Return a matrix (4, 4) of two pairs of complex modes, mixed with each other."""
    matrix = np.zeros((4, 4))
    for n, (modulus, angle) in enumerate(zip(moduli, (0.8, 2.1), strict=True)):
        c, s = modulus * np.cos(angle), modulus * np.sin(angle)
        matrix[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] = [[c, -s], [s, c]]
    mix = np.eye(4) + 0.3 * np.arange(16).reshape(4, 4) / 16.0
    return np.asarray(mix @ matrix @ np.linalg.inv(mix))


def test_slow_modes_are_removed_within_a_few_passes() -> None:
    slow, deviation = extrapolated(rotation_matrix((0.99, 0.97)))
    assert slow.converged
    assert np.abs(deviation).max() < 1e-13


def test_motion_with_growing_modes_is_not_steady() -> None:
    slow, _ = extrapolated(rotation_matrix((0.99, 1.002)))
    assert not slow.steady


def test_states_are_compared_by_roller_position() -> None:
    """A pattern fixed in space is the same in each pass, although each roller has the position of the next."""
    model = assemble.model(case(model="rollers", defect=SLOT))
    slow, pattern = SteadyExtrapolation(model, 4, 40, 1e-9), np.arange(13.0)
    for n in range(3):
        y = assemble.empty_buffer(model)
        y[lay.RADIAL : lay.RADIAL + 13] = np.roll(pattern, -n)  # roller j has the position of j + 1 a pass before
        slow.states.append(y[lay.POSITION : lay.POSITION + 2 * lay.STATE])
    assert np.ptp(slow._aligned_states(), axis=1).max() == 0.0


@pytest.mark.parametrize("load", [150.0, 150.01, 180.0])
def test_a_start_near_the_steady_motion_needs_little_extrapolation(
    load: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Changes that are small from the beginning, or rounding errors, need not decrease further."""
    setup = set_up(choice.resolve(settled_case(**HEAVY | {"load": load}, periodic=True)))
    raw, passes, real_extrapolate = integrate(setup), [0], SteadyExtrapolation.extrapolate

    def counting_extrapolate(slow: SteadyExtrapolation, y: np.ndarray) -> bool:
        passes[0] += 1
        return real_extrapolate(slow, y)

    monkeypatch.setattr(SteadyExtrapolation, "extrapolate", counting_extrapolate)
    integrate(setup, start=step_check.rewound_state(setup, raw), criterion=step_check.ORBIT_CRITERION)
    assert 0 < passes[0] <= settling.WAITING_PASSES + 4 + 2
    passes[0] = 0
    integrate(setup, max_passes=5)
    assert passes[0] == 5


def test_only_slow_modes_of_periodic_motion_are_extrapolated() -> None:
    heavy = choice.resolve(settled_case(**HEAVY))
    assert settling.slow_mode_count(heavy) == 4
    for other in (
        choice.resolve(settled_case()),
        heavy.model_copy(update={"settle": 0.05}),
        choice.resolve(settled_case(**HEAVY | {"defect": SLOT | {"race": "inner"}})),
        choice.resolve(settled_case(**HEAVY | {"model": "planar"})),
    ):
        assert settling.slow_mode_count(other) == 0


def test_start_error_of_a_heavy_ring_is_reported_and_removed_by_auto() -> None:
    long, short, result = (
        simulate(case(**HEAVY | {"settle": settle}, periodic=periodic))
        for settle, periodic in (("1.5 s", False), ("50 ms", True), ("auto", True))
    )
    for name, column in (("velocity@BPFO", ""), ("velocity.rms", ".rms"), ("outer_force.max", ".force")):
        reference = long.features[name]
        assert result.features[name] == pytest.approx(reference, rel=1e-5)
        assert result.features[f"error.start{column}"] < 1e-6
        error = abs(short.features[name] / reference - 1.0)
        assert error <= 1.2 * short.features[f"error.start{column}"] + 1e-5
        assert short.features[f"error.start{column}"] <= max(5.0 * error, 5e-3)
    assert short.features["error.start.force"] > 2e-4
    assert float(result.info["passes_computed"]) < 20


INNER: dict[str, Any] = {
    "bearing": "nf308",
    "duration": "0.15 s",
    "record": [],
    "step_check": False,
    "settle": "50 ms",
}


def test_error_of_a_rotating_defect_is_that_of_the_whole_record() -> None:
    """Quarters of 1.5 turns do not separate BPFI from its sidebands; the record does, within 1 %."""
    inner = {"race": "inner", "shape": "rectangular", "length": "8 mm", "width": "1.12 mm", "depth": "20 um"}
    ring = {"rig": {"ring_mass": "3.19 kg"}, "load": "749 N", "speed": "2422 rpm"}
    scene = case(**INNER, **ring, model="rollers", defect=inner)
    record = simulate(scene).features
    longer = simulate(scene.model_copy(update={"settle": 0.2, "duration": 0.6})).features
    assert abs(record["velocity@BPFI"] / longer["velocity@BPFI"] - 1.0) < record["error.start"] < 0.01


def test_error_of_the_rms_includes_a_partial_turn_of_a_defect() -> None:
    """A record of 4.57 turns passes the load zone five times: its RMS is 4 % off that of whole turns."""
    inner = {"race": "inner", "shape": "triangular", "length": "8 mm", "width": "0.86 mm", "depth": "50 um"}
    scene = case(**INNER, model="ring", load="276 N", speed="1827 rpm", defect=inner)
    record = simulate(scene).features
    whole = simulate(scene.model_copy(update={"duration": 20 * 60.0 / 1827.0})).features
    error = abs(record["velocity.rms"] / whole["velocity.rms"] - 1.0)
    assert 0.03 < error < 1.1 * record["error.start.rms"] < 0.06


def test_period_search_does_not_change_the_features() -> None:
    short, full = (simulate(settled_case(**HEAVY, periodic=periodic)) for periodic in (True, False))
    assert full.info["passes_computed"] == full.info["passes"]
    for name in ("velocity@BPFO", "velocity.rms", "velocity.kurtosis", "acceleration.peak", "outer_force.max"):
        assert short.features[name] == pytest.approx(full.features[name], rel=1e-6)


def test_error_of_a_free_cage_covers_other_seeds() -> None:
    result = simulate(settled_case(model="planar", defect=SLOT, step_check=False, duration="0.3 s")).features
    other_seed = simulate(
        settled_case(model="planar", defect=SLOT, duration="0.3 s", step_check=False, seed=1)
    ).features
    assert 1e-4 < result["error.start"] < 0.5
    assert abs(other_seed["velocity@BPFO"] / result["velocity@BPFO"] - 1.0) < 5.0 * result["error.start"]
    assert 1e-5 < result["error.start.force"] < 0.1
    assert abs(other_seed["outer_force.max"] / result["outer_force.max"] - 1.0) < 5.0 * result["error.start.force"]


def test_slow_decay_is_not_periodic() -> None:
    """A difference of 1e-8 that halves each pass is not accepted if a mode may decay by 0.995 a pass only."""
    observed = [4e-8, 2e-8, 1e-8]
    assert repetition._has_converged(observed, repetition.RECORD_CRITERION, 0.0)
    assert not repetition._has_converged(observed, repetition.RECORD_CRITERION, 0.995)
    tiny = [1e-9, 1e-9, 0.9e-10]
    assert repetition._has_converged(tiny, repetition.RECORD_CRITERION, 0.99)
    assert not repetition._has_converged(tiny, repetition.RECORD_CRITERION, 0.9999)


@pytest.mark.parametrize("rig", [{}, {"ring_mass": "20 kg"}])
def test_period_search_does_not_change_the_automatic_step(rig: dict[str, Any]) -> None:
    """Pilots from rest would need a quarter of the step that is accurate on the steady motion."""
    defect = SLOT | {"width": "0.35 mm", "angle": "11 deg"}
    fields = {"speed": "1700 rpm", "load": "180 N", "clearance": "8 um", "defect": defect, "duration": "0.25 s"}
    short, full = (simulate(settled_case(**fields, rig=rig, periodic=periodic)) for periodic in (True, False))
    assert full.info["passes_computed"] == full.info["passes"]
    assert float(short.info["passes_computed"]) < 0.5 * float(full.info["passes"])
    assert full.info["step_s"] == short.info["step_s"]
    assert full.features["step_error.rms"] == short.features["step_error.rms"]
    for name in ("velocity@BPFO", "velocity@3BPFO", "velocity.rms", "velocity.kurtosis", "outer_force.max"):
        assert short.features[name] == pytest.approx(full.features[name], rel=1e-5)


@pytest.mark.parametrize(
    ("settle", "rig", "advice"),
    [
        ("50 ms", {"ring_mass": "60 kg"}, "use a `settle` of 0.67 s"),
        ("auto", {"ring_mass": "20000 kg", "bracket_damping": 0.0}, "use more damping"),
    ],
)
def test_strict_check_refuses_cases_that_cannot_settle(
    monkeypatch: pytest.MonkeyPatch, settle: str, rig: dict[str, Any], advice: str
) -> None:
    """Before the run; without a strict check `error.start` is large."""
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
