"""Analytic derivatives of the forces of ``parts/cage.py`` between cage, rollers and rings.

A name with the prefix ``d_`` is the change of a quantity per unit of one coordinate or of its rate
(``models/planar_derivatives.py``).
"""

from math import hypot
from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import derivatives, normal_force
from bearingsim.core.laws.friction.interface import mu, mu_derivative
from bearingsim.core.parts.cage import (
    Centred,
    FreeCage,
    KinematicCage,
    NoDrag,
    OilDrag,
    RingGuided,
    RollerGuided,
    cage_motion_in_land,
    radial_stop,
)

# rows of a roller in its pocket: position and velocity relative to the cage's centre, along the pocket's e_r and
# e_theta; side of the nearer wall (1 or -1); tangent stiffness and damping of the wall; derivatives of the force
# of ``radial_stop`` with respect to position and velocity; mu, and its derivative with respect to slip times the
# wall's force; force on the roller along the pocket's e_r and e_theta
(
    OFFSET_R,
    OFFSET_T,
    OFFSET_V_R,
    OFFSET_V_T,
    WALL_SIDE,
    WALL_K,
    WALL_C,
    STOP_K,
    STOP_C,
    MU,
    MU_V,
    POCKET_FORCE_R,
    POCKET_FORCE_T,
) = lay.rows(
    lay.POCKET_CONTACT, "m, m, m/s, m/s, 1, N/m, N s/m, N/m, N s/m, 1, N s/m, N, N", "linearise", "linearise"
)


@generic
def orbit_drag_derivative(drag: Any, speed: float) -> float:
    """Return the derivative of ``orbit_drag`` with respect to the speed (N s/m)."""


@generic
def land_drag_derivative(drag: Any) -> float:
    """Return the derivative of ``land_drag`` with respect to the cage's speed (N m s)."""


@orbit_drag_derivative.register(NoDrag)
def _orbit_drag_derivative_none(drag, speed):
    return 0.0


@land_drag_derivative.register(NoDrag)
def _land_drag_derivative_none(drag):
    return 0.0


@orbit_drag_derivative.register(OilDrag)
def _orbit_drag_derivative_oil(drag, speed):
    return -2.0 * drag.roller * abs(speed)


@land_drag_derivative.register(OilDrag)
def _land_drag_derivative_oil(drag):
    return -drag.land


@generic
def radial_stop_derivatives(guide: Any, offset: float, speed: float) -> tuple[float, float]:
    """Return the derivatives of ``radial_stop`` with respect to the displacement (N/m) and its rate (N s/m)."""


@radial_stop_derivatives.register(Centred)
def _radial_stop_derivatives_centred(guide, offset, speed):
    return 0.0, 0.0


@radial_stop_derivatives.register(RingGuided)
def _radial_stop_derivatives_ring(guide, offset, speed):
    return 0.0, 0.0


@radial_stop_derivatives.register(RollerGuided)
def _radial_stop_derivatives_rollers(guide, offset, speed):
    K, C = derivatives(guide.law, abs(offset) - guide.play, speed if offset > 0.0 else -speed)
    return -K, -C


@generic
def cage_accelerances(cage: Any) -> tuple[float, float]:
    """Return the cage's inverse moment of inertia (1/(kg m^2)) and mass (1/kg), each 0 if prescribed."""


@generic
def centre_accelerance(guide: Any, m: float) -> float:
    """Return the inverse mass 1/m (1/kg) of the centre of a cage of mass ``m`` (kg), 0 if the centre is fixed."""


@centre_accelerance.register(Centred)
def _centre_accelerance_fixed(guide, m):
    return 0.0


@centre_accelerance.register(RollerGuided)
def _centre_accelerance_rollers(guide, m):
    return 1.0 / m


@centre_accelerance.register(RingGuided)
def _centre_accelerance_ring(guide, m):
    return 1.0 / m


@cage_accelerances.register(KinematicCage)
def _cage_accelerances_kinematic(cage):
    return 0.0, 0.0


@cage_accelerances.register(FreeCage)
def _cage_accelerances_free(cage):
    return 1.0 / cage.inertia, centre_accelerance(cage.guide, cage.m)


