"""The normal force of one contact: an elastic law and a damping law.

    Q = max(0, k delta^m1 + damping(delta, v))   where delta > 0, else 0

delta: approach (m), positive in contact; v: its total rate (m/s), positive while closing. A damping law holds
the elastic law it goes with, so one value names the whole contact: ``HuntCrossley(TenNinths(k), chi)``.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic, jit


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


@generic
def elastic(law: Any, delta: float) -> float:
    """Elastic force (N) at approach ``delta`` >= 0 (m)."""


@generic
def tangent(law: Any, delta: float) -> float:
    """Slope of the elastic force (N/m) at approach ``delta`` >= 0 (m)."""


@generic
def share(outer: Any, inner: Any, delta: float) -> float:
    """Approach (m) of the inner contact when both contacts in series have ``delta`` >= 0 (m) together."""


@share.register(TenNinths)
def _share_ten_ninths(outer, inner, delta):
    return 0.5 * delta


@elastic.register(TenNinths)
def _elastic_ten_ninths(law, delta):
    return law.k * delta * ninth_root(delta)


@tangent.register(TenNinths)
def _tangent_ten_ninths(law, delta):
    return 10.0 / 9.0 * law.k * ninth_root(delta)


class HuntCrossley(NamedTuple):
    """Damping proportional to the elastic force: Q = Q_e (1 + chi v). chi in s/m.

    Continuous at touch-down. Source: Hunt and Crossley 1975. chi is the model's largest unknown: dry steel
    0.1-0.5 s/m, a lubricated contact far more.
    """

    stiffness: Any
    chi: float


class Kraemer(NamedTuple):
    """Damping proportional to the tangent stiffness: Q = Q_e + beta Q_e' v. beta in s.

    Source: Kraemer, Dynamics of Rotors and Foundations 1993: 0.25e-5 .. 2.5e-5 s for rolling bearings.
    Jumps (by delta^(1/9)) at touch-down.
    """

    stiffness: Any
    beta: float


class General(NamedTuple):
    """Damping of the multibody codes: Q = Q_e + c sgn(v) |v|^m2 delta^m3. c in N (s/m)^m2 / m^m3."""

    stiffness: Any
    c: float
    m2: float
    m3: float


@generic
def normal_force(contact: Any, delta: float, v: float) -> float:
    """Contact force (N, never pulling) at approach ``delta`` (m, any sign) and closing rate ``v`` (m/s)."""


@generic
def damping_slope(contact: Any, delta: float, v: float) -> float:
    """How fast the force grows with the closing rate, dQ/dv (N s/m), at ``delta`` >= 0 and ``v``."""


@generic
def stiffness_slope(contact: Any, delta: float, v: float) -> float:
    """How fast the force grows with the approach, dQ/d(delta) (N/m), at ``delta`` >= 0 and ``v``."""


@normal_force.register(HuntCrossley)
def _force_hunt_crossley(contact, delta, v):
    return max(elastic(contact.stiffness, max(delta, 0.0)) * (1.0 + contact.chi * v), 0.0)


@damping_slope.register(HuntCrossley)
def _damping_hunt_crossley(contact, delta, v):
    return contact.chi * elastic(contact.stiffness, delta)


@stiffness_slope.register(HuntCrossley)
def _stiffness_hunt_crossley(contact, delta, v):
    return tangent(contact.stiffness, delta) * max(1.0 + contact.chi * v, 0.0)


@normal_force.register(Kraemer)
def _force_kraemer(contact, delta, v):
    d = max(delta, 0.0)
    return max(elastic(contact.stiffness, d) + contact.beta * tangent(contact.stiffness, d) * v, 0.0)


@damping_slope.register(Kraemer)
def _damping_kraemer(contact, delta, v):
    return contact.beta * tangent(contact.stiffness, delta)


@stiffness_slope.register(Kraemer)
def _stiffness_kraemer(contact, delta, v):
    return tangent(contact.stiffness, delta)


@normal_force.register(General)
def _force_general(contact, delta, v):
    d = max(delta, 0.0)
    drag = contact.c * abs(v) ** contact.m2 * d**contact.m3
    drag = drag if v > 0.0 else -drag
    force = max(elastic(contact.stiffness, d) + drag, 0.0)
    return force if delta > 0.0 else 0.0  # with m3 = 0 the dashpot would act on a roller that is not there


@damping_slope.register(General)
def _damping_general(contact, delta, v):
    # at rest |v|^(m2-1) is 0 or infinite unless m2 = 1: a thousandth of a metre per second stands for "slow"
    return contact.m2 * contact.c * max(abs(v), 1e-3) ** (contact.m2 - 1.0) * delta**contact.m3


@stiffness_slope.register(General)
def _stiffness_general(contact, delta, v):
    growth = contact.m3 * contact.c * abs(v) ** contact.m2 * max(delta, 1e-12) ** (contact.m3 - 1.0)
    return tangent(contact.stiffness, delta) + max(growth if v > 0.0 else -growth, 0.0)
