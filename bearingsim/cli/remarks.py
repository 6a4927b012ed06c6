"""Remarks below the table of `bearingsim check`: choices with their reasons, assumptions, warnings."""

import math
from collections.abc import Iterator

from bearingsim.cli.plan import Plan, PricedJob
from bearingsim.cli.screen import span
from bearingsim.config.rules.damping import WARNING

OPENING_RATIO = 2.0  # times the static force; a larger impact force means that contacts have opened


def remarks(plan: Plan, verbose: bool) -> Iterator[str]:
    """Yield the remarks, one text each; verbose: also on methods, periodicity and the variation of damping."""
    yield from model_choices(plan)
    yield from friction_cost(plan)
    yield from series_cost(plan)
    if verbose:
        yield from method_choices(plan)
        yield from periodic_jobs(plan)
    yield from (text for text in damping(plan) if verbose or text.startswith(WARNING))
    yield from unreached_floors(plan)
    yield from reached_floors(plan)
    yield from varied_parameters(plan)
    if verbose:
        yield from unvaried_damping(plan)
    yield from plan.study.assumptions
    yield from empty_figures(plan)
    yield from initial_transients(plan)


def empty_figures(plan: Plan) -> Iterator[str]:
    """Yield a warning for each figure whose `where` selects no case."""
    cases = [swept for _, swept in plan.study.swept_cases]
    for number, figure in enumerate(plan.study.figures, 1):
        selects_any = any(
            all(_matches(swept.get(path), path, text) for path, text in figure.where.items()) for swept in cases
        )
        if figure.where and not selects_any:
            selection = ", ".join(f"{path}: {text}" for path, text in figure.where.items())
            yield f"{WARNING}figure {number} is empty: no case of the study has `{selection}`"


def _matches(value: float | str | None, path: str, text: str) -> bool:
    """Compare a swept value (SI) with one written as ``text``."""
    if not isinstance(value, float):
        return value == text
    from bearingsim.study import dimension
    from bearingsim.text.units import UnitError, parse

    kind = dimension(path)
    try:
        number = parse(text, kind) if kind else float(text)
    except (UnitError, ValueError):
        return False
    return math.isclose(value, number, rel_tol=1e-9)


NOTABLE_SHARE = 0.1  # fraction of the CPU time of a study, above which a cost is reported
FLOOR_RATIO = 0.999  # drop over depth of a defect, at or above which a roller touches the floor
WALL_CLEARANCE_RATIO = 0.5
"""Drop of a roller relative to the depth of a triangular defect, below which the roller touches only the rims,
because the walls (slope 2 depth/width) are steeper than its circle."""


def unreached_floors(plan: Plan) -> Iterator[str]:
    """Yield a remark if no roller reaches the floor of a defect or the walls of a triangular one."""
    envelope_jobs = _envelope_jobs(plan)
    depths = [_smallest_depth(priced) for priced in envelope_jobs]
    same_result = all(
        defect.shape in ("rectangular", "triangular") and priced.roller_drop < WALL_CLEARANCE_RATIO * defect.depth
        for priced in envelope_jobs
        for defect in priced.job.case.defects
    )
    if envelope_jobs and not any(_reaches_floor(priced) or _touches_walls(priced) for priced in envelope_jobs):
        drops, depth_range = (
            span(1e6 * d for d in values) for values in ([priced.roller_drop for priced in envelope_jobs], depths)
        )
        note = "; rectangle and triangle agree" if same_result else ""
        element = _element(envelope_jobs)
        yield f"by geometry, {element}s drop {drops} um and do not reach the floor at {depth_range} um{note}"


def reached_floors(plan: Plan) -> Iterator[str]:
    """Yield the depths at which rollers reach the floor of a defect, and the cases in which they do."""
    envelope_jobs = _envelope_jobs(plan)
    reaching = [priced for priced in envelope_jobs if _reaches_floor(priced)]
    if reaching:
        others = [priced for priced in envelope_jobs if not _reaches_floor(priced)]
        depth_range, element = span(1e6 * _smallest_depth(priced) for priced in reaching), _element(reaching)
        scope = f" {_distinction(reaching, others, plan)}" if others else ""
        scope_text = " there" if others else ""
        yield f"by geometry, {element}s reach the floor at {depth_range} um{scope}: the depth matters{scope_text}"


def _envelope_jobs(plan: Plan) -> list[PricedJob]:
    cases = [(priced, priced.job.case) for priced in plan.cases]
    return [priced for priced, case in cases if case.defects and case.excitation == "envelope"]


def _element(jobs: list[PricedJob]) -> str:
    return str(jobs[0].job.case.bearing.element)


def _smallest_depth(priced: PricedJob) -> float:
    return min(defect.depth for defect in priced.job.case.defects)


