"""Power laws of the approach: linear spring, Hertz's point contact, fits of the line contact, any exponent."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.laws.stiffness.interface import MIN_APPROACH, curvature, elastic, tangent
from bearingsim.core.laws.stiffness.series import as_power


class Linear(NamedTuple):
    """Linear spring, Q = k delta; k in N/m."""

    k: float


@elastic.register(Linear)
def _elastic_linear(law, delta):
    return law.k * delta


@tangent.register(Linear)
def _tangent_linear(law, delta):
    return law.k


@curvature.register(Linear)
def _curvature_linear(law, delta):
    return 0.0


@as_power.register(Linear)
def _as_power_linear(law):
    return law.k, 1.0


class ThreeHalves(NamedTuple):
    """Point contact, Q = k delta^(3/2); k in N/m^(3/2). Source: Hertz; see ``hertz.make_ball_contact`` for k."""

    k: float


@elastic.register(ThreeHalves)
def _elastic_three_halves(law, delta):
    return law.k * delta * sqrt(max(delta, 0.0))


@tangent.register(ThreeHalves)
def _tangent_three_halves(law, delta):
    return 1.5 * law.k * sqrt(max(delta, 0.0))


@curvature.register(ThreeHalves)
def _curvature_three_halves(law, delta):
    return tangent(law, delta) / (2.0 * max(delta, MIN_APPROACH))


@as_power.register(ThreeHalves)
def _as_power_three_halves(law):
    return law.k, 1.5


PALMGREN_N_MM = 8.06e4  # k over L^(8/9), in N and mm: 3.84e-5^(-10/9)
ISO16281_BOTH_N_MM = 35948.0  # k of both contacts in series over L^(8/9), in N and mm
LINE_CONTACT_EXPONENT = 10.0 / 9.0
"""Exponent of the approach in Palmgren's and ISO/TS 16281's line contacts."""


class TenNinths(NamedTuple):
    """Line contact of finite length, Q = k delta^(10/9); k in N/m^(10/9) for the full roller length.

    For one contact. Sources: Palmgren's delta = 3.84e-5 Q^0.9/L^0.8 mm; ISO/TS 16281, whose k = 35948 L^(8/9) is
    that of both contacts of a roller in series (k of one contact: 2^(10/9) times as large).
    """

    k: float


def make_palmgren(L_w: float) -> TenNinths:
    """Return Palmgren's law of a steel line contact of length ``L_w`` (m)."""
    return TenNinths(PALMGREN_N_MM * (1e3 * L_w) ** (8.0 / 9.0) * 1e3**LINE_CONTACT_EXPONENT)


def make_iso16281(L_w: float) -> TenNinths:
    """Return ISO/TS 16281's law of one of the two contacts of a steel roller of length ``L_w`` (m)."""
    k_both = ISO16281_BOTH_N_MM * (1e3 * L_w) ** (8.0 / 9.0) * 1e3**LINE_CONTACT_EXPONENT
    return TenNinths(k_both * 2.0**LINE_CONTACT_EXPONENT)


C_1, C_2, C_3, C_4, C_5 = 1 / 9, 5 / 81, 95 / 2187, 665 / 19683, 4921 / 177147
"""Coefficients of the series of (1 - e)^(-1/9) - 1 in powers of e."""


@jit
def ninth_root(x: float) -> float:
    """Return x^(1/9) for x >= 0 without a library call, so that loops over rollers are vectorised.

    r = x^(-1/9) is estimated from the exponent bits, then corrected twice by r <- r (1 - e)^(-1/9), e = 1 - x r^9,
    expanded to e^3 and then to e^5; the relative error is below 2e-15 for 1e-30 <= x <= 1e3.
    """
    x = max(x, 1e-300)
    high = np.float64(x).view(np.int64) >> 32
    guess = (1191820000 - ((high * 477218588) >> 32)) << 32
    r = np.int64(guess).view(np.float64)
    r2 = r * r
    r4 = r2 * r2
    e = 1.0 - x * (r4 * r4 * r)
    r = r + r * e * (C_1 + e * (C_2 + e * C_3))
    r2 = r * r
    r4 = r2 * r2
    e = 1.0 - x * (r4 * r4 * r)
    r = r + r * e * (C_1 + e * (C_2 + e * (C_3 + e * (C_4 + e * C_5))))
    r2 = r * r
    r4 = r2 * r2
    return x * (r4 * r4)


@elastic.register(TenNinths)
def _elastic_ten_ninths(law, delta):
    return law.k * delta * ninth_root(delta)


@tangent.register(TenNinths)
def _tangent_ten_ninths(law, delta):
    return 10.0 / 9.0 * law.k * ninth_root(delta)


@curvature.register(TenNinths)
def _curvature_ten_ninths(law, delta):
    return tangent(law, delta) / (9.0 * max(delta, MIN_APPROACH))


@as_power.register(TenNinths)
def _as_power_ten_ninths(law):
    return law.k, LINE_CONTACT_EXPONENT


class PowerLaw(NamedTuple):
    """Power law, Q = k delta^m, with any exponent m >= 1; k in N/m^m. Uses ``pow``, so loops over rollers are not
    vectorised."""

    k: float
    m: float


@elastic.register(PowerLaw)
def _elastic_power_law(law, delta):
    return law.k * max(delta, 0.0) ** law.m


@tangent.register(PowerLaw)
def _tangent_power_law(law, delta):
    return law.k * law.m * max(delta, 0.0) ** (law.m - 1.0)


@curvature.register(PowerLaw)
def _curvature_power_law(law, delta):
    return (law.m - 1.0) * tangent(law, delta) / max(delta, MIN_APPROACH)


@as_power.register(PowerLaw)
def _as_power_power_law(law):
    return law.k, law.m
