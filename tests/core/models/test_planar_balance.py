"""`planar` against mechanics: momentum, torque and power, at any state and along a motion.

The bodies are in `tests/independent/planar_bodies.py`, the forces on them and all sums in `planar_sums.py`.
"""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.pairs import ANGLE, RADIUS
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.parts.cage import RingGuided
from tests.independent import planar_bodies as bodies
from tests.independent import planar_sums
from tests.scenes.nf308 import SLOT, case
from tests.scenes.planar_runs import balances, energy_error, orders, record_run, start_planar

BALANCE_TIME = 2e-3  # s: time of the balances at random states
NARROW = SLOT | {"width": "0.3 mm", "length": "8 mm"}
ALL_EFFECTS = {
    "model": "planar",
    "defects": [NARROW, NARROW | {"race": "inner"}, NARROW | {"race": "roller", "roller": 5}],
    "load_across": "60 N",
    "gravity": True,
    "shaft": {"stiffness": "5e7 N/m", "mass": "3 kg", "damping": "300 N s/m"},
    "unbalance": {"mass_radius": "1e-2 kg m", "angle": "40 deg"},
    "rig": {"ring_mass": "0.5 kg", "torsion_stiffness": "3e3 N m/rad", "torsion_damping": "2 N m s/rad"},
    "contact": {"damping": {"chi": "5 s/m"}},
}
"""Fields of a case with all effects."""
RAMP = {"ramp": {"to": "2400 rpm", "time": "5 ms"}, "friction": "traction"}
CAGE_FRICTION = {"static": "0.2", "dynamic": "0.1", "static_speed": "2 m/s", "dynamic_speed": "8 m/s"}
"""Friction of the cage that depends on the slip at all its sliding speeds."""
SETUPS = {
    "on rollers": {"cage": {"guide": "rollers", "friction": CAGE_FRICTION}, "drag": {"land": "outer"}},
    "on the outer ring": {"cage": {"guide": "outer-ring", "friction": CAGE_FRICTION}, "drag": {"land": "inner"}}
    | RAMP,
    "on the inner ring": {"cage": {"guide": "inner-ring", "friction": CAGE_FRICTION}, "drag": {"land": "outer"}}
    | RAMP,
}


def random_state(model, seed):
    """Return a buffer far from equilibrium: micrometres and cm/s at the races, the cage beyond its play."""
    rng, Z = np.random.default_rng(seed), model.bearing.Z
    y = assemble.empty_buffer(model)
    for row, size in (
        (lay.RADIAL, 3e-6),
        (lay.RADIAL_V, 2e-2),
        (lay.EPS, 3e-3),
        (lay.EPS_V, 1.0),
        (lay.SPIN, 0.02),
        (lay.SPIN_V, 8.0),
    ):
        y[row : row + Z] = rng.normal(0.0, size, Z)
    for cell, size in ((lay.X, 2e-6), (lay.X_I, 2e-6), (lay.X_C, 1e-4)):
        y[lay.POSITION + cell : lay.POSITION + cell + 2] = rng.normal(0.0, size, 2)
        y[lay.VELOCITY + cell : lay.VELOCITY + cell + 2] = rng.normal(0.0, 2e-2, 2)
    y[lay.POSITION + lay.X_C] += 3e-4
    for cell in (lay.PSI, lay.PHI_C):
        y[lay.POSITION + cell], y[lay.VELOCITY + cell] = rng.normal(0.0, 1e-2), rng.normal(0.0, 3.0)
    return y


def align_defects(model, y, t, outwards):
    """Move the defects under rollers 4, 8 and 5, and load these; the last on the outer or the inner race."""
    for j, q in ((3, 1e-5), (7, -1e-5), (4, 1e-5 if outwards else -1e-5)):
        y[lay.RADIAL + j] = q
    scene = bodies_at(model, y, t)
    theta = np.angle(scene.rollers.centre[:, 0])
    head = model.defects.head
    head[:, ANGLE] = 4e-5 / head[:, RADIUS]
    head[0, ANGLE] += np.angle(scene.rollers.centre[3, 0] - scene.ring.centre[0]) - y[lay.POSITION + lay.PSI]
    head[1, ANGLE] += np.angle(scene.rollers.centre[7, 0] - scene.inner.centre[0]) - scene.inner.angle[0]
    angle = theta[4] - 2 * np.pi * 4 / model.bearing.Z - model.bearing.theta_0
    head[2:, ANGLE] += angle - scene.rollers.angle[4, 0] + (0.0 if outwards else np.pi)


def bodies_at(model, y, t):
    """Return the bodies of a buffer."""
    return bodies.scene(model, np.array([t]), y[bodies.state_rows(model.bearing.Z)][:, np.newaxis])


def random_contact_state(setup, seed, **fields):
    """Return a model and a random state with all contacts closed and accelerations filled in."""
    model = assemble.model(case(**ALL_EFFECTS, **SETUPS[setup], **fields))
    y = random_state(model, seed)
    align_defects(model, y, BALANCE_TIME, outwards=seed % 2 == 0)
    start_at_rest(model, BALANCE_TIME, y)
    return model, y


