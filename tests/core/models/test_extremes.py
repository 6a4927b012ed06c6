"""Extremes of a motion, and that an evaluation changes neither the state nor the extremes."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.catalogue import MODELS, code
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.geometry.slices import WEIGHT
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import update_extremes
from bearingsim.core.models.spatial_equilibrium import solve_spatial_equilibrium
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parts.mounts import RigidMount
from tests.scenes.nf308 import advance_recorded, case
from tests.scenes.spatial_bearing import L_W, empty, even_slices, spatial_model

DISPLACEMENT = 8e-7  # m: displacement of the rollers from equilibrium


def ringing_bearing():
    """Return a misaligned bearing with oscillating rollers, and its buffer."""
    planar = assemble.with_friction_lag(assemble.model(case(model="planar")), 3e-6)
    model = spatial_model(planar, even_slices(4), mount_o=RigidMount(3e-4, -2e-4), mount_i=RigidMount(0.0, 1e-4))
    y = empty(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    assert solve_spatial_equilibrium(model, 0.0, y) < 1e-8 * model.support.F
    y[lay.RADIAL : lay.RADIAL + 13] += DISPLACEMENT * y[lay.SIN : lay.SIN + 13]
    start_at_rest(model, 0.0, y)
    return model, y


def test_every_model_updates_extremes():
    assert {code(model.module).KIND.parameters for model in MODELS.values()} <= update_extremes.types


def test_an_evaluation_changes_neither_state_nor_extremes():
    """Also with rings on rigid mounts; a second evaluation gives the same."""
    model, y = ringing_bearing()
    y[lay.POSITION : lay.POSITION + 2 * lay.STATE] += 1e-9 * np.random.default_rng(0).normal(size=2 * lay.STATE)
    start_at_rest(model, 0.0, y)  # which sets the rings on their mounts
    before = y.copy()
    start_at_rest(model, 0.0, y)
    evaluated = y.copy()
    assert (evaluated[: lay.ACCELERATION] == before[: lay.ACCELERATION]).all()
    for row in (lay.TILT_MAX, lay.LINE_LOAD_MAX, lay.Q_O_MAX, lay.Q_I_MAX, lay.Q_P_MAX):
        assert (y[row : row + 13] == before[row : row + 13]).all()
    start_at_rest(model, 0.0, y)
    assert (y == evaluated).all()


@pytest.mark.parametrize("method", [RungeKutta4(3e-6), Verlet(2e-7)])
def test_extremes_are_those_of_whole_steps(method):
    """Largest force, tilt and line load of every roller are those of the recorded steps, not of stages."""
    model, y = ringing_bearing()
    slices = [lay.slice_row(k, row) for k in range(4) for row in (lay.LOAD_O, lay.LOAD_I)]
    widths = np.repeat(model.slices.table[:, WEIGHT], 2) * L_W
    cells = np.concatenate([row + np.arange(13) for row in (lay.TILT, lay.Q_O, *slices)])
    out = np.empty((len(cells), 1000))
    assert advance_recorded(method, model, Monitor(1000, 1.0), 0, y, cells, out)[1] == SUCCESS
    largest = np.abs(out).reshape(-1, 13, 1000).max(axis=2)
    assert (y[lay.TILT_MAX : lay.TILT_MAX + 13] == largest[0]).all()
    assert (y[lay.Q_O_MAX : lay.Q_O_MAX + 13] == largest[1]).all()
    assert y[lay.LINE_LOAD_MAX : lay.LINE_LOAD_MAX + 13] == pytest.approx(
        (largest[2:] / widths[:, np.newaxis]).max(axis=0), rel=1e-12
    )
    assert largest[0].max() > 1e-5
