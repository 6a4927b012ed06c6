"""``rollers``: the ring moves in x and y, each roller radially; the cage turns at its kinematic speed.

    delta_o = r + R_w - R_o - u.e_r - h(s_o),  v_o = r' - u'.e_r - omega_c u.e_theta - h'(s_o) R_o omega_c
    delta_i = R_i + R_w - r - h(s_i),          v_i = -r' - h'(s_i) R_i (omega_c - omega_i)
    m_r r'' = m_r omega_c^2 r + Q_i - Q_o
    m_o u'' = -F e_0 - F_across e_90 - k_b (u - u_0) - c_b u' + sum_j Q_o,j e_r(theta_j)

(A pit of a roller counts in h at each of its contacts, sliding past at R_w omega_b.) The position of a roller is
kept as its displacement q from the middle of the clearance, r = d_m/2 + q: 0.03 m would cost 2 of 16 digits. Left
out: friction, tangential motion, tilt, the bending of the rings.
"""

from typing import Any, NamedTuple

from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, slopes, stiffness_bound
from bearingsim.core.layout import (
    BY_POSITION,
    BY_VELOCITY,
    COS,
    DELTA_I,
    DELTA_O,
    INVERSE_MASS,
    LANES,
    POSITION,
    Q_I,
    Q_O,
    ROW,
    SIN,
    V_I,
    V_O,
    VELOCITY,
    WORK,
    A,
    Q,
    V,
    X,
    Y,
    from_border,
    own_block,
    to_border,
)
from bearingsim.core.models.extremes import keep_forces
from bearingsim.core.models.interface import (
    ModelKind,
    accelerations,
    begin,
    damping_per_mass,
    freedoms,
    keep_extremes,
    linearise,
    stiffness_per_mass,
    watched,
    width,
)
from bearingsim.core.models.outer_ring import accelerate_ring, linearise_ring, turn
from bearingsim.core.parameters import Bearing, Support, lanes, turns
from bearingsim.core.pits.jumps import next_cusp, next_cusp_evenly
from bearingsim.core.pits.on_roller import correct_contact, outdone, slopes_over_pit, standing, standing_evenly
from bearingsim.core.pits.pairs import HALF_WIDTH, OUTER, SIDE, Pits, sliding

K_O, C_O, K_I, C_I = (WORK + n * ROW for n in range(4))  # how a contact's force grows: N/m, N s/m


class Rollers(NamedTuple):
    """Parameters of the model; ``outer``, ``inner``: the contact laws (``laws/damping``) at the two races."""

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    pits: Pits


@width.register(Rollers)
def _width(model):
    return LANES + lanes(model.bearing)


@watched.register(Rollers)
def _watched(model):
    return model.bearing.Z


@jit
def approaches(bearing, y, n):
    """Approaches and their rates of both contacts of every roller over an undamaged race."""
    omega_c, gap = bearing.omega_c, bearing.gap
    u_x, u_y, v_x, v_y = y[POSITION + X], y[POSITION + Y], y[VELOCITY + X], y[VELOCITY + Y]
    w_x, w_y = v_x + omega_c * u_y, v_y - omega_c * u_x  # u' - omega_c x u, so that w.e_r = d(u.e_r)/dt
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        y[DELTA_O + j] = y[Q + j] - (u_x * c + u_y * s) - gap
        y[V_O + j] = y[V + j] - (w_x * c + w_y * s)
        y[DELTA_I + j] = -gap - y[Q + j]
        y[V_I + j] = -y[V + j]


standing.register(Rollers)(standing_evenly)
next_cusp.register(Rollers)(next_cusp_evenly)


@jit
def over_pits(model, t, y):
    """Correct the contact of each roller that stands over a pit (its force is the sum of its groups)."""
    pits, bearing = model.pits, model.bearing
    for d in range(len(pits.head)):
        j, s = standing(model, d, t, y)
        if abs(s) < pits.head[d, HALF_WIDTH] and not outdone(model, d, j, s, t, y):
            speed = sliding(pits, d, bearing)
            if pits.head[d, SIDE] == OUTER:
                correct_contact(OuterSide(), model.outer, pits, d, j, s, speed, y)
            else:
                correct_contact(InnerSide(), model.inner, pits, d, j, s, speed, y)


