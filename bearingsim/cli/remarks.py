"""What `bearingsim check` says in words below its table: what was chosen and why, and what to keep in mind."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from bearingsim.cli.screen import span
from bearingsim.config.rules.damping import WARNING

if TYPE_CHECKING:
    from bearingsim.cli.plan import Plan, Priced

__all__ = ["remarks"]

OPENS = 2.0  # times the force at rest: an impact by which contacts have opened
NOTABLE = 0.01  # of the start: what may be left of it when the record begins, without a word


def remarks(plan: "Plan", verbose: bool) -> Iterator[str]:
    """What is said, one text each; verbose: also of methods, repetition and damping, and what varying it takes."""
    yield from choices(plan)
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


HANGS = 0.999  # of a pit's depth: what a roller sinks by that does not reach its floor
CLEARS_WALLS = 0.5  # the same of a V: its walls, of slope 2 depth/width, are steeper than the roller at its rims


def hanging(plan: "Plan") -> Iterator[str]:
    """Whether rollers hang on the rims of all pits, so that how deep they are does not count."""
    damaged = [one for one in plan.cases if one.job.case.defects and one.job.case.excitation == "envelope"]
    depths = [min(defect.depth for defect in one.job.case.defects) for one in damaged]
    prisms = all(
        defect.shape in ("rectangular", "triangular") and one.sinking < CLEARS_WALLS * defect.depth
        for one in damaged
        for defect in one.job.case.defects
    )
    if damaged and all(one.sinking < HANGS * depth for one, depth in zip(damaged, depths, strict=True)):
        reached, floors = (span(1e6 * d for d in part) for part in ([one.sinking for one in damaged], depths))
        same = "; rectangle and triangle are the same" if prisms else ""
        yield f"rollers sink {reached} um and do not reach the floor, {floors} um{same}"


def choices(plan: "Plan") -> list[str]:
    """Which models an `accuracy` has led to, and why; or that this is not known yet."""
    goal, found = plan.study.goal, plan.study.selection
    if goal is None:
        return []
    if found is None:
        models = ", ".join(f"`{name}`" for name in dict.fromkeys(priced.job.case.model for priced in plan.cases))
        return [f"model: chosen as the run begins, or by `check --pilots`; priced as the reference, {models}"]
    why: dict[str, list[str]] = {}
    for chosen in found.jobs.values():
        why.setdefault(chosen.model, []).append(chosen.why)
    count = len(found.jobs)
    told = [f"`{model}` in {len(reasons)} of {count} cases: {reasons[0]}" for model, reasons in why.items()]
    return [*told, *found.notes]


def methods(plan: "Plan") -> list[str]:
    """Which methods `method: auto` has chosen, and why: a text for each; and how their steps are proven."""
    automatic = [one for one in plan.everything if one.job.case.method == "auto"]
    found: dict[str, list[str]] = {}
    for one in automatic:
        found.setdefault(str(one.choice.method), []).append(one.choice.why)
    told = [
        f"`{name}`{f' in {len(why)} of {len(automatic)} jobs' if len(found) > 1 else ''}: {why[0]}"
        for name, why in found.items()
    ]
    checks_step = [one.job.case.checks_step for one in plan.everything]
    if any(checks_step):
        whole = all(one.job.case.step_check == "strict" for one in plan.everything if one.job.case.checks_step)
        where = "the whole run" if whole else "a period, or on the run's beginning"
        told.append(f"time step: checked on {where}; half of it may change line and RMS by 0.5 %")
    return told


def repeating(plan: "Plan") -> Iterator[str]:
    """How many jobs may repeat themselves, and what they would take if none did."""
    from bearingsim.runner.progress import duration

    found = [one for one in plan.everything if one.estimate.most_seconds > one.estimate.cpu_seconds]
    if found:
        most = plan.cpu_seconds + sum(one.estimate.most_seconds - one.estimate.cpu_seconds for one in found)
        count = f"{len(found)} of {len(plan.everything)}"
        yield f"{count} responses may be periodic; if none is: {duration(most)} of CPU time"


def damping(plan: "Plan") -> Iterator[str]:
    """How the study's own contacts are damped, beside what is plausible; nothing of models without damping."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.damping import Damped, sentences

    acts = [one for one in plan.cases + plan.baselines if "damping" in MODELS[one.job.case.model].abilities]
    found = [one.limits for one in acts]
    yield from sentences([Damped(each.damping_time, each.damping_ratio, each.crossing) for each in found])
    yield from dict.fromkeys(filter(None, map(caveat, acts)))


def caveat(priced: "Priced") -> str:
    """What is to be kept in mind of a case's damping law; nothing of one that has nothing to say."""
    limits, law = priced.limits, priced.job.case.contact.damping
    opens = limits.impact_force > OPENS * limits.rest_load
    return str(law.caveat(opens)) if hasattr(law, "caveat") else ""


def varied(plan: "Plan") -> Iterator[str]:
    """What the study varies of what is not known."""
    from bearingsim.study.uncertainty import UNKNOWNS, by_kind

    tried = by_kind((one.what, one.value) for one in plan.study.variations())
    for what, values in tried.items():
        jobs = {id(one.case) for one in plan.study.variations() if one.what == what}
        cases, *_ = plan.counted
        of = f"{len(jobs)} of {cases} cases" if len(jobs) < cases else "each case"
        yield f"`uncertainty`: {UNKNOWNS[what].tried_text(what, values)}, in {of}"


def unvaried(plan: "Plan") -> Iterator[str]:
    """What it would take to vary the damping, if the study does not."""
    from bearingsim.runner.progress import duration
    from bearingsim.study.uncertainty import acts, sweeps_damping, unexamined

    tried = {one.what for one in plan.study.variations()}
    if "damping" not in tried and plan.study.uncertainty != () and not sweeps_damping(plan.study.units):
        damped = [one for one in plan.cases if acts("damping", one.job.case)]
        if damped:
            yield unexamined(len(damped), duration, sum(one.estimate.cpu_seconds for one in damped))


def unsettled(plan: "Plan") -> Iterator[str]:
    """Jobs whose start has not decayed when their record begins."""
    from bearingsim.simulation.choice import resolved
    from bearingsim.simulation.settling import MOST, needed, remembered, slow_modes

    cases = [resolved(one.job.case) for one in plan.everything]
    slow = [case for case in cases if remembered(case) > NOTABLE and slow_modes(case) == 0]
    if slow:
        jobs = f"{len(slow)} of {len(cases)} jobs: " if len(slow) < len(cases) else ""
        left = f"{span(1e2 * remembered(case) for case in slow)} % of the start is left"
        times = [needed(case) for case in slow]
        advice = f"needs {span(times)} s" if max(times) < math.inf else "is never damped"
        longer = "`settle: auto`" if max(times) <= MOST else "more damping"
        yield f"{jobs}{left} when the record begins; the slowest mode {advice}: take {longer} (docs/start.md)"
