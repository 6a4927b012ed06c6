"""``linearise`` of ``planar`` against differences of its accelerations, at states in which everything acts."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from tests.core.models.test_planar_balance import WAYS, WHERE, random_state, shaken
from tests.scenes.differences import derivatives, differences
from tests.scenes.nf308 import case

SHARED = [[0, 1], [2], [3], [4, 5], [6, 7]]  # ring, its angle, cage's angle, its centre, inner ring
LENGTHS = [0, 1, 4, 5, 6, 7]
EDGES = {way: {"excitation": "elastic-edge" if way == "on rollers" else "envelope"} for way in WAYS}
"""Both kinds of edges, but each model with one of them: what is compiled for it is compiled once."""


def kinds(Z):
    """Coordinates of one kind, of all rollers together: lists of places among all."""
    return [*SHARED, *(list(range(8 + i * Z, 8 + (i + 1) * Z)) for i in range(3))]


def steps(Z):
    """Steps of the differences: positions, and velocities (N,) each. With a fifth of these, rounding shows."""
    length = np.array([k in LENGTHS for k in range(8)] + [True] * Z + [False] * 2 * Z)
    return np.where(length, 1.5e-10, 5e-9), np.where(length, 1e-6, 1e-5)


def agree(model, y):
    """Every block, of a kind of acceleration by a kind of coordinate: to 1e-5 of itself, or 1e-9 of its row."""
    Z = model.bearing.Z
    found, expected = derivatives(model, WHERE, y), differences(model, WHERE, y, steps(Z))
    for one, other in zip(found, expected, strict=True):
        for rows in kinds(Z):
            row = np.abs(other[rows]).max()
            for columns in kinds(Z):
                block = np.ix_(rows, columns)
                assert np.abs(one - other)[block].max() <= 1e-5 * np.abs(other[block]).max() + 1e-9 * row


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(6))
def test_derivatives_are_those_of_the_accelerations(way, seed):
    """Contacts open and closed, defects of races and of a roller, traction, every guide, drag, shaft, bracket.

    On rollers the defects' edges are elastic: share and sinking of a defect both change along it.
    """
    model, y = shaken(way, seed, **EDGES[way])
    agree(model._replace(lag=0.0), y)


@pytest.mark.parametrize("seed", range(3))
def test_of_a_kinematic_cage_and_rings_that_are_held(seed):
    """Rows of what does not move are zero, and remain so."""
    model = assemble.model(case(model="planar", cage={"motion": "kinematic"}, friction="none", load="150 N"))
    y = random_state(model, seed)
    start_at_rest(model, WHERE, y)
    agree(model._replace(lag=0.0), y)
    by_position, by_velocity = derivatives(model, WHERE, y)
    still = [2, 3, 4, 5, 6, 7, *range(8 + 13, 8 + 39)]
    assert np.abs(by_position[still]).max() == 0.0
    assert np.abs(by_velocity[still]).max() == 0.0


def test_padded_lanes_are_zero():
    """13 rollers in 16 lanes: where the arrow is solved, they are there."""
    model, y = shaken("on rollers", 0, **EDGES["on rollers"])
    padded = derivatives(model._replace(bearing=model.bearing._replace(Z=2 * lay.VECTOR_WIDTH)), WHERE, y)
    assert np.abs(y[lay.INVERSE_MASS + 13 : lay.INVERSE_MASS + 16]).max() == 0.0
    for full in padded:
        for j in (13, 14, 15):
            lanes = [8 + i * 16 + j for i in range(3)]
            assert np.abs(full[lanes]).max() == 0.0
            assert np.abs(full[:, lanes]).max() == 0.0
