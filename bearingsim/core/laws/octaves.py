"""Tables of a function of one positive number, by a cubic in each of 32 cells per octave.

The cell of a number follows from its bits, without logarithm or search. A table is a flat array of four
coefficients per cell, for powers of the distance from the cell's left end. Below FLOOR there is one cell from the
origin (where the function is 0); above CEILING the function is a straight line.
"""

from collections.abc import Callable

import numpy as np

from bearingsim.core.jit import jit

MIN_EXPONENT, MAX_EXPONENT = -36, -6  # of 2 at the ends of the table
CELL_BITS = 5  # leading bits of the significand that number the cells of an octave
CELLS_PER_OCTAVE = 1 << CELL_BITS
FLOOR, CEILING = 2.0**MIN_EXPONENT, 2.0**MAX_EXPONENT
COEFFICIENTS = 4  # per cell
_SHIFT = 52 - CELL_BITS  # bits of a double below those of its cell's index
_BELOW_FLOOR = ((1023 + MIN_EXPONENT) << CELL_BITS) - 1  # cell 0 extends from the origin to FLOOR
_LOWEST = float(np.nextafter(FLOOR, 0.0))  # its bits give cell 0


def tabulate(function: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Tabulate a function by cubic Hermite interpolation.

    function: returns values (n,) and derivatives (n,) at positions (n,).
    """
    octaves = 2.0 ** np.arange(MIN_EXPONENT, MAX_EXPONENT)
    y = np.append(np.outer(octaves, 1.0 + np.arange(CELLS_PER_OCTAVE) / CELLS_PER_OCTAVE).ravel(), CEILING)
    x, derivative = function(y)
    h, rise = np.diff(y), np.diff(x)
    second = (3.0 * rise / h - 2.0 * derivative[:-1] - derivative[1:]) / h
    third = (derivative[:-1] + derivative[1:] - 2.0 * rise / h) / h**2
    inner_cells = np.stack([x[:-1], derivative[:-1], second, third], axis=1)
    mean = x[0] / y[0]
    first_cell = [0.0, 2.0 * mean - derivative[0], (derivative[0] - mean) / y[0], 0.0]
    last_cell = [x[-1], derivative[-1], 0.0, 0.0]
    return np.vstack([first_cell, inner_cells, last_cell]).ravel()


@jit
def cell(y):
    """Return the index of the first coefficient of the cell of ``y``, and the distance of ``y`` from its left
    end."""
    limited = min(max(_LOWEST, y), CEILING)  # in this order NaN gets a valid cell and remains in the distance
    index = np.float64(limited).view(np.int64) >> _SHIFT
    left = np.int64(index << _SHIFT).view(np.float64)
    # only one conditional: with two, Numba on Python 3.13 creates branches, and the loop is not vectorised
    return COEFFICIENTS * (index - _BELOW_FLOOR), y - (0.0 if y < FLOOR else left)


@jit
def value(table, y):
    """Return the function at ``y`` >= 0."""
    k, s = cell(y)
    return table[k] + s * (table[k + 1] + s * (table[k + 2] + s * table[k + 3]))


@jit
def derivative(table, y):
    """Return the first derivative of ``value``."""
    k, s = cell(y)
    return table[k + 1] + s * (2.0 * table[k + 2] + s * (3.0 * table[k + 3]))


@jit
def second_derivative(table, y):
    """Return the second derivative of ``value``, slightly discontinuous between cells."""
    k, s = cell(y)
    return 2.0 * table[k + 2] + s * (6.0 * table[k + 3])
