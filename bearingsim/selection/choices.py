"""Study with the chosen models in its cases, and audits of the choices.

Choices are stored in ``choices.json`` before the first job. Later runs read them instead of choosing again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite, nan
from random import Random

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.errors import UserError
from bearingsim.selection.candidates import WITH_FRICTION, candidate_case, make_reference, with_friction
from bearingsim.selection.curves import error_scales, list_curves
from bearingsim.selection.trials import required_healthy_case
from bearingsim.store.choices import Choice, Choices
from bearingsim.study import Job, Study
from bearingsim.study.jobs import Audit, ModelChoice, Selection, case_id, identity

AUDITED_SHARE, MIN_AUDITED = 0.05, 3  # share and smallest number of the jobs of other models that are audited


def choice_key(study: Study, case: Case) -> str:
    """Return the identity of a case with the requested accuracy, under which its choice is stored."""
    assert study.goal is not None
    goal = {"within": study.goal.within, "of": list(study.goal.of)}
    return identity(case, goal | ({"friction": "tried"} if with_friction(case) is not None else {}))


def apply_choices(study: Study, choices: Choices) -> Study:
    """Return the study with the chosen models; every case must have a choice."""
    study_cases = [case for case, _ in study.swept_cases]
    case_choices = [choices[choice_key(study, case)] for case in study_cases]
    cases = [_chosen_case(study, study_cases, n, choice.candidate) for n, choice in enumerate(case_choices)]
    swept = tuple((case, values) for case, (_, values) in zip(cases, study.swept_cases, strict=True))
    ids = [case_id(case) for case in cases]
    curve_ids = tuple((curve.feature, tuple(ids[n] for n in curve.cases)) for curve in list_curves(study))
    reasons = dict(zip(ids, _model_choices(study, case_choices), strict=True))
    references = [_audit_case(case, choice) for case, choice in zip(study_cases, case_choices, strict=True)]
    selection = Selection(reasons, curve_ids, tuple(draw_audits(study, references, ids)))
    return replace(study, swept_cases=swept, selection=selection)


def _chosen_case(study: Study, study_cases: Sequence[Case], number: int, candidate: str) -> Case:
    """Return a case with the settings of its chosen candidate. Raises ``UserError`` if that does not apply."""
    make_case = {REFERENCE: make_reference, WITH_FRICTION: with_friction}.get(candidate)
    computed = (
        make_case(study_cases[number]) if make_case is not None else candidate_case(study, number, candidate)
    )
    if computed is None:
        raise UserError(
            f"choices.json names `{candidate}`, which cannot compute a case: remove the file to choose again"
        )
    return computed


def _model_choices(study: Study, case_choices: Sequence[Choice]) -> list[ModelChoice]:
    """Return the choices with errors that are bounds on the curves of the study.

    A choice may be from an earlier plan, whose curves had other cases and thus another largest value. If that was
    larger, the errors are larger relative to the present curves; if it was smaller, they are still bounds.
    """
    assert study.goal is not None
    study_curves, factors = list_curves(study), [dict[str, float]() for _ in case_choices]
    for name in study.goal.of:
        values = [choice.values.get(name) for choice in case_choices]
        error_scales_of_cases = error_scales(
            name, [nan if value is None else value for value in values], study_curves
        )
        for choice, scale, case_factors in zip(case_choices, error_scales_of_cases, factors, strict=True):
            earlier_scale = choice.scales.get(name)
            if earlier_scale is not None and not earlier_scale <= scale:
                case_factors[name] = earlier_scale / scale if scale else inf

    return [
        ModelChoice(
            choice.model,
            choice.why,
            *(_scale_errors(errors, case_factors) for errors in (choice.error, choice.nodes, choice.friction)),
        )
        for choice, case_factors in zip(case_choices, factors, strict=True)
    ]


def _scale_errors(errors: Mapping[str, float | None], factors: Mapping[str, float]) -> dict[str, float | None]:
    """Multiply errors by factors of their features, 1 by default; an infinite or unknown error is None."""
    products = {name: error * factors.get(name, 1.0) if error else error for name, error in errors.items()}
    return {name: error if error is not None and isfinite(error) else None for name, error in products.items()}


def _audit_case(case: Case, choice: Choice) -> Case:
    """Return the case that audits a choice: the reference, with friction if chosen or inferred from others."""
    friction_case = with_friction(case) if choice.inferred or choice.candidate == WITH_FRICTION else None
    return friction_case or make_reference(case)


def draw_audits(study: Study, references: Sequence[Case], ids: Sequence[str]) -> list[Audit]:
    """Draw a seeded sample of the jobs not computed by their reference, to be computed again by the reference.

    The rank of each job is random but does not depend on the others, so that further cases hardly change the
    sample. Otherwise an extended study could lose a failed audit, and claim the accuracy again.
    """
    auditable_jobs = [(name, case) for name, case in zip(ids, references, strict=True) if case_id(case) != name]
    if not auditable_jobs:
        return []
    sample_size = min(len(auditable_jobs), max(MIN_AUDITED, round(AUDITED_SHARE * len(auditable_jobs))))
    seed = references[0].seed
    sample = sorted(auditable_jobs, key=lambda job: Random(f"{seed} {job[0]}").random())[:sample_size]
    return [_audit(study, name, case) for name, case in sample]


def _audit(study: Study, job_id: str, case: Case) -> Audit:
    """Return the audit of a job, with its healthy counterpart if a feature is relative to it."""
    healthy = required_healthy_case(study, case)
    healthy_job = None if healthy is None else Job(healthy, is_variation=True)
    job = Job(case, baseline=healthy_job, is_variation=True)
    return Audit(job_id, job, healthy_job)
