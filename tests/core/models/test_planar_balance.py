"""`planar` against mechanics: momentum, torque and power, at any state and along a motion.

The bodies, and what acts on them, are `tests/independent/planar_bodies.py`.
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
from tests.scenes.nf308 import SLOT, case
from tests.scenes.planar_runs import balances, energy_error, orders, record_run, start_planar

WHERE = 2e-3  # s: when the balances at any state are drawn up
NARROW = SLOT | {"width": "0.3 mm", "length": "8 mm"}
EVERYTHING = {
    "model": "planar",
    "defects": [NARROW, NARROW | {"race": "inner"}, NARROW | {"race": "roller", "roller": 5}],
    "load_across": "60 N",
    "gravity": True,
    "shaft": {"stiffness": "5e7 N/m", "mass": "3 kg", "damping": "300 N s/m"},
    "unbalance": {"mass_radius": "1e-2 kg m", "angle": "40 deg"},
    "rig": {"ring_mass": "0.5 kg", "torsion_stiffness": "3e3 N m/rad", "torsion_damping": "2 N m s/rad"},
    "contact": {"damping": {"chi": "5 s/m"}},
}
"""Fields of a case in which all that can act does."""
SPEEDING = {"ramp": {"to": "2400 rpm", "time": "5 ms"}, "friction": "traction"}
RUBBING = {"static": "0.2", "dynamic": "0.1", "static_speed": "2 m/s", "dynamic_speed": "8 m/s"}
"""Friction of the cage that still depends on the slip at the speeds of a bearing that turns."""
WAYS = {
    "on rollers": {"cage": {"guide": "rollers", "friction": RUBBING}, "drag": {"land": "outer"}},
    "on the outer ring": {"cage": {"guide": "outer-ring", "friction": RUBBING}, "drag": {"land": "inner"}}
    | SPEEDING,
    "on the inner ring": {"cage": {"guide": "inner-ring", "friction": RUBBING}, "drag": {"land": "outer"}}
    | SPEEDING,
}


def random_state(model, seed):
    """A buffer far from rest: micrometres and centimetres per second at the races, the cage beyond its play."""
    random, Z = np.random.default_rng(seed), model.bearing.Z
    y = assemble.empty_buffer(model)
    for row, size in (
        (lay.RADIAL, 3e-6),
        (lay.RADIAL_V, 2e-2),
        (lay.EPS, 3e-3),
        (lay.EPS_V, 1.0),
        (lay.SPIN, 0.02),
        (lay.SPIN_V, 8.0),
    ):
        y[row : row + Z] = random.normal(0.0, size, Z)
    for place, size in ((lay.X, 2e-6), (lay.X_I, 2e-6), (lay.X_C, 1e-4)):
        y[lay.POSITION + place : lay.POSITION + place + 2] = random.normal(0.0, size, 2)
        y[lay.VELOCITY + place : lay.VELOCITY + place + 2] = random.normal(0.0, 2e-2, 2)
    y[lay.POSITION + lay.X_C] += 3e-4
    for place in (lay.PSI, lay.PHI_C):
        y[lay.POSITION + place], y[lay.VELOCITY + place] = random.normal(0.0, 1e-2), random.normal(0.0, 3.0)
    return y


def lead_onto_defects(model, y, t, outwards):
    """Turn the defects under rollers 4, 8 and 5, and press these on them; the last outwards or inwards."""
    for j, q in ((3, 1e-5), (7, -1e-5), (4, 1e-5 if outwards else -1e-5)):
        y[lay.RADIAL + j] = q
    found = now(model, y, t)
    theta = np.angle(found.rollers.at[:, 0])
    head = model.defects.head
    head[:, ANGLE] = 4e-5 / head[:, RADIUS]
    head[0, ANGLE] += np.angle(found.rollers.at[3, 0] - found.ring.at[0]) - y[lay.POSITION + lay.PSI]
    head[1, ANGLE] += np.angle(found.rollers.at[7, 0] - found.inner.at[0]) - found.inner.angle[0]
    turned = theta[4] - 2 * np.pi * 4 / model.bearing.Z - model.bearing.theta_0
    head[2:, ANGLE] += turned - found.rollers.angle[4, 0] + (0.0 if outwards else np.pi)


def now(model, y, t):
    """The bodies of a buffer."""
    return bodies.scene(model, np.array([t]), y[bodies.places(model.bearing.Z)][:, np.newaxis])


def shaken(way, seed, **given):
    """A model, and a buffer at a random state with everything in contact and accelerations filled in."""
    model = assemble.model(case(**EVERYTHING, **WAYS[way], **given))
    y = random_state(model, seed)
    lead_onto_defects(model, y, WHERE, outwards=seed % 2 == 0)
    start_at_rest(model, WHERE, y)
    return model, y


def leaving(model, y):
    """Balances at five states on the line along which ``y`` is leaving, and their distance (s)."""
    h, at = 2e-8, bodies.places(model.bearing.Z)
    velocities = at[len(at) // 2 :]
    slope = np.concatenate([y[velocities], y[velocities + lay.ACCELERATION - lay.VELOCITY]])
    ahead = h * np.arange(-2, 3)
    line = y[at][:, np.newaxis] + ahead * slope[:, np.newaxis]
    return bodies.balance(bodies.scene(model, WHERE + ahead, line)), h


def rate(values, h):
    """Slope in the middle of five values, to fourth order."""
    return (8 * (values[3] - values[1]) - (values[4] - values[0])) / (12 * h)


@pytest.mark.parametrize("way", WAYS)
def test_in_the_states_below_everything_acts(way):
    """Each defect, the cage's guide, and pockets on both sides."""
    for seed in range(4):
        model, y = shaken(way, seed)
        assert abs(y[lay.DEFECT_FORCE_O + 3]) > 0.5
        assert abs(y[lay.DEFECT_FORCE_I + 7]) > 0.5
        assert abs(y[(lay.DEFECT_FORCE_I if seed % 2 else lay.DEFECT_FORCE_O) + 4]) > 0.5
        guide, s = model.cage.guide, now(model, y, WHERE)
        if isinstance(guide, RingGuided):
            ring = s.ring if guide.outer else s.inner
            assert abs(s.cage.at - ring.at)[0] > guide.play
        else:
            apart = bodies.dot(np.exp(1j * bodies.pockets(model.bearing, s.cage.angle)), s.rollers.at - s.cage.at)
            assert (np.abs(apart - model.bearing.R_i - model.bearing.R_w) > guide.play).sum() > 3


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(4))
def test_momentum_and_torque_balance_at_any_state(way, seed):
    """Rings, rollers and cage together feel what acts from outside, to 1e-12 of the forces between them.

    The torque holds the friction at the inner race, which comes from slips good to 1e-12 m/s: 1e-11.
    """
    model, y = shaken(way, seed)
    found, h = leaving(model, y)
    between = y[lay.Q_O : lay.Q_O + 13].sum() + y[lay.Q_I : lay.Q_I + 13].sum()
    assert abs(rate(found.momentum, h) - found.force[2]) < 1e-12 * between
    assert abs(rate(found.spin, h) - found.torque[2]) < 1e-11 * between * model.bearing.R_o


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(4))
def test_power_balances_at_any_state(way, seed):
    """The energy of all bodies, contacts and springs grows by what is put in less what is lost, within 1e-8."""
    model, y = shaken(way, seed)
    found, h = leaving(model, y)
    assert found.lost[2] > 100.0
    assert rate(found.energy, h) == pytest.approx(
        found.power[2] - found.lost[2], abs=1e-8 * (abs(found.power[2]) + found.lost[2])
    )


