"""The contacts of the slices of all rollers with one race: geometry, force and friction in space.

Slice k of a roller stands at p = c + zeta_k a. With the ring's centre u and its axis b,

    d = p - u,  w = d.b,  X = d - w b,  rho = |X|,  n = X/rho,  tau = b x n
    delta = sigma (rho - R) + R_w - drop - h(s),     force on the slice  -sigma Q n + g Q tau

sigma = 1 on the outer race, -1 on the inner; g = -sigma times what a pit tilts the normal by. X and its rate grow
linearly along the roller, so each roller keeps where they are in its middle (APART, MOVES) and how they grow
(ALONG, TURNS). Sums over the slices: G of the forces, H of zeta times them; TWIST, BEND of what friction turns,
acting the arm away from p:

    moment on the roller = a x H + TWIST b + BEND

Friction over slip (KAPPA) is taken with the slip as it is, and acts on the slip as it will be a lag later (see
``laws/friction/lag.py``, ``rub``), of the mean slips of both contacts, of tilting and of skewing.
"""

from math import sqrt

from bearingsim.core.geometry.sides import rows_of, sign, totals
from bearingsim.core.jit import add, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.friction.lag import taken
from bearingsim.core.layout import (
    ALONG_R,
    ALONG_T,
    ALONG_Z,
    APART_R,
    APART_T,
    APART_Z,
    APPROACH,
    APPROACH_I,
    APPROACH_O,
    AXIAL,
    AXIAL_V,
    BEND_R,
    BEND_T,
    BEND_Z,
    BENT,
    CLOSING,
    COS,
    DRIFT,
    DRIFTS,
    EPS_V,
    FAR,
    G_R,
    G_T,
    G_Z,
    H_R,
    H_T,
    H_Z,
    INNER_SIDE,
    INVERSE_MASS,
    K_0,
    K_1,
    K_2,
    K_ARM,
    K_R,
    K_T,
    K_Z,
    KAPPA,
    KS_0,
    KS_1,
    KS_Z,
    LEAN,
    LINE_MAX,
    LOAD,
    LOAD_I,
    LOAD_O,
    LOST,
    MOVES_R,
    MOVES_T,
    MOVES_Z,
    OMEGA,
    OUT_R,
    OUT_T,
    OUT_Z,
    OUTER_SIDE,
    OWN,
    PUSH_R,
    PUSH_T,
    PUSH_Z,
    RING_R,
    RING_T,
    ROLLING,
    ROLLS,
    ROW,
    SHIFT,
    SHIFT_SKEW,
    SHIFT_Z,
    SIN,
    SINK,
    SKEW,
    SKEW_V,
    SLIP_T,
    SLIP_Z,
    SWAY_R,
    SWAY_T,
    SWAY_Z,
    TILT,
    TILT_V,
    TURN_R,
    TURN_T,
    TURN_Z,
    TURNS_R,
    TURNS_T,
    TURNS_Z,
    TWIST,
    UPRIGHT,
    UPRIGHT_V,
    Q,
    V,
)

AT_REST = 1e-12  # m/s: slip below it is none, and friction over slip the curve's slope
NONNEGATIVE = 0x7FFFFFFF  # tells the compiler that a place in the buffer is none from its end


