"""``planar``: rings, rollers and cage move freely in the plane. Friction drives the rollers, so slip is computed.

The coordinates are each roller's radial displacement q, angle eps from the centre of its pocket, and spin; the
outer ring's x and y (and its rotation against a torsion spring); the cage's rotation and centre; and the centre of
the inner ring on its shaft. With rho = |c_j - u| the distance of a roller's centre from the ring's, n the unit
vector from the ring's centre to the roller's, and tau perpendicular to n,

    delta_o = rho + R_w - R_o - h(s),   s = R_o (angle of n - psi - phi_d),   force on the roller  -Q_o (n + g tau)

where g = -h'(s) R_o/rho, because a defect tilts the normal of the contact and its edge pushes the roller along the
race. The inner contact is analogous. The slip at a contact is the velocity of the roller's surface relative to
the race, perpendicular to the tilted normal, with the arm R_w - delta/2 on the roller; the friction force is
-mu(slip) Q. The approach is not linearised in u, because the linear approach q - u.e_r would do work on a closed
path. Angles are stored relative to their kinematic values, to avoid loss of digits.

Neglected: tilt, skew and axial motion of rollers, bending of rings and cage, stiffness of oil films.
"""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump, next_jump_with_slip
from bearingsim.core.defects.on_roller import correct_contact, is_masked, roller_at_defect
from bearingsim.core.defects.pairs import (
    CARRIER,
    HALF_WIDTH,
    ON_INNER,
    OUTER,
    RADIUS,
    SIDE,
    Defects,
    nearest_roller,
)
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.plane import Centre, approach, centre_at, cos_sin, fill_roller_direction, small_angle
from bearingsim.core.geometry.sides import InnerSide, OuterSide, contact_rows, normal_rows, sign
from bearingsim.core.jit import inlined, jit
from bearingsim.core.laws.damping.interface import damping_bound, stiffness_bound
from bearingsim.core.models import interface
from bearingsim.core.models.by_roller import (
    accelerate_roller,
    accelerate_shared,
    load_roller,
    register_roller_model,
    shared_quantities,
)
from bearingsim.core.models.extremes import update_forces
from bearingsim.core.models.interface import ModelKind, accelerations
from bearingsim.core.models.outer_ring import accelerate_outer_ring
from bearingsim.core.models.planar_derivatives import fill_planar_jacobian
from bearingsim.core.models.planar_forces import compute_roller_forces
from bearingsim.core.models.planar_form import add_form, load_contacts, load_contacts_with_form
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts.cage import accelerate_cage, cage_constraint, pocket_stiffness, sum_pocket_forces
from bearingsim.core.parts.form import Smooth
from bearingsim.core.parts.shaft import (
    accelerate_inner_ring,
    accelerate_ring_rotation,
    damper_per_mass,
    spring_per_mass,
)
from bearingsim.core.sums import sum_loads


class Planar(NamedTuple):
    """Parameters of the model.

    outer, inner: contact laws at the races; motion: ``geometry/motion.py``; friction: law of friction at the races
    (``laws/friction``); cage, drag: ``parts/cage.py``; shaft, bracket: ``parts/shaft.py``; gravity: m/s^2 along
    e_0, acting on rollers and cage (a ring's weight is part of its load); lag: time after which the slip of
    the implicit friction is evaluated, s (``laws/friction/lag.py``); form: form of the surfaces
    (``parts/form.py``).
    """

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    defects: Defects
    motion: Any
    friction: Any
    cage: Any
    drag: Any
    shaft: Any
    bracket: Any
    gravity: float
    lag: float = 0.0
    form: Any = Smooth()


@interface.state_width.register(Planar)
def _state_width(model):
    return 2 * lay.ROW + lay.FIRST_LANE + lanes(model.bearing)


@interface.monitored_bodies.register(Planar)
def _monitored_bodies(model):
    return model.bearing.Z


next_jump.register(Planar)(next_jump_with_slip)


@roller_at_defect.register(Planar)
def _roller_at_defect(model, d, t, y):
    """Return the roller from the positions of rollers, rings and cage and from the rows filled by ``approach``."""
    b, head = model.bearing, model.defects.head[d]
    time, _, _ = kinematic_time(model.motion, t)
    cage_angle = b.omega_c * time + y[lay.POSITION + lay.PHI_C]
    on_roller, outer = head[CARRIER] >= 0.0, head[SIDE] == OUTER
    roller_angle = (
        cage_angle - (b.omega_c - b.omega_b) * time - (y[lay.SPIN + int(head[CARRIER])] if on_roller else 0.0)
    )
    j, s = nearest_roller(model.defects, d, b.theta_0 + cage_angle, b.omega_i * time, roller_angle, b.Z)
    normal_angle = small_angle(y[lay.NORMAL_O_T + j] if outer else y[lay.NORMAL_I_T + j])
    return j, s + head[RADIUS] * (
        y[lay.EPS + j] + normal_angle - (y[lay.POSITION + lay.PSI] if outer and not on_roller else 0.0)
    )


