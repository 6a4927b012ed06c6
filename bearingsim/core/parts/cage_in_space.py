"""Cage in space: tilt and axial motion, and contacts of the rollers' slices with the pockets.

The walls of a pocket are planes fixed to the cage. With r the pocket's radial direction (perpendicular to the
cage's axis b), w = b x r normal to the walls, p the centre of a slice and c_c the cage's centre,

    e = (p - c_c).w,     N = pocket(|e| - c_p/2, d|e|/dt)  at p, opposite to e

where each slice has its share of the pocket's law. Friction between roller and wall acts along r and b. Axially, a
pocket stops its roller by the law applied to |(c - c_c).b| - play_z, with the force at c along b.
"""

from math import sqrt
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.orientation import Body, axis_acceleration, axis_precession_rate, body_at
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA
from bearingsim.core.geometry.vectors import angular_velocity, combine, combine_three, cross, cross_components, dot
from bearingsim.core.jit import absent, generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.parts.cage import FreeCage, radial_stop
from bearingsim.core.parts.races_in_space import SLIP_OFFSET


@absent
class CageInPlane(NamedTuple):
    """Cage without tilt, axial motion or axial stops for the rollers."""


class CageInSpace(NamedTuple):
    """Cage that tilts and moves axially under the forces of the rollers in its pockets.

    I_t: moment of inertia of the cage about a diameter (kg m^2); play_z: axial play of a roller in its pocket to
    either side (m); law: contact law of a roller's end and its pocket.
    """

    I_t: float
    play_z: float
    law: Any


@generic
def cage_body(cage_z: Any, omega_cage: float, y: Any) -> Body:
    """Return position and motion of the cage; omega_cage: rate of its angle (rad/s)."""


@cage_body.register(CageInPlane)
def _cage_body_plane(cage_z, omega_cage, y):
    p, v = lay.POSITION, lay.VELOCITY
    return Body(
        y[p + lay.X_C],
        y[p + lay.Y_C],
        0.0,
        y[v + lay.X_C],
        y[v + lay.Y_C],
        0.0,
        0.0,
        0.0,
        1.0,
        0.0,
        0.0,
        0.0,
        omega_cage,
    )


@cage_body.register(CageInSpace)
def _cage_body_space(cage_z, omega_cage, y):
    return body_at(y, lay.X_C, lay.Z_C, lay.CAGE_TILT_X, lay.CAGE_TILT_Y, omega_cage)


@generic(absent=0.0)
def axial_stop(cage_z: Any, offset: float, speed: float) -> float:
    """Return the force (N) of a pocket on its roller along the cage's axis.

    offset, speed: axial displacement from the pocket's centre (m) and its rate (m/s).
    """


@axial_stop.register(CageInSpace)
def _axial_stop_space(cage_z, offset, speed):
    force = normal_force(cage_z.law, abs(offset) - cage_z.play_z, speed if offset > 0.0 else -speed)
    return -force if offset > 0.0 else force


@generic(absent=0.0)
def accelerate_cage_axis(cage_z: Any, cage: Any, body: Body, y: Any) -> float:
    """Write the axial acceleration of the cage and that of its axis; return its ``axis_precession_rate``."""


@accelerate_cage_axis.register(CageInSpace)
def _accelerate_cage_axis_space(cage_z, cage, body, y):
    b, spin = body, cage.inertia * body.omega
    l_x, l_y = axis_acceleration(
        y[lay.M_X_C], y[lay.M_Y_C], y[lay.M_C], spin, cage_z.I_t, b.a_x, b.a_y, b.a_z, b.w_x, b.w_y, b.w_z
    )
    y[lay.ACCELERATION + lay.Z_C] = y[lay.F_Z_C] / cage.m
    y[lay.ACCELERATION + lay.CAGE_TILT_X], y[lay.ACCELERATION + lay.CAGE_TILT_Y] = l_x, l_y
    return axis_precession_rate(body, l_x, l_y)


@generic(absent=0.0)
def axial_stiffness(cage_z: Any, cage: Any, per_mass: float, Z: int) -> float:
    """Return the stiffness of the pockets' ends over the effective mass (1/s^2) of ``Z`` rollers and the cage.

    per_mass: inverse mass of a roller (1/kg). That of the cage is Z/m if all rollers push it. Tilt adds less,
    because the moment of inertia about a diameter is at least m r^2/2.
    """