@jit
def face(side, bearing, ring, omega_cage, y, n):
    """How each roller stands and moves relative to the ring: along its axis, all is linear."""
    at, middle = rows_of(side), 0.5 * (bearing.R_o + bearing.R_i)
    b_z, w_z = ring.a_z, ring.w_z
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        b_r, b_t = ring.a_x * c + ring.a_y * s, ring.a_y * c - ring.a_x * s
        w_r, w_t = ring.w_x * c + ring.w_y * s, ring.w_y * c - ring.w_x * s
        u_r, u_t = ring.x * c + ring.y * s, ring.y * c - ring.x * s
        a_r, a_t, a_z = y[TILT + j], y[SKEW + j], y[UPRIGHT + j]
        v_r, v_t, v_z = y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j]
        r = middle + y[Q + j]
        d_r, d_z = r - u_r, y[AXIAL + j] - ring.z
        m_r = y[V + j] - (ring.v_x * c + ring.v_y * s)
        m_t = r * (omega_cage + y[EPS_V + j]) - (ring.v_y * c - ring.v_x * s)
        m_z = y[AXIAL_V + j] - ring.v_z
        off = d_r * b_r - u_t * b_t + d_z * b_z
        along = a_r * b_r + a_t * b_t + a_z * b_z
        y[at + RING_R + j], y[at + RING_T + j] = b_r, b_t
        y[at + APART_R + j] = -u_r - off * b_r  # less r, of which it would cost digits
        y[at + APART_T + j] = -u_t - off * b_t
        y[at + APART_Z + j] = d_z - off * b_z
        y[at + ALONG_R + j] = a_r - along * b_r
        y[at + ALONG_T + j] = a_t - along * b_t
        y[at + ALONG_Z + j] = a_z - along * b_z
        y[at + MOVES_R + j] = m_r - off * w_r
        y[at + MOVES_T + j] = m_t - off * w_t
        y[at + MOVES_Z + j] = m_z - off * w_z
        y[at + TURNS_R + j] = v_r - along * w_r
        y[at + TURNS_T + j] = v_t - along * w_t
        y[at + TURNS_Z + j] = v_z - along * w_z
        omega = y[OMEGA + j]
        o_r = a_t * v_z - a_z * v_t + omega * a_r  # the roller's angular velocity
        o_t = a_z * v_r - a_r * v_z + omega * a_t
        o_z = a_r * v_t - a_t * v_r + omega * a_z
        y[at + ROLLS + j] = o_r * b_r + o_t * b_t + o_z * b_z
        y[at + DRIFT + j] = m_r * b_r + m_t * b_t + m_z * b_z + d_r * w_r - u_t * w_t + d_z * w_z
        y[at + DRIFTS + j] = v_r * b_r + v_t * b_t + v_z * b_z + a_r * w_r + a_t * w_t + a_z * w_z
        y[at + SWAY_R + j] = b_t * o_z - b_z * o_t + w_r
        y[at + SWAY_T + j] = b_z * o_r - b_r * o_z + w_t
        y[at + SWAY_Z + j] = b_r * o_t - b_t * o_r + w_z


@jit
def clear(side, y, n):
    """Empty the sums over slices, after ``face``."""
    at = rows_of(side)
    force, approach, rate, slip, across = totals(side)
    for j in range(n):
        y[force + j], y[approach + j], y[slip + j], y[across + j] = 0.0, 0.0, 0.0, 0.0
        y[rate + j] = sign(side) * y[at + MOVES_R + j]  # of the middle, nearly: for the step watch only
        y[at + G_R + j], y[at + G_T + j], y[at + G_Z + j], y[at + TWIST + j] = 0.0, 0.0, 0.0, 0.0
        y[at + H_R + j], y[at + H_T + j], y[at + H_Z + j] = 0.0, 0.0, 0.0
        y[at + BEND_R + j], y[at + BEND_T + j], y[at + BEND_Z + j] = 0.0, 0.0, 0.0
        y[at + K_0 + j], y[at + K_1 + j], y[at + K_2 + j] = 0.0, 0.0, 0.0
        y[at + KS_0 + j], y[at + KS_1 + j], y[at + KS_Z + j] = 0.0, 0.0, 0.0
        y[at + K_ARM + j], y[at + K_R + j], y[at + K_T + j], y[at + K_Z + j] = 0.0, 0.0, 0.0, 0.0


