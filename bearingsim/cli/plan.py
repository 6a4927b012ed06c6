"""Plan of a study: its jobs with their CPU time, memory and disk space."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any

from bearingsim.text.announcer import COMPILATION_REMARK, SILENT, Announcer

if TYPE_CHECKING:
    from bearingsim.config import Case
    from bearingsim.runner.packing import Cost
    from bearingsim.simulation.choice import Choice
    from bearingsim.simulation.limits import Limits
    from bearingsim.simulation.time_grid import Estimate
    from bearingsim.study import Job, Study


MAX_PRICED = 100
"""Largest number of jobs that are priced, at 2 to 4 ms of CPU time each."""
UNEVEN_LOAD_WEIGHT = 5
"""Weight in MAX_PRICED of a job with uneven load along its rollers, which needs a 3D equilibrium."""
SLIPS_PER_DECADE = 50  # slip speeds per decade at which a friction curve is searched for its maximum
SLIP_DECADES = range(-9, 3)
"""Decades (m/s) of this search; absolute, because the slip at the peak of dry friction is independent of speed."""


@dataclass(frozen=True)
class PricedJob:
    """Job with its method, step (s), step limits (s) and price.

    friction_scale: the largest friction on the most loaded roller at rest (N), and the decay time (s) of its slip;
    nan and inf without friction. roller_drop: largest depth (m) of a roller in a defect, nan without defects.
    """

    job: "Job"
    choice: "Choice"
    step: float
    limits: "Limits"
    estimate: "Estimate"
    friction_scale: tuple[float, float]
    roller_drop: float


@dataclass(frozen=True)
class Plan:
    """Cases of a study with their healthy baselines and variations, priced.

    jobs: all jobs, of which a large study prices only a sample (``sample_jobs``). refusals: jobs that cannot run,
    with reasons. friction_seconds: CPU time (s) of the priced jobs if all are computed with friction, which the
    models still to be chosen may need; nan if they are chosen, or the friction is specified.
    """

    study: "Study"
    jobs: tuple["Job", ...]
    cases: tuple[PricedJob, ...]
    baselines: tuple[PricedJob, ...]
    variations: tuple[PricedJob, ...]
    refusals: tuple[tuple["Job", str], ...]
    requested_workers: int
    friction_seconds: float = math.nan

    @property
    def costs(self) -> list["Cost"]:
        """Costs used to distribute jobs over workers and to limit the number of workers by memory."""
        from bearingsim.runner.packing import Cost

        estimates = [priced.estimate for priced in self.priced_jobs]
        return [
            Cost(price.cpu_seconds, price.bytes, price.max_memory, max_seconds=price.max_seconds)
            for price in estimates
        ]

    @property
    def workers(self) -> int:
        """Number of worker processes: the requested number, or fewer if memory limits it."""
        from bearingsim.runner.packing import workers_in_memory

        return workers_in_memory(self.costs, self.requested_workers)

    @property
    def refusal_texts(self) -> tuple[str, ...]:
        """Reasons why jobs cannot be run, one text per kind."""
        return tuple(_group_refusals(self.refusals, self.study, self.sample_text))

    @property
    def job_counts(self) -> tuple[int, int, int, int]:
        """Numbers of cases, healthy cases, variations and audits of the study, including refused ones."""
        baselines = sum(job.is_baseline for job in self.jobs)
        further = [job for job in self.jobs if job.is_variation]
        audits = 0
        if self.study.selection is not None:  # without one there are no audits
            variations = {variation.job.id for variation in self.study.variations()}
            audits = sum(job.id not in variations for job in further)
        return len(self.jobs) - baselines - len(further), baselines, len(further) - audits, audits

    @property
    def scale(self) -> float:
        """Ratio of the number of jobs to that of the sample (priced or refused), at least 1."""
        return len(self.jobs) / self.sample_size

    @property
    def sample_size(self) -> int:
        """Number of jobs of the sample, priced or refused."""
        return len(self.priced_jobs) + len(self.refusals)

    @property
    def sample_text(self) -> str:
        """Words after the number of refused jobs, such as ` of 100 sampled`; empty if all jobs are priced."""
        return f" of {self.sample_size} sampled" * (self.sample_size < len(self.jobs))

    @property
    def priced_jobs(self) -> tuple[PricedJob, ...]:
        """All priced jobs: cases, healthy cases and variations."""
        return self.cases + self.baselines + self.variations

    @property
    def cpu_seconds(self) -> float:
        """Estimated CPU time (s) of all jobs."""
        return self.scale * sum(priced.estimate.cpu_seconds for priced in self.priced_jobs)

    @property
    def most_cpu_seconds(self) -> float:
        """Estimated CPU time (s) of all jobs if no response is periodic and no record ends early."""
        return self.scale * sum(priced.estimate.max_seconds for priced in self.priced_jobs)

    @property
    def wall_seconds(self) -> float:
        """Estimated time (s) on the workers: the longest job, or an even share of all."""
        longest = max((priced.estimate.cpu_seconds for priced in self.priced_jobs), default=0.0)
        return max(longest, self.cpu_seconds / self.workers)

    @property
    def bytes(self) -> int:
        """Estimated bytes on disk of all series, before compression."""
        return round(self.scale * sum(priced.estimate.bytes for priced in self.priced_jobs))


ESTIMATING = "estimating the cost of the jobs"
COMPILING = f"compiling code for the estimate (some seconds; {COMPILATION_REMARK})"


def price_study(study: "Study", workers: int | None, announcements: Announcer = SILENT) -> Plan:
    """Estimate the cost of the jobs of a study, or of a sample of many; refusals are collected, not raised."""
    from joblib import cpu_count

    from bearingsim.core.jit import compilation_callbacks

    announcements.begin(ESTIMATING)
    jobs, priced_jobs, refusals, friction_s = study.jobs(), [], [], math.nan
    with compilation_callbacks(lambda: announcements.begin(COMPILING), lambda: announcements.begin(ESTIMATING)):
        for job in sample_jobs(jobs):
            try:
                priced_jobs.append(_price(job))
            except ValueError as error:
                refusals.append((job, str(error)))
        if not refusals:
            study.assumptions  # noqa: B018 (evaluated now, because it may compile too)
            friction_s = friction_seconds(study, priced_jobs)
    return Plan(
        study=study,
        jobs=tuple(jobs),
        cases=tuple(
            priced for priced in priced_jobs if not priced.job.is_baseline and not priced.job.is_variation
        ),
        baselines=tuple(priced for priced in priced_jobs if priced.job.is_baseline),
        variations=tuple(priced for priced in priced_jobs if priced.job.is_variation),
        refusals=tuple(refusals),
        requested_workers=workers or cpu_count(),
        friction_seconds=friction_s,
    )


def friction_seconds(study: "Study", jobs: Sequence[PricedJob]) -> float:
    """Estimate the CPU time (s) of jobs if all are computed with friction, which prevents periodic responses.

    NaN if the models of the study are chosen, or its friction is specified.
    """
    from bearingsim.selection.candidates import estimated_cpu_time, with_friction

    if study.goal is None or study.selection is not None:
        return math.nan
    cases = [with_friction(priced.job.case) for priced in jobs]
    if all(case is None for case in cases):
        return math.nan
    return sum(
        priced.estimate.cpu_seconds if case is None else estimated_cpu_time(case)
        for priced, case in zip(jobs, cases, strict=True)
    )


def sample_jobs(jobs: "Sequence[Job]") -> "Sequence[Job]":
    """Sample the jobs if they exceed MAX_PRICED, reproducibly and in order.

    The sample includes the first and last job and the extremes of swept ranges, where most refusals occur.
    """
    from bearingsim.assemble.space import unevenly_loaded

    effort = sum(UNEVEN_LOAD_WEIGHT if unevenly_loaded(job.case) else 1 for job in jobs)
    if effort <= MAX_PRICED:
        return jobs
    size = MAX_PRICED * len(jobs) // effort
    candidates = [*extreme_jobs(jobs), *Random(len(jobs)).sample(range(len(jobs)), len(jobs))]
    return [jobs[index] for index in sorted([*dict.fromkeys(candidates)][:size])]


def extreme_jobs(jobs: "Sequence[Job]") -> Iterator[int]:
    """Yield the indices of the first and last job, and of the smallest and largest value of each swept path."""
    yield from (0, len(jobs) - 1)
    for path in jobs[0].swept:
        values = {
            index: value for index, job in enumerate(jobs) if isinstance(value := job.swept.get(path), float)
        }
        if values:
            yield from (min(values, key=values.__getitem__), max(values, key=values.__getitem__))


def _price(job: "Job") -> PricedJob:
    from bearingsim import assemble
    from bearingsim.assemble.scales import largest_roller_drop
    from bearingsim.catalogue import MODELS
    from bearingsim.simulation import choice, time_grid

    case = job.case
    grid, limits = time_grid.make_grid(case), choice.limits(case)
    price, friction = time_grid.estimate(case), friction_scale(case, limits.rest_load)
    has_drop = case.defects and MODELS[case.model].loaded
    roller_drop = largest_roller_drop(assemble.model(case)) if has_drop else math.nan
    return PricedJob(job, choice.choose_method(case), grid.step, limits, price, friction, roller_drop)


def friction_scale(case: "Case", force: float) -> tuple[float, float]:
    """Compute the largest friction (N) at a normal force (N), and the decay time (s) of a roller's slip.

    The slip of a roller pressed between two races by a force Q decays as exp(-2 mu' Q R_w^2 t/I_r), where mu' is
    the largest derivative of the friction coefficient with respect to the slip speed.
    """
    from bearingsim import assemble
    from bearingsim.core.laws.friction.interface import mu_derivative_bound

    if case.friction is None:
        return math.nan, math.inf
    model = assemble.model(case)
    bearing, u = model.bearing, model.bearing.R_w * model.bearing.omega_b
    derivative = float(mu_derivative_bound(model.friction, u))
    decay_time = bearing.I_r / (2.0 * derivative * force * bearing.R_w**2) if derivative > 0.0 else math.inf
    return max_friction_coefficient(model.friction, u) * force, decay_time


@lru_cache(maxsize=1 << 10)
def max_friction_coefficient(law: Any, u: float) -> float:
    """Compute the largest friction coefficient of a law at the rolling speed ``u`` (m/s), within 1 %."""
    from bearingsim.core.laws.friction.interface import mu

    lowest, highest = (SLIPS_PER_DECADE * decade for decade in (SLIP_DECADES.start, SLIP_DECADES.stop))
    return max(float(mu(law, 10.0 ** (n / SLIPS_PER_DECADE), u)) for n in range(lowest, highest + 1))


def _group_refusals(refusals: Iterable[tuple["Job", str]], study: "Study", sample: str = "") -> Iterable[str]:
    """Yield a message for each group of refusals that differ only in numbers: count, first job and its reason.

    sample: words after the count.
    """
    from bearingsim.plots.labels import swept_text
    from bearingsim.runner.summary import failure_kind

    groups: dict[str, list[tuple[Job, str]]] = {}
    for job, text in refusals:
        groups.setdefault(failure_kind(text), []).append((job, text))
    for group in groups.values():
        job, text = group[0]
        position = swept_text(job.swept, study.units)
        count = f"{len(group)}{sample} jobs refused, the first at" if sample or len(group) > 1 else "refused:"
        yield f"{count} {position or 'the only case'}: {text}"
