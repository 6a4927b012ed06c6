"""The cage: it follows the rollers, drag holds it back, its guide holds it up."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parts.cage import OilDrag
from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import SLOT, advance_recorded, case

RECORD = ["cage.slip", "cage.speed", "roller.cage_force"]
STILL = {
    "model": "planar",
    "rig": {"ring_mass": "0.5 kg", "torsion_stiffness": "3e3 N m/rad", "torsion_damping": "2 N m s/rad"},
    "shaft": {"stiffness": "1e9 N/m", "mass": "3 kg", "damping": "3000 N s/m"},
    "drag": {},
}
"""The kind of case in which a cage is guided, with a shaft that hardly gives way."""
ON_A_RAMP = {"ramp": {"to": "2400 rpm", "time": "5 ms"}, "friction": "traction"}
"""Of no account here: with them a ring-guided cage is in a bearing that other tests compile anyway."""


def follow(model, y, seconds, places):
    """Recording (places, n) at every step of 0.4 us."""
    out = np.empty((len(places), round(seconds / 4e-7)))
    assert advance_recorded(Verlet(4e-7), model, Monitor(8, 1.0), 0, y, np.array(places), out)[1] == SUCCESS
    return out


@pytest.mark.parametrize("defect", [{}, {"defect": SLOT}])
def test_without_drag_the_cage_is_kinematic(defect):
    """Rollers scattered in their pockets, friction on: within 0.01 %."""
    run = simulate(case(model="planar", duration="0.2 s", settle="20 ms", seed=2, record=RECORD, **defect))
    assert np.abs(run.series["cage.slip"]).max() < 1e-4
    assert run.series["cage.speed"] == pytest.approx(case().speed * (1 - 12 / 65) / 2, rel=1e-4)


def test_without_friction_nothing_holds_the_rollers_to_that():
    """The edges of a slot knock them about, and they the cage."""
    smooth = {"law": "static-dynamic", "static": "0", "dynamic": "0"}
    given = {"model": "planar", "friction": smooth, "duration": "0.1 s", "settle": "50 ms", "record": RECORD}
    assert np.abs(simulate(case(**given)).series["cage.slip"]).max() < 1e-4
    assert np.abs(simulate(case(**given, defect=SLOT)).series["cage.slip"]).max() > 1e-3


def test_a_cage_that_is_knocked_comes_back():
    """2 % too slow, it hits its rollers, which friction keeps rolling: within 0.12 s they have it back."""
    model = assemble.model(case(model="planar"))
    y, _ = assemble.start(case(model="planar"), model)
    y[lay.VELOCITY + lay.PHI_C] = -0.02 * model.bearing.omega_c
    start_at_rest(model, 0.0, y)
    beyond, _ = follow(model, y, 0.2, [lay.VELOCITY + lay.PHI_C, lay.POSITION + lay.PHI_C])
    slip = -beyond / model.bearing.omega_c
    assert slip[0] == pytest.approx(0.02, rel=1e-3)
    assert np.abs(slip[round(0.12 / 4e-7) :]).max() < 1e-4


@pytest.mark.parametrize(("clearance", "slip"), [("0.05 mm", 0.070e-2), ("0.2 mm", 0.23e-2)])
def test_drag_holds_the_cage_back_by_a_clearance_each_turn(clearance, slip):
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


def pushed(guide, off, **cage):
    """Acceleration (complex, m/s^2) of a cage of 0.05 kg that stands ``off`` its place (complex, m)."""
    wide = {"pocket_clearance": "2 mm", "friction": {"static": "0", "dynamic": "0"}, "mass": "50 g"}
    given = case(**STILL, cage={"guide": guide} | wide | cage, **({} if guide == "rollers" else ON_A_RAMP))
    model = assemble.model(given)
    y, _ = assemble.start(given, model)
    y[lay.POSITION + lay.X_C], y[lay.POSITION + lay.Y_C] = off.real, off.imag
    start_at_rest(model, 0.0, y)
    return complex(y[lay.ACCELERATION + lay.X_C], y[lay.ACCELERATION + lay.Y_C])


@pytest.mark.parametrize("guide", ["inner-ring", "outer-ring"])
@pytest.mark.parametrize("way", [1.0, -1.0j, np.exp(2.5j)])
def test_a_ring_pushes_the_cage_back_beyond_the_play(guide, way):
    """0.2 mm of 0.4 mm, then 1e7 N/m; the ring itself stands up to 0.4 um off."""
    assert abs(pushed(guide, 1.98e-4 * way)) == 0.0
    back = -pushed(guide, 2.5e-4 * way) / way
    assert back.real == pytest.approx(1e7 * 0.5e-4 / 0.05, rel=0.01)
    assert abs(back.imag) < 0.01 * back.real


@pytest.mark.parametrize("way", [1.0, -1.0j, np.exp(2.5j)])
def test_rollers_push_the_cage_back_beyond_the_play(way):
    """Their pockets stop it radially after 0.1 mm, each with 1e7 N/m of what is along it."""
    radial = {"radial_pocket_clearance": "0.2 mm"}
    assert abs(pushed("rollers", 0.98e-4 * way, **radial)) == 0.0
    angle = np.pi / 13 + 2 * np.pi * np.arange(13) / 13
    beyond = np.maximum(np.abs(2e-4 * np.cos(angle - np.angle(way))) - 1e-4, 0.0)
    by_hand = (1e7 * beyond * np.abs(np.cos(angle - np.angle(way)))).sum() / 0.05
    back = -pushed("rollers", 2e-4 * way, **radial) / way
    assert back.real == pytest.approx(by_hand, rel=0.02)
    assert abs(back.imag) < 0.2 * back.real


@pytest.mark.parametrize("speed", ["600 rpm", "1800 rpm"])
def test_a_heavy_cage_hangs_on_its_rollers(speed):
    """Without drag it comes to rest within its radial play below the middle: gravity pulls along e_0."""
    given = case(**STILL, cage={"guide": "rollers"}, gravity=True, speed=speed)
    model = assemble.model(given)._replace(drag=OilDrag(0.0, 0.0, 1.0))
    y, _ = assemble.start(given, model)
    x, z = follow(model, y, 0.2, [lay.POSITION + lay.X_C, lay.POSITION + lay.Y_C])
    assert np.hypot(x, z).max() < 1.1e-4
    half = len(x) // 2
    assert 0.8e-4 < x[half:].mean() < 1.05e-4
    assert abs(z[half:].mean()) < 0.5e-4


def test_a_weightless_cage_stays_in_the_middle():
    given = case(**STILL, cage={"guide": "rollers"})
    model = assemble.model(given)._replace(drag=OilDrag(0.0, 0.0, 1.0))
    y, _ = assemble.start(given, model)
    assert np.abs(follow(model, y, 0.02, [lay.POSITION + lay.X_C, lay.POSITION + lay.Y_C])).max() < 1e-8
