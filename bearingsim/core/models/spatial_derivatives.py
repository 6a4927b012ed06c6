"""The derivatives of ``spatial``'s accelerations: by velocity exact, by position to 1e-3 and better.

What rollers feel of a body - the rings, the cage - follows from their place and velocity relative to it: a twist
that each coordinate of roller or body makes (``parts/twists.py``), and matrices that answer it with a wrench
(``parts/wrench.py``). Wrenches become accelerations by Newton's and Euler's equations. Left out: how moments that
stand turn a ring's axis as it leans, the centripetal terms of an axis that nods, and the terms that
``parts/space_slopes.py`` names. Friction counts without lag.
"""

from typing import Any, NamedTuple

from bearingsim.core.geometry.motion import elapsed
from bearingsim.core.geometry.orientation import Body, body_at
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.vectors import both, cross, dot, turning
from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    AXIS_X_A,
    AXIS_Y_A,
    BY_POSITION,
    BY_VELOCITY,
    COS,
    EPS_V,
    INVERSE_MASS,
    LEAN_X,
    LEAN_X_I,
    LEAN_Y,
    LEAN_Y_I,
    MOBILITY,
    OMEGA,
    PHI_C,
    PSI,
    SIN,
    SKEW_V,
    TILT_V,
    TURN_R,
    TURN_T,
    TURN_Z,
    UPRIGHT_V,
    VELOCITY,
    X_C,
    X_I,
    Z_I,
    Q,
    X,
    Z,
    border_block,
    from_border,
    own_block,
    to_border,
)
from bearingsim.core.models.planar_derivatives import by_own_motion, by_springs, mobilities
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.cage import let_go
from bearingsim.core.parts.cage_in_space import cage_body
from bearingsim.core.parts.cage_slopes import guide_change
from bearingsim.core.parts.mounts import mount_mobility, mount_springs
from bearingsim.core.parts.shaft import mobility
from bearingsim.core.parts.space_slopes import (
    NONE,
    axis_of,
    cage_mobility_in_space,
    seen_by,
    touch_flanges,
    touch_pockets,
    touch_race,
)
from bearingsim.core.parts.twists import (
    LEAN,
    SPIN,
    TIP,
    TURN,
    body_place,
    body_speed,
    lean_by,
    roller_place,
    roller_speed,
)
from bearingsim.core.parts.wrench import (
    BY_SPEED,
    TOUCHES,
    answer,
    clear_wrenches,
    of_roller,
    plus,
    rolling_wrench,
    six,
    standing_wrench,
    times,
)

OWN, SHARED = 6, 17
OF_OUTER = (X, X + 1, 8, 11, 14, PSI)  # the bodies' shared coordinates
OF_CAGE = (X_C, X_C + 1, 9, 12, 15, PHI_C)
OF_INNER = (X_I, X_I + 1, 10, 13, 16, -1)


class Mobile(NamedTuple):
    """A body, and what forces and moments accelerate it by.

    free: how many coordinates, ``of``: their shared numbers; force, axial: 1/kg across the bearing's axis and
    along it; tip, turn: 1/(kg m^2) of the axis and about it; wound: how much of the axis' winding its angle lacks;
    I_a: kg m^2.
    """

    body: Body
    free: int
    of: Any
    force: float
    axial: float
    tip: float
    turn: float
    wound: float
    I_a: float


@jit
def clear(y, n):
    """Empty both arrows."""
    for matrix in (BY_POSITION, BY_VELOCITY):
        for i in range(OWN):
            for k in range(OWN):
                for j in range(n):
                    y[own_block(matrix, i, k) + j] = 0.0
            for k in range(SHARED):
                for j in range(n):
                    y[from_border(matrix, i, k) + j] = 0.0
                for j in range(n):
                    y[to_border(matrix, k, i) + j] = 0.0
        for k in range(SHARED):
            for m in range(SHARED):
                y[border_block(matrix, k, m)] = 0.0


# Wrenches: what they accelerate


