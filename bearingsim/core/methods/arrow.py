"""Matrices of the arrow's shape: each roller couples to itself and to the border (rings and cage) only.

    | D_1             U_1 |  | x_1 |   | b_1 |      W_j = D_j^-1 U_j
    |      D_2        U_2 |  | x_2 |   | b_2 |      C = B - sum_j L_j W_j          (Schur complement)
    |           ...   ... |  | ... | = | ... |      C x_B = b_B - sum_j L_j D_j^-1 b_j
    | L_1  L_2  ...    B  |  | x_B |   | b_B |      x_j = D_j^-1 b_j - W_j x_B

so that factors and solution cost as much for each roller, however many there are. Rollers lie in lanes: what is
done to D_j is done to all rollers at once, operation by operation. Source: Golub and Van Loan, Matrix
Computations, sections 3.2 (LU), 4.5 (block systems); the shape is also called bordered block diagonal.

The D_j are factored without exchanging rows. They are I - beta A_v - alpha A_q of one body, near to symmetric
and positive definite once its rows are weighted by its masses, which is where that is safe; and, unlike the choice
of a pivot by size, it does not care that some rows are metres and some radians. The border's rows are exchanged,
by size over the largest in its row.

Matrices hold a roller's angle absolutely, theta = EPS + PHI_C; blocks of the state hold EPS. ``solve`` and
``multiply`` take blocks of the state and give such. In padded lanes D = 1, U = L = 0: they change nothing.
"""

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    BORDER_BLOCK,
    BY_POSITION,
    BY_VELOCITY,
    INVERSE_MASS,
    LANES,
    MOST_BORDER,
    PHI_C,
    ROW,
    SYSTEM,
    border_block,
    from_border,
    own_block,
    shared_cell,
    to_border,
)
from bearingsim.core.models.interface import freedoms, width

PIVOTS = (
    SYSTEM + BORDER_BLOCK + MOST_BORDER * MOST_BORDER
)  # behind the border's block: rows exchanged, their sizes


@jit
def rollers_wide(model):
    """Lanes in use by the model's rollers; 0 if they have no coordinates of their own."""
    own, _ = freedoms(model)
    return width(model) - max(own - 1, 0) * ROW - LANES


@jit
def turned_with(model):
    """Whether the cage turns the frame in which a roller's angle is kept."""
    own, shared = freedoms(model)
    return own > 1 and shared > PHI_C


# the matrix


@jit
def mix(to, of_velocity, of_position, alpha, beta, y, n):
    """One row of -beta A_v - alpha A_q."""
    made = y[to : to + n]
    by_velocity, by_position = y[of_velocity : of_velocity + n], y[of_position : of_position + n]
    for j in range(n):
        made[j] = -(beta * by_velocity[j] + alpha * by_position[j])


@jit
def combine(model, alpha, beta, y):
    """SYSTEM = I - beta A_v - alpha A_q; alpha in s^2, beta in s."""
    own, shared = freedoms(model)
    n = rollers_wide(model)
    for i in range(own):
        for k in range(own):
            row = own_block(0, i, k)
            mix(SYSTEM + row, BY_VELOCITY + row, BY_POSITION + row, alpha, beta, y, n)
        for k in range(shared):
            row = from_border(0, i, k)
            mix(SYSTEM + row, BY_VELOCITY + row, BY_POSITION + row, alpha, beta, y, n)
        for j in range(n):
            y[own_block(SYSTEM, i, i) + j] += 1.0
    for k in range(shared):
        for i in range(own):
            row = to_border(0, k, i)
            mix(SYSTEM + row, BY_VELOCITY + row, BY_POSITION + row, alpha, beta, y, n)
        row = border_block(0, k, 0)
        mix(SYSTEM + row, BY_VELOCITY + row, BY_POSITION + row, alpha, beta, y, shared)
        y[border_block(SYSTEM, k, k)] += 1.0


# its factors


@jit
def take_off(to, of, by, y, n):
    """One row less the product of two others."""
    left, one, other = y[to : to + n], y[of : of + n], y[by : by + n]
    for j in range(n):
        left[j] -= one[j] * other[j]


@jit
def factor(model, y):
    """Factor SYSTEM in place: D_j = L U (of U's diagonal the reciprocals), W_j over U_j, C = P L U over B."""
    own, shared = freedoms(model)
    n = rollers_wide(model)
    for p in range(own):
        pivot = own_block(SYSTEM, p, p)
        for j in range(n):
            y[pivot + j] = 1.0 / y[pivot + j]
        for i in range(p + 1, own):
            part = own_block(SYSTEM, i, p)
            for j in range(n):
                y[part + j] *= y[pivot + j]
            for k in range(p + 1, own):
                take_off(own_block(SYSTEM, i, k), part, own_block(SYSTEM, p, k), y, n)
    for k in range(shared):
        own_solve(own, from_border(SYSTEM, 0, k), MOST_BORDER * ROW, y, n)
    for k in range(shared):
        for m in range(shared):
            total = 0.0
            for j in range(n):
                part = 0.0
                for i in range(own):
                    part += y[to_border(SYSTEM, k, i) + j] * y[from_border(SYSTEM, i, m) + j]
                total = add(total, part)
            y[border_block(SYSTEM, k, m)] -= total
    factor_border(shared, y)


