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
    aside_d, aside_v, aside_s, aside_z = 0.0, 0.0, 0.0, 0.0
    for k in range(int(head[GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, head[REDUCED_RADIUS])
        share_s, slope_s = defect_response_gradient(defects.excitation, group, s, head[REDUCED_RADIUS])
        approach, rate, closed = delta - h, v - slope * speed, 1.0 if delta > h else 0.0
        K, C = derivatives(law, approach, rate)
        weight, force = share * group[GROUP_WEIGHT], normal_force(law, approach, rate)
        K, C = weight * K, weight * C
        by_s = share_s * group[GROUP_WEIGHT] * force - K * slope - C * slope_s * speed
        load_d, load_v, load_s = load_d + K, load_v + C, load_s + by_s
        aside_d, aside_v, aside_z = aside_d + K * slope, aside_v + C * slope, aside_z - C * slope * slope
        aside_s += by_s * slope + weight * force * slope_s
        mean_d += weight * closed
        mean_s += group[GROUP_WEIGHT] * closed * (share_s * approach - share * slope)
    y[base + LOAD_D + j], y[base + LOAD_V + j], y[base + LOAD_S + j] = load_d, load_v, load_s
    y[base + DEFECT_FORCE_D + j], y[base + DEFECT_FORCE_V + j], y[base + DEFECT_FORCE_S + j] = (
        aside_d,
        aside_v,
        aside_s,
    )
    y[base + DEFECT_FORCE_Z + j], y[base + MEAN_D + j], y[base + MEAN_S + j] = aside_z, mean_d, mean_s


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
                turning = omega_i if on == ON_INNER else y[lay.VELOCITY + lay.PSI]
                turning = spin + y[lay.SPIN_V + j] if on >= 0.0 else turning
                _, n_r, n_t, short, d_r, d_t = relative_to_ring(
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
                delta, apart = sigma * (y[lay.RADIAL + j] - short) - b.gap, n_r * d_r + n_t * d_t
                speed = radius * (y[frame + TANGENTIAL_V + j] / y[frame + RHO + j] - turning)
                defect_derivatives(side, law, defects, d, s, speed, delta, sigma * apart, y, j)
                y[base + RHO_V + j], y[base + DEFECT_RADIUS + j] = apart, radius
                y[base + DEFECT_RADIUS_RING + j] = radius if on == ON_OUTER else 0.0
                y[base + DEFECT_RADIUS_ROLLER + j] = radius if on >= 0.0 else 0.0


@jit
def friction_derivatives(side, friction, R_w, omega_cage, spin, y, n):
    """Fill tilt of the normal, arms and friction of every contact."""
    base, frame, rubs, _ = derivative_rows(side)
    force, approach, _, slip, tilt = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        turning = omega_cage + y[lay.EPS_V + j] - spin - y[lay.SPIN_V + j]
        Q, f = y[force + j], y[rubs + j]
        per_load = 1.0 / max(Q, 1e-300)
        per_load = per_load if Q > 0.0 else 0.0
        normal_slope = y[tilt + j] * per_load
        cosine = 1.0 / sqrt(1.0 + normal_slope * normal_slope)
        sine, arm = normal_slope * cosine, R_w - 0.5 * y[approach + j]
        by_slip, by_rolling = mu_derivative(friction, y[slip + j], R_w * abs(turning))
        y[base + NORMAL_SLOPE + j] = normal_slope
        y[base + NORMAL_COS + j] = cosine
        y[base + NORMAL_SIN + j] = sine
        y[base + INVERSE_LOAD + j] = per_load
        y[base + ROLLER_ARM + j], y[base + RING_ARM + j] = arm, y[frame + RHO + j] * cosine + sigma * arm
        y[base + MU + j] = mu(friction, y[slip + j], R_w * abs(turning))
        y[base + MU_V + j] = Q * by_slip
        y[base + MU_U + j] = Q * by_rolling * (R_w if turning > 0.0 else -R_w)
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
    base, frame, rubs, shared = derivative_rows(side)
    _, _, _, _, tilt = contact_rows(side)
    sigma = sign(side)
    for j in range(n):
        n_r, n_t = y[frame + NORMAL + j], y[frame + NORMAL + lay.ROW + j]
        rho = y[frame + RHO + j]
        across = y[frame + TANGENTIAL_V + j]
        p_r, p_t = y[lay.D_POSITION_R + j], y[lay.D_POSITION_T + j]
        w_r, w_t = y[lay.D_VELOCITY_R + j], y[lay.D_VELOCITY_T + j]
        apart, f = y[base + RHO_V + j], y[rubs + j]
        defect, normal_slope = y[base + DEFECT_RADIUS + j], y[base + NORMAL_SLOPE + j]
        cosine = y[base + NORMAL_COS + j]
        sine = y[base + NORMAL_SIN + j]
        arm = y[base + ROLLER_ARM + j]
        on_ring = y[base + RING_ARM + j]
        defect_ring, defect_roller = y[base + DEFECT_RADIUS_RING + j], y[base + DEFECT_RADIUS_ROLLER + j]

        out, turned = n_r * p_r + n_t * p_t, (n_r * p_t - n_t * p_r) / rho
        apart_1 = n_r * w_r + n_t * w_t + across * turned
        across_1 = n_r * w_t - n_t * w_r - apart * turned
        deep, closing = sigma * out, sigma * apart_1
        along = defect * turned - defect_ring * ring - defect_roller * roll
        passing = defect * (across_1 - across * out / rho) / rho - defect_ring * ring_v - defect_roller * roll_v
        load = y[base + LOAD_D + j] * deep + y[base + LOAD_V + j] * closing
        load += y[base + LOAD_S + j] * along - y[base + DEFECT_FORCE_V + j] * passing  # Q_z = -S_v, group by group
        aside = y[base + DEFECT_FORCE_D + j] * deep + y[base + DEFECT_FORCE_V + j] * closing
        aside += y[base + DEFECT_FORCE_S + j] * along + y[base + DEFECT_FORCE_Z + j] * passing

        tilt_1 = (defect * aside - y[tilt + j] * out) / rho
        normal_slope_1 = (tilt_1 - normal_slope * load) * y[base + INVERSE_LOAD + j] * cosine * cosine
        cosine_1, sine_1 = -sine * normal_slope_1, cosine * normal_slope_1
        arm_1 = -0.5 * (y[base + MEAN_D + j] * deep + y[base + MEAN_S + j] * along)
        on_ring_1 = out * cosine + rho * cosine_1 + sigma * arm_1
        slip = across_1 * cosine + across * cosine_1 - ring_v * on_ring - omega_ring * on_ring_1
        slip += sigma * (apart_1 * sine + apart * sine_1 + roll_v * arm + (spin + y[lay.SPIN_V + j]) * arm_1)
        f_1 = y[base + MU + j] * load + y[base + MU_U + j] * (orbit_v - roll_v)
        f_1 += y[base + MU_V + j] * slip

        along_n = -sigma * (load + f_1 * sine + f * sine_1) - y[base + FORCE_TAU + j] * turned
        across_n = tilt_1 - f_1 * cosine - f * cosine_1 + y[base + FORCE_N + j] * turned
        push_r, push_t = along_n * n_r - across_n * n_t, along_n * n_t + across_n * n_r
        c, s = y[lay.COS + j], y[lay.SIN + j]
        y[lay.D_FORCE_R + j] += push_r
        y[lay.D_FORCE_T + j] += push_t
        y[lay.D_TORQUE + j] -= sigma * (f_1 * arm + f * arm_1) + defect_roller * aside
        y[lay.D_FORCE_SHARED + shared * lay.ROW + j] += push_t * s - push_r * c
        y[lay.D_FORCE_SHARED + (shared + 1) * lay.ROW + j] -= push_r * s + push_t * c
        race_arm = f_1 * on_ring + f * on_ring_1 - defect_ring * aside
        y[lay.D_FORCE_SHARED + lay.PSI * lay.ROW + j] += race_arm if sigma > 0.0 else 0.0
