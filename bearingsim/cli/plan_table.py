"""Printed plan of a study, as a table or as JSON."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from bearingsim.cli.plan import Plan, PricedJob
from bearingsim.cli.remarks import remarks
from bearingsim.cli.screen import console, print_table, span
from bearingsim.study.ranges import frequency, pressure
from bearingsim.text.numbers import significant

if TYPE_CHECKING:
    from bearingsim.study.design import SampledDesign


Row = tuple[str, Callable[[PricedJob], float]]
STEP_ROW: Row = ("step chosen (us)", lambda p: math.inf if is_adaptive(p) else 1e6 * p.step)
SAMPLING_ROW: Row = ("adaptive, recorded every (us)", lambda p: 1e6 * p.step if is_adaptive(p) else math.inf)


def line_frequency(name: str, share: float = 1.0) -> Callable[[PricedJob], float]:
    """Build a function that computes the frequency (Hz) of a line, times ``share``, at a job's highest speed."""
    return lambda p: share * frequency(p.job.case, name)


CASE_ROWS: tuple[Row, ...] = (
    ("BPFO (Hz)", line_frequency("BPFO")),
    ("BPFI (Hz)", line_frequency("BPFI")),
    ("BSF (Hz)", line_frequency("2BSF", 0.5)),
    ("FTF (Hz)", line_frequency("FTF")),
    ("largest force at rest (N)", lambda p: p.limits.rest_load),
    ("contact pressure (GPa)", lambda p: 1e-9 * pressure(p.job.case)),
)
DEFECT_ROWS: tuple[Row, ...] = (
    ("impact force, estimated (N)", lambda p: p.limits.impact_force),
    ("crossing of the defect (us)", lambda p: 1e6 * p.limits.crossing),
    ("samples per crossing", lambda p: p.limits.crossing * p.job.case.sampling),
    ("element drops by (um)", lambda p: 1e6 * p.roller_drop),
)
"""Rows of studies with defects."""
LIMIT_ROWS: tuple[Row, ...] = (
    ("step limit at rest (us)", lambda p: 1e6 * p.limits.at_rest),
    ("step limit at impact (us)", lambda p: 1e6 * p.limits.at_impact),
    ("contact frequency (kHz)", lambda p: 1e-3 * p.limits.contact_frequency),
    ("damping c/k at rest (us)", lambda p: 1e6 * p.limits.damping_time),
    ("damping ratio", lambda p: p.limits.damping_ratio),
    ("closing speed (mm/s)", lambda p: 1e3 * p.limits.closing_speed),
)
"""Step limits, and the contact properties that determine them."""
COST_ROW: Row = ("CPU time per job (s)", lambda p: p.estimate.cpu_seconds)
MEMORY_ROW: Row = ("memory per job, at most (MB)", lambda p: 1e-6 * p.estimate.max_memory)
STEP_CHECK_ROW: Row = ("of which step check (s)", lambda p: p.estimate.check_seconds)
FRICTION_ROWS: tuple[Row, ...] = (
    ("largest friction at rest (N)", lambda p: p.friction_scale[0]),
    ("slip time constant at rest (us)", lambda p: 1e6 * p.friction_scale[1]),
)
"""Rows of studies with friction. Lagged friction does not limit the step; but to resolve the decay of slip, the
step must be shorter than its time constant."""


def show(plan: Plan, verbose: bool) -> None:
    """Print the plan; verbose: also a row per case."""
    from bearingsim.config.scan.notes import notes
    from bearingsim.runner.packing import cost_text, worker_note

    study, screen = plan.study, console()
    swept = ", ".join(study.units) or "nothing"
    screen.print(f"{study.name}: {_job_counts(plan)}; sweeps {swept}", markup=False)
    if study.sampled_design is not None:
        screen.print(f"design: {study.sampled_design}; {_design_counts(study.sampled_design)}", markup=False)
    if plan.refusals or not plan.priced_jobs:
        return
    groups = _groups(plan.cases or plan.baselines)
    screen.print()
    sample_note = " in the estimate" * (len(plan.priced_jobs) < len(plan.jobs))
    headers = ["", *groups]
    rows = [
        [name, *(span(map(value, group)) for group in groups.values())]
        for name, value in _table_rows(plan, verbose)
    ]
    print_table(headers, [[f"cases{sample_note}", *(str(len(group)) for group in groups.values())], *rows])
    screen.print()
    if len(plan.priced_jobs) < len(plan.jobs):
        screen.print(f"estimated from {len(plan.priced_jobs)} of {len(plan.jobs)} jobs")
    for text in [
        *worker_note(plan.costs, plan.requested_workers),
        *remarks(plan, verbose),
        *study.notes,
        *notes(study.cases()),
    ]:
        screen.print(text, markup=False)
    if verbose:
        _show_cases(plan)
        screen.print()
    time = cost_text([priced.job.case for priced in plan.priced_jobs], plan.costs, plan.workers, plan.scale)
    screen.print(f"about {time}, at most {byte_text(plan.bytes)} of series", markup=False)


