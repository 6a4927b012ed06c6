"""``linearise`` of ``spatial`` against differences of its accelerations, at states in which everything acts."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from tests.core.models.test_spatial_balance import STATES, WAYS, WHERE, shaken
from tests.scenes.differences import derivatives, differences
from tests.scenes.nf308 import case
from tests.scenes.spatial_bearing import L_W

LENGTHS = [0, 1, 4, 5, 6, 7, 8, 9, 10]


def steps(Z):
    """Steps of the differences: positions, and velocities (N,) each."""
    length = [k in LENGTHS for k in range(17)] + [True] * Z + [False] * 2 * Z + [True] * Z + [False] * 2 * Z
    return np.where(length, 3e-11, 1e-9), np.where(length, 1e-7, 1e-6)


def arms(b):
    """Metres per unit of each coordinate (N,): where what it turns is touched."""
    r = 0.5 * (b.R_o + b.R_i)
    shared = [1.0, 1.0, b.R_o, r, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, *[b.R_o, r, b.R_i] * 2]
    return np.array(shared + [s for s in (1.0, r, b.R_w, 1.0, L_W / 2, L_W / 2) for _ in range(b.Z)])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("lean", "own"), STATES)
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_the_accelerations(way, lean, own, seed):
    """Pits, flanges, pockets, rings on springs, traction; all lengths in metres at the arms of the turns.

    By velocity to 1e-6 of the whole; by position to 5e-5, or 5e-4 where axes lean by 2 mrad (at forces a hundred
    times those of a load: what is left out are forces over radii), and every row that is not small to 1 %.
    """
    model, y = shaken(way, seed, lean, own)
    model = model._replace(lag=0.0)
    arm = arms(model.bearing)
    found, expected = derivatives(model, WHERE, y), differences(model, WHERE, y, steps(model.bearing.Z))
    for one, other, bound in zip(found, expected, (5e-5 if lean < 1e-3 else 5e-4, 1e-6), strict=True):
        errors, full = ((matrix * arm[:, None] / arm) for matrix in (one - other, other))
        assert np.linalg.norm(errors) <= bound * np.linalg.norm(full)
        rows = np.linalg.norm(full, axis=1)
        assert np.all(np.linalg.norm(errors, axis=1) <= 1e-2 * rows + 1e-6 * rows.max())


def test_of_a_kinematic_cage_nothing_is_left_out():
    """To 1e-7: rings held, axes that lean by 0.1 mrad. But for columns of angles, which the cage keeps."""
    given = case(model="spatial", cage={"motion": "kinematic"})
    model = assemble.model(given)
    y, _ = assemble.start(given, model)
    random, Z = np.random.default_rng(0), model.bearing.Z
    for row, size in ((lay.RADIAL, 3e-7), (lay.RADIAL_V, 1e-3), (lay.AXIS_X, 1e-4), (lay.AXIS_Y, 1e-4)):
        y[row : row + Z] += random.normal(0.0, size, Z)
    start_at_rest(model, 0.0, y)
    model = model._replace(lag=0.0)
    found, expected = derivatives(model, 0.0, y), differences(model, 0.0, y, steps(Z))
    angles = np.arange(17 + Z, 17 + 2 * Z)
    arm = arms(model.bearing)
    for one, other in zip(found, expected, strict=True):
        errors, full = (np.delete(matrix * arm[:, None] / arm, angles, axis=1) for matrix in (one - other, other))
        assert np.linalg.norm(errors) <= 1e-7 * np.linalg.norm(full)
        assert np.abs(one[17 + Z : 17 + 4 * Z]).max() == 0.0
