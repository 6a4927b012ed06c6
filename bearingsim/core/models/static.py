"""``static``: at each cage angle the ring stands where the forces balance; nothing has inertia or damping.

Left out: everything that takes time. What remains is the load distribution, variable compliance, and the path
of the ring as rollers sink into a pit.
"""

from typing import Any, NamedTuple

from bearingsim.core.layout import LANES
from bearingsim.core.models.extremes import keep_forces
from bearingsim.core.models.interface import ModelKind, keep_extremes, solved, width
from bearingsim.core.parameters import Bearing, Support
from bearingsim.core.pits.on_roller import standing, standing_evenly
from bearingsim.core.pits.pairs import Pits


class Static(NamedTuple):
    """Parameters of the model; ``bearing.m_r`` must be 0, the ring's mass and the damping are not used."""

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    pits: Pits


solved(Static)
standing.register(Static)(standing_evenly)
keep_extremes.register(Static)(keep_forces)


@width.register(Static)
def _width(model):
    return LANES


KIND = ModelKind(Static, per_crossing=50)
