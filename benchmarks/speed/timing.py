"""Timing by turns: least CPU time and noise, beside a yardstick that the program has no part in.

A machine is never quiet. So what is to be compared takes turns, round after round, and the least of each counts.
The yardstick is a loop of this file, timed in the same rounds: what the clock or a neighbour does to one, it does
to the other. Measures over their yardstick are what ``compare.py`` compares, not seconds.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numba
import numpy as np

Task = Callable[[], float]
"""What is timed: runs once, and says what CPU time (s) it took without its preparations."""


class Measure(NamedTuple):
    """A least CPU time (s), that of the yardstick beside it (s), and by how much both vary between rounds (1)."""

    seconds: float
    yardstick: float
    noise: float
    rounds: int


def measured(tasks: Mapping[str, Task], rounds: int) -> dict[str, Measure]:
    """All tasks in turn, ``rounds`` times. One turn before goes uncounted: it compiles."""
    every = {"yardstick": yardstick, **tasks}
    for task in every.values():
        task()
    turns = [[task() for task in every.values()] for _ in range(rounds)]
    times = dict(zip(every, np.array(turns).T, strict=True))
    own = times.pop("yardstick")
    return {
        name: Measure(float(took.min()), float(own.min()), noise(took) + noise(own), rounds)
        for name, took in times.items()
    }


def noise(times: np.ndarray) -> float:
    """How far the least of some times can be trusted: by how much the lower quartile is over it; inf if none."""
    ordered = np.sort(times)
    if len(ordered) == 1:
        return 0.0
    return float(ordered[max(1, len(ordered) // 4)] / ordered[0] - 1.0) if np.isfinite(ordered[0]) else np.inf


def clocked(function: Callable, *given: Any) -> float:
    """CPU time (s) of this thread in a call."""
    began = time.thread_time()
    function(*given)
    return time.thread_time() - began


def yardstick() -> float:
    """CPU time (s) of a loop as the core's are: rows of a buffer, a root and a division a lane."""
    return clocked(_roots, np.linspace(1.0, 2.0, 32), 20_000)


@numba.njit(error_model="numpy")
def _roots(x, times):
    for _ in range(times):
        for j in range(16):
            x[16 + j] = np.sqrt(x[j] + x[16 + j] / (1.0 + x[j]))


def exponent(sizes: Sequence[float] | np.ndarray, costs: Sequence[float] | np.ndarray) -> float:
    """The power of the size that the cost grows with: the slope of the straight line through their logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def cost_at(error: float, errors: Sequence[float], costs: Sequence[float]) -> float:
    """What a method costs at an error, between the points of its work-precision curve; inf if it never came to it.

    Only points count that nothing cheaper beats. Between two of them the curve is straight in log-log; where all
    are below the error, the cheapest counts.
    """
    front: list[tuple[float, float]] = []
    for cost, found in sorted(zip(costs, errors, strict=True)):
        if not front or found < front[-1][1]:
            front.append((cost, found))
    reached = next((k for k, (_, found) in enumerate(front) if found <= error), None)
    if reached is None:
        return float("inf")
    if reached == 0:
        return front[0][0]
    (c0, e0), (c1, e1) = front[reached - 1], front[reached]
    share = np.log(e0 / error) / np.log(e0 / e1)
    return float(c0 * (c1 / c0) ** share)
