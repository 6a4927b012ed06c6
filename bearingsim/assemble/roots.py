"""Root in an interval by Brent's method (1973, Algorithms for minimization without derivatives, ch. 4).

The steps and results equal those of ``scipy.optimize.brentq`` to the last bit, without the half second that its
import takes in every process.
"""

from collections.abc import Callable
from math import inf

MOST_STEPS = 100


def root(function: Callable[[float], float], low: float, high: float, absolute: float, relative: float) -> float:
    """Return the root between ``low`` and ``high`` of a function with different signs there.

    absolute, relative: tolerances of the root. Raises ValueError for equal signs, or if it does not converge.
    """
    before, now, far = low, high, 0.0
    f_before, f_now, f_far = function(before), function(now), 0.0
    last = step = 0.0
    if f_before == 0.0 or f_now == 0.0:
        return before if f_before == 0.0 else now
    if (f_before < 0.0) == (f_now < 0.0):
        raise ValueError(f"the function has equal signs at {low} and {high}")
    for _ in range(MOST_STEPS):
        if f_before != 0.0 and (f_before < 0.0) != (f_now < 0.0):
            far, f_far = before, f_before
            last = step = now - before
        if abs(f_far) < abs(f_now):
            before, now, far = now, far, now
            f_before, f_now, f_far = f_now, f_far, f_now
        least, half = (absolute + relative * abs(now)) / 2.0, (far - now) / 2.0
        if f_now == 0.0 or abs(half) < least:
            return now
        wanted = inf
        if abs(last) > least and abs(f_now) < abs(f_before):
            wanted = _interpolated((before, f_before), (now, f_now), (far, f_far))
        is_fast = 2.0 * abs(wanted) < min(abs(last), 3.0 * abs(half) - least)
        last, step = (step, wanted) if is_fast else (half, half)
        before, f_before = now, f_now
        now += step if abs(step) > least else least if half > 0.0 else -least
        f_now = function(now)
    raise ValueError(f"no root between {low} and {high} after {MOST_STEPS} steps")


def _interpolated(before: tuple[float, float], now: tuple[float, float], far: tuple[float, float]) -> float:
    """Return the step from ``now`` to the root of the secant or the inverse parabola; inf if there is none."""
    (x_before, f_before), (x, f), (x_far, f_far) = before, now, far
    if x_before == x_far:
        return -f * (x - x_before) / (f - f_before)
    secant, secant_far = (f_before - f) / (x_before - x), (f_far - f) / (x_far - x)
    bent = secant_far * secant * (f_far - f_before)
    return -f * (f_far * secant_far - f_before * secant) / bent if bent != 0.0 else inf
