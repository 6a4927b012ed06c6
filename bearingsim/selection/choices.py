"""Choices of a model for each case, and the study with these models in its cases.

Choices are stored in ``choices.json`` before the first job. Later runs read them instead of choosing again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite, nan
from random import Random

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.errors import UserError
from bearingsim.selection.candidates import WITH_FRICTION, candidate_case, reference, with_friction
from bearingsim.selection.curves import curves, scales
from bearingsim.selection.trials import required_healthy_case
from bearingsim.store.choices import Choice, Choices
from bearingsim.study import Job, Study
from bearingsim.study.jobs import Audit, ModelChoice, Selection, case_id, identity

AUDITED_SHARE, MIN_AUDITED = 0.05, 3


def key(study: Study, case: Case) -> str:
    """Return the identity of a case with its requested accuracy."""
    assert study.goal is not None
    goal = {"within": study.goal.within, "of": list(study.goal.of)}
    return identity(case, goal | ({"friction": "tried"} if with_friction(case) is not None else {}))


def apply_choices(study: Study, choices: Choices) -> Study:
    """Return the study with the chosen models; every case must have a choice."""
    study_cases = [case for case, _ in study.swept_cases]
    chosen = [choices[key(study, case)] for case in study_cases]
    cases = [_case(study, study_cases, n, choice.candidate) for n, choice in enumerate(chosen)]
    swept = tuple((case, values) for case, (_, values) in zip(cases, study.swept_cases, strict=True))
    ids = [case_id(case) for case in cases]
    curve_ids = tuple((curve.feature, tuple(ids[n] for n in curve.cases)) for curve in curves(study))
    reasons = dict(zip(ids, _model_choices(study, chosen), strict=True))
    references = [_audit_case(case, choice) for case, choice in zip(study_cases, chosen, strict=True)]
    selection = Selection(reasons, curve_ids, tuple(audits(study, references, ids)))
    return replace(study, swept_cases=swept, selection=selection)


def _case(study: Study, study_cases: Sequence[Case], number: int, candidate: str) -> Case:
    """Return a case with the settings of a candidate. Raises ``UserError`` if the candidate does not apply."""
    make_reference = {REFERENCE: reference, WITH_FRICTION: with_friction}.get(candidate)
    computed = (
        make_reference(study_cases[number])
        if make_reference is not None
        else candidate_case(study, number, candidate)
    )
    if computed is None:
        raise UserError(
            f"choices.json names `{candidate}`, which cannot compute a case: remove the file to choose again"
        )
    return computed


def _model_choices(study: Study, chosen: Sequence[Choice]) -> list[ModelChoice]:
    """Return the choices with errors that are bounds on the curves of the study.

    A choice may be of an earlier plan, whose curves had other cases and thus another largest value. If that was
    larger, the errors are larger on the present curves; if it was smaller, they remain bounds and are kept.
    """
    assert study.goal is not None
    study_curves, factors = curves(study), [dict[str, float]() for _ in chosen]
    for name in study.goal.of:
        values = [choice.values.get(name) for choice in chosen]
        sizes = scales(name, [nan if value is None else value for value in values], study_curves)
        for choice, size, case_factors in zip(chosen, sizes, factors, strict=True):
            earlier_size = choice.scales.get(name)
            if earlier_size is not None and not earlier_size <= size:
                case_factors[name] = earlier_size / size if size else inf

    return [
        ModelChoice(
            choice.model,
            choice.why,
            *(_scaled(errors, case_factors) for errors in (choice.error, choice.nodes, choice.friction)),
        )
        for choice, case_factors in zip(chosen, factors, strict=True)
    ]


def _scaled(errors: Mapping[str, float | None], factors: Mapping[str, float]) -> dict[str, float | None]:
    """Multiply errors by factors of their features, 1 by default; an infinite or unknown error is None."""
    products = {name: error * factors.get(name, 1.0) if error else error for name, error in errors.items()}
    return {name: error if error is not None and isfinite(error) else None for name, error in products.items()}


def _audit_case(case: Case, choice: Choice) -> Case:
    """Return the case that audits a choice: the reference, with friction if chosen or inferred from others."""
    friction_case = with_friction(case) if choice.inferred or choice.candidate == WITH_FRICTION else None
    return friction_case or reference(case)


def audits(study: Study, references: Sequence[Case], ids: Sequence[str]) -> list[Audit]:
    """Draw a seeded sample of the jobs of other models, to be computed again by their references.

    Each job has a random rank of its own, so that further cases hardly change the sample: otherwise a failed audit
    would be dropped from an extended study, and the accuracy restored.
    """
    replaced = [(name, case) for name, case in zip(ids, references, strict=True) if case_id(case) != name]
    if not replaced:
        return []
    sample_size = min(len(replaced), max(MIN_AUDITED, round(AUDITED_SHARE * len(replaced))))
    seed = references[0].seed
    sample = sorted(replaced, key=lambda job: Random(f"{seed} {job[0]}").random())[:sample_size]
    return [_audit(study, name, case) for name, case in sample]


def _audit(study: Study, job_id: str, case: Case) -> Audit:
    """Return the audit of a job, with its healthy counterpart if a feature is relative to it."""
    healthy = required_healthy_case(study, case)
    healthy_job = None if healthy is None else Job(healthy, is_variation=True)
    job = Job(case, baseline=healthy_job, is_variation=True)
    return Audit(job_id, job, healthy_job)
