"""A defect that grows deeper along rolling and ends in a wall."""

from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.depth import CONSTANT_SECTION, extent, section, section_intervals
from bearingsim.core.defects.profile import RACE, make_polyline


class Wedge(NamedTuple):
    """length: along the axis; width: along rolling; depth: at the wall; m."""

    length: float
    width: float
    depth: float


@section.register(Wedge)
def _section(defect, z):
    if abs(z) >= defect.length / 2.0:
        return RACE
    b = defect.width / 2.0
    return make_polyline(np.array([-b, 0.9 * b, b]), np.array([0.0, defect.depth, 0.0]))


@extent.register(Wedge)
def _extent(defect):
    return -defect.width / 2.0, defect.width / 2.0, -defect.length / 2.0, defect.length / 2.0


@section_intervals.register(Wedge)
def _cuts(defect):
    return [(-defect.length / 2.0, defect.length / 2.0, CONSTANT_SECTION)]
