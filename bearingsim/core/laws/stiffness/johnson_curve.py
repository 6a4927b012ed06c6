"""Line contact in reduced form: one curve for all radii, lengths and materials, tabulated once.

Johnson's approach of two cylinders under the force Q' per length (m, N/m)

    delta = Q'/(pi E*) [ln(4 pi E* dR/Q') - 1]

reads, with x = Q'/(4 pi E* dR) and y = delta/(4 dR),

    y = -x (ln x + 1),    dy/dx = -(ln x + 2)

so x(y) is a single function of one number. It cannot be written out, and a logarithm inside a loop over rollers
would cost its vector lanes: so it is tabulated (``laws/octaves.py``). x is continuous with its slope, and the
slope given is that of the interpolant.

Relative error of x below 1e-9, of the slope below 1e-6, for 2^-36 <= y <= 2^-6. Below, where 1/ln y tends to
zero too slowly to matter, a parabola through the origin; above, a straight line. The formula itself ends at
y = e^-2 = 0.135 (x = e^-2), where the stiffness it gives is infinite.
"""

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.laws.octaves import bend, slope, tabulate, value


def exact(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x and dx/dy at each ``y``: Newton on w - ln w = -1 - ln y, where w = y/x = -(ln x + 1) > 1."""
    right = -1.0 - np.log(y)
    w = right + np.log(right)
    for _ in range(8):
        w -= (w - np.log(w) - right) / (1.0 - 1.0 / w)
    return y / w, 1.0 / (w - 1.0)


TABLE = tabulate(exact)


@jit
def reduced_force(y):
    """Return x(y): force over 4 pi E* dR L at the approach ``y`` >= 0 over 4 dR."""
    return value(TABLE, y)


@jit
def reduced_slope(y):
    """Return dx/dy, the derivative of ``reduced_force``."""
    return slope(TABLE, y)


@jit
def reduced_curvature(y):
    """Return d2x/dy2, the derivative of ``reduced_slope``, slightly discontinuous between cells."""
    return bend(TABLE, y)
