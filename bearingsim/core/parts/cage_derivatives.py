"""Analytic derivatives of the forces of ``parts/cage.py`` between cage, rollers and rings."""

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
    radial_stop,
)

# rows of a roller in its pocket: position and velocity relative to the cage's centre, along the pocket's
# directions; side of the nearer wall (1 or -1); tangent stiffness and damping of the wall and of the stop; mu, and
# its derivative with respect to slip times the force; force on the roller along the pocket's directions
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
def cage_mobility(cage: Any) -> tuple[float, float]:
    """Return the inverse of the cage's moment of inertia (1/(kg m^2)) and that of its mass (1/kg), each 0 where
    the motion is prescribed."""


@generic
def centre_mobility(guide: Any, m: float) -> float:
    """Return the inverse (1/kg) of the mass ``m`` (kg) of a cage, 0 if its centre is fixed."""


@centre_mobility.register(Centred)
def _centre_mobility_fixed(guide, m):
    return 0.0


@centre_mobility.register(RollerGuided)
def _centre_mobility_rollers(guide, m):
    return 1.0 / m


@centre_mobility.register(RingGuided)
def _centre_mobility_ring(guide, m):
    return 1.0 / m


@cage_mobility.register(KinematicCage)
def _cage_mobility_kinematic(cage):
    return 0.0, 0.0


@cage_mobility.register(FreeCage)
def _cage_mobility_free(cage):
    return 1.0 / cage.inertia, centre_mobility(cage.guide, cage.m)


# Pockets


@generic
def pocket_derivatives(cage: Any, model: Any, omega_cage: float, spin: float, y: Any, n: int) -> None:
    """Fill the rows OFFSET_R to POCKET_FORCE_T for every roller's contact with its pocket."""


@pocket_derivatives.register(KinematicCage)
def _pocket_derivatives_kinematic(cage, model, omega_cage, spin, y, n):
    return None


@pocket_derivatives.register(FreeCage)
def _pocket_derivatives_free(cage, model, omega_cage, spin, y, n):
    b = model.bearing
    R_mean, R_w = 0.5 * (b.R_o + b.R_i), b.R_w
    d_x = y[lay.POSITION + lay.X_C]
    d_y = y[lay.POSITION + lay.Y_C]
    v_x = y[lay.VELOCITY + lay.X_C]
    v_y = y[lay.VELOCITY + lay.Y_C]
    for j in range(n):
        mask = b.m_r * y[lay.INVERSE_MASS + j]
        pc, ps, ce, se = y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
        r, v = R_mean + y[lay.RADIAL + j], y[lay.RADIAL_V + j]
        w = r * (omega_cage + y[lay.EPS_V + j])
        e, rho = r * se + d_x * ps - d_y * pc, r * ce - d_x * pc - d_y * ps
        v_r, v_t = v * ce - w * se - v_x * pc - v_y * ps, v * se + w * ce + v_x * ps - v_y * pc
        side = 1.0 if e > 0.0 else -1.0
        depth, rate = abs(e) - cage.play, side * (v_t - omega_cage * rho)
        N, (K, C) = normal_force(cage.pocket, depth, rate), derivatives(cage.pocket, depth, rate)
        slip = v_r - side * R_w * (spin + y[lay.SPIN_V + j]) + omega_cage * (e + side * R_w)
        mu_v, _ = mu_derivative(cage.friction, slip, R_w * abs(spin))
        mu_value, offset, offset_v = mu(cage.friction, slip, R_w * abs(spin)), rho - R_mean, v_r + omega_cage * e
        stop_d, stop_v = radial_stop_derivatives(cage.guide, offset, offset_v)
        y[OFFSET_R + j] = rho
        y[OFFSET_T + j] = e
        y[OFFSET_V_R + j] = v_r
        y[OFFSET_V_T + j] = v_t
        y[WALL_SIDE + j] = side
        y[WALL_K + j], y[WALL_C + j], y[MU + j], y[MU_V + j] = mask * K, mask * C, mu_value, mask * N * mu_v
        y[STOP_K + j], y[STOP_C + j] = mask * stop_d, mask * stop_v
        y[POCKET_FORCE_R + j] = mask * (radial_stop(cage.guide, offset, offset_v) - mu_value * N)
        y[POCKET_FORCE_T + j] = -mask * side * N


