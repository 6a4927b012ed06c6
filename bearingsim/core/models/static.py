"""``static``: at each cage angle the ring stands where the forces balance; nothing has inertia or damping.

Left out: everything that takes time. What remains is the load distribution, variable compliance, and the path
of the ring as rollers sink into a pit.
"""

from typing import Any, NamedTuple

from bearingsim.core.layout import LANES
from bearingsim.core.models.extremes import keep_forces
from bearingsim.core.models.interface import (
    ModelKind,
    begin,
    damping_per_mass,
    keep_extremes,
    stiffness_per_mass,
    watched,
    width,
)
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


standing.register(Static)(standing_evenly)


@width.register(Static)
def _width(model):
    return LANES


@begin.register(Static)
def _begin(model, t, y):
    return None


keep_extremes.register(Static)(keep_forces)


@watched.register(Static)
def _watched(model):
    return 0


@stiffness_per_mass.register(Static)
def _stiffness_per_mass(model, y, j):
    return 0.0


@damping_per_mass.register(Static)
def _damping_per_mass(model, y, j):
    return 0.0


KIND = ModelKind(Static, per_crossing=50)
