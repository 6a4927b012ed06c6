"""Plausible damping of rolling contacts, and warnings of other values.

docs/damping.md states the sources. c/k is the ratio of damping to stiffness of a contact under the static load,
which is the decay time of an overdamped contact.
"""

from collections.abc import Iterator, Sequence
from math import inf, isfinite
from typing import Any, NamedTuple

from bearingsim.text.numbers import span

PLAUSIBLE_RANGE = (0.3e-6, 25e-6)
"""s; plausible range of c/k of a lubricated contact, from measurements and theory."""
CROSSING_SHARE = 0.1
"""Largest c/k at which the roller can follow a defect, relative to the crossing time of the defect."""
WARNING = "warning: "
"""Prefix of a warning."""
RANGE_TOLERANCE = 1.0 + 1e-6
"""Relative tolerance of the bounds, so that a default at the end of the range lies within it."""


class JobDamping(NamedTuple):
    """Damping of a job: c/k (s), damping ratio, and shortest crossing time of a defect (s), inf without one."""

    time: float
    ratio: float
    crossing: float = inf

    @property
    def too_heavy(self) -> bool:
        """True if the roller cannot follow the defect."""
        return self.time > RANGE_TOLERANCE * PLAUSIBLE_RANGE[1] or self.time > CROSSING_SHARE * self.crossing

    @property
    def too_light(self) -> bool:
        """True if the damping is below that of a lubricated contact, as with dry steel."""
        return self.time * RANGE_TOLERANCE < PLAUSIBLE_RANGE[0]


def damping_remarks(jobs: Sequence[JobDamping]) -> Iterator[str]:
    """Yield the range of damping of the jobs beside the plausible range, then warnings of implausible damping."""
    if not jobs:
        return
    crossings = [job.crossing for job in jobs if isfinite(job.crossing)]
    crossing = f"; shortest crossing of a defect {1e6 * min(crossings):.3g} us" if crossings else ""
    times, ratios = _range([1e6 * job.time for job in jobs]), _range([job.ratio for job in jobs])
    low, high = (f"{1e6 * bound:g}" for bound in PLAUSIBLE_RANGE)
    yield f"damping: c/k {times} us (plausible: {low} to {high}), ratio {ratios}{crossing}"
    high_jobs, low_jobs = [job for job in jobs if job.too_heavy], [job for job in jobs if job.too_light]
    if high_jobs:
        reasons = [f"{high} us"] * any(job.time > RANGE_TOLERANCE * PLAUSIBLE_RANGE[1] for job in high_jobs)
        if any(job.time > CROSSING_SHARE * job.crossing for job in high_jobs):
            reasons.append("a tenth of the crossing")
        excess = f"c/k {_range([1e6 * job.time for job in high_jobs])} us, above {' and '.join(reasons)}"
        yield f"{WARNING}{excess}, so damping dominates the result{_count_text(high_jobs, jobs)}"
    if low_jobs:
        deficit = f"c/k {_range([1e6 * job.time for job in low_jobs])} us, below {low} us as for dry steel"
        yield f"{WARNING}{deficit}, so the motion may be chaotic{_count_text(low_jobs, jobs)}"


def result_remarks(info: Any) -> Iterator[str]:
    """Yield ``damping_remarks`` on finished jobs; info: table of attributes of the jobs (``Results.info``)."""
    columns = ["damping_time_s", "damping_ratio", "crossing_s"]
    if all(name in info for name in columns):
        yield from damping_remarks([JobDamping(*row) for row in info[columns].dropna().to_numpy().tolist()])


def _range(values: Sequence[float]) -> str:
    """Format the range of values."""
    return span(min(values), max(values), "{:.3g}".format)


def _count_text(selected: Sequence[JobDamping], jobs: Sequence[JobDamping]) -> str:
    """Format the number of selected jobs; empty if all are selected."""
    return "" if len(selected) == len(jobs) else f" ({len(selected)} of {len(jobs)} jobs)"
