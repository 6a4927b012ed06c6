"""Of two defects under one slice: which is felt, whatever their order."""

from itertools import permutations

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.envelope import Path
from bearingsim.core.defects.on_roller import is_masked
from bearingsim.core.defects.on_slices import clear_defect_response, mark_rollers_at_defects, slice_defect_response
from bearingsim.core.defects.pairs import ON_OUTER, OUTER, RollerDefectPair
from bearingsim.core.defects.traced import pack_traced_defects
from tests.scenes.nf308 import case
from tests.scenes.spatial_bearing import empty, even_slices, spatial_model

B = 1e-4  # m: half of every defect
AT = 0.3 * B  # m: where the roller stands


def level(h):
    """A meeting whose every slice feels ``h`` (m) all along."""
    row = (1.0, B, B, 0.0, abs(h))
    path = Path(np.array([[-B, h, 0.0, 0.0]]), B)
    return RollerDefectPair(OUTER, ON_OUTER, 0.0, 0.0385, 7e-3, [row] * 2, [path] * 2)


def standing_over(depths):
    """A bearing whose first roller stands over defects of these depths (m) at once, and its buffer."""
    model = spatial_model(assemble.model(case(model="planar")), even_slices(2))
    model = model._replace(bearing=model.bearing._replace(theta_0=AT / 0.0385))
    y = empty(model)
    start_at_rest(model, 0.0, y)
    return model._replace(defects=pack_traced_defects([level(h) for h in depths])), y


def felt(depths):
    """Sinking (m) of the first roller's first slice."""
    model, y = standing_over(depths)
    assert mark_rollers_at_defects(model, 0.0, 1.0, 1.0, y) == len(depths)
    slice_defect_response(model, 0.0, 0, 1.0, 1.0, 1.0, y)
    sinking = y[lay.OUTER_SIDE + lay.ROLLER_DROP]
    clear_defect_response(model, y)
    assert y[lay.OUTER_SIDE + lay.ROLLER_DROP] == 0.0
    return sinking


DEPTHS = [(-2e-6,), (-2e-6, -1e-6), (-2e-6, 0.0), (-2e-6, 1e-6), (-2e-6, 0.0, -1e-6), (2e-6, 1e-6, 0.0)]


@pytest.mark.parametrize("depths", DEPTHS)
def test_the_deepest_is_felt_in_any_order(depths):
    """A burr only where nothing deeper is: as ``is_masked`` chooses in the plane."""
    for order in permutations(depths):
        assert felt(order) == max(depths)
        model, y = standing_over(order)
        counts = [not is_masked(model, d, 0, AT, 0.0, y) for d in range(len(order))]
        assert [h for h, one in zip(order, counts, strict=True) if one] == [max(depths)]