@generic
def pocket_change(
    cage: Any, R_w: float, omega_cage: float, roll_v: float, turn: float, turn_v: float, y, n
) -> None:
    """Add the changes of the pocket forces to the rows D_FORCE, for the changes in the rows D_POSITION and
    D_VELOCITY and for rotation of rollers and cage.

    roll_v: change of the rollers' spin (rad/s); turn, turn_v: of the cage's angle (rad) and speed (rad/s).
    """


@pocket_change.register(KinematicCage)
def _pocket_change_kinematic(cage, R_w, omega_cage, roll_v, turn, turn_v, y, n):
    return None


@pocket_change.register(FreeCage)
def _pocket_change_free(cage, R_w, omega_cage, roll_v, turn, turn_v, y, n):
    for j in range(n):
        pc = y[lay.COS_POCKET + j]
        ps = y[lay.SIN_POCKET + j]
        ce = y[lay.COS_EPS + j]
        se = y[lay.SIN_EPS + j]
        side = y[WALL_SIDE + j]
        rho, e, on_r, on_t = y[OFFSET_R + j], y[OFFSET_T + j], y[POCKET_FORCE_R + j], y[POCKET_FORCE_T + j]
        p_r = ce * y[lay.D_POSITION_R + j] - se * y[lay.D_POSITION_T + j] + e * turn
        p_t = se * y[lay.D_POSITION_R + j] + ce * y[lay.D_POSITION_T + j] - rho * turn
        w_r = ce * y[lay.D_VELOCITY_R + j] - se * y[lay.D_VELOCITY_T + j] + y[OFFSET_V_T + j] * turn
        w_t = se * y[lay.D_VELOCITY_R + j] + ce * y[lay.D_VELOCITY_T + j] - y[OFFSET_V_R + j] * turn
        closing = side * (w_t - omega_cage * p_r - rho * turn_v)
        N = y[WALL_K + j] * (side * p_t) + y[WALL_C + j] * closing
        slip = w_r + omega_cage * p_t + (e + side * R_w) * turn_v - side * R_w * roll_v
        f = y[MU + j] * N + y[MU_V + j] * slip
        stop = y[STOP_K + j] * p_r + y[STOP_C + j] * (w_r + omega_cage * p_t + e * turn_v)
        f_r, f_t = stop - f, -side * N
        y[lay.D_TORQUE + j] += side * R_w * f
        torque = e * f_r + p_t * on_r - rho * f_t - p_r * on_t - side * R_w * f
        y[lay.D_FORCE_SHARED + lay.PHI_C * lay.ROW + j] += torque
        f_r, f_t = f_r - on_t * turn, f_t + on_r * turn  # the pocket's directions rotate, too
        y[lay.D_FORCE_R + j] += ce * f_r + se * f_t
        y[lay.D_FORCE_T + j] += ce * f_t - se * f_r
        y[lay.D_FORCE_SHARED + lay.X_C * lay.ROW + j] += ps * f_t - pc * f_r
        y[lay.D_FORCE_SHARED + lay.Y_C * lay.ROW + j] -= ps * f_r + pc * f_t


# Guides


@jit
def add_to_border(matrix, k, m, value, y):
    """Add the acceleration of shared coordinate ``k`` under a force (N) or torque (N m) to column ``m``."""
    y[lay.corner_block(matrix, k, m)] += y[lay.MOBILITY_SHARED + k] * value


@generic
def guide_change(cage: Any, omega_cage: float, omega_i: float, y: Any) -> None:
    """Add the derivatives of the forces between cage and guiding ring to the corners of both arrow matrices."""


@generic
def land_change(guide: Any, omega_cage: float, omega_i: float, y: Any) -> None:
    """Add the derivatives of ``land_contact`` to the corners of both arrow matrices."""


@land_change.register(Centred)
def _land_change_centred(guide, omega_cage, omega_i, y):
    return None


@land_change.register(RollerGuided)
def _land_change_rollers(guide, omega_cage, omega_i, y):
    return None


