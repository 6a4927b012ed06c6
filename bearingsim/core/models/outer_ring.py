"""Functions common to models with a moving ring: angles of the rollers, and the ring's equation of motion.

m_o u'' = -F e_0 - F_across e_90 - k_b (u - u_0) - c_b u' + sum_j Q_o,j e_r(theta_j)
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.plane import cos_sin
from bearingsim.core.jit import inlined, jit
from bearingsim.core.parameters import kinematic_angles, lanes
from bearingsim.core.sums import lane_sum, sum_loads


class RingMotion(NamedTuple):
    """Quantities common to all rollers, for a kinematic cage and a moving ring.

    C, S: cosine and sine of the first roller's angle; u_x, u_y: the ring's centre (m); w_x, w_y: its velocity
    relative to the rotating cage, u' - omega_c x u, so that w.e_r = d(u.e_r)/dt (m/s); external_x, external_y:
    force on the ring (N) except that of the rollers.
    """

    C: float
    S: float
    u_x: float
    u_y: float
    w_x: float
    w_y: float
    external_x: float
    external_y: float


@inlined
def ring_motion(model, t, y):
    """Return ``RingMotion`` at time ``t`` (s)."""
    theta_c, omega_c = kinematic_angles(model.bearing, t)[0], model.bearing.omega_c
    u_x, u_y = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
    w_x, w_y = y[lay.VELOCITY + lay.X] + omega_c * u_y, y[lay.VELOCITY + lay.Y] - omega_c * u_x
    external_x, external_y = dynamic_force(model.support, 0.0, 0.0, y)
    C, S = cos_sin(theta_c)
    return RingMotion(C, S, u_x, u_y, w_x, w_y, external_x, external_y)


@inlined
def fill_roller_angle(common, y, j):
    """Fill the rows COS and SIN of roller ``j``, the cosine and sine of its angle, and return both."""
    c = common.C * y[lay.COS_0 + j] - common.S * y[lay.SIN_0 + j]
    s = common.S * y[lay.COS_0 + j] + common.C * y[lay.SIN_0 + j]
    y[lay.COS + j], y[lay.SIN + j] = c, s
    return c, s


@inlined
def load_ring(y, j):
    """Fill the load of roller ``j`` on the ring, along e_r."""
    y[lay.roller_load(lay.F_X) + j] = y[lay.Q_O + j] * y[lay.COS + j]
    y[lay.roller_load(lay.F_Y) + j] = y[lay.Q_O + j] * y[lay.SIN + j]


@inlined
def static_force(support, f_x, f_y, y):
    """Return ``f_x``, ``f_y`` (N) plus the applied load and the spring force of the bracket: the force on a ring
    at rest."""
    f_x = f_x - support.F - support.k_b * (y[lay.POSITION + lay.X] - support.x_0)
    f_y = f_y - support.F_across - support.k_b * (y[lay.POSITION + lay.Y] - support.y_0)
    return f_x, f_y


@inlined
def dynamic_force(support, f_x, f_y, y):
    """Return ``static_force`` plus the damping force of the bracket: the force (N) on a moving ring.

    Equation (M8) of docs/model.md, second line, without the rollers' forces.
    """
    f_x, f_y = static_force(support, f_x, f_y, y)
    return f_x - support.c_b * y[lay.VELOCITY + lay.X], f_y - support.c_b * y[lay.VELOCITY + lay.Y]


@inlined
def accelerate(m_o, f_x, f_y, y):
    """Write the ring's acceleration under the total force ``f_x``, ``f_y`` (N)."""
    y[lay.ACCELERATION + lay.X] = f_x / m_o
    y[lay.ACCELERATION + lay.Y] = f_y / m_o


@inlined
def accelerate_ring(model, common, y):
    """Fill the ring's acceleration under the loads that ``load_ring`` filled.

    Equation (M8) of docs/model.md, second line.
    """
    sum_loads(lay.F_X, lay.F_Y, y, lanes(model.bearing))
    accelerate(model.bearing.m_o, y[lay.F_X] + common.external_x, y[lay.F_Y] + common.external_y, y)


@jit
def accelerate_outer_ring(model, y):
    """Fill the ring's acceleration under the forces of the rollers and of the cage that it guides.

    The cells F_X and F_Y must contain the sums of these forces (N).
    """
    f_x, f_y = dynamic_force(model.support, y[lay.F_X], y[lay.F_Y], y)
    accelerate(model.bearing.m_o, f_x, f_y, y)


# addends of the stiffnesses (N/m) and dampings (N s/m) of the ring
K_XX, K_XY, K_YX, K_YY, C_XX, C_XY, C_YY = (lay.ADDENDS + n * lay.ROW for n in range(7))


@jit
def linearise_ring(model, K, C, y, n):
    """Fill the corner blocks: derivatives of the ring's acceleration with respect to its position and velocity.

    K, C: rows of the derivatives of Q_o (N/m, N s/m) with respect to delta = -u.e_r and its rate
    v = -(u' - omega_c x u).e_r, at fixed coordinates of the rollers.
    """
    support, per_mass, omega_c = model.support, 1.0 / model.bearing.m_o, model.bearing.omega_c
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        derivative_x, derivative_y = y[K + j] * c - y[C + j] * omega_c * s, y[K + j] * s + y[C + j] * omega_c * c
        y[K_XX + j], y[K_XY + j] = c * derivative_x, c * derivative_y
        y[K_YX + j], y[K_YY + j] = s * derivative_x, s * derivative_y
        y[C_XX + j], y[C_XY + j], y[C_YY + j] = y[C + j] * c * c, y[C + j] * c * s, y[C + j] * s * s
    k_xx, k_xy, k_yx, k_yy = lane_sum(K_XX, y, n), lane_sum(K_XY, y, n), lane_sum(K_YX, y, n), lane_sum(K_YY, y, n)
    c_xx, c_xy, c_yy = lane_sum(C_XX, y, n), lane_sum(C_XY, y, n), lane_sum(C_YY, y, n)
    y[lay.corner_block(lay.POSITION_JACOBIAN, lay.X, lay.X)] = -per_mass * (k_xx + support.k_b)
    y[lay.corner_block(lay.POSITION_JACOBIAN, lay.X, lay.Y)] = -per_mass * k_xy
    y[lay.corner_block(lay.POSITION_JACOBIAN, lay.Y, lay.X)] = -per_mass * k_yx
    y[lay.corner_block(lay.POSITION_JACOBIAN, lay.Y, lay.Y)] = -per_mass * (k_yy + support.k_b)
    y[lay.corner_block(lay.VELOCITY_JACOBIAN, lay.X, lay.X)] = -per_mass * (c_xx + support.c_b)
    y[lay.corner_block(lay.VELOCITY_JACOBIAN, lay.X, lay.Y)] = -per_mass * c_xy
    y[lay.corner_block(lay.VELOCITY_JACOBIAN, lay.Y, lay.X)] = -per_mass * c_xy
    y[lay.corner_block(lay.VELOCITY_JACOBIAN, lay.Y, lay.Y)] = -per_mass * (c_yy + support.c_b)
