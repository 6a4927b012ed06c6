"""Shares in the approach of two contacts in series, of a massless roller between the races."""

from typing import Any

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.stiffness.interface import elastic, tangent

# steps, from the secants at delta/2; error 1e-10 of the force for exponents 1 to 1.5 and a ratio of k of 100
NEWTON_STEPS = 4
NOT_A_POWER_LAW = (0.0, 0.0)


@generic(otherwise=NOT_A_POWER_LAW)
def as_power(law: Any) -> tuple[float, float]:
    """Return k (N/m^m) and m of a power law k delta^m; two zeros for any other law."""


@jit
def inner_approach_by_newton(outer, inner, delta):
    """Compute ``inner_approach`` of any two laws."""
    d = max(delta, 0.0)
    force_outer, force_inner = elastic(outer, 0.5 * d), elastic(inner, 0.5 * d)
    share = d * force_outer / max(force_outer + force_inner, 1e-300)
    for _ in range(NEWTON_STEPS):
        excess = elastic(inner, share) - elastic(outer, d - share)
        spring_rate = tangent(inner, share) + tangent(outer, d - share)
        share = min(max(share - excess / max(spring_rate, 1e-300), 0.0), d)
    return share


def inner_approach_of_powers(outer, inner, delta):
    """Compute ``inner_approach`` of two power laws of equal exponent in closed form, of any other two by Newton's
    method."""
    (k_outer, m), (k_inner, m_inner) = as_power(outer), as_power(inner)
    if m != m_inner or m == 0.0:  # known at compile time, except for ``PowerLaw``
        return inner_approach_by_newton(outer, inner, delta)
    ratio = (k_outer / k_inner) ** (1.0 / m)
    return max(delta, 0.0) * (ratio / (1.0 + ratio))


@generic(otherwise=inner_approach_of_powers)
def inner_approach(outer: Any, inner: Any, delta: float) -> float:
    """Return the inner contact's part (m) of the approach ``delta`` >= 0 (m) of two contacts in series.

    It balances the elastic forces, E_outer(delta - part) = E_inner(part). In closed form for two power laws of
    equal exponent and for two of Johnson's laws; exactly delta/2 if both contacts are equal. Any other pair is
    solved by Newton steps in a separate function, whose call prevents the vectorisation of loops over rollers.
    """