# along a motion


def test_energy_closes_in_a_healthy_bearing():
    """Damping and friction on: Verlet closes to second order, Runge-Kutta to fourth."""
    model, y = start_planar()
    slow = [energy_error(model, Verlet(h), 6.4e-3, y)[0] for h in (8e-7, 4e-7, 2e-7)]
    fast = [energy_error(model, RungeKutta4(h), 6.4e-3, y)[0] for h in (3.2e-6, 1.6e-6, 8e-7)]
    assert orders(slow) == pytest.approx(2.0, abs=0.1)
    assert orders(fast) == pytest.approx(4.2, abs=0.4)


def test_energy_closes_over_a_slot():
    """Damping, friction and a slot: second order at least, to 0.3 % and 0.1 % of what was lost at 0.1 us.

    A contact's force begins as tau^(10/9) and so holds Runge-Kutta to little more than second order.
    """
    model, y = start_planar(defect=SLOT)
    slow, lost = zip(*(energy_error(model, Verlet(h), 6.4e-3, y) for h in (4e-7, 2e-7, 1e-7)), strict=True)
    fast = [energy_error(model, RungeKutta4(h), 6.4e-3, y)[0] for h in (8e-7, 1e-7)]
    assert orders(slow).mean() > 1.75
    assert np.log2(fast[0] / fast[1]) / 3 > 1.9
    assert lost[-1] > 1.5e-4
    assert slow[-1] < 4e-3 * lost[-1]
    assert fast[-1] < 1e-3 * lost[-1]


def test_verlet_keeps_the_energy_of_an_undamped_bearing():
    """No damping, no friction: the energy strays with the square of the step, by 2e-5 of what is exchanged."""
    model, y = start_planar()
    slides = StaticDynamic(0.0, 0.0, 0.02, 0.1)
    cage = model.cage._replace(friction=slides, pocket=model.cage.pocket._replace(chi=0.0))
    support = model.support._replace(c_b=0.0)
    outer, inner = model.outer._replace(chi=0.0), model.inner._replace(chi=0.0)
    model = model._replace(outer=outer, inner=inner, friction=slides, support=support, cage=cage)
    y[lay.VELOCITY + lay.X] = 1e-3
    start_at_rest(model, 0.0, y)
    strays = []
    for h in (8e-7, 4e-7, 2e-7):
        t, out = record_run(model, Verlet(h), 12.8e-3, y)
        found = balances(model, t, out)
        assert np.abs(found.lost).max() == 0.0
        strays.append(np.ptp(found.energy + model.support.F * out[lay.X]))
    assert orders(strays) == pytest.approx(2.0, abs=0.15)
    assert strays[-1] < 2e-5 * np.ptp(found.energy)
