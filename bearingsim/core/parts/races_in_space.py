"""Contacts of the slices of all rollers with one race: geometry, force and friction in space.

The middle of slice k of a roller is p = c + zeta_k a. With the ring's centre u and its axis b,

    d = p - u,  w = d.b,  X = d - w b,  rho = |X|,  n = X/rho,  tau = b x n
    delta = sigma (rho - R) + R_w - drop - h(s),     force on the slice  -sigma Q n + g Q tau

sigma = 1 on the outer race, -1 on the inner; g is -sigma times the tilt of the normal at a defect. X and its rate
are linear along the roller, so only their values at its middle (OFFSET, OFFSET_V) and slopes (DIRECTION,
DIRECTION_V) are stored. Sums over the slices: G of the forces, H of zeta times the forces, COUPLE_AXIAL and COUPLE
of the moments about p by friction and by defects of the roller, so that

    moment on the roller = a x H + COUPLE_AXIAL b + COUPLE

KAPPA, friction over slip, is evaluated at the present slip and multiplied by the slip predicted one lag later,
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

SLIP_OFFSET = 1e-12  # m/s, added in quadrature to the slip so that friction/slip stays finite at zero slip
NONNEGATIVE = 0x7FFFFFFF  # mask that shows the compiler that a buffer index is not negative
FEW = 127  # mask that shows it the bound on the number of rollers, so that rows of slices cannot overlap others


@jit
def race_frame(side, bearing, ring, omega_cage, y, n):
    """Fill each roller's position and motion relative to the ring as linear functions along its axis.

    Equation (S2) of docs/spatial.md, first line.
    """
    base, middle = side_rows(side), 0.5 * (bearing.R_o + bearing.R_i)
    b_z, w_z = ring.a_z, ring.w_z
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        b_r, b_t = ring.a_x * c + ring.a_y * s, ring.a_y * c - ring.a_x * s
        w_r, w_t = ring.w_x * c + ring.w_y * s, ring.w_y * c - ring.w_x * s
        u_r, u_t = ring.x * c + ring.y * s, ring.y * c - ring.x * s
        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        v_r, v_t, v_z = y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]
        r = middle + y[lay.RADIAL + j]
        d_r, d_z = r - u_r, y[lay.AXIAL + j] - ring.z
        m_r = y[lay.RADIAL_V + j] - (ring.v_x * c + ring.v_y * s)
        m_t = r * (omega_cage + y[lay.EPS_V + j]) - (ring.v_y * c - ring.v_x * s)
        m_z = y[lay.AXIAL_V + j] - ring.v_z
        off = d_r * b_r - u_t * b_t + d_z * b_z
        along = a_r * b_r + a_t * b_t + a_z * b_z
        y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j] = b_r, b_t
        y[base + lay.OFFSET_R + j] = -u_r - off * b_r  # without r, which would cost digits
        y[base + lay.OFFSET_T + j] = -u_t - off * b_t
        y[base + lay.OFFSET_Z + j] = d_z - off * b_z
        y[base + lay.DIRECTION_R + j] = a_r - along * b_r
        y[base + lay.DIRECTION_T + j] = a_t - along * b_t
        y[base + lay.DIRECTION_Z + j] = a_z - along * b_z
        y[base + lay.OFFSET_V_R + j] = m_r - off * w_r
        y[base + lay.OFFSET_V_T + j] = m_t - off * w_t
        y[base + lay.OFFSET_V_Z + j] = m_z - off * w_z
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
    """Set the sums over slices to zero; call it after ``race_frame``."""
    base = side_rows(side)
    force, approach, rate, slip, across = contact_rows(side)
    for j in range(n):
        y[force + j], y[approach + j], y[slip + j], y[across + j] = 0.0, 0.0, 0.0, 0.0
        y[rate + j] = sign(side) * y[base + lay.OFFSET_V_R + j]  # at the middle, approximate: for the step monitor
        y[base + lay.CONTACT_FORCE_R + j] = 0.0
        y[base + lay.CONTACT_FORCE_T + j] = 0.0
        y[base + lay.CONTACT_FORCE_Z + j] = 0.0
        y[base + lay.COUPLE_AXIAL + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_R + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_T + j] = 0.0
        y[base + lay.CONTACT_ZETA_FORCE_Z + j] = 0.0
        y[base + lay.COUPLE_R + j], y[base + lay.COUPLE_T + j], y[base + lay.COUPLE_Z + j] = 0.0, 0.0, 0.0
        y[base + lay.KAPPA_0 + j], y[base + lay.KAPPA_1 + j], y[base + lay.KAPPA_2 + j] = 0.0, 0.0, 0.0
        y[base + lay.KAPPA_SLIP_0 + j], y[base + lay.KAPPA_SLIP_1 + j], y[base + lay.KAPPA_SLIP_Z + j] = (
            0.0,
            0.0,
            0.0,
        )
        y[base + lay.KAPPA_ARM + j] = 0.0
        y[base + lay.KAPPA_R + j] = 0.0
        y[base + lay.KAPPA_T + j] = 0.0
        y[base + lay.KAPPA_Z + j] = 0.0


@inlined
def add_slice(side, law, friction, bearing, ring, zeta, weight, drop, k, y, n):
    """Add the forces on slice ``k`` of every roller to the sums of this side; store its loads and approaches.

    zeta, drop: m; weight: share of the contact. The rows ROLLER_DROP to ROLLER_DEFECT of the side contain the
    effect of a defect on the slice.
    """
    load_row, approach_row = slice_rows(side)
    row = lay.SLICES + lay.FIRST_LANE + (k & (MAX_SLICES - 1)) * (lay.SLICE_ROWS * lay.ROW)
    for j in range(n & FEW):
        load, approach = load_slice(side, law, friction, bearing, ring, zeta, weight, drop, y, j)
        y[row + (load_row + j)] = load
        y[row + (approach_row + j)] = approach


@inlined
def load_slice(side, law, friction, bearing, ring, zeta, weight, drop, y, j):
    """Compute position, motion, force and friction of a slice of roller ``j``; add its forces to the sums.

    Returns the load (N) and the approach (m) of the slice.

    Equations (S2) and (S3) of docs/spatial.md.
    """
    base, sigma, middle = side_rows(side), sign(side), 0.5 * (bearing.R_o + bearing.R_i)
    lacking, radius, b_z, turning = bearing.gap + drop, bearing.R_w - drop, ring.a_z, ring.omega
    short = y[base + lay.OFFSET_R + j] + zeta * y[base + lay.DIRECTION_R + j]
    X_r = middle + y[lay.RADIAL + j] + short
    X_t = y[base + lay.OFFSET_T + j] + zeta * y[base + lay.DIRECTION_T + j]
    X_z = y[base + lay.OFFSET_Z + j] + zeta * y[base + lay.DIRECTION_Z + j]
    aside = X_t * X_t + X_z * X_z
    rho = sqrt(X_r * X_r + aside)
    per_both = 1.0 / (rho * (rho + X_r))
    per_rho = per_both * (rho + X_r)
    n_r, n_t, n_z = X_r * per_rho, X_t * per_rho, X_z * per_rho
    b_r, b_t = y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j]
    t_r, t_t, t_z = b_t * n_z - b_z * n_t, b_z * n_r - b_r * n_z, b_r * n_t - b_t * n_r
    v_r = y[base + lay.OFFSET_V_R + j] + zeta * y[base + lay.DIRECTION_V_R + j]
    v_t = y[base + lay.OFFSET_V_T + j] + zeta * y[base + lay.DIRECTION_V_T + j]
    v_z = y[base + lay.OFFSET_V_Z + j] + zeta * y[base + lay.DIRECTION_V_Z + j]
    apart = n_r * v_r + n_t * v_t + n_z * v_z
    across = t_r * v_r + t_t * v_t + t_z * v_z

    normal_slope, cosine = y[base + lay.NORMAL_SLOPE + j], 1.0 - y[base + lay.NORMAL_VERSINE + j]
    own, rolls, sine = y[base + lay.ROLLER_DEFECT + j], y[base + lay.ROLL_SPEED + j], sigma * normal_slope * cosine
    short += aside * (per_both * rho)
    delta = sigma * (y[lay.RADIAL + j] + short) - lacking - y[base + lay.ROLLER_DROP + j]
    arm = sigma * (radius - 0.5 * delta)
    o_r, o_t, o_z = n_r * cosine - t_r * sine, n_t * cosine - t_t * sine, n_z * cosine - t_z * sine
    e_r, e_t, e_z = t_r * cosine + n_r * sine, t_t * cosine + n_t * sine, t_z * cosine + n_z * sine
    drift = y[base + lay.AXIAL_SLIP + j] + zeta * y[base + lay.AXIAL_SLIP_SLOPE + j]
    drift += arm * (
        o_r * y[base + lay.AXIAL_SLIP_ARM_R + j]
        + o_t * y[base + lay.AXIAL_SLIP_ARM_T + j]
        + o_z * y[base + lay.AXIAL_SLIP_ARM_Z + j]
    )
    slip = across * cosine + apart * sine + arm * rolls - turning * (rho * cosine + arm)
    rate = sigma * apart - normal_slope * (across - (turning + own * (rolls - turning)) * rho)

    force = weight * (1.0 - y[base + lay.STIFFNESS_LOSS + j]) * normal_force(law, delta, rate)
    speed = sqrt(slip * slip + drift * drift + SLIP_OFFSET * SLIP_OFFSET)
    kappa = mu(friction, speed, y[lay.ROLLING_SPEED + j]) * force / speed
    push, shove, f, f_b = -sigma * force, normal_slope * force, kappa * slip, kappa * drift
    g_r = push * n_r + shove * t_r - f * e_r - f_b * b_r
    g_t = push * n_t + shove * t_t - f * e_t - f_b * b_t
    g_z = push * n_z + shove * t_z - f * e_z - f_b * b_z
    bend, moment = arm * f_b, zeta * kappa
    y[base + lay.CONTACT_FORCE_R + j] += g_r
    y[base + lay.CONTACT_FORCE_T + j] += g_t
    y[base + lay.CONTACT_FORCE_Z + j] += g_z
    y[base + lay.CONTACT_ZETA_FORCE_R + j] += zeta * g_r
    y[base + lay.CONTACT_ZETA_FORCE_T + j] += zeta * g_t
    y[base + lay.CONTACT_ZETA_FORCE_Z + j] += zeta * g_z
    y[base + lay.COUPLE_AXIAL + j] -= arm * f + own * shove * rho
    y[base + lay.COUPLE_R + j] += bend * e_r
    y[base + lay.COUPLE_T + j] += bend * e_t
    y[base + lay.COUPLE_Z + j] += bend * e_z
    y[base + lay.KAPPA_0 + j] += kappa
    y[base + lay.KAPPA_1 + j] += moment
    y[base + lay.KAPPA_2 + j] += zeta * moment
    y[base + lay.KAPPA_SLIP_0 + j] += f
    y[base + lay.KAPPA_SLIP_1 + j] += zeta * f
    y[base + lay.KAPPA_SLIP_Z + j] += f_b
    y[base + lay.KAPPA_ARM + j] += kappa * arm
    y[base + lay.KAPPA_R + j] += kappa * e_r
    y[base + lay.KAPPA_T + j] += kappa * e_t
    y[base + lay.KAPPA_Z + j] += kappa * e_z
    all_force, all_approach, _, all_slip, all_across = contact_rows(side)
    y[all_force + j] += force
    y[all_across + j] += shove
    y[all_slip + j] += weight * slip
    y[all_approach + j] += weight * max(delta, 0.0)
    return force, delta


@jit
def update_line_load(row, width, y, n):
    """Update the largest line load with the loads of a slice of ``width`` (m) whose rows begin at ``row``."""
    row &= NONNEGATIVE
    per_width = 1.0 / width
    for j in range(n):
        most = max(y[row + lay.LOAD_O * lay.ROW + j], y[row + lay.LOAD_I * lay.ROW + j])
        y[lay.LINE_LOAD_MAX + j] = max(y[lay.LINE_LOAD_MAX + j], most * per_width)


@jit
def slip_relaxation(lag, m_r, I_r, I_t, R_w, y, n):
    """Fill SLIP_CHANGE, SLIP_CHANGE_Z and SKEW_V_CHANGE, the changes of every roller's slips within the lag (s).

    The effective lag is ``implicit_fraction`` of it. Along the race the unknowns are the mean slips of both
    contacts and the rate of skew, which is eliminated. Axially they are the mean slips of both contacts, which
    change by axial motion and tilting of the roller.
    """
    outer, inner = lay.OUTER_SIDE, lay.INNER_SIDE
    along, crosswise = lag * (1.0 / m_r + R_w * R_w / I_r), lag * (1.0 / m_r - R_w * R_w / I_r)
    along_z, crosswise_z = lag * (1.0 / m_r + R_w * R_w / I_t), lag * (1.0 / m_r - R_w * R_w / I_t)
    for j in range(n):
        K = y[outer + lay.KAPPA_0 + j] + y[inner + lay.KAPPA_0 + j]
        part, part_z = implicit_fraction(along * K), implicit_fraction(along_z * K)
        a, b, g = part * along, part * crosswise, part * lag / I_t
        a_z, b_z = part_z * along_z, part_z * crosswise_z
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
    per = 1.0 / (A * D - B * C)
    d_o, d_i = -(a * S_o + b * S_i), -(b * S_o + a * S_i)
    return (D * d_o - B * d_i) * per, (A * d_i - C * d_o) * per


@jit
def relax_friction(side, ring, y, n):
    """Add the change of friction by the change of slip within the lag to the sums, along its mean direction."""
    base, b_z = side_rows(side), ring.a_z
    for j in range(n):
        k_0 = y[base + lay.KAPPA_0 + j]
        k_1 = y[base + lay.KAPPA_1 + j]
        shift = y[base + lay.SLIP_CHANGE + j]
        shift_z = y[base + lay.SLIP_CHANGE_Z + j]
        per = 1.0 / max(k_0, 1e-300)
        e_r, e_t, e_z = (
            y[base + lay.KAPPA_R + j] * per,
            y[base + lay.KAPPA_T + j] * per,
            y[base + lay.KAPPA_Z + j] * per,
        )
        arm, skew = y[base + lay.KAPPA_ARM + j] * per, y[lay.SKEW_V_CHANGE + j]
        f = k_0 * shift + k_1 * skew
        h = k_1 * shift + y[base + lay.KAPPA_2 + j] * skew
        f_b = k_0 * shift_z
        h_b = k_1 * shift_z
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
def side_loads(side, bearing, ring, y, n):
    """Add the sums over slices to the loads on each roller, and fill its loads on the ring.

    The latter are force (N) and moment about the ring's centre (N m) along e_0, e_90, e_z: the reaction at the
    same points.
    """
    base, middle = side_rows(side), 0.5 * (bearing.R_o + bearing.R_i)
    plane, space, turn = load_cells(side)
    f_x, f_y, f_z = lay.roller_load(plane), lay.roller_load(plane + 1), lay.roller_load(space)
    m_x, m_y, m_z = lay.roller_load(space + 1), lay.roller_load(space + 2), lay.roller_load(turn)
    for j in range(n):
        c, s, real = y[lay.COS + j], y[lay.SIN + j], bearing.m_r * y[lay.INVERSE_MASS + j]
        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        G_r = y[base + lay.CONTACT_FORCE_R + j]
        G_t = y[base + lay.CONTACT_FORCE_T + j]
        G_z = y[base + lay.CONTACT_FORCE_Z + j]
        h_r = y[base + lay.CONTACT_ZETA_FORCE_R + j]
        h_t = y[base + lay.CONTACT_ZETA_FORCE_T + j]
        h_z = y[base + lay.CONTACT_ZETA_FORCE_Z + j]
        twist = y[base + lay.COUPLE_AXIAL + j]
        M_r = a_t * h_z - a_z * h_t + twist * y[base + lay.RING_AXIS_R + j] + y[base + lay.COUPLE_R + j]
        M_t = a_z * h_r - a_r * h_z + twist * y[base + lay.RING_AXIS_T + j] + y[base + lay.COUPLE_T + j]
        M_z = a_r * h_t - a_t * h_r + twist * ring.a_z + y[base + lay.COUPLE_Z + j]
        y[lay.FORCE_R + j] += G_r
        y[lay.FORCE_T + j] += G_t
        y[lay.FORCE_Z + j] += G_z
        y[lay.MOMENT_R + j] += M_r
        y[lay.MOMENT_T + j] += M_t
        y[lay.MOMENT_Z + j] += M_z
        d_r = middle + y[lay.RADIAL + j] - ring.x * c - ring.y * s
        d_t, d_z = ring.x * s - ring.y * c, y[lay.AXIAL + j] - ring.z
        N_r, N_t = M_r + d_t * G_z - d_z * G_t, M_t + d_z * G_r - d_r * G_z
        y[f_x + j], y[f_y + j], y[f_z + j] = -G_r * c + G_t * s, -G_r * s - G_t * c, -real * G_z
        y[m_x + j], y[m_y + j] = -N_r * c + N_t * s, -N_r * s - N_t * c
        y[m_z + j] = -real * (M_z + d_r * G_t - d_t * G_r)