# Pockets


@generic
def fill_pocket_derivatives(cage: Any, model: Any, omega_cage: float, spin: float, y: Any, n: int) -> None:
    """Fill the rows OFFSET_R to POCKET_FORCE_T for every roller's contact with its pocket.

    omega_cage, spin: speed of the cage, and nominal spin of a roller (rad/s).
    """


@fill_pocket_derivatives.register(KinematicCage)
def _fill_pocket_derivatives_kinematic(cage, model, omega_cage, spin, y, n):
    return None


@fill_pocket_derivatives.register(FreeCage)
def _fill_pocket_derivatives_free(cage, model, omega_cage, spin, y, n):
    b = model.bearing
    R_mean, R_w = 0.5 * (b.R_o + b.R_i), b.R_w
    x_c = y[lay.POSITION + lay.X_C]
    y_c = y[lay.POSITION + lay.Y_C]
    v_x = y[lay.VELOCITY + lay.X_C]
    v_y = y[lay.VELOCITY + lay.Y_C]
    for j in range(n):
        mask = b.m_r * y[lay.INVERSE_MASS + j]  # 1, and 0 in a padded lane
        pc, ps, ce, se = y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
        r, v = R_mean + y[lay.RADIAL + j], y[lay.RADIAL_V + j]
        w = r * (omega_cage + y[lay.EPS_V + j])
        e, rho = r * se + x_c * ps - y_c * pc, r * ce - x_c * pc - y_c * ps
        v_r, v_t = v * ce - w * se - v_x * pc - v_y * ps, v * se + w * ce + v_x * ps - v_y * pc
        side = 1.0 if e > 0.0 else -1.0
        depth, rate = abs(e) - cage.play, side * (v_t - omega_cage * rho)
        N, (K, C) = normal_force(cage.pocket, depth, rate), derivatives(cage.pocket, depth, rate)
        slip = v_r - side * R_w * (spin + y[lay.SPIN_V + j]) + omega_cage * (e + side * R_w)
        mu_v, _ = mu_derivative(cage.friction, slip, R_w * abs(spin))
        mu_value, offset, offset_v = mu(cage.friction, slip, R_w * abs(spin)), rho - R_mean, v_r + omega_cage * e
        stop_k, stop_c = radial_stop_derivatives(cage.guide, offset, offset_v)
        y[OFFSET_R + j] = rho
        y[OFFSET_T + j] = e
        y[OFFSET_V_R + j] = v_r
        y[OFFSET_V_T + j] = v_t
        y[WALL_SIDE + j] = side
        y[WALL_K + j], y[WALL_C + j], y[MU + j], y[MU_V + j] = mask * K, mask * C, mu_value, mask * N * mu_v
        y[STOP_K + j], y[STOP_C + j] = mask * stop_k, mask * stop_c
        y[POCKET_FORCE_R + j] = mask * (radial_stop(cage.guide, offset, offset_v) - mu_value * N)
        y[POCKET_FORCE_T + j] = -mask * side * N


@generic
def add_pocket_changes(
    cage: Any, R_w: float, omega_cage: float, d_spin: float, d_cage_angle: float, d_cage_omega: float, y, n
) -> None:
    """Add the directional derivatives of the pocket forces to the rows D_FORCE, along the rows D_POSITION and
    D_VELOCITY and the rotations of rollers and cage.

    d_spin: change of the rollers' spin (rad/s); d_cage_angle, d_cage_omega: changes of the cage's angle (rad) and
    speed (rad/s).
    """


@add_pocket_changes.register(KinematicCage)
def _add_pocket_changes_kinematic(cage, R_w, omega_cage, d_spin, d_cage_angle, d_cage_omega, y, n):
    return None


