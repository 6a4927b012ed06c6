"""Sums over rollers, bit-for-bit independent of the processor's vector width."""

from bearingsim.core import layout as lay
from bearingsim.core.jit import inlined


@inlined
def lane_sum(row, y, n):
    """Return the sum of the ``n`` lanes (a multiple of VECTOR_WIDTH) of the buffer's ``row``.

    Lane j is added to partial sum j mod 8. The eight partial sums are then added pairwise, in a fixed order.
    """
    a, b, c, d = y[row], y[row + 1], y[row + 2], y[row + 3]
    e, f, g, h = y[row + 4], y[row + 5], y[row + 6], y[row + 7]
    for j in range(lay.VECTOR_WIDTH, n, lay.VECTOR_WIDTH):
        a += y[row + j]
        b += y[row + j + 1]
        c += y[row + j + 2]
        d += y[row + j + 3]
        e += y[row + j + 4]
        f += y[row + j + 5]
        g += y[row + j + 6]
        h += y[row + j + 7]
    return ((a + e) + (c + g)) + ((b + f) + (d + h))


@inlined
def sum_addends(y, n):
    """Return the sum of the first ``n`` ADDENDS, after setting those up to the next multiple of VECTOR_WIDTH to
    0."""
    vectors = max((n + lay.VECTOR_WIDTH - 1) // lay.VECTOR_WIDTH, 1)  # `lane_sum` reads one vector even for n = 0
    n_lanes = vectors * lay.VECTOR_WIDTH
    for j in range(n, n_lanes):
        y[lay.ADDENDS + j] = 0.0
    return lane_sum(lay.ADDENDS, y, n_lanes)


@inlined
def sum_loads(first_cell, last_cell, y, n):
    """Fill the load cells ``first_cell`` to ``last_cell``, both included, with the sums of the rollers' loads."""
    for cell in range(first_cell, last_cell + 1):
        y[cell] = lane_sum(lay.roller_load(cell), y, n)
