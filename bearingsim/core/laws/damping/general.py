"""Damping law of multibody codes: a power of the rate times a power of the approach."""

from math import isclose
from typing import Any, NamedTuple

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import MIN_APPROACH, elastic, tangent

MIN_RATE = 1e-12  # m/s: minimum rate for evaluating a derivative that is infinite at rest


class General(NamedTuple):
    """Damping law of multibody codes: Q = Q_e + c sgn(v) |v|^m2 delta^m3. c in N (s/m)^m2 / m^m3.

    m2, m3: exponents, each a ``Power0``, ``Power1``, ``Power2`` or ``Power`` (``make_general``). The first three
    are empty tuples, hence equal to one another; compare laws by their types, not by ``==``.
    """

    stiffness: Any
    c: float
    m2: Any
    m3: Any


@jit
def sign(v):
    """Return the sign of ``v``, 0 at rest, where Coulomb damping (m2 = 0) has no force."""
    return (1.0 if v > 0.0 else 0.0) - (1.0 if v < 0.0 else 0.0)


@normal_force.register(General)
def _force(contact, delta, v):
    d = max(delta, 0.0)
    damping_force = sign(v) * contact.c * monomial(contact.m2, abs(v)) * monomial(contact.m3, d)
    contact_factor = 1.0 if delta > 0.0 else 0.0  # with m3 = 0 the dashpot would act without contact
    return contact_factor * max(elastic(contact.stiffness, d) + damping_force, 0.0)


@derivatives.register(General)
def _derivatives(contact, delta, v):
    """Return the derivatives, with at least MIN_RATE in |v|^(m2-1) and MIN_APPROACH in delta^(m3-1), which can be
    infinite at 0."""
    d, speed = max(delta, 0.0), abs(v)
    approach_factor = monomial(contact.m3, d)
    rate_factor = sign(v) * contact.c * monomial(contact.m2, speed)
    contact_factor = 1.0 if delta > 0.0 else 0.0
    contact_factor = contact_factor if elastic(contact.stiffness, d) + rate_factor * approach_factor > 0.0 else 0.0
    K = tangent(contact.stiffness, d) + rate_factor * monomial_derivative(contact.m3, max(d, MIN_APPROACH))
    C = contact.c * monomial_derivative(contact.m2, max(speed, MIN_RATE)) * approach_factor
    return contact_factor * K, contact_factor * C


@stiffness_bound.register(General)
def _stiffness_bound(contact, delta, v):
    K_damping = contact.c * monomial(contact.m2, abs(v)) * monomial_derivative(contact.m3, max(delta, 1e-12))
    return tangent(contact.stiffness, delta) + max(sign(v) * K_damping, 0.0)


@damping_bound.register(General)
def _damping_bound(contact, delta, v):
    # at rest |v|^(m2-1) is 0 or infinite unless m2 = 1, so 1e-3 m/s is the minimum rate
    return contact.c * monomial_derivative(contact.m2, max(abs(v), 1e-3)) * monomial(contact.m3, delta)


# Exponents


class Power0(NamedTuple):
    """The exponent 0."""


class Power1(NamedTuple):
    """The exponent 1."""


class Power2(NamedTuple):
    """The exponent 2."""


class Power(NamedTuple):
    """Any exponent m >= 0. Uses ``pow``, so loops over rollers are not vectorised."""

    m: float


@generic
def monomial(exponent: Any, x: float) -> float:
    """Return x^m, for x >= 0."""


@generic
def monomial_derivative(exponent: Any, x: float) -> float:
    """Return the derivative of x^m, m x^(m-1), for x > 0."""


@monomial.register(Power0)
def _monomial_0(exponent, x):
    return 1.0


@monomial_derivative.register(Power0)
def _derivative_0(exponent, x):
    return 0.0


@monomial.register(Power1)
def _monomial_1(exponent, x):
    return x


@monomial_derivative.register(Power1)
def _derivative_1(exponent, x):
    return 1.0


@monomial.register(Power2)
def _monomial_2(exponent, x):
    return x * x


@monomial_derivative.register(Power2)
def _derivative_2(exponent, x):
    return 2.0 * x


@monomial.register(Power)
def _monomial(exponent, x):
    return x**exponent.m


@monomial_derivative.register(Power)
def _derivative(exponent, x):
    return exponent.m * x ** (exponent.m - 1.0)


INTEGER_EXPONENTS = ((0.0, Power0), (1.0, Power1), (2.0, Power2))
"""Exponents that have a type of their own, which needs no ``pow``."""


def make_exponent(m: float) -> Power0 | Power1 | Power2 | Power:
    """Return the exponent ``m`` as the type that is evaluated fastest."""
    kinds = [kind for exponent, kind in INTEGER_EXPONENTS if isclose(m, exponent, rel_tol=1e-12, abs_tol=1e-12)]
    return kinds[0]() if kinds else Power(float(m))


def make_general(stiffness: Any, c: float, m2: float, m3: float) -> General:
    """Return a ``General`` law, its exponents as the types that are evaluated fastest."""
    return General(stiffness, c, make_exponent(m2), make_exponent(m3))
