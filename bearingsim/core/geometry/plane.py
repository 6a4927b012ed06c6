"""Positions and velocities of rollers in the plane and their approach to the races, for angles of any size.

rho = |c_j - u| is the distance of a roller from a ring's centre, n the direction from there to the roller, tau
transverse to n.
"""

from math import floor, pi, sqrt
from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.sides import contact_rows, normal_rows, sign
from bearingsim.core.jit import inlined, jit

QUARTERS_PER_RAD = 2.0 / pi  # right angles per rad
QUARTER_HIGH, QUARTER_LOW = 0.5 * pi, 6.123233995736766e-17
"""Right angle (rad) as the sum of two floats."""
S_3, S_5, S_7 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S_9, S_11, S_13 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C_4, C_6, C_8 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C_10, C_12, C_14 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11
"""Coefficients of sine and cosine by powers of an angle up to pi/4 (FreeBSD's msun, k_sin.c and k_cos.c)."""


@inlined
def cos_sin(angle):
    """Return cosine and sine of ``angle`` (rad); a call is 17 ns faster than two library calls.

    The error is below 3e-16 plus 2e-16 of the angle, the rounding error of the angle.
    """
    quarters = floor(angle * QUARTERS_PER_RAD + 0.5)
    x = (angle - quarters * QUARTER_HIGH) - quarters * QUARTER_LOW
    z = x * x
    s = x + x * z * (S_3 + z * (S_5 + z * (S_7 + z * (S_9 + z * (S_11 + z * S_13)))))
    c = 1.0 - 0.5 * z + z * z * (C_4 + z * (C_6 + z * (C_8 + z * (C_10 + z * (C_12 + z * C_14)))))
    quadrant = quarters - 4.0 * floor(0.25 * quarters)
    C, S = (s, c) if quadrant == 1.0 or quadrant == 3.0 else (c, s)
    return (-C if quadrant == 1.0 or quadrant == 2.0 else C), (-S if quadrant >= 2.0 else S)


class Centre(NamedTuple):
    """Position (m) and velocity (m/s) of a ring's or the cage's centre, along e_0 and e_90."""

    x: float
    y: float
    v_x: float
    v_y: float


@inlined
def centre_at(cell, y):
    """Return the centre whose coordinates are stored in the shared cells ``cell`` and ``cell`` + 1."""
    p, v = lay.POSITION + cell, lay.VELOCITY + cell
    return Centre(y[p], y[p + 1], y[v], y[v + 1])


@inlined
def fill_roller_direction(C, S, y, j):
    """Fill the directions of roller ``j`` and of its pocket.

    C, S: cosine and sine of the angle of pocket 0. |EPS| remains below 0.01, where the series are exact to
    rounding errors.
    """
    cos_pocket = C * y[lay.COS_0 + j] - S * y[lay.SIN_0 + j]
    sin_pocket = S * y[lay.COS_0 + j] + C * y[lay.SIN_0 + j]
    e = y[lay.EPS + j]
    e2 = e * e
    cos_eps = 1.0 - e2 * (0.5 - e2 * (1.0 / 24.0 - e2 * (1.0 / 720.0)))
    sin_eps = e * (1.0 - e2 * (1.0 / 6.0 - e2 * (1.0 / 120.0 - e2 * (1.0 / 5040.0))))
    y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j] = (
        cos_pocket,
        sin_pocket,
        cos_eps,
        sin_eps,
    )
    y[lay.COS + j], y[lay.SIN + j] = (
        cos_pocket * cos_eps - sin_pocket * sin_eps,
        sin_pocket * cos_eps + cos_pocket * sin_eps,
    )


@jit
def fill_roller_directions(theta_c, y, n):
    """Fill the directions of all rollers and pockets, with pocket 0 at ``theta_c`` (rad).

    Equation (P1) of docs/planar.md.
    """
    C, S = cos_sin(theta_c)
    for j in range(n):
        fill_roller_direction(C, S, y, j)


@jit
def relative_to_ring(c, s, r, v, theta_v, u_x, u_y, v_x, v_y):
    """Compute position and velocity of a roller relative to a ring with the centre ``u_x``, ``u_y`` (m) and its
    velocity ``v_x``, ``v_y`` (m/s).

    c, s: cosine and sine of the roller's angle; r, v: its radial position (m) and speed (m/s); theta_v: its
    orbital speed (rad/s). Returns its distance rho from the centre (m), the direction n to it along e_r and
    e_theta, r - rho (m) without cancellation, and its velocity relative to the centre along e_r and e_theta (m/s).
    """
    u_r, u_t = u_x * c + u_y * s, u_y * c - u_x * s
    x = r - u_r
    rho = sqrt(x * x + u_t * u_t)
    per_both = 1.0 / (rho * (rho + x))
    per_rho, r_minus_rho = per_both * (rho + x), u_r - u_t * u_t * (per_both * rho)
    return (
        rho,
        x * per_rho,
        -u_t * per_rho,
        r_minus_rho,
        v - (v_x * c + v_y * s),
        r * theta_v - (v_y * c - v_x * s),
    )


@inlined
def approach(side, bearing, ring, omega_cage, y, j):
    """Compute approach, its rate, normal and transverse speed of one contact of roller ``j`` on an undamaged race.

    side: of the contact; ring: ``Centre`` of its ring, from which the normal points to the roller; omega_cage:
    speed of the cage (rad/s).

    Equation (P3) of docs/planar.md without h.
    """
    normal_r, normal_t, distance, transverse_speed, _ = normal_rows(side)
    _, approaches, rates, _, tangential_forces = contact_rows(side)
    sigma, q = sign(side), y[lay.RADIAL + j]
    rho, n_r, n_t, r_minus_rho, d_r, d_t = relative_to_ring(
        y[lay.COS + j],
        y[lay.SIN + j],
        0.5 * (bearing.R_o + bearing.R_i) + q,
        y[lay.RADIAL_V + j],
        omega_cage + y[lay.EPS_V + j],
        ring.x,
        ring.y,
        ring.v_x,
        ring.v_y,
    )
    y[distance + j], y[normal_r + j], y[normal_t + j] = rho, n_r, n_t
    outer_position, inner_position = (q, r_minus_rho) if sigma > 0.0 else (r_minus_rho, q)
    y[approaches + j] = outer_position - bearing.gap - inner_position
    y[rates + j] = sigma * n_t * d_t - -sigma * n_r * d_r  # sigma n.d; another form would round differently
    y[transverse_speed + j] = n_r * d_t - n_t * d_r
    y[tangential_forces + j] = 0.0


@inlined
def small_angle(sine):
    """Return the angle (rad) of a ``sine`` by its series, exact to rounding errors below 0.02."""
    z = sine * sine
    return sine * (1.0 + z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0 + z * (105.0 / 3456.0)))))
