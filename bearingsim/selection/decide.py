"""The choice itself: for the cases of a curve the cheapest model that is surely close enough to the reference."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.selection.choices import Choice, Choices, key
from bearingsim.selection.curves import curves, groups, scales
from bearingsim.selection.judge import Value, error, value
from bearingsim.selection.trials import (
    Known,
    candidates,
    price,
    reference,
    repeats,
    with_twin,
)
from bearingsim.simulation.trial import passes_to_try
from bearingsim.study import Study

FOR_MODEL = 0.8
"""Of the accuracy asked for, what the model may take: the rest is left to step and scatter."""
MIXED = 1.0 / 3.0
"""Of the cost of one model for a whole curve, what several may cost to be taken instead."""
TIE = 0.9
"""Of what a higher model costs, what a lower one must save to be taken."""


class Decision(NamedTuple):
    """Choices by ``key``, and how many references repeat themselves."""

    choices: Choices
    repeating: int


def decide(study: Study, numbers: Sequence[int], known: Known) -> Decision:
    """Choose for the cases of these numbers, all of whose trials are known."""
    assert study.goal is not None
    cases, drawn, goal = study.cases(), curves(study), study.goal
    of_reference = {n: values(study, reference(cases[n]), cases[n], known) for n in range(len(cases))}
    size = {
        feature: [of_reference[n][feature].value if of_reference[n] else float("nan") for n in range(len(cases))]
        for feature in goal.of
    }
    found: dict[int, Choice] = {}
    settled = [n for n in numbers if repeats(study, cases[n], known)]
    for n in settled:
        why = "the reference repeats itself: its trial is the answer"
        found[n] = Choice(REFERENCE, cases[n].model, why if of_reference[n] else "the reference fails", {})
    sizes = {feature: scales(feature, size[feature], drawn) for feature in goal.of}
    errors: dict[str, dict[int, dict[str, float]]] = {}
    able = candidates(study, numbers, known)
    for name, tried in able.items():
        for n, case in tried.items():
            own = values(study, case, cases[n], known)
            if own:
                errors.setdefault(name, {})[n] = {
                    feature: _relative(error(own[feature], of_reference[n][feature]), sizes[feature][n])
                    for feature in goal.of
                }
    open_cases = [n for n in numbers if n not in found]
    for group in groups(open_cases, drawn):
        found |= _of_group(study, group, able, errors)
    repeating = sum(bool(of_reference[n]) for n in settled)
    return Decision({key(study, cases[n]): one for n, one in found.items()}, repeating)


def _relative(error: float, size: float) -> float:
    """An error over what it counts over; infinite if nobody knows."""
    found = error / (size or 1.0)
    return found if np.isfinite(found) else float("inf")


def values(study: Study, case: Case, of: Case, known: Known) -> dict[str, Value]:
    """What is asked of a case, as its trial (and its twin's) has it; nothing of one that failed."""
    assert study.goal is not None
    found = [known.get(one.id) for one in with_twin(study, case, passes_to_try(of))]
    if any(one is None for one in found):
        return {}
    own, twin = (*found, None)[:2]
    assert own is not None
    return {feature: value(feature, own, twin) for feature in study.goal.of}


Errors = Mapping[str, Mapping[int, Mapping[str, float]]]


def _of_group(
    study: Study, group: Sequence[int], able: Mapping[str, Mapping[int, Case]], errors: Errors
) -> dict[int, Choice]:
    """One model for the cases of a group, unless several cost less than a third of it."""
    assert study.goal is not None
    cases, most = study.cases(), FOR_MODEL * study.goal.within
    costs = {REFERENCE: {n: price(reference(cases[n])) for n in group}}
    for name, tried in errors.items():
        held = [n for n in group if n in tried and max(tried[n].values()) <= most]
        costs[name] = {n: price(able[name][n]) for n in held}
    whole = {name: sum(of.values()) for name, of in costs.items() if len(of) == len(group)}
    one = _cheapest(whole)
    each = {n: _cheapest({name: of[n] for name, of in costs.items() if n in of}) for n in group}
    mixed = sum(costs[name][n] for n, name in each.items())
    taken = each if mixed < MIXED * whole[one] else dict.fromkeys(group, one)
    return {n: _told(cases[n], name, n, able, errors, study.goal.within) for n, name in taken.items()}


def _cheapest(costs: Mapping[str, float]) -> str:
    """The cheapest, from the highest model down: a lower one must save a tenth of the cost."""
    best = REFERENCE
    for name, cost in costs.items():
        if cost < TIE * costs[best]:
            best = name
    return best


def _told(
    case: Case, name: str, n: int, able: Mapping[str, Mapping[int, Case]], errors: Errors, within: float
) -> Choice:
    """A choice, and why."""
    if name != REFERENCE:
        why = f"{100.0 * max(errors[name][n].values()):.2g} % from {case.model}, at {able[name][n].model}'s price"
        return Choice(name, able[name][n].model, why, errors[name][n])
    return Choice(REFERENCE, case.model, _why_none(n, errors, FOR_MODEL * within), {})


def _why_none(n: int, errors: Errors, most: float) -> str:
    """Why nothing cheaper is taken in place of the reference of a case."""
    own = [max(of[n].values()) for of in errors.values() if n in of]
    if not own:
        return "nothing that can do this costs less"
    if min(own) == np.inf:
        return "what costs less could not be told from it in so few ball passes"
    nearest = f"the nearest of those that cost less is {100.0 * min(own):.2g} % off"
    over = f"over {100.0 * most:.2g} %"
    return f"{nearest}: {over}" if min(own) > most else f"{nearest} here, but {over} elsewhere on a curve"