@jit
def accelerate_roller(model, w, y, j):
    """Accelerations of the coordinates of roller ``j`` under a wrench."""
    a, c, s, M = axis_of(y, j), y[COS + j], y[SIN + j], (w[3], w[4], w[5])
    held, per_mass = let_go(model.cage, 1.0), y[INVERSE_MASS + j]
    r = 0.5 * (model.bearing.R_o + model.bearing.R_i) + y[Q + j]
    n = cross(M, a)
    l_r, l_t = n[0] / model.I_t, held * n[1] / model.I_t
    wound = (l_r * a[1] - a[0] * l_t) / (1.0 + a[2])
    spin = dot(M, a) / model.bearing.I_r - wound
    per_t = held * per_mass
    return w[0] * per_mass, w[1] * per_t / r, held * spin, w[2] * per_t, l_r * c - l_t * s, l_r * s + l_t * c


@jit
def accelerate_body(mobile, F, M):
    """Accelerations of a body's coordinates under a force and a moment along e_0, e_90, e_z."""
    b = mobile.body.a_x, mobile.body.a_y, mobile.body.a_z
    n = cross(M, b)
    l_x, l_y = mobile.tip * n[0], mobile.tip * n[1]
    wound = (l_x * b[1] - b[0] * l_y) / (1.0 + b[2])
    turn = mobile.turn * dot(M, b) - mobile.wound * wound
    return mobile.force * F[0], mobile.force * F[1], mobile.axial * F[2], l_x, l_y, turn


@jit
def react(mobile, w, d, M, c, s):
    """What the opposite of a wrench on a roller at ``d`` from the body's centre accelerates the body by.

    M: moment besides, about the body's centre, on the roller.
    """
    F = w[0], w[1], w[2]
    M = both(1.0, M, 1.0, both(1.0, (w[3], w[4], w[5]), 1.0, cross(d, F)))
    force = -F[0] * c + F[1] * s, -F[0] * s - F[1] * c, -F[2]
    return accelerate_body(mobile, force, (-M[0] * c + M[1] * s, -M[0] * s - M[1] * c, -M[2]))


@jit
def keep_own(matrix, i, model, mobile, w, d, M, y, j):
    """Add a wrench, and a moment on the body, to the column of coordinate ``i`` of roller ``j``."""
    on_roller, on_body = accelerate_roller(model, w, y, j), react(mobile, w, d, M, y[COS + j], y[SIN + j])
    for k in range(OWN):
        y[own_block(matrix, k, i) + j] += on_roller[k]
    for k in range(mobile.free):
        y[to_border(matrix, mobile.of[k], i) + j] = on_body[k]


@jit
def keep_shared(matrix, m, model, mobile, w, d, M, y, j):
    """Add it to the column of the body's coordinate ``m``."""
    on_roller, on_body = accelerate_roller(model, w, y, j), react(mobile, w, d, M, y[COS + j], y[SIN + j])
    for k in range(OWN):
        y[from_border(matrix, k, mobile.of[m]) + j] = on_roller[k]
    for k in range(mobile.free):
        y[border_block(matrix, mobile.of[k], mobile.of[m])] += on_body[k]


@jit
def between(model, mobile, omega_cage, y):
    """The columns of what acts between the rollers and a body, from the matrices of ``parts/wrench.py``."""
    for j in range(model.bearing.Z):
        if y[of_roller(j) + TOUCHES] > 0.0:
            by_roller(model, mobile, omega_cage, y, j)
            by_body(model, mobile, omega_cage, y, j)


@jit
def by_roller(model, mobile, omega_cage, y, j):
    """The columns of the coordinates of roller ``j``."""
    b, at = model.bearing, of_roller(j)
    middle, F = 0.5 * (b.R_o + b.R_i), standing_wrench(j, y)[0]
    d, _, _ = seen_by(mobile.body, b, omega_cage, y, j)
    turns = turning(mobile.body, y[COS + j], y[SIN + j])
    faster = b.R_w if omega_cage + y[EPS_V + j] > y[OMEGA + j] else -b.R_w
    rolls = (0.0, faster, -faster, 0.0, 0.0, 0.0)  # the rolling speed, with the orbit's and with the spin
    for i in range(OWN):
        P, phi, dv, faster = roller_place(i, middle, omega_cage, y, j)
        w = answer(j, six(P, phi), six(both(1.0, dv, -1.0, cross(turns, P)), faster), y)
        keep_own(BY_POSITION, i, model, mobile, w, d, cross(P, F), y, j)
        W, S = roller_speed(i, middle, y, j)
        w = plus(1.0, times(at + BY_SPEED, six(W, S), y), rolls[i], rolling_wrench(j, y))
        keep_own(BY_VELOCITY, i, model, mobile, w, d, NONE, y, j)


