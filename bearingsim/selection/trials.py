"""What is tried before models are chosen: the first ball passes of each case, by its reference and others.

A reference whose motion repeats itself is computed to the end by its trial: it is the answer, and nothing cheaper
is tried. Of the others, every model that costs less goes through the same passes.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from bearingsim.catalogue import MODELS, below
from bearingsim.config import Case
from bearingsim.config.sections.ring import MAX_HARMONICS
from bearingsim.simulation.time_grid import estimate
from bearingsim.simulation.trial import Trial, passes_to_try
from bearingsim.study import Study, healthy_twin
from bearingsim.study.goal import HEALTHY
from bearingsim.study.jobs import identity

FEW_HARMONICS, FEW_SLICES = "8", 0.5
AS_SAID, FEWER_HARMONICS, FEWER_SLICES = (
    "the harmonics that are said",
    f"{FEW_HARMONICS} harmonics",
    "half the slices",
)
CANDIDATES = (FEWER_SLICES, AS_SAID, FEWER_HARMONICS, *reversed(MODELS))
"""The names of all of them, from the highest."""
WORTH_TRYING = 0.8  # of what the reference takes: a model that saves less is not tried


@dataclass(frozen=True)
class Trialled:
    """A trial to be computed: of which case, what is asked of it, how many ball passes."""

    id: str
    case: Case
    asked: tuple[str, ...]
    passes: int


Known = Mapping[str, Trial | None]
"""Trials by id; None for one that failed."""


def trial_of(study: Study, case: Case, passes: int) -> Trialled:
    """The trial of a case."""
    assert study.goal is not None
    asked = tuple(sorted({name.removesuffix(HEALTHY) for name in study.goal.of}))
    return Trialled(_named(case, asked, passes), case, asked, passes)


@lru_cache(maxsize=1 << 17)
def _named(case: Case, asked: tuple[str, ...], passes: int) -> str:
    """The id of a trial."""
    return identity(case, {"trial": passes, "asked": list(asked)})


def reference(case: Case) -> Case:
    """What a case is judged by: itself, with twice the harmonics where its ring bends."""
    ring = case.rig.ring
    if ring is None:
        return case
    more = ring.model_copy(update={"harmonics": min(MAX_HARMONICS, 2 * int(ring.harmonics))})
    return case.model_copy(update={"rig": case.rig.model_copy(update={"ring": more})})


def with_twin(study: Study, case: Case, passes: int) -> list[Trialled]:
    """The trial of a case, and of its healthy twin if what is asked is measured against that."""
    return [trial_of(study, one, passes) for one in (case, twin_asked(study, case)) if one is not None]


def twin_asked(study: Study, case: Case) -> Case | None:
    """The healthy twin of a case, if what is asked is measured against that."""
    assert study.goal is not None
    return healthy_twin(case) if any(name.endswith(HEALTHY) for name in study.goal.of) else None


def first_trials(study: Study, numbers: Sequence[int]) -> list[Trialled]:
    """Those of the references of cases, each once."""
    cases = study.cases()
    found = [one for n in numbers for one in with_twin(study, reference(cases[n]), passes_to_try(cases[n]))]
    return list({one.id: one for one in found}.values())


def repeats(study: Study, case: Case, known: Known) -> bool:
    """Whether a case's reference was found to repeat itself: then it is the answer; or failed: then nothing is."""
    found = [known.get(one.id) for one in with_twin(study, reference(case), passes_to_try(case))]
    return any(one is None for one in found) or (found[0] is not None and found[0].repeats)


def candidates(study: Study, numbers: Sequence[int], known: Known) -> dict[str, dict[int, Case]]:
    """What may be taken in place of a reference that does not repeat itself, if it costs less, by name."""
    cases = study.cases()
    return every_candidate(study, [n for n in numbers if not repeats(study, cases[n], known)])


def every_candidate(study: Study, numbers: Sequence[int]) -> dict[str, dict[int, Case]]:
    """The cases of each candidate that can be and costs less than the reference, by name, from the highest.

    None that two cases come to: their results would be one.
    """
    if study.otherwise is None:
        return {}
    own, found = study.cases(), {name: dict[int, Case]() for name in CANDIDATES}
    for n in numbers:
        if own[n].ramp is not None:
            continue  # its first passes, at one speed, tell nothing of those at another
        instead_of = price(reference(own[n]))
        for name in ladder(own[n]):
            case = computed_by(study, n, name)
            if case is not None and saves(case, instead_of):
                found[name][n] = case
    apart = {name: _told_apart(cases) for name, cases in found.items()}
    return {name: cases for name, cases in apart.items() if cases}


def _told_apart(cases: Mapping[int, Case]) -> dict[int, Case]:
    """The cases that are no other's equals."""
    ids = {n: identity(case) for n, case in cases.items()}
    count = Counter(ids.values())
    return {n: case for n, case in cases.items() if count[ids[n]] == 1}


def computed_by(study: Study, number: int, candidate: str) -> Case | None:
    """A case of a study as a candidate computes it; None if it cannot be."""
    own = study.swept_cases[number][0]
    given = ladder(own).get(candidate)
    if given is None:
        return None
    if not given or study.otherwise is None:
        return own
    return study.otherwise(given)[number]


def ladder(case: Case) -> dict[str, dict[str, str]]:
    """The candidates below the reference of a case, by name, and what each says otherwise."""
    found: dict[str, dict[str, str]] = {}
    if MODELS[case.model].sliced:
        found[FEWER_SLICES] = {"contact.slices": str(max(2, round(FEW_SLICES * int(case.contact.slices))))}
    if case.rig.ring is not None:
        found |= {AS_SAID: {}, FEWER_HARMONICS: {"rig.ring.harmonics": FEW_HARMONICS}}
    return found | {name: {"model": name} for name in below(case.model)}


def saves(case: Case, instead_of: float) -> bool:
    """Whether a case takes so much less CPU time than another (s) that it is worth trying."""
    return price(case) < WORTH_TRYING * instead_of


@lru_cache(maxsize=1 << 17)
def price(case: Case) -> float:
    """CPU time (s) of all of a case that does not repeat itself; infinite for one that is refused."""
    try:
        return estimate(case).most_seconds
    except ValueError:
        return float("inf")


def further_trials(study: Study, numbers: Sequence[int], known: Known) -> list[Trialled]:
    """Those of the candidates, where the reference does not repeat itself; each once."""
    own = study.cases()
    found = [
        one
        for cases in candidates(study, numbers, known).values()
        for n, case in cases.items()
        for one in with_twin(study, case, passes_to_try(own[n]))
    ]
    return list({one.id: one for one in found}.values())
