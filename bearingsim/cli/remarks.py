"""Remarks below the table of `bearingsim check`: choices with their reasons, assumptions, warnings."""

import math
from collections.abc import Iterator

from bearingsim.cli.plan import Plan, Priced
from bearingsim.cli.screen import span
from bearingsim.config.rules.damping import WARNING

OPENS = 2.0  # times the static force; a larger impact force means that contacts have opened


def remarks(plan: Plan, verbose: bool) -> Iterator[str]:
    """Yield the remarks, one text each; verbose: also on methods, periodicity and the variation of damping."""
    yield from choices(plan)
    yield from in_full(plan)
    if verbose:
        yield from methods(plan)
        yield from repeating(plan)
    yield from (text for text in damping(plan) if verbose or text.startswith(WARNING))
    yield from hanging(plan)
    yield from varied(plan)
    if verbose:
        yield from unvaried(plan)
    yield from plan.study.assumptions
    yield from unsettled(plan)


WORTH_SAYING = 0.1  # fraction of the CPU time of a study, from which a cost is reported
HANGS = 0.999  # of a defect's depth; a roller with a smaller drop does not reach the floor
CLEARS_WALLS = 0.5  # of the depth of a V; below it the walls (slope 2 depth/width) are steeper than the roller


def hanging(plan: Plan) -> Iterator[str]:
    """Yield a remark if rollers rest on the rims of all defects, so that depth has no influence."""
    damaged = [
        priced for priced in plan.cases if priced.job.case.defects and priced.job.case.excitation == "envelope"
    ]
    depths = [min(defect.depth for defect in priced.job.case.defects) for priced in damaged]
    prisms = all(
        defect.shape in ("rectangular", "triangular") and priced.sinking < CLEARS_WALLS * defect.depth
        for priced in damaged
        for defect in priced.job.case.defects
    )
    if damaged and all(priced.sinking < HANGS * depth for priced, depth in zip(damaged, depths, strict=True)):
        reached, floors = (
            span(1e6 * d for d in part) for part in ([priced.sinking for priced in damaged], depths)
        )
        same = "; rectangle and triangle give equal results" if prisms else ""
        element = damaged[0].job.case.bearing.element
        yield f"{element}s drop {reached} um and do not reach the floor at {floors} um{same}"


def choices(plan: Plan) -> list[str]:
    """Return the models chosen for an `accuracy`, with the reasons, or a note that they are not chosen yet."""
    goal, selection = plan.study.goal, plan.study.selection
    if goal is None:
        return []
    if selection is None:
        models = ", ".join(f"`{name}`" for name in dict.fromkeys(priced.job.case.model for priced in plan.cases))
        return [f"model not chosen yet (`check --pilots` does it); estimate for the reference, {models}"]
    why: dict[str, list[str]] = {}
    for chosen in selection.jobs.values():
        why.setdefault(chosen.model, []).append(chosen.why)
    count = len(selection.jobs)
    texts = [f"`{model}` in {len(reasons)} of {count} cases: {reasons[0]}" for model, reasons in why.items()]
    return [*texts, *selection.notes]


def in_full(plan: Plan) -> Iterator[str]:
    """Yield the cost of stored series in a study with an `accuracy`, for which jobs are computed in full."""
    from bearingsim.runner.progress import duration
    from bearingsim.simulation.time_grid import estimate
    from bearingsim.study.goal import ended_early

    goal = plan.study.goal
    if goal is None:
        return
    stores = [priced for priced in plan.everything if priced.job.case.record]
    plain = [priced.job.case.model_copy(update={"record": ()}) for priced in stores]
    early = [ended_early(case, goal, plan.study.figures) for case in plain]
    saved = sum(
        priced.estimate.cpu_seconds - estimate(case).cpu_seconds
        for priced, case in zip(stores, early, strict=True)
        if case.until is not None and priced.job.case.until is None
    )
    if saved > WORTH_SAYING * sum(priced.estimate.cpu_seconds for priced in plan.everything):
        yield f"`record` stores series: about {duration(plan.share * saved)} of CPU time more than `record: []`"


