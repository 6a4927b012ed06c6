"""Motion of the rings within rounding errors, which counts as zero (bounds: ``rounding_bounds.py``)."""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay

PEAK_TO_PEAK = 6.0  # of a motion within rounding, relative to the bound of its RMS: three standard deviations
NEGLIGIBLE = 1e-5
"""Fraction of the RMS below which rounding is left out of comparisons: every error bound of a step contains it
(``step_check.FIXED_STEP_BOUNDS``)."""
RING_CENTRES = (lay.X, lay.Y, lay.X_I, lay.Y_I)
SENSOR_CELLS = (lay.SENSOR, lay.SENSOR_V, lay.SENSOR_A)


class Rounding(NamedTuple):
    """Largest RMS of a motion due to rounding: displacement (m), velocity (m/s), acceleration (m/s^2)."""

    displacement: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0

    def plus(self, other: "Rounding") -> "Rounding":
        """Return the bounds of the difference of two motions."""
        return Rounding(*(a + b for a, b in zip(self, other, strict=True)))

    def of_cells(self, cells: np.ndarray) -> np.ndarray:
        """Return the bound (C,) of each recorded cell (C,): 0 for cells other than the motion of rings."""
        bounds = np.zeros(len(cells))
        for block, sensor_cell, bound in zip(lay.BLOCKS, SENSOR_CELLS, self, strict=True):
            bounds[np.isin(cells, [*(block + cell for cell in RING_CENTRES), sensor_cell])] = bound
        return bounds


NO_ROUNDING = Rounding()


def notable(bound: float, scale: float) -> float:
    """Return the bound of an error due to rounding, 0 if it is ``NEGLIGIBLE`` relative to ``scale``.

    bound, scale: in the same unit.
    """
    return bound if bound > NEGLIGIBLE * scale else 0.0
