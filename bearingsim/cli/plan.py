"""`bearingsim check`: plan of a study, with its CPU time, memory and disk space."""

import json
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any

from bearingsim.cli.screen import console, print_table, significant, span
from bearingsim.study.ranges import frequency, pressure
from bearingsim.text.patience import ONCE, QUIET, Patience

if TYPE_CHECKING:
    from bearingsim.config import Case
    from bearingsim.runner.packing import Cost
    from bearingsim.simulation.choice import Choice
    from bearingsim.simulation.limits import Limits
    from bearingsim.simulation.time_grid import Estimate
    from bearingsim.study import Job, Study
    from bearingsim.study.design import Drawn

MOST_PRICED = 100
"""Largest number of jobs that are priced, at 2 to 4 ms of CPU time each."""
IN_SPACE = 5
"""Weight in MOST_PRICED of a job with uneven load along its rollers: equilibrium takes three dimensions."""


@dataclass(frozen=True)
class Priced:
    """A job with the method and the step (s) chosen for it, the limits of that step (s), and its price.

    friction_scale: the largest friction on the most loaded roller at rest (N), and the decay time (s) of its slip;
    nan and inf without friction. sinking: largest depth (m) of a roller in a pit, nan without pits.
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
    """A study's cases, their healthy baselines and variations, priced.

    jobs: all of them; a large study is priced by a sample (``drawn``). refusals: jobs that cannot be run, with the
    reason.
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
        """Costs by which jobs are packed for workers and the workers that fit into memory are counted."""
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
        """Reasons for which jobs cannot be run, one text a kind."""
        return tuple(_grouped(self.refusals, self.study))

    @property
    def counted(self) -> tuple[int, int, int]:
        """Numbers of cases, twins and variations of the study, including refused ones."""
        twins = sum(job.is_baseline for job in self.jobs)
        varied = sum(job.is_variation for job in self.jobs)
        return len(self.jobs) - twins - varied, twins, varied

    @property
    def share(self) -> float:
        """Number of jobs per priced job."""
        return len(self.jobs) / (len(self.everything) + len(self.refusals))

    @property
    def everything(self) -> tuple[Priced, ...]:
        """Cases, twins and variations."""
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

    from bearingsim.core.jit import heard

    patience.begin(ESTIMATING)
    jobs, priced, refusals = study.jobs(), [], []
    with heard(lambda: patience.begin(COMPILING), lambda: patience.begin(ESTIMATING)):
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
    """Compute the largest friction (N) under a force (N), and the decay time (s) of the slip of a roller.

    The slip of a roller between two races, each under the force Q, decays as exp(-2 mu' Q R_w^2/I_r t), with mu'
    the largest slope of the friction curve.
    """
    from bearingsim import assemble
    from bearingsim.core.laws.friction.interface import mu_slope_bound

    if case.friction is None:
        return math.nan, math.inf
    model = assemble.model(case)
    b, u = model.bearing, model.bearing.R_w * model.bearing.omega_b
    slope = float(mu_slope_bound(model.friction, u))
    settled = b.I_r / (2.0 * slope * force * b.R_w**2) if slope > 0.0 else math.inf
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


# Rows of the printed table, with one column per model and method


Line = tuple[str, Callable[[Priced], float]]
CHOSEN: Line = ("step chosen (us)", lambda p: math.inf if takes_own_steps(p) else 1e6 * p.step)
RECORDED: Line = ("own steps, recorded every (us)", lambda p: 1e6 * p.step if takes_own_steps(p) else math.inf)


def line_frequency(name: str, share: float = 1.0) -> Callable[[Priced], float]:
    """Return a function that computes the frequency (Hz) of a line, times ``share``, at a job's highest speed."""
    return lambda p: share * frequency(p.job.case, name)


