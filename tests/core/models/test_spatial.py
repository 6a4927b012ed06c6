"""`spatial` against `planar` at plane states, and vectorisation of its loops."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.geometry.orientation import Body
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.models import spatial
from bearingsim.core.models.spatial_equilibrium import solve_spatial_equilibrium
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parameters import lanes
from bearingsim.core.parts import cage_in_space, flanges, races_in_space
from bearingsim.core.parts.flanges import NoFlanges
from bearingsim.core.parts.mounts import ElasticMount, RigidMount
from tests.core.models.test_planar_balance import ALL_EFFECTS, BALANCE_TIME, SETUPS, align_defects, random_state
from tests.independent.planar_bodies import state_rows
from tests.scenes.lanes import compiled, keeps_lanes, needs_vectors
from tests.scenes.nf308 import SLOT, advance_recorded, case
from tests.scenes.spatial_bearing import empty, even_slices, spatial_model, uneven_slices

FULL_LENGTH_SLOT = SLOT | {"width": "0.3 mm"}
SLOTS_ON_ALL = ALL_EFFECTS | {
    "defects": [
        FULL_LENGTH_SLOT,
        FULL_LENGTH_SLOT | {"race": "inner"},
        FULL_LENGTH_SLOT | {"race": "roller", "roller": 5},
    ]
}
SLICINGS = [even_slices(1), even_slices(6), uneven_slices(7)]
ELASTIC = ElasticMount(1.0, 1e-3, 1e-3, 1e7, 100.0, 1e4, 1.0, 0.0, 0.0)
"""Mount of rings that can tilt, but are aligned."""


def in_space_state(model, slicing, y, **fields):
    """Return the model in space, and its buffer at the planar state in ``y``."""
    space = spatial_model(model, slicing, **fields)
    x = empty(space)
    x[: lay.BUFFER_SIZE] = y[: lay.BUFFER_SIZE]
    x[lay.ACCELERATION : lay.ACCELERATION + lay.STATE] = 0.0
    return space, x


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("slicing", SLICINGS, ids=["1 slice", "6 slices", "7 uneven slices"])
def test_plane_states_equal_planar(setup, slicing):
    """Random states, defects across each body, with and without lag: accelerations to 1e-9 of the largest."""
    for seed in range(4):
        model = assemble.model(case(**SLOTS_ON_ALL, **SETUPS[setup]))._replace(lag=1e-6 * (seed // 2))
        y = random_state(model, seed)
        align_defects(model, y, BALANCE_TIME, outwards=seed % 2 == 0)
        start_at_rest(model, BALANCE_TIME, y)
        space, x = in_space_state(model, slicing, y, mount_o=ELASTIC, mount_i=ELASTIC)
        start_at_rest(space, BALANCE_TIME, x)
        for row in range(6):
            cells = lay.ACCELERATION + row * lay.ROW + np.arange(lay.FIRST_LANE + 13)
            scale = np.abs(y[cells]).max() if row < 3 else 1e5
            assert np.abs(x[cells] - y[cells]).max() < 1e-9 * scale
        assert x[lay.Q_O : lay.Q_O + 13] == pytest.approx(y[lay.Q_O : lay.Q_O + 13], rel=1e-11)
        assert x[lay.Q_I : lay.Q_I + 13] == pytest.approx(y[lay.Q_I : lay.Q_I + 13], rel=1e-11)
        assert np.ptp(y[lay.Q_O : lay.Q_O + 13]) > 100.0


def test_plane_motion_equals_planar_over_20_ms():
    """A slot on the outer race, friction, drag: every instant, within the change by halving the step."""
    bearing_case = case(model="planar", defect=SLOT)
    model = assemble.model(bearing_case)
    y, _ = assemble.start(bearing_case, model)
    cells = state_rows(13)
    motions = {}
    for name, h in (("planar", 1e-6), ("finer", 5e-7), ("space", 1e-6)):
        simulated, x = in_space_state(model, even_slices(6), y) if name == "space" else (model, y.copy())
        start_at_rest(simulated, 0.0, x)
        out = np.empty((len(cells), round(20e-3 / h)))
        assert advance_recorded(RungeKutta4(h), simulated, Monitor(1000, 1.0), 0, x, cells, out)[1] == SUCCESS
        motions[name] = out[:, :: round(1e-6 / h)] if name != "finer" else out[:, 1::2]
    difference = np.abs(motions["space"] - motions["planar"]).max(axis=1)
    step_error = np.abs(motions["finer"] - motions["planar"]).max(axis=1)
    assert (difference <= step_error + 1e-12 * np.abs(motions["planar"]).max(axis=1)).all()


def test_a_kinematic_cage_fixes_all_but_the_tilt():
    """Orbit, spin, skew and axial motion: a tilted roller's axis rotates with it, and stays in its plane."""
    misaligned = {"mount_o": RigidMount(1e-4, 0.0)}
    bearing_case = case(model="planar")
    model = assemble.model(bearing_case)
    y, _ = assemble.start(bearing_case, model)
    free, x = in_space_state(model, even_slices(6), y, **misaligned)
    assert solve_spatial_equilibrium(free, 0.0, x) < 1e-8 * model.support.F
    kinematic = assemble.model(case(model="planar", cage={"motion": "kinematic"}))
    space = spatial_model(kinematic, even_slices(6), flanges=NoFlanges(), **misaligned)
    start_at_rest(space, 0.0, x)
    assert np.abs(x[lay.TILT : lay.TILT + 13]).max() > 2e-5
    out = np.empty((2, 2000))
    cells = np.array([lay.TILT + 2, lay.SKEW + 2])
    assert advance_recorded(RungeKutta4(1e-6), space, Monitor(8, 1.0), 0, x, cells, out)[1] == SUCCESS
    assert np.abs(out[1]).max() < 1e-9 * np.abs(out[0]).max()
    assert np.ptp(out[0]) > 1e-2 * np.abs(out[0]).max()
    for row in (lay.EPS, lay.SPIN, lay.AXIAL):
        assert np.abs(x[row : row + 13]).max() == 0.0


