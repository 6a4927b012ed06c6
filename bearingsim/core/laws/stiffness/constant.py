"""Which law a constant k and an exponent m name."""

from math import isclose

from bearingsim.core.laws.stiffness.linear import Linear
from bearingsim.core.laws.stiffness.power_law import PowerLaw
from bearingsim.core.laws.stiffness.ten_ninths import EXPONENT, TenNinths
from bearingsim.core.laws.stiffness.three_halves import ThreeHalves

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