@axial_stiffness.register(CageInSpace)
def _axial_stiffness_space(cage_z, cage, per_mass, Z):
    return tangent(cage_z.law.stiffness, cage_z.play_z) * (per_mass + Z / cage.m)


@generic(absent=None)
def add_pocket_forces_in_space(
    cage: Any, model: Any, body: Body, omega_cage: float, spin: float, y: Any, n: int
) -> None:
    """Add the pocket forces to the FORCE and MOMENT rows of the rollers; fill Q_P and the loads on the cage.

    omega_cage, spin: rate of the cage's angle, and nominal spin of a roller (rad/s).
    """


@add_pocket_forces_in_space.register(FreeCage)
def _add_pocket_forces_free(cage, model, body, omega_cage, spin, y, n):
    fill_pocket_kinematics(model.bearing, body, omega_cage, y, n)
    if any_pocket_contact(cage.play, 0.5 * model.L_w, y, n):
        for k in range(len(model.slices.table)):
            table = model.slices.table
            add_pocket_slice_force(
                cage, model.bearing, abs(spin), table[k, ZETA], table[k, WEIGHT], table[k, DROP], y, n
            )
    add_pocket_loads(cage, model, body, omega_cage, y, n)


@jit
def pocket_axes(body, pc, ps, ce, se):
    """Return r and w of a pocket along the roller's e_r, e_theta, e_z; the cage's axis b along e_r, e_theta; and
    the component of b along the pocket's e_theta over (1 + b_z)."""
    p_r, p_t = body.a_x * pc + body.a_y * ps, body.a_y * pc - body.a_x * ps  # b along the pocket's e_r, e_theta
    b_r, b_t = p_r * ce + p_t * se, p_t * ce - p_r * se
    h = 1.0 / (1.0 + body.a_z)
    u, q = p_r * h, p_t * h
    return ((ce - u * b_r, -se - u * b_t, -p_r), (se - q * b_r, ce - q * b_t, -p_t), (b_r, b_t), q)


@jit
def motion_in_cage(bearing, body, omega_cage, y, j):
    """Return position and velocity of a roller's centre relative to the cage, along e_r, e_theta, e_z."""
    c = y[lay.COS_POCKET + j] * y[lay.COS_EPS + j] - y[lay.SIN_POCKET + j] * y[lay.SIN_EPS + j]
    s = y[lay.SIN_POCKET + j] * y[lay.COS_EPS + j] + y[lay.COS_POCKET + j] * y[lay.SIN_EPS + j]
    r = 0.5 * (bearing.R_o + bearing.R_i) + y[lay.RADIAL + j]
    d_r, d_t, d_z = r - body.x * c - body.y * s, body.x * s - body.y * c, y[lay.AXIAL + j] - body.z
    O_r, O_t, O_z = angular_velocity(body, c, s)
    x_r, x_t, x_z = cross_components(O_r, O_t, O_z, d_r, d_t, d_z)  # velocity of the cage at the roller's centre
    v_r = y[lay.RADIAL_V + j] - body.v_x * c - body.v_y * s - x_r
    v_t = r * (omega_cage + y[lay.EPS_V + j]) + body.v_x * s - body.v_y * c - x_t
    return d_r, d_t, d_z, v_r, v_t, y[lay.AXIAL_V + j] - body.v_z - x_z