def _touches_walls(priced: PricedJob) -> bool:
    return any(
        defect.shape == "triangular" and priced.roller_drop >= WALL_CLEARANCE_RATIO * defect.depth
        for defect in priced.job.case.defects
    )


def _reaches_floor(priced: PricedJob) -> bool:
    return priced.roller_drop >= FLOOR_RATIO * _smallest_depth(priced)


def _distinction(jobs: list[PricedJob], others: list[PricedJob], plan: Plan) -> str:
    """Describe jobs by the values of a swept path that the others do not have, or else by their number.

    Three values or more are described as a range, in which no value of the others may lie.
    """
    from bearingsim.plots.labels import swept_text, value_text

    for path in jobs[0].job.swept:
        values = list(dict.fromkeys(priced.job.swept[path] for priced in jobs))
        other_values = {priced.job.swept[path] for priced in others}
        numbers = [value for value in values if isinstance(value, float)]
        is_range = len(numbers) == len(values) and not any(
            min(numbers) < value < max(numbers) for value in other_values if isinstance(value, float)
        )
        if not other_values & set(values) and (is_range or len(values) <= 2):
            ends = sorted(numbers) if len(numbers) == len(values) else values
            texts = [value_text(path, value, plan.study.units) for value in ends]
            range_text = f" to {texts[-1]}" if len(texts) > 2 else "".join(f" and {text}" for text in texts[1:])
            return f"for {swept_text({path: ends[0]}, plan.study.units)}{range_text}"
    return f"in {len(jobs)} of {len(jobs) + len(others)} cases"


def model_choices(plan: Plan) -> list[str]:
    """Return the models chosen for an `accuracy`, with a reason each, or a note that they are not chosen yet."""
    goal, selection = plan.study.goal, plan.study.selection
    if goal is None:
        return []
    if selection is None:
        models = ", ".join(f"`{name}`" for name in dict.fromkeys(priced.job.case.model for priced in plan.cases))
        return [f"model not chosen yet (`check --pilots` chooses it); estimate for the reference, {models}"]
    reasons_by_model: dict[str, list[str]] = {}
    for chosen in selection.jobs.values():
        reasons_by_model.setdefault(chosen.model, []).append(chosen.why)
    count = len(selection.jobs)
    texts = [
        f"`{model}` in {len(reasons)} of {count} cases: {reasons[0]}"
        for model, reasons in reasons_by_model.items()
    ]
    return [*texts, *selection.notes]


def friction_cost(plan: Plan) -> Iterator[str]:
    """Yield the CPU time if all jobs are computed with friction, in a study whose models are not chosen yet."""
    from bearingsim.runner.progress import duration

    if math.isfinite(plan.friction_seconds):
        seconds = duration(plan.scale * plan.friction_seconds)
        yield f"with friction, all jobs need {seconds} of CPU time plus the trials (`check --pilots`)"


def series_cost(plan: Plan) -> Iterator[str]:
    """Yield the cost of stored series in a study with an `accuracy`, for which jobs are computed in full."""
    from bearingsim.runner.progress import duration
    from bearingsim.simulation.time_grid import estimate
    from bearingsim.study.goal import add_early_end

    goal = plan.study.goal
    if goal is None:
        return
    series_jobs = [priced for priced in plan.priced_jobs if priced.job.case.record]
    bare_cases = [priced.job.case.model_copy(update={"record": ()}) for priced in series_jobs]
    cases = [add_early_end(case, goal, plan.study.figures) for case in bare_cases]
    extra = sum(
        priced.estimate.cpu_seconds - estimate(case).cpu_seconds
        for priced, case in zip(series_jobs, cases, strict=True)
        if case.until is not None and priced.job.case.until is None
    )
    if extra > NOTABLE_SHARE * sum(priced.estimate.cpu_seconds for priced in plan.priced_jobs):
        yield f"`record` stores series: about {duration(plan.scale * extra)} of CPU time more than `record: []`"


def method_choices(plan: Plan) -> list[str]:
    """Return the methods chosen by `method: auto` with a reason each, and the scope of the step check."""
    automatic = [priced for priced in plan.priced_jobs if priced.job.case.method == "auto"]
    reasons: dict[str, list[str]] = {}
    for priced in automatic:
        reasons.setdefault(str(priced.choice.method), []).append(priced.choice.reason)
    texts = [
        f"`{name}`{f' in {len(whys)} of {len(automatic)} jobs' if len(reasons) > 1 else ''}: {whys[0]}"
        for name, whys in reasons.items()
    ]
    checks_step = [priced.job.case.checks_step for priced in plan.priced_jobs]
    if any(checks_step):
        is_strict = all(
            priced.job.case.step_check == "strict" for priced in plan.priced_jobs if priced.job.case.checks_step
        )
        scope = "the whole run" if is_strict else "one period or the start of the run"
        texts.append(f"time step: checked on {scope}; a 2.24 times shorter one must agree within 0.5 %")
    return texts


