"""Root of a scalar function by Brent's method, without SciPy: importing ``scipy.optimize`` takes 0.15 s.

Brent, Algorithms for Minimization without Derivatives, 1973, chapter 4, in the order of operations of SciPy's
``brentq``, so that both give the same bits.
"""

from collections.abc import Callable
from math import inf, isnan

MAX_ITERATIONS = 100


def root(f: Callable[[float], float], low: float, high: float, xtol: float, rtol: float) -> float:
    """Find a root of ``f`` between ``low`` and ``high``, at which it has opposite signs, within xtol + rtol |x|.

    Raises ValueError if the signs are equal, if a value is NaN, or after ``MAX_ITERATIONS``.
    """
    previous, current, f_previous, f_current = low, high, f(low), f(high)
    if f_previous == 0.0:
        return previous
    if not (f_current == 0.0 or f_previous * f_current < 0.0):
        raise ValueError(f"no change of sign between {low:g} and {high:g}: {f_previous:g}, {f_current:g}")
    other, f_other = previous, f_previous  # the root lies between ``current`` and ``other``
    step = last_step = high - low
    for _ in range(MAX_ITERATIONS):
        if f_current != 0.0 and (f_previous > 0.0) != (f_current > 0.0):
            other, f_other = previous, f_previous
            step = last_step = current - previous
        if abs(f_other) < abs(f_current):
            previous, current, other = current, other, current
            f_previous, f_current, f_other = f_current, f_other, f_current
        tolerance, half = 0.5 * (xtol + rtol * abs(current)), 0.5 * (other - current)
        if f_current == 0.0 or abs(half) < tolerance:
            return current
        interpolated = inf
        if abs(last_step) > tolerance and abs(f_current) < abs(f_previous):
            interpolated = _interpolate(previous, current, other, f_previous, f_current, f_other)
        if 2.0 * abs(interpolated) < min(abs(last_step), 3.0 * abs(half) - tolerance):
            last_step, step = step, interpolated
        else:
            last_step = step = half
        previous, f_previous = current, f_current
        current += step if abs(step) > tolerance else tolerance if half > 0.0 else -tolerance
        f_current = f(current)
        if isnan(f_current):
            break
    raise ValueError(f"no root between {low:g} and {high:g} in {MAX_ITERATIONS} steps; last value {f_current:g}")


def _interpolate(
    previous: float, current: float, other: float, f_previous: float, f_current: float, f_other: float
) -> float:
    """Return the step from ``current`` to the root of a line or of a hyperbola through three points; inf: none."""
    if previous == other:
        return -f_current * (current - previous) / (f_current - f_previous)
    slope = (f_previous - f_current) / (previous - current)
    other_slope = (f_other - f_current) / (other - current)
    numerator = f_other * other_slope - f_previous * slope
    denominator = other_slope * slope * (f_other - f_previous)
    return -f_current * numerator / denominator if denominator != 0.0 else inf