@jit
def fill_pocket_kinematics(bearing, body, omega_cage, y, n):
    """Fill each roller's position in its pocket and slip along the wall as linear functions along its axis.

    Set the sums over slices to zero.
    """
    for j in range(n):
        pc, ps, ce, se = y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
        radial, w, b, q = pocket_axes(body, pc, ps, ce, se)
        d_r, d_t, d_z, v_r, v_t, v_z = motion_in_cage(bearing, body, omega_cage, y, j)
        O_r, O_t, O_z = angular_velocity(body, pc * ce - ps * se, ps * ce + pc * se)
        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        g_r, g_t, g_z = y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]
        x_r, x_t, x_z = cross_components(O_r, O_t, O_z, a_r, a_t, a_z)
        o_r, o_t, o_z = cross_components(a_r, a_t, a_z, g_r, g_t, g_z)
        # rate of the roller's axis and angular velocity of the roller, relative to the cage
        g_r, g_t, g_z = g_r - x_r, g_t - x_t, g_z - x_z
        omega = y[lay.OMEGA + j]
        o_r, o_t, o_z = o_r + omega * a_r - O_r, o_t + omega * a_t - O_t, o_z + omega * a_z - O_z
        r = 0.5 * (bearing.R_o + bearing.R_i) + y[lay.RADIAL + j]
        axial_offset = d_r * b[0] + d_t * b[1] + d_z * body.a_z
        y[lay.POCKET_OFFSET + j] = r * se + body.x * ps - body.y * pc - q * (axial_offset + d_z)
        y[lay.POCKET_OFFSET_SLOPE + j] = a_r * w[0] + a_t * w[1] + a_z * w[2]
        y[lay.POCKET_OFFSET_V + j] = v_r * w[0] + v_t * w[1] + v_z * w[2]
        y[lay.POCKET_OFFSET_V_SLOPE + j] = g_r * w[0] + g_t * w[1] + g_z * w[2]
        y[lay.POCKET_SLIP + j] = v_r * radial[0] + v_t * radial[1] + v_z * radial[2]
        y[lay.POCKET_SLIP_SLOPE + j] = g_r * radial[0] + g_t * radial[1] + g_z * radial[2]
        y[lay.POCKET_SLIP_Z + j] = v_r * b[0] + v_t * b[1] + v_z * body.a_z
        y[lay.POCKET_SLIP_Z_SLOPE + j] = g_r * b[0] + g_t * b[1] + g_z * body.a_z
        y[lay.POCKET_OMEGA_Z + j] = o_r * b[0] + o_t * b[1] + o_z * body.a_z
        y[lay.POCKET_OMEGA_R + j] = o_r * radial[0] + o_t * radial[1] + o_z * radial[2]
        y[lay.POCKET_FORCE_W + j] = 0.0
        y[lay.POCKET_FORCE_R + j] = 0.0
        y[lay.POCKET_FORCE_Z + j] = 0.0
        y[lay.POCKET_COUPLE_Z + j] = 0.0
        y[lay.POCKET_ZETA_FORCE_W + j] = 0.0
        y[lay.POCKET_ZETA_FORCE_R + j] = 0.0
        y[lay.POCKET_ZETA_FORCE_Z + j] = 0.0
        y[lay.POCKET_COUPLE_R + j] = 0.0
        y[lay.KAPPA_P + j] = 0.0


@jit
def any_pocket_contact(play, half_length, y, n):
    """Check if any roller touches its pocket; half_length: of a roller (m)."""
    contacts = 0
    for j in range(n):
        max_offset = abs(y[lay.POCKET_OFFSET + j]) + half_length * abs(y[lay.POCKET_OFFSET_SLOPE + j])
        contacts += 1 if max_offset > play else 0
    return contacts > 0


@jit
def add_pocket_slice_force(cage, bearing, spin, zeta, weight, drop, y, n):
    """Add normal force and friction of the pocket's wall on one slice of every roller to the sums.

    spin: magnitude of the nominal spin of a roller (rad/s); zeta, drop: m; weight: share of the contact.

    Equation (S5) of docs/spatial.md.
    """
    radius = bearing.R_w - drop
    for j in range(n):
        mask = weight * bearing.m_r * y[lay.INVERSE_MASS + j]  # 0 in a padded lane
        e = y[lay.POCKET_OFFSET + j] + zeta * y[lay.POCKET_OFFSET_SLOPE + j]
        side = 1.0 if e > 0.0 else -1.0
        rate = side * (y[lay.POCKET_OFFSET_V + j] + zeta * y[lay.POCKET_OFFSET_V_SLOPE + j])
        N = mask * normal_force(cage.pocket, abs(e) - cage.play, rate)
        slip = (
            y[lay.POCKET_SLIP + j]
            + zeta * y[lay.POCKET_SLIP_SLOPE + j]
            - side * radius * y[lay.POCKET_OMEGA_Z + j]
        )
        slip_z = (
            y[lay.POCKET_SLIP_Z + j]
            + zeta * y[lay.POCKET_SLIP_Z_SLOPE + j]
            + side * radius * y[lay.POCKET_OMEGA_R + j]
        )
        speed = sqrt(slip * slip + slip_z * slip_z + SLIP_OFFSET * SLIP_OFFSET)
        kappa = mu(cage.friction, speed, bearing.R_w * spin) * N / speed
        f, f_b = kappa * slip, kappa * slip_z
        y[lay.POCKET_FORCE_W + j] -= side * N
        y[lay.POCKET_FORCE_R + j] -= f
        y[lay.POCKET_FORCE_Z + j] -= f_b
        y[lay.POCKET_ZETA_FORCE_W + j] -= zeta * side * N
        y[lay.POCKET_ZETA_FORCE_R + j] -= zeta * f
        y[lay.POCKET_ZETA_FORCE_Z + j] -= zeta * f_b
        y[lay.POCKET_COUPLE_Z + j] += side * radius * f
        y[lay.POCKET_COUPLE_R + j] -= side * radius * f_b
        y[lay.KAPPA_P + j] += kappa


