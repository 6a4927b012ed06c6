"""What is tried before models are chosen: the first ball passes of each case, by its reference and others.

A reference whose motion repeats itself is computed to the end by its trial: it is the answer, and nothing cheaper
is tried. Of the others, every model that costs less goes through the same passes.
"""

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
AS_SAID = "the harmonics that are said"
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
    assert study.goal is not None
    twin = healthy_twin(case) if any(name.endswith(HEALTHY) for name in study.goal.of) else None
    return [trial_of(study, one, passes) for one in (case, twin) if one is not None]


def first_trials(study: Study, numbers: Sequence[int]) -> list[Trialled]:
    """Those of the references of cases, each once."""
    cases = study.cases()
    found = [one for n in numbers for one in with_twin(study, reference(cases[n]), passes_to_try(cases[n]))]
    return list({one.id: one for one in found}.values())


def repeats(study: Study, case: Case, known: Known) -> bool:
    """Whether a case's reference was found to repeat itself: then it is the answer; or failed: then nothing is."""
    found = known.get(trial_of(study, reference(case), passes_to_try(case)).id)
    return found is None or found.repeats


def candidates(study: Study, numbers: Sequence[int], known: Known) -> dict[str, dict[int, Case]]:
    """What may be taken in place of a reference that does not repeat itself, if it costs less, by name."""
    own = study.cases()
    open_cases = [n for n in numbers if not repeats(study, own[n], known)]
    return {name: cases for name, cases in every_candidate(study, open_cases).items() if cases}


def every_candidate(study: Study, numbers: Sequence[int]) -> dict[str, dict[int, Case]]:
    """The cases of each candidate that can be and costs less than the reference, by name, from the highest."""
    if not numbers or study.otherwise is None:
        return {}
    own, found = study.cases(), {}
    for name, given in ladder([own[n] for n in numbers]).items():
        others = study.otherwise(given) if given else own
        able = {n: others[n] for n in numbers}
        found[name] = {n: case for n, case in able.items() if case is not None and saves(case, reference(own[n]))}
    return found


def ladder(cases: Sequence[Case]) -> dict[str, dict[str, str]]:
    """The candidates below the references of some cases, by name, and what each says otherwise."""
    found: dict[str, dict[str, str]] = {}
    order = list(MODELS)
    highest = max((case.model for case in cases), key=order.index)
    if any(case.rig.ring is not None for case in cases):
        found |= {AS_SAID: {}, f"{FEW_HARMONICS} harmonics": {"rig.ring.harmonics": FEW_HARMONICS}}
    sliced = [int(case.contact.slices) for case in cases if MODELS[case.model].sliced]
    if sliced:
        few = str(max(2, round(FEW_SLICES * max(sliced))))
        found[f"{few} slices"] = {"contact.slices": few}
    return found | {name: {"model": name} for name in below(highest)}


def saves(case: Case, instead_of: Case) -> bool:
    """Whether a case takes so much less CPU time than another that it is worth trying."""
    return price(case) < WORTH_TRYING * price(instead_of)


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
