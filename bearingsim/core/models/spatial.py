"""``spatial``: every body with six degrees of freedom; sliced rollers that tilt, skew and move axially.

The model extends ``planar``. Each roller also moves along the bearing's axis and rotates about two more axes, and
so do the rings and the cage unless they are fixed. The contact of a roller with a race is a sum over slices
(``parts/races_in_space.py``). The roller's axis moves like that of a symmetric top (``geometry/orientation.py``).
In components along e_r, e_theta, e_z at the roller's angle,

    q'' = r theta'^2 + F_r/m,  theta'' = (F_theta/m - 2 q' theta')/r,  z'' = F_z/m
    omega' = M.a/I_a,  a'' = [(M - I_a omega a') x a]/I_t - |a'|^2 a

With straight rollers and without misalignment and tilting defects, all added quantities are zero and the rest
equals ``planar`` to rounding.

Neglected: bending of rollers, rings and cage; the elliptic section of a tilted slice (R_w (1 - cos tilt), 3 nm at
1 mrad); moments of the cage's guide; stiffness of oil films.
"""

from math import sqrt
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump, next_jump_with_slip
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.on_slices import (
    clear_defect_response,
    fill_slice_response,
    mark_rollers_at_defects,
    roller_near_defect,
    slice_polar_position,
)
from bearingsim.core.defects.pairs import OUTER, RADIUS, SIDE, Defects
from bearingsim.core.geometry.orientation import axis_acceleration, axis_precession, axis_z
from bearingsim.core.geometry.plane import fill_roller_directions
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA, Slices
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import damping_bound, stiffness_bound
from bearingsim.core.models import interface
from bearingsim.core.models.bodies_in_space import accelerate_rings_and_cage, bodies_at, set_mounted_rings
from bearingsim.core.models.differences import accelerate_bodies, fill_difference_jacobian, is_free_coordinate
from bearingsim.core.models.extremes import update_largest_forces
from bearingsim.core.models.interface import ModelKind, accelerations
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts.cage import cage_constraint, orbit_drag, pocket_stiffness
from bearingsim.core.parts.cage_in_space import add_pocket_forces_in_space, axial_stiffness
from bearingsim.core.parts.flanges import add_flange_forces, flange_stiffness
from bearingsim.core.parts.form import Smooth
from bearingsim.core.parts.form_in_space import read_form
from bearingsim.core.parts.mounts import mount_damping, mount_stiffness
from bearingsim.core.parts.races_in_space import (
    add_side_loads,
    add_slice,
    clear_sums,
    fill_race_frame,
    fill_slip_changes,
    relax_friction,
    update_line_load,
)
from bearingsim.core.parts.shaft import damper_per_mass, spring_per_mass
from bearingsim.core.sums import sum_loads


