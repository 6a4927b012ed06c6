"""What every model with a moving ring shares: angles of the rollers, and the ring's own equation of motion.

m_o u'' = -F e_0 - F_across e_90 - k_b (u - u_0) - c_b u' + sum_j Q_o,j e_r(theta_j)
"""

from math import cos, sin

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    ACCELERATION,
    BY_POSITION,
    BY_VELOCITY,
    COS,
    COS_0,
    F_X,
    F_Y,
    POSITION,
    Q_O,
    SIN,
    SIN_0,
    VELOCITY,
    X,
    Y,
    border_block,
)


@jit
def turn(theta_c, y, n):
    """Cosine and sine of every roller's angle, the first roller standing at ``theta_c`` (rad)."""
    C, S = cos(theta_c), sin(theta_c)
    for j in range(n):
        y[COS + j] = C * y[COS_0 + j] - S * y[SIN_0 + j]
        y[SIN + j] = S * y[COS_0 + j] + C * y[SIN_0 + j]


@jit
def standing_force(support, f_x, f_y, y):
    """``f_x``, ``f_y`` (N), with the load and the bracket's spring: what acts on a ring that stands."""
    f_x = f_x - support.F - support.k_b * (y[POSITION + X] - support.x_0)
    f_y = f_y - support.F_across - support.k_b * (y[POSITION + Y] - support.y_0)
    return f_x, f_y


@jit
def moving_force(support, f_x, f_y, y):
    """The same with the bracket's damper: what acts on a ring that moves."""
    f_x, f_y = standing_force(support, f_x, f_y, y)
    return f_x - support.c_b * y[VELOCITY + X], f_y - support.c_b * y[VELOCITY + Y]


@jit
def accelerate(m_o, f_x, f_y, y):
    """Write the ring's acceleration under all forces (N)."""
    y[ACCELERATION + X] = f_x / m_o
    y[ACCELERATION + Y] = f_y / m_o


@jit
def accelerate_ring(model, y, n):
    """The ring's acceleration under contacts whose normals go through the bearing's centre."""
    f_x, f_y = 0.0, 0.0
    for j in range(n):
        f_x = add(f_x, y[Q_O + j] * y[COS + j])
        f_y = add(f_y, y[Q_O + j] * y[SIN + j])
    held_x, held_y = moving_force(model.support, 0.0, 0.0, y)
    accelerate(model.bearing.m_o, f_x + held_x, f_y + held_y, y)


@jit
def move_outer_ring(model, y):
    """Its acceleration under what the rollers, and a guided cage, have pushed into its cells."""
    f_x, f_y = moving_force(model.support, y[F_X], y[F_Y], y)
    accelerate(model.bearing.m_o, f_x, f_y, y)


@jit
def linearise_ring(model, K, C, y, n):
    """Derivatives of the ring's acceleration by its own position and velocity; fills the border's blocks.

    K, C: rows of how Q_o grows with the outer contact's approach and its rate as the ring sees them, that is with
    delta = -u.e_r and v = -(u' - omega_c x u).e_r and a roller that stays where it is (N/m, N s/m).
    """
    support, per_mass, omega_c = model.support, 1.0 / model.bearing.m_o, model.bearing.omega_c
    k_xx, k_xy, k_yx, k_yy, c_xx, c_xy, c_yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        by_x, by_y = y[K + j] * c - y[C + j] * omega_c * s, y[K + j] * s + y[C + j] * omega_c * c
        k_xx, k_xy = add(k_xx, c * by_x), add(k_xy, c * by_y)
        k_yx, k_yy = add(k_yx, s * by_x), add(k_yy, s * by_y)
        c_xx, c_xy, c_yy = add(c_xx, y[C + j] * c * c), add(c_xy, y[C + j] * c * s), add(c_yy, y[C + j] * s * s)
    y[border_block(BY_POSITION, X, X)] = -per_mass * (k_xx + support.k_b)
    y[border_block(BY_POSITION, X, Y)] = -per_mass * k_xy
    y[border_block(BY_POSITION, Y, X)] = -per_mass * k_yx
    y[border_block(BY_POSITION, Y, Y)] = -per_mass * (k_yy + support.k_b)
    y[border_block(BY_VELOCITY, X, X)] = -per_mass * (c_xx + support.c_b)
    y[border_block(BY_VELOCITY, X, Y)] = -per_mass * c_xy
    y[border_block(BY_VELOCITY, Y, X)] = -per_mass * c_xy
    y[border_block(BY_VELOCITY, Y, Y)] = -per_mass * (c_yy + support.c_b)
