"""Grouping of jobs by cost: shards of a study, units of work, limits of CPU time and failures."""

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim import cpu_time, memory
from bearingsim.memory import PROGRAM_BYTES
from bearingsim.runner.progress import duration
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.study import Job


UNIT_S = 2.0  # s; intended CPU time of a unit, whose file takes 40 ms to write
MIN_UNIT_S, MAX_UNIT_S = 0.25, 10.0  # s; limits of the CPU time of a unit, in short and long studies
MIN_UNITS, MAX_UNITS = 3, 50  # units per worker: fewer leave workers idle at the end, more only add files
UNIT_BYTES = 64e6  # bytes; a unit is complete when its series reach this size


class Cost(NamedTuple):
    """Estimated cost of a job: CPU time in s, size of its series in bytes, and peak memory in bytes.

    spent: CPU time in s of the estimate itself; max_seconds: CPU time in s if the response is not periodic or the
    record does not end early, although ``seconds`` assumes so.
    """

    seconds: float
    bytes: float
    memory: float = 0.0
    spent: float = 0.0
    max_seconds: float = 0.0


NOTABLE_RATIO = 1.1  # smallest ratio of largest to expected CPU time of a study at which both are reported
CONDITIONS = {False: "the responses are periodic", True: "the records end early"}
"""Conditions of an expected CPU time; the key is True for a record that ends by `until`."""


def cost_text(cases: Sequence[Any], costs: Sequence[Cost], workers: int, scale: float = 1.0) -> str:
    """Format the expected and the largest CPU time of jobs, and the elapsed time on the workers.

    scale: ratio of the number of jobs in the study to that of ``costs``. Example: `2.5 s of CPU time if the
    responses are periodic, up to 30 s if not; 1.3 s to 15 s on 2 workers`.
    """
    expected, largest = (
        [scale * sum(seconds), max(max(seconds, default=0.0), scale * sum(seconds) / workers)]
        for seconds in ([cost.seconds for cost in costs], [max(cost.seconds, cost.max_seconds) for cost in costs])
    )
    workers_text = f"on {workers} worker{'s' * (workers > 1)}"
    if largest[0] < NOTABLE_RATIO * expected[0]:
        return f"{duration(expected[0])} of CPU time, {duration(expected[1])} {workers_text}"
    has_until = [
        getattr(case, "until", None) is not None
        for case, cost in zip(cases, costs, strict=True)
        if cost.max_seconds > cost.seconds
    ]
    condition = " and ".join(text for value, text in CONDITIONS.items() if value in has_until)
    return (
        f"{duration(expected[0])} of CPU time if {condition}, up to {duration(largest[0])} if not;"
        f" {duration(expected[1])} to {duration(largest[1])} {workers_text}"
    )


def select_shard(jobs: Sequence["Job"], shard: tuple[int, int]) -> list["Job"]:
    """Select shard ``k`` of ``n`` (from 1) of the jobs: every n-th job sorted by id, equal on every machine.

    Raises ValueError for a shard that does not exist.
    """
    k, n = shard
    if not 1 <= k <= n:
        raise ValueError(f"no shard {k}/{n}: shards run from 1/{n} to {n}/{n}")
    ids = {job.id for job in sorted(jobs, key=lambda job: job.id)[k - 1 :: n]}
    return [job for job in jobs if job.id in ids]


def pack(jobs: Sequence["Job"], costs: Sequence[Cost], workers: int) -> list[list[int]]:
    """Pack jobs into units; return the indices of the jobs of each unit, most expensive unit first.

    All jobs of a unit have the same time axis and channels. The CPU time of a unit is about ``unit_seconds``.
    """
    target = unit_seconds(sum(cost.seconds for cost in costs), workers)
    order = sorted(range(len(jobs)), key=lambda index: _axis_key(jobs[index].case))
    groups = [list(group) for _, group in groupby(order, key=lambda index: _axis_key(jobs[index].case))]
    units = [unit for group in groups for unit in _split(group, costs, target)]
    return sorted(units, key=lambda unit: -sum(costs[index].seconds for index in unit))


def unit_seconds(total: float, workers: int) -> float:
    """Compute the CPU time (s) of a unit from that of the study: 2 s, less for short and more for long studies."""
    share = total / workers
    seconds = max(min(UNIT_S, share / MIN_UNITS), share / MAX_UNITS)
    return min(max(seconds, MIN_UNIT_S), MAX_UNIT_S)


