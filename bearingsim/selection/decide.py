"""The choice itself: for the cases of a curve the cheapest model that is surely close enough to the reference.

Candidates are tried from the cheapest up, and no further than the first that holds for all cases of a curve.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf, nan
from typing import NamedTuple

import numpy as np

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.selection.candidates import can_be_tried, candidates, price, recut, reference
from bearingsim.selection.choices import Choice, Choices, key
from bearingsim.selection.curves import curves, groups, scales
from bearingsim.selection.judge import Value, error, value
from bearingsim.selection.trials import Known, Trialled, first_trials, once, repeats, trials_of
from bearingsim.simulation.trial import stepped_alike
from bearingsim.study import Study

FOR_MODEL = 0.8
"""Of the accuracy asked for, what the model may take: the rest is left to step and scatter."""
MIXED = 1.0 / 3.0
"""Of the cost of one model for a whole curve, what several may cost to be taken instead."""
TIE = 0.9
"""Of what a higher model costs, what a lower one must save to be taken."""

NOTHING_CHEAPER = "nothing that can do this costs less"


class Decision(NamedTuple):
    """Choices by ``key``, and how many references repeat themselves."""

    choices: Choices
    repeating: int


class Recut(NamedTuple):
    """A case, its like with other nodes, and how many times what these change the error of its own is at most."""

    case: Case
    recut: Case
    times: float


class Choosing:
    """The choice for some cases of a study: which trials it wants next, and what follows from them."""

    def __init__(self, study: Study, numbers: Sequence[int]) -> None:
        """numbers: of the cases to be chosen for, among ``study.cases()``."""
        self.study, self.numbers, cases = study, numbers, study.cases()
        self.tried = [n for n in numbers if can_be_tried(cases[n])]
        self.drawn = curves(study)

    def wanted(self, known: Known) -> list[Trialled]:
        """Trials that are to be computed before more can be said; none once a choice can be made."""
        first = [one for one in first_trials(self.study, self.tried) if one.id not in known]
        if first:
            return first
        evidence = Evidence(self, known)
        missing = once([one for group in self.open_groups(known) for one in self._next(group, evidence)])
        return missing or self._recut_trials(evidence)

    def decide(self, known: Known) -> Decision:
        """Choose, with what is known: a trial that is not counts as failed."""
        evidence, cases = Evidence(self, known), self.study.cases()
        found = self._models(evidence)
        for n in self.tried:
            found[n] = replace(found[n], nodes=self._nodes(n, found[n], evidence))
        repeating = sum(bool(evidence.of_reference[n]) and repeats(self.study, n, known) for n in self.tried)
        return Decision({key(self.study, cases[n]): one for n, one in found.items()}, repeating)

    def _models(self, evidence: "Evidence") -> dict[int, Choice]:
        """Return the choice for each case, without the errors of its discretisation."""
        known, cases = evidence.known, self.study.cases()
        found = {n: Choice(REFERENCE, cases[n].model, NOTHING_CHEAPER, {}) for n in self.numbers}
        settled = [n for n in self.tried if repeats(self.study, n, known)]
        for n in settled:
            why = "the reference repeats itself: its trial is the answer"
            found[n] = Choice(
                REFERENCE, cases[n].model, why if evidence.of_reference[n] else "the reference fails", {}
            )
        for group in self.open_groups(known):
            found |= self._of_group(group, evidence)
        return found

    def _recut_trials(self, evidence: "Evidence") -> list[Trialled]:
        """Return the trials of the choices with other nodes that are still to be computed."""
        others = [(n, self._recut(n, choice, evidence)) for n, choice in self._models(evidence).items()]
        trials = [trials_of(self.study, n, other.recut)[0] for n, other in others if other is not None]
        return once([trial for trial in trials if trial.id not in evidence.known])

    def _recut(self, n: int, choice: Choice, evidence: "Evidence") -> "Recut | None":
        """Return the case that was chosen for number ``n`` and its like with other nodes, at the same step.

        None if nodes change nothing, or the case was not tried.
        """
        own, judges = self.study.cases()[n], choice.candidate == REFERENCE
        chosen = reference(own) if judges else self.able[choice.candidate][n]
        other = recut(chosen, judges)
        trial = evidence.known.get(trials_of(self.study, n, chosen)[0].id)
        return None if other is None or trial is None else Recut(chosen, stepped_alike(other[0], trial), other[1])

    def _nodes(self, n: int, choice: Choice, evidence: "Evidence") -> dict[str, float | None]:
        """Return the error of a choice's discretisation, by feature; nothing if it has none, or was not tried."""
        other = self._recut(n, choice, evidence)
        return {} if other is None else evidence.of_nodes(n, other)

    def open_groups(self, known: Known) -> list[list[int]]:
        """The cases whose reference does not repeat itself, those that take one model together."""
        return groups((n for n in self.tried if not repeats(self.study, n, known)), self.drawn)

    @cached_property
    def able(self) -> dict[str, dict[int, Case]]:
        """The cases of every candidate, by name, from the highest."""
        return candidates(self.study, self.tried)

    def _next(self, group: Sequence[int], evidence: "Evidence") -> list[Trialled]:
        """The trials of the cheapest candidate that has not been tried on a group, if nothing cheaper holds."""
        held = inf
        for cost, name in sorted((self._cost(name, group), name) for name in self.able):
            if held < TIE * cost:
                return []
            cases = {n: self.able[name][n] for n in group if n in self.able[name]}
            trials = [one for n, case in cases.items() for one in trials_of(self.study, n, case)]
            missing = [one for one in trials if one.id not in evidence.known]
            if missing:
                return missing
            if len(cases) == len(group) and all(
                self._holds(evidence.errors(n, case)) for n, case in cases.items()
            ):
                held = cost
        return []

    def _cost(self, name: str, group: Sequence[int]) -> float:
        """What a candidate costs for the cases of a group that it is able to compute."""
        return sum(price(self.able[name][n]) for n in group if n in self.able[name])

    def _holds(self, errors: Mapping[str, float]) -> bool:
        """Whether a model's errors leave enough of the accuracy to step and scatter."""
        assert self.study.goal is not None
        return bool(errors) and max(errors.values()) <= FOR_MODEL * self.study.goal.within

    def _of_group(self, group: Sequence[int], evidence: "Evidence") -> dict[int, Choice]:
        """One model for the cases of a group, unless several cost less than a third of it."""
        costs = {REFERENCE: {n: price(reference(self.study.cases()[n])) for n in group}}
        for name, cases in self.able.items():
            held = [n for n in group if n in cases and self._holds(evidence.errors(n, cases[n]))]
            costs[name] = {n: price(cases[n]) for n in held}
        whole = {name: sum(of.values()) for name, of in costs.items() if len(of) == len(group)}
        one = _cheapest(whole)
        each = {n: _cheapest({name: of[n] for name, of in costs.items() if n in of}) for n in group}
        mixed = sum(costs[name][n] for n, name in each.items())
        taken = each if mixed < MIXED * whole[one] else dict.fromkeys(group, one)
        return {n: self._told(n, name, evidence) for n, name in taken.items()}

    def _told(self, n: int, name: str, evidence: "Evidence") -> Choice:
        """A choice, and why."""
        own = self.study.cases()[n]
        if name == REFERENCE:
            return Choice(REFERENCE, own.model, self._why_none(n, evidence), {})
        case = self.able[name][n]
        errors = evidence.errors(n, case)
        why = f"{100.0 * max(errors.values()):.2g} % from {own.model}, at {case.model}'s price"
        return Choice(name, case.model, why, errors)

    def _why_none(self, n: int, evidence: "Evidence") -> str:
        """Why nothing cheaper is taken in place of the reference of a case."""
        assert self.study.goal is not None
        tried = [evidence.errors(n, cases[n]) for cases in self.able.values() if n in cases]
        own, most = [max(errors.values()) for errors in tried if errors], FOR_MODEL * self.study.goal.within
        if not own:
            return NOTHING_CHEAPER
        if min(own) == inf:
            return "what costs less could not be told from it in so few ball passes"
        nearest = f"the nearest of those that cost less is {100.0 * min(own):.2g} % off"
        over = f"over {100.0 * most:.2g} %"
        return f"{nearest}: {over}" if min(own) > most else f"{nearest} here, but {over} elsewhere on a curve"


