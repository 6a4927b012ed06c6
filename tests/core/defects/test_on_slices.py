"""Choice among several defects under one slice, in any order."""

from itertools import permutations

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.envelope import Path
from bearingsim.core.defects.on_roller import is_masked
from bearingsim.core.defects.on_slices import clear_defect_response, fill_slice_response, mark_rollers_at_defects
from bearingsim.core.defects.pairs import ON_OUTER, OUTER, RollerDefectPair
from bearingsim.core.defects.traced import pack_traced_defects
from tests.scenes.nf308 import case
from tests.scenes.spatial_bearing import empty, even_slices, spatial_model

B = 1e-4  # m: half width of every defect
POSITION = 0.3 * B  # m: position of the roller


def flat_defect(h):
    """Return a roller-defect pair of constant drop ``h`` (m)."""
    row = (1.0, B, B, 0.0, abs(h))
    path = Path(np.array([[-B, h, 0.0, 0.0]]), B)
    return RollerDefectPair(OUTER, ON_OUTER, 0.0, 0.0385, 7e-3, [row] * 2, [path] * 2)


def bearing_over_defects(depths):
    """Return a bearing with its first roller over defects of these depths (m), and its buffer."""
    model = spatial_model(assemble.model(case(model="planar")), even_slices(2))
    model = model._replace(bearing=model.bearing._replace(theta_0=POSITION / 0.0385))
    y = empty(model)
    start_at_rest(model, 0.0, y)
    return model._replace(defects=pack_traced_defects([flat_defect(h) for h in depths])), y


def slice_drop(depths):
    """Return the drop (m) of the first slice of the first roller."""
    model, y = bearing_over_defects(depths)
    assert mark_rollers_at_defects(model, 0.0, 1.0, 1.0, y) == len(depths)
    fill_slice_response(model, 0.0, 0, 1.0, 1.0, 1.0, y)
    drop = y[lay.OUTER_SIDE + lay.ROLLER_DROP]
    clear_defect_response(model, y)
    assert y[lay.OUTER_SIDE + lay.ROLLER_DROP] == 0.0
    return drop


DEPTHS = [(-2e-6,), (-2e-6, -1e-6), (-2e-6, 0.0), (-2e-6, 1e-6), (-2e-6, 0.0, -1e-6), (2e-6, 1e-6, 0.0)]


@pytest.mark.parametrize("depths", DEPTHS)
def test_deepest_defect_acts_in_any_order(depths):
    """A burr acts only if there is no deeper defect, as with ``is_masked`` in the plane."""
    for order in permutations(depths):
        assert slice_drop(order) == max(depths)
        model, y = bearing_over_defects(order)
        acts = [not is_masked(model, d, 0, POSITION, 0.0, y) for d in range(len(order))]
        assert [h for h, is_acting in zip(order, acts, strict=True) if is_acting] == [max(depths)]
