"""``linearise`` of ``planar`` against differences of its accelerations, at states in which everything acts."""

import numpy as np
import pytest

from tests.differences import derivatives, differences
from tests.test_planar_balance import WAYS, WHERE, shaken

SHARED = 8
LENGTHS = (0, 1, 4, 5, 6, 7)  # shared coordinates that are lengths; of a roller's the first is


def steps(Z):
    """Steps of the differences: positions, and velocities (N,) each."""
    length = np.array([k in LENGTHS for k in range(SHARED)] + [True] * Z + [False] * 2 * Z)
    return np.where(length, 3e-11, 1e-9), np.where(length, 1e-7, 1e-6)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(4))
def test_derivatives_are_those_of_the_accelerations(way, seed):
    model, y = shaken(way, seed)
    model = model._replace(lag=0.0)
    found, expected = derivatives(model, WHERE, y), differences(model, WHERE, y, steps(model.bearing.Z))
    for one, other in zip(found, expected, strict=True):
        scale = np.abs(other).max(axis=1, keepdims=True) + 1e-300
        print(np.abs(one - other).max(axis=1) / scale[:, 0])
        assert np.abs(one - other).max() <= 1e-6 * np.abs(other).max()
