"""Arrows of any size for the tests: a model that is nothing but its size, and the same matrix, dense."""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.models.interface import degrees_of_freedom, state_width


class ArrowModel(NamedTuple):
    """A model of ``Z`` rollers with ``own`` coordinates each and ``shared`` of the border, known at run time."""

    own: int
    shared: int
    Z: int


@state_width.register(ArrowModel)
def _state_width(model):
    lanes = (model.Z + lay.VECTOR_WIDTH - 1) // lay.VECTOR_WIDTH * lay.VECTOR_WIDTH
    return lay.FIRST_LANE if model.own == 0 else (model.own - 1) * lay.ROW + lay.FIRST_LANE + lanes


@degrees_of_freedom.register(ArrowModel)
def _degrees_of_freedom(model):
    return model.own, model.shared


def cells(model: ArrowModel, block: int = 0) -> np.ndarray:
    """Return the offsets of the coordinates in a block, in the dense matrix's order: rollers, then border."""
    rollers = [block + i * lay.ROW + lay.FIRST_LANE + j for j in range(model.Z) for i in range(model.own)]
    return np.array(rollers + [block + lay.shared_cell(k) for k in range(model.shared)])


def arrow_cells(model: ArrowModel, matrix: int) -> np.ndarray:
    """Return the cells of the dense matrix's entries in the arrow at ``matrix``; -1 outside the arrow."""
    own, shared, Z = model
    N = own * Z
    cells_ = np.full((N + shared, N + shared), -1)
    for j in range(Z):
        rows = slice(own * j, own * (j + 1))
        cells_[rows, rows] = [[lay.diagonal_block(matrix, i, k) + j for k in range(own)] for i in range(own)]
        if own:
            cells_[rows, N:] = [[lay.border_column(matrix, i, k) + j for k in range(shared)] for i in range(own)]
            cells_[N:, rows] = [[lay.border_row(matrix, k, i) + j for i in range(own)] for k in range(shared)]
    cells_[N:, N:] = [[lay.corner_block(matrix, k, m) for m in range(shared)] for k in range(shared)]
    return cells_


def fill(model: ArrowModel, matrix: int, scatter: float | np.ndarray, y: np.ndarray) -> np.ndarray:
    """Put random entries in the arrow at ``matrix``; the same, dense. scatter: () or (n, n), their size."""
    cells_ = arrow_cells(model, matrix)
    size = np.broadcast_to(scatter, cells_.shape)
    dense = np.where(cells_ >= 0, size * RANDOM.standard_normal(cells_.shape), 0.0)
    y[cells_[cells_ >= 0]] = dense[cells_ >= 0]
    return dense


RANDOM = np.random.default_rng(5)


def cage_transform(model: ArrowModel) -> np.ndarray:
    """T of x_absolute = T x: each roller's angle is counted from where the cage has turned to."""
    T = np.eye(model.own * model.Z + model.shared)
    if model.own > 1 and model.shared > lay.PHI_C:
        T[1 : model.own * model.Z : model.own, model.own * model.Z + lay.PHI_C] = 1.0
    return T


def random_arrows(
    model: ArrowModel, scatter: float | np.ndarray = 0.2
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A buffer with random derivatives, and these dense, in the coordinates of the state."""
    y = lay.make_buffer(model.Z, 1.0)
    T = cage_transform(model)
    by_position = np.linalg.solve(T, fill(model, lay.POSITION_JACOBIAN, scatter, y) @ T)
    by_velocity = np.linalg.solve(T, fill(model, lay.VELOCITY_JACOBIAN, scatter, y) @ T)
    return y, by_position, by_velocity


def spring_arrow(model: ArrowModel, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A buffer with -M^-1 sum_j k_j n_j n_j^T in POSITION_JACOBIAN, springs (Z, s) from each roller to the border.

    And this, dense. In absolute angles. The units of coordinates, and with them M, differ by up to 1e6.
    """
    own, shared, Z = model
    y, size = lay.make_buffer(Z, 1.0), own * Z + shared
    units = 10.0 ** RANDOM.uniform(-3, 3, size)
    dense = np.zeros((size, size))
    for j, stiffness in enumerate(k):
        indices = np.r_[own * j : own * (j + 1), own * Z : size]
        for stiffness_ in stiffness:
            n = RANDOM.standard_normal(len(indices)) * units[indices]
            dense[np.ix_(indices, indices)] -= stiffness_ * np.outer(n, n) / units[indices, np.newaxis] ** 2
    cells_ = arrow_cells(model, lay.POSITION_JACOBIAN)
    y[cells_[cells_ >= 0]] = dense[cells_ >= 0]
    return y, dense


def unused_cells(model: ArrowModel, block: int) -> np.ndarray:
    """Cells of a state block that belong to no coordinate."""
    return np.setdiff1d(np.arange(block, block + lay.STATE), cells(model, block))
