"""Grouping of jobs by their cost: shards of a study, units of work, bounds of CPU time and failures."""

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim import cpu_time, memory
from bearingsim.memory import PROGRAM
from bearingsim.runner.progress import duration
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.study import Job


UNIT_S = 2.0  # s of CPU time of a unit, against which the 40 ms of its file are small
SHORTEST_UNIT_S, LONGEST_UNIT_S = 0.25, 10.0  # s of CPU time, in short and long studies
MIN_UNITS, MAX_UNITS = 3, 50  # per worker: fewer leave workers idle at the end, more only add files
UNIT_BYTES = 64e6  # largest size of the series of a unit


class Cost(NamedTuple):
    """Estimated price of a job: CPU time in s, series in bytes, and peak memory in bytes.

    spent: CPU time in s that the estimate itself took.
    """

    seconds: float
    bytes: float
    memory: float = 0.0
    spent: float = 0.0


def shard_of(jobs: Sequence["Job"], shard: tuple[int, int]) -> list["Job"]:
    """Select share ``k`` of ``n`` (from 1) of the jobs: every n-th in the order of ids, alike on every machine.

    Raises ValueError for a share that does not exist.
    """
    k, n = shard
    if not 1 <= k <= n:
        raise ValueError(f"no shard {k}/{n}: shards run from 1/{n} to {n}/{n}")
    ours = {job.id for job in sorted(jobs, key=lambda job: job.id)[k - 1 :: n]}
    return [job for job in jobs if job.id in ours]


def pack(jobs: Sequence["Job"], costs: Sequence[Cost], workers: int) -> list[list[int]]:
    """Pack jobs into units; return the indices of the jobs of each unit, most expensive unit first.

    The jobs of a unit share one time axis and one set of channels. A unit takes at least 2 s of CPU time unless
    the study is too short for all workers.
    """
    target = unit_seconds(sum(cost.seconds for cost in costs), workers)
    order = sorted(range(len(jobs)), key=lambda index: _axis(jobs[index].case))
    alike = [list(group) for _, group in groupby(order, key=lambda index: _axis(jobs[index].case))]
    units = [unit for group in alike for unit in _cut(group, costs, target)]
    return sorted(units, key=lambda unit: -sum(costs[index].seconds for index in unit))


def unit_seconds(total: float, workers: int) -> float:
    """Compute the CPU time (s) of a unit of a study of ``total`` s: 2 s, less in a short, more in a long one."""
    share = total / workers
    wanted = max(min(UNIT_S, share / MIN_UNITS), share / MAX_UNITS)
    return min(max(wanted, SHORTEST_UNIT_S), LONGEST_UNIT_S)


def fitting(costs: Sequence[Cost], workers: int) -> int:
    """Compute the number of workers that fit into memory with any choice of jobs, at least 1.

    A worker holds the results of its unit, in double precision, besides the running job.
    """
    heaviest = sorted((PROGRAM + cost.memory for cost in costs), reverse=True)
    held = 2.0 * min(UNIT_BYTES, sum(cost.bytes for cost in costs))
    each = [bytes + held for bytes in heaviest[:workers]]
    return next((n for n in range(workers, 1, -1) if PROGRAM + sum(each[:n]) <= memory.limit()), 1)


def fewer(costs: Sequence[Cost], workers: int) -> Iterator[str]:
    """Yield a line if memory allows fewer workers than requested."""
    able = fitting(costs, workers)
    if able < workers:
        most = max(cost.memory for cost in costs)
        yield (
            f"{able} worker{'s' * (able > 1)} in place of {workers}: a job may take {most / 1e9:.2g} GB of memory,"
            f" and there are {memory.limit() / 1e9:.2g} GB"
        )


def _axis(case: Any) -> str:
    """Return a text that is equal for cases with one time axis and one set of channels."""
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


class Affordable(NamedTuple):
    """Jobs within the bound of CPU time, with their costs; notes: a line on the jobs left out, if any."""

    jobs: list["Job"]
    costs: list[Cost]
    notes: list[str]


def refuse_bounds(max_failures: float, max_cpu: float) -> None:
    """Raise ValueError for bounds that no job can meet."""
    if max_failures < 1:
        raise ValueError(f"expected at least 1 failed job that ends the run, got {max_failures}")
    if not max_cpu > 0.0:
        raise ValueError(f"expected a CPU time above zero, got {max_cpu} s")


def affordable(jobs: Sequence["Job"], costs: Sequence[Cost], max_cpu: float, shown: bool | None) -> Affordable:
    """Select the jobs whose estimated CPU time is at most ``max_cpu`` s; shown: False prints nothing."""
    longer = [cost.seconds for cost in costs if cost.seconds > max_cpu]
    kept = [pair for pair in zip(jobs, costs, strict=True) if pair[1].seconds <= max_cpu]
    notes = []
    if longer:
        count = f"{len(longer)} jobs are" if len(longer) > 1 else "1 job is"
        bound, longest = duration(max_cpu), max(longer)
        most = f"{'up to ' * (len(longer) > 1)}{duration(longest)} of CPU time, " if isfinite(longest) else ""
        notes.append(f"{count} skipped: estimated at {most}over {bound} (`--max-cpu`)")
        if shown is not False:
            say(" ".join(notes), err=True)
    return Affordable([job for job, _ in kept], [cost for _, cost in kept], notes)


def ended_early(failed: int, max_failures: float) -> str:
    """Return a note on a run that the number of failed jobs has ended."""
    jobs = f"{failed} jobs" if failed > 1 else "1 job"
    allowed = "`--fail-fast`" if max_failures == 1 else f"`--max-failures {max_failures:g}`"
    return f"stopped early: {jobs} failed ({allowed}); run the same command to continue without them"


def costs(estimate: Callable[[Any], Any], jobs: Sequence["Job"], max_cpu: float) -> list[Cost]:
    """Estimate the costs of jobs whose CPU time is bounded by ``max_cpu`` s."""
    return [_cost(estimate, job.case, max_cpu) for job in jobs]


def _cost(estimate: Callable[[Any], Any], case: Any, max_cpu: float) -> Cost:
    """Estimate the cost of a job: zero for a refused case, whose simulation reports the reason.

    Infinite if the estimate itself takes longer than the CPU time (s) of a job.
    """
    began = cpu_time.now()
    try:
        with cpu_time.at_most(max_cpu):
            price = estimate(case)
    except cpu_time.OutOfCpuTime:
        return Cost(inf, 0.0)
    except ValueError:
        return Cost(0.0, 0.0)
    numbers = float(price.cpu_seconds), float(price.bytes), float(price.most_memory)
    return Cost(*numbers, spent=cpu_time.now() - began)
