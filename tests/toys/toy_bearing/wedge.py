"""A pit that grows deeper along rolling and ends in a wall."""

from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.depth import EVEN, cuts, extent, section
from bearingsim.core.defects.profile import RACE, polygon


class Wedge(NamedTuple):
    """length: along the axis; width: along rolling; depth: at the wall; m."""

    length: float
    width: float
    depth: float


@section.register(Wedge)
def _section(pit, z):
    if abs(z) >= pit.length / 2.0:
        return RACE
    b = pit.width / 2.0
    return polygon(np.array([-b, 0.9 * b, b]), np.array([0.0, pit.depth, 0.0]))


@extent.register(Wedge)
def _extent(pit):
    return -pit.width / 2.0, pit.width / 2.0, -pit.length / 2.0, pit.length / 2.0


@cuts.register(Wedge)
def _cuts(pit):
    return [(-pit.length / 2.0, pit.length / 2.0, EVEN)]
