"""Twists of ``spatial``: what a unit of a coordinate, or of its rate, moves and turns a roller by.

Along e_r, e_theta and e_z of the roller; relative to the body where it is the body's coordinate.
"""

from bearingsim.core import layout as lay
from bearingsim.core.geometry.vectors import angular_velocity, combine, cross
from bearingsim.core.jit import jit
from bearingsim.core.parts.space_slopes import ZERO_3, axis_of

RADIAL, ORBIT, SPIN, AXIAL, AXIS = range(5)  # a roller's coordinates; its axis has two
FIRST_AXIS, ANGLE = 3, 5  # a body's: its axis, its angle; first its centre


@jit
def axis_change(a, r, t):
    """Change of an axis whose components along e_r and e_theta change by ``r``, ``t``, and the turn it makes."""
    da = r, t, -(a[0] * r + a[1] * t) / a[2]
    return da, combine(1.0, cross(a, da), (r * a[1] - a[0] * t) / (1.0 + a[2]), a)


@jit
def roller_place(i, middle, omega_cage, y, j):
    """Displacement and turn of roller ``j`` by its coordinate ``i``; changes of velocity and angular velocity."""
    a = axis_of(y, j)
    c = y[lay.COS + j]
    s = y[lay.SIN + j]
    r = middle + y[lay.RADIAL + j]
    theta_v = omega_cage + y[lay.EPS_V + j]
    if i == RADIAL:
        return (1.0, 0.0, 0.0), ZERO_3, (0.0, theta_v, 0.0), ZERO_3
    if i == ORBIT:
        return (0.0, r, 0.0), ZERO_3, (-r * theta_v, y[lay.RADIAL_V + j], 0.0), ZERO_3
    if i == SPIN:
        return ZERO_3, a, ZERO_3, ZERO_3
    if i == AXIAL:
        return (0.0, 0.0, 1.0), ZERO_3, ZERO_3, ZERO_3
    da, turn = axis_change(a, s, c) if i > AXIS else axis_change(a, c, -s)
    nods = cross(da, (y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]))
    return ZERO_3, turn, ZERO_3, combine(1.0, nods, y[lay.OMEGA + j], da)


@jit
def roller_speed(i, middle, y, j):
    """Velocity and angular velocity of roller ``j`` by the rate of its coordinate ``i``."""
    a, c, s = axis_of(y, j), y[lay.COS + j], y[lay.SIN + j]
    if i == RADIAL:
        return (1.0, 0.0, 0.0), ZERO_3
    if i == ORBIT:
        return (0.0, middle + y[lay.RADIAL + j], 0.0), ZERO_3
    if i == SPIN:
        return ZERO_3, a
    if i == AXIAL:
        return (0.0, 0.0, 1.0), ZERO_3
    return ZERO_3, (axis_change(a, s, c) if i > AXIS else axis_change(a, c, -s))[1]


@jit
def body_direction(k, c, s):
    """Direction of a body's coordinate ``k`` of its centre, or of its axis (less FIRST_AXIS)."""
    if k == 0:
        return c, -s, 0.0
    if k == 1:
        return s, c, 0.0
    return 0.0, 0.0, 1.0


@jit
def body_place(k, body, d, v, omega, c, s):
    """Twist of a roller relative to a body by the body's coordinate ``k``, and change of its relative velocity.

    d, v, omega: place, velocity and angular velocity of the roller as the body sees it.
    """
    turns = angular_velocity(body, c, s)
    if k < FIRST_AXIS:
        u = body_direction(k, c, s)
        return (-u[0], -u[1], -u[2]), ZERO_3, cross(turns, u), ZERO_3
    b = body.a_x * c + body.a_y * s, body.a_y * c - body.a_x * s, body.a_z
    b_v = body.w_x * c + body.w_y * s, body.w_y * c - body.w_x * s, body.w_z
    turn, faster = b, ZERO_3
    if k < ANGLE:
        to = body_direction(k - FIRST_AXIS, c, s)
        db, turn = axis_change(b, to[0], to[1])
        faster = combine(1.0, cross(db, b_v), body.omega, db)
    moves = combine(-1.0, cross(faster, d), -1.0, cross(turn, v))
    return cross(d, turn), (-turn[0], -turn[1], -turn[2]), moves, combine(-1.0, faster, -1.0, cross(turn, omega))


@jit
def body_speed(k, body, d, c, s):
    """Velocity and angular velocity of a roller relative to a body by the rate of the body's coordinate ``k``."""
    if k < FIRST_AXIS:
        u = body_direction(k, c, s)
        return (-u[0], -u[1], -u[2]), ZERO_3
    b = body.a_x * c + body.a_y * s, body.a_y * c - body.a_x * s, body.a_z
    turn = b
    if k < ANGLE:
        to = body_direction(k - FIRST_AXIS, c, s)
        turn = axis_change(b, to[0], to[1])[1]
    return cross(d, turn), (-turn[0], -turn[1], -turn[2])
