"""Timing in turns: minimum CPU time and noise, with a yardstick independent of bearingsim.

Machines are disturbed by other processes. Therefore tasks that are compared alternate, and the minimum over the
rounds counts. The yardstick is a loop in this file that is timed in the same rounds, so that clock rate and
disturbances affect both equally. ``compare.py`` compares measures divided by their yardstick.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numba
import numpy as np

Task = Callable[[], float]
"""Function that runs once and returns its CPU time (s) without preparations."""


class Measure(NamedTuple):
    """Least CPU time (s), that of the yardstick (s), and the relative variation of both between rounds."""

    seconds: float
    yardstick: float
    noise: float
    rounds: int


def measure_in_turns(tasks: Mapping[str, Task], rounds: int) -> dict[str, Measure]:
    """Run all tasks in turn, ``rounds`` times, after a first turn that compiles and does not count."""
    all_tasks = {"yardstick": yardstick, **tasks}
    for task in all_tasks.values():
        task()
    turns = [[task() for task in all_tasks.values()] for _ in range(rounds)]
    times = dict(zip(all_tasks, np.array(turns).T, strict=True))
    yardstick_times = times.pop("yardstick")
    return {
        name: Measure(
            float(task_times.min()),
            float(yardstick_times.min()),
            noise(task_times) + noise(yardstick_times),
            rounds,
        )
        for name, task_times in times.items()
    }


def noise(times: np.ndarray) -> float:
    """Compute the uncertainty of the least time: excess of the lower quartile over it; inf if not finite."""
    ordered = np.sort(times)
    if len(ordered) == 1:
        return 0.0
    return float(ordered[max(1, len(ordered) // 4)] / ordered[0] - 1.0) if np.isfinite(ordered[0]) else np.inf


def cpu_time(function: Callable, *arguments: Any) -> float:
    """Return the CPU time (s) of this thread in a call."""
    began = time.thread_time()
    function(*arguments)
    return time.thread_time() - began


def yardstick() -> float:
    """Return the CPU time (s) of a loop similar to those of the core: rows of a buffer, square root, division."""
    return cpu_time(_roots, np.linspace(1.0, 2.0, 32), 20_000)


@numba.njit(error_model="numpy")
def _roots(x, count):
    for _ in range(count):
        for j in range(16):
            x[16 + j] = np.sqrt(x[j] + x[16 + j] / (1.0 + x[j]))


def exponent(sizes: Sequence[float] | np.ndarray, costs: Sequence[float] | np.ndarray) -> float:
    """Fit the exponent of a power law of cost over size, by a line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def cost_at(error: float, errors: Sequence[float], costs: Sequence[float]) -> float:
    """Interpolate the cost of a method at an error on its work-precision curve; inf if the error is not reached.

    Only points that no cheaper one beats are used. Interpolation is linear in log-log; if all errors are smaller,
    the least cost is returned.
    """
    front: list[tuple[float, float]] = []
    for cost, reached_error in sorted(zip(costs, errors, strict=True)):
        if not front or reached_error < front[-1][1]:
            front.append((cost, reached_error))
    index = next((k for k, (_, reached_error) in enumerate(front) if reached_error <= error), None)
    if index is None:
        return float("inf")
    if index == 0:
        return front[0][0]
    (c0, e0), (c1, e1) = front[index - 1], front[index]
    share = np.log(e0 / error) / np.log(e0 / e1)
    return float(c0 * (c1 / c0) ** share)
