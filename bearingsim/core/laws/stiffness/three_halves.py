"""Point contact, after Hertz."""

from math import sqrt
from typing import NamedTuple

from bearingsim.core.laws.stiffness.interface import SHALLOWEST, curvature, elastic, tangent
from bearingsim.core.laws.stiffness.series import as_power


class ThreeHalves(NamedTuple):
    """Point contact, Q = k delta^(3/2); k in N/m^(3/2). Source: Hertz; see ``hertz.ball_on_race`` for k."""

    k: float


@elastic.register(ThreeHalves)
def _elastic(law, delta):
    return law.k * delta * sqrt(max(delta, 0.0))


@tangent.register(ThreeHalves)
def _tangent(law, delta):
    return 1.5 * law.k * sqrt(max(delta, 0.0))


@curvature.register(ThreeHalves)
def _curvature(law, delta):
    return tangent(law, delta) / (2.0 * max(delta, SHALLOWEST))


@as_power.register(ThreeHalves)
def _as_power(law):
    return law.k, 1.5