@jit
def stand(side, bearing, ring, zeta, drop, y, n):
    """Where one slice of every roller stands and how it moves: approach, its rate, slip.

    zeta, drop: m. The side's rows SINK to OWN say what the slice feels of a pit.
    """
    at, sigma, middle = rows_of(side), sign(side), 0.5 * (bearing.R_o + bearing.R_i)
    lacking, radius, b_z, turning = bearing.gap + drop, bearing.R_w - drop, ring.a_z, ring.turns
    for j in range(n):
        short = y[at + APART_R + j] + zeta * y[at + ALONG_R + j]
        X_r = middle + y[Q + j] + short
        X_t = y[at + APART_T + j] + zeta * y[at + ALONG_T + j]
        X_z = y[at + APART_Z + j] + zeta * y[at + ALONG_Z + j]
        aside = X_t * X_t + X_z * X_z
        rho = sqrt(X_r * X_r + aside)
        per_rho = 1.0 / rho
        n_r, n_t, n_z = X_r * per_rho, X_t * per_rho, X_z * per_rho
        b_r, b_t = y[at + RING_R + j], y[at + RING_T + j]
        t_r, t_t, t_z = b_t * n_z - b_z * n_t, b_z * n_r - b_r * n_z, b_r * n_t - b_t * n_r
        v_r = y[at + MOVES_R + j] + zeta * y[at + TURNS_R + j]
        v_t = y[at + MOVES_T + j] + zeta * y[at + TURNS_T + j]
        v_z = y[at + MOVES_Z + j] + zeta * y[at + TURNS_Z + j]
        apart = n_r * v_r + n_t * v_t + n_z * v_z
        across = t_r * v_r + t_t * v_t + t_z * v_z

        lean, cosine = y[at + LEAN + j], 1.0 - y[at + BENT + j]
        own, rolls, sine = y[at + OWN + j], y[at + ROLLS + j], sigma * lean * cosine
        delta = sigma * (y[Q + j] + short + aside / (rho + X_r)) - lacking - y[at + SINK + j]
        arm = sigma * (radius - 0.5 * delta)
        o_r, o_t, o_z = n_r * cosine - t_r * sine, n_t * cosine - t_t * sine, n_z * cosine - t_z * sine
        drift = y[at + DRIFT + j] + zeta * y[at + DRIFTS + j]
        drift += arm * (o_r * y[at + SWAY_R + j] + o_t * y[at + SWAY_T + j] + o_z * y[at + SWAY_Z + j])
        y[at + OUT_R + j], y[at + OUT_T + j], y[at + OUT_Z + j], y[at + FAR + j] = n_r, n_t, n_z, rho
        y[at + APPROACH + j], y[at + SLIP_Z + j] = delta, drift
        y[at + CLOSING + j] = sigma * apart - lean * (across - (turning + own * (rolls - turning)) * rho)
        y[at + SLIP_T + j] = across * cosine + apart * sine + arm * rolls - turning * (rho * cosine + arm)


@jit
def press(side, law, friction, weight, y, n):
    """Force of one slice of every roller, and its friction over slip; weight: part of the contact."""
    at = rows_of(side)
    for j in range(n):
        force = weight * (1.0 - y[at + LOST + j]) * normal_force(law, y[at + APPROACH + j], y[at + CLOSING + j])
        slip, drift = y[at + SLIP_T + j], y[at + SLIP_Z + j]
        speed = sqrt(slip * slip + drift * drift + AT_REST * AT_REST)
        y[at + LOAD + j] = force
        y[at + KAPPA + j] = mu(friction, speed, y[ROLLING + j]) * force / speed


@jit
def add_up(side, bearing, ring, zeta, weight, drop, y, n):
    """Add what acts on one slice of every roller to the sums."""
    at, sigma, radius, b_z = rows_of(side), sign(side), bearing.R_w - drop, ring.a_z
    all_force, all_approach, _, all_slip, all_across = totals(side)
    for j in range(n):
        n_r, n_t, n_z = y[at + OUT_R + j], y[at + OUT_T + j], y[at + OUT_Z + j]
        b_r, b_t = y[at + RING_R + j], y[at + RING_T + j]
        t_r, t_t, t_z = b_t * n_z - b_z * n_t, b_z * n_r - b_r * n_z, b_r * n_t - b_t * n_r
        lean, cosine = y[at + LEAN + j], 1.0 - y[at + BENT + j]
        sine, delta, slip = sigma * lean * cosine, y[at + APPROACH + j], y[at + SLIP_T + j]
        e_r, e_t, e_z = t_r * cosine + n_r * sine, t_t * cosine + n_t * sine, t_z * cosine + n_z * sine
        force, kappa, arm = y[at + LOAD + j], y[at + KAPPA + j], sigma * (radius - 0.5 * delta)
        push, shove, f, f_b = -sigma * force, lean * force, kappa * slip, kappa * y[at + SLIP_Z + j]
        g_r = push * n_r + shove * t_r - f * e_r - f_b * b_r
        g_t = push * n_t + shove * t_t - f * e_t - f_b * b_t
        g_z = push * n_z + shove * t_z - f * e_z - f_b * b_z
        y[at + G_R + j] += g_r
        y[at + G_T + j] += g_t
        y[at + G_Z + j] += g_z
        y[at + H_R + j] += zeta * g_r
        y[at + H_T + j] += zeta * g_t
        y[at + H_Z + j] += zeta * g_z
        y[at + TWIST + j] -= arm * f + y[at + OWN + j] * shove * y[at + FAR + j]
        bend, moment = arm * f_b, zeta * kappa
        y[at + BEND_R + j] += bend * e_r
        y[at + BEND_T + j] += bend * e_t
        y[at + BEND_Z + j] += bend * e_z
        y[at + K_0 + j] += kappa
        y[at + K_1 + j] += moment
        y[at + K_2 + j] += zeta * moment
        y[at + KS_0 + j] += f
        y[at + KS_1 + j] += zeta * f
        y[at + KS_Z + j] += f_b
        y[at + K_ARM + j] += kappa * arm
        y[at + K_R + j] += kappa * e_r
        y[at + K_T + j] += kappa * e_t
        y[at + K_Z + j] += kappa * e_z
        y[all_force + j] += force
        y[all_across + j] += shove
        y[all_slip + j] += weight * slip
        y[all_approach + j] += weight * max(delta, 0.0)


