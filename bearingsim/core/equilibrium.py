"""The exact static equilibrium: where the ring rests at a given cage angle.

For a ring position u each roller finds its own balance Q_o = Q_i + m_r omega_c^2 r (one unknown, bracketed);
the ring's position is then found by Newton with a line search on the net force

    f(u) = -F e_0 - k_b (u - u_0) + sum_j Q_o,j(u) e_r(theta_j)

which is minus the gradient of a convex energy, so the method cannot wander off. A roller that carries nothing
rests on the outer race. ``static`` takes one such equilibrium per step; ``ring`` and ``rollers`` start from it.
"""

from math import cos, hypot, pi, sin

import numpy as np

from bearingsim.core.contact import elastic, tangent
from bearingsim.core.defects import W, depression, roller_over
from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    COS,
    COS_0,
    DELTA_I,
    DELTA_O,
    POSITION,
    Q_I,
    Q_O,
    ROW,
    SIN,
    SIN_0,
    STAGE,
    VELOCITY,
    Q,
    X,
    Y,
)

K_SERIES = STAGE  # scratch row: stiffness of the two contacts of a roller in series, N/m
PIT, ALONG = STAGE + ROW, STAGE + 2 * ROW  # scratch rows: the pit under a roller (-1: none), and where in it
RESIDUAL = 1e-10  # of the load: well under the 1e-8 promised
MAX_STEPS = 200
LONGEST_STEP = 1e-5  # m


class NoEquilibrium(ArithmeticError):
    """The rollers cannot hold the load."""


@jit
def outer_force(stiffness, pits, d, s, o):
    """Outer contact at approach ``o`` (m, from the undamaged race): force, slope and mean approach.

    ``d`` is the pit under the roller, -1 for none; ``s`` the roller's distance from the pit's middle (m).
    """
    if d < 0:
        return elastic(stiffness, max(o, 0.0)), tangent(stiffness, max(o, 0.0)), max(o, 0.0)
    force, slope, mean = 0.0, 0.0, 0.0
    for k in range(pits.used[d]):
        group = pits.groups[d, k]
        delta = max(o - depression(group, s, pits.R)[0], 0.0)
        force += group[W] * elastic(stiffness, delta)
        slope += group[W] * tangent(stiffness, delta)
        mean += group[W] * delta
    return force, slope, mean


@jit
def excess_force(model, d, s, touch, q):
    """Net inward force (N) on a roller at ``q`` (m) and its slope; ``touch`` is where it meets the outer race."""
    bearing, stiffness = model.bearing, model.contact.stiffness
    outer, slope, _mean = outer_force(stiffness, model.pits, d, s, q - touch)
    inner = max(-bearing.gap - q, 0.0)
    r = 0.5 * (bearing.R_o + bearing.R_i) + q
    centrifugal = bearing.m_r * bearing.omega_c * bearing.omega_c * r
    return outer - elastic(stiffness, inner) - centrifugal, slope + tangent(stiffness, inner)


@jit
def roller_balance(model, d, s, u_r):
    """Position q (m) of a roller when the outer race stands ``u_r`` further out at its angle.

    Newton inside a bracket: from touching the outer race with no force to pressing on it with all there is.
    """
    gap = model.bearing.gap
    touch = u_r + gap
    massless = model.bearing.m_r == 0.0
    if massless and touch >= -gap:
        return touch
    if massless and d < 0:
        return u_r / 2.0
    if massless and model.pits.used[d] == 1:
        h = depression(model.pits.groups[d, 0], s, model.pits.R)[0]
        return min(0.5 * (u_r + h), -gap)
    low, high = touch, max(touch, -gap) + 1e-6
    while excess_force(model, d, s, touch, high)[0] < 0.0:
        high += high - low
    q = 0.5 * (low + high)
    for _ in range(MAX_STEPS):
        excess, slope = excess_force(model, d, s, touch, q)
        if excess > 0.0:
            high = q
        else:
            low = q
        target = q - excess / slope
        if not low <= target <= high:
            target = 0.5 * (low + high)
        if abs(target - q) <= 1e-12 * (high - touch):  # below it lies rounding
            return target
        q = target
    return q


@jit
def find_pits(pits, theta_c, Z, y):
    """Fill the rows PIT and ALONG: which pit is under which roller, and how far (m) its middle is."""
    for j in range(Z):
        y[PIT + j] = -1.0
    for d in range(len(pits.angle)):
        j, s = roller_over(pits, d, theta_c, Z)
        if abs(s) < pits.half_width[d]:
            y[PIT + j], y[ALONG + j] = d, s


@jit
def balance_rollers(model, t, y):
    """Balance every roller for the ring position in ``y``; fills its angle, approach, force and K_SERIES rows."""
    bearing, stiffness = model.bearing, model.contact.stiffness
    theta_c = bearing.theta_0 + bearing.omega_c * t
    find_pits(model.pits, theta_c, bearing.Z, y)
    C, S = cos(theta_c), sin(theta_c)
    for j in range(bearing.Z):
        c = C * y[COS_0 + j] - S * y[SIN_0 + j]
        s = S * y[COS_0 + j] + C * y[SIN_0 + j]
        u_r = y[POSITION + X] * c + y[POSITION + Y] * s
        d, along = int(y[PIT + j]), y[ALONG + j]
        q = roller_balance(model, d, along, u_r)
        force, k_o, approach = outer_force(stiffness, model.pits, d, along, q - u_r - bearing.gap)
        inner = max(-bearing.gap - q, 0.0)
        k_i = tangent(stiffness, inner) if inner > 0.0 else 0.0
        y[COS + j], y[SIN + j], y[Q + j] = c, s, q
        y[DELTA_O + j], y[DELTA_I + j] = approach, inner
        y[Q_O + j], y[Q_I + j] = force, elastic(stiffness, inner)
        y[K_SERIES + j] = k_o * k_i / (k_o + k_i) if force > 0.0 else 0.0


