"""The derivatives of ``spatial``'s accelerations: by velocity exact, by position to 1e-3 and better.

What rollers feel of a body - the rings, the cage - follows from their place and velocity relative to it: a twist
that each coordinate of roller or body makes (``parts/twists.py``), and matrices that answer it with a wrench
(``parts/wrench.py``). Wrenches become accelerations by Newton's and Euler's equations. Left out: how moments that
stand turn a ring's axis as it leans, the centripetal terms of an axis that nods, and the terms that
``parts/space_slopes.py`` names. Friction counts without lag.
"""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.orientation import Body, body_at
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.vectors import angular_velocity, combine, cross, dot
from bearingsim.core.jit import jit
from bearingsim.core.models.planar_derivatives import by_own_motion, by_springs, mobilities
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.cage import cage_constraint
from bearingsim.core.parts.cage_in_space import cage_body
from bearingsim.core.parts.cage_slopes import guide_change
from bearingsim.core.parts.mounts import mount_mobility, mount_springs
from bearingsim.core.parts.shaft import mobility
from bearingsim.core.parts.space_slopes import (
    ZERO_3,
    axis_of,
    cage_mobility_in_space,
    flange_jacobian,
    pocket_jacobian,
    race_jacobian,
    relative_to_body,
)
from bearingsim.core.parts.twists import (
    ANGLE,
    AXIS,
    FIRST_AXIS,
    SPIN,
    axis_change,
    body_place,
    body_speed,
    roller_place,
    roller_speed,
)
from bearingsim.core.parts.wrench import (
    BY_SPEED,
    IN_CONTACT,
    clear_wrenches,
    combine_six,
    constant_wrench,
    matrix_of,
    matrix_times,
    rolling_wrench,
    six,
    wrench_change,
)

OWN, SHARED = 6, 17
OF_OUTER = (lay.X, lay.X + 1, 8, 11, 14, lay.PSI)  # the bodies' shared coordinates
OF_CAGE = (lay.X_C, lay.X_C + 1, 9, 12, 15, lay.PHI_C)
OF_INNER = (lay.X_I, lay.X_I + 1, 10, 13, 16, -1)


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
def clear_jacobians(y, n):
    """Empty both arrows."""
    for matrix in (lay.POSITION_JACOBIAN, lay.VELOCITY_JACOBIAN):
        for i in range(OWN):
            for k in range(OWN):
                for j in range(n):
                    y[lay.diagonal_block(matrix, i, k) + j] = 0.0
            for k in range(SHARED):
                for j in range(n):
                    y[lay.border_column(matrix, i, k) + j] = 0.0
                for j in range(n):
                    y[lay.border_row(matrix, k, i) + j] = 0.0
        for k in range(SHARED):
            for m in range(SHARED):
                y[lay.corner_block(matrix, k, m)] = 0.0


# Wrenches: what they accelerate


@jit
def accelerate_roller(model, w, y, j):
    """Accelerations of the coordinates of roller ``j`` under a wrench."""
    a, c, s, M = axis_of(y, j), y[lay.COS + j], y[lay.SIN + j], (w[3], w[4], w[5])
    held, per_mass = cage_constraint(model.cage, 1.0), y[lay.INVERSE_MASS + j]
    r = 0.5 * (model.bearing.R_o + model.bearing.R_i) + y[lay.RADIAL + j]
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
def body_reaction(mobile, w, d, M, c, s):
    """What the opposite of a wrench on a roller at ``d`` from the body's centre accelerates the body by.

    M: moment besides, about the body's centre, on the roller.
    """
    F = w[0], w[1], w[2]
    M = combine(1.0, M, 1.0, combine(1.0, (w[3], w[4], w[5]), 1.0, cross(d, F)))
    force = -F[0] * c + F[1] * s, -F[0] * s - F[1] * c, -F[2]
    return accelerate_body(mobile, force, (-M[0] * c + M[1] * s, -M[0] * s - M[1] * c, -M[2]))


@jit
def add_to_roller_column(matrix, i, model, mobile, w, d, M, y, j):
    """Add a wrench, and a moment on the body, to the column of coordinate ``i`` of roller ``j``."""
    on_roller = accelerate_roller(model, w, y, j)
    on_body = body_reaction(mobile, w, d, M, y[lay.COS + j], y[lay.SIN + j])
    for k in range(OWN):
        y[lay.diagonal_block(matrix, k, i) + j] += on_roller[k]
    for k in range(mobile.free):
        y[lay.border_row(matrix, mobile.of[k], i) + j] = on_body[k]


@jit
def add_to_shared_column(matrix, m, model, mobile, w, d, M, y, j):
    """Add it to the column of the body's coordinate ``m``."""
    on_roller = accelerate_roller(model, w, y, j)
    on_body = body_reaction(mobile, w, d, M, y[lay.COS + j], y[lay.SIN + j])
    for k in range(OWN):
        y[lay.border_column(matrix, k, mobile.of[m]) + j] = on_roller[k]
    for k in range(mobile.free):
        y[lay.corner_block(matrix, mobile.of[k], mobile.of[m])] += on_body[k]


