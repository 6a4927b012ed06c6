"""Arrow matrices (bordered block diagonal): each roller couples only to itself and to the border (rings and cage).

    | D_1             U_1 |  | x_1 |   | b_1 |      W_j = D_j^-1 U_j
    |      D_2        U_2 |  | x_2 |   | b_2 |      C = B - sum_j L_j W_j          (Schur complement)
    |           ...   ... |  | ... | = | ... |      C x_B = b_B - sum_j L_j D_j^-1 b_j
    | L_1  L_2  ...    B  |  | x_B |   | b_B |      x_j = D_j^-1 b_j - W_j x_B

D_j: block of roller j; L_j, U_j: its parts of the border; B: corner block. The cost of factorisation and solution
is proportional to the number of rollers. Each roller is a lane of a row, so each operation on D_j is vectorised
over all rollers. Source: Golub and Van Loan, Matrix Computations, sections 3.2 (LU), 4.5 (block systems).

The D_j are factored without pivoting. They are I - beta A_v - alpha A_q of one body, nearly symmetric and positive
definite if the rows are weighted by mass, so this is stable; unlike partial pivoting it is also independent of the
units of the rows (metres and radians). The corner block is factored with scaled partial pivoting.

The matrices refer to the absolute angle theta = EPS + PHI_C of a roller, blocks of the state contain EPS.
``solve`` and ``multiply`` accept and return blocks of the state. Padded lanes have D = 1, U = L = 0 and no effect.
"""

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.models.interface import degrees_of_freedom, state_width
from bearingsim.core.sums import sum_addends

# row exchanges and row scales, stored behind the corner block
PIVOTS = lay.SYSTEM + lay.CORNER_BLOCK + lay.MAX_SHARED * lay.MAX_SHARED


@jit
def roller_lanes(model):
    """Return the number of lanes used by the model's rollers; 0 if they have no coordinates of their own."""
    per_roller, _ = degrees_of_freedom(model)
    return state_width(model) - max(per_roller - 1, 0) * lay.ROW - lay.FIRST_LANE


@jit
def has_relative_angles(model):
    """Check if the angles of rollers are relative to the cage."""
    per_roller, shared = degrees_of_freedom(model)
    return per_roller > 1 and shared > lay.PHI_C


# Assembly


@jit
def combine_row(target, velocity_row, position_row, alpha, beta, y, n):
    """Store one row of -beta A_v - alpha A_q at ``target``."""
    row = y[target : target + n]
    A_v, A_q = y[velocity_row : velocity_row + n], y[position_row : position_row + n]
    for j in range(n):
        row[j] = -(beta * A_v[j] + alpha * A_q[j])


@jit
def assemble_system(model, alpha, beta, y):
    """Fill SYSTEM = I - beta A_v - alpha A_q; alpha in s^2, beta in s."""
    per_roller, shared = degrees_of_freedom(model)
    n = roller_lanes(model)
    for i in range(per_roller):
        for k in range(per_roller):
            row = lay.diagonal_block(0, i, k)
            combine_row(
                lay.SYSTEM + row, lay.VELOCITY_JACOBIAN + row, lay.POSITION_JACOBIAN + row, alpha, beta, y, n
            )
        for k in range(shared):
            row = lay.border_column(0, i, k)
            combine_row(
                lay.SYSTEM + row, lay.VELOCITY_JACOBIAN + row, lay.POSITION_JACOBIAN + row, alpha, beta, y, n
            )
        for j in range(n):
            y[lay.diagonal_block(lay.SYSTEM, i, i) + j] += 1.0
    for k in range(shared):
        for i in range(per_roller):
            row = lay.border_row(0, k, i)
            combine_row(
                lay.SYSTEM + row, lay.VELOCITY_JACOBIAN + row, lay.POSITION_JACOBIAN + row, alpha, beta, y, n
            )
        row = lay.corner_block(0, k, 0)
        combine_row(
            lay.SYSTEM + row, lay.VELOCITY_JACOBIAN + row, lay.POSITION_JACOBIAN + row, alpha, beta, y, shared
        )
        y[lay.corner_block(lay.SYSTEM, k, k)] += 1.0


# Factorisation


