"""Analytic derivatives of the accelerations of ``planar``, column by column.

A column contains the changes per unit of one coordinate: the same coordinate of all rollers at once (a roller
depends only on its own and the shared coordinates), or one shared coordinate. The changes of the rollers'
positions and velocities relative to the touched body are written to the rows D_POSITION and D_VELOCITY, from which
``parts/races.py`` and ``parts/cage_derivatives.py`` compute the changes of the forces. Terms from the rotation of
e_r and e_theta with the roller, its inertial terms and the springs of the shared coordinates are added at the end.

Friction is not lagged (``laws/friction/lag.py``), because implicit methods use no lag.
"""

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.jit import jit
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.cage import cage_constraint, orbit_drag
from bearingsim.core.parts.cage_derivatives import (
    cage_mobility,
    guide_change,
    land_drag_derivative,
    orbit_drag_derivative,
    pocket_change,
    pocket_derivatives,
)
from bearingsim.core.parts.races import (
    contact_derivatives,
    derivatives_over_defects,
    friction_derivatives,
    race_change,
)
from bearingsim.core.parts.shaft import damper_per_mass, mobility, spring_per_mass
from bearingsim.core.sums import sum_addends

RADIAL, ORBIT, SPIN = range(3)  # a roller's coordinates
SHARED = 8
CAGE, INNER = 3, 6  # first shared coordinates of the cage and of the inner ring


@jit
def clear_changes(low, high, y, n):
    """Clear all displacements and changes of force, including shared coordinates range(low, high)."""
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
def mobilities(model, y, n):
    """Fill the rows MOBILITY_*: inverse masses and inverse moments of inertia of rollers and shared bodies."""
    b, cage, m_o = model.bearing, model.cage, model.bearing.m_o
    R_mean, cage_factor = 0.5 * (b.R_o + b.R_i), cage_constraint(cage, 1.0)
    for j in range(n):
        per_mass = y[lay.INVERSE_MASS + j]
        y[lay.MOBILITY_R + j], y[lay.MOBILITY_T + j] = (
            per_mass,
            cage_factor * per_mass / (R_mean + y[lay.RADIAL + j]),
        )
        y[lay.MOBILITY_SPIN + j] = cage_factor * (b.m_r / b.I_r) * per_mass
    cage_rotation, cage_translation = cage_mobility(cage)
    y[lay.MOBILITY_SHARED + lay.X], y[lay.MOBILITY_SHARED + lay.Y], y[lay.MOBILITY_SHARED + lay.PSI] = (
        1.0 / m_o,
        1.0 / m_o,
        mobility(model.bracket),
    )
    y[lay.MOBILITY_SHARED + lay.PHI_C] = cage_rotation
    y[lay.MOBILITY_SHARED + lay.X_C] = cage_translation
    y[lay.MOBILITY_SHARED + lay.Y_C] = cage_translation
    y[lay.MOBILITY_SHARED + lay.X_I], y[lay.MOBILITY_SHARED + lay.Y_I] = (
        mobility(model.shaft),
        mobility(model.shaft),
    )


@jit
def write_roller_column(matrix, i, m_r, y, n):
    """Write the changes of acceleration into the column of the rollers' coordinate ``i``."""
    for j in range(n):
        y[lay.diagonal_block(matrix, RADIAL, i) + j] = y[lay.MOBILITY_R + j] * y[lay.D_FORCE_R + j]
    for j in range(n):
        y[lay.diagonal_block(matrix, ORBIT, i) + j] = y[lay.MOBILITY_T + j] * y[lay.D_FORCE_T + j]
    for j in range(n):
        y[lay.diagonal_block(matrix, SPIN, i) + j] = y[lay.MOBILITY_SPIN + j] * y[lay.D_TORQUE + j]
    for k in range(SHARED):
        scale = m_r * y[lay.MOBILITY_SHARED + k]  # times the inverse mass, which is 0 in a padded lane
        for j in range(n):
            y[lay.border_row(matrix, k, i) + j] = (
                scale * y[lay.INVERSE_MASS + j] * y[lay.D_FORCE_SHARED + k * lay.ROW + j]
            )


