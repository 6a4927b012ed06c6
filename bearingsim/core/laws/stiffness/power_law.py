"""A power of the approach with any exponent."""

from typing import NamedTuple

from bearingsim.core.laws.stiffness.interface import SHALLOWEST, curvature, elastic, tangent
from bearingsim.core.laws.stiffness.series import as_power


class PowerLaw(NamedTuple):
    """Q = k delta^m with any exponent m >= 1; k in N/m^m. Calls ``pow``: a loop over rollers loses its lanes."""

    k: float
    m: float


@elastic.register(PowerLaw)
def _elastic(law, delta):
    return law.k * max(delta, 0.0) ** law.m


@tangent.register(PowerLaw)
def _tangent(law, delta):
    return law.k * law.m * max(delta, 0.0) ** (law.m - 1.0)


@curvature.register(PowerLaw)
def _curvature(law, delta):
    return (law.m - 1.0) * tangent(law, delta) / max(delta, SHALLOWEST)


@as_power.register(PowerLaw)
def _as_power(law):
    return law.k, law.m
