"""Contacts of the slices of all rollers with one race: geometry, force and friction in space.

The centre of slice k of a roller is p = c + zeta_k a. With the ring's centre u and its axis b,

    d = p - u,  w = d.b,  X = d - w b,  rho = |X|,  n = X/rho,  tau = b x n
    delta = sigma (rho - R) + R_w - drop - h(s),     force on the slice  -sigma Q n + g Q tau

sigma = 1 on the outer race, -1 on the inner; g is -sigma times the tangent of the normal's tilt towards tau, due
to a defect or to form. X and its rate are linear along the roller, so only their values at its centre (OFFSET,
OFFSET_V) and slopes (DIRECTION, DIRECTION_V) are stored. Sums over the slices: G of the forces, H of zeta times
the forces, COUPLE_AXIAL and COUPLE of the moments about p due to friction and to defects of the roller, so that

    moment on the roller = a x H + COUPLE_AXIAL b + COUPLE

KAPPA, friction over slip, is evaluated at the current slip and multiplied by the slip predicted one lag later,
from the changes of both mean slips, of tilting and of skewing (``laws/friction/lag.py``, ``relax_friction``).
"""

from math import sqrt

from bearingsim.core import layout as lay
from bearingsim.core.geometry.sides import contact_rows, load_cells, side_rows, sign, slice_rows
from bearingsim.core.geometry.slices import MAX_SLICES
from bearingsim.core.jit import inlined, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.friction.lag import implicit_fraction
from bearingsim.core.parts.form_in_space import (
    height_slope_of_slice,
    recess_of_slice,
    recess_rate_of_slice,
    torque_of_roller_form,
    versine,
)

SLIP_OFFSET = 1e-12  # m/s, added in quadrature to the slip so that friction/slip stays finite at zero slip
INDEX_MASK = 0x7FFFFFFF  # mask by which the compiler knows that a buffer index is not negative
# mask by which the compiler knows the bound on the number of rollers, so that rows of slices cannot overlap others
LANE_MASK = 127


@jit
def fill_race_frame(side, bearing, ring, omega_cage, y, n):
    """Fill each roller's position and motion relative to the ring as linear functions along its axis.

    Equation (S2) of docs/spatial.md, first line.
    """
    base, R_mean = side_rows(side), 0.5 * (bearing.R_o + bearing.R_i)
    b_z, w_z = ring.a_z, ring.w_z
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        b_r, b_t = ring.a_x * c + ring.a_y * s, ring.a_y * c - ring.a_x * s
        w_r, w_t = ring.w_x * c + ring.w_y * s, ring.w_y * c - ring.w_x * s
        u_r, u_t = ring.x * c + ring.y * s, ring.y * c - ring.x * s
        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        v_r, v_t, v_z = y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]
        r = R_mean + y[lay.RADIAL + j]
        d_r, d_z = r - u_r, y[lay.AXIAL + j] - ring.z
        m_r = y[lay.RADIAL_V + j] - (ring.v_x * c + ring.v_y * s)
        m_t = r * (omega_cage + y[lay.EPS_V + j]) - (ring.v_y * c - ring.v_x * s)
        m_z = y[lay.AXIAL_V + j] - ring.v_z
        axial_offset = d_r * b_r - u_t * b_t + d_z * b_z
        along = a_r * b_r + a_t * b_t + a_z * b_z
        y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j] = b_r, b_t
        y[base + lay.OFFSET_R + j] = -u_r - axial_offset * b_r  # without r, which would cost digits
        y[base + lay.OFFSET_T + j] = -u_t - axial_offset * b_t
        y[base + lay.OFFSET_Z + j] = d_z - axial_offset * b_z
        y[base + lay.DIRECTION_R + j] = a_r - along * b_r
        y[base + lay.DIRECTION_T + j] = a_t - along * b_t
        y[base + lay.DIRECTION_Z + j] = a_z - along * b_z
        y[base + lay.OFFSET_V_R + j] = m_r - axial_offset * w_r
        y[base + lay.OFFSET_V_T + j] = m_t - axial_offset * w_t
        y[base + lay.OFFSET_V_Z + j] = m_z - axial_offset * w_z
        y[base + lay.DIRECTION_V_R + j] = v_r - along * w_r
        y[base + lay.DIRECTION_V_T + j] = v_t - along * w_t
        y[base + lay.DIRECTION_V_Z + j] = v_z - along * w_z
        omega = y[lay.OMEGA + j]
        o_r = a_t * v_z - a_z * v_t + omega * a_r  # the roller's angular velocity
        o_t = a_z * v_r - a_r * v_z + omega * a_t
        o_z = a_r * v_t - a_t * v_r + omega * a_z
        y[base + lay.ROLL_SPEED + j] = o_r * b_r + o_t * b_t + o_z * b_z
        y[base + lay.AXIAL_SLIP + j] = m_r * b_r + m_t * b_t + m_z * b_z + d_r * w_r - u_t * w_t + d_z * w_z
        y[base + lay.AXIAL_SLIP_SLOPE + j] = v_r * b_r + v_t * b_t + v_z * b_z + a_r * w_r + a_t * w_t + a_z * w_z
        y[base + lay.AXIAL_SLIP_ARM_R + j] = b_t * o_z - b_z * o_t + w_r
        y[base + lay.AXIAL_SLIP_ARM_T + j] = b_z * o_r - b_r * o_z + w_t
        y[base + lay.AXIAL_SLIP_ARM_Z + j] = b_r * o_t - b_t * o_r + w_z