@jit
def write_shared_column(matrix, m, low, high, m_r, y, n):
    """Write the changes of acceleration into the column of the shared coordinate ``m``.

    low, high: the shared coordinates range(low, high) depend on it.
    """
    for j in range(n):
        y[lay.border_column(matrix, RADIAL, m) + j] = y[lay.MOBILITY_R + j] * y[lay.D_FORCE_R + j]
    for j in range(n):
        y[lay.border_column(matrix, ORBIT, m) + j] = y[lay.MOBILITY_T + j] * y[lay.D_FORCE_T + j]
    for j in range(n):
        y[lay.border_column(matrix, SPIN, m) + j] = y[lay.MOBILITY_SPIN + j] * y[lay.D_TORQUE + j]
    for k in range(SHARED):
        y[lay.corner_block(matrix, k, m)] = 0.0
    for k in range(low, high):
        for j in range(n):
            y[lay.ADDENDS + j] = y[lay.INVERSE_MASS + j] * y[lay.D_FORCE_SHARED + k * lay.ROW + j]
        y[lay.corner_block(matrix, k, m)] = m_r * y[lay.MOBILITY_SHARED + k] * sum_addends(y, n)


@jit
def displace_rollers(i, position, speed, R_mean, omega_cage, y, n):
    """Displace every roller's coordinate ``i`` by ``position`` (m, rad), its rate by ``speed`` (m/s, rad/s).

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
    """Displace a body along e_0 (axis 0) or e_90 (1) by ``position`` (m), ``speed`` (m/s); fill the displacements
    of the rollers relative to it."""
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
def add_roller_columns(model, omega_cage, omega_i, spin, y, n):
    """Fill the columns of the rollers' own coordinates and velocities."""
    b, ring_v = model.bearing, y[lay.VELOCITY + lay.PSI]
    R_mean = 0.5 * (b.R_o + b.R_i)
    for i in range(3):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            roll, roll_v = (position, speed) if i == SPIN else (0.0, 0.0)
            orbit_v = speed if i == ORBIT else 0.0
            clear_changes(0, SHARED, y, n)
            displace_rollers(i, position, speed, R_mean, omega_cage, y, n)
            race_change(OuterSide(), spin, ring_v, roll, roll_v, orbit_v, 0.0, 0.0, y, n)
            race_change(InnerSide(), spin, omega_i, roll, roll_v, orbit_v, 0.0, 0.0, y, n)
            pocket_change(model.cage, b.R_w, omega_cage, roll_v, 0.0, 0.0, y, n)
            write_roller_column(matrix, i, b.m_r, y, n)


@jit
def add_ring_columns(side, omega_ring, spin, m_r, low, high, y, n):
    """Fill the columns of a ring's centre; its shared coordinates are range(low, high)."""
    for axis in range(2):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            clear_changes(low, high, y, n)
            displace_body(axis, position, speed, y, n)
            race_change(side, spin, omega_ring, 0.0, 0.0, 0.0, 0.0, 0.0, y, n)
            write_shared_column(matrix, low + axis, low, high, m_r, y, n)


@jit
def add_ring_angle_column(model, spin, y, n):
    """Fill the columns of the outer ring's angle, with which its defects rotate, and of its speed."""
    for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
        clear_changes(lay.X, CAGE, y, n)
        race_change(OuterSide(), spin, y[lay.VELOCITY + lay.PSI], 0.0, 0.0, 0.0, position, speed, y, n)
        write_shared_column(matrix, lay.PSI, lay.X, CAGE, model.bearing.m_r, y, n)


@jit
def add_cage_columns(model, omega_cage, y, n):
    """Fill the columns of the cage's angle and centre, in the order of its shared coordinates."""
    for k in range(CAGE, INNER):
        for matrix, position, speed in ((lay.POSITION_JACOBIAN, 1.0, 0.0), (lay.VELOCITY_JACOBIAN, 0.0, 1.0)):
            turn, turn_v = (position, speed) if k == lay.PHI_C else (0.0, 0.0)
            clear_changes(CAGE, INNER, y, n)
            if k != lay.PHI_C:
                displace_body(k - lay.X_C, position, speed, y, n)
            pocket_change(model.cage, model.bearing.R_w, omega_cage, 0.0, turn, turn_v, y, n)
            write_shared_column(matrix, k, CAGE, INNER, model.bearing.m_r, y, n)


