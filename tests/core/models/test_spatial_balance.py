"""`spatial` against mechanics: momentum, angular momentum and power at any state.

The bodies, and what acts on them, are `tests/independent/spatial_bodies.py`.
"""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.pairs import ANGLE, RADIUS
from bearingsim.core.geometry.slices import slice_edges, slices
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.laws.stiffness.power_laws import Linear
from bearingsim.core.parts.cage_in_space import CageInSpace
from bearingsim.core.parts.flanges import Flanges
from bearingsim.core.parts.mounts import ElasticMount
from tests.core.models.test_planar_balance import EVERYTHING, RUBBING, SPEEDING, WHERE, rate
from tests.core.models.test_planar_balance import random_state as planar_state
from tests.independent import spatial_bodies as bodies
from tests.scenes.nf308 import SLOT, case
from tests.scenes.spatial_bearing import L_W, empty, spatial_model

DEFECT = SLOT | {"width": "0.3 mm"}
REACH = ((-0.1e-3, 5e-3), (-6e-3, 1e-3), (1e-3, 4e-3), (1e-3, 4e-3))
"""From where to where (m) along the roller each meeting's defect reaches."""
FLANGES = Flanges(
    inner_minus=1.0,
    inner_plus=1.0,
    outer_minus=1.0,
    outer_plus=1.0,
    play=1e-5,
    height=1.5e-3,
    law=HuntCrossley(Linear(5e7), 5.0),
    friction=StaticDynamic(0.1, 0.05, 1.0, 20.0),
)
WAYS = {
    "on rollers": {"cage": {"guide": "rollers", "friction": RUBBING}, "drag": {"land": "outer"}},
    "on a ramp": {"cage": {"guide": "rollers", "friction": RUBBING}, "drag": {"land": "inner"}} | SPEEDING,
}


def model_of(way):
    """A model in which all that can act does."""
    defects = [DEFECT, DEFECT | {"race": "inner"}, DEFECT | {"race": "roller", "roller": 5}]
    model = assemble.model(case(**EVERYTHING | {"defects": defects}, **WAYS[way]))
    cut = slices(slice_edges(L_W, REACH, 9), lambda z: 2e-6 * (2 * z / L_W) ** 2)
    inertia = model.bracket.inertia
    return spatial_model(
        model,
        cut,
        REACH,
        mount_o=ElasticMount(model.bearing.m_o, inertia, 0.6 * inertia, 2e7, 100.0, 5e4, 2.0, 3e-4, -2e-4),
        mount_i=ElasticMount(model.shaft.m, 2e-3, 5e-3, 3e7, 200.0, 8e4, 3.0, -1e-4, 4e-4),
        flanges=FLANGES,
        cage_z=CageInSpace(0.55 * model.cage.inertia, 2e-5, HuntCrossley(Linear(1e7), 10.0)),
    )


def random_state(model, seed, lean):
    """A buffer far from rest, with axes that lean by some ``lean`` (rad)."""
    random, n = np.random.default_rng(seed + 100), model.bearing.Z
    y = empty(model)
    y[: lay.BUFFER_SIZE] = planar_state_of(model, seed)
    for row, size in ((lay.AXIAL, 1.5e-5), (lay.AXIAL_V, 1e-2), (lay.AXIS_X, lean), (lay.AXIS_X_V, 1e3 * lean)):
        for other in (0, lay.ROW) if row in (lay.AXIS_X, lay.AXIS_X_V) else (0,):
            y[row + other : row + other + n] = random.normal(0.0, size, n)
    for block, axial, lean_by in ((lay.POSITION, 2e-5, lean), (lay.VELOCITY, 1e-2, 300 * lean)):
        y[block + lay.Z : block + lay.Z + 3] = random.normal(0.0, axial, 3)
        for row in (1, 2):
            y[block + lay.Z + row * lay.ROW : block + lay.Z + row * lay.ROW + 3] = random.normal(0.0, lean_by, 3)
    return y


def planar_state_of(model, seed):
    """What `planar`'s tests shake, of a planar model of the same bearing."""
    given = case(model="planar")
    flat = assemble.model(given)
    assert flat.bearing.Z == model.bearing.Z
    y = planar_state(flat, seed)
    assert len(y) == lay.BUFFER_SIZE
    return y


def lead_onto_defects(model, y, outwards, own):
    """Turn defects under rollers 4 and 8 and press these on them; roller 5's out, in, or away (not ``own``)."""
    for j, q in ((3, 1e-5), (7, -1e-5), (4, 1e-5 if outwards else -1e-5)):
        y[lay.RADIAL + j] = q
    s = now(model, y)
    head = model.defects.head
    head[:, ANGLE] = 4e-5 / head[:, RADIUS]
    for d, ring, j in ((0, s.ring, 3), (1, s.inner, 7)):
        head[d, ANGLE] += ring.angle_of(s.rollers.at[:, j] - ring.at)[0]
    roller = bodies.Body(*(part[:, 4] for part in s.rollers))
    outermost = roller.angle_of(roller.at)[0] - model.bearing.theta_0 - 2 * pi * 4 / model.bearing.Z
    head[2:, ANGLE] += outermost + (0.0 if outwards else pi) + (0.0 if own else pi / 2)