def methods(plan: Plan) -> list[str]:
    """Return the methods chosen by `method: auto` with the reasons, and the scope of the step check."""
    automatic = [priced for priced in plan.everything if priced.job.case.method == "auto"]
    reasons: dict[str, list[str]] = {}
    for priced in automatic:
        reasons.setdefault(str(priced.choice.method), []).append(priced.choice.why)
    texts = [
        f"`{name}`{f' in {len(why)} of {len(automatic)} jobs' if len(reasons) > 1 else ''}: {why[0]}"
        for name, why in reasons.items()
    ]
    checks_step = [priced.job.case.checks_step for priced in plan.everything]
    if any(checks_step):
        whole = all(
            priced.job.case.step_check == "strict" for priced in plan.everything if priced.job.case.checks_step
        )
        where = "the whole run" if whole else "one period or the start of the run"
        texts.append(f"time step: checked on {where}; a 2.24 times shorter one must agree within 0.5 %")
    return texts


def repeating(plan: Plan) -> Iterator[str]:
    """Yield the number of jobs that may be periodic or end early, and the CPU time if none of them does."""
    from bearingsim.runner.progress import duration
    from bearingsim.simulation.choice import resolved
    from bearingsim.simulation.repetition import may_repeat

    shorter = [priced for priced in plan.everything if priced.estimate.most_seconds > priced.estimate.cpu_seconds]
    periodic = [priced for priced in shorter if may_repeat(resolved(priced.job.case))]
    early = [priced for priced in shorter if priced not in periodic]
    texts = (periodic, "responses may be periodic", "is"), (early, "records may end early", "does")
    for jobs, text, verb in texts:
        if jobs:
            more = sum(priced.estimate.most_seconds - priced.estimate.cpu_seconds for priced in jobs)
            most = duration(plan.cpu_seconds + plan.share * more)
            yield f"{len(jobs)} of {len(plan.everything)} {text}; CPU time if none {verb}: {most}"


def damping(plan: Plan) -> Iterator[str]:
    """Yield the contact damping of the study and its plausible range; nothing for models without damping."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.damping import Damped, sentences

    everything = plan.cases + plan.baselines
    acts = [priced for priced in everything if "damping" in MODELS[priced.job.case.model].abilities]
    limits = [priced.limits for priced in acts]
    yield from sentences([Damped(bounds.damping_time, bounds.damping_ratio, bounds.crossing) for bounds in limits])
    yield from dict.fromkeys(filter(None, map(caveat, acts)))


def caveat(priced: Priced) -> str:
    """Return the caveat of a case's damping law, or "" if it has none."""
    limits, law = priced.limits, priced.job.case.contact.damping
    opens = limits.impact_force > OPENS * limits.rest_load
    return str(law.caveat(opens)) if hasattr(law, "caveat") else ""


def varied(plan: Plan) -> Iterator[str]:
    """Yield the unknown quantities that the study varies, with their values and the number of cases."""
    from bearingsim.study.uncertainty import UNKNOWNS, group_by_kind

    tried = group_by_kind((variation.what, variation.value) for variation in plan.study.variations())
    for what, values in tried.items():
        jobs = {id(variation.case) for variation in plan.study.variations() if variation.what == what}
        cases, *_ = plan.counted
        of = f"{len(jobs)} of {cases} cases" if len(jobs) < cases else "each case"
        yield f"`uncertainty`: {UNKNOWNS[what].tried_text(what, values)}, in {of}"


def unvaried(plan: Plan) -> Iterator[str]:
    """Yield the cost of varying the damping, if the study does not vary it."""
    from bearingsim.runner.progress import duration
    from bearingsim.study.uncertainty import acts, sweeps_damping, unexamined

    tried = {variation.what for variation in plan.study.variations()}
    if "damping" not in tried and plan.study.uncertainty != () and not sweeps_damping(plan.study.units):
        damped = [priced for priced in plan.cases if acts("damping", priced.job.case)]
        if damped:
            yield unexamined(len(damped), duration, sum(priced.estimate.cpu_seconds for priced in damped))


def unsettled(plan: Plan) -> Iterator[str]:
    """Yield a remark on jobs whose initial transient has not decayed when their record begins."""
    from bearingsim.simulation.choice import resolved
    from bearingsim.simulation.settling import MOST, needed, remembered, remembers_start

    cases = [resolved(priced.job.case) for priced in plan.everything]
    slow = [case for case in cases if remembers_start(case)]
    if slow:
        jobs = f" ({len(slow)} of {len(cases)} jobs)" if len(slow) < len(cases) else ""
        left = f"{span(1e2 * remembered(case) for case in slow)} % of the initial transient is left"
        times = [needed(case) for case in slow]
        advice = f"needs {span(times)} s" if max(times) < math.inf else "is never damped"
        longer = "`settle: auto`" if max(times) <= MOST else "more damping"
        yield f"{left} when the record begins; the slowest mode {advice}; use {longer}{jobs}"
