"""Twists of ``spatial``: what a unit of a coordinate, or of its rate, moves and turns a roller by.

Along e_r, e_theta and e_z of the roller; relative to the body where it is the body's coordinate.
"""

from bearingsim.core.geometry.vectors import both, cross, turning
from bearingsim.core.jit import jit
from bearingsim.core.layout import COS, EPS_V, OMEGA, SIN, SKEW_V, TILT_V, UPRIGHT_V, Q, V
from bearingsim.core.parts.space_slopes import NONE, axis_of

RADIAL, ORBIT, SPIN, AXIAL, LEAN = range(5)  # a roller's coordinates; its axis has two
TIP, TURN = 3, 5  # a body's: its axis, its angle; first its centre


@jit
def lean_by(a, r, t):
    """Change of an axis whose components along e_r and e_theta change by ``r``, ``t``, and the turn it makes."""
    da = r, t, -(a[0] * r + a[1] * t) / a[2]
    return da, both(1.0, cross(a, da), (r * a[1] - a[0] * t) / (1.0 + a[2]), a)


@jit
def roller_place(i, middle, omega_cage, y, j):
    """Displacement and turn of roller ``j`` by its coordinate ``i``; changes of velocity and angular velocity."""
    a, c, s, r, theta_v = axis_of(y, j), y[COS + j], y[SIN + j], middle + y[Q + j], omega_cage + y[EPS_V + j]
    if i == RADIAL:
        return (1.0, 0.0, 0.0), NONE, (0.0, theta_v, 0.0), NONE
    if i == ORBIT:
        return (0.0, r, 0.0), NONE, (-r * theta_v, y[V + j], 0.0), NONE
    if i == SPIN:
        return NONE, a, NONE, NONE
    if i == AXIAL:
        return (0.0, 0.0, 1.0), NONE, NONE, NONE
    da, turn = lean_by(a, s, c) if i > LEAN else lean_by(a, c, -s)
    nods = cross(da, (y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j]))
    return NONE, turn, NONE, both(1.0, nods, y[OMEGA + j], da)


@jit
def roller_speed(i, middle, y, j):
    """Velocity and angular velocity of roller ``j`` by the rate of its coordinate ``i``."""
    a, c, s = axis_of(y, j), y[COS + j], y[SIN + j]
    if i == RADIAL:
        return (1.0, 0.0, 0.0), NONE
    if i == ORBIT:
        return (0.0, middle + y[Q + j], 0.0), NONE
    if i == SPIN:
        return NONE, a
    if i == AXIAL:
        return (0.0, 0.0, 1.0), NONE
    return NONE, (lean_by(a, s, c) if i > LEAN else lean_by(a, c, -s))[1]


@jit
def along(k, c, s):
    """Direction of a body's coordinate ``k`` of its centre, or of its axis (less TIP)."""
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
    turns = turning(body, c, s)
    if k < TIP:
        u = along(k, c, s)
        return (-u[0], -u[1], -u[2]), NONE, cross(turns, u), NONE
    b = body.a_x * c + body.a_y * s, body.a_y * c - body.a_x * s, body.a_z
    b_v = body.w_x * c + body.w_y * s, body.w_y * c - body.w_x * s, body.w_z
    turn, faster = b, NONE
    if k < TURN:
        to = along(k - TIP, c, s)
        db, turn = lean_by(b, to[0], to[1])
        faster = both(1.0, cross(db, b_v), body.turns, db)
    moves = both(-1.0, cross(faster, d), -1.0, cross(turn, v))
    return cross(d, turn), (-turn[0], -turn[1], -turn[2]), moves, both(-1.0, faster, -1.0, cross(turn, omega))


@jit
def body_speed(k, body, d, c, s):
    """Velocity and angular velocity of a roller relative to a body by the rate of the body's coordinate ``k``."""
    if k < TIP:
        u = along(k, c, s)
        return (-u[0], -u[1], -u[2]), NONE
    b = body.a_x * c + body.a_y * s, body.a_y * c - body.a_x * s, body.a_z
    turn = b
    if k < TURN:
        to = along(k - TIP, c, s)
        turn = lean_by(b, to[0], to[1])[1]
    return cross(d, turn), (-turn[0], -turn[1], -turn[2])