LINES: tuple[Line, ...] = (
    ("BPFO (Hz)", line_frequency("BPFO")),
    ("BPFI (Hz)", line_frequency("BPFI")),
    ("BSF (Hz)", line_frequency("2BSF", 0.5)),
    ("FTF (Hz)", line_frequency("FTF")),
    ("largest force at rest (N)", lambda p: p.limits.rest_load),
    ("its pressure (GPa)", lambda p: 1e-9 * pressure(p.job.case)),
)
PITS: tuple[Line, ...] = (
    ("impact force, about (N)", lambda p: p.limits.impact_force),
    ("crossing of the pit (us)", lambda p: 1e6 * p.limits.crossing),
    ("samples in a crossing", lambda p: p.limits.crossing * p.job.case.sampling),
    ("an element sinks by (um)", lambda p: 1e6 * p.sinking),
)
"""Rows of studies with pits."""
LIMITS: tuple[Line, ...] = (
    ("step limit at rest (us)", lambda p: 1e6 * p.limits.at_rest),
    ("step limit at impact (us)", lambda p: 1e6 * p.limits.at_impact),
    ("contact frequency (kHz)", lambda p: 1e-3 * p.limits.contact_frequency),
    ("damping c/k at rest (us)", lambda p: 1e6 * p.limits.damping_time),
    ("damping ratio", lambda p: p.limits.damping_ratio),
    ("closing speed (mm/s)", lambda p: 1e3 * p.limits.closing_speed),
)
"""Step limits, and the contact properties that they follow from."""
COST: Line = ("CPU time of a job (s)", lambda p: p.estimate.cpu_seconds)
MEMORY: Line = ("memory of a job, at most (MB)", lambda p: 1e-6 * p.estimate.most_memory)
PROOF: Line = ("of it to prove its step (s)", lambda p: p.estimate.check_seconds)
FRICTION: tuple[Line, ...] = (
    ("friction at rest, at most (N)", lambda p: p.friction_scale[0]),
    ("slip at rest settles in (us)", lambda p: 1e6 * p.friction_scale[1]),
)
"""Rows of studies with friction. It lags by one step, so it sets no limit; a step below the time resolves it."""
SLIPS_PER_DECADE = 50  # slip speeds per decade at which a friction curve is searched for its maximum


def show(plan: Plan, verbose: bool) -> None:
    """Print the plan; verbose: also a row per case."""
    from bearingsim.cli.remarks import remarks
    from bearingsim.config.scan.repair import notes
    from bearingsim.runner.packing import fewer
    from bearingsim.runner.progress import duration

    study, out = plan.study, console()
    swept = ", ".join(study.units) or "nothing"
    out.print(f"{study.name}: {_counts(plan)}; sweeps {swept}", markup=False)
    if study.drawn is not None:
        out.print(f"design: {study.drawn}; {_rows(study.drawn)}", markup=False)
    if plan.refusals or not plan.everything:
        return
    groups = _groups(plan.cases or plan.baselines)
    out.print()
    of_some = " in the estimate" * (len(plan.everything) < len(plan.jobs))
    heads = ["", *groups]
    rows = [
        [name, *(span(map(value, group)) for group in groups.values())] for name, value in _lines(plan, verbose)
    ]
    print_table(heads, [[f"cases{of_some}", *(str(len(group)) for group in groups.values())], *rows])
    out.print()
    if len(plan.everything) < len(plan.jobs):
        out.print(f"estimated from {len(plan.everything)} of {len(plan.jobs)} jobs")
    for text in [
        *fewer(plan.costs, plan.asked_workers),
        *remarks(plan, verbose),
        *study.notes,
        *notes(study.cases()),
    ]:
        out.print(text, markup=False)
    if verbose:
        _show_cases(plan)
        out.print()
    time = f"{duration(plan.cpu_seconds)} of CPU time, {duration(plan.wall_seconds)} on {plan.workers}"
    out.print(f"about {time} worker{'s' * (plan.workers > 1)}, at most {size(plan.bytes)} of series", markup=False)


def takes_own_steps(priced: Priced) -> bool:
    """Return True if the method of a job adapts its step."""
    from bearingsim.catalogue import METHODS

    method = priced.choice.method
    return method is not None and METHODS[method].adaptive


