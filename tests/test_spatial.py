"""`spatial` against `planar`, where what it knows beyond it lies still; and its parts against closed forms."""

import numpy as np
import pytest

from bearingsim import build
from bearingsim.core.advance import FINE, Watch, advance, start_at_rest
from bearingsim.core.layout import ACCELERATION, LANES, Q_I, Q_O, ROW, SIZE, STATE
from bearingsim.core.methods.rk4 import RungeKutta4
from tests.planar_bodies import places
from tests.scenes import SLOT, case
from tests.spatial_scene import empty, even, in_space, uneven
from tests.test_planar_balance import EVERYTHING, WAYS, WHERE, lead_onto_pits, random_state

FULL = SLOT | {"width": "0.3 mm"}
ON_ALL = EVERYTHING | {"defects": [FULL, FULL | {"race": "inner"}, FULL | {"race": "roller", "roller": 5}]}
CUTS = [even(1), even(6), uneven(7)]


def same_state(model, cut, y):
    """The model in space, and its buffer at the planar state in ``y``."""
    space = in_space(model, cut)
    x = empty(space)
    x[:SIZE] = y[:SIZE]
    x[ACCELERATION : ACCELERATION + STATE] = 0.0
    return space, x


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("cut", CUTS, ids=["1 slice", "6 slices", "7 uneven slices"])
def test_with_nothing_out_of_the_plane_it_is_planar(way, cut):
    """Random states, a pit across each body, with and without lag: every acceleration to 1e-9 of the largest."""
    for seed in range(4):
        model = build.model(case(**ON_ALL, **WAYS[way]))._replace(lag=1e-6 * (seed // 2))
        y = random_state(model, seed)
        lead_onto_pits(model, y, WHERE, outwards=seed % 2 == 0)
        start_at_rest(model, WHERE, y)
        space, x = same_state(model, cut, y)
        start_at_rest(space, WHERE, x)
        for row in range(6):
            here = ACCELERATION + row * ROW + np.arange(LANES + 13)
            most = np.abs(y[here]).max() if row < 3 else 1e5
            assert np.abs(x[here] - y[here]).max() < 1e-9 * most
        assert x[Q_O : Q_O + 13] == pytest.approx(y[Q_O : Q_O + 13], rel=1e-11)
        assert x[Q_I : Q_I + 13] == pytest.approx(y[Q_I : Q_I + 13], rel=1e-11)
        assert np.ptp(y[Q_O : Q_O + 13]) > 100.0


def test_over_20_ms_it_moves_as_planar():
    """A slot on the outer race, friction, drag: every instant, within what halving the step changes."""
    given = case(model="planar", defect=SLOT)
    model = build.model(given)
    y, _ = build.start(given, model)
    at = places(13)
    found = {}
    for name, h in (("planar", 1e-6), ("finer", 5e-7), ("space", 1e-6)):
        one, x = same_state(model, even(6), y) if name == "space" else (model, y.copy())
        start_at_rest(one, 0.0, x)
        out = np.empty((len(at), round(20e-3 / h)))
        assert advance(RungeKutta4(h), one, Watch(1000, 1.0), 0, x, at, out)[1] == FINE
        found[name] = out[:, :: round(1e-6 / h)] if name != "finer" else out[:, 1::2]
    strayed = np.abs(found["space"] - found["planar"]).max(axis=1)
    halved = np.abs(found["finer"] - found["planar"]).max(axis=1)
    assert (strayed <= halved + 1e-12 * np.abs(found["planar"]).max(axis=1)).all()