def periodic_jobs(plan: Plan) -> Iterator[str]:
    """Yield the number of jobs that may be periodic or end early, and the CPU time if none of them does."""
    from bearingsim.runner.progress import duration
    from bearingsim.simulation.choice import resolve
    from bearingsim.simulation.repetition import may_repeat

    short_jobs = [
        priced for priced in plan.priced_jobs if priced.estimate.max_seconds > priced.estimate.cpu_seconds
    ]
    repeating = [priced for priced in short_jobs if may_repeat(resolve(priced.job.case))]
    early_ends = [priced for priced in short_jobs if priced not in repeating]
    texts = (repeating, "responses may be periodic", "is"), (early_ends, "records may end early", "does")
    for jobs, text, verb in texts:
        if jobs:
            extra_seconds = sum(priced.estimate.max_seconds - priced.estimate.cpu_seconds for priced in jobs)
            longest = duration(plan.cpu_seconds + plan.scale * extra_seconds)
            yield f"{len(jobs)} of {len(plan.priced_jobs)} {text}; CPU time if none {verb}: {longest}"


def damping(plan: Plan) -> Iterator[str]:
    """Yield the contact damping of the study and its plausible range; nothing for models without damping."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.damping import JobDamping, damping_remarks

    jobs = plan.cases + plan.baselines
    damped_jobs = [priced for priced in jobs if "damping" in MODELS[priced.job.case.model].abilities]
    limits = [priced.limits for priced in damped_jobs]
    yield from damping_remarks(
        [JobDamping(bounds.damping_time, bounds.damping_ratio, bounds.crossing) for bounds in limits]
    )
    yield from dict.fromkeys(filter(None, map(caveat, damped_jobs)))


def caveat(priced: PricedJob) -> str:
    """Return the caveat of a case's damping law, or "" if it has none."""
    limits, law = priced.limits, priced.job.case.contact.damping
    contact_opens = limits.impact_force > OPENING_RATIO * limits.rest_load
    return str(law.caveat(contact_opens)) if hasattr(law, "caveat") else ""


def varied_parameters(plan: Plan) -> Iterator[str]:
    """Yield the uncertain parameters that the study varies, with their values and the number of cases."""
    from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind

    values_by_kind = group_by_kind((variation.what, variation.value) for variation in plan.study.variations())
    for kind, values in values_by_kind.items():
        jobs = {id(variation.case) for variation in plan.study.variations() if variation.what == kind}
        cases, *_ = plan.job_counts
        scope = f"{len(jobs)} of {cases} cases" if len(jobs) < cases else "each case"
        yield f"`uncertainty`: {PARAMETER_KINDS[kind].text(kind, values)}, in {scope}"


def unvaried_damping(plan: Plan) -> Iterator[str]:
    """Yield the cost of varying the damping, if the study does not vary it."""
    from bearingsim.runner.progress import duration
    from bearingsim.study.uncertainty import damping_remark, has_effect, sweeps_damping

    varied_kinds = {variation.what for variation in plan.study.variations()}
    if "damping" not in varied_kinds and plan.study.uncertainty != () and not sweeps_damping(plan.study.units):
        damped_jobs = [priced for priced in plan.cases if has_effect("damping", priced.job.case)]
        if damped_jobs:
            count = sum(has_effect("damping", case) for case in plan.study.cases())  # including jobs not priced
            seconds = sum(priced.estimate.cpu_seconds for priced in damped_jobs) / len(damped_jobs)
            yield damping_remark(count, duration, count * seconds)


def initial_transients(plan: Plan) -> Iterator[str]:
    """Yield a remark on jobs whose initial transient has not decayed when their record begins."""
    from bearingsim.simulation.choice import resolve
    from bearingsim.simulation.settling import MAX_SETTLING, decay_time, has_transient, remaining_transient

    cases = [resolve(priced.job.case) for priced in plan.priced_jobs]
    slow_cases = [case for case in cases if has_transient(case)]
    if slow_cases:
        jobs = f" ({len(slow_cases)} of {len(cases)} jobs)" if len(slow_cases) < len(cases) else ""
        remainder = (
            f"{span(1e2 * remaining_transient(case) for case in slow_cases)} % of the initial transient is left"
        )
        times = [decay_time(case) for case in slow_cases]
        time_text = f"needs {span(times)} s" if max(times) < math.inf else "is never damped"
        remedy = "`settle: auto`" if max(times) <= MAX_SETTLING else "more damping"
        yield f"{remainder} when the record begins; the slowest mode {time_text}; use {remedy}{jobs}"
