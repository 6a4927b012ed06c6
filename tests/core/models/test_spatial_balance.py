"""`spatial` against mechanics: momentum, angular momentum and power at any state.

The bodies are in `tests/independent/spatial_bodies.py`, the forces on them and all sums in `spatial_sums.py`.
"""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.pairs import ANGLE, RADIUS
from bearingsim.core.geometry.slices import make_slices, slice_edges
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.laws.stiffness.power_laws import Linear
from bearingsim.core.parts.cage_in_space import CageInSpace
from bearingsim.core.parts.flanges import Flanges
from bearingsim.core.parts.form import UnequalRollers
from bearingsim.core.parts.mounts import ElasticMount
from tests.core.models.test_planar_balance import ALL_EFFECTS, BALANCE_TIME, CAGE_FRICTION, RAMP, rate
from tests.core.models.test_planar_balance import SETUPS as PLANAR_SETUPS
from tests.core.models.test_planar_balance import random_state as planar_state
from tests.independent import spatial_bodies as bodies
from tests.independent import spatial_sums
from tests.scenes.nf308 import SLOT, case
from tests.scenes.spatial_bearing import L_W, empty, spatial_model

DEFECT = SLOT | {"width": "0.3 mm"}
REACH = ((-0.1e-3, 5e-3), (-6e-3, 1e-3), (1e-3, 4e-3), (1e-3, 4e-3))
"""Ends (m) along the roller of the defect of each roller-defect pair."""
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
FORM = "between surfaces with form"
SETUPS = {
    "on rollers": {"cage": {"guide": "rollers", "friction": CAGE_FRICTION}, "drag": {"land": "outer"}},
    "on a ramp": {"cage": {"guide": "rollers", "friction": CAGE_FRICTION}, "drag": {"land": "inner"}} | RAMP,
    FORM: PLANAR_SETUPS[FORM],
}


def model_of(setup):
    """Return a model with all effects."""
    defects = [DEFECT, DEFECT | {"race": "inner"}, DEFECT | {"race": "roller", "roller": 5}]
    model = assemble.model(case(**ALL_EFFECTS | {"defects": defects}, **SETUPS[setup]))
    slicing = make_slices(slice_edges(L_W, REACH, 9), lambda z: 2e-6 * (2 * z / L_W) ** 2)
    inertia = model.bracket.inertia
    return spatial_model(
        model,
        slicing,
        REACH,
        mount_o=ElasticMount(model.bearing.m_o, inertia, 0.6 * inertia, 2e7, 100.0, 5e4, 2.0, 3e-4, -2e-4),
        mount_i=ElasticMount(model.shaft.m, 2e-3, 5e-3, 3e7, 200.0, 8e4, 3.0, -1e-4, 4e-4),
        flanges=FLANGES,
        cage_z=CageInSpace(0.55 * model.cage.inertia, 2e-5, HuntCrossley(Linear(1e7), 10.0)),
    )


def random_state(model, seed, tilt):
    """Return a buffer far from equilibrium, with axes tilted by about ``tilt`` (rad)."""
    rng, n = np.random.default_rng(seed + 100), model.bearing.Z
    y = empty(model)
    y[: lay.BUFFER_SIZE] = planar_state_of(model, seed)
    for row, size in ((lay.AXIAL, 1.5e-5), (lay.AXIAL_V, 1e-2), (lay.AXIS_X, tilt), (lay.AXIS_X_V, 1e3 * tilt)):
        for offset in (0, lay.ROW) if row in (lay.AXIS_X, lay.AXIS_X_V) else (0,):
            y[row + offset : row + offset + n] = rng.normal(0.0, size, n)
    for block, axial, tilt_size in ((lay.POSITION, 2e-5, tilt), (lay.VELOCITY, 1e-2, 300 * tilt)):
        y[block + lay.Z : block + lay.Z + 3] = rng.normal(0.0, axial, 3)
        for row in (1, 2):
            y[block + lay.Z + row * lay.ROW : block + lay.Z + row * lay.ROW + 3] = rng.normal(0.0, tilt_size, 3)
    return y


def planar_state_of(model, seed):
    """Return a random state of the planar model of the same bearing."""
    bearing_case = case(model="planar")
    planar = assemble.model(bearing_case)
    assert planar.bearing.Z == model.bearing.Z
    y = planar_state(planar, seed)
    assert len(y) == lay.BUFFER_SIZE
    return y


def align_defects(model, y, outwards, on_own_defect):
    """Move defects under rollers 4 and 8 and load these; that of roller 5 out, in, or off its contacts."""
    for j, q in ((3, 1e-5), (7, -1e-5), (4, 1e-5 if outwards else -1e-5)):
        y[lay.RADIAL + j] = q
    s = bodies_at(model, y)
    head = model.defects.head
    head[:, ANGLE] = 4e-5 / head[:, RADIUS]
    for d, ring, j in ((0, s.ring, 3), (1, s.inner, 7)):
        head[d, ANGLE] += ring.angle_of(s.rollers.centre[:, j] - ring.centre)[0]
    roller = bodies.Body(*(values[:, 4] for values in s.rollers))
    outermost = roller.angle_of(roller.centre)[0] - model.bearing.theta_0 - 2 * pi * 4 / model.bearing.Z
    head[2:, ANGLE] += outermost + (0.0 if outwards else pi) + (0.0 if on_own_defect else pi / 2)