class PlanarMotion(NamedTuple):
    """Pocket angle, body speeds and centres, computed once per evaluation.

    time: kinematic time (s); ramp_rate: relative acceleration of all speeds (1/s); theta_c, C, S: the first
    pocket's angle (rad), its cosine and sine; omega_cage, omega_i, omega_o: speeds of the cage, the inner and the
    outer ring (rad/s); spin: nominal spin of a roller (rad/s); outer, inner, cage: centres of rings and cage.
    """

    time: float
    ramp_rate: float
    theta_c: float
    C: float
    S: float
    omega_cage: float
    omega_i: float
    spin: float
    omega_o: float
    outer: Centre
    inner: Centre
    cage: Centre


register_roller_model(Planar)


@shared_quantities.register(Planar)
def _shared_quantities(model, t, y):
    b = model.bearing
    time, rate, ramp_rate = kinematic_time(model.motion, t)
    theta_c = b.theta_0 + b.omega_c * time + y[lay.POSITION + lay.PHI_C]
    C, S = cos_sin(theta_c)
    return PlanarMotion(
        time=time,
        ramp_rate=ramp_rate,
        theta_c=theta_c,
        C=C,
        S=S,
        omega_cage=b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C],
        omega_i=b.omega_i * rate,
        spin=(b.omega_c - b.omega_b) * rate,
        omega_o=y[lay.VELOCITY + lay.PSI],
        outer=centre_at(lay.X, y),
        inner=centre_at(lay.X_I, y),
        cage=centre_at(lay.X_C, y),
    )


@load_roller.register(Planar)
def _load_roller(model, common, y, j):
    fill_roller_direction(common.C, common.S, y, j)
    approach(OuterSide(), model.bearing, common.outer, common.omega_cage, y, j)
    approach(InnerSide(), model.bearing, common.inner, common.omega_cage, y, j)
    load_contacts(model.form, model, common, y, j)