@jit
def by_body(model, mobile, omega_cage, y, j):
    """The columns of the body's coordinates, of what it does to roller ``j``: forces that stand turn with it."""
    at, c, s, (F, M) = of_roller(j), y[COS + j], y[SIN + j], standing_wrench(j, y)
    d, v, omega = seen_by(mobile.body, model.bearing, omega_cage, y, j)
    for m in range(mobile.free):
        P, phi, dv, faster = body_place(m, mobile.body, d, v, omega, c, s)
        w = plus(1.0, answer(j, six(P, phi), six(dv, faster), y), -1.0, six(cross(phi, F), cross(phi, M)))
        away = cross(P, F) if m < TIP else NONE  # it leaves the force's line
        keep_shared(BY_POSITION, m, model, mobile, w, d, away, y, j)
        W, S = body_speed(m, mobile.body, d, c, s)
        keep_shared(BY_VELOCITY, m, model, mobile, times(at + BY_SPEED, six(W, S), y), d, NONE, y, j)


@jit
def nodding_rollers(model, y):
    """What the moments that stand do as a roller's axis leans out of them."""
    for j in range(model.bearing.Z):
        a, c, s, I_r = axis_of(y, j), y[COS + j], y[SIN + j], model.bearing.I_r
        spin, M = I_r * y[OMEGA + j], (y[TURN_R + j], y[TURN_T + j], y[TURN_Z + j])
        gyro = both(1.0, M, -spin, (y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j]))
        real, held = model.bearing.m_r * y[INVERSE_MASS + j], let_go(model.cage, 1.0)
        l_r, l_t = y[AXIS_X_A + j] * c + y[AXIS_Y_A + j] * s, y[AXIS_Y_A + j] * c - y[AXIS_X_A + j] * s
        for i in (LEAN, LEAN + 1):
            da, _ = lean_by(a, s, c) if i > LEAN else lean_by(a, c, -s)
            n = cross(gyro, da)
            n_r, n_t = real * n[0] / model.I_t, real * held * n[1] / model.I_t
            wound = (n_r * a[1] - a[0] * n_t + l_r * da[1] - da[0] * l_t) / (1.0 + a[2])
            y[own_block(BY_POSITION, SPIN, i) + j] += held * (real * dot(M, da) / I_r - wound)
            y[own_block(BY_POSITION, LEAN, i) + j] += n_r * c - n_t * s
            y[own_block(BY_POSITION, LEAN + 1, i) + j] += n_r * s + n_t * c


@jit
def spinning_rollers(model, y):
    """What their spin does as the rollers' axes nod: M = -I_a omega a'."""
    for j in range(model.bearing.Z):
        a, c, s, I_r = axis_of(y, j), y[COS + j], y[SIN + j], model.bearing.I_r
        nods = -I_r * y[TILT_V + j], -I_r * y[SKEW_V + j], -I_r * y[UPRIGHT_V + j]
        for i in (SPIN, LEAN, LEAN + 1):
            M = nods
            if i > SPIN:
                da, _ = lean_by(a, s, c) if i > LEAN else lean_by(a, c, -s)
                spin = -I_r * y[OMEGA + j]
                M = spin * da[0], spin * da[1], spin * da[2]
            on_roller = accelerate_roller(model, six(NONE, M), y, j)
            for k in range(OWN):
                y[own_block(BY_VELOCITY, k, i) + j] += on_roller[k]