@jit
def net_force(model, y):
    """Net force (N) on the ring, from the rows that ``balance_rollers`` filled."""
    support = model.support
    f_x = -support.F - support.k_b * (y[POSITION + X] - support.x_0)
    f_y = -support.k_b * (y[POSITION + Y] - support.y_0)
    for j in range(model.bearing.Z):
        f_x += y[Q_O + j] * y[COS + j]
        f_y += y[Q_O + j] * y[SIN + j]
    return f_x, f_y


@jit
def ring_stiffness(model, y):
    """Stiffness of the ring's support (N/m): entries xx, xy, yy of the symmetric matrix -df/du."""
    k_b = model.support.k_b
    # a ring hanging on one roller has no stiffness across it: a trace of it keeps the step finite
    trace = 1e-8 * tangent(model.contact.stiffness, 1e-7)
    k_xx, k_xy, k_yy = k_b + trace, 0.0, k_b + trace
    for j in range(model.bearing.Z):
        c, s, k = y[COS + j], y[SIN + j], y[K_SERIES + j]
        k_xx += k * c * c
        k_xy += k * c * s
        k_yy += k * s * s
    return k_xx, k_xy, k_yy


@jit
def solve_2x2(k_xx, k_xy, k_yy, f_x, f_y):
    """Solution of the symmetric 2 x 2 system."""
    determinant = k_xx * k_yy - k_xy * k_xy
    return (k_yy * f_x - k_xy * f_y) / determinant, (k_xx * f_y - k_xy * f_x) / determinant


@jit
def push_at(model, t, y, x, z, d_x, d_y, part):
    """Net force (N) with the ring moved by ``part`` of (d_x, d_y) from (x, z), and its push that way (N m)."""
    y[POSITION + X], y[POSITION + Y] = x + part * d_x, z + part * d_y
    balance_rollers(model, t, y)
    f_x, f_y = net_force(model, y)
    return f_x, f_y, f_x * d_x + f_y * d_y


@jit
def search_along(model, t, y, d_x, d_y, push):
    """Go along (d_x, d_y) (m) until the force no longer pushes that way; the full length if it never stops.

    ``push`` is the force along the way at its start. Returns the net force (N) at the end.
    """
    x, z = y[POSITION + X], y[POSITION + Y]
    f_x, f_y, end = push_at(model, t, y, x, z, d_x, d_y, 1.0)
    if abs(end) <= 0.5 * push or end > 0.0:
        return f_x, f_y
    low, high = 0.0, 1.0
    for _ in range(60):
        part = 0.5 * (low + high)
        f_x, f_y, here = push_at(model, t, y, x, z, d_x, d_y, part)
        if abs(here) <= 0.5 * push:
            break
        if here > 0.0:
            low = part
        else:
            high = part
    return f_x, f_y


@jit
def find_rest(model, t, y):
    """Put ring and rollers at rest at time ``t`` (s), starting from the ring position in ``y``.

    Newton on the net force with a line search on the energy's slope. Returns the residual force (N);
    velocities are left alone.
    """
    goal = RESIDUAL * (model.support.F + 1e-3)
    balance_rollers(model, t, y)
    f_x, f_y = net_force(model, y)
    for _ in range(MAX_STEPS):
        if hypot(f_x, f_y) <= goal:
            break
        k_xx, k_xy, k_yy = ring_stiffness(model, y)
        d_x, d_y = solve_2x2(k_xx, k_xy, k_yy, f_x, f_y)
        shorter = min(1.0, LONGEST_STEP / hypot(d_x, d_y))
        d_x, d_y = shorter * d_x, shorter * d_y
        f_x, f_y = search_along(model, t, y, d_x, d_y, f_x * d_x + f_y * d_y)
    return hypot(f_x, f_y)


@jit
def force_along(model, t, y, x):
    """Net force (N) along the load line with the ring at ``x`` (m) on it: falls as x grows."""
    y[POSITION + X], y[POSITION + Y] = x, 0.0
    balance_rollers(model, t, y)
    return net_force(model, y)[0]


@jit
def first_guess(model, t, y):
    """Put the ring on the load line where the force along it vanishes, by bisection to a nanometre."""
    reach = 1e-7 + 2.0 * abs(model.bearing.gap)
    while force_along(model, t, y, -reach) < 0.0:
        reach *= 2.0
    low, high = -reach, reach
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        if force_along(model, t, y, middle) > 0.0:
            low = middle
        else:
            high = middle
    force_along(model, t, y, low)  # the side on which rollers carry


@jit
def rest_from_scratch(model, t, y):
    """``find_rest`` with nothing known beforehand; all velocities zero. Returns the residual force (N)."""
    y[POSITION : POSITION + ROW] = 0.0
    y[VELOCITY : VELOCITY + ROW] = 0.0
    first_guess(model, t, y)
    return find_rest(model, t, y)


def mean_rest(model, y, samples=32):
    """Mean ring position (m, m) over one ball pass at rest: the anchor of the bracket.

    Raises ``NoEquilibrium`` if one is not found to 1e-8 of the load.
    """
    pass_time = 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
    positions = []
    for n in range(samples):
        find = rest_from_scratch if n == 0 else find_rest
        residual = find(model, (n + 0.5) / samples * pass_time, y)
        if not residual <= 1e-8 * model.support.F:
            raise NoEquilibrium(f"no static equilibrium: {residual:g} N left of {model.support.F:g} N")
        positions.append((y[POSITION + X], y[POSITION + Y]))
    x, z = np.mean(positions, axis=0)
    return float(x), float(z)