@jit
def keep_slice(row, y, n):
    """Keep the loads and approaches of one slice, whose rows begin at ``row``."""
    row &= NONNEGATIVE
    for j in range(n):
        y[row + LOAD_O * ROW + j] = y[OUTER_SIDE + LOAD + j]
        y[row + LOAD_I * ROW + j] = y[INNER_SIDE + LOAD + j]
        y[row + APPROACH_O * ROW + j] = y[OUTER_SIDE + APPROACH + j]
        y[row + APPROACH_I * ROW + j] = y[INNER_SIDE + APPROACH + j]


@jit
def keep_line_load(row, width, y, n):
    """Take the loads of one slice, ``width`` (m) wide, whose rows begin at ``row``, into the largest line load."""
    row &= NONNEGATIVE
    per_width = 1.0 / width
    for j in range(n):
        most = max(y[row + LOAD_O * ROW + j], y[row + LOAD_I * ROW + j])
        y[LINE_MAX + j] = max(y[LINE_MAX + j], most * per_width)


@jit
def relax(lag, m_r, I_r, I_t, R_w, y, n):
    """How the slips of every roller will change within the lag (s): fills SHIFT, SHIFT_Z and SHIFT_SKEW.

    Of the lag a part is ``taken``. Along the race: the mean slips of both contacts and the rate of skew, three
    equations of which the last is eliminated. Along the axis: the mean slips of both contacts, which a roller's
    shift and tilting change.
    """
    outer, inner = OUTER_SIDE, INNER_SIDE
    along, crosswise = lag * (1.0 / m_r + R_w * R_w / I_r), lag * (1.0 / m_r - R_w * R_w / I_r)
    along_z, crosswise_z = lag * (1.0 / m_r + R_w * R_w / I_t), lag * (1.0 / m_r - R_w * R_w / I_t)
    for j in range(n):
        K = y[outer + K_0 + j] + y[inner + K_0 + j]
        part, part_z = taken(along * K), taken(along_z * K)
        a, b, g = part * along, part * crosswise, part * lag / I_t
        a_z, b_z = part_z * along_z, part_z * crosswise_z
        N_o, N_i = y[outer + K_1 + j], y[inner + K_1 + j]
        M = y[outer + KS_1 + j] + y[inner + KS_1 + j]
        gamma = g / (1.0 + g * (y[outer + K_2 + j] + y[inner + K_2 + j]))
        k_oo, k_oi = y[outer + K_0 + j] - gamma * N_o * N_o, -gamma * N_o * N_i
        k_ii = y[inner + K_0 + j] - gamma * N_i * N_i
        S_o, S_i = y[outer + KS_0 + j] - gamma * N_o * M, y[inner + KS_0 + j] - gamma * N_i * M
        s_o, s_i = change(a, b, k_oo, k_oi, k_ii, S_o, S_i)
        y[outer + SHIFT + j], y[inner + SHIFT + j] = s_o, s_i
        y[SHIFT_SKEW + j] = -gamma * (M + N_o * s_o + N_i * s_i)
        y[outer + SHIFT_Z + j], y[inner + SHIFT_Z + j] = change(
            a_z, b_z, y[outer + K_0 + j], 0.0, y[inner + K_0 + j], y[outer + KS_Z + j], y[inner + KS_Z + j]
        )