@jit
def own_solve(own, first, apart, y, n):
    """D_j^-1 of every roller on one column, in place: coordinate i in the row at ``first`` + i ``apart``."""
    for i in range(own):
        for k in range(i):
            take_off(first + i * apart, own_block(SYSTEM, i, k), first + k * apart, y, n)
    for back in range(own):
        i = own - 1 - back
        for k in range(i + 1, own):
            take_off(first + i * apart, own_block(SYSTEM, i, k), first + k * apart, y, n)
        pivot = own_block(SYSTEM, i, i)
        for j in range(n):
            y[first + i * apart + j] *= y[pivot + j]


@jit
def factor_border(shared, y):
    """LU of the border's block, rows exchanged by size over the largest entry that the row had."""
    for k in range(shared):
        largest = 0.0
        for m in range(shared):
            largest = max(largest, abs(y[border_block(SYSTEM, k, m)]))
        y[PIVOTS + MOST_BORDER + k] = 1.0 / max(largest, 1e-300)
    for p in range(shared):
        best, size = p, 0.0
        for k in range(p, shared):
            found = abs(y[border_block(SYSTEM, k, p)]) * y[PIVOTS + MOST_BORDER + k]
            if found > size:
                best, size = k, found
        y[PIVOTS + p] = best
        if best != p:
            swap(border_block(SYSTEM, p, 0), border_block(SYSTEM, best, 0), y, shared)
            swap(PIVOTS + MOST_BORDER + p, PIVOTS + MOST_BORDER + best, y, 1)
        for k in range(p + 1, shared):
            part = y[border_block(SYSTEM, k, p)] / y[border_block(SYSTEM, p, p)]
            y[border_block(SYSTEM, k, p)] = part
            for m in range(p + 1, shared):
                y[border_block(SYSTEM, k, m)] -= part * y[border_block(SYSTEM, p, m)]


@jit
def swap(one, other, y, n):
    """Exchange two stretches of the buffer."""
    for m in range(n):
        y[one + m], y[other + m] = y[other + m], y[one + m]


# its use


@jit
def to_absolute(model, block, sign, y):
    """Angles of a state block from their pockets' to absolute ones (``sign`` 1) or back (-1); no padded lanes."""
    turned = sign * y[block + PHI_C]
    for j in range(rollers_wide(model)):
        y[block + ROW + LANES + j] += turned if y[INVERSE_MASS + j] > 0.0 else 0.0


@jit
def solve(model, block, y):
    """x of SYSTEM x = b, in place on the state block that begins at ``block``; SYSTEM is factored."""
    own, shared = freedoms(model)
    n = rollers_wide(model)
    if turned_with(model):
        to_absolute(model, block, 1.0, y)
    own_solve(own, block + LANES, ROW, y, n)
    for k in range(shared):
        total = 0.0
        for j in range(n):
            part = 0.0
            for i in range(own):
                part += y[to_border(SYSTEM, k, i) + j] * y[block + i * ROW + LANES + j]
            total = add(total, part)
        y[block + shared_cell(k)] -= total
    solve_border(shared, block, y)
    for k in range(shared):
        moved = y[block + shared_cell(k)]
        for i in range(own):
            for j in range(n):
                y[block + i * ROW + LANES + j] -= y[from_border(SYSTEM, i, k) + j] * moved
    if turned_with(model):
        to_absolute(model, block, -1.0, y)


@jit
def solve_border(shared, block, y):
    """The border's own system, in place on the shared cells of ``block``."""
    for k in range(shared):
        best = shared_cell(int(y[PIVOTS + k]))
        here = shared_cell(k)
        y[block + here], y[block + best] = y[block + best], y[block + here]
    for k in range(shared):
        total = y[block + shared_cell(k)]
        for m in range(k):
            total -= y[border_block(SYSTEM, k, m)] * y[block + shared_cell(m)]
        y[block + shared_cell(k)] = total
    for back in range(shared):
        k = shared - 1 - back
        total = y[block + shared_cell(k)]
        for m in range(k + 1, shared):
            total -= y[border_block(SYSTEM, k, m)] * y[block + shared_cell(m)]
        y[block + shared_cell(k)] = total / y[border_block(SYSTEM, k, k)]


@jit
def multiply(model, matrix, source, target, y):
    """The state block at ``target`` = ``matrix`` (BY_POSITION, BY_VELOCITY) times the one at ``source``."""
    own, shared = freedoms(model)
    n = rollers_wide(model)
    turned = y[source + PHI_C] if turned_with(model) else 0.0
    for i in range(own):
        row = target + i * ROW + LANES
        for j in range(n):
            y[row + j] = 0.0
        for k in range(own):
            extra = turned if k == 1 else 0.0
            for j in range(n):
                y[row + j] += y[own_block(matrix, i, k) + j] * (y[source + k * ROW + LANES + j] + extra)
        for k in range(shared):
            moved = y[source + shared_cell(k)]
            for j in range(n):
                y[row + j] += y[from_border(matrix, i, k) + j] * moved
    for k in range(shared):
        total = 0.0
        for m in range(shared):
            total += y[border_block(matrix, k, m)] * y[source + shared_cell(m)]
        for i in range(own):
            extra = turned if i == 1 else 0.0
            for j in range(n):
                total = add(total, y[to_border(matrix, k, i) + j] * (y[source + i * ROW + LANES + j] + extra))
        y[target + shared_cell(k)] = total
    if turned_with(model):
        to_absolute(model, target, -1.0, y)