@inlined
def correct_for_defects(model, common, t, y):
    """Correct each roller over a defect; return the torque (N m) on the outer ring due to the defects."""
    torque = 0.0
    for d in range(len(model.defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        if abs(s) < model.defects.head[d, HALF_WIDTH]:
            torque += correct_for_defect(model, common, d, j, s, t, y)
    return torque


@jit
def correct_for_defect(model, common, d, j, s, t, y):
    """Correct force, tilt of the normal and torque of roller ``j`` over roller-defect pair ``d``, and all
    dependent quantities.

    s: distance from the centre of the defect (m). Returns the torque (N m) on the outer ring due to the defect.

    Equations (P3) and (P4) of docs/planar.md.
    """
    if is_masked(model, d, j, s, t, y):
        return 0.0
    defects, carrier = model.defects, model.defects.head[d, CARRIER]
    on_roller, outer = carrier >= 0.0, defects.head[d, SIDE] == OUTER
    omega_defect = common.omega_i if carrier == ON_INNER else common.omega_o
    omega_defect = common.spin + y[lay.SPIN_V + j] if on_roller else omega_defect
    Q_o, Q_i = y[lay.Q_O + j], y[lay.Q_I + j]
    if outer:
        tangential = tilt_contact(OuterSide(), model.outer, defects, d, j, s, omega_defect, y)
        form_torque = add_form(model.form, OuterSide(), Q_o, y, j)
    else:
        tangential = tilt_contact(InnerSide(), model.inner, defects, d, j, s, omega_defect, y)
        form_torque = add_form(model.form, InnerSide(), Q_i, y, j)
    torque = tangential * defects.head[d, RADIUS]
    y[lay.DEFECT_TORQUE + j] -= torque if on_roller else 0.0
    normal_slope_o = y[lay.DEFECT_FORCE_O + j] / max(y[lay.Q_O + j], 1e-300)
    normal_slope_i = y[lay.DEFECT_FORCE_I + j] / max(y[lay.Q_I + j], 1e-300)
    compute_roller_forces(model, common, normal_slope_o, normal_slope_i, y, j)
    return (-torque if outer and not on_roller else 0.0) + (form_torque if outer else 0.0)


@jit
def tilt_contact(side, law, defects, d, j, s, omega_defect, y):
    """Correct one contact for a defect that rotates at ``omega_defect`` (rad/s), and tilt its normal.

    Returns the tangential component (N) of its force.
    """
    (_, _, rho, tangential_v, rho_v), (_, _, rate, _, tilt_row), radius = (
        normal_rows(side),
        contact_rows(side),
        defects.head[d, RADIUS],
    )
    y[rho_v + j] = sign(side) * y[rate + j]
    speed = radius * (y[tangential_v + j] / y[rho + j] - omega_defect)
    tangential = correct_contact(side, law, defects, d, j, s, speed, y)
    y[tilt_row + j] = tangential * radius / y[rho + j]
    return tangential


@accelerate_shared.register(Planar)
def _accelerate_shared(model, common, t, y):
    b = model.bearing
    n, alpha_kinematic = lanes(b), b.omega_c * common.ramp_rate
    form_torque = load_contacts_with_form(model.form, model, common, y)
    torque = correct_for_defects(model, common, t, y) + form_torque
    sum_loads(lay.F_X, lay.M_RING, y, n)
    sum_loads(lay.F_X_I, lay.F_Y_I, y, n)
    sum_pocket_forces(model.cage, y, n)
    y[lay.M_RING] += torque
    alpha_cage = accelerate_cage(model.cage, model, common.omega_cage, common.omega_i, alpha_kinematic, y)
    y[lay.ACCELERATION + lay.PHI_C] = alpha_cage - alpha_kinematic
    accelerate_outer_ring(model, y)
    accelerate_ring_rotation(model.bracket, y)
    accelerate_inner_ring(
        model.shaft, model, b.omega_i * common.time, common.omega_i, b.omega_i * common.ramp_rate, y
    )
    return alpha_cage


@accelerate_roller.register(Planar)
def _accelerate_roller(model, common, alpha_cage, y, j):
    """Implement ``accelerate_roller`` by equation (P2) of docs/planar.md.

    q'' = r theta'^2 + F_r/m,  theta'' = (F_theta/m - 2 q' theta')/r,  spin'' = M/I.
    """
    b, cage, per_mass = model.bearing, model.cage, y[lay.INVERSE_MASS + j]
    mask, alpha_spin = b.m_r * per_mass, (b.omega_c - b.omega_b) * common.ramp_rate
    r, theta_v = 0.5 * (b.R_o + b.R_i) + y[lay.RADIAL + j], common.omega_cage + y[lay.EPS_V + j]
    y[lay.RADIAL_A + j] = mask * r * theta_v * theta_v + per_mass * y[lay.FORCE_R + j]
    theta_a = (per_mass * y[lay.FORCE_T + j] - 2.0 * y[lay.RADIAL_V + j] * theta_v) / r
    y[lay.EPS_A + j] = cage_constraint(cage, mask * (theta_a - alpha_cage))
    y[lay.SPIN_A + j] = cage_constraint(cage, mask * (y[lay.TORQUE + j] * (1.0 / b.I_r) - alpha_spin))


@interface.begin.register(Planar)
def _begin(model, t, y):
    accelerations(model, t, y)


interface.update_extremes.register(Planar)(update_forces)


@interface.stiffness_per_mass.register(Planar)
def _stiffness_per_mass(model, y, j):
    """Return the largest stiffness over mass of the roller between its races, its pocket, and the rings'
    supports."""
    outer = stiffness_bound(model.outer, max(y[lay.DELTA_O + j], 0.0), y[lay.V_O + j])
    inner = stiffness_bound(model.inner, max(y[lay.DELTA_I + j], 0.0), y[lay.V_I + j])
    supports = max(spring_per_mass(model.shaft), spring_per_mass(model.bracket))
    per_mass = y[lay.INVERSE_MASS + j]
    pocket = pocket_stiffness(model.cage, per_mass, model.bearing.Z)
    return max(per_mass * (outer + inner), supports, pocket)


@interface.damping_per_mass.register(Planar)
def _damping_per_mass(model, y, j):
    """Return the largest damping over mass of the contacts and the rings' supports.

    Friction is left out, because it acts along the race, not on the radial motion, and because explicit methods
    evaluate it implicitly if it would limit the step (``laws/friction/lag.py``).
    """
    outer = damping_bound(model.outer, max(y[lay.DELTA_O + j], 0.0), y[lay.V_O + j])
    inner = damping_bound(model.inner, max(y[lay.DELTA_I + j], 0.0), y[lay.V_I + j])
    supports = max(damper_per_mass(model.shaft), damper_per_mass(model.bracket))
    return max(y[lay.INVERSE_MASS + j] * (outer + inner), supports)


@interface.degrees_of_freedom.register(Planar)
def _degrees_of_freedom(model):
    return 3, 8


@interface.linearise.register(Planar)
def _linearise(model, t, y):
    fill_planar_jacobian(model, t, y)


KIND = ModelKind(Planar, per_crossing=100)