@jit
def subtract_product(target_row, left_row, right_row, y, n):
    """Subtract the elementwise product of two rows from a row."""
    target, left, right = y[target_row : target_row + n], y[left_row : left_row + n], y[right_row : right_row + n]
    for j in range(n):
        target[j] -= left[j] * right[j]


@jit
def factorise(model, y):
    """Factor SYSTEM in place: D_j = L U (reciprocals on U's diagonal), W_j replaces U_j, C = P L U replaces B."""
    per_roller, shared = degrees_of_freedom(model)
    n = roller_lanes(model)
    for p in range(per_roller):
        pivot = lay.diagonal_block(lay.SYSTEM, p, p)
        for j in range(n):
            y[pivot + j] = 1.0 / y[pivot + j]
        for i in range(p + 1, per_roller):
            factor_row = lay.diagonal_block(lay.SYSTEM, i, p)
            for j in range(n):
                y[factor_row + j] *= y[pivot + j]
            for k in range(p + 1, per_roller):
                subtract_product(
                    lay.diagonal_block(lay.SYSTEM, i, k), factor_row, lay.diagonal_block(lay.SYSTEM, p, k), y, n
                )
    for k in range(shared):
        solve_rollers(per_roller, lay.border_column(lay.SYSTEM, 0, k), lay.MAX_SHARED * lay.ROW, y, n)
    for k in range(shared):
        for m in range(shared):
            for j in range(n):
                product = 0.0
                for i in range(per_roller):
                    product += y[lay.border_row(lay.SYSTEM, k, i) + j] * y[lay.border_column(lay.SYSTEM, i, m) + j]
                y[lay.ADDENDS + j] = product
            y[lay.corner_block(lay.SYSTEM, k, m)] -= sum_addends(y, n)
    factor_corner(shared, y)


@jit
def solve_rollers(per_roller, column, stride, y, n):
    """Apply D_j^-1 of every roller to one column, in place.

    Coordinate i of the rollers is in the row at ``column`` + i ``stride``.
    """
    for i in range(per_roller):
        for k in range(i):
            subtract_product(column + i * stride, lay.diagonal_block(lay.SYSTEM, i, k), column + k * stride, y, n)
    for m in range(per_roller):
        i = per_roller - 1 - m
        for k in range(i + 1, per_roller):
            subtract_product(column + i * stride, lay.diagonal_block(lay.SYSTEM, i, k), column + k * stride, y, n)
        pivot = lay.diagonal_block(lay.SYSTEM, i, i)
        for j in range(n):
            y[column + i * stride + j] *= y[pivot + j]


@jit
def factor_corner(shared, y):
    """Factor the corner block by LU with scaled partial pivoting."""
    for k in range(shared):
        largest = 0.0
        for m in range(shared):
            largest = max(largest, abs(y[lay.corner_block(lay.SYSTEM, k, m)]))
        y[PIVOTS + lay.MAX_SHARED + k] = 1.0 / max(largest, 1e-300)
    for p in range(shared):
        pivot, largest_ratio = p, 0.0
        for k in range(p, shared):
            candidate = abs(y[lay.corner_block(lay.SYSTEM, k, p)]) * y[PIVOTS + lay.MAX_SHARED + k]
            if candidate > largest_ratio:
                pivot, largest_ratio = k, candidate
        y[PIVOTS + p] = pivot
        if pivot != p:
            swap(lay.corner_block(lay.SYSTEM, p, 0), lay.corner_block(lay.SYSTEM, pivot, 0), y, shared)
            swap(PIVOTS + lay.MAX_SHARED + p, PIVOTS + lay.MAX_SHARED + pivot, y, 1)
        for k in range(p + 1, shared):
            factor = y[lay.corner_block(lay.SYSTEM, k, p)] / y[lay.corner_block(lay.SYSTEM, p, p)]
            y[lay.corner_block(lay.SYSTEM, k, p)] = factor
            for m in range(p + 1, shared):
                y[lay.corner_block(lay.SYSTEM, k, m)] -= factor * y[lay.corner_block(lay.SYSTEM, p, m)]


@jit
def swap(a, b, y, n):
    """Exchange the ranges of ``n`` entries at ``a`` and ``b``."""
    for m in range(n):
        y[a + m], y[b + m] = y[b + m], y[a + m]


# Solution


