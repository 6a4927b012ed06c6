"""Plan of a study: its jobs with their CPU time, memory and disk space."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any

from bearingsim.text.patience import ONCE, QUIET, Patience

if TYPE_CHECKING:
    from bearingsim.config import Case
    from bearingsim.runner.packing import Cost
    from bearingsim.simulation.choice import Choice
    from bearingsim.simulation.limits import Limits
    from bearingsim.simulation.time_grid import Estimate
    from bearingsim.study import Job, Study


MOST_PRICED = 100
"""Largest number of jobs that are priced, at 2 to 4 ms of CPU time each."""
IN_SPACE = 5
"""Weight in MOST_PRICED of a job with uneven load along its rollers, which needs a 3D equilibrium."""
SLIPS_PER_DECADE = 50  # slip speeds per decade at which a friction curve is searched for its maximum


@dataclass(frozen=True)
class Priced:
    """Job with its method, step (s), step limits (s) and price.

    friction_scale: the largest friction on the most loaded roller at rest (N), and the decay time (s) of its slip;
    nan and inf without friction. sinking: largest depth (m) of a roller in a defect, nan without defects.
    """

    job: "Job"
    choice: "Choice"
    step: float
    limits: "Limits"
    estimate: "Estimate"
    friction_scale: tuple[float, float]
    sinking: float


@dataclass(frozen=True)
class Plan:
    """Cases of a study with their healthy baselines and variations, priced.

    jobs: all jobs; a large study is priced by a sample (``drawn``). refusals: jobs that cannot run, with reasons.
    """

    study: "Study"
    jobs: tuple["Job", ...]
    cases: tuple[Priced, ...]
    baselines: tuple[Priced, ...]
    variations: tuple[Priced, ...]
    refusals: tuple[tuple["Job", str], ...]
    asked_workers: int

    @property
    def costs(self) -> list["Cost"]:
        """Costs used to distribute jobs over workers and to limit the number of workers by memory."""
        from bearingsim.runner.packing import Cost

        estimates = [priced.estimate for priced in self.everything]
        return [Cost(price.cpu_seconds, price.bytes, price.most_memory) for price in estimates]

    @property
    def workers(self) -> int:
        """Number of worker processes: the requested number, or fewer if memory limits it."""
        from bearingsim.runner.packing import fitting

        return fitting(self.costs, self.asked_workers)

    @property
    def refused(self) -> tuple[str, ...]:
        """Reasons why jobs cannot be run, one text per kind."""
        return tuple(_grouped(self.refusals, self.study))

    @property
    def counted(self) -> tuple[int, int, int]:
        """Numbers of cases, healthy cases and variations of the study, including refused ones."""
        baselines = sum(job.is_baseline for job in self.jobs)
        varied = sum(job.is_variation for job in self.jobs)
        return len(self.jobs) - baselines - varied, baselines, varied

    @property
    def share(self) -> float:
        """Number of jobs for each job that was looked at, priced or refused; at least 1."""
        return len(self.jobs) / (len(self.everything) + len(self.refusals))

    @property
    def everything(self) -> tuple[Priced, ...]:
        """All priced jobs: cases, healthy cases and variations."""
        return self.cases + self.baselines + self.variations

    @property
    def cpu_seconds(self) -> float:
        """Estimated CPU time (s) of all jobs."""
        return self.share * sum(priced.estimate.cpu_seconds for priced in self.everything)

    @property
    def wall_seconds(self) -> float:
        """Estimated time (s) on the workers: the longest job, or an even share of all."""
        longest = max((priced.estimate.cpu_seconds for priced in self.everything), default=0.0)
        return max(longest, self.cpu_seconds / self.workers)

    @property
    def bytes(self) -> int:
        """Estimated bytes on disk of all series, before compression."""
        return round(self.share * sum(priced.estimate.bytes for priced in self.everything))


ESTIMATING = "estimating what the jobs take"
COMPILING = f"compiling what the estimate needs, some seconds: {ONCE}"


def plan_of(study: "Study", workers: int | None, patience: Patience = QUIET) -> Plan:
    """Price the jobs of a study, or a sample of many; refusals are collected, not raised."""
    from joblib import cpu_count

    from bearingsim.core.jit import compilation_callbacks

    patience.begin(ESTIMATING)
    jobs, priced, refusals = study.jobs(), [], []
    with compilation_callbacks(lambda: patience.begin(COMPILING), lambda: patience.begin(ESTIMATING)):
        for job in drawn(jobs):
            try:
                priced.append(_priced(job))
            except ValueError as error:
                refusals.append((job, str(error)))
        if not refusals:
            study.assumptions  # noqa: B018 (evaluated now, because it may compile too)
    return Plan(
        study=study,
        jobs=tuple(jobs),
        cases=tuple(item for item in priced if not item.job.is_baseline and not item.job.is_variation),
        baselines=tuple(item for item in priced if item.job.is_baseline),
        variations=tuple(item for item in priced if item.job.is_variation),
        refusals=tuple(refusals),
        asked_workers=workers or cpu_count(),
    )


def drawn(jobs: "Sequence[Job]") -> "Sequence[Job]":
    """Sample the jobs if they exceed MOST_PRICED, reproducibly and in order.

    The sample includes the first and last job and the extremes of swept ranges, where most refusals occur.
    """
    from bearingsim.assemble.space import unevenly_loaded

    effort = sum(IN_SPACE if unevenly_loaded(job.case) else 1 for job in jobs)
    if effort <= MOST_PRICED:
        return jobs
    count = MOST_PRICED * len(jobs) // effort
    order = [*ends(jobs), *Random(len(jobs)).sample(range(len(jobs)), len(jobs))]
    return [jobs[n] for n in sorted([*dict.fromkeys(order)][:count])]


def ends(jobs: "Sequence[Job]") -> Iterator[int]:
    """Yield the indices of the first and last job, and of the least and greatest value of each swept path."""
    yield from (0, len(jobs) - 1)
    for path in jobs[0].swept:
        values = {n: value for n, job in enumerate(jobs) if isinstance(value := job.swept.get(path), float)}
        if values:
            yield from (min(values, key=values.__getitem__), max(values, key=values.__getitem__))


def _priced(job: "Job") -> Priced:
    from bearingsim import assemble
    from bearingsim.assemble.scales import largest_roller_drop
    from bearingsim.catalogue import MODELS
    from bearingsim.simulation import choice, time_grid

    case = job.case
    cut, limits = time_grid.grid(case), choice.limits(case)
    price, rubs = time_grid.estimate(case), friction_scale(case, limits.rest_load)
    sinks = case.defects and MODELS[case.model].loaded
    sinking = largest_roller_drop(assemble.model(case)) if sinks else math.nan
    return Priced(job, choice.choice(case), cut.step, limits, price, rubs, sinking)


def friction_scale(case: "Case", force: float) -> tuple[float, float]:
    """Compute the largest friction (N) at a normal force (N), and the decay time (s) of a roller's slip.

    The slip of a roller pressed between two races by Q decays as exp(-2 mu' Q R_w^2/I_r t), with mu'
    the largest derivative of the friction curve.
    """
    from bearingsim import assemble
    from bearingsim.core.laws.friction.interface import mu_derivative_bound

    if case.friction is None:
        return math.nan, math.inf
    model = assemble.model(case)
    b, u = model.bearing, model.bearing.R_w * model.bearing.omega_b
    derivative = float(mu_derivative_bound(model.friction, u))
    settled = b.I_r / (2.0 * derivative * force * b.R_w**2) if derivative > 0.0 else math.inf
    return most_friction(model.friction, u) * force, settled


@lru_cache(maxsize=1 << 10)
def most_friction(law: Any, u: float) -> float:
    """Compute the largest friction coefficient of a law at the rolling speed ``u`` (m/s), within 1 %."""
    from bearingsim.core.laws.friction.interface import mu

    return max(float(mu(law, u * 10.0 ** (n / SLIPS_PER_DECADE), u)) for n in range(-4 * SLIPS_PER_DECADE, 1))


def _grouped(refusals: Iterable[tuple["Job", str]], study: "Study") -> Iterable[str]:
    """Yield one message for all refusals that differ only in numbers."""
    from bearingsim.plots.labels import described
    from bearingsim.runner.summary import kind_of

    groups: dict[str, list[tuple[Job, str]]] = {}
    for job, text in refusals:
        groups.setdefault(kind_of(text), []).append((job, text))
    for group in groups.values():
        job, text = group[0]
        where = described(job.swept, study.units)
        count = f"{len(group)} jobs refused, the first at" if len(group) > 1 else "refused:"
        yield f"{count} {where or 'the only case'}: {text}"
