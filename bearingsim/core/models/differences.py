"""Jacobians by finite differences of the accelerations, with one coordinate of all rollers displaced at a time.

The acceleration of a roller depends only on its own and the shared coordinates. One evaluation with the same
coordinate of all rollers displaced therefore gives a column for every roller; the effect of each roller on rings
and cage follows from its loads on them (Curtis, Powell and Reid 1974, On the estimation of sparse Jacobian
matrices, J. Inst. Maths Applics 13, 117). Forward differences have an error of first order, below 1e-5 for all
derivatives (tested). The column of a coordinate that cannot move is left empty, which saves its evaluation.
"""

from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.jit import generic, jit
from bearingsim.core.models.interface import accelerations, degrees_of_freedom
from bearingsim.core.parameters import lanes
from bearingsim.core.sums import lane_sum


@jit
def shared_arms(b):
    """Return the lever arms (m) of angles among the shared coordinates, 1 for positions; b: the bearing.

    The order is that of ``layout.shared_cell``.
    """
    R_mean = 0.5 * (b.R_o + b.R_i)
    planar_arms = (1.0, 1.0, b.R_o, R_mean, 1.0, 1.0, 1.0, 1.0)
    return (*planar_arms, 1.0, 1.0, 1.0, b.R_o, R_mean, b.R_i, b.R_o, R_mean, b.R_i)


@jit
def roller_arms(b):
    """Return the lever arms (m) of angles among a roller's six coordinates, 1 for positions; b: the bearing."""
    return 1.0, 0.5 * (b.R_o + b.R_i), b.R_w, 1.0, b.R_w, b.R_w


# increments of positions (m) and velocities (m/s), at the lever arm for angles: the first is small against
# approaches and large against their rounding errors
POSITION_INCREMENT, VELOCITY_INCREMENT = 2e-11, 1e-7
ORBIT = 1  # coordinate of a roller that is an absolute angle in the arrow matrices


@generic
def is_free_coordinate(model: Any, i: int) -> bool:
    """Check if coordinate ``i`` of a roller is free."""


@generic
def accelerate_bodies(model: Any, t: float, y: Any) -> None:
    """Write the accelerations of the shared coordinates from the cells F_X to M_INNER, which may be overwritten.

    ``accelerations`` of such a model also fills the rows ROLLER_LOADS, each roller's contribution to these cells.
    """


@jit
def clear_arrows(roller_dof, shared_dof, y, n):
    """Set both arrow matrices to zero."""
    for matrix in (lay.POSITION_JACOBIAN, lay.VELOCITY_JACOBIAN):
        for i in range(roller_dof):
            for k in range(roller_dof):
                for j in range(n):
                    y[lay.diagonal_block(matrix, i, k) + j] = 0.0
            for k in range(shared_dof):
                for j in range(n):
                    y[lay.border_column(matrix, i, k) + j] = 0.0
                    y[lay.border_row(matrix, k, i) + j] = 0.0
        for k in range(shared_dof):
            for m in range(shared_dof):
                y[lay.corner_block(matrix, k, m)] = 0.0


@jit
def store_state(roller_dof, model, y):
    """Store the state at which derivatives are computed, with absolute orbital accelerations, and the rollers'
    loads."""
    for c in range(3 * lay.STATE):
        y[lay.REFERENCE_STATE + c] = y[lay.POSITION + c]
    for j in range(model.bearing.Z):
        y[lay.REFERENCE_STATE + lay.EPS_A + j] += y[lay.ACCELERATION + lay.PHI_C] if roller_dof > ORBIT else 0.0
    for c in range(lay.LOADS):
        row = lay.roller_load(lay.F_X + c)
        for j in range(model.bearing.Z):
            y[row + lay.REFERENCE_ROLLER_LOADS - lay.ROLLER_LOADS + j] = y[row + j]
        y[lay.REFERENCE_LOADS + c] = lane_sum(row, y, lanes(model.bearing))


@jit
def load_bodies(model, t, y, j, scale):
    """Compute the shared accelerations under the stored loads plus ``scale`` times the change of roller ``j``'s
    loads.

    They are affine in the loads, so with ``scale`` = 1/displacement their difference from the stored accelerations
    is the derivative.
    """
    for c in range(lay.LOADS):
        row = lay.roller_load(lay.F_X + c) + j
        change = y[row] - y[row + lay.REFERENCE_ROLLER_LOADS - lay.ROLLER_LOADS]
        y[lay.F_X + c] = y[lay.REFERENCE_LOADS + c] + scale * change
    accelerate_bodies(model, t, y)


