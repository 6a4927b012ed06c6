"""The elastic force of one contact, Q_e = k delta^m1 or a law like it, and how two in series share an approach.

delta: approach (m), positive in contact. Each law has ``elastic``, ``tangent`` and ``share``. All keep the vector
lanes of a loop over rollers, but those of ``PowerLaw``, which call the library's power.
"""

from math import exp, isclose, log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.hertz import effective_modulus
from bearingsim.core.laws.johnson import reduced_force, reduced_slope


@jit
def ninth_root(x: float) -> float:
    """x^(1/9) for x >= 0 without a call, so that a loop over rollers keeps its vector lanes.

    r ~ x^(-1/9) is read off the exponent bits, then corrected three times by
    r <- r (1 - e)^(-1/9), e = 1 - x r^9, expanded to e^3; relative error below 2e-15 over 1e-30 .. 1e3.
    """
    x = max(x, 1e-300)
    high = np.float64(x).view(np.int64) >> 32
    guess = (1191820000 - ((high * 477218588) >> 32)) << 32
    r = np.int64(guess).view(np.float64)
    for _ in range(3):
        r2 = r * r
        r4 = r2 * r2
        e = 1.0 - x * (r4 * r4 * r)
        r = r + r * e * (1.0 / 9.0 + e * (5.0 / 81.0 + e * (95.0 / 2187.0)))
    r2 = r * r
    r4 = r2 * r2
    return x * (r4 * r4)


class TenNinths(NamedTuple):
    """Line contact of finite length, Q = k delta^(10/9); k in N/m^(10/9) for the full roller length.

    One contact alone. Sources: Palmgren's delta = 3.84e-5 Q^0.9/L^0.8 mm, and ISO/TS 16281, whose constant
    35948 L^(8/9) is for both contacts of a roller in series (one contact: times 2^(10/9)).
    """

    k: float


PALMGREN_N_MM = 8.06e4  # N/mm^(10/9) per L^(8/9): 3.84e-5^(-10/9)
ISO16281_BOTH_N_MM = 35948.0
EXPONENT = 10.0 / 9.0


def palmgren(L_w: float) -> TenNinths:
    """Palmgren's stiffness of a steel line contact of length ``L_w`` (m), k in N/m^(10/9)."""
    return TenNinths(PALMGREN_N_MM * (1e3 * L_w) ** (8.0 / 9.0) * 1e3**EXPONENT)


def iso16281(L_w: float) -> TenNinths:
    """ISO/TS 16281's stiffness of one of the two contacts of a roller of length ``L_w`` (m), k in N/m^(10/9)."""
    both = ISO16281_BOTH_N_MM * (1e3 * L_w) ** (8.0 / 9.0) * 1e3**EXPONENT
    return TenNinths(both * 2.0**EXPONENT)


class ThreeHalves(NamedTuple):
    """Point contact, Q = k delta^(3/2); k in N/m^(3/2). Source: Hertz; see ``hertz.ball_on_race`` for k."""

    k: float


class Linear(NamedTuple):
    """Q = k delta; k in N/m."""

    k: float


class PowerLaw(NamedTuple):
    """Q = k delta^m with any exponent m >= 1; k in N/m^m. Calls ``pow``: a loop over rollers loses its lanes."""

    k: float
    m: float


class Johnson(NamedTuple):
    """Line contact of two cylinders, delta = Q'/(pi E*) [ln(4 pi E* dR/Q') - 1] with Q' = Q/L solved for Q.

    force: 4 pi E* dR L (N), length: 4 dR (m); see ``johnson``. Source: K. L. Johnson, Contact Mechanics, Cambridge
    1985, section 5.6: a cylinder of radius R is compressed, from its axis to the contact of half width a, by
    Q'/(2 pi E*) [2 ln(4 R/a) - 1]. Twice, for R_1 and R_2, with a^2 = 4 Q' R_1 R_2/(pi E* (R_1 +- R_2)), gives the
    formula with dR = R_1 + R_2, or R_2 - R_1 inside a ring. (This pair form: Pereira, Ramalho and Ambrosio,
    Nonlinear Dynamics 63 (2011) 681.) So the ring is taken to be as deep as its own radius; twice as deep would
    add Q' ln 2/(pi E*), some 5 %.

    Plane strain: no end effects. The bracket must exceed 1, which it does for delta < 0.5 dR; the tabulated curve
    (``laws/johnson.py``) is within 1e-9 of the formula for 6e-11 dR < delta < 0.06 dR,
    beyond that extended smoothly.
    """

    force: float
    length: float


def johnson(E: float, nu: float, L: float, dR: float) -> Johnson:
    """The law of a roller of length ``L`` (m) on a race, both of ``E`` (Pa) and ``nu``.

    ``dR`` (m): R_i + R_w on the inner race, R_o - R_w on the outer.
    """
    return Johnson(4.0 * pi * effective_modulus(E, nu) * dR * L, 4.0 * dR)


def constant(k: float, m: float) -> TenNinths | ThreeHalves | Linear | PowerLaw:
    """The law k delta^m, k in N/m^m: the fastest that has this exponent."""
    for exponent, law in ((1.0, Linear), (EXPONENT, TenNinths), (1.5, ThreeHalves)):
        if isclose(m, exponent, rel_tol=1e-12):
            return law(k)
    if m < 1.0:
        raise ValueError(f"exponent {m}: below 1 a contact is infinitely stiff at touch-down")
    return PowerLaw(k, m)


