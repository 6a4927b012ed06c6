"""The cage in space: how it leans and moves along the axis, and its pockets as slices of a roller meet them.

A pocket's walls are planes fixed to the cage: with r the pocket's radial direction (across the cage's axis b) and
w = b x r across the walls, p a slice's middle and c_c the cage's centre,

    e = (p - c_c).w      N = pocket(|e| - c_p/2, d|e|/dt)  against e, at p

for each slice its part of the pocket's law; the roller's surface rubs on the wall along r and b. Along the axis a
pocket stops its roller, the law acting on |(c - c_c).b| - play_z, at c along b.
"""

from math import sqrt
from typing import Any, NamedTuple

from bearingsim.core.geometry.orientation import Body, body_at, tip, winding_rate
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA
from bearingsim.core.geometry.vectors import across, both, cross, dot, mix, turning
from bearingsim.core.jit import absent, add, generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.layout import (
    ACCELERATION,
    AXIAL,
    AXIAL_V,
    C_AX,
    C_RAD,
    CE,
    EPS_V,
    F_X_C,
    F_Y_C,
    F_Z_C,
    GAP,
    GAP_V,
    H_AX,
    H_RAD,
    H_W,
    IN_GAP,
    IN_GAP_V,
    IN_WALL,
    IN_WALL_Z,
    INVERSE_MASS,
    LEAN_X_C,
    LEAN_Y_C,
    M_C,
    M_X_C,
    M_Y_C,
    N_AX,
    N_RAD,
    N_W,
    OMEGA,
    PC,
    POSITION,
    PS,
    PUSH_R,
    PUSH_T,
    PUSH_Z,
    Q_P,
    RUB_P,
    SE,
    SKEW,
    SKEW_V,
    SPINS,
    SWINGS,
    TILT,
    TILT_V,
    TURN_R,
    TURN_T,
    TURN_Z,
    UPRIGHT,
    UPRIGHT_V,
    VELOCITY,
    WALL,
    WALL_Z,
    X_C,
    Y_C,
    Z_C,
    Q,
    V,
)
from bearingsim.core.parts.cage import FreeCage, radial_stop
from bearingsim.core.parts.races_in_space import AT_REST


@absent
class CageInPlane(NamedTuple):
    """The cage neither leans nor moves along the axis, and does not hold rollers along it."""


class CageInSpace(NamedTuple):
    """The cage leans and moves along the axis as the rollers in its pockets push it.

    I_t: its moment of inertia about a diameter (kg m^2); play_z: of a roller in its pocket along the axis, to
    either side (m); law: of the contact between a roller's end and its pocket.
    """

    I_t: float
    play_z: float
    law: Any


@generic
def cage_body(cage_z: Any, omega_cage: float, y: Any) -> Body:
    """The cage as it stands and moves; omega_cage: rate of its angle (rad/s)."""


@cage_body.register(CageInPlane)
def _cage_body_plane(cage_z, omega_cage, y):
    p, v = POSITION, VELOCITY
    return Body(y[p + X_C], y[p + Y_C], 0.0, y[v + X_C], y[v + Y_C], 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, omega_cage)


@cage_body.register(CageInSpace)
def _cage_body_space(cage_z, omega_cage, y):
    return body_at(y, X_C, Z_C, LEAN_X_C, LEAN_Y_C, omega_cage)


@generic(absent=0.0)
def axial_stop(cage_z: Any, out: float, speed: float) -> float:
    """Force (N) of a pocket on its roller along the cage's axis, ``out`` (m) and ``speed`` (m/s) outwards."""


@axial_stop.register(CageInSpace)
def _axial_stop_space(cage_z, out, speed):
    force = normal_force(cage_z.law, abs(out) - cage_z.play_z, speed if out > 0.0 else -speed)
    return -force if out > 0.0 else force


@generic(absent=0.0)
def lean_cage(cage_z: Any, cage: Any, body: Body, y: Any) -> float:
    """Write the accelerations of the cage along the axis and of its axis; returns its ``winding_rate``."""


@lean_cage.register(CageInSpace)
def _lean_cage_space(cage_z, cage, body, y):
    b, spin = body, cage.inertia * body.turns
    l_x, l_y = tip(y[M_X_C], y[M_Y_C], y[M_C], spin, cage_z.I_t, b.a_x, b.a_y, b.a_z, b.w_x, b.w_y, b.w_z)
    y[ACCELERATION + Z_C] = y[F_Z_C] / cage.m
    y[ACCELERATION + LEAN_X_C], y[ACCELERATION + LEAN_Y_C] = l_x, l_y
    return winding_rate(body, l_x, l_y)


@generic(absent=0.0)
def axial_stiffness(cage_z: Any, cage: Any, per_mass: float) -> float:
    """Stiffness of a pocket's end over the mass (1/s^2) of what it parts, a roller's inverse mass being given."""


@axial_stiffness.register(CageInSpace)
def _axial_stiffness_space(cage_z, cage, per_mass):
    return tangent(cage_z.law.stiffness, cage_z.play_z) * (per_mass + 2.0 / cage.m)