@jit
def add_inertial_terms(model, omega_cage, y, n):
    """Add the terms of rotating directions and of inertia in q'' = r theta'^2 + F_r/m and
    theta'' = (F_t/m - 2 q' theta')/r."""
    b, cage_factor = model.bearing, cage_constraint(model.cage, 1.0)
    R_mean = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        r = R_mean + y[lay.RADIAL + j]
        v = y[lay.RADIAL_V + j]
        theta_v = omega_cage + y[lay.EPS_V + j]
        mask = b.m_r * y[lay.INVERSE_MASS + j]
        drag, derivative = orbit_drag(model.drag, r * theta_v), orbit_drag_derivative(model.drag, r * theta_v)
        coriolis, per_r, per_t = cage_factor * mask * 2.0 / r, y[lay.MOBILITY_R + j], y[lay.MOBILITY_T + j]
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, RADIAL, RADIAL) + j] += mask * theta_v * theta_v
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, RADIAL, ORBIT) + j] += per_r * (y[lay.FORCE_T + j] - drag)
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, ORBIT, ORBIT) + j] -= per_t * y[lay.FORCE_R + j]
        derivative_t = per_t * (derivative * theta_v - y[lay.FORCE_T + j] / r) + coriolis * v * theta_v / r
        y[lay.diagonal_block(lay.POSITION_JACOBIAN, ORBIT, RADIAL) + j] += derivative_t
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, RADIAL, ORBIT) + j] += mask * 2.0 * r * theta_v
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, ORBIT, RADIAL) + j] -= coriolis * theta_v
        y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, ORBIT, ORBIT) + j] += per_t * derivative * r - coriolis * v


@jit
def add_support_terms(model, y):
    """Add the derivatives of the rings' supports, and of the oil between cage and land."""
    support, m_o = model.support, model.bearing.m_o
    for k, K, C in (
        (lay.X, support.k_b / m_o, support.c_b / m_o),
        (lay.Y, support.k_b / m_o, support.c_b / m_o),
        (lay.PSI, spring_per_mass(model.bracket), damper_per_mass(model.bracket)),
        (lay.PHI_C, 0.0, -y[lay.MOBILITY_SHARED + lay.PHI_C] * land_drag_derivative(model.drag)),
        (lay.X_I, spring_per_mass(model.shaft), damper_per_mass(model.shaft)),
        (lay.Y_I, spring_per_mass(model.shaft), damper_per_mass(model.shaft)),
    ):
        y[lay.corner_block(lay.POSITION_JACOBIAN, k, k)] -= K
        y[lay.corner_block(lay.VELOCITY_JACOBIAN, k, k)] -= C


@jit
def planar_jacobian(model, t, y):
    """Implement ``linearise`` for ``planar``, from the rows filled by ``accelerations``."""
    b = model.bearing
    n = lanes(b)
    _, rate, _ = kinematic_time(model.motion, t)
    omega_i, spin = b.omega_i * rate, (b.omega_c - b.omega_b) * rate
    omega_cage = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C]
    mobilities(model, y, n)
    contact_derivatives(OuterSide(), model.outer, y, n)
    contact_derivatives(InnerSide(), model.inner, y, n)
    if len(model.defects.head) > 0:
        derivatives_over_defects(OuterSide(), model.outer, model, t, omega_cage, omega_i, spin, y)
        derivatives_over_defects(InnerSide(), model.inner, model, t, omega_cage, omega_i, spin, y)
    friction_derivatives(OuterSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    friction_derivatives(InnerSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    pocket_derivatives(model.cage, model, omega_cage, spin, y, n)

    add_roller_columns(model, omega_cage, omega_i, spin, y, n)
    add_ring_columns(OuterSide(), y[lay.VELOCITY + lay.PSI], spin, b.m_r, lay.X, CAGE, y, n)
    add_ring_angle_column(model, spin, y, n)
    add_cage_columns(model, omega_cage, y, n)
    add_ring_columns(InnerSide(), omega_i, spin, b.m_r, INNER, SHARED, y, n)
    add_inertial_terms(model, omega_cage, y, n)
    guide_change(model.cage, omega_cage, omega_i, y)
    add_support_terms(model, y)
