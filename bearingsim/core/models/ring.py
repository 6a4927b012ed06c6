"""``ring``: the ring moves in x and y; rollers have no mass, so a roller's two contacts are in series.

Over an undamaged race both contacts share the approach and its rate equally,

    Q = normal_force(delta/2, v/2),   delta = -u.e_r - G_r/2,   v its rate,

and over a pit with several groups along the roller the elastic balance is solved for the inner approach,

    sum_k w_k E(delta - delta_i - h_k) = E(delta_i),

with each group's closing rate halved. (While that balance holds, the half is exact for damping proportional to
the elastic force, and for one group with any law where both contacts are
alike. A massless roller between dashpots would relax to it within some
microseconds; leaving that out costs under 1 % of the force over a bowl, 3 % at chi = 200 s/m.) Left out besides:
the rollers' inertia and centrifugal load.
"""

from typing import Any, NamedTuple

from bearingsim.core.jit import add, jit
from bearingsim.core.laws.damping.interface import damping_bound, in_series, normal_force, slopes, stiffness_bound
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.laws.stiffness.series import share
from bearingsim.core.layout import (
    COS,
    DELTA_I,
    DELTA_O,
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
    X,
    Y,
)
from bearingsim.core.models.equilibrium import ALONG, PIT, find_pits, roller_balance
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
from bearingsim.core.pits.on_roller import (
    force_over_pit,
    sinking_rate,
    sinking_slope,
    slopes_over_pit,
    standing,
    standing_evenly,
    stiffness_over_pit,
)
from bearingsim.core.pits.pairs import Pits, sliding

K_RING, C_RING = WORK + 5 * ROW, WORK + 6 * ROW  # how a roller's force grows with its series' approach: N/m, N s/m


class Ring(NamedTuple):
    """Parameters of the model; ``bearing.m_r`` must be 0."""

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    pits: Pits


@width.register(Ring)
def _width(model):
    return LANES


@watched.register(Ring)
def _watched(model):
    return 1


standing.register(Ring)(standing_evenly)
next_cusp.register(Ring)(next_cusp_evenly)


@jit
def series(model, y, n):
    """The two contacts of every roller over undamaged races: approaches, and half of the rate to each."""
    omega_c, gap = model.bearing.omega_c, model.bearing.gap
    u_x, u_y, v_x, v_y = y[POSITION + X], y[POSITION + Y], y[VELOCITY + X], y[VELOCITY + Y]
    w_x, w_y = v_x + omega_c * u_y, v_y - omega_c * u_x
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        delta = -(u_x * c + u_y * s) - 2.0 * gap
        inner = share(model.outer.stiffness, model.inner.stiffness, max(delta, 0.0)) + 0.5 * min(delta, 0.0)
        y[DELTA_O + j] = delta - inner
        y[DELTA_I + j] = inner
        y[V_O + j] = -0.5 * (w_x * c + w_y * s)
        y[V_I + j] = y[V_O + j]


@jit
def over_pit(model, y, j):
    """Solve the series of a roller of which a contact stands over a pit."""
    pits, bearing = model.pits, model.bearing
    u_r = -(y[DELTA_O + j] + y[DELTA_I + j] + 2.0 * bearing.gap)
    q = roller_balance(model, y, j, u_r)
    outer, inner, half = q - u_r - bearing.gap, -bearing.gap - q, y[V_O + j]
    y[DELTA_O + j], y[DELTA_I + j] = outer, inner
    d, s = int(y[PIT + j]), y[ALONG + j]
    e, along = int(y[PIT + ROW + j]), y[ALONG + ROW + j]
    if d >= 0:
        speed = sliding(pits, d, bearing)
        if e >= 0:
            half -= 0.5 * sinking_rate(model.inner.stiffness, pits, e, along, sliding(pits, e, bearing), inner)
        y[Q_O + j], _, y[DELTA_O + j], y[V_O + j] = force_over_pit(
            model.outer, pits, d, s, 0.5 * speed, outer, half
        )
    else:
        speed = sliding(pits, e, bearing)
        y[Q_O + j], _, y[DELTA_I + j], y[V_I + j] = force_over_pit(
            model.inner, pits, e, along, 0.5 * speed, inner, half
        )
        y[V_O + j] = y[V_I + j]


@accelerations.register(Ring)
def _accelerations(model, t, y):
    bearing = model.bearing
    n = lanes(bearing)
    turn(turns(bearing, t)[0], y, n)
    series(model, y, n)
    for j in range(n):
        y[Q_O + j] = normal_force(model.outer, y[DELTA_O + j], y[V_O + j])
    if len(model.pits.head) > 0:
        find_pits(model, t, y)
        for j in range(bearing.Z):
            if y[PIT + j] >= 0.0 or y[PIT + ROW + j] >= 0.0:
                over_pit(model, y, j)
    for j in range(n):
        y[Q_I + j] = y[Q_O + j]
    accelerate_ring(model, y, n)


