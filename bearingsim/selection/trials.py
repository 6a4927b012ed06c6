"""Trials for model selection: first ball passes of a case, and of its healthy counterpart if needed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from bearingsim.config import Case
from bearingsim.config.names import MEANS
from bearingsim.selection.candidates import recut, reference, with_friction
from bearingsim.simulation.settling import cage_turn
from bearingsim.simulation.trial import Against, Trial, defect_turn, passes_to_try, tells_friction
from bearingsim.study import Study, healthy_case
from bearingsim.study.goal import HEALTHY
from bearingsim.study.jobs import identity


@dataclass(frozen=True)
class Trialled:
    """Trial to be computed: case, requested features, number of ball passes, and period (s) of a turn.

    against: references with which the running trial is compared, to end it early.
    """

    id: str
    case: Case
    asked: tuple[str, ...]
    passes: int
    turn: float
    against: tuple[Against, ...] = ()


Known = Mapping[str, Trial | None]
"""Trials by id; None for a failed trial."""


def trials_of(study: Study, number: int, case: Case) -> list[Trialled]:
    """List the trials of a candidate ``case`` for case ``number``: its own, and a healthy one if needed."""
    own = study.swept_cases[number][0]
    loose = with_friction(own) is not None
    turn = max(defect_turn(own), cage_turn(own)) if loose else defect_turn(own)
    read = asked_of(study), passes_to_try(own, loose), turn  # the same for a healthy case, which has no defects
    cases = [variant for variant in (case, required_healthy_case(study, case)) if variant is not None]
    return [Trialled(_named(variant, *read), variant, *read) for variant in cases]


def asked_of(study: Study) -> tuple[str, ...]:
    """List the features needed from each trial of a study."""
    assert study.goal is not None
    return tuple(sorted({name.removesuffix(HEALTHY) for name in study.goal.of}))


@lru_cache(maxsize=1 << 17)
def _named(case: Case, features: tuple[str, ...], passes: int, turn: float) -> str:
    """Return the id of a trial."""
    settings = {"trial": passes, "asked": list(features)}
    bands = tuple(name for name in case.features if name not in MEANS)
    case = case.model_copy(update={"until": None, "features": bands})  # `until` does not affect a trial
    return identity(case, settings if turn == defect_turn(case) else settings | {"turn": float(f"{turn:.12g}")})


def required_healthy_case(study: Study, case: Case) -> Case | None:
    """Return the healthy counterpart of a case, if a feature is relative to it, else None."""
    assert study.goal is not None
    return healthy_case(case) if any(name.endswith(HEALTHY) for name in study.goal.of) else None


def first_trials(study: Study, numbers: Sequence[int]) -> list[Trialled]:
    """Return the trials of the references, each once; none if too short for friction and without other nodes."""
    cases = study.cases()
    wanted = [n for n in numbers if tells_friction(cases[n]) or with_friction(cases[n]) is None or recut(cases[n])]
    return once([trial for n in wanted for trial in trials_of(study, n, reference(cases[n]))])


def once(trials: Sequence[Trialled]) -> list[Trialled]:
    """Drop trials that occur twice."""
    return list({trial.id: trial for trial in trials}.values())


def repeats(study: Study, number: int, trials: Known) -> bool:
    """Check if the choice for a case is settled, because the trial of its reference is periodic or has failed."""
    results = [trials.get(trial.id) for trial in trials_of(study, number, reference(study.cases()[number]))]
    return any(trial is None for trial in results) or (results[0] is not None and results[0].repeats)