@jit
def clear_sums(side, y, n):
    """Set the sums over slices to zero. Requires the rows filled by ``fill_race_frame``."""
    base = side_rows(side)
    force, approach, rate, slip, tangential = contact_rows(side)
    for j in range(n):
        y[force + j], y[approach + j], y[slip + j], y[tangential + j] = 0.0, 0.0, 0.0, 0.0
        # at the roller's centre, approximate, for the step monitor
        y[rate + j] = sign(side) * y[base + lay.OFFSET_V_R + j]
        y[base + lay.CONTACT_FORCE_R + j] = 0.0
        y[base + lay.CONTACT_FORCE_T + j] = 0.0
        y[base + lay.CONTACT_FORCE_Z + j] = 0.0
        y[base + lay.COUPLE_AXIAL + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_R + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_T + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_Z + j] = 0.0
        y[base + lay.COUPLE_R + j], y[base + lay.COUPLE_T + j], y[base + lay.COUPLE_Z + j] = 0.0, 0.0, 0.0
        y[base + lay.KAPPA_0 + j], y[base + lay.KAPPA_1 + j], y[base + lay.KAPPA_2 + j] = 0.0, 0.0, 0.0
        y[base + lay.KAPPA_SLIP_0 + j] = 0.0
        y[base + lay.KAPPA_SLIP_1 + j] = 0.0
        y[base + lay.KAPPA_SLIP_Z + j] = 0.0
        y[base + lay.KAPPA_ARM + j] = 0.0
        y[base + lay.KAPPA_R + j] = 0.0
        y[base + lay.KAPPA_T + j] = 0.0
        y[base + lay.KAPPA_Z + j] = 0.0


@inlined
def add_slice(side, law, friction, form, bearing, ring, zeta, weight, drop, k, y, n):
    """Add the forces on slice ``k`` of every roller to the sums of this side; store its loads and approaches.

    zeta: position along the roller (m); drop: of the roller's profile (m); weight: share of the contact. The rows
    ROLLER_DROP to ROLLER_DEFECT of the side contain the effect of a defect on the slice.
    """
    load_row, approach_row = slice_rows(side)
    force_sum, approach_sum, _, slip_sum, tangential_sum = contact_rows(side)
    row = lay.SLICES + lay.FIRST_LANE + (k & (MAX_SLICES - 1)) * (lay.SLICE_ROWS * lay.ROW)
    for j in range(n & LANE_MASK):
        load, approach, tangential, slip = load_slice(
            side, law, friction, form, bearing, ring, zeta, weight, drop, y, j
        )
        y[row + (load_row + j)] = load
        y[row + (approach_row + j)] = approach
        y[force_sum + j] += load
        y[tangential_sum + j] += tangential
        y[slip_sum + j] += weight * slip
        y[approach_sum + j] += weight * max(approach, 0.0)


