"""Forces on a roller of ``planar``: contacts, friction, drag, weight and pocket; slip; reactions on the rings.

Rows of the buffer that are read: COS, SIN, and the contacts' DELTA_*, RHO_*, RHO_V_*, TANGENTIAL_V_*, Q_*,
NORMAL_*, DEFECT_FORCE_* and DEFECT_TORQUE. Rows that are written: SLIP_* (without ``SLIP_OFFSET``), FRICTION_*,
FORCE_R, FORCE_T, TORQUE, the roller's loads on the rings (F_X, F_Y, M_RING, F_X_I, F_Y_I), and those of
``add_pocket_force``.
"""

from math import sqrt

from bearingsim.core import layout as lay
from bearingsim.core.jit import inlined
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.friction.lag import lagged_friction
from bearingsim.core.parts.cage import add_pocket_force, orbit_drag

SLIP_OFFSET = 1e-12  # m/s, far below any resolved slip; keeps friction/slip finite at zero slip


@inlined
def compute_roller_forces(model, common, normal_slope_o, normal_slope_i, y, j):
    """Compute slip, friction, forces and torque of roller ``j``, and its reactions on the rings.

    common: ``planar.PlanarMotion``; normal_slope_o, normal_slope_i: tangent of the angle from the line of centres
    to the contact normal, 0 without a defect. Equations (P4), (P5), (P6) and (P9) of docs/planar.md.
    """
    bearing, friction, drag, R_w = model.bearing, model.friction, model.drag, model.bearing.R_w
    inverse_mass, inverse_spin_mass = 1.0 / bearing.m_r, R_w * R_w / bearing.I_r  # 1/kg
    a = model.lag * (inverse_mass + inverse_spin_mass)  # s/kg, in (P8)
    b = model.lag * (inverse_mass - inverse_spin_mass)
    c, s = y[lay.COS + j], y[lay.SIN + j]
    mask = bearing.m_r * y[lay.INVERSE_MASS + j]  # 0 in a padded lane, where c = s = 0 removes the other loads
    beta_v = common.spin + y[lay.SPIN_V + j]
    theta_v = common.omega_cage + y[lay.EPS_V + j]
    u = R_w * abs(theta_v - beta_v)  # rolling speed (m/s): mean speed of both surfaces relative to the contact

    arm_o, arm_i = R_w - 0.5 * y[lay.DELTA_O + j], R_w - 0.5 * y[lay.DELTA_I + j]
    cos_o = 1.0 / sqrt(1.0 + normal_slope_o * normal_slope_o)
    cos_i = 1.0 / sqrt(1.0 + normal_slope_i * normal_slope_i)
    sin_o, sin_i = normal_slope_o * cos_o, normal_slope_i * cos_i
    ring_arm_o, ring_arm_i = y[lay.RHO_O + j] * cos_o + arm_o, y[lay.RHO_I + j] * cos_i - arm_i
    slip_o = (
        y[lay.TANGENTIAL_V_O + j] * cos_o
        + y[lay.RHO_V_O + j] * sin_o
        + beta_v * arm_o
        - common.omega_o * ring_arm_o
    )
    slip_i = (
        y[lay.TANGENTIAL_V_I + j] * cos_i
        - y[lay.RHO_V_I + j] * sin_i
        - beta_v * arm_i
        - common.omega_i * ring_arm_i
    )
    y[lay.SLIP_O + j], y[lay.SLIP_I + j] = slip_o, slip_i
    slip_o += SLIP_OFFSET if slip_o > 0.0 else -SLIP_OFFSET
    slip_i += SLIP_OFFSET if slip_i > 0.0 else -SLIP_OFFSET
    inverse = 1.0 / (slip_o * slip_i)  # one division for both contacts
    # k_o, k_i: friction over slip (N s/m)
    k_o = mu(friction, slip_o, u) * y[lay.Q_O + j] * slip_i * inverse
    k_i = mu(friction, slip_i, u) * y[lay.Q_I + j] * slip_o * inverse
    f_o, f_i = lagged_friction(k_o, k_i, slip_o, slip_i, a, b)

    along_n, across_n = -y[lay.Q_O + j] - f_o * sin_o, y[lay.DEFECT_FORCE_O + j] - f_o * cos_o
    force_o_r = along_n * y[lay.NORMAL_O_R + j] - across_n * y[lay.NORMAL_O_T + j]
    force_o_t = along_n * y[lay.NORMAL_O_T + j] + across_n * y[lay.NORMAL_O_R + j]
    along_n, across_n = y[lay.Q_I + j] + f_i * sin_i, y[lay.DEFECT_FORCE_I + j] - f_i * cos_i
    force_i_r = along_n * y[lay.NORMAL_I_R + j] - across_n * y[lay.NORMAL_I_T + j]
    force_i_t = along_n * y[lay.NORMAL_I_T + j] + across_n * y[lay.NORMAL_I_R + j]
    y[lay.FRICTION_O + j], y[lay.FRICTION_I + j] = f_o, f_i

    weight, r = model.gravity * bearing.m_r, 0.5 * (bearing.R_o + bearing.R_i) + y[lay.RADIAL + j]
    y[lay.FORCE_R + j] = force_o_r + force_i_r + weight * c
    y[lay.FORCE_T + j] = force_o_t + force_i_t - weight * s + orbit_drag(drag, theta_v * r)
    y[lay.TORQUE + j] = y[lay.DEFECT_TORQUE + j] + f_i * arm_i - f_o * arm_o
    y[lay.roller_load(lay.F_X) + j] = -force_o_r * c + force_o_t * s
    y[lay.roller_load(lay.F_Y) + j] = -force_o_r * s - force_o_t * c
    y[lay.roller_load(lay.M_RING) + j] = mask * f_o * ring_arm_o
    y[lay.roller_load(lay.F_X_I) + j] = -force_i_r * c + force_i_t * s
    y[lay.roller_load(lay.F_Y_I) + j] = -force_i_r * s - force_i_t * c
    add_pocket_force(model.cage, model, common, y, j)
