"""Analytic derivatives of the accelerations of ``planar``, column by column.

A column contains the changes per unit of one coordinate: the same coordinate of all rollers at once (a roller
depends only on its own and the shared coordinates), or one shared coordinate. The changes of the rollers'
positions and velocities relative to the body that they touch are written to the rows D_POSITION and D_VELOCITY,
from which ``parts/races.py`` and ``parts/cage_derivatives.py`` compute the changes of the forces. Terms from the
rotation of e_r and e_theta with the roller, its inertial terms and the supports of the shared coordinates are
added at the end.

Friction is not lagged (``laws/friction/lag.py``), because implicit methods use no lag.
"""

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.jit import jit
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.cage import cage_constraint, orbit_drag
from bearingsim.core.parts.cage_derivatives import (
    add_guide_derivatives,
    add_pocket_changes,
    cage_accelerances,
    fill_pocket_derivatives,
    land_drag_derivative,
    orbit_drag_derivative,
)
from bearingsim.core.parts.races import (
    add_race_changes,
    correct_derivatives_over_defects,
    fill_contact_derivatives,
    fill_friction_derivatives,
)
from bearingsim.core.parts.shaft import accelerance, damper_per_mass, spring_per_mass
from bearingsim.core.sums import sum_addends

RADIAL, ORBIT, SPIN = range(3)  # coordinates of a roller
SHARED_DOF = 8  # number of shared coordinates
FIRST_CAGE, FIRST_INNER = 3, 6  # first shared coordinate of the cage and of the inner ring


@jit
def clear_changes(low, high, y, n):
    """Clear the rows D_POSITION, D_VELOCITY, D_FORCE and D_TORQUE, and D_FORCE_SHARED of range(low, high)."""
    for j in range(n):
        y[lay.D_POSITION_R + j] = 0.0
        y[lay.D_POSITION_T + j] = 0.0
        y[lay.D_VELOCITY_R + j] = 0.0
        y[lay.D_VELOCITY_T + j] = 0.0
        y[lay.D_FORCE_R + j], y[lay.D_FORCE_T + j], y[lay.D_TORQUE + j] = 0.0, 0.0, 0.0
    for k in range(low, high):
        for j in range(n):
            y[lay.D_FORCE_SHARED + k * lay.ROW + j] = 0.0


@jit
def fill_accelerances(model, y, n):
    """Fill the rows ACCELERANCE_*: accelerations of rollers and shared bodies per unit of force or torque."""
    b, cage, m_o = model.bearing, model.cage, model.bearing.m_o
    R_mean, cage_factor = 0.5 * (b.R_o + b.R_i), cage_constraint(cage, 1.0)
    for j in range(n):
        per_mass = y[lay.INVERSE_MASS + j]
        y[lay.ACCELERANCE_R + j], y[lay.ACCELERANCE_T + j] = (
            per_mass,
            cage_factor * per_mass / (R_mean + y[lay.RADIAL + j]),
        )
        y[lay.ACCELERANCE_SPIN + j] = cage_factor * (b.m_r / b.I_r) * per_mass
    cage_rotation, cage_translation = cage_accelerances(cage)
    y[lay.ACCELERANCE_SHARED + lay.X], y[lay.ACCELERANCE_SHARED + lay.Y], y[lay.ACCELERANCE_SHARED + lay.PSI] = (
        1.0 / m_o,
        1.0 / m_o,
        accelerance(model.bracket),
    )
    y[lay.ACCELERANCE_SHARED + lay.PHI_C] = cage_rotation
    y[lay.ACCELERANCE_SHARED + lay.X_C] = cage_translation
    y[lay.ACCELERANCE_SHARED + lay.Y_C] = cage_translation
    y[lay.ACCELERANCE_SHARED + lay.X_I], y[lay.ACCELERANCE_SHARED + lay.Y_I] = (
        accelerance(model.shaft),
        accelerance(model.shaft),
    )


@jit
def write_roller_column(matrix, i, m_r, y, n):
    """Write the changes of acceleration into the column of the rollers' coordinate ``i``."""
    for j in range(n):
        y[lay.diagonal_block(matrix, RADIAL, i) + j] = y[lay.ACCELERANCE_R + j] * y[lay.D_FORCE_R + j]
    for j in range(n):
        y[lay.diagonal_block(matrix, ORBIT, i) + j] = y[lay.ACCELERANCE_T + j] * y[lay.D_FORCE_T + j]
    for j in range(n):
        y[lay.diagonal_block(matrix, SPIN, i) + j] = y[lay.ACCELERANCE_SPIN + j] * y[lay.D_TORQUE + j]
    for k in range(SHARED_DOF):
        scale = m_r * y[lay.ACCELERANCE_SHARED + k]  # the inverse mass is 0 in a padded lane
        for j in range(n):
            y[lay.border_row(matrix, k, i) + j] = (
                scale * y[lay.INVERSE_MASS + j] * y[lay.D_FORCE_SHARED + k * lay.ROW + j]
            )


