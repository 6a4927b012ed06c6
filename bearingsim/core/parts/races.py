"""Analytic derivatives of the forces between rollers and a race of ``planar``.

The force of a contact depends on the approach along n, the position s over a defect, their rates, and the slip.
With sigma = 1 at the outer race and -1 at the inner, and with n', tau' tilted by the defect, the force on the
roller is -sigma Q n' - f tau', and

    dQ = Q_d d(delta) + Q_v dv + Q_s ds + Q_z d(s'),   df = mu dQ + Q (mu_v d(slip) + mu_u du)

while n and tau rotate as the roller moves along tau. The changes of position and velocity relative to the ring's
centre, along e_r and e_theta, are read from the rows D_POSITION and D_VELOCITY; the resulting changes of force are
added to the rows D_FORCE. A name with the prefix ``d_`` is such a change, per unit of one coordinate or of its
rate.
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
# its rate (V), position (S) and ds/dt (Z); radius of the surface with the defect; the same if the defect is on the
# outer ring, else 0; the same if it is on a roller, else 0
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
# tilt of the normal: tangent, cosine, sine; 1/Q; arms of friction about roller and ring; mu; its derivatives with
# respect to slip and rolling speed, times Q; force on the roller along n and tau
NORMAL_SLOPE, NORMAL_COS, NORMAL_SIN, INVERSE_LOAD, ROLLER_ARM, RING_ARM, MU, MU_V, MU_U, FORCE_N, FORCE_TAU = (
    jacobian_rows(13 * lay.ROW, "1, 1, 1, 1/N, m, m, 1, N s/m, N s/m, N, N")
)
# offsets of rows from NORMAL_O_R or NORMAL_I_R: n along e_r (and, one row further, e_theta), rho, speed along tau
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
def fill_contact_derivatives(side, law, y, n):
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
def fill_defect_derivatives(side, law, defects, d, s, speed, delta, v, y, j):
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
        approach, rate, contact_mask = delta - h, v - slope * speed, 1.0 if delta > h else 0.0
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
        mean_d += weight * contact_mask
        mean_s += group[GROUP_WEIGHT] * contact_mask * (share_s * approach - share * slope)
    y[base + LOAD_D + j], y[base + LOAD_V + j], y[base + LOAD_S + j] = load_d, load_v, load_s
    y[base + DEFECT_FORCE_D + j], y[base + DEFECT_FORCE_V + j], y[base + DEFECT_FORCE_S + j] = (
        tangential_d,
        tangential_v,
        tangential_s,
    )
    y[base + DEFECT_FORCE_Z + j], y[base + MEAN_D + j], y[base + MEAN_S + j] = tangential_z, mean_d, mean_s


@jit
def correct_derivatives_over_defects(side, law, model, t, omega_cage, omega_i, spin, y):
    """Correct the derivatives of each contact over a defect on this side; ``planar.correct_for_defects`` corrects
    the forces."""
    defects, b, sigma = model.defects, model.bearing, sign(side)
    base, frame, _, shared = derivative_rows(side)
    for d in range(len(defects.head)):
        carrier, radius = defects.head[d, CARRIER], defects.head[d, RADIUS]
        if (defects.head[d, SIDE] == OUTER) == (sigma > 0.0):
            j, s = roller_at_defect(model, d, t, y)
            if abs(s) < defects.head[d, HALF_WIDTH] and not is_masked(model, d, j, s, t, y):
                omega_defect = omega_i if carrier == ON_INNER else y[lay.VELOCITY + lay.PSI]
                omega_defect = spin + y[lay.SPIN_V + j] if carrier >= 0.0 else omega_defect
                _, n_r, n_t, r_minus_rho, v_r, v_t = relative_to_ring(
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
                delta, rho_v = sigma * (y[lay.RADIAL + j] - r_minus_rho) - b.gap, n_r * v_r + n_t * v_t
                speed = radius * (y[frame + TANGENTIAL_V + j] / y[frame + RHO + j] - omega_defect)
                fill_defect_derivatives(side, law, defects, d, s, speed, delta, sigma * rho_v, y, j)
                y[base + RHO_V + j], y[base + DEFECT_RADIUS + j] = rho_v, radius
                y[base + DEFECT_RADIUS_RING + j] = radius if carrier == ON_OUTER else 0.0
                y[base + DEFECT_RADIUS_ROLLER + j] = radius if carrier >= 0.0 else 0.0


@jit
def fill_friction_derivatives(side, friction, R_w, omega_cage, spin, y, n):
    """Fill the rows NORMAL_SLOPE to FORCE_TAU of every contact: tilt of the normal, arms, friction and force."""
    base, frame, friction_row, _ = derivative_rows(side)
    force, approach, _, slip, defect_force = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        rolling_rate = omega_cage + y[lay.EPS_V + j] - spin - y[lay.SPIN_V + j]
        Q, f = y[force + j], y[friction_row + j]
        per_load = 1.0 / max(Q, 1e-300)
        per_load = per_load if Q > 0.0 else 0.0
        normal_slope = y[defect_force + j] * per_load
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
        y[base + FORCE_TAU + j] = y[defect_force + j] - f * cosine


@jit
def add_race_changes(side, spin, omega_ring, d_roll, d_spin, d_orbit, d_ring_angle, d_ring_omega, y, n):
    """Add the directional derivatives of the contact forces to the rows D_FORCE, along the rows D_POSITION and
    D_VELOCITY and the rotations.

    spin, omega_ring: nominal spin of a roller and speed of the ring (rad/s); d_roll, d_spin: changes of the
    rollers' rotation angle (rad) and spin (rad/s); d_orbit: change of their orbital speed (rad/s), on which the
    rolling speed depends; d_ring_angle, d_ring_omega: changes of the ring's angle (rad) and speed (rad/s).
    """
    base, frame, friction_row, shared = derivative_rows(side)
    _, _, _, _, defect_force = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        n_r, n_t = y[frame + NORMAL + j], y[frame + NORMAL + lay.ROW + j]
        rho = y[frame + RHO + j]
        v_tau = y[frame + TANGENTIAL_V + j]
        d_p_r, d_p_t = y[lay.D_POSITION_R + j], y[lay.D_POSITION_T + j]
        d_v_r, d_v_t = y[lay.D_VELOCITY_R + j], y[lay.D_VELOCITY_T + j]
        rho_v, f = y[base + RHO_V + j], y[friction_row + j]
        radius, normal_slope = y[base + DEFECT_RADIUS + j], y[base + NORMAL_SLOPE + j]
        cosine = y[base + NORMAL_COS + j]
        sine = y[base + NORMAL_SIN + j]
        arm = y[base + ROLLER_ARM + j]
        ring_arm = y[base + RING_ARM + j]
        radius_ring, radius_roller = y[base + DEFECT_RADIUS_RING + j], y[base + DEFECT_RADIUS_ROLLER + j]

        d_rho, d_angle = n_r * d_p_r + n_t * d_p_t, (n_r * d_p_t - n_t * d_p_r) / rho
        d_rho_v = n_r * d_v_r + n_t * d_v_t + v_tau * d_angle
        d_v_tau = n_r * d_v_t - n_t * d_v_r - rho_v * d_angle
        d_delta, d_delta_v = sigma * d_rho, sigma * d_rho_v
        d_s = radius * d_angle - radius_ring * d_ring_angle - radius_roller * d_roll
        d_s_v = (
            radius * (d_v_tau - v_tau * d_rho / rho) / rho - radius_ring * d_ring_omega - radius_roller * d_spin
        )
        d_Q = y[base + LOAD_D + j] * d_delta + y[base + LOAD_V + j] * d_delta_v
        # Q_z equals -DEFECT_FORCE_V, group by group
        d_Q += y[base + LOAD_S + j] * d_s - y[base + DEFECT_FORCE_V + j] * d_s_v
        d_tangential = y[base + DEFECT_FORCE_D + j] * d_delta + y[base + DEFECT_FORCE_V + j] * d_delta_v
        d_tangential += y[base + DEFECT_FORCE_S + j] * d_s + y[base + DEFECT_FORCE_Z + j] * d_s_v

        d_defect_force = (radius * d_tangential - y[defect_force + j] * d_rho) / rho
        d_normal_slope = (d_defect_force - normal_slope * d_Q) * y[base + INVERSE_LOAD + j] * cosine * cosine
        d_cosine, d_sine = -sine * d_normal_slope, cosine * d_normal_slope
        d_arm = -0.5 * (y[base + MEAN_D + j] * d_delta + y[base + MEAN_S + j] * d_s)
        d_ring_arm = d_rho * cosine + rho * d_cosine + sigma * d_arm
        d_slip = d_v_tau * cosine + v_tau * d_cosine - d_ring_omega * ring_arm - omega_ring * d_ring_arm
        d_slip += sigma * (d_rho_v * sine + rho_v * d_sine + d_spin * arm + (spin + y[lay.SPIN_V + j]) * d_arm)
        d_f = y[base + MU + j] * d_Q + y[base + MU_U + j] * (d_orbit - d_spin)
        d_f += y[base + MU_V + j] * d_slip

        d_force_n = -sigma * (d_Q + d_f * sine + f * d_sine) - y[base + FORCE_TAU + j] * d_angle
        d_force_tau = d_defect_force - d_f * cosine - f * d_cosine + y[base + FORCE_N + j] * d_angle
        d_force_r, d_force_t = d_force_n * n_r - d_force_tau * n_t, d_force_n * n_t + d_force_tau * n_r
        c, s = y[lay.COS + j], y[lay.SIN + j]
        y[lay.D_FORCE_R + j] += d_force_r
        y[lay.D_FORCE_T + j] += d_force_t
        y[lay.D_TORQUE + j] -= sigma * (d_f * arm + f * d_arm) + radius_roller * d_tangential
        y[lay.D_FORCE_SHARED + shared * lay.ROW + j] += d_force_t * s - d_force_r * c
        y[lay.D_FORCE_SHARED + (shared + 1) * lay.ROW + j] -= d_force_r * s + d_force_t * c
        d_ring_torque = d_f * ring_arm + f * d_ring_arm - radius_ring * d_tangential
        y[lay.D_FORCE_SHARED + lay.PSI * lay.ROW + j] += d_ring_torque if sigma > 0.0 else 0.0
