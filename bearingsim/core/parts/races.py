"""Analytic derivatives of the forces between rollers and a race of ``planar``.

The force of a contact depends on the approach along n, the position s over a defect, their rates, and the slip.
With sigma = 1 at the outer race, -1 at the inner, and n', tau' tilted by the defect, the force on the roller is
-sigma Q n' - f tau', and

    dQ = Q_d d(delta) + Q_v dv + Q_s ds + Q_z d(s'),   df = mu dQ + Q (mu_v d(slip) + mu_u du)

while n and tau rotate as the roller moves along tau. The changes of position and velocity relative to the ring's
centre, along e_r and e_theta, are read from the rows D_POSITION and D_VELOCITY; the resulting changes of force are
added to the rows D_FORCE.
"""

from functools import partial
from math import sqrt
from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import defect_response, defect_response_gradient
from bearingsim.core.defects.on_roller import is_masked, roller_at_defect
from bearingsim.core.defects.pairs import (
    CARRIER,
    GROUP_COUNT,
    GROUP_WEIGHT,
    HALF_WIDTH,
    ON_INNER,
    ON_OUTER,
    OUTER,
    RADIUS,
    REDUCED_RADIUS,
    SIDE,
)
from bearingsim.core.geometry.plane import relative_to_ring
from bearingsim.core.geometry.sides import InnerSide, OuterSide, contact_rows, sign
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import derivatives, normal_force
from bearingsim.core.laws.friction.interface import mu, mu_derivative

# rows of a contact, relative to OUTER_CONTACT or INNER_CONTACT: rate of rho; derivatives of the force (LOAD), of
# the tangential force over a defect (DEFECT_FORCE) and of the mean approach (MEAN) with respect to approach (D),
# its rate (V), position (S) and ds/dt (Z); radius of the surface with the defect, then the same if it is on the
# outer ring, and on a roller, else 0
jacobian_rows = partial(
    lay.rows, owners="linearise", lifetime="linearise", bases=(lay.OUTER_CONTACT, lay.INNER_CONTACT)
)
(
    RHO_V,
    LOAD_D,
    LOAD_V,
    LOAD_S,
    DEFECT_FORCE_D,
    DEFECT_FORCE_V,
    DEFECT_FORCE_S,
    DEFECT_FORCE_Z,
    MEAN_D,
    MEAN_S,
    DEFECT_RADIUS,
    DEFECT_RADIUS_RING,
    DEFECT_RADIUS_ROLLER,
) = jacobian_rows(0, "m/s, N/m, N s/m, N/m, N/m, N s/m, N/m, N s/m, 1, 1, m, m, m")
# tilt of the normal: tangent, cosine, sine; 1/force; arms on roller and ring; mu, its derivatives with respect to
# slip and rolling speed times the force; force on the roller along and across n
NORMAL_SLOPE, NORMAL_COS, NORMAL_SIN, INVERSE_LOAD, ROLLER_ARM, RING_ARM, MU, MU_V, MU_U, FORCE_N, FORCE_TAU = (
    jacobian_rows(13 * lay.ROW, "1, 1, 1, 1/N, m, m, 1, N s/m, N s/m, N, N")
)
# rows from NORMAL_O_R or NORMAL_I_R on: n along e_r (and e_theta), rho, speed across n
NORMAL, RHO, TANGENTIAL_V = 0, 2 * lay.ROW, 3 * lay.ROW


@generic
def derivative_rows(side: Any) -> tuple[int, int, int, int]:
    """Return the base of the rows of derivatives, the rows of n and of friction, and the ring's first shared
    coordinate."""


@derivative_rows.register(OuterSide)
def _derivative_rows_outer(side):
    return lay.OUTER_CONTACT, lay.NORMAL_O_R, lay.FRICTION_O, lay.X


@derivative_rows.register(InnerSide)
def _derivative_rows_inner(side):
    return lay.INNER_CONTACT, lay.NORMAL_I_R, lay.FRICTION_I, lay.X_I