class Spatial(NamedTuple):
    """Parameters of the model: those of ``Planar``, and

    slices: division of a roller into slices (``geometry/slices.py``); L_w: length of a roller (m); I_t: its moment
    of inertia about a diameter (kg m^2); mount_o, mount_i: mounts of the rings (``parts/mounts.py``); flanges:
    ``parts/flanges.py``; cage_z: ``parts/cage_in_space.py``; lag: as in ``Planar``, s; form: form of the
    surfaces (``parts/form.py``).
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
    slices: Slices
    L_w: float
    I_t: float
    mount_o: Any
    mount_i: Any
    flanges: Any
    cage_z: Any
    lag: float = 0.0
    form: Any = Smooth()


@interface.state_width.register(Spatial)
def _state_width(model):
    return 5 * lay.ROW + lay.FIRST_LANE + lanes(model.bearing)


@interface.monitored_bodies.register(Spatial)
def _monitored_bodies(model):
    return model.bearing.Z


@jit
def fill_roller_axes(spin, omega_cage, R_w, y, n):
    """Fill the components of each roller's axis along e_r, e_theta, e_z, their rates, the speed about it and the
    rolling speed.

    spin: nominal spin of a roller (rad/s).
    """
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        a_x, a_y, w_x, w_y = y[lay.AXIS_X + j], y[lay.AXIS_Y + j], y[lay.AXIS_X_V + j], y[lay.AXIS_Y_V + j]
        a_z = axis_z(a_x, a_y)
        y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j] = a_x * c + a_y * s, a_y * c - a_x * s, a_z
        y[lay.TILT_V + j], y[lay.SKEW_V + j] = w_x * c + w_y * s, w_y * c - w_x * s
        y[lay.AXIS_Z_V + j] = -(a_x * w_x + a_y * w_y) / a_z
        y[lay.OMEGA + j] = spin + y[lay.SPIN_V + j] + axis_precession(a_x, a_y, a_z, w_x, w_y)
        y[lay.ROLLING_SPEED + j] = R_w * abs(omega_cage + y[lay.EPS_V + j] - y[lay.OMEGA + j])


@jit
def fill_external_loads(model, omega_cage, y, n):
    """Fill the rows FORCE and MOMENT of every roller with the loads except contact forces: gravity and oil
    drag."""
    weight, R_mean = model.gravity * model.bearing.m_r, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    for j in range(n):
        speed = (omega_cage + y[lay.EPS_V + j]) * (R_mean + y[lay.RADIAL + j])
        y[lay.FORCE_R + j] = weight * y[lay.COS + j]
        y[lay.FORCE_T + j] = -weight * y[lay.SIN + j] + orbit_drag(model.drag, speed)
        y[lay.FORCE_Z + j] = 0.0
        y[lay.MOMENT_R + j], y[lay.MOMENT_T + j], y[lay.MOMENT_Z + j] = 0.0, 0.0, 0.0


@jit
def compute_race_contacts(model, t, tilt_factor, outer, inner, omega_cage, y, n):
    """Compute the contacts of the rollers' slices with both races; fill the sums of both sides.

    tilt_factor: 1.0, or 0.0 if defects and form do not tilt the normal (static equilibrium); outer, inner: the
    rings.
    """
    b, table = model.bearing, model.slices.table
    fill_race_frame(OuterSide(), b, outer, omega_cage, y, n)
    fill_race_frame(InnerSide(), b, inner, omega_cage, y, n)
    marked = mark_rollers_at_defects(model, t, outer.a_z, inner.a_z, y) if len(model.defects.head) > 0 else 0
    clear_sums(OuterSide(), y, n)
    clear_sums(InnerSide(), y, n)
    for k in range(len(table)):
        zeta, weight, drop = table[k, ZETA], table[k, WEIGHT], table[k, DROP]
        if marked > 0:
            fill_slice_response(model, t, k, tilt_factor, outer.a_z, inner.a_z, y)
        read_form(model.form, model, t, tilt_factor, zeta, (outer.a_z, inner.a_z), y, n)
        add_slice(OuterSide(), model.outer, model.friction, model.form, b, outer, zeta, weight, drop, k, y, n)
        add_slice(InnerSide(), model.inner, model.friction, model.form, b, inner, zeta, weight, drop, k, y, n)
    if marked > 0:
        clear_defect_response(model, y)
    fill_slip_changes(model.lag, b.m_r, b.I_r, model.I_t, b.R_w, y, n)
    relax_friction(OuterSide(), outer, y, n)
    relax_friction(InnerSide(), inner, y, n)


@jit
def accelerate_rollers(model, omega_cage, alpha_cage, alpha_spin, y, n):
    """Write the accelerations of every roller: Newton's equations of its centre, Euler's of its axis and spin."""
    b, cage = model.bearing, model.cage
    R_mean = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        per_mass = y[lay.INVERSE_MASS + j]
        mask = b.m_r * per_mass
        r, theta_v = R_mean + y[lay.RADIAL + j], omega_cage + y[lay.EPS_V + j]
        y[lay.RADIAL_A + j] = mask * r * theta_v * theta_v + per_mass * y[lay.FORCE_R + j]
        theta_a = (per_mass * y[lay.FORCE_T + j] - 2.0 * y[lay.RADIAL_V + j] * theta_v) / r
        y[lay.EPS_A + j] = cage_constraint(cage, mask * (theta_a - alpha_cage))
        y[lay.AXIAL_A + j] = cage_constraint(cage, per_mass * y[lay.FORCE_Z + j])

        a_r, a_t, a_z = y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]
        w_r, w_t, w_z = y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j]
        M_r, M_t, M_z = y[lay.MOMENT_R + j], y[lay.MOMENT_T + j], y[lay.MOMENT_Z + j]
        l_r, l_t = axis_acceleration(
            M_r, M_t, M_z, b.I_r * y[lay.OMEGA + j], model.I_t, a_r, a_t, a_z, w_r, w_t, w_z
        )
        # acceleration along e_theta of an axis that a kinematic cage prevents from skewing
        frame_acceleration = 2.0 * w_r * theta_v + a_r * alpha_cage
        l_r, l_t = mask * l_r, mask * (frame_acceleration + cage_constraint(cage, l_t - frame_acceleration))
        c, s = y[lay.COS + j], y[lay.SIN + j]
        y[lay.AXIS_X_A + j], y[lay.AXIS_Y_A + j] = l_r * c - l_t * s, l_r * s + l_t * c
        one_plus_z, swept_rate = 1.0 + a_z, w_r * a_t - a_r * w_t
        precession_rate = (l_r * a_t - a_r * l_t) / one_plus_z - swept_rate * w_z / (one_plus_z * one_plus_z)
        omega_a = (M_r * a_r + M_t * a_t + M_z * a_z) / b.I_r
        y[lay.SPIN_A + j] = cage_constraint(cage, mask * (omega_a - precession_rate - alpha_spin))


@accelerations.register(Spatial)
def _accelerations(model, t, y):
    b = model.bearing
    n = lanes(b)
    common = bodies_at(model, t, y)
    fill_roller_directions(b.theta_0 + b.omega_c * common.time + y[lay.POSITION + lay.PHI_C], y, n)
    fill_roller_axes(common.spin, common.omega_cage, b.R_w, y, n)
    fill_external_loads(model, common.omega_cage, y, n)
    compute_race_contacts(model, t, 1.0, common.outer, common.inner, common.omega_cage, y, n)
    add_flange_forces(model.flanges, model, common.outer, common.inner, y, n)
    add_side_loads(OuterSide(), b, common.outer, y, n)
    add_side_loads(InnerSide(), b, common.inner, y, n)
    add_pocket_forces_in_space(model.cage, model, common.cage, common.omega_cage, common.spin, y, n)
    sum_loads(lay.F_X, lay.M_INNER, y, n)
    alpha_cage = accelerate_rings_and_cage(model, common, y)
    accelerate_rollers(model, common.omega_cage, alpha_cage, (b.omega_c - b.omega_b) * common.ramp_rate, y, n)


@interface.begin.register(Spatial)
def _begin(model, t, y):
    set_mounted_rings(model, y)
    accelerations(model, t, y)


@interface.update_extremes.register(Spatial)
def _update_extremes(model, y):
    n = lanes(model.bearing)
    update_largest_forces(y, n)
    for j in range(n):
        y[lay.TILT_MAX + j] = max(y[lay.TILT_MAX + j], abs(y[lay.TILT + j]))
    for k in range(len(model.slices.table)):
        update_line_load(lay.slice_row(k, 0), model.slices.table[k, WEIGHT] * model.L_w, y, n)


next_jump.register(Spatial)(next_jump_with_slip)


@roller_at_defect.register(Spatial)
def _roller_at_defect(model, d, t, y):
    """Return the roller whose centre is nearest, from the positions of rollers, rings and cage and from the rows
    filled by ``fill_race_frame``."""
    head, R_mean = model.defects.head[d], 0.5 * (model.bearing.R_o + model.bearing.R_i)
    outer = head[SIDE] == OUTER
    tilt_cells = (lay.RING_TILT_X, lay.RING_TILT_Y) if outer else (lay.INNER_TILT_X, lay.INNER_TILT_Y)
    b_z = axis_z(y[tilt_cells[0]], y[tilt_cells[1]])
    j, s = roller_near_defect(model, d, t, y)
    return j, s + head[RADIUS] * slice_polar_position(
        lay.OUTER_SIDE if outer else lay.INNER_SIDE, R_mean, b_z, 0.0, y, j
    )[0]


@jit
def largest_eigenvalue(a, b, d):
    """Return the largest eigenvalue of the symmetric matrix [[a, b], [b, d]]."""
    half = 0.5 * (a - d)
    return 0.5 * (a + d) + sqrt(half * half + b * b)


@jit
def contact_stiffness_and_damping(model, y, j):
    """Return the largest stiffness (1/s^2) and damping (1/s) over inertia of a roller on its race contacts.

    They are the largest eigenvalues for radial motion and tilt, which are coupled unless the sum of k zeta over
    the slices is zero, so a roller loaded at one end is stiffer than in either motion alone.
    """
    k, k_1, k_2, c, c_1, c_2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(model.slices.table)):
        zeta, weight = model.slices.table[i, ZETA], model.slices.table[i, WEIGHT]
        delta_o = max(y[lay.slice_row(i, lay.APPROACH_O) + j], 0.0)
        delta_i = max(y[lay.slice_row(i, lay.APPROACH_I) + j], 0.0)
        k_slice = weight * (
            stiffness_bound(model.outer, delta_o, y[lay.V_O + j])
            + stiffness_bound(model.inner, delta_i, y[lay.V_I + j])
        )
        c_slice = weight * (
            damping_bound(model.outer, delta_o, y[lay.V_O + j])
            + damping_bound(model.inner, delta_i, y[lay.V_I + j])
        )
        k, k_1, k_2 = k + k_slice, k_1 + zeta * k_slice, k_2 + zeta * zeta * k_slice
        c, c_1, c_2 = c + c_slice, c_1 + zeta * c_slice, c_2 + zeta * zeta * c_slice
    per_mass, per_inertia = y[lay.INVERSE_MASS + j], 1.0 / model.I_t
    coupling = sqrt(per_mass * per_inertia)
    K = largest_eigenvalue(per_mass * k, coupling * k_1, per_inertia * k_2)
    return K, largest_eigenvalue(per_mass * c, coupling * c_1, per_inertia * c_2)


@interface.stiffness_per_mass.register(Spatial)
def _stiffness_per_mass(model, y, j):
    """Return the largest stiffness over inertia of the roller between its races, its pocket, the flanges, and the
    rings' supports."""
    per_mass = y[lay.INVERSE_MASS + j]
    K, _ = contact_stiffness_and_damping(model, y, j)
    supports = max(spring_per_mass(model.shaft), spring_per_mass(model.bracket))
    mounts = max(mount_stiffness(model.mount_o), mount_stiffness(model.mount_i))
    wall = pocket_stiffness(model.cage, per_mass, model.bearing.Z)
    pocket = max(wall, axial_stiffness(model.cage_z, model.cage, per_mass, model.bearing.Z))
    flange = flange_stiffness(model.flanges, per_mass, 1.0 / model.I_t, model.bearing.R_w)
    return max(K, supports, mounts, pocket, flange)


