"""``linearise`` of ``spatial`` against differences of its accelerations, at states in which everything acts."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.parts.flanges import NoFlanges
from tests.core.models.test_spatial_balance import STATES, WAYS, WHERE, shaken
from tests.scenes.differences import derivatives, differences
from tests.scenes.nf308 import case
from tests.scenes.spatial_bearing import L_W, empty, even_slices, spatial_model

KINEMATIC = {"motion": "kinematic"}
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


def compared(model, t, y):
    """What ``linearise`` finds less what it should find, and that, in metres: columns of all that can move."""
    arm = arms(model.bearing)
    found, expected = derivatives(model, t, y), differences(model, t, y, steps(model.bearing.Z))
    moves = np.any(expected[0] != 0.0, axis=1) | np.any(expected[1] != 0.0, axis=1)
    for one, other in zip(found, expected, strict=True):
        yield [(matrix * arm[:, None] / arm)[:, moves] for matrix in (one - other, other)]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("lean", "own"), STATES)
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_the_accelerations(way, lean, own, seed):
    """Defects, flanges, pockets, rings on springs, traction; all lengths in metres at the arms of the turns.

    To 1e-5 of the whole, and every row that is not small to 1e-4: differences go forward.
    """
    model, y = shaken(way, seed, lean, own)
    for errors, full in compared(model._replace(lag=0.0), WHERE, y):
        assert np.linalg.norm(errors) <= 1e-5 * np.linalg.norm(full)
        rows = np.linalg.norm(full, axis=1)
        assert np.all(np.linalg.norm(errors, axis=1) <= 1e-4 * rows + 1e-7 * rows.max())


def test_of_a_kinematic_cage_only_what_moves_is_derived():
    """Rings held, axes that lean by 0.1 mrad."""
    kinematic, free = (assemble.model(case(model="planar", **given)) for given in ({"cage": KINEMATIC}, {}))
    model = spatial_model(kinematic, even_slices(6), flanges=NoFlanges())
    y = empty(model)
    y[: lay.BUFFER_SIZE] = assemble.start(case(model="planar"), free)[0]
    random, Z = np.random.default_rng(0), model.bearing.Z
    for row, size in ((lay.RADIAL, 3e-7), (lay.RADIAL_V, 1e-3), (lay.AXIS_X, 1e-4), (lay.AXIS_Y, 1e-4)):
        y[row : row + Z] += random.normal(0.0, size, Z)
    start_at_rest(model, 0.0, y)
    model = model._replace(lag=0.0)
    for errors, full in compared(model, 0.0, y):
        assert np.linalg.norm(errors) <= 3e-5 * np.linalg.norm(full)
        assert full.shape == (17 + 6 * Z, 2 + 3 * Z)
    for one in derivatives(model, 0.0, y):
        assert np.abs(one[17 + Z : 17 + 4 * Z]).max() == 0.0
