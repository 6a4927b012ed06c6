"""``rollers``: the ring moves in x and y, each roller radially; the cage rotates at its kinematic speed.

    delta_o = r + R_w - R_o - u.e_r - h(s_o),  v_o = r' - u'.e_r - omega_c u.e_theta - h'(s_o) R_o omega_c
    delta_i = R_i + R_w - r - h(s_i),          v_i = -r' - h'(s_i) R_i (omega_c - omega_i)
    m_r r'' = m_r omega_c^2 r + Q_i - Q_o
    m_o u'' = -F e_0 - F_across e_90 - k_b (u - u_0) - c_b u' + sum_j Q_o,j e_r(theta_j)

A defect of a roller is included in h at each of its contacts, which it passes at R_w omega_b. The position of a
roller is stored as its displacement q from the pitch circle, r = d_m/2 + q, because r of about 0.03 m would cost 2
of 16 digits. Neglected: friction, tangential motion, tilt, bending of the rings. Bending of the outer ring can be
included (``parts/bending.py``), which subtracts w(theta_j) from delta_o and its rate from v_o.
"""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump, next_jump_without_slip
from bearingsim.core.defects.on_roller import (
    correct_contact,
    derivatives_over_defect,
    is_masked,
    roller_at_defect,
    roller_at_defect_without_slip,
)
from bearingsim.core.defects.pairs import HALF_WIDTH, OUTER, SIDE, Defects, passing_speed
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.jit import inlined, jit
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.models import interface
from bearingsim.core.models.by_roller import (
    accelerate_roller,
    accelerate_shared,
    load_roller,
    register_roller_model,
    shared_quantities,
)
from bearingsim.core.models.extremes import update_forces
from bearingsim.core.models.interface import ModelKind, accelerations, harmonics, linearise, read_sensor
from bearingsim.core.models.outer_ring import (
    accelerate_ring,
    fill_roller_angle,
    linearise_ring,
    load_ring,
    ring_motion,
)
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts import bending
from bearingsim.core.parts.form import RECESS_I, RECESS_O, RECESS_V_I, RECESS_V_O, Smooth, fill_recesses, recess

# tangent stiffness and damping of the contacts
K_O, C_O, K_I, C_I = lay.rows(lay.WORK, "N/m, N s/m", "rollers", "linearise", count=2)


class Rollers(NamedTuple):
    """Parameters of the model; ``outer``, ``inner``: contact laws (``laws/damping``) at the two races.

    bending: bending of the outer ring (``parts/bending.py``); form: form of the surfaces (``parts/form.py``).
    """

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    defects: Defects
    bending: Any
    form: Any = Smooth()


@interface.state_width.register(Rollers)
def _state_width(model):
    count = harmonics(model)
    return lay.MODES_S + count if count > 0 else lay.FIRST_LANE + lanes(model.bearing)


@harmonics.register(Rollers)
def _harmonics(model):
    return bending.harmonics(model.bending)


@interface.monitored_bodies.register(Rollers)
def _monitored_bodies(model):
    return model.bearing.Z


roller_at_defect.register(Rollers)(roller_at_defect_without_slip)
next_jump.register(Rollers)(next_jump_without_slip)
register_roller_model(Rollers)


@shared_quantities.register(Rollers)
def _shared_quantities(model, t, y):
    common = ring_motion(model, t, y)
    bending.fill_race_deflection(model.bending, common.C, common.S, model.bearing.omega_c, y, lanes(model.bearing))
    fill_recesses(model.form, model.bearing, t, y)
    return common


@inlined
def fill_race_approaches(model, common, c, s, y, j):
    """Fill the approaches of both contacts of roller ``j`` over undamaged races, and their rates.

    Equation (M7) of docs/model.md without h; for a flexible ring (R3) of docs/ring.md; with form (F1) of
    docs/form.md.
    """
    gap, r, v, form = model.bearing.gap, y[lay.RADIAL + j], y[lay.RADIAL_V + j], model.form
    delta = r - (common.u_x * c + common.u_y * s) - gap - bending.race_deflection(model.bending, y, j)
    rate = v - (common.w_x * c + common.w_y * s) - bending.race_deflection_rate(model.bending, y, j)
    y[lay.DELTA_O + j], y[lay.V_O + j] = (
        delta - recess(form, RECESS_O, y, j),
        rate - recess(form, RECESS_V_O, y, j),
    )
    y[lay.DELTA_I + j], y[lay.V_I + j] = (
        -gap - r - recess(form, RECESS_I, y, j),
        -v - recess(form, RECESS_V_I, y, j),
    )


@load_roller.register(Rollers)
def _load_roller(model, common, y, j):
    c, s = fill_roller_angle(common, y, j)
    fill_race_approaches(model, common, c, s, y, j)
    y[lay.Q_O + j] = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
    y[lay.Q_I + j] = normal_force(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])
    load_ring(y, j)


