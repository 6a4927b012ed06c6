"""A power of the approach with any exponent."""

from math import isclose
from typing import NamedTuple

from bearingsim.core.laws.stiffness.interface import SHALLOWEST, curvature, elastic, tangent
from bearingsim.core.laws.stiffness.linear import Linear
from bearingsim.core.laws.stiffness.series import as_power
from bearingsim.core.laws.stiffness.ten_ninths import EXPONENT, TenNinths
from bearingsim.core.laws.stiffness.three_halves import ThreeHalves


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


FASTER = ((1.0, Linear), (EXPONENT, TenNinths), (1.5, ThreeHalves))
"""The exponents that have a law of their own, without ``pow``."""


def constant(k: float, m: float) -> TenNinths | ThreeHalves | Linear | PowerLaw:
    """The law k delta^m, k in N/m^m: the fastest that has this exponent."""
    for exponent, law in FASTER:
        if isclose(m, exponent, rel_tol=1e-12):
            return law(k)
    if m < 1.0:
        raise ValueError(f"exponent {m}: below 1 a contact is infinitely stiff at touch-down")
    return PowerLaw(k, m)