@jit
def roller_body_columns(model, mobile, omega_cage, y):
    """The columns of what acts between the rollers and a body, from the matrices of ``parts/wrench.py``."""
    for j in range(model.bearing.Z):
        if y[matrix_of(j) + IN_CONTACT] > 0.0:
            by_roller(model, mobile, omega_cage, y, j)
            by_body(model, mobile, omega_cage, y, j)


@jit
def by_roller(model, mobile, omega_cage, y, j):
    """The columns of the coordinates of roller ``j``."""
    b, at = model.bearing, matrix_of(j)
    middle, F = 0.5 * (b.R_o + b.R_i), constant_wrench(j, y)[0]
    d, _, _ = relative_to_body(mobile.body, b, omega_cage, y, j)
    turns = angular_velocity(mobile.body, y[lay.COS + j], y[lay.SIN + j])
    faster = b.R_w if omega_cage + y[lay.EPS_V + j] > y[lay.OMEGA + j] else -b.R_w
    rolls = (0.0, faster, -faster, 0.0, 0.0, 0.0)  # the rolling speed, with the orbit's and with the spin
    for i in range(OWN):
        P, phi, dv, faster = roller_place(i, middle, omega_cage, y, j)
        w = wrench_change(j, six(P, phi), six(combine(1.0, dv, -1.0, cross(turns, P)), faster), y)
        add_to_roller_column(lay.POSITION_JACOBIAN, i, model, mobile, w, d, cross(P, F), y, j)
        W, S = roller_speed(i, middle, y, j)
        w = combine_six(1.0, matrix_times(at + BY_SPEED, six(W, S), y), rolls[i], rolling_wrench(j, y))
        add_to_roller_column(lay.VELOCITY_JACOBIAN, i, model, mobile, w, d, ZERO_3, y, j)


@jit
def by_body(model, mobile, omega_cage, y, j):
    """The columns of the body's coordinates, of what it does to roller ``j``: forces that stand turn with it."""
    at, c, s, (F, M) = matrix_of(j), y[lay.COS + j], y[lay.SIN + j], constant_wrench(j, y)
    d, v, omega = relative_to_body(mobile.body, model.bearing, omega_cage, y, j)
    for m in range(mobile.free):
        P, phi, dv, faster = body_place(m, mobile.body, d, v, omega, c, s)
        w = combine_six(
            1.0, wrench_change(j, six(P, phi), six(dv, faster), y), -1.0, six(cross(phi, F), cross(phi, M))
        )
        away = cross(P, F) if m < FIRST_AXIS else ZERO_3  # it leaves the force's line
        add_to_shared_column(lay.POSITION_JACOBIAN, m, model, mobile, w, d, away, y, j)
        W, S = body_speed(m, mobile.body, d, c, s)
        add_to_shared_column(
            lay.VELOCITY_JACOBIAN, m, model, mobile, matrix_times(at + BY_SPEED, six(W, S), y), d, ZERO_3, y, j
        )


@jit
def tilting_rollers(model, y):
    """What the moments that stand do as a roller's axis leans out of them."""
    for j in range(model.bearing.Z):
        a, c, s, I_r = axis_of(y, j), y[lay.COS + j], y[lay.SIN + j], model.bearing.I_r
        spin, M = I_r * y[lay.OMEGA + j], (y[lay.MOMENT_R + j], y[lay.MOMENT_T + j], y[lay.MOMENT_Z + j])
        gyro = combine(1.0, M, -spin, (y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]))
        real, held = model.bearing.m_r * y[lay.INVERSE_MASS + j], cage_constraint(model.cage, 1.0)
        l_r = y[lay.AXIS_X_A + j] * c + y[lay.AXIS_Y_A + j] * s
        l_t = y[lay.AXIS_Y_A + j] * c - y[lay.AXIS_X_A + j] * s
        for i in (AXIS, AXIS + 1):
            da, _ = axis_change(a, s, c) if i > AXIS else axis_change(a, c, -s)
            n = cross(gyro, da)
            n_r, n_t = real * n[0] / model.I_t, real * held * n[1] / model.I_t
            wound = (n_r * a[1] - a[0] * n_t + l_r * da[1] - da[0] * l_t) / (1.0 + a[2])
            y[lay.diagonal_block(lay.POSITION_JACOBIAN, SPIN, i) + j] += held * (real * dot(M, da) / I_r - wound)
            y[lay.diagonal_block(lay.POSITION_JACOBIAN, AXIS, i) + j] += n_r * c - n_t * s
            y[lay.diagonal_block(lay.POSITION_JACOBIAN, AXIS + 1, i) + j] += n_r * s + n_t * c