@jit
def land_column(guide, omega_cage, omega_ring, matrix, m, p, w, cage_v, ring_v, y):
    """Add one column of ``land_change``.

    p, w: changes of the cage's position (m) and velocity (m/s) relative to the ring, pairs along e_0 and e_90;
    cage_v, ring_v: changes of the speeds of cage and ring (rad/s).
    """
    o, i = guide.outer, 1.0 - guide.outer
    d_x = y[lay.POSITION + lay.X_C] - o * y[lay.POSITION + lay.X] - i * y[lay.POSITION + lay.X_I]
    d_y = y[lay.POSITION + lay.Y_C] - o * y[lay.POSITION + lay.Y] - i * y[lay.POSITION + lay.Y_I]
    v_x = y[lay.VELOCITY + lay.X_C] - o * y[lay.VELOCITY + lay.X] - i * y[lay.VELOCITY + lay.X_I]
    v_y = y[lay.VELOCITY + lay.Y_C] - o * y[lay.VELOCITY + lay.Y] - i * y[lay.VELOCITY + lay.Y_I]
    distance = max(hypot(d_x, d_y), 1e-30)
    c, s = d_x / distance, d_y / distance
    rate, v_t = v_x * c + v_y * s, v_y * c - v_x * s
    cage_arm = (o - i) * guide.land
    ring_arm = cage_arm + distance
    slip, rolling = v_t + cage_arm * omega_cage - ring_arm * omega_ring, guide.land * abs(omega_cage)
    N, (K, C) = (
        normal_force(guide.law, distance - guide.play, rate),
        derivatives(guide.law, distance - guide.play, rate),
    )
    mu_value, (mu_v, mu_u) = (mu(guide.friction, slip, rolling), mu_derivative(guide.friction, slip, rolling))
    f = mu_value * N

    distance_1, angle_1 = p[0] * c + p[1] * s, (p[1] * c - p[0] * s) / distance
    N_1 = K * distance_1 + C * (w[0] * c + w[1] * s + v_t * angle_1)
    slip_1 = w[1] * c - w[0] * s - rate * angle_1 + cage_arm * cage_v - ring_arm * ring_v - distance_1 * omega_ring
    rolling_1 = guide.land * (cage_v if omega_cage > 0.0 else -cage_v)
    f_1 = mu_value * N_1 + N * (mu_v * slip_1 + mu_u * rolling_1)
    f_along, f_across = -N_1 + f * angle_1, -f_1 - N * angle_1
    f_x, f_y = f_along * c - f_across * s, f_along * s + f_across * c
    add_to_border(matrix, lay.X_C, m, f_x, y)
    add_to_border(matrix, lay.Y_C, m, f_y, y)
    add_to_border(matrix, lay.PHI_C, m, -cage_arm * f_1, y)
    add_to_border(matrix, lay.X, m, -o * f_x, y)
    add_to_border(matrix, lay.Y, m, -o * f_y, y)
    add_to_border(matrix, lay.PSI, m, o * (ring_arm * f_1 + distance_1 * f), y)
    add_to_border(matrix, lay.X_I, m, -i * f_x, y)
    add_to_border(matrix, lay.Y_I, m, -i * f_y, y)


@land_change.register(RingGuided)
def _land_change_ring(guide, omega_cage, omega_i, y):
    o, i = guide.outer, 1.0 - guide.outer
    d_x = y[lay.POSITION + lay.X_C] - o * y[lay.POSITION + lay.X] - i * y[lay.POSITION + lay.X_I]
    d_y = y[lay.POSITION + lay.Y_C] - o * y[lay.POSITION + lay.Y] - i * y[lay.POSITION + lay.Y_I]
    if hypot(d_x, d_y) <= guide.play:
        return
    omega_ring, zero = i * omega_i + o * y[lay.VELOCITY + lay.PSI], (0.0, 0.0)
    for m, sign in ((lay.X_C, 1.0), (lay.X, -o), (lay.X_I, -i)):
        for axis in range(2):
            direction = (sign * (1.0 - axis), sign * axis)
            land_column(
                guide, omega_cage, omega_ring, lay.POSITION_JACOBIAN, m + axis, direction, zero, 0.0, 0.0, y
            )
            land_column(
                guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, m + axis, zero, direction, 0.0, 0.0, y
            )
    land_column(guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, lay.PHI_C, zero, zero, 1.0, 0.0, y)
    land_column(guide, omega_cage, omega_ring, lay.VELOCITY_JACOBIAN, lay.PSI, zero, zero, 0.0, o, y)


@guide_change.register(KinematicCage)
def _guide_change_kinematic(cage, omega_cage, omega_i, y):
    return None


@guide_change.register(FreeCage)
def _guide_change_free(cage, omega_cage, omega_i, y):
    land_change(cage.guide, omega_cage, omega_i, y)