@inlined
def correct_for_defects(model, t, y):
    """Correct the contact of each roller over a defect, whose force is the sum over the defect's groups."""
    for d in range(len(model.defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        if abs(s) < model.defects.head[d, HALF_WIDTH]:
            correct_for_defect(model, d, j, s, t, y)


@jit
def correct_for_defect(model, d, j, s, t, y):
    """Correct the contact of roller ``j`` over roller-defect pair ``d``, unless another pair masks it."""
    if is_masked(model, d, j, s, t, y):
        return
    defects, speed = model.defects, passing_speed(model.defects, d, model.bearing)
    if defects.head[d, SIDE] == OUTER:
        correct_contact(OuterSide(), model.outer, defects, d, j, s, speed, y)
        load_ring(y, j)
    else:
        correct_contact(InnerSide(), model.inner, defects, d, j, s, speed, y)


@accelerate_shared.register(Rollers)
def _accelerate_shared(model, common, t, y):
    correct_for_defects(model, t, y)
    accelerate_ring(model, common, y)
    bending.accelerate_harmonics(model.bending, model.bearing.m_o, y)


@accelerate_roller.register(Rollers)
def _accelerate_roller(model, common, body_acceleration, y, j):
    """Implement ``accelerate_roller`` by equation (M8) of docs/model.md, first line."""
    b = model.bearing
    centrifugal = b.m_r * b.omega_c * b.omega_c * (0.5 * (b.R_o + b.R_i) + y[lay.RADIAL + j])
    y[lay.RADIAL_A + j] = y[lay.INVERSE_MASS + j] * (centrifugal + y[lay.Q_I + j] - y[lay.Q_O + j])


@interface.begin.register(Rollers)
def _begin(model, t, y):
    accelerations(model, t, y)


interface.update_extremes.register(Rollers)(update_forces)


@interface.race_deflection_at.register(Rollers)
def _race_deflection_at(model, y, j):
    return bending.race_deflection(model.bending, y, j)


@read_sensor.register(Rollers)
def _read_sensor(model, y):
    bending.read_sensor(model.bending, y)


@interface.stiffness_per_mass.register(Rollers)
def _stiffness_per_mass(model, y, j):
    outer = stiffness_bound(model.outer, max(y[lay.DELTA_O + j], 0.0), y[lay.V_O + j])
    inner = stiffness_bound(model.inner, max(y[lay.DELTA_I + j], 0.0), y[lay.V_I + j])
    return bending.race_stiffness_bound(
        model.bending, y[lay.INVERSE_MASS + j] * (outer + inner), y[lay.INVERSE_MASS + j], outer
    )


@interface.damping_per_mass.register(Rollers)
def _damping_per_mass(model, y, j):
    outer = damping_bound(model.outer, max(y[lay.DELTA_O + j], 0.0), y[lay.V_O + j])
    inner = damping_bound(model.inner, max(y[lay.DELTA_I + j], 0.0), y[lay.V_I + j])
    return y[lay.INVERSE_MASS + j] * (outer + inner) + bending.race_damping(model.bending, outer)


@interface.degrees_of_freedom.register(Rollers)
def _degrees_of_freedom(model):
    return 1, 2


@jit
def correct_derivatives_over_defects(model, t, y):
    """Correct the derivatives of each contact over a defect; its position on the defect depends on time only."""
    defects, bearing = model.defects, model.bearing
    for d in range(len(defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        if abs(s) < defects.head[d, HALF_WIDTH] and not is_masked(model, d, j, s, t, y):
            speed = passing_speed(defects, d, bearing)
            if defects.head[d, SIDE] == OUTER:
                delta, v = y[lay.DELTA_O + j], y[lay.V_O + j]
                y[K_O + j], y[C_O + j] = derivatives_over_defect(model.outer, defects, d, s, speed, delta, v)
            else:
                delta, v = y[lay.DELTA_I + j], y[lay.V_I + j]
                y[K_I + j], y[C_I + j] = derivatives_over_defect(model.inner, defects, d, s, speed, delta, v)


@linearise.register(Rollers)
def _linearise(model, t, y):
    bearing = model.bearing
    n, common = lanes(bearing), shared_quantities(model, t, y)
    for j in range(n):
        fill_race_approaches(model, common, y[lay.COS + j], y[lay.SIN + j], y, j)
        y[K_O + j], y[C_O + j] = derivatives(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
        y[K_I + j], y[C_I + j] = derivatives(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])
    correct_derivatives_over_defects(model, t, y)

    omega_c, omega_c_squared, per_ring_mass = bearing.omega_c, bearing.omega_c * bearing.omega_c, 1.0 / bearing.m_o
    for j in range(n):
        c, s, per_mass = y[lay.COS + j], y[lay.SIN + j], y[lay.INVERSE_MASS + j]
        K, C = y[K_O + j], y[C_O + j]
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, 0, 0) + j] = per_mass * (
            bearing.m_r * omega_c_squared - K - y[K_I + j]
        )
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, 0, 0) + j] = per_mass * (-C - y[C_I + j])
        y[lay.border_column(lay.POSITION_JACOBIAN, 0, lay.X) + j] = per_mass * (K * c - C * omega_c * s)
        y[lay.border_column(lay.POSITION_JACOBIAN, 0, lay.Y) + j] = per_mass * (K * s + C * omega_c * c)
        y[lay.border_column(lay.VELOCITY_JACOBIAN, 0, lay.X) + j] = per_mass * C * c
        y[lay.border_column(lay.VELOCITY_JACOBIAN, 0, lay.Y) + j] = per_mass * C * s
        y[lay.border_row(lay.POSITION_JACOBIAN, lay.X, 0) + j] = per_ring_mass * K * c
        y[lay.border_row(lay.POSITION_JACOBIAN, lay.Y, 0) + j] = per_ring_mass * K * s
        y[lay.border_row(lay.VELOCITY_JACOBIAN, lay.X, 0) + j] = per_ring_mass * C * c
        y[lay.border_row(lay.VELOCITY_JACOBIAN, lay.Y, 0) + j] = per_ring_mass * C * s
    linearise_ring(model, K_O, C_O, y, n)


# the damping force jumps at the cusp of a narrow defect and decays within 0.2 us, so a crossing needs more steps
KIND = ModelKind(Rollers, per_crossing=100)
