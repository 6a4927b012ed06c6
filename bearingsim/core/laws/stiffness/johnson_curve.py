"""Line contact in reduced form: one curve for all radii, lengths and materials, tabulated once.

Johnson's approach of two cylinders under the force Q' per length (m, N/m)

    delta = Q'/(pi E*) [ln(4 pi E* dR/Q') - 1]

reads, with x = Q'/(4 pi E* dR) and y = delta/(4 dR),

    y = -x (ln x + 1),    dy/dx = -(ln x + 2)

so x(y) is a single function of one number. It cannot be written out, and a logarithm inside a loop over rollers
would cost its vector lanes: so x is a cubic Hermite interpolant on a grid of 32 cells to the octave, whose cell is
read off the exponent bits of y. x is continuous with its slope, and the slope given is that of the interpolant.

Relative error of x below 1e-9, of the slope below 1e-6, for 2^-36 <= y <= 2^-6. Below, where 1/ln y tends to
zero too slowly to matter, a parabola through the origin; above, a straight line. The formula itself ends at
y = e^-2 = 0.135 (x = e^-2), where the stiffness it gives is infinite.
"""

import numpy as np

from bearingsim.core.jit import jit

FIRST, LAST = -36, -6  # octaves of the table
CELL_BITS = 5
CELLS = 1 << CELL_BITS  # to an octave
FLOOR, CEILING = 2.0**FIRST, 2.0**LAST
COEFFICIENTS = 4
_SHIFT = 52 - CELL_BITS  # bits of a double below those that name its cell
_BELOW_FLOOR = ((1023 + FIRST) << CELL_BITS) - 1  # cell 0 reaches from the origin to FLOOR


def exact(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x and dx/dy at each ``y``: Newton on w - ln w = -1 - ln y, where w = y/x = -(ln x + 1) > 1."""
    right = -1.0 - np.log(y)
    w = right + np.log(right)
    for _ in range(8):
        w -= (w - np.log(w) - right) / (1.0 - 1.0 / w)
    return y / w, 1.0 / (w - 1.0)


def tabulate() -> np.ndarray:
    """Coefficients of x - in powers of the distance from the cell's left end - of all cells in turn, flat."""
    octaves = 2.0 ** np.arange(FIRST, LAST)
    y = np.append(np.outer(octaves, 1.0 + np.arange(CELLS) / CELLS).ravel(), CEILING)
    x, slope = exact(y)
    h, rise = np.diff(y), np.diff(x)
    second = (3.0 * rise / h - 2.0 * slope[:-1] - slope[1:]) / h
    third = (slope[:-1] + slope[1:] - 2.0 * rise / h) / h**2
    inside = np.stack([x[:-1], slope[:-1], second, third], axis=1)
    mean = x[0] / y[0]
    first = [0.0, 2.0 * mean - slope[0], (slope[0] - mean) / y[0], 0.0]
    last = [x[-1], slope[-1], 0.0, 0.0]
    return np.vstack([first, inside, last]).ravel()


TABLE = tabulate()


@jit
def cell(y):
    """Where the coefficients of the cell of ``y`` begin, and the distance of ``y`` from the cell's left end."""
    inside = min(max(FLOOR, y), CEILING)  # in this order NaN finds a cell, and stays in the distance
    number = np.float64(inside).view(np.int64) >> _SHIFT
    left = np.int64(number << _SHIFT).view(np.float64)
    low = y < FLOOR
    first = 0 if low else COEFFICIENTS * (number - _BELOW_FLOOR)
    return first, y - (0.0 if low else left)


@jit
def reduced_force(y):
    """x(y): force over 4 pi E* dR L at the approach ``y`` >= 0 over 4 dR."""
    k, s = cell(y)
    return TABLE[k] + s * (TABLE[k + 1] + s * (TABLE[k + 2] + s * TABLE[k + 3]))


@jit
def reduced_slope(y):
    """dx/dy, the slope of ``reduced_force``."""
    k, s = cell(y)
    return TABLE[k + 1] + s * (2.0 * TABLE[k + 2] + s * (3.0 * TABLE[k + 3]))


@jit
def reduced_curvature(y):
    """d2x/dy2, the slope of ``reduced_slope``; it jumps a little from cell to cell."""
    k, s = cell(y)
    return 2.0 * TABLE[k + 2] + s * (6.0 * TABLE[k + 3])
