"""Where rollers stand and move in the plane, and how close they are to the races, without small angles.

With rho = |c_j - u| the distance of a roller from a ring's centre, n from there to the roller, tau across it.
"""

from math import cos, sin, sqrt

from bearingsim.core.geometry.sides import frame, ring_of, sign, totals
from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    CE,
    COS,
    COS_0,
    EPS,
    EPS_V,
    PC,
    POSITION,
    PS,
    SE,
    SIN,
    SIN_0,
    VELOCITY,
    Q,
    V,
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
def approach(side, bearing, omega_cage, y, n):
    """Approach, its rate, normal and sideways speed of every contact of one side over an undamaged race.

    The normal points from the ring's centre to the roller.
    """
    gap, middle = bearing.gap, 0.5 * (bearing.R_o + bearing.R_i)
    normal_r, normal_t, distance, across, _ = frame(side)
    _, approaches, rates, _, tilts = totals(side)
    sigma, ring = sign(side), ring_of(side)
    u_x, u_y, v_x, v_y = y[POSITION + ring], y[POSITION + ring + 1], y[VELOCITY + ring], y[VELOCITY + ring + 1]
    for j in range(n):
        rho, n_r, n_t, short, d_r, d_t = from_centre(
            y[COS + j], y[SIN + j], middle + y[Q + j], y[V + j], omega_cage + y[EPS_V + j], u_x, u_y, v_x, v_y
        )
        y[distance + j], y[normal_r + j], y[normal_t + j] = rho, n_r, n_t
        outwards, lost = (y[Q + j], short) if sigma > 0.0 else (short, y[Q + j])
        y[approaches + j] = outwards - gap - lost
        y[rates + j] = sigma * n_t * d_t - -sigma * n_r * d_r  # sigma n.d; written otherwise it rounds otherwise
        y[across + j] = n_r * d_t - n_t * d_r
        y[tilts + j] = 0.0