@jit
def change(a, b, k_oo, k_oi, k_ii, S_o, S_i):
    """Changes s of two slips that follow from forces F = S + k s by s = -(a F_o + b F_i), -(b F_o + a F_i)."""
    A, B = 1.0 + a * k_oo + b * k_oi, a * k_oi + b * k_ii
    C, D = b * k_oo + a * k_oi, 1.0 + b * k_oi + a * k_ii
    per = 1.0 / (A * D - B * C)
    d_o, d_i = -(a * S_o + b * S_i), -(b * S_o + a * S_i)
    return (D * d_o - B * d_i) * per, (A * d_i - C * d_o) * per


@jit
def rub(side, ring, y, n):
    """Change the friction in the sums to that of the slips a lag later, along its mean direction."""
    at, b_z = rows_of(side), ring.a_z
    for j in range(n):
        k_0, k_1, shift, shift_z = y[at + K_0 + j], y[at + K_1 + j], y[at + SHIFT + j], y[at + SHIFT_Z + j]
        per = 1.0 / max(k_0, 1e-300)
        e_r, e_t, e_z = y[at + K_R + j] * per, y[at + K_T + j] * per, y[at + K_Z + j] * per
        arm, skew = y[at + K_ARM + j] * per, y[SHIFT_SKEW + j]
        f, h, f_b, h_b = (
            k_0 * shift + k_1 * skew,
            k_1 * shift + y[at + K_2 + j] * skew,
            k_0 * shift_z,
            k_1 * shift_z,
        )
        b_r, b_t = y[at + RING_R + j], y[at + RING_T + j]
        y[at + G_R + j] -= f * e_r + f_b * b_r
        y[at + G_T + j] -= f * e_t + f_b * b_t
        y[at + G_Z + j] -= f * e_z + f_b * b_z
        y[at + H_R + j] -= h * e_r + h_b * b_r
        y[at + H_T + j] -= h * e_t + h_b * b_t
        y[at + H_Z + j] -= h * e_z + h_b * b_z
        y[at + TWIST + j] -= arm * f
        y[at + BEND_R + j] += arm * f_b * e_r
        y[at + BEND_T + j] += arm * f_b * e_t
        y[at + BEND_Z + j] += arm * f_b * e_z


@jit
def gather(side, bearing, ring, y, n):
    """Add the sums over slices to what acts on each roller; returns force (N) and moment (N m) on the ring.

    Both along e_0, e_90, e_z; the moment is about the ring's centre. What a roller feels, the ring feels at the
    same points: minus the force, and minus its moment about the ring's centre.
    """
    at, middle = rows_of(side), 0.5 * (bearing.R_o + bearing.R_i)
    f_x, f_y, f_z, m_x, m_y, m_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        c, s, real = y[COS + j], y[SIN + j], bearing.m_r * y[INVERSE_MASS + j]
        a_r, a_t, a_z = y[TILT + j], y[SKEW + j], y[UPRIGHT + j]
        G_r, G_t, G_z = y[at + G_R + j], y[at + G_T + j], y[at + G_Z + j]
        h_r, h_t, h_z, twist = y[at + H_R + j], y[at + H_T + j], y[at + H_Z + j], y[at + TWIST + j]
        M_r = a_t * h_z - a_z * h_t + twist * y[at + RING_R + j] + y[at + BEND_R + j]
        M_t = a_z * h_r - a_r * h_z + twist * y[at + RING_T + j] + y[at + BEND_T + j]
        M_z = a_r * h_t - a_t * h_r + twist * ring.a_z + y[at + BEND_Z + j]
        y[PUSH_R + j] += G_r
        y[PUSH_T + j] += G_t
        y[PUSH_Z + j] += G_z
        y[TURN_R + j] += M_r
        y[TURN_T + j] += M_t
        y[TURN_Z + j] += M_z
        d_r = middle + y[Q + j] - ring.x * c - ring.y * s
        d_t, d_z = ring.x * s - ring.y * c, y[AXIAL + j] - ring.z
        N_r, N_t = M_r + d_t * G_z - d_z * G_t, M_t + d_z * G_r - d_r * G_z
        f_x = add(f_x, -G_r * c + G_t * s)
        f_y = add(f_y, -G_r * s - G_t * c)
        f_z = add(f_z, -real * G_z)
        m_x = add(m_x, -N_r * c + N_t * s)
        m_y = add(m_y, -N_r * s - N_t * c)
        m_z = add(m_z, -real * (M_z + d_r * G_t - d_t * G_r))
    return f_x, f_y, f_z, m_x, m_y, m_z
