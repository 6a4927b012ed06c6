"""A model's derivatives by differences of its accelerations, each coordinate of all rollers at once.

A roller feels itself and the shared coordinates only. So one evaluation, with the same coordinate of all rollers
displaced, gives a column of every roller; what each of them does to rings and cage follows from its own loads on
them (Curtis, Powell and Reid 1974, On the estimation of sparse Jacobian matrices, J. Inst. Maths Applics 13, 117).
Differences go forward, so their error is of first order: under 1e-5 of all derivatives (a test). A coordinate that
nothing accelerates stands still: its column is left empty, and saves its evaluation.
"""

from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.jit import add, generic, jit
from bearingsim.core.models.arms import roller_arms, shared_arms
from bearingsim.core.models.interface import accelerations, degrees_of_freedom
from bearingsim.core.parameters import lanes

DISPLACEMENT = 2e-11  # m, at the arm of an angle: small beside any approach, large beside its rounding
SPEED = 1e-7  # m/s
ORBIT = 1  # the coordinate of a roller that the arrow counts absolutely


@generic
def roller_moves(model: Any, i: int) -> bool:
    """Check if coordinate ``i`` of a roller is free."""


@generic
def accelerate_bodies(model: Any, t: float, y: Any) -> None:
    """Write the accelerations of the shared coordinates from the cells F_X to M_INNER; it may spend them.

    Beside it, ``accelerations`` of such a model fills the rows ROLLER_LOADS: what each roller adds to these cells.
    """


@jit
def clear_arrows(own, shared, y, n):
    """Empty both arrows."""
    for matrix in (lay.POSITION_JACOBIAN, lay.VELOCITY_JACOBIAN):
        for i in range(own):
            for k in range(own):
                for j in range(n):
                    y[lay.diagonal_block(matrix, i, k) + j] = 0.0
            for k in range(shared):
                for j in range(n):
                    y[lay.border_column(matrix, i, k) + j] = 0.0
                    y[lay.border_row(matrix, k, i) + j] = 0.0
        for k in range(shared):
            for m in range(shared):
                y[lay.corner_block(matrix, k, m)] = 0.0


@jit
def keep_here(own, model, y):
    """Keep the state about which differences are taken, accelerations absolute, and the rollers' loads there."""
    for c in range(3 * lay.STATE):
        y[lay.HERE + c] = y[lay.POSITION + c]
    for j in range(model.bearing.Z):
        y[lay.HERE + lay.EPS_A + j] += y[lay.ACCELERATION + lay.PHI_C] if own > ORBIT else 0.0
    for c in range(lay.LOADS):
        row, total = lay.roller_load(lay.F_X + c), 0.0
        for j in range(model.bearing.Z):
            y[row + lay.ROLLER_LOADS_HERE - lay.ROLLER_LOADS + j] = y[row + j]
            total = add(total, y[row + j])
        y[lay.LOADS_HERE + c] = total


@jit
def load_bodies(model, t, y, j, per):
    """Put the shared accelerations into the state: under the loads here and ``per`` times roller ``j``'s change.

    They are affine in the loads: ``per`` = 1/displacement gives the derivative, beyond the accelerations here.
    """
    for c in range(lay.LOADS):
        row = lay.roller_load(lay.F_X + c) + j
        change = y[row] - y[row + lay.ROLLER_LOADS_HERE - lay.ROLLER_LOADS]
        y[lay.F_X + c] = y[lay.LOADS_HERE + c] + per * change
    accelerate_bodies(model, t, y)


@jit
def roller_column(model, t, matrix, i, own, shared, y, cell):
    """Compute the column of coordinate ``i`` of every roller, displaced in the row at ``cell`` of the state."""
    Z = model.bearing.Z
    accelerations(model, t, y)
    for k in range(own):
        turned = y[lay.ACCELERATION + lay.PHI_C] if k == ORBIT else 0.0
        row = lay.ACCELERATION + k * lay.ROW + lay.FIRST_LANE
        for j in range(Z):
            change = y[row + j] + turned - y[lay.HERE + row + j]
            y[lay.diagonal_block(matrix, k, i) + j] = change / (y[cell + j] - y[lay.HERE + cell + j])
    for j in range(Z):
        load_bodies(model, t, y, j, 1.0 / (y[cell + j] - y[lay.HERE + cell + j]))
        for k in range(shared):
            acceleration = lay.ACCELERATION + lay.shared_cell(k)
            y[lay.border_row(matrix, k, i) + j] = y[acceleration] - y[lay.HERE + acceleration]


@jit
def shared_column(model, t, matrix, m, own, shared, y, cell):
    """Compute the column of the shared coordinate ``m``, displaced in ``cell`` of the state."""
    per = 1.0 / (y[cell] - y[lay.HERE + cell])
    accelerations(model, t, y)
    for k in range(own):
        turned = y[lay.ACCELERATION + lay.PHI_C] if k == ORBIT else 0.0
        row = lay.ACCELERATION + k * lay.ROW + lay.FIRST_LANE
        for j in range(model.bearing.Z):
            y[lay.border_column(matrix, k, m) + j] = per * (y[row + j] + turned - y[lay.HERE + row + j])
    for k in range(shared):
        acceleration = lay.ACCELERATION + lay.shared_cell(k)
        y[lay.corner_block(matrix, k, m)] = per * (y[acceleration] - y[lay.HERE + acceleration])


@jit
def move_shared(own, Z, block, m, by, y):
    """Displace the shared coordinate ``m``; rollers stay where they are while the cage turns."""
    y[block + lay.shared_cell(m)] += by
    if m == lay.PHI_C and own > ORBIT:
        turned = y[block + lay.PHI_C] - y[lay.HERE + block + lay.PHI_C]
        for j in range(Z):
            y[block + ORBIT * lay.ROW + lay.FIRST_LANE + j] -= turned


@jit
def return_here(block, y):
    """Undo a displacement."""
    for c in range(lay.STATE):
        y[block + c] = y[lay.HERE + block + c]


@jit
def difference_jacobian(model, t, y):
    """Implement ``linearise`` by differences."""
    own, shared = degrees_of_freedom(model)
    b = model.bearing
    clear_arrows(own, shared, y, lanes(b))
    keep_here(own, model, y)
    by_roller, by_shared = roller_arms(b), shared_arms(b)
    for c in range(lay.LOADS):
        y[lay.F_X + c] = y[lay.LOADS_HERE + c] + 1.0
    accelerate_bodies(model, t, y)
    for k in range(shared):  # marked where a load accelerates it
        coordinate = lay.shared_cell(k)
        y[lay.LOADS_HERE + lay.LOADS + k] = (
            1.0 if y[lay.ACCELERATION + coordinate] != y[lay.HERE + lay.ACCELERATION + coordinate] else 0.0
        )
    for matrix, block, size in (
        (lay.POSITION_JACOBIAN, lay.POSITION, DISPLACEMENT),
        (lay.VELOCITY_JACOBIAN, lay.VELOCITY, SPEED),
    ):
        for i in range(own):
            if roller_moves(model, i):
                cell = block + i * lay.ROW + lay.FIRST_LANE
                for j in range(b.Z):
                    y[cell + j] += size / by_roller[i]
                roller_column(model, t, matrix, i, own, shared, y, cell)
                return_here(block, y)
        for m in range(shared):
            if y[lay.LOADS_HERE + lay.LOADS + m] > 0.0:
                move_shared(own, b.Z, block, m, size / by_shared[m], y)
                shared_column(model, t, matrix, m, own, shared, y, block + lay.shared_cell(m))
                return_here(block, y)
    accelerations(model, t, y)
