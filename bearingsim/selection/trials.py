"""The trials by which models are chosen: the first ball passes of a case, and of its healthy twin if asked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from bearingsim.config import Case
from bearingsim.selection.candidates import recut, reference, with_friction
from bearingsim.simulation.settling import cage_turn
from bearingsim.simulation.trial import Against, Trial, passes_to_try, pit_turn, tells_friction
from bearingsim.study import Study, healthy_twin
from bearingsim.study.goal import HEALTHY
from bearingsim.study.jobs import identity


@dataclass(frozen=True)
class Trialled:
    """A trial to be computed: of which case, what is asked of it, how many ball passes, cut by which turn (s).

    against: what it is compared with as it goes on, if it is.
    """

    id: str
    case: Case
    asked: tuple[str, ...]
    passes: int
    turn: float
    against: tuple[Against, ...] = ()


Known = Mapping[str, Trial | None]
"""Trials by id; None for one that failed."""


def trials_of(study: Study, number: int, case: Case) -> list[Trialled]:
    """Those by which a candidate for a case of a study is judged: its own, and its healthy twin's if asked."""
    own = study.swept_cases[number][0]
    loose = with_friction(own) is not None
    turn = max(pit_turn(own), cage_turn(own)) if loose else pit_turn(own)
    read = asked_of(study), passes_to_try(own, loose), turn  # the twin's as its case's: it has no pits
    cases = [one for one in (case, twin_asked(study, case)) if one is not None]
    return [Trialled(_named(one, *read), one, *read) for one in cases]


def asked_of(study: Study) -> tuple[str, ...]:
    """The features that each trial of a study is to have."""
    assert study.goal is not None
    return tuple(sorted({name.removesuffix(HEALTHY) for name in study.goal.of}))


@lru_cache(maxsize=1 << 17)
def _named(case: Case, asked: tuple[str, ...], passes: int, turn: float) -> str:
    """The id of a trial."""
    told = {"trial": passes, "asked": list(asked)}
    return identity(case, told if turn == pit_turn(case) else told | {"turn": float(f"{turn:.12g}")})


def twin_asked(study: Study, case: Case) -> Case | None:
    """The healthy twin of a case, if what is asked is measured against that."""
    assert study.goal is not None
    return healthy_twin(case) if any(name.endswith(HEALTHY) for name in study.goal.of) else None


def first_trials(study: Study, numbers: Sequence[int]) -> list[Trialled]:
    """Return those of the references of cases, each once; none of a record that is too short for friction."""
    cases = study.cases()
    wanted = [n for n in numbers if tells_friction(cases[n]) or with_friction(cases[n]) is None or recut(cases[n])]
    return once([one for n in wanted for one in trials_of(study, n, reference(cases[n]))])


def once(trials: Sequence[Trialled]) -> list[Trialled]:
    """Trials without those that occur twice."""
    return list({one.id: one for one in trials}.values())


def repeats(study: Study, number: int, known: Known) -> bool:
    """Whether a case's reference was found to repeat itself: then it is the answer; or failed: then nothing is."""
    found = [known.get(one.id) for one in trials_of(study, number, reference(study.cases()[number]))]
    return any(one is None for one in found) or (found[0] is not None and found[0].repeats)
