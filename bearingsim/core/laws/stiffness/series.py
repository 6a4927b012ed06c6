"""Division of an approach between two contacts in series, those of a massless roller between the races."""

from typing import Any

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.stiffness.interface import elastic, tangent

# from the secants at delta/2; error 1e-10 of the force for exponents 1 to 1.5 and stiffness ratios up to 100
NEWTON_STEPS = 4
NOT_A_POWER_LAW = (0.0, 0.0)  # k and m


@generic(otherwise=NOT_A_POWER_LAW)
def as_power(law: Any) -> tuple[float, float]:
    """Return k (N/m^m) and m of a power law k delta^m; two zeros for any other law."""


@jit
def inner_approach_by_newton(outer, inner, delta):
    """Compute ``inner_approach`` of any two laws by Newton's method."""
    d = max(delta, 0.0)
    force_outer, force_inner = elastic(outer, 0.5 * d), elastic(inner, 0.5 * d)
    inner_part = d * force_outer / max(force_outer + force_inner, 1e-300)
    for _ in range(NEWTON_STEPS):
        excess = elastic(inner, inner_part) - elastic(outer, d - inner_part)
        spring_rate = tangent(inner, inner_part) + tangent(outer, d - inner_part)
        inner_part = min(max(inner_part - excess / max(spring_rate, 1e-300), 0.0), d)
    return inner_part


def inner_approach_of_powers(outer, inner, delta):
    """Compute ``inner_approach`` of two power laws of equal exponent in closed form, of any other two by Newton's
    method."""
    (k_outer, m), (k_inner, m_inner) = as_power(outer), as_power(inner)
    if m != m_inner or m == 0.0:  # decided at compile time, except for ``PowerLaw``
        return inner_approach_by_newton(outer, inner, delta)
    ratio = (k_outer / k_inner) ** (1.0 / m)
    return max(delta, 0.0) * (ratio / (1.0 + ratio))


@generic(otherwise=inner_approach_of_powers)
def inner_approach(outer: Any, inner: Any, delta: float) -> float:
    """Return the inner contact's part (m) of the approach ``delta`` >= 0 (m) of two contacts in series.

    It balances the elastic forces, Q_outer(delta - part) = Q_inner(part), and is exactly delta/2 if both contacts
    are equal. There is a closed form for two power laws of equal exponent and for two of Johnson's laws. Any other
    pair is solved by Newton's method, whose separate function prevents the vectorisation of loops over rollers.
    """