@add_pocket_changes.register(FreeCage)
def _add_pocket_changes_free(cage, R_w, omega_cage, d_spin, d_cage_angle, d_cage_omega, y, n):
    for j in range(n):
        pc = y[lay.COS_POCKET + j]
        ps = y[lay.SIN_POCKET + j]
        ce = y[lay.COS_EPS + j]
        se = y[lay.SIN_EPS + j]
        side = y[WALL_SIDE + j]
        rho, e, force_r, force_t = y[OFFSET_R + j], y[OFFSET_T + j], y[POCKET_FORCE_R + j], y[POCKET_FORCE_T + j]
        d_rho = ce * y[lay.D_POSITION_R + j] - se * y[lay.D_POSITION_T + j] + e * d_cage_angle
        d_e = se * y[lay.D_POSITION_R + j] + ce * y[lay.D_POSITION_T + j] - rho * d_cage_angle
        d_v_r = ce * y[lay.D_VELOCITY_R + j] - se * y[lay.D_VELOCITY_T + j] + y[OFFSET_V_T + j] * d_cage_angle
        d_v_t = se * y[lay.D_VELOCITY_R + j] + ce * y[lay.D_VELOCITY_T + j] - y[OFFSET_V_R + j] * d_cage_angle
        d_rate = side * (d_v_t - omega_cage * d_rho - rho * d_cage_omega)
        d_N = y[WALL_K + j] * (side * d_e) + y[WALL_C + j] * d_rate
        d_slip = d_v_r + omega_cage * d_e + (e + side * R_w) * d_cage_omega - side * R_w * d_spin
        d_f = y[MU + j] * d_N + y[MU_V + j] * d_slip
        d_stop = y[STOP_K + j] * d_rho + y[STOP_C + j] * (d_v_r + omega_cage * d_e + e * d_cage_omega)
        d_force_r, d_force_t = d_stop - d_f, -side * d_N
        y[lay.D_TORQUE + j] += side * R_w * d_f
        d_torque = e * d_force_r + d_e * force_r - rho * d_force_t - d_rho * force_t - side * R_w * d_f
        y[lay.D_FORCE_SHARED + lay.PHI_C * lay.ROW + j] += d_torque
        # e_r and e_theta of the pocket rotate with the cage
        d_force_r, d_force_t = d_force_r - force_t * d_cage_angle, d_force_t + force_r * d_cage_angle
        y[lay.D_FORCE_R + j] += ce * d_force_r + se * d_force_t
        y[lay.D_FORCE_T + j] += ce * d_force_t - se * d_force_r
        y[lay.D_FORCE_SHARED + lay.X_C * lay.ROW + j] += ps * d_force_t - pc * d_force_r
        y[lay.D_FORCE_SHARED + lay.Y_C * lay.ROW + j] -= ps * d_force_r + pc * d_force_t


# Guidance by a ring


@jit
def add_to_corner(matrix, k, m, d_force, y):
    """Add to entry (``k``, ``m``) of the corner block the derivative of the acceleration of shared coordinate
    ``k``.

    d_force: derivative of the force (N) or torque (N m) on coordinate k with respect to coordinate m.
    """
    y[lay.corner_block(matrix, k, m)] += y[lay.ACCELERANCE_SHARED + k] * d_force


@generic
def add_guide_derivatives(cage: Any, omega_cage: float, omega_i: float, y: Any) -> None:
    """Add the derivatives of the forces between cage and guiding ring to the corner blocks of both arrow
    matrices."""


@generic
def add_land_derivatives(guide: Any, omega_cage: float, omega_i: float, y: Any) -> None:
    """Add the derivatives of ``add_land_contact`` to the corner blocks of both arrow matrices."""


@add_land_derivatives.register(Centred)
def _add_land_derivatives_centred(guide, omega_cage, omega_i, y):
    return None


@add_land_derivatives.register(RollerGuided)
def _add_land_derivatives_rollers(guide, omega_cage, omega_i, y):
    return None


