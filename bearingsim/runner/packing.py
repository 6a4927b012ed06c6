"""Which jobs go together: shards of a study, and units of work of a sensible size."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim import memory
from bearingsim.memory import PROGRAM

if TYPE_CHECKING:
    from bearingsim.study import Job

__all__ = ["Cost", "fewer", "fitting", "pack", "shard_of"]

UNIT_S = 2.0  # computing that makes the 40 ms of a file small
SHORTEST_UNIT_S, LONGEST_UNIT_S = 0.25, 10.0
MIN_UNITS, MAX_UNITS = 3, 50  # per worker: fewer leave some idle at the end, more are only more files
UNIT_BYTES = 64e6


class Cost(NamedTuple):
    """Estimated price of a job: CPU time in s, series in bytes, and the most memory in bytes that it may take.

    spent: CPU time in s that the estimate itself took.
    """

    seconds: float
    bytes: float
    memory: float = 0.0
    spent: float = 0.0


def shard_of(jobs: Sequence["Job"], shard: tuple[int, int]) -> list["Job"]:
    """Share ``k`` of ``n`` (from 1) of the jobs: every n-th in the order of ids, the same on every machine.

    Raises ValueError for a share that does not exist.
    """
    k, n = shard
    if not 1 <= k <= n:
        raise ValueError(f"there is no shard {k}/{n}: count from 1/{n} to {n}/{n}")
    ours = {job.id for job in sorted(jobs, key=lambda job: job.id)[k - 1 :: n]}
    return [job for job in jobs if job.id in ours]


def pack(jobs: Sequence["Job"], costs: Sequence[Cost], workers: int) -> list[list[int]]:
    """Indices of the jobs of each unit, most expensive unit first.

    A unit has at least 2 s of computing unless there is too little of it for all workers, one time axis and
    one set of channels.
    """
    target = unit_seconds(sum(cost.seconds for cost in costs), workers)
    order = sorted(range(len(jobs)), key=lambda index: _axis(jobs[index].case))
    alike = [list(group) for _, group in groupby(order, key=lambda index: _axis(jobs[index].case))]
    units = [unit for group in alike for unit in _cut(group, costs, target)]
    return sorted(units, key=lambda unit: -sum(costs[index].seconds for index in unit))


def unit_seconds(total: float, workers: int) -> float:
    """Computing time in s of a unit of a study of ``total`` s: 2, less in a short study, more in a long one."""
    share = total / workers
    wanted = max(min(UNIT_S, share / MIN_UNITS), share / MAX_UNITS)
    return min(max(wanted, SHORTEST_UNIT_S), LONGEST_UNIT_S)


def fitting(costs: Sequence[Cost], workers: int) -> int:
    """How many worker processes have memory enough at once, whichever jobs they are given: at least one.

    Each holds what it has computed of its unit, in twice the precision, besides the job in hand.
    """
    heaviest = sorted((PROGRAM + cost.memory for cost in costs), reverse=True)
    held = 2.0 * min(UNIT_BYTES, sum(cost.bytes for cost in costs))
    each = [bytes + held for bytes in heaviest[:workers]]
    return next((n for n in range(workers, 1, -1) if PROGRAM + sum(each[:n]) <= memory.limit()), 1)


def fewer(costs: Sequence[Cost], workers: int) -> Iterator[str]:
    """A line that says so, if fewer run than asked for."""
    able = fitting(costs, workers)
    if able < workers:
        most = max(cost.memory for cost in costs)
        yield (
            f"{able} worker{'s' * (able > 1)} in place of {workers}: a job may take {most / 1e9:.2g} GB of memory,"
            f" and there are {memory.limit() / 1e9:.2g} GB"
        )


def _axis(case: Any) -> str:
    """Text that is the same for cases with one time axis and one set of channels."""
    names = ("sampling", "duration", "antialias", "record")
    return repr([getattr(case, name, None) for name in names])


def _cut(group: Sequence[int], costs: Sequence[Cost], target: float) -> Iterator[list[int]]:
    """Cut a run of jobs into units of ``target`` seconds; a job as long as that is a unit of its own."""
    unit, seconds, size = [], 0.0, 0.0
    for index in group:
        if costs[index].seconds >= target:
            yield [index]
            continue
        unit.append(index)
        seconds, size = seconds + costs[index].seconds, size + costs[index].bytes
        if seconds >= target or size >= UNIT_BYTES:
            yield unit
            unit, seconds, size = [], 0.0, 0.0
    if unit:
        yield unit