def now(model, y):
    """The bodies of a buffer."""
    return bodies.scene(model, np.array([WHERE]), y[bodies.places(model.bearing.Z)][:, np.newaxis])


def shaken(way, seed, lean, own):
    """A model, and a buffer at a random state with everything in contact and accelerations filled in."""
    model = model_of(way)
    y = random_state(model, seed, lean)
    lead_onto_defects(model, y, seed % 2 == 0, own)
    start_at_rest(model, WHERE, y)
    return model, y


def leaving(model, y, h=2e-8):
    """Balances at five states on the line along which ``y`` is leaving, and their distance (s)."""
    at = bodies.places(model.bearing.Z)
    velocities = at[len(at) // 2 :]
    slope = np.concatenate([y[velocities], y[velocities + lay.ACCELERATION - lay.VELOCITY]])
    ahead = h * np.arange(-2, 3)
    line = y[at][:, np.newaxis] + ahead * slope[:, np.newaxis]
    return bodies.balance(bodies.scene(model, WHERE + ahead, line)), h


STATES = [(1e-5, True), (2e-3, False)]
"""Tilt of the axes (rad), and if a roller stands on its own defect, whose position is exact to first order."""


def driven(model, y):
    """Balances about ``y``, their distance (s), what is missing of the torque (N m), the drive's part of it."""
    found, h = leaving(model, y)
    missing = rate(found.spin, h) - found.torque[2]
    inner = now(model, y).inner
    drive = missing @ inner.axis[0]
    return found, h, missing - drive * inner.axis[0], drive


@pytest.mark.parametrize("way", WAYS)
def test_in_the_states_below_everything_acts(way):
    """Each defect, over a part of the rollers; pockets, flanges; slices at both ends of a roller part unloaded."""
    for seed in range(4):
        _, y = shaken(way, seed, *STATES[0])
        assert (
            min(
                abs(y[lay.DEFECT_FORCE_O + 3]),
                abs(y[lay.DEFECT_FORCE_I + 7]),
                abs(y[(lay.DEFECT_FORCE_I if seed % 2 else lay.DEFECT_FORCE_O) + 4]),
            )
            > 0.5
        )
        assert (np.abs(y[lay.Q_F : lay.Q_F + 13]) > 1.0).sum() > 5
        assert (np.abs(y[lay.Q_P : lay.Q_P + 13]) > 1.0).sum() > 3
        _, y = shaken(way, seed, *STATES[1])
        assert min(abs(y[lay.DEFECT_FORCE_O + 3]), abs(y[lay.DEFECT_FORCE_I + 7])) > 0.5
        loads = np.array([y[lay.slice_row(k, lay.LOAD_O) : lay.slice_row(k, lay.LOAD_O) + 13] for k in range(9)])
        assert ((loads > 0.0).any(axis=0) & (loads == 0.0).any(axis=0)).sum() > 5


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("lean", "own"), STATES)
@pytest.mark.parametrize("seed", range(4))
def test_momentum_balances_at_any_state(way, seed, lean, own):
    """Linear and angular, in space: all bodies together feel what acts from outside, to 1e-12 of the forces.

    What the drive of the inner ring adds along its axis is not known here; the power below holds it.
    """
    model, y = shaken(way, seed, lean, own)
    found, h, missing, _ = driven(model, y)
    between = y[lay.Q_O : lay.Q_O + 13].sum() + y[lay.Q_I : lay.Q_I + 13].sum()
    assert np.abs(rate(found.momentum, h) - found.force[2]).max() < 1e-12 * between
    assert np.abs(missing).max() < 1e-12 * between * model.bearing.R_o
    assert np.abs(rate(found.spin, h)).min() > 1e-6 * between * model.bearing.R_o


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("lean", "own"), STATES)
@pytest.mark.parametrize("seed", range(4))
def test_power_balances_at_any_state(way, seed, lean, own):
    """The energy of all bodies, contacts and springs grows by what is put in less what is lost, within 3e-9."""
    model, y = shaken(way, seed, lean, own)
    found, h, _, drive = driven(model, y)
    power = found.power[2] + drive * now(model, y).inner.spin()[0]
    assert found.lost[2] > 100.0
    assert rate(found.energy, h) == pytest.approx(power - found.lost[2], abs=3e-9 * (abs(power) + found.lost[2]))
