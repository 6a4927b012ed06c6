"""Forces on a roller of ``planar`` between its races: slip, friction, drag, weight, pocket, and its loads on the
rings."""

from math import sqrt

from bearingsim.core import layout as lay
from bearingsim.core.jit import inlined
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.friction.lag import lagged_friction
from bearingsim.core.parts.cage import orbit_drag, pocket_force

SLIP_OFFSET = 1e-12  # m/s, added to the slip so that friction/slip stays finite at zero slip


@inlined
def tangential_forces(model, common, normal_slope_o, normal_slope_i, y, j):
    """Compute slip, friction, drag and pocket force of roller ``j``.

    Fills FORCE_R, FORCE_T, TORQUE and the roller's loads on the rings.
    normal_slope_o, normal_slope_i: tangent of the angle between the contacts' normals and n, nonzero at a defect.

    Equation (P5) of docs/planar.md, over a defect (P6); friction with the lag of a step (P9).
    """
    b, friction, drag = model.bearing, model.friction, model.drag
    R_w, per_m, per_spin = b.R_w, 1.0 / b.m_r, b.R_w * b.R_w / b.I_r
    along_lag, across_lag = model.lag * (per_m + per_spin), model.lag * (per_m - per_spin)
    c, s = y[lay.COS + j], y[lay.SIN + j]
    mask = b.m_r * y[lay.INVERSE_MASS + j]  # 1, and 0 in a padded lane
    beta_v = common.spin + y[lay.SPIN_V + j]
    theta_v = common.omega_cage + y[lay.EPS_V + j]
    u = R_w * abs(theta_v - beta_v)  # rolling speed: of the surface relative to the orbiting contact

    arm_o, arm_i = R_w - 0.5 * y[lay.DELTA_O + j], R_w - 0.5 * y[lay.DELTA_I + j]
    cos_o = 1.0 / sqrt(1.0 + normal_slope_o * normal_slope_o)
    cos_i = 1.0 / sqrt(1.0 + normal_slope_i * normal_slope_i)
    sin_o, sin_i = normal_slope_o * cos_o, normal_slope_i * cos_i
    ring_arm_o, ring_arm_i = y[lay.RHO_O + j] * cos_o + arm_o, y[lay.RHO_I + j] * cos_i - arm_i
    s_o = (
        y[lay.TANGENTIAL_V_O + j] * cos_o
        + y[lay.RHO_V_O + j] * sin_o
        + beta_v * arm_o
        - common.omega_o * ring_arm_o
    )
    s_i = (
        y[lay.TANGENTIAL_V_I + j] * cos_i
        - y[lay.RHO_V_I + j] * sin_i
        - beta_v * arm_i
        - common.omega_i * ring_arm_i
    )
    y[lay.SLIP_O + j], y[lay.SLIP_I + j] = s_o, s_i
    s_o += SLIP_OFFSET if s_o > 0.0 else -SLIP_OFFSET
    s_i += SLIP_OFFSET if s_i > 0.0 else -SLIP_OFFSET
    inverse = 1.0 / (s_o * s_i)
    k_o = mu(friction, s_o, u) * y[lay.Q_O + j] * s_i * inverse
    k_i = mu(friction, s_i, u) * y[lay.Q_I + j] * s_o * inverse
    f_o, f_i = lagged_friction(k_o, k_i, s_o, s_i, along_lag, across_lag)

    along_n, across_n = -y[lay.Q_O + j] - f_o * sin_o, y[lay.DEFECT_FORCE_O + j] - f_o * cos_o
    o_r = along_n * y[lay.NORMAL_O_R + j] - across_n * y[lay.NORMAL_O_T + j]
    o_t = along_n * y[lay.NORMAL_O_T + j] + across_n * y[lay.NORMAL_O_R + j]
    along_n, across_n = y[lay.Q_I + j] + f_i * sin_i, y[lay.DEFECT_FORCE_I + j] - f_i * cos_i
    i_r = along_n * y[lay.NORMAL_I_R + j] - across_n * y[lay.NORMAL_I_T + j]
    i_t = along_n * y[lay.NORMAL_I_T + j] + across_n * y[lay.NORMAL_I_R + j]
    y[lay.FRICTION_O + j], y[lay.FRICTION_I + j] = f_o, f_i

    weight, r = model.gravity * b.m_r, 0.5 * (b.R_o + b.R_i) + y[lay.RADIAL + j]
    y[lay.FORCE_R + j] = o_r + i_r + weight * c
    y[lay.FORCE_T + j] = o_t + i_t - weight * s + orbit_drag(drag, theta_v * r)
    y[lay.TORQUE + j] = y[lay.DEFECT_TORQUE + j] + f_i * arm_i - f_o * arm_o
    y[lay.roller_load(lay.F_X) + j] = -o_r * c + o_t * s
    y[lay.roller_load(lay.F_Y) + j] = -o_r * s - o_t * c
    y[lay.roller_load(lay.M_RING) + j] = mask * f_o * ring_arm_o
    y[lay.roller_load(lay.F_X_I) + j] = -i_r * c + i_t * s
    y[lay.roller_load(lay.F_Y_I) + j] = -i_r * s - i_t * c
    pocket_force(model.cage, model, common, y, j)
