"""Where rollers stand and move in the plane, and how close they are to the races, without small angles.

With rho = |c_j - u| the distance of a roller from a ring's centre, n from there to the roller, tau across it.
"""

from math import cos, sin, sqrt

from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    CE,
    COS,
    COS_0,
    DELTA_I,
    DELTA_O,
    EPS,
    EPS_V,
    M_R,
    M_T,
    N_R,
    N_T,
    PC,
    POSITION,
    PS,
    RHO_I,
    RHO_O,
    SE,
    SIN,
    SIN_0,
    T_I,
    T_O,
    TILT_I,
    TILT_O,
    TORQUE,
    V_I,
    V_O,
    VELOCITY,
    X_I,
    Y_I,
    Q,
    V,
    X,
    Y,
)


@jit
def place(theta_c, y, n):
    """Directions of pockets and rollers, the first pocket standing at ``theta_c`` (rad).

    |EPS| stays under a hundredth, where the series are exact to rounding.
    """
    C, S = cos(theta_c), sin(theta_c)
    for j in range(n):
        pc = C * y[COS_0 + j] - S * y[SIN_0 + j]
        ps = S * y[COS_0 + j] + C * y[SIN_0 + j]
        e = y[EPS + j]
        e2 = e * e
        ce = 1.0 - e2 * (0.5 - e2 * (1.0 / 24.0 - e2 / 720.0))
        se = e * (1.0 - e2 * (1.0 / 6.0 - e2 * (1.0 / 120.0 - e2 / 5040.0)))
        y[PC + j], y[PS + j], y[CE + j], y[SE + j] = pc, ps, ce, se
        y[COS + j] = pc * ce - ps * se
        y[SIN + j] = ps * ce + pc * se


@jit
def from_centre(c, s, r, v, theta_v, u_x, u_y, v_x, v_y):
    """A roller as a ring sees it whose centre stands at u (m) and moves at ``v_x``, ``v_y`` (m/s).

    c, s: of the roller's angle; r, v: its radius (m) and radial speed (m/s); theta_v: its orbit (rad/s). Returns
    its distance rho from the centre (m), the direction n to it along e_r and e_theta, r - rho (m) without
    cancellation, and its velocity relative to the centre along e_r and e_theta (m/s).
    """
    u_r, u_t = u_x * c + u_y * s, u_y * c - u_x * s
    x = r - u_r
    rho = sqrt(x * x + u_t * u_t)
    short = u_r - u_t * u_t / (rho + x)
    return rho, x / rho, -u_t / rho, short, v - (v_x * c + v_y * s), r * theta_v - (v_y * c - v_x * s)


@jit
def approach_outer(bearing, omega_cage, y, n):
    """Approach, its rate, normal and sideways speed of every outer contact over an undamaged race."""
    gap, middle = bearing.gap, 0.5 * (bearing.R_o + bearing.R_i)
    u_x, u_y, v_x, v_y = y[POSITION + X], y[POSITION + Y], y[VELOCITY + X], y[VELOCITY + Y]
    for j in range(n):
        rho, n_r, n_t, short, d_r, d_t = from_centre(
            y[COS + j], y[SIN + j], middle + y[Q + j], y[V + j], omega_cage + y[EPS_V + j], u_x, u_y, v_x, v_y
        )
        y[RHO_O + j], y[N_R + j], y[N_T + j] = rho, n_r, n_t
        y[DELTA_O + j] = y[Q + j] - gap - short
        y[V_O + j] = n_r * d_r + n_t * d_t
        y[T_O + j] = n_r * d_t - n_t * d_r
        y[TILT_O + j] = 0.0
        y[TORQUE + j] = 0.0


@jit
def approach_inner(bearing, omega_cage, y, n):
    """The same of every inner contact; its normal points from the inner ring's centre to the roller."""
    gap, middle = bearing.gap, 0.5 * (bearing.R_o + bearing.R_i)
    u_x, u_y, v_x, v_y = y[POSITION + X_I], y[POSITION + Y_I], y[VELOCITY + X_I], y[VELOCITY + Y_I]
    for j in range(n):
        rho, n_r, n_t, short, d_r, d_t = from_centre(
            y[COS + j], y[SIN + j], middle + y[Q + j], y[V + j], omega_cage + y[EPS_V + j], u_x, u_y, v_x, v_y
        )
        y[RHO_I + j], y[M_R + j], y[M_T + j] = rho, n_r, n_t
        y[DELTA_I + j] = short - gap - y[Q + j]
        y[V_I + j] = -n_r * d_r - n_t * d_t
        y[T_I + j] = n_r * d_t - n_t * d_r
        y[TILT_I + j] = 0.0