@inlined
def load_slice(side, law, friction, form, bearing, ring, zeta, weight, drop, y, j):
    """Compute position, motion, force and friction of a slice of roller ``j``; add force and moments to the sums.

    Returns the load (N), the approach (m), the tangential force due to the normal's tilt (N) and the slip (m/s).

    Equations (S2) and (S3) of docs/spatial.md; with form (F1) and (F2) of docs/form.md.
    """
    base, sigma, R_mean = side_rows(side), sign(side), 0.5 * (bearing.R_o + bearing.R_i)
    clearance, radius, b_z, omega_ring = bearing.gap + drop, bearing.R_w - drop, ring.a_z, ring.omega
    rho_minus_r = y[base + lay.OFFSET_R + j] + zeta * y[base + lay.DIRECTION_R + j]
    X_r = R_mean + y[lay.RADIAL + j] + rho_minus_r
    X_t = y[base + lay.OFFSET_T + j] + zeta * y[base + lay.DIRECTION_T + j]
    X_z = y[base + lay.OFFSET_Z + j] + zeta * y[base + lay.DIRECTION_Z + j]
    lateral_squared = X_t * X_t + X_z * X_z
    rho = sqrt(X_r * X_r + lateral_squared)
    inverse_product = 1.0 / (rho * (rho + X_r))
    inverse_rho = inverse_product * (rho + X_r)
    n_r, n_t, n_z = X_r * inverse_rho, X_t * inverse_rho, X_z * inverse_rho
    b_r, b_t = y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j]
    t_r, t_t, t_z = b_t * n_z - b_z * n_t, b_z * n_r - b_r * n_z, b_r * n_t - b_t * n_r
    v_r = y[base + lay.OFFSET_V_R + j] + zeta * y[base + lay.DIRECTION_V_R + j]
    v_t = y[base + lay.OFFSET_V_T + j] + zeta * y[base + lay.DIRECTION_V_T + j]
    v_z = y[base + lay.OFFSET_V_Z + j] + zeta * y[base + lay.DIRECTION_V_Z + j]
    rho_v = n_r * v_r + n_t * v_t + n_z * v_z
    v_tau = t_r * v_r + t_t * v_t + t_z * v_z

    defect_slope = y[base + lay.NORMAL_SLOPE + j]
    normal_slope = defect_slope - height_slope_of_slice(form, side, inverse_rho, y, j)
    cosine = 1.0 - versine(form, base, normal_slope, y, j)
    on_roller, roll_speed = y[base + lay.ROLLER_DEFECT + j], y[base + lay.ROLL_SPEED + j]
    sine = sigma * normal_slope * cosine
    rho_minus_r += lateral_squared * (inverse_product * rho)
    delta = sigma * (y[lay.RADIAL + j] + rho_minus_r) - clearance - y[base + lay.ROLLER_DROP + j]
    delta = delta - recess_of_slice(form, side, y, j)
    arm = sigma * (radius - 0.5 * delta)
    o_r, o_t, o_z = n_r * cosine - t_r * sine, n_t * cosine - t_t * sine, n_z * cosine - t_z * sine
    e_r, e_t, e_z = t_r * cosine + n_r * sine, t_t * cosine + n_t * sine, t_z * cosine + n_z * sine
    axial_slip = y[base + lay.AXIAL_SLIP + j] + zeta * y[base + lay.AXIAL_SLIP_SLOPE + j]
    axial_slip += arm * (
        o_r * y[base + lay.AXIAL_SLIP_ARM_R + j]
        + o_t * y[base + lay.AXIAL_SLIP_ARM_T + j]
        + o_z * y[base + lay.AXIAL_SLIP_ARM_Z + j]
    )
    slip = v_tau * cosine + rho_v * sine + arm * roll_speed - omega_ring * (rho * cosine + arm)
    rate = sigma * rho_v - defect_slope * (v_tau - (omega_ring + on_roller * (roll_speed - omega_ring)) * rho)
    past_race, past_roller = v_tau - omega_ring * rho, v_tau - roll_speed * rho
    rate = rate - recess_rate_of_slice(form, side, inverse_rho, past_race, past_roller, y, j)

    force = weight * (1.0 - y[base + lay.STIFFNESS_LOSS + j]) * normal_force(law, delta, rate)
    speed = sqrt(slip * slip + axial_slip * axial_slip + SLIP_OFFSET * SLIP_OFFSET)
    kappa = mu(friction, speed, y[lay.ROLLING_SPEED + j]) * force / speed
    f_n, f_t, f, f_b = -sigma * force, normal_slope * force, kappa * slip, kappa * axial_slip
    g_r = f_n * n_r + f_t * t_r - f * e_r - f_b * b_r
    g_t = f_n * n_t + f_t * t_t - f * e_t - f_b * b_t
    g_z = f_n * n_z + f_t * t_z - f * e_z - f_b * b_z
    torque = arm * f + on_roller * (defect_slope * force) * rho - torque_of_roller_form(form, side, force, y, j)
    y[base + lay.COUPLE_AXIAL + j] -= torque
    add_moments(base, zeta, arm, (g_r, g_t, g_z), (f, f_b), kappa, (e_r, e_t, e_z), y, j)
    return force, delta, f_t, slip