@jit
def pocket_load(cage, model, body, omega_cage, y, j):
    """Return force and moment of a pocket on its roller, stops included, and the roller's position relative to the
    cage's centre, along e_r, e_theta, e_z."""
    b, mask = model.bearing, model.bearing.m_r * y[lay.INVERSE_MASS + j]
    radial, w, axis_in_plane, _ = pocket_axes(
        body, y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
    )
    axis = axis_in_plane[0], axis_in_plane[1], body.a_z
    d_r, d_t, d_z, _, _, _ = motion_in_cage(b, body, omega_cage, y, j)
    d = d_r, d_t, d_z
    radial_offset, axial_offset = dot(d, radial) - 0.5 * (b.R_o + b.R_i), dot(d, axis)
    along_r = y[lay.POCKET_FORCE_R + j] + mask * radial_stop(cage.guide, radial_offset, y[lay.POCKET_SLIP + j])
    along_b = y[lay.POCKET_FORCE_Z + j] + mask * axial_stop(model.cage_z, axial_offset, y[lay.POCKET_SLIP_Z + j])
    F = combine_three(y[lay.POCKET_FORCE_W + j], w, along_r, radial, along_b, axis)
    H = combine_three(
        y[lay.POCKET_ZETA_FORCE_W + j],
        w,
        y[lay.POCKET_ZETA_FORCE_R + j],
        radial,
        y[lay.POCKET_ZETA_FORCE_Z + j],
        axis,
    )
    tilting_moment = cross((y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]), H)
    return (
        F,
        combine_three(1.0, tilting_moment, y[lay.POCKET_COUPLE_Z + j], axis, y[lay.POCKET_COUPLE_R + j], radial),
        d,
    )


@jit
def add_pocket_loads(cage, model, body, omega_cage, y, n):
    """Add force and moment of the pockets to the rollers, and fill the reactions in the loads on the cage."""
    f_x, f_y, f_z = lay.roller_load(lay.F_X_C), lay.roller_load(lay.F_Y_C), lay.roller_load(lay.F_Z_C)
    m_x, m_y, m_z = lay.roller_load(lay.M_X_C), lay.roller_load(lay.M_Y_C), lay.roller_load(lay.M_C)
    for j in range(n):
        F, M, d = pocket_load(cage, model, body, omega_cage, y, j)
        y[lay.Q_P + j] = y[lay.POCKET_FORCE_W + j]
        y[lay.FORCE_R + j] += F[0]
        y[lay.FORCE_T + j] += F[1]
        y[lay.FORCE_Z + j] += F[2]
        y[lay.MOMENT_R + j] += M[0]
        y[lay.MOMENT_T + j] += M[1]
        y[lay.MOMENT_Z + j] += M[2]
        c = y[lay.COS_POCKET + j] * y[lay.COS_EPS + j] - y[lay.SIN_POCKET + j] * y[lay.SIN_EPS + j]
        s = y[lay.SIN_POCKET + j] * y[lay.COS_EPS + j] + y[lay.COS_POCKET + j] * y[lay.SIN_EPS + j]
        N = combine(1.0, M, 1.0, cross(d, F))  # moment about the cage's centre
        y[f_x + j], y[f_y + j], y[f_z + j] = -F[0] * c + F[1] * s, -F[0] * s - F[1] * c, -F[2]
        y[m_x + j], y[m_y + j], y[m_z + j] = -N[0] * c + N[1] * s, -N[0] * s - N[1] * c, -N[2]