class Evidence:
    """What trials tell of the cases of a study: how far a candidate is off, over what errors count over."""

    def __init__(self, choosing: Choosing, known: Known) -> None:
        self.study, self.known = choosing.study, known
        assert self.study.goal is not None
        self.of_reference = [self._values(n, reference(case)) for n, case in enumerate(self.study.cases())]
        self.sizes = {
            feature: scales(
                feature, [of[feature].value if of else nan for of in self.of_reference], choosing.drawn
            )
            for feature in self.study.goal.of
        }

    def errors(self, n: int, case: Case) -> dict[str, float]:
        """What a case that stands for number ``n`` is surely no further off, by feature; nothing if it failed."""
        own, other = self._values(n, case), self.of_reference[n]
        if not own or not other:
            return {}
        return {name: _relative(error(own[name], other[name]), self.sizes[name][n]) for name in own}

    def of_nodes(self, n: int, other: Recut) -> dict[str, float | None]:
        """Return the error of the discretisation of a case for number ``n``, by feature; None where it is unknown.

        Of motions that repeat themselves one period is all: nothing scatters.
        """
        assert self.study.goal is not None
        own, off = self._values(n, other.case), self._values(n, other.recut, other.case)
        if not own or not off:
            return dict.fromkeys(self.study.goal.of)
        trials = [self.known[trials_of(self.study, n, case)[0].id] for case in (other.case, other.recut)]
        exact = all(trial is not None and trial.repeats for trial in trials)
        errors = {
            name: abs(own[name].value - off[name].value) if exact else error(own[name], off[name]) for name in own
        }
        found = {name: other.times * _relative(of, self.sizes[name][n]) for name, of in errors.items()}
        return {name: of if of < inf else None for name, of in found.items()}

    def _values(self, n: int, case: Case, beside: Case | None = None) -> dict[str, Value]:
        """What is asked of a case, as its trial (and its twin's) has it; nothing of one that failed.

        beside: a case whose twin counts instead.
        """
        assert self.study.goal is not None
        twins = trials_of(self.study, n, beside or case)[1:]
        trials = [self.known.get(one.id) for one in (trials_of(self.study, n, case)[0], *twins)]
        own, twin = trials[0], trials[-1] if len(trials) > 1 else None
        if own is None or None in trials or (twin is not None and twin.turns != own.turns):
            return {}
        return {feature: value(feature, own, twin) for feature in self.study.goal.of}


def _relative(error: float, size: float) -> float:
    """An error over what it counts over; infinite if nobody knows."""
    found = error / (size or 1.0)
    return found if np.isfinite(found) else inf


def _cheapest(costs: Mapping[str, float]) -> str:
    """The cheapest, from the highest model down: a lower one must save a tenth of the cost."""
    best = REFERENCE
    for name, cost in costs.items():
        if cost < TIE * costs[best]:
            best = name
    return best