@jit
def write_shared_column(matrix, m, low, high, m_r, y, n):
    """Write the changes of acceleration into the column of the shared coordinate ``m``.

    low, high: the accelerations of the shared coordinates range(low, high) depend on it.
    """
    for j in range(n):
        y[lay.border_column(matrix, RADIAL, m) + j] = y[lay.ACCELERANCE_R + j] * y[lay.D_FORCE_R + j]
    for j in range(n):
        y[lay.border_column(matrix, ORBIT, m) + j] = y[lay.ACCELERANCE_T + j] * y[lay.D_FORCE_T + j]
    for j in range(n):
        y[lay.border_column(matrix, SPIN, m) + j] = y[lay.ACCELERANCE_SPIN + j] * y[lay.D_TORQUE + j]
    for k in range(SHARED_DOF):
        y[lay.corner_block(matrix, k, m)] = 0.0
    for k in range(low, high):
        for j in range(n):
            y[lay.ADDENDS + j] = y[lay.INVERSE_MASS + j] * y[lay.D_FORCE_SHARED + k * lay.ROW + j]
        y[lay.corner_block(matrix, k, m)] = m_r * y[lay.ACCELERANCE_SHARED + k] * sum_addends(y, n)


@jit
def displace_rollers(i, position, speed, R_mean, omega_cage, y, n):
    """Fill the changes due to a displacement of every roller's coordinate ``i`` and of its rate.

    position: displacement of the coordinate (m, rad); speed: of its rate (m/s, rad/s).

    The velocity r' e_r + r theta' e_theta changes with r and, because its directions rotate, with theta.
    """
    radial = 1.0 if i == RADIAL else 0.0
    orbital = 1.0 if i == ORBIT else 0.0
    for j in range(n):
        r, v, theta_v = R_mean + y[lay.RADIAL + j], y[lay.RADIAL_V + j], omega_cage + y[lay.EPS_V + j]
        y[lay.D_POSITION_R + j], y[lay.D_POSITION_T + j] = position * radial, position * orbital * r
        y[lay.D_VELOCITY_R + j] = speed * radial - position * orbital * r * theta_v
        y[lay.D_VELOCITY_T + j] = speed * orbital * r + position * (radial * theta_v + orbital * v)


@jit
def displace_body(axis, position, speed, y, n):
    """Fill the changes of the rollers' positions and velocities relative to a body whose centre is displaced.

    axis: direction of the displacement, 0 for e_0 and 1 for e_90; position (m), speed (m/s): changes of the body's
    position and velocity along it.
    """
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        d_r, d_t = (-s, -c) if axis else (-c, s)
        y[lay.D_POSITION_R + j], y[lay.D_POSITION_T + j], y[lay.D_VELOCITY_R + j], y[lay.D_VELOCITY_T + j] = (
            position * d_r,
            position * d_t,
            speed * d_r,
            speed * d_t,
        )


@jit
def fill_roller_columns(model, omega_cage, omega_i, spin, y, n):
    """Fill the columns of the rollers' own coordinates and velocities."""
    b, omega_o = model.bearing, y[lay.VELOCITY + lay.PSI]
    R_mean = 0.5 * (b.R_o + b.R_i)
    for i in range(3):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            d_roll, d_spin = (position, speed) if i == SPIN else (0.0, 0.0)
            d_orbit = speed if i == ORBIT else 0.0
            clear_changes(0, SHARED_DOF, y, n)
            displace_rollers(i, position, speed, R_mean, omega_cage, y, n)
            add_race_changes(OuterSide(), spin, omega_o, d_roll, d_spin, d_orbit, 0.0, 0.0, y, n)
            add_race_changes(InnerSide(), spin, omega_i, d_roll, d_spin, d_orbit, 0.0, 0.0, y, n)
            add_pocket_changes(model.cage, b.R_w, omega_cage, d_spin, 0.0, 0.0, y, n)
            write_roller_column(matrix, i, b.m_r, y, n)


@jit
def fill_ring_columns(side, omega_ring, spin, m_r, low, high, y, n):
    """Fill the columns of a ring's centre, which couples with the shared coordinates range(low, high) only."""
    for axis in range(2):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            clear_changes(low, high, y, n)
            displace_body(axis, position, speed, y, n)
            add_race_changes(side, spin, omega_ring, 0.0, 0.0, 0.0, 0.0, 0.0, y, n)
            write_shared_column(matrix, low + axis, low, high, m_r, y, n)


@jit
def fill_ring_angle_columns(model, spin, y, n):
    """Fill the columns of the outer ring's angle, with which its defects rotate, and of its speed."""
    for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
        clear_changes(lay.X, FIRST_CAGE, y, n)
        add_race_changes(OuterSide(), spin, y[lay.VELOCITY + lay.PSI], 0.0, 0.0, 0.0, position, speed, y, n)
        write_shared_column(matrix, lay.PSI, lay.X, FIRST_CAGE, model.bearing.m_r, y, n)


