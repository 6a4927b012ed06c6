"""Algebra of arrow matrices against NumPy's dense matrices."""

from itertools import product

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core.methods.arrow import assemble_system, factorise, multiply, solve
from tests.scenes.arrows import (
    RANDOM,
    ArrowModel,
    cage_transform,
    cells,
    random_arrows,
    spring_arrow,
    unused_cells,
)

SIZES = [
    ArrowModel(own, shared, Z)
    for own, shared, Z in product((0, 1, 3, 6), (2, 8, 17), (3, 8, 13, 104))
    if own or Z == 13
]
B, C = lay.STAGE, lay.STAGE + lay.STATE  # blocks of the state that the tests work on


def size_id(model):
    return f"{model.own}x{model.Z}+{model.shared}"


def right_hand_side(model, y):
    b = RANDOM.standard_normal(len(cells(model)))
    y[cells(model, B)] = b
    return b


@pytest.mark.parametrize("model", SIZES, ids=size_id)
def test_solve_equals_dense_solution(model):
    y, A_q, A_v = random_arrows(model, 0.2 / np.sqrt(model.Z))
    b = right_hand_side(model, y)
    assemble_system(model, 0.7, 0.9, y)
    factorise(model, y)
    solve(model, B, y)
    S = np.eye(len(b)) - 0.9 * A_v - 0.7 * A_q
    expected = np.linalg.solve(S, b)
    assert np.linalg.norm(y[cells(model, B)] - expected) <= 1e-12 * np.linalg.norm(expected)
    assert not y[unused_cells(model, B)].any()


@pytest.mark.parametrize("model", SIZES, ids=size_id)
def test_backward_error_of_solve_with_springs_up_to_1e16(model):
    """Contacts give the matrix a condition number of 1e16 and more, here with units from 1e-3 to 1e3."""
    y, A_q = spring_arrow(model, 10.0 ** RANDOM.uniform(0, 16, (model.Z, 4)))
    T = cage_transform(model)
    b = right_hand_side(model, y)
    assemble_system(model, 1.0, 0.0, y)
    factorise(model, y)
    solve(model, B, y)
    S, x = np.eye(len(b)) - A_q, T @ y[cells(model, B)]
    backward = np.abs(S @ x - T @ b) / (np.abs(S) @ np.abs(x) + np.abs(T) @ np.abs(b))
    assert backward.max() < 1e-12


@pytest.mark.parametrize("model", SIZES, ids=size_id)
@pytest.mark.parametrize("matrix", [lay.POSITION_JACOBIAN, lay.VELOCITY_JACOBIAN])
def test_multiply_equals_dense_product(model, matrix):
    y, A_q, A_v = random_arrows(model)
    b = right_hand_side(model, y)
    multiply(model, matrix, B, C, y)
    expected = (A_q if matrix == lay.POSITION_JACOBIAN else A_v) @ b
    assert np.linalg.norm(y[cells(model, C)] - expected) <= 1e-13 * np.linalg.norm(expected) * np.sqrt(len(b))
    assert np.array_equal(y[cells(model, B)], b)
    assert not y[unused_cells(model, C)].any()