@jit
def add_land_column(
    guide, omega_cage, omega_ring, matrix, m, d_position, d_velocity, d_cage_omega, d_ring_omega, y
):
    """Add one column of ``add_land_derivatives``.

    d_position, d_velocity: changes of the cage's position (m) and velocity (m/s) relative to the ring, pairs along
    e_0 and e_90; d_cage_omega, d_ring_omega: changes of the speeds of cage and ring (rad/s).
    """
    outer, inner = guide.outer, 1.0 - guide.outer  # 1 for the guiding ring, 0 for the other
    e_x, e_y, v_x, v_y = cage_motion_in_land(guide, y)
    eccentricity = max(hypot(e_x, e_y), 1e-30)
    c, s = e_x / eccentricity, e_y / eccentricity
    rate, v_t = v_x * c + v_y * s, v_y * c - v_x * s
    cage_arm = (outer - inner) * guide.land
    ring_arm = cage_arm + eccentricity
    slip, rolling = v_t + cage_arm * omega_cage - ring_arm * omega_ring, guide.land * abs(omega_cage)
    N, (K, C) = (
        normal_force(guide.law, eccentricity - guide.play, rate),
        derivatives(guide.law, eccentricity - guide.play, rate),
    )
    mu_value, (mu_v, mu_u) = (mu(guide.friction, slip, rolling), mu_derivative(guide.friction, slip, rolling))
    f = mu_value * N

    d_eccentricity = d_position[0] * c + d_position[1] * s
    d_angle = (d_position[1] * c - d_position[0] * s) / eccentricity
    d_N = K * d_eccentricity + C * (d_velocity[0] * c + d_velocity[1] * s + v_t * d_angle)
    d_slip = d_velocity[1] * c - d_velocity[0] * s - rate * d_angle
    d_slip = d_slip + cage_arm * d_cage_omega - ring_arm * d_ring_omega - d_eccentricity * omega_ring
    d_rolling = guide.land * (d_cage_omega if omega_cage > 0.0 else -d_cage_omega)
    d_f = mu_value * d_N + N * (mu_v * d_slip + mu_u * d_rolling)
    d_f_n, d_f_t = -d_N + f * d_angle, -d_f - N * d_angle
    d_f_x, d_f_y = d_f_n * c - d_f_t * s, d_f_n * s + d_f_t * c
    add_to_corner(matrix, lay.X_C, m, d_f_x, y)
    add_to_corner(matrix, lay.Y_C, m, d_f_y, y)
    add_to_corner(matrix, lay.PHI_C, m, -cage_arm * d_f, y)
    add_to_corner(matrix, lay.X, m, -outer * d_f_x, y)
    add_to_corner(matrix, lay.Y, m, -outer * d_f_y, y)
    add_to_corner(matrix, lay.PSI, m, outer * (ring_arm * d_f + d_eccentricity * f), y)
    add_to_corner(matrix, lay.X_I, m, -inner * d_f_x, y)
    add_to_corner(matrix, lay.Y_I, m, -inner * d_f_y, y)


@add_land_derivatives.register(RingGuided)
def _add_land_derivatives_ring(guide, omega_cage, omega_i, y):
    outer, inner = guide.outer, 1.0 - guide.outer  # 1 for the guiding ring, 0 for the other
    e_x = y[lay.POSITION + lay.X_C] - outer * y[lay.POSITION + lay.X] - inner * y[lay.POSITION + lay.X_I]
    e_y = y[lay.POSITION + lay.Y_C] - outer * y[lay.POSITION + lay.Y] - inner * y[lay.POSITION + lay.Y_I]
    if hypot(e_x, e_y) <= guide.play:
        return
    omega_ring, zero = inner * omega_i + outer * y[lay.VELOCITY + lay.PSI], (0.0, 0.0)
    for m, sign in ((lay.X_C, 1.0), (lay.X, -outer), (lay.X_I, -inner)):
        for axis in range(2):
            direction = (sign * (1.0 - axis), sign * axis)
            add_land_column(
                guide, omega_cage, omega_ring, lay.POSITION_JACOBIAN, m + axis, direction, zero, 0.0, 0.0, y
            )
            add_land_column(
                guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, m + axis, zero, direction, 0.0, 0.0, y
            )
    add_land_column(guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, lay.PHI_C, zero, zero, 1.0, 0.0, y)
    add_land_column(guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, lay.PSI, zero, zero, 0.0, outer, y)


@add_guide_derivatives.register(KinematicCage)
def _add_guide_derivatives_kinematic(cage, omega_cage, omega_i, y):
    return None


@add_guide_derivatives.register(FreeCage)
def _add_guide_derivatives_free(cage, omega_cage, omega_i, y):
    add_land_derivatives(cage.guide, omega_cage, omega_i, y)
