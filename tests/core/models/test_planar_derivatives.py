"""``linearise`` of ``planar`` against differences of its accelerations, at states with all effects."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from tests.core.models.test_planar_balance import BALANCE_TIME, SETUPS, random_contact_state, random_state
from tests.scenes.differences import derivatives, differences
from tests.scenes.nf308 import case

SHARED = [[0, 1], [2], [3], [4, 5], [6, 7]]  # ring, its angle, cage's angle, its centre, inner ring
LENGTHS = [0, 1, 4, 5, 6, 7]
EDGES = {setup: {"excitation": "elastic-edge" if setup == "on rollers" else "envelope"} for setup in SETUPS}
"""Excitation of each setup: both kinds of edges, but one per setup, to compile each once."""


def coordinate_groups(Z):
    """Return groups of coordinates of one kind, for all rollers together: lists of indices."""
    return [*SHARED, *(list(range(8 + i * Z, 8 + (i + 1) * Z)) for i in range(3))]


def steps(Z):
    """Return the steps of position and velocity (N,); with a fifth of these, rounding dominates."""
    length = np.array([k in LENGTHS for k in range(8)] + [True] * Z + [False] * 2 * Z)
    return np.where(length, 1.5e-10, 5e-9), np.where(length, 1e-6, 1e-5)


def assert_derivatives_agree(model, y):
    """Compare every block of two groups: to 1e-5 of its largest entry, or 1e-9 of its rows."""
    Z = model.bearing.Z
    result, expected = derivatives(model, BALANCE_TIME, y), differences(model, BALANCE_TIME, y, steps(Z))
    for value, reference in zip(result, expected, strict=True):
        for rows in coordinate_groups(Z):
            row = np.abs(reference[rows]).max()
            for columns in coordinate_groups(Z):
                block = np.ix_(rows, columns)
                assert np.abs(value - reference)[block].max() <= 1e-5 * np.abs(reference[block]).max() + 1e-9 * row


@pytest.mark.parametrize("setup", [name for name, fields in SETUPS.items() if "surfaces" not in fields])
@pytest.mark.parametrize("seed", range(6))
def test_derivatives_are_those_of_the_accelerations(setup, seed):
    """Contacts open and closed, defects of races and of a roller, traction, every guide, drag, shaft, bracket.

    On rollers the defects' edges are elastic: load share and drop at a defect both change along it. Surfaces with
    form have no derivatives, and implicit methods are refused there.
    """
    model, y = random_contact_state(setup, seed, **EDGES[setup])
    assert_derivatives_agree(model._replace(lag=0.0), y)


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_with_a_kinematic_cage_and_fixed_rings(seed):
    """Rows of fixed coordinates are zero."""
    model = assemble.model(case(model="planar", cage={"motion": "kinematic"}, friction="none", load="150 N"))
    y = random_state(model, seed)
    start_at_rest(model, BALANCE_TIME, y)
    assert_derivatives_agree(model._replace(lag=0.0), y)
    by_position, by_velocity = derivatives(model, BALANCE_TIME, y)
    fixed = [2, 3, 4, 5, 6, 7, *range(8 + 13, 8 + 39)]
    assert np.abs(by_position[fixed]).max() == 0.0
    assert np.abs(by_velocity[fixed]).max() == 0.0


def test_padded_lanes_are_zero():
    """13 rollers in 16 lanes, as in the solution of the arrow matrix."""
    model, y = random_contact_state("on rollers", 0, **EDGES["on rollers"])
    padded = derivatives(model._replace(bearing=model.bearing._replace(Z=2 * lay.VECTOR_WIDTH)), BALANCE_TIME, y)
    assert np.abs(y[lay.INVERSE_MASS + 13 : lay.INVERSE_MASS + 16]).max() == 0.0
    for matrix in padded:
        for j in (13, 14, 15):
            lanes = [8 + i * 16 + j for i in range(3)]
            assert np.abs(matrix[lanes]).max() == 0.0
            assert np.abs(matrix[:, lanes]).max() == 0.0