def workers_in_memory(costs: Sequence[Cost], workers: int) -> int:
    """Compute the number of workers that fit into memory even if they run the largest jobs together, at least 1.

    Besides the running job, a worker stores the results of its unit in double precision.
    """
    by_memory = sorted((PROGRAM_BYTES + cost.memory for cost in costs), reverse=True)
    result_bytes = 2.0 * min(UNIT_BYTES, sum(cost.bytes for cost in costs))
    worker_bytes = [job_bytes + result_bytes for job_bytes in by_memory[:workers]]
    return next((n for n in range(workers, 1, -1) if PROGRAM_BYTES + sum(worker_bytes[:n]) <= memory.limit()), 1)


def worker_note(costs: Sequence[Cost], workers: int) -> Iterator[str]:
    """Yield a note if memory allows fewer workers than requested."""
    count = workers_in_memory(costs, workers)
    if count < workers:
        peak = max(cost.memory for cost in costs)
        yield (
            f"{count} worker{'s' * (count > 1)} instead of {workers}:"
            f" a job may need {peak / 1e9:.2g} GB of memory,"
            f" and {memory.limit() / 1e9:.2g} GB are available"
        )


def _axis_key(case: Any) -> str:
    """Return a string that is equal for cases with the same time axis and channels."""
    names = ("sampling", "duration", "antialias", "record")
    return repr([getattr(case, name, None) for name in names])


def _split(group: Sequence[int], costs: Sequence[Cost], target: float) -> Iterator[list[int]]:
    """Split jobs into units of about ``target`` seconds; a job of that CPU time or more is a unit of its own."""
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


class AffordableJobs(NamedTuple):
    """Jobs within the limit of CPU time, with their costs; notes: on the skipped jobs, if there are any."""

    jobs: list["Job"]
    costs: list[Cost]
    notes: list[str]


def check_limits(max_failures: float, max_cpu: float) -> None:
    """Raise ValueError for limits that no job can satisfy."""
    if max_failures < 1:
        raise ValueError(f"expected at least 1 failed job that ends the run, got {max_failures}")
    if not max_cpu > 0.0:
        raise ValueError(f"expected a CPU time above zero, got {max_cpu} s")


def select_affordable(
    jobs: Sequence["Job"], costs: Sequence[Cost], max_cpu: float, shown: bool | None
) -> AffordableJobs:
    """Select the jobs whose estimated CPU time is at most ``max_cpu`` s; shown: False to print nothing."""
    expensive = [cost.seconds for cost in costs if cost.seconds > max_cpu]
    pairs = [pair for pair in zip(jobs, costs, strict=True) if pair[1].seconds <= max_cpu]
    notes = []
    if expensive:
        count = f"{len(expensive)} jobs are" if len(expensive) > 1 else "1 job is"
        limit, longest = duration(max_cpu), max(expensive)
        estimate_text = (
            f"{'up to ' * (len(expensive) > 1)}{duration(longest)} of CPU time, " if isfinite(longest) else ""
        )
        notes.append(f"{count} skipped: estimated at {estimate_text}over {limit} (`--max-cpu`)")
        if shown is not False:
            say(" ".join(notes), err=True)
    return AffordableJobs([job for job, _ in pairs], [cost for _, cost in pairs], notes)


def early_end_note(failed: int, max_failures: float) -> str:
    """Return a note on a run that ended because too many jobs failed."""
    jobs = f"{failed} jobs" if failed > 1 else "1 job"
    option = "`--fail-fast`" if max_failures == 1 else f"`--max-failures {max_failures:g}`"
    return f"stopped early: {jobs} failed ({option}); run the same command to continue without them"


def estimate_costs(estimate: Callable[[Any], Any], jobs: Sequence["Job"], max_cpu: float) -> list[Cost]:
    """Estimate the costs of jobs; each estimate may take at most ``max_cpu`` s of CPU time.

    estimate: function of a case, as ``Engine.estimate``.
    """
    return [_estimate_cost(estimate, job.case, max_cpu) for job in jobs]


def _estimate_cost(estimate: Callable[[Any], Any], case: Any, max_cpu: float) -> Cost:
    """Estimate the cost of a job: infinite CPU time if the estimate itself exceeds ``max_cpu`` s.

    The cost of an invalid case is zero, because its simulation fails at once and reports the reason.
    """
    start = cpu_time.now()
    try:
        with cpu_time.at_most(max_cpu):
            estimated = estimate(case)
    except cpu_time.OutOfCpuTime:
        return Cost(inf, 0.0)
    except ValueError:
        return Cost(0.0, 0.0)
    quantities = float(estimated.cpu_seconds), float(estimated.bytes), float(estimated.max_memory)
    return Cost(*quantities, spent=cpu_time.now() - start, max_seconds=float(estimated.max_seconds))