@generic(absent=None)
def pockets_in_space(cage: Any, model: Any, body: Body, omega_cage: float, spin: float, y: Any, n: int) -> None:
    """Add the pockets' forces to the rollers' PUSH and TURN rows and fill the cage's cells and Q_P.

    omega_cage, spin: rate of the cage's angle, and a roller's nominal spin (rad/s).
    """


@pockets_in_space.register(FreeCage)
def _pockets_free(cage, model, body, omega_cage, spin, y, n):
    face_walls(model.bearing, body, omega_cage, y, n)
    if within_reach(cage.play, 0.5 * model.L_w, y, n):
        for k in range(len(model.slices.table)):
            table = model.slices.table
            wall_slice(cage, model.bearing, abs(spin), table[k, ZETA], table[k, WEIGHT], table[k, DROP], y, n)
    gather_pockets(cage, model, body, omega_cage, y, n)


@jit
def pocket_axes(body, pc, ps, ce, se):
    """A pocket's r and w along the roller's e_r, e_theta, e_z; the cage's axis along e_r, e_theta."""
    p_r, p_t = body.a_x * pc + body.a_y * ps, body.a_y * pc - body.a_x * ps  # the axis as the pocket sees it
    b_r, b_t = p_r * ce + p_t * se, p_t * ce - p_r * se
    h = 1.0 / (1.0 + body.a_z)
    u, q = p_r * h, p_t * h
    return (
        (ce - u * b_r, -se - u * b_t, -p_r),
        (se - q * b_r, ce - q * b_t, -p_t),
        (b_r, b_t),
        q,
    )


@jit
def apart(bearing, body, omega_cage, y, j):
    """A roller's centre less the cage's, and its velocity as seen from the cage, along e_r, e_theta, e_z."""
    c, s = y[PC + j] * y[CE + j] - y[PS + j] * y[SE + j], y[PS + j] * y[CE + j] + y[PC + j] * y[SE + j]
    r = 0.5 * (bearing.R_o + bearing.R_i) + y[Q + j]
    d_r, d_t, d_z = r - body.x * c - body.y * s, body.x * s - body.y * c, y[AXIAL + j] - body.z
    O_r, O_t, O_z = turning(body, c, s)
    x_r, x_t, x_z = across(O_r, O_t, O_z, d_r, d_t, d_z)
    v_r = y[V + j] - body.v_x * c - body.v_y * s - x_r
    v_t = r * (omega_cage + y[EPS_V + j]) + body.v_x * s - body.v_y * c - x_t
    return d_r, d_t, d_z, v_r, v_t, y[AXIAL_V + j] - body.v_z - x_z


@jit
def face_walls(bearing, body, omega_cage, y, n):
    """How each roller stands in its pocket and slips along the wall: along its axis, all is linear."""
    for j in range(n):
        pc, ps, ce, se = y[PC + j], y[PS + j], y[CE + j], y[SE + j]
        rad, w, b, q = pocket_axes(body, pc, ps, ce, se)
        d_r, d_t, d_z, v_r, v_t, v_z = apart(bearing, body, omega_cage, y, j)
        O_r, O_t, O_z = turning(body, pc * ce - ps * se, ps * ce + pc * se)
        a_r, a_t, a_z = y[TILT + j], y[SKEW + j], y[UPRIGHT + j]
        g_r, g_t, g_z = y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j]
        x_r, x_t, x_z = across(O_r, O_t, O_z, a_r, a_t, a_z)
        o_r, o_t, o_z = across(a_r, a_t, a_z, g_r, g_t, g_z)
        g_r, g_t, g_z = g_r - x_r, g_t - x_t, g_z - x_z
        omega = y[OMEGA + j]
        o_r, o_t, o_z = o_r + omega * a_r - O_r, o_t + omega * a_t - O_t, o_z + omega * a_z - O_z
        r = 0.5 * (bearing.R_o + bearing.R_i) + y[Q + j]
        off = d_r * b[0] + d_t * b[1] + d_z * body.a_z
        y[GAP + j] = r * se + body.x * ps - body.y * pc - q * (off + d_z)
        y[IN_GAP + j] = a_r * w[0] + a_t * w[1] + a_z * w[2]
        y[GAP_V + j] = v_r * w[0] + v_t * w[1] + v_z * w[2]
        y[IN_GAP_V + j] = g_r * w[0] + g_t * w[1] + g_z * w[2]
        y[WALL + j] = v_r * rad[0] + v_t * rad[1] + v_z * rad[2]
        y[IN_WALL + j] = g_r * rad[0] + g_t * rad[1] + g_z * rad[2]
        y[WALL_Z + j] = v_r * b[0] + v_t * b[1] + v_z * body.a_z
        y[IN_WALL_Z + j] = g_r * b[0] + g_t * b[1] + g_z * body.a_z
        y[SPINS + j] = o_r * b[0] + o_t * b[1] + o_z * body.a_z
        y[SWINGS + j] = o_r * rad[0] + o_t * rad[1] + o_z * rad[2]
        y[N_W + j], y[N_RAD + j], y[N_AX + j], y[C_AX + j] = 0.0, 0.0, 0.0, 0.0
        y[H_W + j], y[H_RAD + j], y[H_AX + j], y[C_RAD + j] = 0.0, 0.0, 0.0, 0.0
        y[RUB_P + j] = 0.0