@jit
def fill_cage_columns(model, omega_cage, y, n):
    """Fill the columns of the cage's angle and centre, in the order of its shared coordinates."""
    for k in range(FIRST_CAGE, FIRST_INNER):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            d_angle, d_omega = (position, speed) if k == lay.PHI_C else (0.0, 0.0)
            clear_changes(FIRST_CAGE, FIRST_INNER, y, n)
            if k != lay.PHI_C:
                displace_body(k - lay.X_C, position, speed, y, n)
            add_pocket_changes(model.cage, model.bearing.R_w, omega_cage, 0.0, d_angle, d_omega, y, n)
            write_shared_column(matrix, k, FIRST_CAGE, FIRST_INNER, model.bearing.m_r, y, n)


@jit
def add_inertial_terms(model, omega_cage, y, n):
    """Add the terms due to the rotation of e_r and e_theta and to inertia in q'' = r theta'^2 + F_r/m and
    theta'' = (F_theta/m - 2 q' theta')/r, and those of the drag on the orbiting rollers."""
    b, cage_factor = model.bearing, cage_constraint(model.cage, 1.0)
    R_mean = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        r = R_mean + y[lay.RADIAL + j]
        v = y[lay.RADIAL_V + j]
        theta_v = omega_cage + y[lay.EPS_V + j]
        mask = b.m_r * y[lay.INVERSE_MASS + j]
        drag, drag_v = orbit_drag(model.drag, r * theta_v), orbit_drag_derivative(model.drag, r * theta_v)
        coriolis, accelerance_r, accelerance_t = (
            cage_factor * mask * 2.0 / r,
            y[lay.ACCELERANCE_R + j],
            y[lay.ACCELERANCE_T + j],
        )
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, RADIAL, RADIAL) + j] += mask * theta_v * theta_v
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, RADIAL, ORBIT) + j] += accelerance_r * (
            y[lay.FORCE_T + j] - drag
        )
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, ORBIT, ORBIT) + j] -= accelerance_t * y[lay.FORCE_R + j]
        orbital_acceleration_r = (
            accelerance_t * (drag_v * theta_v - y[lay.FORCE_T + j] / r) + coriolis * v * theta_v / r
        )
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, ORBIT, RADIAL) + j] += orbital_acceleration_r
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, RADIAL, ORBIT) + j] += mask * 2.0 * r * theta_v
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, ORBIT, RADIAL) + j] -= coriolis * theta_v
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, ORBIT, ORBIT) + j] += accelerance_t * drag_v * r - coriolis * v


@jit
def add_support_terms(model, y):
    """Add the derivatives of the rings' supports and of the oil drag between cage and land."""
    support, m_o = model.support, model.bearing.m_o
    for k, K, C in (
        (lay.X, support.k_b / m_o, support.c_b / m_o),
        (lay.Y, support.k_b / m_o, support.c_b / m_o),
        (lay.PSI, spring_per_mass(model.bracket), damper_per_mass(model.bracket)),
        (lay.PHI_C, 0.0, -y[lay.ACCELERANCE_SHARED + lay.PHI_C] * land_drag_derivative(model.drag)),
        (lay.X_I, spring_per_mass(model.shaft), damper_per_mass(model.shaft)),
        (lay.Y_I, spring_per_mass(model.shaft), damper_per_mass(model.shaft)),
    ):
        y[lay.corner_block(lay.POSITION_JACOBIAN, k, k)] -= K
        y[lay.corner_block(lay.VELOCITY_JACOBIAN, k, k)] -= C


@jit
def fill_planar_jacobian(model, t, y):
    """Implement ``linearise`` for ``planar``, from the rows filled by ``accelerations``."""
    b = model.bearing
    n = lanes(b)
    _, rate, _ = kinematic_time(model.motion, t)
    omega_i, spin = b.omega_i * rate, (b.omega_c - b.omega_b) * rate
    omega_cage = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C]
    fill_accelerances(model, y, n)
    fill_contact_derivatives(OuterSide(), model.outer, y, n)
    fill_contact_derivatives(InnerSide(), model.inner, y, n)
    if len(model.defects.head) > 0:
        correct_derivatives_over_defects(OuterSide(), model.outer, model, t, omega_cage, omega_i, spin, y)
        correct_derivatives_over_defects(InnerSide(), model.inner, model, t, omega_cage, omega_i, spin, y)
    fill_friction_derivatives(OuterSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    fill_friction_derivatives(InnerSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    fill_pocket_derivatives(model.cage, model, omega_cage, spin, y, n)

    fill_roller_columns(model, omega_cage, omega_i, spin, y, n)
    fill_ring_columns(OuterSide(), y[lay.VELOCITY + lay.PSI], spin, b.m_r, lay.X, FIRST_CAGE, y, n)
    fill_ring_angle_columns(model, spin, y, n)
    fill_cage_columns(model, omega_cage, y, n)
    fill_ring_columns(InnerSide(), omega_i, spin, b.m_r, FIRST_INNER, SHARED_DOF, y, n)
    add_inertial_terms(model, omega_cage, y, n)
    add_guide_derivatives(model.cage, omega_cage, omega_i, y)
    add_support_terms(model, y)