def _lines(plan: Plan, verbose: bool) -> tuple[Line, ...]:
    """Return the rows of the table: frequencies, forces, pits, cost; verbose: also steps, limits, friction."""
    pits = PITS if any(priced.job.case.defects for priced in plan.everything) else ()
    if not verbose:
        return (*LINES, *pits, COST)
    rubs = any(math.isfinite(priced.friction_scale[1]) for priced in plan.everything)
    proves = any(priced.job.case.checks_step for priced in plan.everything)
    own = [takes_own_steps(priced) for priced in plan.everything]
    steps = (*((CHOSEN,) if not all(own) else ()), *((RECORDED,) if any(own) else ()))
    of_methods = (*steps, *LIMITS, *(FRICTION if rubs else ()))
    return (*LINES, *pits, *of_methods, COST, *((PROOF,) if proves else ()), MEMORY)


def _counts(plan: Plan) -> str:
    refused = len(plan.refusals)
    cases, twins, varied = plan.counted
    every = cases + twins + varied
    kinds = [f"{cases} case{'s' * (cases != 1)}", f"{twins} healthy twin{'s' * (twins != 1)}"]
    kinds += [f"{varied} variation{'s' * (varied != 1)}"] if varied else []
    rejected = f", {refused} refused" if refused else ""
    return f"{every} job{'s' * (every != 1)} ({', '.join(kinds)}){rejected}"


def _rows(drawn: "Drawn") -> str:
    rows, cases = len(drawn.cases), len(set(drawn.cases))
    return f"{rows} row{'s' * (rows != 1)}, {cases} case{'s' * (cases != 1)}"


def _groups(jobs: Sequence[Priced]) -> dict[str, list[Priced]]:
    groups: dict[str, list[Priced]] = {}
    for priced in jobs:
        groups.setdefault(" ".join(filter(None, [priced.job.case.model, priced.choice.method])), []).append(priced)
    return groups


def _show_cases(plan: Plan) -> None:
    from bearingsim.plots.labels import value_text

    units = plan.study.units
    lines = _lines(plan, verbose=True)
    heads = [*units, *(name for name, _ in lines)]
    rows = [
        [
            *(value_text(path, priced.job.swept[path], units) for path in units),
            *(span([f(priced)]) for _, f in lines),
        ]
        for priced in plan.cases
    ]
    print_table(heads, rows, words=len(units))


def size(count: int) -> str:
    """Format a number of bytes as `12 kB`, `3.4 MB`, `1.2 GB`."""
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= scale:
            return f"{significant(count / scale, 2)} {unit}"
    return f"{count} B"


def as_json(plan: Plan) -> str:
    """Return the plan as JSON, in SI; null stands for no limit."""
    from bearingsim.config.scan.repair import notes

    cases, twins, varied = plan.counted
    entries = {
        "study": plan.study.name,
        "cases": cases,
        "twins": twins,
        "variations": varied,
        "cpu_seconds": plan.cpu_seconds,
        "wall_seconds": plan.wall_seconds,
        "workers": plan.workers,
        "bytes": plan.bytes,
        "design": None if plan.study.design is None else asdict(plan.study.design),
        "refused_jobs": len(plan.refusals),
        "refused": list(plan.refused),
        "notes": [*plan.study.assumptions, *plan.study.notes, *notes(plan.study.cases())],
        "jobs": [_job_entry(priced) for priced in plan.everything],
    }
    return json.dumps(entries, indent=1)


def _job_entry(priced: Priced) -> dict[str, Any]:
    from bearingsim.config.rules import hierarchy

    job = priced.job
    friction = dict(zip(("friction", "slip_settles"), priced.friction_scale, strict=True))
    named = asdict(priced.limits) | friction
    limits = {name: value if math.isfinite(value) else None for name, value in named.items()}
    return {
        "job": job.id,
        "healthy": job.healthy,
        "twin": job.is_baseline,
        "variation": job.is_variation,
        "swept": job.swept,
        "model": job.case.model,
        "method": priced.choice.method,
        "method_asked": job.case.method,
        "method_why": priced.choice.why,
        "least_model": hierarchy.least(job.case),
        "reasons": hierarchy.reasons(job.case),
        "step": priced.step,
        "limits": limits,
        "estimate": asdict(priced.estimate),
    }
