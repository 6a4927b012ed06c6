"""The trials by which models are chosen: the first ball passes of a case, and of its healthy twin if asked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from bearingsim.config import Case
from bearingsim.selection.candidates import reference
from bearingsim.simulation.trial import Trial, passes_to_try
from bearingsim.study import Study, healthy_twin
from bearingsim.study.goal import HEALTHY
from bearingsim.study.jobs import identity


@dataclass(frozen=True)
class Trialled:
    """A trial to be computed: of which case, what is asked of it, how many ball passes."""

    id: str
    case: Case
    asked: tuple[str, ...]
    passes: int


Known = Mapping[str, Trial | None]
"""Trials by id; None for one that failed."""


def trials_of(study: Study, number: int, case: Case) -> list[Trialled]:
    """Those by which a candidate for a case of a study is judged: its own, and its healthy twin's if asked."""
    passes = passes_to_try(study.swept_cases[number][0])
    return [_trial(study, one, passes) for one in (case, twin_asked(study, case)) if one is not None]


def _trial(study: Study, case: Case, passes: int) -> Trialled:
    assert study.goal is not None
    asked = tuple(sorted({name.removesuffix(HEALTHY) for name in study.goal.of}))
    return Trialled(_named(case, asked, passes), case, asked, passes)


@lru_cache(maxsize=1 << 17)
def _named(case: Case, asked: tuple[str, ...], passes: int) -> str:
    """The id of a trial."""
    return identity(case, {"trial": passes, "asked": list(asked)})


def twin_asked(study: Study, case: Case) -> Case | None:
    """The healthy twin of a case, if what is asked is measured against that."""
    assert study.goal is not None
    return healthy_twin(case) if any(name.endswith(HEALTHY) for name in study.goal.of) else None


def first_trials(study: Study, numbers: Sequence[int]) -> list[Trialled]:
    """Those of the references of cases, each once."""
    cases = study.cases()
    return once([one for n in numbers for one in trials_of(study, n, reference(cases[n]))])


def once(trials: Sequence[Trialled]) -> list[Trialled]:
    """Trials without those that occur twice."""
    return list({one.id: one for one in trials}.values())


def repeats(study: Study, number: int, known: Known) -> bool:
    """Whether a case's reference was found to repeat itself: then it is the answer; or failed: then nothing is."""
    found = [known.get(one.id) for one in trials_of(study, number, reference(study.cases()[number]))]
    return any(one is None for one in found) or (found[0] is not None and found[0].repeats)
