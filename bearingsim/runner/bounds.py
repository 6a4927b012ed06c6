"""Bounds of a run: CPU time of a job and number of failed jobs."""

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.runner.packing import Cost
from bearingsim.runner.progress import duration
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.study import Job


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
        notes.append(f"{count} left out: estimated to take {most}over {bound} (`--max-cpu`)")
        if shown is not False:
            say(" ".join(notes), err=True)
    return Affordable([job for job, _ in kept], [cost for _, cost in kept], notes)


def ended_early(failed: int, max_failures: float) -> str:
    """Return a note on a run that the number of failed jobs has ended."""
    jobs = f"{failed} jobs" if failed > 1 else "1 job"
    allowed = "`--fail-fast`" if max_failures == 1 else f"`--max-failures {max_failures:g}`"
    return f"ended early: {jobs} failed ({allowed}); run the same command to go on without what failed"
