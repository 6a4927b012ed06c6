"""A model's derivatives, written out in full, beside central differences of its accelerations.

The accelerations are what ``start_at_rest`` leaves: the models' tests need that compiled anyway.
"""

from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.interface import degrees_of_freedom, linearise
from tests.scenes.lanes import compiled

ORBIT = 1  # a roller's coordinate that counts absolutely: its angle
MATRICES = ((lay.POSITION_JACOBIAN, lay.POSITION), (lay.VELOCITY_JACOBIAN, lay.VELOCITY))


@compiled
def compute_derivatives(model, t, y):
    linearise(model, t, y)


def cells(model: Any) -> np.ndarray:
    """Return the offsets of the model's coordinates in a block: the shared ones, then those of the rollers."""
    own, shared = degrees_of_freedom(model)
    rollers = [lay.FIRST_LANE + i * lay.ROW + j for i in range(own) for j in range(model.bearing.Z)]
    return np.array([lay.shared_cell(k) for k in range(shared)] + rollers)


def dense_matrix(model: Any, matrix: int, y: np.ndarray) -> np.ndarray:
    """An arrow as a dense matrix (N, N), in the order of ``cells``."""
    (own, shared), Z = degrees_of_freedom(model), model.bearing.Z
    dense = np.zeros((shared + own * Z, shared + own * Z))
    rows = [shared + i * Z + np.arange(Z) for i in range(own)]
    for k in range(shared):
        for m in range(shared):
            dense[k, m] = y[lay.corner_block(matrix, k, m)]
        for i in range(own):
            dense[rows[i], k] = y[lay.border_column(matrix, i, k) :][:Z]
            dense[k, rows[i]] = y[lay.border_row(matrix, k, i) :][:Z]
    for i in range(own):
        for m in range(own):
            dense[rows[i], rows[m]] = y[lay.diagonal_block(matrix, i, m) :][:Z]
    return dense


def derivatives(model: Any, t: float, y: np.ndarray) -> list[np.ndarray]:
    """d(acceleration)/d(position) and /d(velocity) (N, N) of the model."""
    y = y.copy()
    start_at_rest(model, t, y)
    y[lay.POSITION_JACOBIAN : lay.SYSTEM] = np.nan  # nothing may survive
    compute_derivatives(model, t, y)
    return [dense_matrix(model, matrix, y) for matrix, _ in MATRICES]


def absolute_values(model: Any, y: np.ndarray, block: int) -> np.ndarray:
    """Values (N,) of the model's coordinates in a block, rollers' angles counted absolutely."""
    (own, shared), Z = degrees_of_freedom(model), model.bearing.Z
    values = y[block + cells(model)]
    if own > ORBIT:
        values[shared + ORBIT * Z : shared + (ORBIT + 1) * Z] += y[block + lay.PHI_C]
    return values


def shift_coordinate(model: Any, y: np.ndarray, block: int, cell: int, shift: float) -> np.ndarray:
    """The buffer with one coordinate moved; rollers stay where they are while the cage turns."""
    y = y.copy()
    y[block + cell] += shift
    if cell == lay.PHI_C and degrees_of_freedom(model)[0] > ORBIT:
        eps = block + lay.FIRST_LANE + ORBIT * lay.ROW
        y[eps : eps + model.bearing.Z] -= shift
    return y


def differences(model: Any, t: float, y: np.ndarray, steps: tuple[np.ndarray, np.ndarray]) -> list[np.ndarray]:
    """The same by central differences of fourth order; ``steps``: of positions and of velocities, (N,) each."""
    matrices = []
    for (_, block), step_sizes in zip(MATRICES, steps, strict=True):
        columns = []
        for cell, h in zip(cells(model), step_sizes, strict=True):
            values = []
            for multiple in (-2.0, -1.0, 1.0, 2.0):
                shifted_buffer = shift_coordinate(model, y, block, cell, multiple * h)
                start_at_rest(model, t, shifted_buffer)
                values.append(absolute_values(model, shifted_buffer, lay.ACCELERATION))
            columns.append((8.0 * (values[2] - values[1]) - (values[3] - values[0])) / (12.0 * h))
        matrices.append(np.array(columns).T)
    return matrices