@inlined
def add_moments(base, zeta, arm, force, friction, kappa, along, y, j):
    """Add force (N), couple (N m) and kappa (N s/m) of a slice of roller ``j`` and their moments to the sums.

    zeta: position along the roller (m); arm: lever arm of the friction about the roller's axis (m); force: radial,
    tangential and axial; friction: along the rolling direction and along the ring's axis (N); along: unit vector
    of the rolling direction.
    """
    (g_r, g_t, g_z), (f, f_b), (e_r, e_t, e_z) = force, friction, along
    couple, zeta_kappa = arm * f_b, zeta * kappa
    y[base + lay.CONTACT_FORCE_R + j] += g_r
    y[base + lay.CONTACT_FORCE_T + j] += g_t
    y[base + lay.CONTACT_FORCE_Z + j] += g_z
    y[base + lay.CONTACT_ZETA_FORCE_R + j] += zeta * g_r
    y[base + lay.CONTACT_ZETA_FORCE_T + j] += zeta * g_t
    y[base + lay.CONTACT_ZETA_FORCE_Z + j] += zeta * g_z
    y[base + lay.COUPLE_R + j] += couple * e_r
    y[base + lay.COUPLE_T + j] += couple * e_t
    y[base + lay.COUPLE_Z + j] += couple * e_z
    y[base + lay.KAPPA_0 + j] += kappa
    y[base + lay.KAPPA_1 + j] += zeta_kappa
    y[base + lay.KAPPA_2 + j] += zeta * zeta_kappa
    y[base + lay.KAPPA_SLIP_0 + j] += f
    y[base + lay.KAPPA_SLIP_1 + j] += zeta * f
    y[base + lay.KAPPA_SLIP_Z + j] += f_b
    y[base + lay.KAPPA_ARM + j] += kappa * arm
    y[base + lay.KAPPA_R + j] += kappa * e_r
    y[base + lay.KAPPA_T + j] += kappa * e_t
    y[base + lay.KAPPA_Z + j] += kappa * e_z


@jit
def update_line_load(row, width, y, n):
    """Update each roller's largest line load with a slice of ``width`` (m) whose rows begin at ``row``."""
    row &= INDEX_MASK
    per_width = 1.0 / width
    for j in range(n):
        largest = max(y[row + lay.LOAD_O * lay.ROW + j], y[row + lay.LOAD_I * lay.ROW + j])
        y[lay.LINE_LOAD_MAX + j] = max(y[lay.LINE_LOAD_MAX + j], largest * per_width)