@needs_vectors
def test_loops_over_rollers_keep_their_lanes():
    model = spatial_model(assemble.model(case(model="planar")), even_slices(2))
    y, n = empty(model), lanes(model.bearing)
    ring, b = Body._make([0.0] * 8 + [1.0] + [0.0] * 4), model.bearing
    for side in (OuterSide(), InnerSide()):
        assert keeps_lanes(compiled(races_in_space.fill_race_frame.py_func), side, b, ring, 1.0, y, n)
        slice_of = compiled(races_in_space.add_slice.py_func)
        law, friction, form = model.outer, model.friction, model.form
        assert keeps_lanes(slice_of, side, law, friction, form, b, ring, 0.0, 0.5, 0.0, 1, y, n)
        assert keeps_lanes(compiled(races_in_space.add_side_loads.py_func), side, b, ring, y, n)
    assert keeps_lanes(compiled(races_in_space.fill_slip_changes.py_func), 1e-6, 1.0, 1.0, 1.0, 1.0, y, n)
    assert keeps_lanes(compiled(races_in_space.update_line_load.py_func), lay.slice_row(1, 0), 1e-3, y, n)
    assert keeps_lanes(
        compiled(cage_in_space.add_pocket_slice_force.py_func), model.cage, b, 1.0, 0.0, 0.5, 0.0, y, n
    )
    assert keeps_lanes(compiled(spatial.fill_roller_axes.py_func), 1.0, 1.0, 1.0, y, n)
    assert keeps_lanes(compiled(spatial.accelerate_rollers.py_func), model, 1.0, 1.0, 1.0, y, n)


@needs_vectors
@pytest.mark.parametrize("side", [OuterSide(), InnerSide()])
def test_loops_over_rollers_at_flanges_keep_their_lanes(side):
    model = assemble.model(case(model="spatial", contact={"slices": 8}))
    y, n = empty(model), lanes(model.bearing)
    ring = Body._make([0.0] * 8 + [1.0] + [0.0] * 4)
    point = compiled(flanges.add_flange_point_force.py_func)
    assert keeps_lanes(point, side, model.flanges, model, ring, 1.0, 1e-3, y, n)
    assert keeps_lanes(compiled(flanges.any_roller_near_flange.py_func), side, model.flanges, model, ring, y, n)
    assert keeps_lanes(compiled(races_in_space.relax_friction.py_func), side, ring, y, n)
    assert keeps_lanes(compiled(races_in_space.clear_sums.py_func), side, y, n)