@jit
def fill_roller_column(model, t, matrix, i, roller_dof, shared_dof, y, cell):
    """Fill the column of coordinate ``i`` of every roller; the state is displaced in the row at ``cell``."""
    Z = model.bearing.Z
    accelerations(model, t, y)
    for k in range(roller_dof):
        alpha_cage = y[lay.ACCELERATION + lay.PHI_C] if k == ORBIT else 0.0
        row = lay.ACCELERATION + k * lay.ROW + lay.FIRST_LANE
        for j in range(Z):
            change = y[row + j] + alpha_cage - y[lay.REFERENCE_STATE + row + j]
            y[lay.diagonal_block(matrix, k, i) + j] = change / (y[cell + j] - y[lay.REFERENCE_STATE + cell + j])
    for j in range(Z):
        load_bodies(model, t, y, j, 1.0 / (y[cell + j] - y[lay.REFERENCE_STATE + cell + j]))
        for k in range(shared_dof):
            acceleration = lay.ACCELERATION + lay.shared_cell(k)
            y[lay.border_row(matrix, k, i) + j] = y[acceleration] - y[lay.REFERENCE_STATE + acceleration]


@jit
def fill_shared_column(model, t, matrix, m, roller_dof, shared_dof, y, cell):
    """Fill the column of the shared coordinate ``m``; the state is displaced in ``cell``."""
    scale = 1.0 / (y[cell] - y[lay.REFERENCE_STATE + cell])
    accelerations(model, t, y)
    for k in range(roller_dof):
        alpha_cage = y[lay.ACCELERATION + lay.PHI_C] if k == ORBIT else 0.0
        row = lay.ACCELERATION + k * lay.ROW + lay.FIRST_LANE
        for j in range(model.bearing.Z):
            y[lay.border_column(matrix, k, m) + j] = scale * (
                y[row + j] + alpha_cage - y[lay.REFERENCE_STATE + row + j]
            )
    for k in range(shared_dof):
        acceleration = lay.ACCELERATION + lay.shared_cell(k)
        y[lay.corner_block(matrix, k, m)] = scale * (y[acceleration] - y[lay.REFERENCE_STATE + acceleration])


@jit
def displace_shared(roller_dof, Z, block, m, displacement, y):
    """Displace the shared coordinate ``m``; the absolute angles of the rollers do not change with the cage's."""
    y[block + lay.shared_cell(m)] += displacement
    if m == lay.PHI_C and roller_dof > ORBIT:
        angle = y[block + lay.PHI_C] - y[lay.REFERENCE_STATE + block + lay.PHI_C]
        for j in range(Z):
            y[block + ORBIT * lay.ROW + lay.FIRST_LANE + j] -= angle


@jit
def restore_state(block, y):
    """Restore a block of the stored state after a displacement."""
    for c in range(lay.STATE):
        y[block + c] = y[lay.REFERENCE_STATE + block + c]


@jit
def fill_difference_jacobian(model, t, y):
    """Implement ``linearise`` by finite differences."""
    roller_dof, shared_dof = degrees_of_freedom(model)
    b = model.bearing
    clear_arrows(roller_dof, shared_dof, y, lanes(b))
    store_state(roller_dof, model, y)
    roller_arm, shared_arm = roller_arms(b), shared_arms(b)
    for c in range(lay.LOADS):
        y[lay.F_X + c] = y[lay.REFERENCE_LOADS + c] + 1.0
    accelerate_bodies(model, t, y)
    for k in range(shared_dof):  # mark the coordinates that unit loads accelerate: only these can move
        coordinate = lay.shared_cell(k)
        y[lay.REFERENCE_LOADS + lay.LOADS + k] = (
            1.0
            if y[lay.ACCELERATION + coordinate] != y[lay.REFERENCE_STATE + lay.ACCELERATION + coordinate]
            else 0.0
        )
    for matrix, block, increment in (
        (lay.POSITION_JACOBIAN, lay.POSITION, POSITION_INCREMENT),
        (lay.VELOCITY_JACOBIAN, lay.VELOCITY, VELOCITY_INCREMENT),
    ):
        for i in range(roller_dof):
            if is_free_coordinate(model, i):
                cell = block + i * lay.ROW + lay.FIRST_LANE
                for j in range(b.Z):
                    y[cell + j] += increment / roller_arm[i]
                fill_roller_column(model, t, matrix, i, roller_dof, shared_dof, y, cell)
                restore_state(block, y)
        for m in range(shared_dof):
            if y[lay.REFERENCE_LOADS + lay.LOADS + m] > 0.0:
                displace_shared(roller_dof, b.Z, block, m, increment / shared_arm[m], y)
                fill_shared_column(model, t, matrix, m, roller_dof, shared_dof, y, block + lay.shared_cell(m))
                restore_state(block, y)
    accelerations(model, t, y)