@interface.damping_per_mass.register(Spatial)
def _damping_per_mass(model, y, j):
    """Return the largest damping over inertia of contacts and the rings' supports.

    Friction at the races is left out, as in ``planar``. Friction at flanges and pockets has no lag and acts along
    and about the roller's axes, so it is added to the roller's damping. Its current value is used, because these
    contacts always slip.
    """
    b, half, per_mass = model.bearing, 0.5 * model.L_w, y[lay.INVERSE_MASS + j]
    _, C = contact_stiffness_and_damping(model, y, j)
    supports = max(damper_per_mass(model.shaft), damper_per_mass(model.bracket))
    mounts = max(mount_damping(model.mount_o), mount_damping(model.mount_i))
    # accelerance of the surface at a roller's end (1/kg): translation, spin and tilt
    end_accelerance = per_mass + b.R_w * b.R_w / b.I_r + half * half / model.I_t
    return max(C + (y[lay.KAPPA_F + j] + y[lay.KAPPA_P + j]) * end_accelerance, supports, mounts)


@interface.degrees_of_freedom.register(Spatial)
def _degrees_of_freedom(model):
    return 6, 17


@interface.linearise.register(Spatial)
def _linearise(model, t, y):
    fill_difference_jacobian(model, t, y)


@is_free_coordinate.register(Spatial)
def _is_free_coordinate(model, i):
    """Implement ``is_free_coordinate``: with a kinematic cage only radial position and axis direction are free."""
    return i == 0 or i > 3 or cage_constraint(model.cage, 1.0) > 0.0


@accelerate_bodies.register(Spatial)
def _accelerate_bodies(model, t, y):
    accelerate_rings_and_cage(model, bodies_at(model, t, y), y)


KIND = ModelKind(Spatial, per_crossing=100)
