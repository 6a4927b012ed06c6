"""The normal force of one contact: a damping law around an elastic one.

    Q = max(0, Q_e(delta) + damping(delta, v))   where delta > 0, else 0

delta: approach (m), positive in contact; v: its total rate (m/s), positive while closing. A damping law holds
the elastic law (``laws/stiffness.py``) it goes with, so one value names the whole contact:
``HuntCrossley(TenNinths(k), chi)``.
"""

from math import isclose
from typing import Any, NamedTuple

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.stiffness import elastic, tangent


class Undamped(NamedTuple):
    """No damping, Q = Q_e: the law of what stands still, which so is compiled once for all damping laws."""

    stiffness: Any


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


class Power0(NamedTuple):
    """The exponent 0."""


class Power1(NamedTuple):
    """The exponent 1."""


class Power2(NamedTuple):
    """The exponent 2."""


class Power(NamedTuple):
    """Any exponent m >= 0. Calls ``pow``: a loop over rollers loses its vector lanes."""

    m: float


class General(NamedTuple):
    """Damping of the multibody codes: Q = Q_e + c sgn(v) |v|^m2 delta^m3. c in N (s/m)^m2 / m^m3.

    m2, m3: exponents, each a ``Power0``, ``Power1``, ``Power2`` or ``Power``; see ``general``. The first three are
    empty tuples, so equal to one another: laws are told apart by their types, not by ``==``.
    """

    stiffness: Any
    c: float
    m2: Any
    m3: Any


WHOLE = ((0.0, Power0), (1.0, Power1), (2.0, Power2))
"""The exponents that have a type of their own."""


def general(stiffness: Any, c: float, m2: float, m3: float) -> General:
    """General damping with the fastest exponents that are m2 and m3."""
    return General(stiffness, c, power(m2), power(m3))


def power(m: float) -> Power0 | Power1 | Power2 | Power:
    """The fastest exponent that is ``m``."""
    known = [kind for whole, kind in WHOLE if isclose(m, whole, rel_tol=1e-12, abs_tol=1e-12)]
    return known[0]() if known else Power(float(m))


@generic
def raised(exponent: Any, x: float) -> float:
    """x^m, for x >= 0."""


@generic
def raised_slope(exponent: Any, x: float) -> float:
    """Slope of x^m, m x^(m-1), for x > 0."""


@raised.register(Power0)
def _raised_0(exponent, x):
    return 1.0


@raised_slope.register(Power0)
def _slope_0(exponent, x):
    return 0.0


@raised.register(Power1)
def _raised_1(exponent, x):
    return x


@raised_slope.register(Power1)
def _slope_1(exponent, x):
    return 1.0


@raised.register(Power2)
def _raised_2(exponent, x):
    return x * x


@raised_slope.register(Power2)
def _slope_2(exponent, x):
    return 2.0 * x


@raised.register(Power)
def _raised(exponent, x):
    return x**exponent.m


@raised_slope.register(Power)
def _slope(exponent, x):
    return exponent.m * x ** (exponent.m - 1.0)


@generic
def normal_force(contact: Any, delta: float, v: float) -> float:
    """Contact force (N, never pulling) at approach ``delta`` (m, any sign) and closing rate ``v`` (m/s)."""


@generic
def damping_slope(contact: Any, delta: float, v: float) -> float:
    """How fast the force grows with the closing rate, dQ/dv (N s/m), at ``delta`` >= 0 and ``v``."""


@generic
def stiffness_slope(contact: Any, delta: float, v: float) -> float:
    """How fast the force grows with the approach, dQ/d(delta) (N/m), at ``delta`` >= 0 and ``v``."""


@jit
def in_series(outer: float, inner: float) -> float:
    """Stiffness or damping of two contacts in series; 0 where one of them is 0."""
    return outer * inner / max(outer + inner, 1e-300)


@normal_force.register(Undamped)
def _force_undamped(contact, delta, v):
    return elastic(contact.stiffness, max(delta, 0.0))


@damping_slope.register(Undamped)
def _damping_undamped(contact, delta, v):
    return 0.0


@stiffness_slope.register(Undamped)
def _stiffness_undamped(contact, delta, v):
    return tangent(contact.stiffness, delta)


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
    force = max(elastic(contact.stiffness, d) + contact.beta * tangent(contact.stiffness, d) * v, 0.0)
    return force if delta > 0.0 else 0.0  # with a stiffness at touch-down (m1 = 1) damping would act across a gap


@damping_slope.register(Kraemer)
def _damping_kraemer(contact, delta, v):
    return contact.beta * tangent(contact.stiffness, delta)


@stiffness_slope.register(Kraemer)
def _stiffness_kraemer(contact, delta, v):
    return tangent(contact.stiffness, delta)


@normal_force.register(General)
def _force_general(contact, delta, v):
    d = max(delta, 0.0)
    drag = contact.c * raised(contact.m2, abs(v)) * raised(contact.m3, d)
    drag = drag if v > 0.0 else -drag
    force = max(elastic(contact.stiffness, d) + drag, 0.0)
    return force if delta > 0.0 else 0.0  # with m3 = 0 the dashpot would act on a roller that is not there


@damping_slope.register(General)
def _damping_general(contact, delta, v):
    # at rest |v|^(m2-1) is 0 or infinite unless m2 = 1: a thousandth of a metre per second stands for "slow"
    return contact.c * raised_slope(contact.m2, max(abs(v), 1e-3)) * raised(contact.m3, delta)


@stiffness_slope.register(General)
def _stiffness_general(contact, delta, v):
    growth = contact.c * raised(contact.m2, abs(v)) * raised_slope(contact.m3, max(delta, 1e-12))
    return tangent(contact.stiffness, delta) + max(growth if v > 0.0 else -growth, 0.0)