@jit
def contact_derivatives(side, law, y, n):
    """Fill the derivatives of every contact with an undamaged race."""
    base, _, _, _ = derivative_rows(side)
    _, approach, rate, _, _ = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        y[base + LOAD_D + j], y[base + LOAD_V + j] = derivatives(law, y[approach + j], y[rate + j])
        y[base + RHO_V + j] = sigma * y[rate + j]
        y[base + LOAD_S + j], y[base + MEAN_D + j], y[base + MEAN_S + j] = 0.0, 1.0, 0.0
        y[base + DEFECT_FORCE_D + j] = 0.0
        y[base + DEFECT_FORCE_V + j] = 0.0
        y[base + DEFECT_FORCE_S + j] = 0.0
        y[base + DEFECT_FORCE_Z + j] = 0.0
        y[base + DEFECT_RADIUS + j], y[base + DEFECT_RADIUS_RING + j], y[base + DEFECT_RADIUS_ROLLER + j] = (
            0.0,
            0.0,
            0.0,
        )


@jit
def defect_derivatives(side, law, defects, d, s, speed, delta, v, y, j):
    """Fill the derivatives of ``force_over_defect`` for roller ``j`` over roller-defect pair ``d``, summed over
    groups."""
    base, _, _, _ = derivative_rows(side)
    head = defects.head[d]
    load_d, load_v, load_s, mean_d, mean_s = 0.0, 0.0, 0.0, 0.0, 0.0
    tangential_d, tangential_v, tangential_s, tangential_z = 0.0, 0.0, 0.0, 0.0
    for k in range(int(head[GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, head[REDUCED_RADIUS])
        share_s, slope_s = defect_response_gradient(defects.excitation, group, s, head[REDUCED_RADIUS])
        approach, rate, closed = delta - h, v - slope * speed, 1.0 if delta > h else 0.0
        K, C = derivatives(law, approach, rate)
        weight, force = share * group[GROUP_WEIGHT], normal_force(law, approach, rate)
        K, C = weight * K, weight * C
        force_s = share_s * group[GROUP_WEIGHT] * force - K * slope - C * slope_s * speed
        load_d, load_v, load_s = load_d + K, load_v + C, load_s + force_s
        tangential_d, tangential_v, tangential_z = (
            tangential_d + K * slope,
            tangential_v + C * slope,
            tangential_z - C * slope * slope,
        )
        tangential_s += force_s * slope + weight * force * slope_s
        mean_d += weight * closed
        mean_s += group[GROUP_WEIGHT] * closed * (share_s * approach - share * slope)
    y[base + LOAD_D + j], y[base + LOAD_V + j], y[base + LOAD_S + j] = load_d, load_v, load_s
    y[base + DEFECT_FORCE_D + j], y[base + DEFECT_FORCE_V + j], y[base + DEFECT_FORCE_S + j] = (
        tangential_d,
        tangential_v,
        tangential_s,
    )
    y[base + DEFECT_FORCE_Z + j], y[base + MEAN_D + j], y[base + MEAN_S + j] = tangential_z, mean_d, mean_s


@jit
def derivatives_over_defects(side, law, model, t, omega_cage, omega_i, spin, y):
    """Correct the derivatives of each contact of this side over a defect (``planar.correct_for_defects``)."""
    defects, b, sigma = model.defects, model.bearing, sign(side)
    base, frame, _, shared = derivative_rows(side)
    for d in range(len(defects.head)):
        on, radius = defects.head[d, CARRIER], defects.head[d, RADIUS]
        if (defects.head[d, SIDE] == OUTER) == (sigma > 0.0):
            j, s = roller_at_defect(model, d, t, y)
            if abs(s) < defects.head[d, HALF_WIDTH] and not is_masked(model, d, j, s, t, y):
                omega_defect = omega_i if on == ON_INNER else y[lay.VELOCITY + lay.PSI]
                omega_defect = spin + y[lay.SPIN_V + j] if on >= 0.0 else omega_defect
                _, n_r, n_t, r_minus_rho, d_r, d_t = relative_to_ring(
                    y[lay.COS + j],
                    y[lay.SIN + j],
                    0.5 * (b.R_o + b.R_i) + y[lay.RADIAL + j],
                    y[lay.RADIAL_V + j],
                    omega_cage + y[lay.EPS_V + j],
                    y[lay.POSITION + shared],
                    y[lay.POSITION + shared + 1],
                    y[lay.VELOCITY + shared],
                    y[lay.VELOCITY + shared + 1],
                )
                delta, rho_v = sigma * (y[lay.RADIAL + j] - r_minus_rho) - b.gap, n_r * d_r + n_t * d_t
                speed = radius * (y[frame + TANGENTIAL_V + j] / y[frame + RHO + j] - omega_defect)
                defect_derivatives(side, law, defects, d, s, speed, delta, sigma * rho_v, y, j)
                y[base + RHO_V + j], y[base + DEFECT_RADIUS + j] = rho_v, radius
                y[base + DEFECT_RADIUS_RING + j] = radius if on == ON_OUTER else 0.0
                y[base + DEFECT_RADIUS_ROLLER + j] = radius if on >= 0.0 else 0.0


@jit
def friction_derivatives(side, friction, R_w, omega_cage, spin, y, n):
    """Fill tilt of the normal, arms and friction of every contact."""
    base, frame, friction_row, _ = derivative_rows(side)
    force, approach, _, slip, tilt = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        rolling_rate = omega_cage + y[lay.EPS_V + j] - spin - y[lay.SPIN_V + j]
        Q, f = y[force + j], y[friction_row + j]
        per_load = 1.0 / max(Q, 1e-300)
        per_load = per_load if Q > 0.0 else 0.0
        normal_slope = y[tilt + j] * per_load
        cosine = 1.0 / sqrt(1.0 + normal_slope * normal_slope)
        sine, arm = normal_slope * cosine, R_w - 0.5 * y[approach + j]
        mu_v, mu_u = mu_derivative(friction, y[slip + j], R_w * abs(rolling_rate))
        y[base + NORMAL_SLOPE + j] = normal_slope
        y[base + NORMAL_COS + j] = cosine
        y[base + NORMAL_SIN + j] = sine
        y[base + INVERSE_LOAD + j] = per_load
        y[base + ROLLER_ARM + j], y[base + RING_ARM + j] = arm, y[frame + RHO + j] * cosine + sigma * arm
        y[base + MU + j] = mu(friction, y[slip + j], R_w * abs(rolling_rate))
        y[base + MU_V + j] = Q * mu_v
        y[base + MU_U + j] = Q * mu_u * (R_w if rolling_rate > 0.0 else -R_w)
        y[base + FORCE_N + j] = -sigma * (Q + f * sine)
        y[base + FORCE_TAU + j] = y[tilt + j] - f * cosine


@jit
def race_change(side, spin, omega_ring, roll, roll_v, orbit_v, ring, ring_v, y, n):
    """Add the changes of force of every roller to the rows D_FORCE, for the changes in the rows D_POSITION and
    D_VELOCITY and for rotation.

    spin, omega_ring: nominal spin of a roller and speed of the ring (rad/s); roll, roll_v: changes of the rollers'
    spin angle (rad) and spin (rad/s); orbit_v: of their orbital speed, on which the rolling speed depends (rad/s);
    ring, ring_v: of the ring's angle (rad) and speed (rad/s).
    """
    base, frame, friction_row, shared = derivative_rows(side)
    _, _, _, _, tilt = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        n_r, n_t = y[frame + NORMAL + j], y[frame + NORMAL + lay.ROW + j]
        rho = y[frame + RHO + j]
        v_tau = y[frame + TANGENTIAL_V + j]
        p_r, p_t = y[lay.D_POSITION_R + j], y[lay.D_POSITION_T + j]
        w_r, w_t = y[lay.D_VELOCITY_R + j], y[lay.D_VELOCITY_T + j]
        rho_v, f = y[base + RHO_V + j], y[friction_row + j]
        radius, normal_slope = y[base + DEFECT_RADIUS + j], y[base + NORMAL_SLOPE + j]
        cosine = y[base + NORMAL_COS + j]
        sine = y[base + NORMAL_SIN + j]
        arm = y[base + ROLLER_ARM + j]
        ring_arm = y[base + RING_ARM + j]
        radius_ring, radius_roller = y[base + DEFECT_RADIUS_RING + j], y[base + DEFECT_RADIUS_ROLLER + j]

        rho_1, angle_1 = n_r * p_r + n_t * p_t, (n_r * p_t - n_t * p_r) / rho
        rho_v_1 = n_r * w_r + n_t * w_t + v_tau * angle_1
        v_tau_1 = n_r * w_t - n_t * w_r - rho_v * angle_1
        delta_1, delta_v_1 = sigma * rho_1, sigma * rho_v_1
        s_1 = radius * angle_1 - radius_ring * ring - radius_roller * roll
        s_v_1 = radius * (v_tau_1 - v_tau * rho_1 / rho) / rho - radius_ring * ring_v - radius_roller * roll_v
        Q_1 = y[base + LOAD_D + j] * delta_1 + y[base + LOAD_V + j] * delta_v_1
        Q_1 += y[base + LOAD_S + j] * s_1 - y[base + DEFECT_FORCE_V + j] * s_v_1  # Q_z = -S_v, group by group
        tangential_1 = y[base + DEFECT_FORCE_D + j] * delta_1 + y[base + DEFECT_FORCE_V + j] * delta_v_1
        tangential_1 += y[base + DEFECT_FORCE_S + j] * s_1 + y[base + DEFECT_FORCE_Z + j] * s_v_1

        tilt_1 = (radius * tangential_1 - y[tilt + j] * rho_1) / rho
        normal_slope_1 = (tilt_1 - normal_slope * Q_1) * y[base + INVERSE_LOAD + j] * cosine * cosine
        cosine_1, sine_1 = -sine * normal_slope_1, cosine * normal_slope_1
        arm_1 = -0.5 * (y[base + MEAN_D + j] * delta_1 + y[base + MEAN_S + j] * s_1)
        ring_arm_1 = rho_1 * cosine + rho * cosine_1 + sigma * arm_1
        slip_1 = v_tau_1 * cosine + v_tau * cosine_1 - ring_v * ring_arm - omega_ring * ring_arm_1
        slip_1 += sigma * (rho_v_1 * sine + rho_v * sine_1 + roll_v * arm + (spin + y[lay.SPIN_V + j]) * arm_1)
        f_1 = y[base + MU + j] * Q_1 + y[base + MU_U + j] * (orbit_v - roll_v)
        f_1 += y[base + MU_V + j] * slip_1

        along_n = -sigma * (Q_1 + f_1 * sine + f * sine_1) - y[base + FORCE_TAU + j] * angle_1
        across_n = tilt_1 - f_1 * cosine - f * cosine_1 + y[base + FORCE_N + j] * angle_1
        push_r, push_t = along_n * n_r - across_n * n_t, along_n * n_t + across_n * n_r
        c, s = y[lay.COS + j], y[lay.SIN + j]
        y[lay.D_FORCE_R + j] += push_r
        y[lay.D_FORCE_T + j] += push_t
        y[lay.D_TORQUE + j] -= sigma * (f_1 * arm + f * arm_1) + radius_roller * tangential_1
        y[lay.D_FORCE_SHARED + shared * lay.ROW + j] += push_t * s - push_r * c
        y[lay.D_FORCE_SHARED + (shared + 1) * lay.ROW + j] -= push_r * s + push_t * c
        ring_torque = f_1 * ring_arm + f * ring_arm_1 - radius_ring * tangential_1
        y[lay.D_FORCE_SHARED + lay.PSI * lay.ROW + j] += ring_torque if sigma > 0.0 else 0.0
