"""``linearise`` of ``spatial`` against differences of its accelerations, at states with all effects."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.parts.flanges import NoFlanges
from tests.core.models.test_spatial_balance import BALANCE_TIME, SETUPS, STATES, random_contact_state
from tests.scenes.differences import derivatives, differences
from tests.scenes.nf308 import case
from tests.scenes.spatial_bearing import L_W, empty, even_slices, spatial_model

KINEMATIC = {"motion": "kinematic"}
LENGTHS = [0, 1, 4, 5, 6, 7, 8, 9, 10]


def steps(Z):
    """Return the steps of position and velocity (N,)."""
    length = [k in LENGTHS for k in range(17)] + [True] * Z + [False] * 2 * Z + [True] * Z + [False] * 2 * Z
    return np.where(length, 3e-11, 1e-9), np.where(length, 1e-7, 1e-6)


def arms(b):
    """Return the lever arm of each coordinate (N,), in metres per unit."""
    r = 0.5 * (b.R_o + b.R_i)
    shared = [1.0, 1.0, b.R_o, r, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, *[b.R_o, r, b.R_i] * 2]
    return np.array(shared + [s for s in (1.0, r, b.R_w, 1.0, L_W / 2, L_W / 2) for _ in range(b.Z)])


def derivative_errors(model, t, y):
    """Yield errors and expected values of ``linearise`` in metres, for the columns of free coordinates."""
    arm = arms(model.bearing)
    result, expected = derivatives(model, t, y), differences(model, t, y, steps(model.bearing.Z))
    free = np.any(expected[0] != 0.0, axis=1) | np.any(expected[1] != 0.0, axis=1)
    for value, reference in zip(result, expected, strict=True):
        yield [(matrix * arm[:, None] / arm)[:, free] for matrix in (value - reference, reference)]


@pytest.mark.parametrize("setup", [name for name, fields in SETUPS.items() if "surfaces" not in fields])
@pytest.mark.parametrize(("tilt", "on_own_defect"), STATES)
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_the_accelerations(setup, tilt, on_own_defect, seed):
    """Defects, flanges, pockets, rings on springs, traction; angles in metres at their lever arms.

    To 1e-5 of the norm, and every row that is not small to 1e-4, because the differences are one-sided. Surfaces
    with form have no derivatives, and implicit methods are refused there.
    """
    model, y = random_contact_state(setup, seed, tilt, on_own_defect)
    for errors, reference in derivative_errors(model._replace(lag=0.0), BALANCE_TIME, y):
        assert np.linalg.norm(errors) <= 1e-5 * np.linalg.norm(reference)
        rows = np.linalg.norm(reference, axis=1)
        assert np.all(np.linalg.norm(errors, axis=1) <= 1e-4 * rows + 1e-7 * rows.max())


def test_derivatives_with_a_kinematic_cage():
    """Rings fixed, axes tilted by 0.1 mrad."""
    kinematic, free = (assemble.model(case(model="planar", **fields)) for fields in ({"cage": KINEMATIC}, {}))
    model = spatial_model(kinematic, even_slices(6), flanges=NoFlanges())
    y = empty(model)
    y[: lay.BUFFER_SIZE] = assemble.start(case(model="planar"), free)[0]
    rng, Z = np.random.default_rng(0), model.bearing.Z
    for row, size in ((lay.RADIAL, 3e-7), (lay.RADIAL_V, 1e-3), (lay.AXIS_X, 1e-4), (lay.AXIS_Y, 1e-4)):
        y[row : row + Z] += rng.normal(0.0, size, Z)
    start_at_rest(model, 0.0, y)
    model = model._replace(lag=0.0)
    for errors, reference in derivative_errors(model, 0.0, y):
        assert np.linalg.norm(errors) <= 3e-5 * np.linalg.norm(reference)
        assert reference.shape == (17 + 6 * Z, 2 + 3 * Z)
    for matrix in derivatives(model, 0.0, y):
        assert np.abs(matrix[17 + Z : 17 + 4 * Z]).max() == 0.0
