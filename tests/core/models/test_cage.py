"""Cage: kinematic speed, slip by drag, and its guides."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parts.cage import OilDrag, pocket_stiffness
from bearingsim.core.parts.cage_in_space import axial_stiffness
from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import SLOT, advance_recorded, case

RECORD = ["cage.slip", "cage.speed", "roller.cage_force"]
GUIDED_CAGE = {
    "model": "planar",
    "rig": {"ring_mass": "0.5 kg", "torsion_stiffness": "3e3 N m/rad", "torsion_damping": "2 N m s/rad"},
    "shaft": {"stiffness": "1e9 N/m", "mass": "3 kg", "damping": "3000 N s/m"},
    "drag": {},
}
"""Fields of a case with a guided cage and a stiff shaft."""
RAMP = {"ramp": {"to": "2400 rpm", "time": "5 ms"}, "friction": "traction"}
"""Without effect here: with it a ring-guided cage needs only code that other tests compile, too."""


def follow(model, y, seconds, cells):
    """Record the cells (cells, n) at every step of 0.4 us."""
    out = np.empty((len(cells), round(seconds / 4e-7)))
    assert advance_recorded(Verlet(4e-7), model, Monitor(8, 1.0), 0, y, np.array(cells), out)[1] == SUCCESS
    return out


@pytest.mark.parametrize("defect", [{}, {"defect": SLOT}])
def test_without_drag_the_cage_is_kinematic(defect):
    """Rollers scattered in their pockets, friction on: within 0.01 %."""
    run = simulate(case(model="planar", duration="0.2 s", settle="20 ms", seed=2, record=RECORD, **defect))
    assert np.abs(run.series["cage.slip"]).max() < 1e-4
    assert run.series["cage.speed"] == pytest.approx(case().speed * (1 - 12 / 65) / 2, rel=1e-4)


def test_without_friction_a_slot_makes_the_cage_slip():
    """The rollers hit the edges of a slot, and then their pockets."""
    frictionless = {"law": "static-dynamic", "static": "0", "dynamic": "0"}
    fields = {
        "model": "planar",
        "friction": frictionless,
        "duration": "0.1 s",
        "settle": "50 ms",
        "record": RECORD,
    }
    assert np.abs(simulate(case(**fields)).series["cage.slip"]).max() < 1e-4
    assert np.abs(simulate(case(**fields, defect=SLOT)).series["cage.slip"]).max() > 1e-3


def test_a_slow_cage_returns_to_its_kinematic_speed():
    """2 % too slow, the cage hits its rollers, whose friction accelerates it within 0.12 s."""
    model = assemble.model(case(model="planar"))
    y, _ = assemble.start(case(model="planar"), model)
    y[lay.VELOCITY + lay.PHI_C] = -0.02 * model.bearing.omega_c
    start_at_rest(model, 0.0, y)
    speed, _ = follow(model, y, 0.2, [lay.VELOCITY + lay.PHI_C, lay.POSITION + lay.PHI_C])
    slip = -speed / model.bearing.omega_c
    assert slip[0] == pytest.approx(0.02, rel=1e-3)
    assert np.abs(slip[round(0.12 / 4e-7) :]).max() < 1e-4


@pytest.mark.parametrize(("clearance", "slip"), [("0.05 mm", 0.070e-2), ("0.2 mm", 0.23e-2)])
def test_drag_delays_the_cage_by_a_clearance_each_turn(clearance, slip):
    """Unloaded rollers lag in their pockets, loaded ones lead: each crosses its pocket within the loaded arc.

    That is some 90 mm here, half of the pitch circle less a roller or two: a slip of 0.06 and 0.22 %.
    """
    run = simulate(
        case(
            model="planar",
            drag={},
            cage={"pocket_clearance": clearance},
            seed=1,
            duration="0.3 s",
            settle="0.1 s",
            record=RECORD,
        )
    )
    assert run.features["cage.slip.mean"] == pytest.approx(slip, rel=0.1)
    assert np.abs(run.series["roller.cage_force"]).max() > 0.5


# guides


def cage_acceleration(guide, offset, **cage):
    """Return the acceleration (complex, m/s^2) of a cage of 0.05 kg displaced by ``offset`` (complex, m)."""
    fields = {"pocket_clearance": "2 mm", "friction": {"static": "0", "dynamic": "0"}, "mass": "50 g"}
    bearing_case = case(
        **GUIDED_CAGE, cage={"guide": guide} | fields | cage, **({} if guide == "rollers" else RAMP)
    )
    model = assemble.model(bearing_case)
    y, _ = assemble.start(bearing_case, model)
    y[lay.POSITION + lay.X_C], y[lay.POSITION + lay.Y_C] = offset.real, offset.imag
    start_at_rest(model, 0.0, y)
    return complex(y[lay.ACCELERATION + lay.X_C], y[lay.ACCELERATION + lay.Y_C])


@pytest.mark.parametrize("guide", ["inner-ring", "outer-ring"])
@pytest.mark.parametrize("direction", [1.0, -1.0j, np.exp(2.5j)])
def test_a_ring_pushes_the_cage_back_beyond_the_play(guide, direction):
    """0.2 mm of 0.4 mm, then 1e7 N/m; the ring itself is displaced by up to 0.4 um."""
    assert abs(cage_acceleration(guide, 1.98e-4 * direction)) == 0.0
    restoring = -cage_acceleration(guide, 2.5e-4 * direction) / direction
    assert restoring.real == pytest.approx(1e7 * 0.5e-4 / 0.05, rel=0.01)
    assert abs(restoring.imag) < 0.01 * restoring.real


@pytest.mark.parametrize("direction", [1.0, -1.0j, np.exp(2.5j)])
def test_rollers_push_the_cage_back_beyond_the_play(direction):
    """Their pockets stop it radially after 0.1 mm, each with 1e7 N/m of what is along it."""
    radial = {"radial_pocket_clearance": "0.2 mm"}
    assert abs(cage_acceleration("rollers", 0.98e-4 * direction, **radial)) == 0.0
    angle = np.pi / 13 + 2 * np.pi * np.arange(13) / 13
    penetration = np.maximum(np.abs(2e-4 * np.cos(angle - np.angle(direction))) - 1e-4, 0.0)
    expected = (1e7 * penetration * np.abs(np.cos(angle - np.angle(direction)))).sum() / 0.05
    restoring = -cage_acceleration("rollers", 2e-4 * direction, **radial) / direction
    assert restoring.real == pytest.approx(expected, rel=0.02)
    assert abs(restoring.imag) < 0.2 * restoring.real


@pytest.mark.parametrize("speed", ["600 rpm", "1800 rpm"])
def test_a_heavy_cage_hangs_on_its_rollers(speed):
    """Without drag it comes to rest within its radial play below the middle: gravity pulls along e_0."""
    bearing_case = case(**GUIDED_CAGE, cage={"guide": "rollers"}, gravity=True, speed=speed)
    model = assemble.model(bearing_case)._replace(drag=OilDrag(0.0, 0.0, 1.0))
    y, _ = assemble.start(bearing_case, model)
    u_x, u_y = follow(model, y, 0.2, [lay.POSITION + lay.X_C, lay.POSITION + lay.Y_C])
    assert np.hypot(u_x, u_y).max() < 1.1e-4
    half = len(u_x) // 2
    assert 0.8e-4 < u_x[half:].mean() < 1.05e-4
    assert abs(u_y[half:].mean()) < 0.5e-4


def test_a_weightless_cage_stays_in_the_middle():
    bearing_case = case(**GUIDED_CAGE, cage={"guide": "rollers"})
    model = assemble.model(bearing_case)._replace(drag=OilDrag(0.0, 0.0, 1.0))
    y, _ = assemble.start(bearing_case, model)
    assert np.abs(follow(model, y, 0.02, [lay.POSITION + lay.X_C, lay.POSITION + lay.Y_C])).max() < 1e-8


def stiffest_rate(pushes, masses):
    """Largest eigenvalue (1/s^2) of springs of 1e7 N/m; pushes: (springs, coordinates), their stretch by each."""
    scaled = pushes / np.sqrt(masses)
    return float(np.linalg.eigvalsh(1e7 * scaled.T @ scaled).max())


@pytest.mark.parametrize(("guide", "moves"), [("centred", 0.0), ("outer-ring", 1.0)])
def test_all_rollers_pushing_the_cage_limit_the_step(guide, moves):
    """Walls of all pockets: 13 rollers along the race; rotation of the cage, and its centre if it is free."""
    model = assemble.model(case(model="planar", cage={"guide": guide, "mass": "20 g"}))
    m_r, angle = model.bearing.m_r, 2 * np.pi * np.arange(13) / 13
    of_cage = np.stack([np.ones(13), -moves * np.sin(angle), moves * np.cos(angle)], axis=1)
    expected = stiffest_rate(np.hstack([np.eye(13), -of_cage]), np.r_[np.full(13, m_r), 0.02, 0.02, 0.02])
    assert pocket_stiffness(model.cage, 1.0 / m_r, 13) == pytest.approx(expected, rel=1e-9)


def test_all_rollers_pushing_the_cage_axially_limit_the_step():
    """Ends of all pockets: 13 rollers along the axis; the cage's axial motion, and its tilt about two axes."""
    model = assemble.model(case(model="spatial", cage={"mass": "20 g"}))
    m_r, angle, r = model.bearing.m_r, 2 * np.pi * np.arange(13) / 13, 0.0325
    of_cage = np.stack([np.ones(13), r * np.cos(angle), r * np.sin(angle)], axis=1)
    masses = np.r_[np.full(13, m_r), 0.02, model.cage_z.I_t, model.cage_z.I_t]
    expected = stiffest_rate(np.hstack([np.eye(13), -of_cage]), masses)
    assert axial_stiffness(model.cage_z, model.cage, 1.0 / m_r, 13) == pytest.approx(expected, rel=1e-9)
