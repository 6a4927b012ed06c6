"""Printed plan of a study, as a table or as JSON."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from bearingsim.cli.plan import Plan, Priced
from bearingsim.cli.remarks import remarks
from bearingsim.cli.screen import console, print_table, significant, span
from bearingsim.study.ranges import frequency, pressure

if TYPE_CHECKING:
    from bearingsim.study.design import Drawn


Line = tuple[str, Callable[[Priced], float]]
CHOSEN: Line = ("step chosen (us)", lambda p: math.inf if takes_own_steps(p) else 1e6 * p.step)
RECORDED: Line = ("adaptive, recorded every (us)", lambda p: 1e6 * p.step if takes_own_steps(p) else math.inf)


def line_frequency(name: str, share: float = 1.0) -> Callable[[Priced], float]:
    """Return a function that computes the frequency (Hz) of a line, times ``share``, at a job's highest speed."""
    return lambda p: share * frequency(p.job.case, name)


LINES: tuple[Line, ...] = (
    ("BPFO (Hz)", line_frequency("BPFO")),
    ("BPFI (Hz)", line_frequency("BPFI")),
    ("BSF (Hz)", line_frequency("2BSF", 0.5)),
    ("FTF (Hz)", line_frequency("FTF")),
    ("largest force at rest (N)", lambda p: p.limits.rest_load),
    ("contact pressure (GPa)", lambda p: 1e-9 * pressure(p.job.case)),
)
DEFECTS: tuple[Line, ...] = (
    ("impact force, estimated (N)", lambda p: p.limits.impact_force),
    ("crossing of the defect (us)", lambda p: 1e6 * p.limits.crossing),
    ("samples per crossing", lambda p: p.limits.crossing * p.job.case.sampling),
    ("element drops by (um)", lambda p: 1e6 * p.sinking),
)
"""Rows of studies with defects."""
LIMITS: tuple[Line, ...] = (
    ("step limit at rest (us)", lambda p: 1e6 * p.limits.at_rest),
    ("step limit at impact (us)", lambda p: 1e6 * p.limits.at_impact),
    ("contact frequency (kHz)", lambda p: 1e-3 * p.limits.contact_frequency),
    ("damping c/k at rest (us)", lambda p: 1e6 * p.limits.damping_time),
    ("damping ratio", lambda p: p.limits.damping_ratio),
    ("closing speed (mm/s)", lambda p: 1e3 * p.limits.closing_speed),
)
"""Step limits, and the contact properties that determine them."""
COST: Line = ("CPU time per job (s)", lambda p: p.estimate.cpu_seconds)
MEMORY: Line = ("memory per job, at most (MB)", lambda p: 1e-6 * p.estimate.most_memory)
PROOF: Line = ("of it for the step check (s)", lambda p: p.estimate.check_seconds)
FRICTION: tuple[Line, ...] = (
    ("largest friction at rest (N)", lambda p: p.friction_scale[0]),
    ("slip time constant at rest (us)", lambda p: 1e6 * p.friction_scale[1]),
)
"""Rows of studies with friction. It lags by one step, so it sets no limit; resolving it needs a smaller step."""


def show(plan: Plan, verbose: bool) -> None:
    """Print the plan; verbose: also a row per case."""
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
    """Check if the method of a job adapts its step."""
    from bearingsim.catalogue import METHODS

    method = priced.choice.method
    return method is not None and METHODS[method].adaptive


def _lines(plan: Plan, verbose: bool) -> tuple[Line, ...]:
    """Return the rows of the table: frequencies, forces, defects, cost; verbose: also steps, limits, friction."""
    defects = DEFECTS if any(priced.job.case.defects for priced in plan.everything) else ()
    if not verbose:
        return (*LINES, *defects, COST)
    rubs = any(math.isfinite(priced.friction_scale[1]) for priced in plan.everything)
    proves = any(priced.job.case.checks_step for priced in plan.everything)
    own = [takes_own_steps(priced) for priced in plan.everything]
    steps = (*((CHOSEN,) if not all(own) else ()), *((RECORDED,) if any(own) else ()))
    of_methods = (*steps, *LIMITS, *(FRICTION if rubs else ()))
    return (*LINES, *defects, *of_methods, COST, *((PROOF,) if proves else ()), MEMORY)


def _counts(plan: Plan) -> str:
    refused = len(plan.refusals)
    cases, baselines, varied = plan.counted
    every = cases + baselines + varied
    kinds = [f"{cases} case{'s' * (cases != 1)}", f"{baselines} healthy twin{'s' * (baselines != 1)}"]
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
    """Return the plan as JSON, in SI; null means no limit."""
    from bearingsim.config.scan.repair import notes

    cases, baselines, varied = plan.counted
    entries = {
        "study": plan.study.name,
        "cases": cases,
        "twins": baselines,
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