@jit
def carry_rollers(model, omega_cage, y):
    """A cage that keeps a roller from skewing carries its axis round: a'' has 2 a_r' theta' along e_theta."""
    kept = 1.0 - let_go(model.cage, 1.0)
    for j in range(model.bearing.Z):
        c, s = y[COS + j], y[SIN + j]
        turn = 2.0 * kept * (omega_cage + y[EPS_V + j])
        for i, part in ((LEAN, c), (LEAN + 1, s)):
            y[own_block(BY_VELOCITY, LEAN, i) + j] -= turn * part * s
            y[own_block(BY_VELOCITY, LEAN + 1, i) + j] += turn * part * c


@jit
def spinning_body(mobile, y):
    """The same of a body."""
    body, I_a = mobile.body, mobile.I_a
    b = body.a_x, body.a_y, body.a_z
    for m in range(TIP, mobile.free):
        M = -I_a * body.w_x, -I_a * body.w_y, -I_a * body.w_z
        if m < TURN:
            db, _ = lean_by(b, 1.0, 0.0) if m == TIP else lean_by(b, 0.0, 1.0)
            M = -I_a * body.turns * db[0], -I_a * body.turns * db[1], -I_a * body.turns * db[2]
        on_body = accelerate_body(mobile, NONE, M)
        for k in range(mobile.free):
            y[border_block(BY_VELOCITY, mobile.of[k], mobile.of[m])] += on_body[k]


@jit
def mounted(held, of, y):
    """Springs and dampers of a ring along the axis and against leaning."""
    k_z, c_z, k_lean, c_lean = mount_springs(held)
    for k, K, C in ((2, k_z, c_z), (3, k_lean, c_lean), (4, k_lean, c_lean)):
        y[border_block(BY_POSITION, of[k], of[k])] -= K
        y[border_block(BY_VELOCITY, of[k], of[k])] -= C


@jit
def differentiate_in_space(model, t, y):
    """``linearise`` of ``spatial``, from the rows that ``accelerations`` filled."""
    b = model.bearing
    n = lanes(b)
    _, rate, _ = elapsed(model.motion, t)
    omega_i, spin = b.omega_i * rate, (b.omega_c - b.omega_b) * rate
    omega_cage = b.omega_c * rate + y[VELOCITY + PHI_C]
    outer = body_at(y, X, Z, LEAN_X, LEAN_Y, y[VELOCITY + PSI])
    inner = body_at(y, X_I, Z_I, LEAN_X_I, LEAN_Y_I, omega_i)
    cage = cage_body(model.cage_z, omega_cage, y)
    mobilities(model, y, n)
    clear(y, n)

    axial, tip, I_a = mount_mobility(model.mount_o)
    turn = mobility(model.bracket)
    mobile = Mobile(outer, 6, OF_OUTER, y[MOBILITY + X], axial, tip, turn, turn * I_a, I_a)
    clear_wrenches(b.Z, y)
    touch_race(OuterSide(), model.outer, model, t, outer, outer.a_z, inner.a_z, omega_cage, y, n)
    touch_flanges(model.flanges, OuterSide(), model, outer, omega_cage, y)
    between(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    axial, tip, I_a = mount_mobility(model.mount_i)
    mobile = Mobile(inner, 5, OF_INNER, y[MOBILITY + X_I], axial, tip, 0.0, 0.0, I_a)
    clear_wrenches(b.Z, y)
    touch_race(InnerSide(), model.inner, model, t, inner, outer.a_z, inner.a_z, omega_cage, y, n)
    touch_flanges(model.flanges, InnerSide(), model, inner, omega_cage, y)
    between(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    axial, tip, I_a = cage_mobility_in_space(model.cage_z, model.cage)
    mobile = Mobile(cage, 6, OF_CAGE, y[MOBILITY + X_C], axial, tip, y[MOBILITY + PHI_C], 1.0, I_a)
    clear_wrenches(b.Z, y)
    touch_pockets(model.cage, model, cage, omega_cage, spin, y)
    between(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    spinning_rollers(model, y)
    nodding_rollers(model, y)
    carry_rollers(model, omega_cage, y)
    by_own_motion(model, omega_cage, y, n)
    guide_change(model.cage, omega_cage, omega_i, y)
    by_springs(model, y)
    mounted(model.mount_o, OF_OUTER, y)
    mounted(model.mount_i, OF_INNER, y)