@jit
def convert_angles(model, block, sign, y):
    """Convert the angles of a block of the state from relative to absolute (``sign`` 1) or back (-1), except in
    padded lanes."""
    cage_angle = sign * y[block + lay.PHI_C]
    for j in range(roller_lanes(model)):
        y[block + lay.ROW + lay.FIRST_LANE + j] += cage_angle if y[lay.INVERSE_MASS + j] > 0.0 else 0.0


@jit
def solve(model, block, y):
    """Solve SYSTEM x = b in place on the block of the state at ``block``; SYSTEM must be factored."""
    per_roller, shared = degrees_of_freedom(model)
    n = roller_lanes(model)
    if has_relative_angles(model):
        convert_angles(model, block, 1.0, y)
    solve_rollers(per_roller, block + lay.FIRST_LANE, lay.ROW, y, n)
    for k in range(shared):
        for j in range(n):
            product = 0.0
            for i in range(per_roller):
                product += y[lay.border_row(lay.SYSTEM, k, i) + j] * y[block + i * lay.ROW + lay.FIRST_LANE + j]
            y[lay.ADDENDS + j] = product
        y[block + lay.shared_cell(k)] -= sum_addends(y, n)
    solve_corner(shared, block, y)
    for k in range(shared):
        x_k = y[block + lay.shared_cell(k)]
        for i in range(per_roller):
            for j in range(n):
                y[block + i * lay.ROW + lay.FIRST_LANE + j] -= y[lay.border_column(lay.SYSTEM, i, k) + j] * x_k
    if has_relative_angles(model):
        convert_angles(model, block, -1.0, y)


@jit
def solve_corner(shared, block, y):
    """Solve with the factored corner block, in place, on the shared cells of ``block``."""
    for k in range(shared):
        pivot = lay.shared_cell(int(y[PIVOTS + k]))
        cell = lay.shared_cell(k)
        y[block + cell], y[block + pivot] = y[block + pivot], y[block + cell]
    for k in range(shared):
        total = y[block + lay.shared_cell(k)]
        for m in range(k):
            total -= y[lay.corner_block(lay.SYSTEM, k, m)] * y[block + lay.shared_cell(m)]
        y[block + lay.shared_cell(k)] = total
    for n in range(shared):
        k = shared - 1 - n
        total = y[block + lay.shared_cell(k)]
        for m in range(k + 1, shared):
            total -= y[lay.corner_block(lay.SYSTEM, k, m)] * y[block + lay.shared_cell(m)]
        y[block + lay.shared_cell(k)] = total / y[lay.corner_block(lay.SYSTEM, k, k)]


@jit
def multiply(model, matrix, source, target, y):
    """Set the block of the state at ``target`` to ``matrix`` times the block at ``source``.

    matrix: POSITION_JACOBIAN or VELOCITY_JACOBIAN.
    """
    per_roller, shared = degrees_of_freedom(model)
    n = roller_lanes(model)
    cage_angle = y[source + lay.PHI_C] if has_relative_angles(model) else 0.0
    for i in range(per_roller):
        row = target + i * lay.ROW + lay.FIRST_LANE
        for j in range(n):
            y[row + j] = 0.0
        for k in range(per_roller):
            shift = cage_angle if k == 1 else 0.0
            for j in range(n):
                y[row + j] += y[lay.diagonal_block(matrix, i, k) + j] * (
                    y[source + k * lay.ROW + lay.FIRST_LANE + j] + shift
                )
        for k in range(shared):
            x_k = y[source + lay.shared_cell(k)]
            for j in range(n):
                y[row + j] += y[lay.border_column(matrix, i, k) + j] * x_k
    for k in range(shared):
        total = 0.0
        for m in range(shared):
            total += y[lay.corner_block(matrix, k, m)] * y[source + lay.shared_cell(m)]
        for j in range(n):
            product = 0.0
            for i in range(per_roller):
                shift = cage_angle if i == 1 else 0.0
                x = y[source + i * lay.ROW + lay.FIRST_LANE + j] + shift
                product += y[lay.border_row(matrix, k, i) + j] * x
            y[lay.ADDENDS + j] = product
        y[target + lay.shared_cell(k)] = total + sum_addends(y, n)
    if has_relative_angles(model):
        convert_angles(model, target, -1.0, y)