@jit
def within_reach(play, half, y, n):
    """Whether any roller, ``half`` (m) of its length to either side, touches its pocket."""
    touching = 0.0
    for j in range(n):
        touching = add(touching, 1.0 if abs(y[GAP + j]) + half * abs(y[IN_GAP + j]) > play else 0.0)
    return touching > 0.0


@jit
def wall_slice(cage, bearing, spin, zeta, weight, drop, y, n):
    """Force and friction of the pocket's wall on one slice of every roller; adds to the sums."""
    radius = bearing.R_w - drop
    for j in range(n):
        real = weight * bearing.m_r * y[INVERSE_MASS + j]  # 0 in a padded lane
        e = y[GAP + j] + zeta * y[IN_GAP + j]
        side = 1.0 if e > 0.0 else -1.0
        rate = side * (y[GAP_V + j] + zeta * y[IN_GAP_V + j])
        N = real * normal_force(cage.pocket, abs(e) - cage.play, rate)
        slip = y[WALL + j] + zeta * y[IN_WALL + j] - side * radius * y[SPINS + j]
        drift = y[WALL_Z + j] + zeta * y[IN_WALL_Z + j] + side * radius * y[SWINGS + j]
        speed = sqrt(slip * slip + drift * drift + AT_REST * AT_REST)
        kappa = mu(cage.friction, speed, bearing.R_w * spin) * N / speed
        f, f_b = kappa * slip, kappa * drift
        y[N_W + j] -= side * N
        y[N_RAD + j] -= f
        y[N_AX + j] -= f_b
        y[H_W + j] -= zeta * side * N
        y[H_RAD + j] -= zeta * f
        y[H_AX + j] -= zeta * f_b
        y[C_AX + j] += side * radius * f
        y[C_RAD + j] -= side * radius * f_b
        y[RUB_P + j] += kappa


@jit
def of_pocket(cage, model, body, omega_cage, y, j):
    """Force and moment of a pocket on its roller, stops included, and the roller's centre less the cage's."""
    b, real = model.bearing, model.bearing.m_r * y[INVERSE_MASS + j]
    rad, w, leans, _ = pocket_axes(body, y[PC + j], y[PS + j], y[CE + j], y[SE + j])
    axis = leans[0], leans[1], body.a_z
    d_r, d_t, d_z, _, _, _ = apart(b, body, omega_cage, y, j)
    d = d_r, d_t, d_z
    out, aside = dot(d, rad) - 0.5 * (b.R_o + b.R_i), dot(d, axis)
    along_r = y[N_RAD + j] + real * radial_stop(cage.guide, out, y[WALL + j])
    along_b = y[N_AX + j] + real * axial_stop(model.cage_z, aside, y[WALL_Z + j])
    F = mix(y[N_W + j], w, along_r, rad, along_b, axis)
    H = mix(y[H_W + j], w, y[H_RAD + j], rad, y[H_AX + j], axis)
    tilts = cross((y[TILT + j], y[SKEW + j], y[UPRIGHT + j]), H)
    return F, mix(1.0, tilts, y[C_AX + j], axis, y[C_RAD + j], rad), d


@jit
def gather_pockets(cage, model, body, omega_cage, y, n):
    """Add what pockets do to the rollers, stops included, and fill the cage's cells with the opposite."""
    f_x, f_y, f_z, m_x, m_y, m_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        F, M, d = of_pocket(cage, model, body, omega_cage, y, j)
        y[Q_P + j] = y[N_W + j]
        y[PUSH_R + j] += F[0]
        y[PUSH_T + j] += F[1]
        y[PUSH_Z + j] += F[2]
        y[TURN_R + j] += M[0]
        y[TURN_T + j] += M[1]
        y[TURN_Z + j] += M[2]
        c, s = y[PC + j] * y[CE + j] - y[PS + j] * y[SE + j], y[PS + j] * y[CE + j] + y[PC + j] * y[SE + j]
        N = both(1.0, M, 1.0, cross(d, F))  # about the cage's centre
        f_x = add(f_x, -F[0] * c + F[1] * s)
        f_y = add(f_y, -F[0] * s - F[1] * c)
        f_z = add(f_z, -F[2])
        m_x = add(m_x, -N[0] * c + N[1] * s)
        m_y = add(m_y, -N[0] * s - N[1] * c)
        m_z = add(m_z, -N[2])
    y[F_X_C], y[F_Y_C], y[F_Z_C] = f_x, f_y, f_z
    y[M_X_C], y[M_Y_C], y[M_C] = m_x, m_y, m_z
