"""`planar` against simpler models; rotated loads, gravity and an unbalanced shaft."""

from math import cos, pi, sin

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble.rest import healthy_equilibrium
from bearingsim.core.geometry import plane
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models import by_roller
from bearingsim.core.parameters import lanes
from bearingsim.simulation.simulate import simulate
from tests.scenes.lanes import compiled, keeps_lanes, needs_vectors
from tests.scenes.nf308 import SLOT, case

SHORT = {"duration": "50 ms", "settle": "20 ms"}
FORCES = [f"roller.{n}.outer_force" for n in (1, 4, 7, 10)]
IDLE = {"model": "planar", "cage": {"motion": "kinematic"}, "friction": "none"}
"""Fields with which `planar` reduces to `rollers`."""


def pair(**fields):
    """Return results in `rollers` and in `planar` without its additional effects, at the same short step."""
    fields = SHORT | {"method": "verlet", "step": "0.15 us", "step_check": False} | fields
    return simulate(case(**fields)), simulate(case(**fields | IDLE))


LADDER = [
    ({}, 3e-4, 1e-4),
    ({"defect": SLOT}, 1e-4, 2e-4),
    ({"defect": SLOT | {"width": "2 mm"}}, 5e-3, 1e-3),
    ({"defect": SLOT | {"race": "inner"}}, 1e-4, 2e-4),
    ({"defect": SLOT | {"race": "roller", "roller": 2}}, 3e-3, 1e-3),
]


@pytest.mark.parametrize(("fields", "tolerance", "rms"), LADDER)
def test_an_idle_planar_is_rollers(fields, tolerance, rms):
    """Velocity along the load: at every instant, relative to its range, and its RMS.

    The difference: the exact approach rotates the force by u/r, and a defect's edge exerts a tangential force on
    the ring, which across the load line is as large as all other forces.
    """
    rollers, planar = pair(**fields)
    difference = planar.velocity - rollers.velocity
    assert np.abs(difference[:, 0]).max() < tolerance * np.ptp(rollers.velocity[:, 0])
    assert planar.features["velocity.rms"] == pytest.approx(rollers.features["velocity.rms"], rel=rms)
    assert planar.features["outer_force.max"] == pytest.approx(rollers.features["outer_force.max"], rel=5e-4)
    assert np.abs(difference).max() > 0.0


@pytest.mark.parametrize(("width", "tolerance"), [("0.8 mm", 2e-5), ("2 mm", 2e-4)])
def test_the_line_of_an_idle_planar_is_that_of_rollers(width, tolerance):
    rollers, planar = pair(defect=SLOT | {"width": width})
    for line in ("velocity@BPFO", "velocity@2BPFO", "velocity@5BPFO"):
        assert planar.features[line] == pytest.approx(rollers.features[line], rel=tolerance)


def test_rotating_the_load_rotates_the_motion():
    """Healthy: load and rollers rotated by 0.5 rad give the same motion, rotated."""
    fields = {"model": "planar", "duration": "30 ms", "settle": "0 s"}
    expected = simulate(case(**fields)).velocity @ [1, 1j]
    rotated = {"load": 150 * cos(0.5), "load_across": 150 * sin(0.5), "start_angle": pi / 13 + 0.5}
    result = simulate(case(**fields, **rotated)).velocity @ [1, 1j] * np.exp(-0.5j)
    assert np.abs(result - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize(("speed", "falls"), [("395 rpm", True), ("430 rpm", False)])
def test_slow_rollers_fall_at_the_top(speed, falls):
    """An unloaded roller stays on the outer race where omega_c^2 r > g: from 407 rpm on."""
    record = [f"roller.{n}.outer_force" for n in (6, 7, 8)]
    fields = {"model": "planar", "gravity": True, "duration": "0.15 s", "settle": "0.4 s", "sampling": "2000 Hz"}
    lightest = min(values.min() for values in simulate(case(speed=speed, record=record, **fields)).series.values())
    weight = 9.80665 * case().bearing.element_mass
    assert lightest == 0.0 if falls else lightest > 0.1 * weight


SHAFT = {
    "model": "planar",
    "cage": {"guide": "rollers"},
    "drag": {},
    "shaft": {"stiffness": "5e7 N/m", "mass": "3 kg", "damping": "3000 N s/m"},
    "rig": {"ring_mass": "0.5 kg", "torsion_stiffness": "3e3 N m/rad", "torsion_damping": "2 N m s/rad"},
    "duration": "0.3 s",
    "settle": "0.1 s",
    "record": ["ring.velocity", "inner.displacement"],
}


def test_an_unbalance_is_a_line_at_the_shafts_speed():
    """As of two masses, shaft - inner ring - rollers - outer ring - bracket, at the mean stiffness: 1 %."""
    bearing_case = case(**SHAFT, unbalance={"mass_radius": "1e-4 kg m"})
    K, b, w = (
        healthy_equilibrium(bearing_case).K_x,
        assemble.geometry.build_bearing(bearing_case),
        bearing_case.speed,
    )
    stiffness = [[5e7 + K - 3.0 * w**2, -K], [-K, 1e7 + K - b.m_o * w**2]]
    _, ring = np.linalg.solve(stiffness, [1e-4 * w**2, 0.0])
    assert simulate(bearing_case).features["displacement@fr"] == pytest.approx(ring, rel=0.01)


def test_no_line_at_shaft_frequency_without_unbalance():
    assert simulate(case(**SHAFT)).features["displacement@fr"] < 2e-9


# vector lanes


@needs_vectors
@pytest.mark.parametrize(
    "fields", [SHAFT | {"friction": "static-dynamic"}, {"model": "planar", "friction": "traction"}]
)
def test_loops_over_rollers_keep_their_lanes(fields):
    model = assemble.model(case(**fields))
    y, n, method = assemble.empty_buffer(model), lanes(model.bearing), Verlet(1e-7)
    common = by_roller.shared_quantities(model, 0.0, y)
    assert keeps_lanes(compiled(by_roller.load_rollers.py_func), model, method, common, y, n)
    assert keeps_lanes(compiled(by_roller.accelerate_rollers.py_func), model, method, common, 0.0, y, n)
    assert keeps_lanes(compiled(plane.fill_roller_directions.py_func), 0.3, y, n)