@generic
def elastic(law: Any, delta: float) -> float:
    """Elastic force (N) at approach ``delta`` >= 0 (m)."""


@generic
def tangent(law: Any, delta: float) -> float:
    """Slope of the elastic force (N/m) at approach ``delta`` >= 0 (m)."""


@elastic.register(TenNinths)
def _elastic_ten_ninths(law, delta):
    return law.k * delta * ninth_root(delta)


@tangent.register(TenNinths)
def _tangent_ten_ninths(law, delta):
    return 10.0 / 9.0 * law.k * ninth_root(delta)


@elastic.register(ThreeHalves)
def _elastic_three_halves(law, delta):
    return law.k * delta * sqrt(max(delta, 0.0))


@tangent.register(ThreeHalves)
def _tangent_three_halves(law, delta):
    return 1.5 * law.k * sqrt(max(delta, 0.0))


@elastic.register(Linear)
def _elastic_linear(law, delta):
    return law.k * delta


@tangent.register(Linear)
def _tangent_linear(law, delta):
    return law.k


@elastic.register(PowerLaw)
def _elastic_power_law(law, delta):
    return law.k * max(delta, 0.0) ** law.m


@tangent.register(PowerLaw)
def _tangent_power_law(law, delta):
    return law.k * law.m * max(delta, 0.0) ** (law.m - 1.0)


@elastic.register(Johnson)
def _elastic_johnson(law, delta):
    return law.force * reduced_force(delta * (1.0 / law.length))


@tangent.register(Johnson)
def _tangent_johnson(law, delta):
    per_length = 1.0 / law.length
    return law.force * per_length * reduced_slope(delta * per_length)


# Two contacts in series: a roller without mass between the races


@generic
def share(outer: Any, inner: Any, delta: float) -> float:
    """The inner contact's part (m) of the approach ``delta`` >= 0 (m) of two contacts in series.

    It balances the elastic forces, E_outer(delta - part) = E_inner(part). Closed for two power laws of one
    exponent and for two of Johnson's; delta/2, exactly, if both contacts are equal. Any other pair takes Newton
    steps, in a function of their own, whose call costs a loop over rollers its lanes.
    """


@generic
def share_with_power(inner: Any, outer: Any, delta: float) -> float:
    """``share`` where the outer contact is a power law."""


@generic
def share_with_johnson(inner: Any, outer: Any, delta: float) -> float:
    """``share`` where the outer contact is ``Johnson``'s."""


@generic
def exponent(law: Any) -> float:
    """m of a power law."""


@exponent.register(TenNinths)
def _exponent_ten_ninths(law):
    return EXPONENT


@exponent.register(ThreeHalves)
def _exponent_three_halves(law):
    return 1.5


@exponent.register(Linear)
def _exponent_linear(law):
    return 1.0


@exponent.register(PowerLaw)
def _exponent_power_law(law):
    return law.m


NEWTONS = 4  # from the secants at delta/2: 1e-10 of the force for exponents 1 to 1.5 and k a hundred times apart


@jit
def share_by_newton(outer, inner, delta):
    """``share`` of any two laws."""
    d = max(delta, 0.0)
    of_outer, of_inner = elastic(outer, 0.5 * d), elastic(inner, 0.5 * d)
    part = d * of_outer / max(of_outer + of_inner, 1e-300)
    for _ in range(NEWTONS):
        excess = elastic(inner, part) - elastic(outer, d - part)
        slope = tangent(inner, part) + tangent(outer, d - part)
        part = min(max(part - excess / max(slope, 1e-300), 0.0), d)
    return part


def _share_powers(inner, outer, delta):
    m = exponent(outer)
    if m != exponent(inner):  # known when this is compiled, but for PowerLaw
        return share_by_newton(outer, inner, delta)
    ratio = (outer.k / inner.k) ** (1.0 / m)
    return max(delta, 0.0) * (ratio / (1.0 + ratio))


def _share_of_a_power(outer, inner, delta):
    return share_with_power(inner, outer, delta)


for _law in (TenNinths, ThreeHalves, Linear, PowerLaw):
    share.register(_law)(_share_of_a_power)
    share_with_power.register(_law)(_share_powers)


@share.register(Johnson)
def _share_of_johnson(outer, inner, delta):
    return share_with_johnson(inner, outer, delta)


@share_with_johnson.register(Johnson)
def _share_johnsons(inner, outer, delta):
    """Two in series are a third: with P = force/length, delta = Q (1/P_o + 1/P_i) [ln(F/Q) - 1].

    ln F is the mean of ln F_o and ln F_i weighted by 1/P; then part = Q/P_i [ln(F_i/Q) - 1].
    """
    P_o, P_i = outer.force / outer.length, inner.force / inner.length
    weight = P_o / (P_o + P_i)
    apart = log(inner.force / outer.force)
    F, S = outer.force * exp(weight * apart), 1.0 / P_o + 1.0 / P_i
    Q = F * reduced_force(max(delta, 0.0) * (1.0 / (F * S)))
    return weight * max(delta, 0.0) + ((1.0 - weight) * apart / P_i) * Q


def _share_unlike(inner, outer, delta):
    return share_by_newton(outer, inner, delta)


share_with_power.register(Johnson)(_share_unlike)
for _law in (TenNinths, ThreeHalves, Linear, PowerLaw):
    share_with_johnson.register(_law)(_share_unlike)