def is_adaptive(priced: PricedJob) -> bool:
    """Check if the method of a job adapts its step."""
    from bearingsim.catalogue import METHODS

    method = priced.choice.method
    return method is not None and METHODS[method].adaptive


def _table_rows(plan: Plan, verbose: bool) -> tuple[Row, ...]:
    """Return the rows of the table: frequencies, forces, defects, cost; verbose: also steps, limits, friction."""
    defects = DEFECT_ROWS if any(priced.job.case.defects for priced in plan.priced_jobs) else ()
    if not verbose:
        return (*CASE_ROWS, *defects, COST_ROW)
    has_friction = any(math.isfinite(priced.friction_scale[1]) for priced in plan.priced_jobs)
    checks_step = any(priced.job.case.checks_step for priced in plan.priced_jobs)
    adaptive = [is_adaptive(priced) for priced in plan.priced_jobs]
    steps = (*((STEP_ROW,) if not all(adaptive) else ()), *((SAMPLING_ROW,) if any(adaptive) else ()))
    method_rows = (*steps, *LIMIT_ROWS, *(FRICTION_ROWS if has_friction else ()))
    return (*CASE_ROWS, *defects, *method_rows, COST_ROW, *((STEP_CHECK_ROW,) if checks_step else ()), MEMORY_ROW)


def _job_counts(plan: Plan) -> str:
    refusal_count = len(plan.refusals)
    cases, baselines, variations, audits = plan.job_counts
    total = len(plan.jobs)
    kinds = [f"{cases} case{'s' * (cases != 1)}", f"{baselines} healthy baseline{'s' * (baselines != 1)}"]
    kinds += [f"{variations} variation{'s' * (variations != 1)}"] if variations else []
    kinds += [f"{audits} audit{'s' * (audits != 1)}"] if audits else []
    refusals = f", {refusal_count}{plan.sample_text} refused" if refusal_count else ""
    return f"{total} job{'s' * (total != 1)} ({', '.join(kinds)}){refusals}"


def _design_counts(design: "SampledDesign") -> str:
    rows, cases = len(design.cases), len(set(design.cases))
    return f"{rows} row{'s' * (rows != 1)}, {cases} case{'s' * (cases != 1)}"


def _groups(jobs: Sequence[PricedJob]) -> dict[str, list[PricedJob]]:
    groups: dict[str, list[PricedJob]] = {}
    for priced in jobs:
        groups.setdefault(" ".join(filter(None, [priced.job.case.model, priced.choice.method])), []).append(priced)
    return groups


def _show_cases(plan: Plan) -> None:
    from bearingsim.plots.labels import value_text

    units = plan.study.units
    lines = _table_rows(plan, verbose=True)
    headers = [*units, *(name for name, _ in lines)]
    rows = [
        [
            *(value_text(path, priced.job.swept[path], units) for path in units),
            *(span([f(priced)]) for _, f in lines),
        ]
        for priced in plan.cases
    ]
    print_table(headers, rows, text_columns=len(units))


def byte_text(count: int) -> str:
    """Format a number of bytes as `12 kB`, `3.4 MB`, `1.2 GB`."""
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= scale:
            return f"{significant(count / scale, 2)} {unit}"
    return f"{count} B"


def as_json(plan: Plan) -> str:
    """Return the plan as JSON, in SI; null means no limit. Jobs and refused jobs are those of the sample."""
    from bearingsim.config.scan.notes import notes

    cases, baselines, variations, audits = plan.job_counts
    entries = {
        "study": plan.study.name,
        "cases": cases,
        "twins": baselines,
        "variations": variations,
        "audits": audits,
        "cpu_seconds": plan.cpu_seconds,
        "most_cpu_seconds": plan.most_cpu_seconds,
        "wall_seconds": plan.wall_seconds,
        "workers": plan.workers,
        "bytes": plan.bytes,
        "design": None if plan.study.design is None else asdict(plan.study.design),
        "sampled_jobs": plan.sample_size,
        "refused_jobs": len(plan.refusals),
        "refused": list(plan.refusal_texts),
        "notes": [*plan.study.assumptions, *plan.study.notes, *notes(plan.study.cases())],
        "jobs": [_job_entry(priced) for priced in plan.priced_jobs],
    }
    return json.dumps(entries, indent=1)


def _job_entry(priced: PricedJob) -> dict[str, Any]:
    from bearingsim.config.rules import hierarchy

    job = priced.job
    friction = dict(zip(("friction", "slip_settles"), priced.friction_scale, strict=True))
    values = asdict(priced.limits) | friction
    limits = {name: value if math.isfinite(value) else None for name, value in values.items()}
    return {
        "job": job.id,
        "healthy": job.healthy,
        "twin": job.is_baseline,
        "variation": job.is_variation,
        "swept": job.swept,
        "model": job.case.model,
        "method": priced.choice.method,
        "method_asked": job.case.method,
        "method_why": priced.choice.reason,
        "least_model": hierarchy.simplest_model(job.case),
        "reasons": hierarchy.reasons(job.case),
        "step": priced.step,
        "limits": limits,
        "estimate": asdict(priced.estimate),
    }
