"""`planar` against the models below it, and what only it can do: turned loads, gravity, an unbalanced shaft."""

from math import cos, pi, sin

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble.rest import healthy_rest
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
"""What `planar` knows beyond `rollers` left idle."""


def pair(**given):
    """The same case in `rollers` and in an idle `planar`."""
    given = SHORT | {"method": "verlet"} | given
    return simulate(case(**given)), simulate(case(**given | IDLE))


LADDER = [
    ({}, 3e-4, 1e-4),
    ({"defect": SLOT}, 1e-4, 2e-4),
    ({"defect": SLOT | {"width": "2 mm"}}, 5e-3, 1e-3),
    ({"defect": SLOT | {"race": "inner"}}, 1e-4, 2e-4),
    ({"defect": SLOT | {"race": "roller", "roller": 2}}, 3e-3, 1e-3),
]


@pytest.mark.parametrize(("given", "anywhere", "rms"), LADDER)
def test_an_idle_planar_is_rollers(given, anywhere, rms):
    """Velocity along the load: at every instant, relative to its range, and its RMS.

    What is left is that the exact approach turns the force by u/r, and that a defect's edge also pushes the ring
    sideways: across the load line that is as much as all else.
    """
    below, above = pair(**given)
    gap = above.velocity - below.velocity
    assert np.abs(gap[:, 0]).max() < anywhere * np.ptp(below.velocity[:, 0])
    assert above.features["velocity.rms"] == pytest.approx(below.features["velocity.rms"], rel=rms)
    assert above.features["outer_force.max"] == pytest.approx(below.features["outer_force.max"], rel=5e-4)
    assert np.abs(gap).max() > 0.0


@pytest.mark.parametrize(("width", "off"), [("0.8 mm", 2e-5), ("2 mm", 2e-4)])
def test_the_line_of_an_idle_planar_is_that_of_rollers(width, off):
    below, above = pair(defect=SLOT | {"width": width})
    for line in ("velocity@BPFO", "velocity@2BPFO", "velocity@5BPFO"):
        assert above.features[line] == pytest.approx(below.features[line], rel=off)


def test_a_turned_load_is_a_turned_bearing():
    """Healthy: load and rollers turned by 0.5 rad give the same motion, turned."""
    given = {"model": "planar", "duration": "30 ms", "settle": "0 s"}
    straight = simulate(case(**given)).velocity @ [1, 1j]
    turned = {"load": 150 * cos(0.5), "load_across": 150 * sin(0.5), "start_angle": pi / 13 + 0.5}
    found = simulate(case(**given, **turned)).velocity @ [1, 1j] * np.exp(-0.5j)
    assert np.abs(found - straight).max() < 1e-7 * np.abs(straight).max()


@pytest.mark.parametrize(("speed", "falls"), [("395 rpm", True), ("430 rpm", False)])
def test_slow_rollers_fall_at_the_top(speed, falls):
    """An unloaded roller stays on the outer race where omega_c^2 r > g: from 407 rpm on."""
    record = [f"roller.{n}.outer_force" for n in (6, 7, 8)]
    given = {"model": "planar", "gravity": True, "duration": "0.15 s", "settle": "0.4 s", "sampling": "2000 Hz"}
    lightest = min(values.min() for values in simulate(case(speed=speed, record=record, **given)).series.values())
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
    given = case(**SHAFT, unbalance={"mass_radius": "1e-4 kg m"})
    K, b, w = healthy_rest(given).K_x, assemble.geometry.bearing(given), given.speed
    stiffness = [[5e7 + K - 3.0 * w**2, -K], [-K, 1e7 + K - b.m_o * w**2]]
    _, ring = np.linalg.solve(stiffness, [1e-4 * w**2, 0.0])
    assert simulate(given).features["displacement@fr"] == pytest.approx(ring, rel=0.01)


def test_without_unbalance_there_is_no_such_line():
    assert simulate(case(**SHAFT)).features["displacement@fr"] < 2e-9


# vector lanes


@needs_vectors
@pytest.mark.parametrize(
    "given", [SHAFT | {"friction": "static-dynamic"}, {"model": "planar", "friction": "traction"}]
)
def test_loops_over_rollers_keep_their_lanes(given):
    model = assemble.model(case(**given))
    y, n, motion = assemble.empty_buffer(model), lanes(model.bearing), Verlet(1e-7)
    at = by_roller.shared(model, 0.0, y)
    assert keeps_lanes(compiled(by_roller.load_rollers.py_func), model, motion, at, y, n)
    assert keeps_lanes(compiled(by_roller.accelerate_rollers.py_func), model, motion, at, 0.0, y, n)
    assert keeps_lanes(compiled(plane.roller_directions.py_func), 0.3, y, n)
