"""Factors by which the coordinates of a state become comparable lengths and speeds."""

from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.models.interface import harmonics, state_width


def lengths(model: Any) -> np.ndarray:
    """Return the factors (2 STATE,), m or 1, that turn positions and velocities into lengths and speeds.

    A roller's rotation grows without end and counts by its speed alone; entries that are no state of the model get
    0.
    """
    cells = np.full((2, 6, lay.ROW), model.bearing.R_o)
    cells[:, 0, lay.FIRST_LANE :] = 1.0
    cells[:, 3] = 1.0
    cells[:, 0, [lay.X, lay.Y, lay.X_C, lay.Y_C, lay.X_I, lay.Y_I]] = 1.0
    cells[0, 2, lay.FIRST_LANE :] = 0.0
    if harmonics(model) > 0:  # lengths, where other models have the rollers' angles
        cells[:, 1:3] = 1.0
    cells.reshape(2, -1)[:, state_width(model) :] = 0.0
    return cells.ravel()
