"""Decision on the cheapest model whose error bound from the reference is small enough for all cases of a curve.

Candidates are tried in the order of cost, up to the first that is accurate enough for all cases of a curve.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import NamedTuple

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.selection.candidates import (
    WITH_FRICTION,
    can_be_tried,
    candidates,
    price,
    reference,
    with_friction,
)
from bearingsim.selection.choices import key
from bearingsim.selection.curves import curves, groups
from bearingsim.selection.evidence import Evidence
from bearingsim.selection.friction import Friction
from bearingsim.selection.nodes import Discretisation
from bearingsim.selection.trials import Known, Trialled, first_trials, once, repeats, trials_of
from bearingsim.store.choices import Choice, Choices
from bearingsim.study import Study

FOR_MODEL = 0.8
"""Largest error of the model, as a share of the requested accuracy; the rest is for step error and scatter."""
MIXED = 1.0 / 3.0
"""Cost ratio below which several models replace a single one for the cases of a curve."""
TIE = 0.9
"""Cost ratio below which a simpler model is preferred to a more detailed one."""

NOTHING_CHEAPER = "no cheaper model can compute this"
TOO_LITTLE = "cheaper models would save less CPU time than compiling them takes"


class Decision(NamedTuple):
    """Choices by ``key``, and the number of cases with a periodic reference."""

    choices: Choices
    repeating: int


class Choosing:
    """Choice of models for some cases of a study: next trials, and decision from their results."""

    def __init__(
        self, study: Study, numbers: Sequence[int], compiling: Callable[[Case], float] = lambda case: 0.0
    ) -> None:
        """Find the cases with candidates.

        numbers: of the cases for which a model is chosen, among ``study.cases()``; compiling: returns the CPU time
        (s) to compile the code of a case. A candidate must save more than that over the cases, even if its code is
        already in the cache, so that the choice is the same on every machine.
        """
        self.study, self.numbers, self.compiling, cases = study, numbers, compiling, study.cases()
        self.tried = [n for n in numbers if can_be_tried(cases[n])]
        self.drawn = curves(study)

    def wanted(self, trials: Known) -> list[Trialled]:
        """List the trials to compute next; empty once a choice can be made."""
        missing = [trial for trial in first_trials(self.study, self.tried) if trial.id not in trials]
        if missing:
            return missing
        evidence, friction = self._seen(trials)
        missing = friction.trials()
        if not missing:
            left = self._open(friction)
            numbers = [n for group in left for n in group]
            worth = [name for name in self.able if self._is_worth_compiling(name, numbers)]
            missing = [trial for group in left for trial in self._next(group, worth, evidence, friction)]
        return once(missing) or self._nodes(evidence, self._models(evidence, friction)).trials()

    def _seen(self, trials: Known) -> tuple[Evidence, Friction]:
        """Return the errors of models and the effect of friction from trials."""
        assert self.study.goal is not None
        evidence = Evidence(self.study, self.drawn, trials)
        return evidence, Friction(evidence, self.tried, self.drawn, FOR_MODEL * self.study.goal.within)

    def decide(self, trials: Known) -> Decision:
        """Choose from the available trials; a missing trial counts as failed."""
        (evidence, friction), cases = self._seen(trials), self.study.cases()
        choices = self._models(evidence, friction)
        discretisation = self._nodes(evidence, choices)
        for n in self.tried:
            choices[n] = replace(choices[n], nodes=discretisation.errors(n))
            if choices[n].candidate != WITH_FRICTION:
                choices[n] = replace(choices[n], friction=friction.errors(n), inferred=friction.inferred(n))
        repeating = sum(bool(evidence.of_reference[n]) and repeats(self.study, n, trials) for n in self.tried)
        return Decision({key(self.study, cases[n]): choice for n, choice in choices.items()}, repeating)

    def _models(self, evidence: Evidence, friction: Friction) -> dict[int, Choice]:
        """Return the choice for each case, without the errors of friction and discretisation."""
        trials, cases = evidence.known, self.study.cases()
        choices = {n: Choice(REFERENCE, cases[n].model, NOTHING_CHEAPER, {}) for n in self.numbers}
        settled = [n for n in self.tried if repeats(self.study, n, trials)]
        for n in settled:
            why = "the reference is periodic, so its trial is the result"
            choices[n] = Choice(
                REFERENCE, cases[n].model, why if evidence.of_reference[n] else "the reference fails", {}
            )
        for group in self._open(friction):
            choices |= self._choices_of_group(group, evidence, friction)
        rubbing = {n: Choice(WITH_FRICTION, cases[n].model, why, {}) for n, why in friction.too_much.items()}
        return choices | rubbing

    def _nodes(self, evidence: Evidence, choices: Mapping[int, Choice]) -> Discretisation:
        """Return the discretisation errors of the choices from trials."""
        return Discretisation(evidence, self.drawn, choices, lambda n, name: self.able[name][n])

    def _open(self, friction: Friction) -> list[list[int]]:
        """Group the undecided cases, whose reference is not periodic and needs no friction, by shared curves."""
        trials = friction.evidence.known
        left = [n for n in self.tried if n not in friction.too_much and not repeats(self.study, n, trials)]
        return groups(left, self.drawn)

    @cached_property
    def able(self) -> dict[str, dict[int, Case]]:
        """Cases of every candidate, by name, most detailed candidate first."""
        return candidates(self.study, self.tried)

    def _is_worth_compiling(self, name: str, numbers: Sequence[int]) -> bool:
        """Check if a candidate saves more CPU time over some cases than the compilation of its model needs."""
        own = self.study.cases()
        cases = {n: self.able[name][n] for n in numbers if n in self.able[name]}
        others = [case for n, case in cases.items() if case.model != own[n].model]
        compiled = max(map(self.compiling, others), default=0.0)
        saved = sum(price(reference(own[n])) - price(case) for n, case in cases.items())
        return compiled == 0.0 or saved > compiled

    def _next(
        self, group: Sequence[int], names: Sequence[str], evidence: Evidence, friction: Friction
    ) -> list[Trialled]:
        """List trials of the cheapest candidate not yet tried on a group, unless a cheaper one is accepted."""
        held = inf
        for cost, name in sorted((self._cost(name, group), name) for name in names):
            if held < TIE * cost:
                return []
            cases = {n: self.able[name][n] for n in group if n in self.able[name]}
            trials = [trial for n, case in cases.items() for trial in trials_of(self.study, n, case)]
            missing = [trial for trial in trials if trial.id not in evidence.known]
            if missing:
                return missing
            if len(cases) == len(group) and all(
                self._holds(evidence.errors(n, case), friction.errors(n)) for n, case in cases.items()
            ):
                held = cost
        return []

    def _cost(self, name: str, group: Sequence[int]) -> float:
        """Return the total cost of a candidate for the cases of a group to which it applies."""
        return sum(price(self.able[name][n]) for n in group if n in self.able[name])

    def _holds(self, errors: Mapping[str, float], friction: Mapping[str, float | None]) -> bool:
        """Check if the errors of model and friction are within ``FOR_MODEL`` of the requested accuracy."""
        assert self.study.goal is not None
        sums = [of + (friction.get(name) or 0.0) for name, of in errors.items()]
        return bool(sums) and max(sums) <= FOR_MODEL * self.study.goal.within

    def _choices_of_group(self, group: Sequence[int], evidence: Evidence, friction: Friction) -> dict[int, Choice]:
        """Choose one model for the cases of a group, or several if these cost less than a third (``MIXED``)."""
        costs = {REFERENCE: {n: price(reference(self.study.cases()[n])) for n in group}}
        for name, cases in self.able.items():
            held = [
                n for n in group if n in cases and self._holds(evidence.errors(n, cases[n]), friction.errors(n))
            ]
            costs[name] = {n: price(cases[n]) for n in held}
        whole = {name: sum(of.values()) for name, of in costs.items() if len(of) == len(group)}
        alone = _cheapest(whole)
        each = {n: _cheapest({name: of[n] for name, of in costs.items() if n in of}) for n in group}
        mixed = sum(costs[name][n] for n, name in each.items())
        taken = each if mixed < MIXED * whole[alone] else dict.fromkeys(group, alone)
        return {n: self._told(n, name, evidence) for n, name in taken.items()}

    def _told(self, n: int, name: str, evidence: Evidence) -> Choice:
        """Return a choice with its reason."""
        own = self.study.cases()[n]
        if name == REFERENCE:  # friction adds no cost, as neither is periodic
            last = REFERENCE if with_friction(own) is None else WITH_FRICTION
            return Choice(last, own.model, self._why_none(n, evidence), {})
        case = self.able[name][n]
        errors = evidence.errors(n, case)
        why = f"{100.0 * max(errors.values()):.2g} % from {own.model}, at the cost of {case.model}"
        return Choice(name, case.model, why, errors)

    def _why_none(self, n: int, evidence: Evidence) -> str:
        """Explain why the reference of a case is not replaced by a cheaper model."""
        assert self.study.goal is not None
        tried = [evidence.errors(n, cases[n]) for cases in self.able.values() if n in cases]
        own, most = [max(errors.values()) for errors in tried if errors], FOR_MODEL * self.study.goal.within
        if not own:
            cases = [cases[n] for cases in self.able.values() if n in cases]
            untried = [case for case in cases if trials_of(self.study, n, case)[0].id not in evidence.known]
            return TOO_LITTLE if untried else NOTHING_CHEAPER
        if min(own) == inf:
            return "cheaper models could not be distinguished from it in so few ball passes"
        nearest = f"the nearest cheaper model is {100.0 * min(own):.2g} % off"
        over = f"over {100.0 * most:.2g} %"
        return f"{nearest}: {over}" if min(own) > most else f"{nearest} here, but {over} elsewhere on a curve"


def _cheapest(costs: Mapping[str, float]) -> str:
    """Return the cheapest model; a simpler one must save a tenth of the cost. costs: most detailed model first."""
    best = REFERENCE
    for name, cost in costs.items():
        if cost < TIE * costs[best]:
            best = name
    return best