@accelerations.register(Rollers)
def _accelerations(model, t, y):
    bearing = model.bearing
    n = lanes(bearing)
    turn(turns(bearing, t)[0], y, n)
    approaches(bearing, y, n)
    for j in range(n):
        y[Q_O + j] = normal_force(model.outer, y[DELTA_O + j], y[V_O + j])
        y[Q_I + j] = normal_force(model.inner, y[DELTA_I + j], y[V_I + j])
    over_pits(model, t, y)

    omega_2 = bearing.omega_c * bearing.omega_c
    middle = 0.5 * (bearing.R_o + bearing.R_i)
    for j in range(n):
        centrifugal = bearing.m_r * omega_2 * (middle + y[Q + j])
        y[A + j] = y[INVERSE_MASS + j] * (centrifugal + y[Q_I + j] - y[Q_O + j])
    accelerate_ring(model, y, n)


@begin.register(Rollers)
def _begin(model, t, y):
    accelerations(model, t, y)


keep_extremes.register(Rollers)(keep_forces)


@stiffness_per_mass.register(Rollers)
def _stiffness_per_mass(model, y, j):
    outer = stiffness_bound(model.outer, max(y[DELTA_O + j], 0.0), y[V_O + j])
    inner = stiffness_bound(model.inner, max(y[DELTA_I + j], 0.0), y[V_I + j])
    return y[INVERSE_MASS + j] * (outer + inner)


@damping_per_mass.register(Rollers)
def _damping_per_mass(model, y, j):
    outer = damping_bound(model.outer, max(y[DELTA_O + j], 0.0), y[V_O + j])
    inner = damping_bound(model.inner, max(y[DELTA_I + j], 0.0), y[V_I + j])
    return y[INVERSE_MASS + j] * (outer + inner)


@freedoms.register(Rollers)
def _freedoms(model):
    return 1, 2


@jit
def slopes_over_pits(model, t, y):
    """Correct the slopes of each contact that stands over a pit; where it stands depends on time alone."""
    pits, bearing = model.pits, model.bearing
    for d in range(len(pits.head)):
        j, s = standing(model, d, t, y)
        if abs(s) < pits.head[d, HALF_WIDTH] and not outdone(model, d, j, s, t, y):
            speed = sliding(pits, d, bearing)
            if pits.head[d, SIDE] == OUTER:
                delta, v = y[DELTA_O + j], y[V_O + j]
                y[K_O + j], y[C_O + j] = slopes_over_pit(model.outer, pits, d, s, speed, delta, v)
            else:
                delta, v = y[DELTA_I + j], y[V_I + j]
                y[K_I + j], y[C_I + j] = slopes_over_pit(model.inner, pits, d, s, speed, delta, v)


@linearise.register(Rollers)
def _linearise(model, t, y):
    bearing = model.bearing
    n = lanes(bearing)
    approaches(bearing, y, n)
    for j in range(n):
        y[K_O + j], y[C_O + j] = slopes(model.outer, y[DELTA_O + j], y[V_O + j])
        y[K_I + j], y[C_I + j] = slopes(model.inner, y[DELTA_I + j], y[V_I + j])
    slopes_over_pits(model, t, y)

    omega_c, omega_2, per_ring = bearing.omega_c, bearing.omega_c * bearing.omega_c, 1.0 / bearing.m_o
    for j in range(n):
        c, s, per_mass = y[COS + j], y[SIN + j], y[INVERSE_MASS + j]
        K, C = y[K_O + j], y[C_O + j]
        y[own_block(BY_POSITION, 0, 0) + j] = per_mass * (bearing.m_r * omega_2 - K - y[K_I + j])
        y[own_block(BY_VELOCITY, 0, 0) + j] = per_mass * (-C - y[C_I + j])
        y[from_border(BY_POSITION, 0, X) + j] = per_mass * (K * c - C * omega_c * s)
        y[from_border(BY_POSITION, 0, Y) + j] = per_mass * (K * s + C * omega_c * c)
        y[from_border(BY_VELOCITY, 0, X) + j] = per_mass * C * c
        y[from_border(BY_VELOCITY, 0, Y) + j] = per_mass * C * s
        y[to_border(BY_POSITION, X, 0) + j] = per_ring * K * c
        y[to_border(BY_POSITION, Y, 0) + j] = per_ring * K * s
        y[to_border(BY_VELOCITY, X, 0) + j] = per_ring * C * c
        y[to_border(BY_VELOCITY, Y, 0) + j] = per_ring * C * s
    linearise_ring(model, K_O, C_O, y, n)


# at the cusp of a narrow pit the damping force jumps, and decays within 0.2 us: hence more steps over it
KIND = ModelKind(Rollers, per_crossing=100)