@jit
def spinning_rollers(model, y):
    """What their spin does as the rollers' axes nod: M = -I_a omega a'."""
    for j in range(model.bearing.Z):
        a, c, s, I_r = axis_of(y, j), y[lay.COS + j], y[lay.SIN + j], model.bearing.I_r
        nods = -I_r * y[lay.TILT_V + j], -I_r * y[lay.SKEW_V + j], -I_r * y[lay.AXIS_Z_V + j]
        for i in (SPIN, AXIS, AXIS + 1):
            M = nods
            if i > SPIN:
                da, _ = axis_change(a, s, c) if i > AXIS else axis_change(a, c, -s)
                spin = -I_r * y[lay.OMEGA + j]
                M = spin * da[0], spin * da[1], spin * da[2]
            on_roller = accelerate_roller(model, six(ZERO_3, M), y, j)
            for k in range(OWN):
                y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, k, i) + j] += on_roller[k]


@jit
def carry_rollers(model, omega_cage, y):
    """A cage that keeps a roller from skewing carries its axis round: a'' has 2 a_r' theta' along e_theta."""
    kept = 1.0 - cage_constraint(model.cage, 1.0)
    for j in range(model.bearing.Z):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        turn = 2.0 * kept * (omega_cage + y[lay.EPS_V + j])
        for i, part in ((AXIS, c), (AXIS + 1, s)):
            y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, AXIS, i) + j] -= turn * part * s
            y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, AXIS + 1, i) + j] += turn * part * c


@jit
def spinning_body(mobile, y):
    """The same of a body."""
    body, I_a = mobile.body, mobile.I_a
    b = body.a_x, body.a_y, body.a_z
    for m in range(FIRST_AXIS, mobile.free):
        M = -I_a * body.w_x, -I_a * body.w_y, -I_a * body.w_z
        if m < ANGLE:
            db, _ = axis_change(b, 1.0, 0.0) if m == FIRST_AXIS else axis_change(b, 0.0, 1.0)
            M = -I_a * body.omega * db[0], -I_a * body.omega * db[1], -I_a * body.omega * db[2]
        on_body = accelerate_body(mobile, ZERO_3, M)
        for k in range(mobile.free):
            y[lay.corner_block(lay.VELOCITY_JACOBIAN, mobile.of[k], mobile.of[m])] += on_body[k]


@jit
def mounted(held, of, y):
    """Springs and dampers of a ring along the axis and against leaning."""
    k_z, c_z, k_tilt, c_tilt = mount_springs(held)
    for k, K, C in ((2, k_z, c_z), (3, k_tilt, c_tilt), (4, k_tilt, c_tilt)):
        y[lay.corner_block(lay.POSITION_JACOBIAN, of[k], of[k])] -= K
        y[lay.corner_block(lay.VELOCITY_JACOBIAN, of[k], of[k])] -= C


@jit
def spatial_jacobian(model, t, y):
    """``linearise`` of ``spatial``, from the rows that ``accelerations`` filled."""
    b = model.bearing
    n = lanes(b)
    _, rate, _ = kinematic_time(model.motion, t)
    omega_i, spin = b.omega_i * rate, (b.omega_c - b.omega_b) * rate
    omega_cage = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C]
    outer = body_at(y, lay.X, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, y[lay.VELOCITY + lay.PSI])
    inner = body_at(y, lay.X_I, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y, omega_i)
    cage = cage_body(model.cage_z, omega_cage, y)
    mobilities(model, y, n)
    clear_jacobians(y, n)

    axial, tip, I_a = mount_mobility(model.mount_o)
    turn = mobility(model.bracket)
    mobile = Mobile(outer, 6, OF_OUTER, y[lay.MOBILITY_SHARED + lay.X], axial, tip, turn, turn * I_a, I_a)
    clear_wrenches(b.Z, y)
    race_jacobian(OuterSide(), model.outer, model, t, outer, outer.a_z, inner.a_z, omega_cage, y, n)
    flange_jacobian(model.flanges, OuterSide(), model, outer, omega_cage, y)
    roller_body_columns(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    axial, tip, I_a = mount_mobility(model.mount_i)
    mobile = Mobile(inner, 5, OF_INNER, y[lay.MOBILITY_SHARED + lay.X_I], axial, tip, 0.0, 0.0, I_a)
    clear_wrenches(b.Z, y)
    race_jacobian(InnerSide(), model.inner, model, t, inner, outer.a_z, inner.a_z, omega_cage, y, n)
    flange_jacobian(model.flanges, InnerSide(), model, inner, omega_cage, y)
    roller_body_columns(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    axial, tip, I_a = cage_mobility_in_space(model.cage_z, model.cage)
    mobile = Mobile(
        cage,
        6,
        OF_CAGE,
        y[lay.MOBILITY_SHARED + lay.X_C],
        axial,
        tip,
        y[lay.MOBILITY_SHARED + lay.PHI_C],
        1.0,
        I_a,
    )
    clear_wrenches(b.Z, y)
    pocket_jacobian(model.cage, model, cage, omega_cage, spin, y)
    roller_body_columns(model, mobile, omega_cage, y)
    spinning_body(mobile, y)

    spinning_rollers(model, y)
    tilting_rollers(model, y)
    carry_rollers(model, omega_cage, y)
    by_own_motion(model, omega_cage, y, n)
    guide_change(model.cage, omega_cage, omega_i, y)
    by_springs(model, y)
    mounted(model.mount_o, OF_OUTER, y)
    mounted(model.mount_i, OF_INNER, y)