def balances_ahead(model, y):
    """Return the balances at five states along the motion from ``y``, and their time step (s)."""
    h, cells = 2e-8, bodies.state_rows(model.bearing.Z)
    velocities = cells[len(cells) // 2 :]
    slope = np.concatenate([y[velocities], y[velocities + lay.ACCELERATION - lay.VELOCITY]])
    ahead = h * np.arange(-2, 3)
    states = y[cells][:, np.newaxis] + ahead * slope[:, np.newaxis]
    return planar_sums.balance(bodies.scene(model, BALANCE_TIME + ahead, states)), h


def rate(values, h):
    """Return the derivative in the middle of five values, to fourth order."""
    return (8 * (values[3] - values[1]) - (values[4] - values[0])) / (12 * h)


SETUPS["between surfaces with form"] = SETUPS["on rollers"] | {
    "surfaces": {
        "outer": {"spectrum": {"amplitude": "2 um", "orders": [2, 60]}},
        "inner": {"spectrum": {"amplitude": "2 um", "orders": [2, 60]}},
        "rollers": {"diameter": {"scatter": "1 um"}, "spectrum": {"amplitude": "0.5 um", "orders": [2, 20]}},
    }
}


@pytest.mark.parametrize("setup", SETUPS)
def test_every_effect_acts_in_the_random_states(setup):
    """Each defect, the cage's guide, and pockets on both sides."""
    for seed in range(4):
        model, y = random_contact_state(setup, seed)
        assert abs(y[lay.DEFECT_FORCE_O + 3]) > 0.5
        assert abs(y[lay.DEFECT_FORCE_I + 7]) > 0.5
        assert abs(y[(lay.DEFECT_FORCE_I if seed % 2 else lay.DEFECT_FORCE_O) + 4]) > 0.5
        guide, s = model.cage.guide, bodies_at(model, y, BALANCE_TIME)
        if isinstance(guide, RingGuided):
            ring = s.ring if guide.outer else s.inner
            assert abs(s.cage.centre - ring.centre)[0] > guide.play
        else:
            radial = bodies.dot(
                np.exp(1j * bodies.pockets(model.bearing, s.cage.angle)), s.rollers.centre - s.cage.centre
            )
            assert (np.abs(radial - model.bearing.R_i - model.bearing.R_w) > guide.play).sum() > 3


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("seed", range(4))
def test_momentum_and_torque_balance_at_any_state(setup, seed):
    """The momentum of rings, rollers and cage changes by the external forces, to 1e-12 of the contact forces.

    The torque includes friction at the inner race, from slips accurate to 1e-12 m/s: 1e-11.
    """
    model, y = random_contact_state(setup, seed)
    balance, h = balances_ahead(model, y)
    contact_force = y[lay.Q_O : lay.Q_O + 13].sum() + y[lay.Q_I : lay.Q_I + 13].sum()
    assert abs(rate(balance.momentum, h) - balance.force[2]) < 1e-12 * contact_force
    assert abs(rate(balance.spin, h) - balance.torque[2]) < 1e-11 * contact_force * model.bearing.R_o


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("seed", range(4))
def test_power_balances_at_any_state(setup, seed):
    """The energy of all bodies, contacts and springs changes by power supplied less dissipated, within 1e-8."""
    model, y = random_contact_state(setup, seed)
    balance, h = balances_ahead(model, y)
    assert balance.lost[2] > 100.0
    assert rate(balance.energy, h) == pytest.approx(
        balance.power[2] - balance.lost[2], abs=1e-8 * (abs(balance.power[2]) + balance.lost[2])
    )


# along a motion


def test_energy_closes_in_a_healthy_bearing():
    """Damping and friction on: Verlet closes to second order, Runge-Kutta to fourth."""
    model, y = start_planar()
    verlet = [energy_error(model, Verlet(h), 6.4e-3, y)[0] for h in (8e-7, 4e-7, 2e-7)]
    runge_kutta = [energy_error(model, RungeKutta4(h), 6.4e-3, y)[0] for h in (3.2e-6, 1.6e-6, 8e-7)]
    assert orders(verlet) == pytest.approx(2.0, abs=0.1)
    assert orders(runge_kutta) == pytest.approx(4.2, abs=0.4)


def test_energy_closes_over_a_slot():
    """Damping, friction and a slot: second order at least, to 0.3 % and 0.1 % of the dissipated energy at 0.1 us.

    A contact's force begins as tau^(10/9), which limits Runge-Kutta to little more than second order.
    """
    model, y = start_planar(defect=SLOT)
    verlet, lost = zip(*(energy_error(model, Verlet(h), 6.4e-3, y) for h in (4e-7, 2e-7, 1e-7)), strict=True)
    runge_kutta = [energy_error(model, RungeKutta4(h), 6.4e-3, y)[0] for h in (8e-7, 1e-7)]
    assert orders(verlet).mean() > 1.75
    assert np.log2(runge_kutta[0] / runge_kutta[1]) / 3 > 1.9
    assert lost[-1] > 1.5e-4
    assert verlet[-1] < 4e-3 * lost[-1]
    assert runge_kutta[-1] < 1e-3 * lost[-1]


def test_verlet_conserves_energy_of_undamped_bearing():
    """No damping, no friction: the energy drifts with the square of the step, by 2e-5 of its range."""
    model, y = start_planar()
    frictionless = StaticDynamic(0.0, 0.0, 0.02, 0.1)
    cage = model.cage._replace(friction=frictionless, pocket=model.cage.pocket._replace(chi=0.0))
    support = model.support._replace(c_b=0.0)
    outer, inner = model.outer._replace(chi=0.0), model.inner._replace(chi=0.0)
    model = model._replace(outer=outer, inner=inner, friction=frictionless, support=support, cage=cage)
    y[lay.VELOCITY + lay.X] = 1e-3
    start_at_rest(model, 0.0, y)
    drifts = []
    for h in (8e-7, 4e-7, 2e-7):
        t, out = record_run(model, Verlet(h), 12.8e-3, y)
        balance = balances(model, t, out)
        assert np.abs(balance.lost).max() == 0.0
        drifts.append(np.ptp(balance.energy + model.support.F * out[lay.X]))
    assert orders(drifts) == pytest.approx(2.0, abs=0.15)
    assert drifts[-1] < 2e-5 * np.ptp(balance.energy)
