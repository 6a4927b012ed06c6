"""What every model with a moving ring shares: angles of the rollers, and the ring's own equation of motion."""

from math import cos, sin

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import ACCELERATION, COS, COS_0, POSITION, Q_O, SIN, SIN_0, VELOCITY, X, Y


@jit
def turn(theta_c, y, n):
    """Cosine and sine of every roller's angle, the first roller standing at ``theta_c`` (rad)."""
    C, S = cos(theta_c), sin(theta_c)
    for j in range(n):
        y[COS + j] = C * y[COS_0 + j] - S * y[SIN_0 + j]
        y[SIN + j] = S * y[COS_0 + j] + C * y[SIN_0 + j]


@jit
def accelerate_ring(model, y, n):
    """m_o u'' = -F e_0 - F_across e_90 - k_b (u - u_0) - c_b u' + sum_j Q_o,j e_r(theta_j)."""
    support, m_o = model.support, model.bearing.m_o
    f_x, f_y = 0.0, 0.0
    for j in range(n):
        f_x = add(f_x, y[Q_O + j] * y[COS + j])
        f_y = add(f_y, y[Q_O + j] * y[SIN + j])
    f_x += -support.F - support.k_b * (y[POSITION + X] - support.x_0) - support.c_b * y[VELOCITY + X]
    f_y += -support.F_across - support.k_b * (y[POSITION + Y] - support.y_0) - support.c_b * y[VELOCITY + Y]
    y[ACCELERATION + X] = f_x / m_o
    y[ACCELERATION + Y] = f_y / m_o
