"""Trials for model selection: first ball passes of a case, and of its healthy counterpart if needed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from bearingsim.config import Case
from bearingsim.config.names import MEANS
from bearingsim.selection.candidates import change_mesh, make_reference, with_friction
from bearingsim.simulation.ending import inspection_passes
from bearingsim.simulation.settling import cage_revolution_time, has_free_cage
from bearingsim.simulation.trial import (
    ReferenceValues,
    Trial,
    defect_revolution_time,
    may_become_record,
    shows_friction,
    trial_passes,
)
from bearingsim.study import Study, healthy_case
from bearingsim.study.goal import HEALTHY_SUFFIX
from bearingsim.study.jobs import identity


@dataclass(frozen=True)
class TrialRequest:
    """Trial to be computed: case, requested features, and number of ball passes.

    revolution_time: period (s) of the slowest defect, 0 if none rotates; that of the cage if it is longer and
    friction is not specified (``with_friction``); reference_values: at most one, with which the running trial is
    compared, to end it early.
    """

    id: str
    case: Case
    features: tuple[str, ...]
    passes: int
    revolution_time: float
    reference_values: tuple[ReferenceValues, ...] = ()


TrialResults = Mapping[str, Trial | None]
"""Trials by id; None for a failed trial."""


def trials_of(study: Study, number: int, case: Case) -> list[TrialRequest]:
    """List the trials of ``case``, a candidate for the case with index ``number``.

    The second is that of its healthy counterpart, if a requested feature is relative to it.
    """
    study_case = study.swept_cases[number][0]
    free_case = with_friction(study_case)
    revolution_time = (
        defect_revolution_time(study_case)
        if free_case is None
        else max(defect_revolution_time(study_case), cage_revolution_time(study_case))
    )
    healthy_free_case = None if free_case is None else required_healthy_case(study, free_case)
    passes = _pass_count(study_case, free_case, healthy_free_case)
    cases = [variant for variant in (case, required_healthy_case(study, case)) if variant is not None]
    # the same for a healthy case, which has no defects of its own
    settings = required_features(study), passes, revolution_time
    is_pair = len(cases) > 1 and has_free_cage(case)  # trials of a pair do not end early
    # the accuracy is part of the id of a trial that may end early, because its end depends on the accuracy
    may_end = has_free_cage(case) and not (is_pair or may_become_record(case))
    within = study.goal.within if study.goal is not None and may_end else None
    return [TrialRequest(_trial_id(variant, *settings, is_pair, within), variant, *settings) for variant in cases]


@lru_cache(maxsize=1 << 17)
def _pass_count(case: Case, *free_cases: Case | None) -> int:
    """Return the number of ball passes of the trials of a case.

    free_cases: the case with friction and its healthy counterpart, or None. If their trials may become records, no
    trial needs more passes than the shortest possible record.
    """
    passes = trial_passes(case, free_cases[0] is not None)
    earliest_ends = [
        next(inspection_passes(free)) for free in free_cases if free is not None and may_become_record(free)
    ]
    return min(passes, *earliest_ends) if earliest_ends else passes


def required_features(study: Study) -> tuple[str, ...]:
    """List the features needed from each trial of a study."""
    assert study.goal is not None
    return tuple(sorted({name.removesuffix(HEALTHY_SUFFIX) for name in study.goal.of}))


@lru_cache(maxsize=1 << 17)
def _trial_id(
    case: Case, features: tuple[str, ...], passes: int, revolution_time: float, is_pair: bool, within: float | None
) -> str:
    """Return the id of a trial.

    is_pair: whether it is used together with that of its healthy or faulty counterpart; within: accuracy of a
    trial that ends early if it is far from its reference, else None.
    """
    settings: dict[str, Any] = {"trial": passes, "asked": list(features)}
    settings |= (
        {"turn": float(f"{revolution_time:.12g}")} if revolution_time != defect_revolution_time(case) else {}
    )
    settings |= {"pair": True} if is_pair else {}
    settings |= {"within": within} if within is not None else {}
    bands = tuple(name for name in case.features if name not in MEANS)
    return identity(case.model_copy(update={"until": None, "features": bands}), settings)  # `until` has no effect


def required_healthy_case(study: Study, case: Case) -> Case | None:
    """Return the healthy counterpart of a case, if a feature is relative to it, else None."""
    assert study.goal is not None
    return healthy_case(case) if any(name.endswith(HEALTHY_SUFFIX) for name in study.goal.of) else None


def first_trials(study: Study, numbers: Sequence[int]) -> list[TrialRequest]:
    """Return the trials of the references, without duplicates.

    A case whose friction is not specified (``with_friction``) has none if its record is too short for a trial with
    friction (``shows_friction``) and it cannot be remeshed (``change_mesh``).
    """
    cases = study.cases()
    useful = [
        n for n in numbers if shows_friction(cases[n]) or with_friction(cases[n]) is None or change_mesh(cases[n])
    ]
    return unique([trial for n in useful for trial in trials_of(study, n, make_reference(cases[n]))])


def unique(trials: Sequence[TrialRequest]) -> list[TrialRequest]:
    """Return the trials without duplicates, by id."""
    return list({trial.id: trial for trial in trials}.values())


def is_decided(study: Study, number: int, trials: TrialResults) -> bool:
    """Check if no cheaper model is tried for a case.

    This is so if the response of its reference is periodic, or if a trial of the reference or of its healthy
    counterpart is missing or failed.
    """
    results = [trials.get(trial.id) for trial in trials_of(study, number, make_reference(study.cases()[number]))]
    return any(trial is None for trial in results) or (results[0] is not None and results[0].is_periodic)