@jit
def fill_slip_changes(lag, m_r, I_r, I_t, R_w, y, n):
    """Fill SLIP_CHANGE, SLIP_CHANGE_Z and SKEW_V_CHANGE, the changes of every roller's slips within the lag (s).

    The effective lag is the ``implicit_fraction`` of ``lag``. Along the rolling direction the unknowns are the
    mean slips of both contacts and the rate of skew, which is eliminated. Axially they are the mean slips of both
    contacts, which change by axial motion and tilting of the roller.
    """
    outer, inner = lay.OUTER_SIDE, lay.INNER_SIDE
    along, across = lag * (1.0 / m_r + R_w * R_w / I_r), lag * (1.0 / m_r - R_w * R_w / I_r)
    along_z, across_z = lag * (1.0 / m_r + R_w * R_w / I_t), lag * (1.0 / m_r - R_w * R_w / I_t)
    for j in range(n):
        K = y[outer + lay.KAPPA_0 + j] + y[inner + lay.KAPPA_0 + j]
        fraction, fraction_z = implicit_fraction(along * K), implicit_fraction(along_z * K)
        a, b, g = fraction * along, fraction * across, fraction * lag / I_t
        a_z, b_z = fraction_z * along_z, fraction_z * across_z
        N_o, N_i = y[outer + lay.KAPPA_1 + j], y[inner + lay.KAPPA_1 + j]
        M = y[outer + lay.KAPPA_SLIP_1 + j] + y[inner + lay.KAPPA_SLIP_1 + j]
        gamma = g / (1.0 + g * (y[outer + lay.KAPPA_2 + j] + y[inner + lay.KAPPA_2 + j]))
        k_oo, k_oi = y[outer + lay.KAPPA_0 + j] - gamma * N_o * N_o, -gamma * N_o * N_i
        k_ii = y[inner + lay.KAPPA_0 + j] - gamma * N_i * N_i
        S_o = y[outer + lay.KAPPA_SLIP_0 + j] - gamma * N_o * M
        S_i = y[inner + lay.KAPPA_SLIP_0 + j] - gamma * N_i * M
        s_o, s_i = solve_slip_changes(a, b, k_oo, k_oi, k_ii, S_o, S_i)
        y[outer + lay.SLIP_CHANGE + j], y[inner + lay.SLIP_CHANGE + j] = s_o, s_i
        y[lay.SKEW_V_CHANGE + j] = -gamma * (M + N_o * s_o + N_i * s_i)
        y[outer + lay.SLIP_CHANGE_Z + j], y[inner + lay.SLIP_CHANGE_Z + j] = solve_slip_changes(
            a_z,
            b_z,
            y[outer + lay.KAPPA_0 + j],
            0.0,
            y[inner + lay.KAPPA_0 + j],
            y[outer + lay.KAPPA_SLIP_Z + j],
            y[inner + lay.KAPPA_SLIP_Z + j],
        )


@jit
def solve_slip_changes(a, b, k_oo, k_oi, k_ii, S_o, S_i):
    """Return the changes s of two slips under forces F = S + k s: s = -(a F_o + b F_i), -(b F_o + a F_i)."""
    A, B = 1.0 + a * k_oo + b * k_oi, a * k_oi + b * k_ii
    C, D = b * k_oo + a * k_oi, 1.0 + b * k_oi + a * k_ii
    inverse = 1.0 / (A * D - B * C)
    d_o, d_i = -(a * S_o + b * S_i), -(b * S_o + a * S_i)
    return (D * d_o - B * d_i) * inverse, (A * d_i - C * d_o) * inverse


