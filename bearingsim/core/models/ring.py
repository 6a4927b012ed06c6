"""``ring``: the ring moves in x and y; rollers have no mass, so a roller's two contacts are in series.

Over an undamaged race both contacts share the approach and its rate equally,

    Q = normal_force(delta/2, v/2),   delta = -u.e_r - G_r/2,   v its rate,

and over a pit with several groups along the roller the elastic balance is solved for the inner approach,

    sum_k w_k E(delta - delta_i - h_k) = E(delta_i),

with each group's closing rate halved. (While that balance holds, the half is exact for damping proportional to
the elastic force, and for one group with any law. A massless roller between dashpots would relax to it within some
microseconds; leaving that out costs under 1 % of the force over a bowl, 3 % at chi = 200 s/m.) Left out besides:
the rollers' inertia and centrifugal load.
"""

from typing import Any, NamedTuple

from bearingsim.core.contact import damping_slope, normal_force, stiffness_slope
from bearingsim.core.defects import Pits, W, depression, roller_over
from bearingsim.core.equilibrium import roller_balance
from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    COS,
    DELTA_I,
    DELTA_O,
    LANES,
    POSITION,
    Q_I,
    Q_O,
    SIN,
    V_I,
    V_O,
    VELOCITY,
    X,
    Y,
)
from bearingsim.core.models.interface import (
    ModelKind,
    accelerations,
    begin,
    damping_per_mass,
    stiffness_per_mass,
    watched,
    width,
)
from bearingsim.core.models.outer_ring import accelerate_ring, turn
from bearingsim.core.parameters import Bearing, Support, lanes


class Ring(NamedTuple):
    """Parameters of the model; ``bearing.m_r`` must be 0."""

    bearing: Bearing
    support: Support
    contact: Any
    pits: Pits


@width.register(Ring)
def _width(model):
    return LANES


@watched.register(Ring)
def _watched(model):
    return 1


@jit
def halves(bearing, y, n):
    """Half the total approach and half its rate of every roller over an undamaged race."""
    omega_c, gap = bearing.omega_c, bearing.gap
    u_x, u_y, v_x, v_y = y[POSITION + X], y[POSITION + Y], y[VELOCITY + X], y[VELOCITY + Y]
    w_x, w_y = v_x + omega_c * u_y, v_y - omega_c * u_x
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        y[DELTA_O + j] = -0.5 * (u_x * c + u_y * s) - gap
        y[V_O + j] = -0.5 * (w_x * c + w_y * s)


@jit
def over_pits(model, theta_c, y):
    """Solve the series of each roller that stands over a pit."""
    pits, bearing = model.pits, model.bearing
    for d in range(len(pits.angle)):
        j, s = roller_over(pits, d, theta_c, bearing.Z)
        if abs(s) < pits.half_width[d]:
            u_r = -2.0 * (y[DELTA_O + j] + bearing.gap)
            outer = roller_balance(model, d, s, u_r) - u_r - bearing.gap
            force, mean, closing = 0.0, 0.0, 0.0
            for k in range(pits.used[d]):
                group = pits.groups[d, k]
                h, slope = depression(group, s, pits.R)
                rate = y[V_O + j] - 0.5 * slope * pits.R_o * bearing.omega_c
                force += group[W] * normal_force(model.contact, outer - h, rate)
                mean += group[W] * max(outer - h, 0.0)
                closing += group[W] * max(outer - h, 0.0) * rate
            y[Q_O + j] = force
            y[DELTA_O + j] = mean
            y[V_O + j] = closing / mean if mean > 0.0 else 0.0


@accelerations.register(Ring)
def _accelerations(model, t, y):
    bearing = model.bearing
    n = lanes(bearing)
    theta_c = bearing.theta_0 + bearing.omega_c * t
    turn(theta_c, y, n)
    halves(bearing, y, n)
    for j in range(n):
        y[Q_O + j] = normal_force(model.contact, y[DELTA_O + j], y[V_O + j])
    over_pits(model, theta_c, y)
    for j in range(n):
        y[Q_I + j] = y[Q_O + j]
        y[DELTA_I + j] = y[DELTA_O + j]
        y[V_I + j] = y[V_O + j]
    accelerate_ring(model, y, n)


@begin.register(Ring)
def _begin(model, t, y):
    accelerations(model, t, y)


@stiffness_per_mass.register(Ring)
def _stiffness_per_mass(model, y, j):
    """All contacts in one line: at least the largest eigenvalue of the ring's stiffness, at most twice it."""
    total = 0.0
    for i in range(lanes(model.bearing)):
        real = y[COS + i] * y[COS + i] + y[SIN + i] * y[SIN + i]  # 1, and 0 in a padded lane
        total = add(total, real * stiffness_slope(model.contact, max(y[DELTA_O + i], 0.0), y[V_O + i]))
    return (0.5 * total + model.support.k_b) / model.bearing.m_o


@damping_per_mass.register(Ring)
def _damping_per_mass(model, y, j):
    total = 0.0
    for i in range(lanes(model.bearing)):
        real = y[COS + i] * y[COS + i] + y[SIN + i] * y[SIN + i]
        total = add(total, real * damping_slope(model.contact, max(y[DELTA_O + i], 0.0), y[V_O + i]))
    return (0.5 * total + model.support.c_b) / model.bearing.m_o


KIND = ModelKind(Ring, massless=True, memoryless=False, per_crossing=50, cost=0.19e-6)