def bodies_at(model, y):
    """Return the bodies of a buffer."""
    return bodies.scene(model, np.array([BALANCE_TIME]), y[bodies.state_rows(model.bearing.Z)][:, np.newaxis])


def round_rollers(rollers):
    """Return unwaved rollers of the same diameters."""
    return UnequalRollers(np.ascontiguousarray(rollers.pieces[:, 0].mean(axis=0)))


def random_contact_state(setup, seed, tilt, on_own_defect):
    """Return a model and a random state with all contacts closed and accelerations filled in."""
    model = model_of(setup)
    if setup == FORM and not on_own_defect:  # waves of a roller are exact to first order, too
        model = model._replace(form=model.form._replace(rollers=round_rollers(model.form.rollers)))
    y = random_state(model, seed, tilt)
    align_defects(model, y, seed % 2 == 0, on_own_defect)
    start_at_rest(model, BALANCE_TIME, y)
    return model, y


def balances_ahead(model, y, h=2e-8):
    """Return the balances at five states along the motion from ``y``, and their time step (s)."""
    cells = bodies.state_rows(model.bearing.Z)
    velocities = cells[len(cells) // 2 :]
    slope = np.concatenate([y[velocities], y[velocities + lay.ACCELERATION - lay.VELOCITY]])
    ahead = h * np.arange(-2, 3)
    states = y[cells][:, np.newaxis] + ahead * slope[:, np.newaxis]
    return spatial_sums.balance(bodies.scene(model, BALANCE_TIME + ahead, states)), h


STATES = [(1e-5, True), (2e-3, False)]
"""Tilt of the axes (rad), and if a roller is on its own defect, whose position is exact to first order."""


def driven(model, y):
    """Return the balances about ``y``, their time step (s), the torque error (N m), and the drive torque (N m)."""
    balance, h = balances_ahead(model, y)
    torque_error = rate(balance.spin, h) - balance.torque[2]
    inner = bodies_at(model, y).inner
    drive_torque = torque_error @ inner.axis[0]
    return balance, h, torque_error - drive_torque * inner.axis[0], drive_torque


@pytest.mark.parametrize("setup", SETUPS)
def test_every_effect_acts_in_the_random_states(setup):
    """Each defect, over a part of the rollers; pockets, flanges; some slices of the rollers unloaded."""
    for seed in range(4):
        _, y = random_contact_state(setup, seed, *STATES[0])
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
        _, y = random_contact_state(setup, seed, *STATES[1])
        assert min(abs(y[lay.DEFECT_FORCE_O + 3]), abs(y[lay.DEFECT_FORCE_I + 7])) > 0.5
        loads = np.array([y[lay.slice_row(k, lay.LOAD_O) : lay.slice_row(k, lay.LOAD_O) + 13] for k in range(9)])
        assert ((loads > 0.0).any(axis=0) & (loads == 0.0).any(axis=0)).sum() > 5


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize(("tilt", "on_own_defect"), STATES)
@pytest.mark.parametrize("seed", range(4))
def test_momentum_balances_at_any_state(setup, seed, tilt, on_own_defect):
    """Linear and angular momentum change by the external forces, to 1e-12 of the contact forces.

    The torque of the inner ring's drive along its axis is unknown here; the power balance includes it.
    """
    model, y = random_contact_state(setup, seed, tilt, on_own_defect)
    balance, h, torque_error, _ = driven(model, y)
    contact_force = y[lay.Q_O : lay.Q_O + 13].sum() + y[lay.Q_I : lay.Q_I + 13].sum()
    assert np.abs(rate(balance.momentum, h) - balance.force[2]).max() < 1e-12 * contact_force
    assert np.abs(torque_error).max() < 1e-12 * contact_force * model.bearing.R_o
    assert np.abs(rate(balance.spin, h)).min() > 1e-6 * contact_force * model.bearing.R_o


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize(("tilt", "on_own_defect"), STATES)
@pytest.mark.parametrize("seed", range(4))
def test_power_balances_at_any_state(setup, seed, tilt, on_own_defect):
    """The energy of all bodies, contacts and springs changes by power supplied less dissipated, within 3e-9."""
    model, y = random_contact_state(setup, seed, tilt, on_own_defect)
    balance, h, _, drive_torque = driven(model, y)
    power = balance.power[2] + drive_torque * bodies_at(model, y).inner.spin()[0]
    assert balance.lost[2] > 100.0
    assert rate(balance.energy, h) == pytest.approx(
        power - balance.lost[2], abs=3e-9 * (abs(power) + balance.lost[2])
    )