@jit
def relax_friction(side, ring, y, n):
    """Add to the sums the change of friction due to the change of slip within the lag, along its mean
    direction."""
    base, b_z = side_rows(side), ring.a_z
    for j in range(n):
        k_0 = y[base + lay.KAPPA_0 + j]
        k_1 = y[base + lay.KAPPA_1 + j]
        slip_change = y[base + lay.SLIP_CHANGE + j]
        slip_change_z = y[base + lay.SLIP_CHANGE_Z + j]
        inverse = 1.0 / max(k_0, 1e-300)
        e_r, e_t, e_z = (
            y[base + lay.KAPPA_R + j] * inverse,
            y[base + lay.KAPPA_T + j] * inverse,
            y[base + lay.KAPPA_Z + j] * inverse,
        )
        arm, skew_v_change = y[base + lay.KAPPA_ARM + j] * inverse, y[lay.SKEW_V_CHANGE + j]
        f = k_0 * slip_change + k_1 * skew_v_change
        h = k_1 * slip_change + y[base + lay.KAPPA_2 + j] * skew_v_change
        f_b = k_0 * slip_change_z
        h_b = k_1 * slip_change_z
        b_r, b_t = y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j]
        y[base + lay.CONTACT_FORCE_R + j] -= f * e_r + f_b * b_r
        y[base + lay.CONTACT_FORCE_T + j] -= f * e_t + f_b * b_t
        y[base + lay.CONTACT_FORCE_Z + j] -= f * e_z + f_b * b_z
        y[base + lay.CONTACT_ZETA_FORCE_R + j] -= h * e_r + h_b * b_r
        y[base + lay.CONTACT_ZETA_FORCE_T + j] -= h * e_t + h_b * b_t
        y[base + lay.CONTACT_ZETA_FORCE_Z + j] -= h * e_z + h_b * b_z
        y[base + lay.COUPLE_AXIAL + j] -= arm * f
        y[base + lay.COUPLE_R + j] += arm * f_b * e_r
        y[base + lay.COUPLE_T + j] += arm * f_b * e_t
        y[base + lay.COUPLE_Z + j] += arm * f_b * e_z


@jit
def add_side_loads(side, bearing, ring, y, n):
    """Add the sums over slices to the loads on each roller, and fill its loads on the ring.

    The loads on the ring are force (N) and moment about the ring's centre (N m) along e_0, e_90, e_z: the reaction
    at the same points of contact.
    """
    base, R_mean = side_rows(side), 0.5 * (bearing.R_o + bearing.R_i)
    in_plane, out_of_plane, axial_moment = load_cells(side)
    f_x, f_y, f_z = lay.roller_load(in_plane), lay.roller_load(in_plane + 1), lay.roller_load(out_of_plane)
    m_x, m_y = lay.roller_load(out_of_plane + 1), lay.roller_load(out_of_plane + 2)
    m_z = lay.roller_load(axial_moment)
    for j in range(n):
        c, s, mask = y[lay.COS + j], y[lay.SIN + j], bearing.m_r * y[lay.INVERSE_MASS + j]
        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        G_r = y[base + lay.CONTACT_FORCE_R + j]
        G_t = y[base + lay.CONTACT_FORCE_T + j]
        G_z = y[base + lay.CONTACT_FORCE_Z + j]
        h_r = y[base + lay.CONTACT_ZETA_FORCE_R + j]
        h_t = y[base + lay.CONTACT_ZETA_FORCE_T + j]
        h_z = y[base + lay.CONTACT_ZETA_FORCE_Z + j]
        couple_axial = y[base + lay.COUPLE_AXIAL + j]
        M_r = a_t * h_z - a_z * h_t + couple_axial * y[base + lay.RING_AXIS_R + j] + y[base + lay.COUPLE_R + j]
        M_t = a_z * h_r - a_r * h_z + couple_axial * y[base + lay.RING_AXIS_T + j] + y[base + lay.COUPLE_T + j]
        M_z = a_r * h_t - a_t * h_r + couple_axial * ring.a_z + y[base + lay.COUPLE_Z + j]
        y[lay.FORCE_R + j] += G_r
        y[lay.FORCE_T + j] += G_t
        y[lay.FORCE_Z + j] += G_z
        y[lay.MOMENT_R + j] += M_r
        y[lay.MOMENT_T + j] += M_t
        y[lay.MOMENT_Z + j] += M_z
        d_r = R_mean + y[lay.RADIAL + j] - ring.x * c - ring.y * s
        d_t, d_z = ring.x * s - ring.y * c, y[lay.AXIAL + j] - ring.z
        N_r, N_t = M_r + d_t * G_z - d_z * G_t, M_t + d_z * G_r - d_r * G_z
        y[f_x + j], y[f_y + j], y[f_z + j] = -G_r * c + G_t * s, -G_r * s - G_t * c, -mask * G_z
        y[m_x + j], y[m_y + j] = -N_r * c + N_t * s, -N_r * s - N_t * c
        y[m_z + j] = -mask * (M_z + d_r * G_t - d_t * G_r)