@begin.register(Ring)
def _begin(model, t, y):
    accelerations(model, t, y)


keep_extremes.register(Ring)(keep_forces)


@stiffness_per_mass.register(Ring)
def _stiffness_per_mass(model, y, j):
    """All contacts in one line: at least the largest eigenvalue of the ring's stiffness, at most twice it."""
    total = 0.0
    for i in range(lanes(model.bearing)):
        real = y[COS + i] * y[COS + i] + y[SIN + i] * y[SIN + i]  # 1, and 0 in a padded lane
        outer = stiffness_bound(model.outer, max(y[DELTA_O + i], 0.0), y[V_O + i])
        inner = stiffness_bound(model.inner, max(y[DELTA_I + i], 0.0), y[V_I + i])
        total = add(total, real * in_series(outer, inner))
    return (total + model.support.k_b) / model.bearing.m_o


@damping_per_mass.register(Ring)
def _damping_per_mass(model, y, j):
    total = 0.0
    for i in range(lanes(model.bearing)):
        real = y[COS + i] * y[COS + i] + y[SIN + i] * y[SIN + i]
        outer = damping_bound(model.outer, max(y[DELTA_O + i], 0.0), y[V_O + i])
        inner = damping_bound(model.inner, max(y[DELTA_I + i], 0.0), y[V_I + i])
        total = add(total, real * in_series(outer, inner))
    return (total + model.support.c_b) / model.bearing.m_o


@freedoms.register(Ring)
def _freedoms(model):
    return 0, 2


@jit
def slopes_in_series(model, y, n):
    """How the force of every roller over undamaged races grows: each contact takes its part of the approach.

    The elastic balance E_o(delta_o) = E_i(delta_i) gives the outer the part E_i'/(E_o' + E_i'); of the rate it has
    half.
    """
    for j in range(n):
        K, C = slopes(model.outer, y[DELTA_O + j], y[V_O + j])
        k_o = tangent(model.outer.stiffness, max(y[DELTA_O + j], 0.0))
        k_i = tangent(model.inner.stiffness, max(y[DELTA_I + j], 0.0))
        y[K_RING + j] = K * k_i / max(k_o + k_i, 1e-300)
        y[C_RING + j] = 0.5 * C


@jit
def slopes_over_pit_in_series(model, y, j):
    """The same of a roller of which a contact stands over a pit (``over_pit``)."""
    pits, bearing = model.pits, model.bearing
    u_r = -(y[DELTA_O + j] + y[DELTA_I + j] + 2.0 * bearing.gap)
    q = roller_balance(model, y, j, u_r)
    outer, inner, half = q - u_r - bearing.gap, -bearing.gap - q, y[V_O + j]
    d, s = int(y[PIT + j]), y[ALONG + j]
    e, along = int(y[PIT + ROW + j]), y[ALONG + ROW + j]
    k_o = stiffness_over_pit(model.outer.stiffness, pits, d, s, outer)
    k_i = stiffness_over_pit(model.inner.stiffness, pits, e, along, inner)
    part = k_i / max(k_o + k_i, 1e-300)
    if d < 0:
        speed = 0.5 * sliding(pits, e, bearing)
        K, C = slopes_over_pit(model.inner, pits, e, along, speed, inner, half)
        return (1.0 - part) * K, 0.5 * C
    falling = 0.0  # how the closing rate falls as the inner contact closes up
    if e >= 0:
        speed, stiffness = sliding(pits, e, bearing), model.inner.stiffness
        half -= 0.5 * sinking_rate(stiffness, pits, e, along, speed, inner)
        falling = 0.5 * sinking_slope(stiffness, pits, e, along, speed, inner)
    K, C = slopes_over_pit(model.outer, pits, d, s, 0.5 * sliding(pits, d, bearing), outer, half)
    return part * K - (1.0 - part) * falling * C, 0.5 * C


@linearise.register(Ring)
def _linearise(model, t, y):
    n = lanes(model.bearing)
    series(model, y, n)
    slopes_in_series(model, y, n)
    if len(model.pits.head) > 0:
        find_pits(model, t, y)
        for j in range(model.bearing.Z):
            if y[PIT + j] >= 0.0 or y[PIT + ROW + j] >= 0.0:
                y[K_RING + j], y[C_RING + j] = slopes_over_pit_in_series(model, y, j)
    linearise_ring(model, K_RING, C_RING, y, n)


KIND = ModelKind(Ring, per_crossing=50)
