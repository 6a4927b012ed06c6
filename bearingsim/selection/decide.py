"""Choice of the cheapest model with a small enough error bound for all cases of a curve.

Candidates are tried in ascending order of cost. Once one is accurate enough for all cases of a curve, only those
that cost at most 11 % more (``SIMPLER_COST_RATIO``) are still tried.
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
    estimated_cpu_time,
    list_candidates,
    make_reference,
    with_friction,
)
from bearingsim.selection.choices import choice_key
from bearingsim.selection.curves import group_cases, list_curves
from bearingsim.selection.evidence import Evidence
from bearingsim.selection.friction import FrictionEffect
from bearingsim.selection.nodes import Discretisation
from bearingsim.selection.trials import TrialRequest, TrialResults, first_trials, is_decided, trials_of, unique
from bearingsim.store.choices import Choice, Choices
from bearingsim.study import Study
from bearingsim.text.numbers import percent

MODEL_ERROR_SHARE = 0.8
"""Largest error of a model, as a share of the requested accuracy; the rest is for step error and scatter."""
MIXED_COST_RATIO = 1.0 / 3.0
"""Ratio of costs below which several models are chosen for the cases of a curve instead of one."""
SIMPLER_COST_RATIO = 0.9
"""Ratio of costs below which a simpler model is preferred to a more detailed one."""

NOTHING_CHEAPER = "no cheaper model can compute this"
FRICTION_NOT_TRIED = "a trial does not cover a ramp, so the effect of friction is unknown"
SAVING_TOO_SMALL = "cheaper models would save less CPU time than compiling them takes"


class Decision(NamedTuple):
    """Choices by ``key``, and the number of cases with a periodic reference."""

    choices: Choices
    periodic_count: int


class ModelSelector:
    """Choice of models for some cases of a study: trials to be computed, and decision from their results."""

    def __init__(
        self, study: Study, numbers: Sequence[int], compile_time_of: Callable[[Case], float] = lambda case: 0.0
    ) -> None:
        """Find the cases with candidates.

        numbers: of the cases for which a model is chosen, among ``study.cases()``; compile_time_of: returns the
        CPU time (s) to compile the code of a case. A candidate must save more than that over the cases, even if
        its code is already in the cache, so that the choice is the same on every machine.
        """
        self.study, self.numbers, self.compile_time_of, cases = study, numbers, compile_time_of, study.cases()
        self.tried_cases = [n for n in numbers if can_be_tried(cases[n])]
        self.curves = list_curves(study)

    def next_trials(self, trials: TrialResults) -> list[TrialRequest]:
        """List the trials to compute next; empty once a choice can be made."""
        missing = [trial for trial in first_trials(self.study, self.tried_cases) if trial.id not in trials]
        if missing:
            return missing
        evidence, friction = self._read_evidence(trials)
        missing = friction.trials()
        if not missing:
            undecided = self._undecided_groups(friction)
            numbers = [n for group in undecided for n in group]
            worthwhile = [name for name in self.candidate_cases if self._is_worth_compiling(name, numbers)]
            missing = [
                trial
                for group in undecided
                for trial in self._candidate_trials(group, worthwhile, evidence, friction)
            ]
        return unique(missing) or self._discretisation(evidence, self._model_choices(evidence, friction)).trials()

    def _read_evidence(self, trials: TrialResults) -> tuple[Evidence, FrictionEffect]:
        """Return the errors of models and the effect of friction, from trials."""
        assert self.study.goal is not None
        evidence = Evidence(self.study, self.curves, trials)
        return evidence, FrictionEffect(
            evidence, self.tried_cases, self.curves, MODEL_ERROR_SHARE * self.study.goal.within
        )

    def decide(self, trials: TrialResults) -> Decision:
        """Choose from the available trials; a missing trial counts as failed."""
        (evidence, friction), cases = self._read_evidence(trials), self.study.cases()
        choices = self._model_choices(evidence, friction)
        discretisation = self._discretisation(evidence, choices)
        for n in self.numbers:
            values, scales = evidence.magnitudes_and_scales(n)
            choices[n] = replace(choices[n], nodes=discretisation.errors(n), values=values, scales=scales)
            if choices[n].candidate != WITH_FRICTION:
                choices[n] = replace(choices[n], friction=friction.errors(n), inferred=friction.is_inferred(n))
        periodic_count = sum(
            bool(evidence.reference_values[n]) and is_decided(self.study, n, trials) for n in self.tried_cases
        )
        return Decision(
            {choice_key(self.study, cases[n]): choice for n, choice in choices.items()}, periodic_count
        )

    def _model_choices(self, evidence: Evidence, friction: FrictionEffect) -> dict[int, Choice]:
        """Return the choice for each case, without the errors of friction and discretisation."""
        trials, cases = evidence.trials, self.study.cases()
        choices = {n: self._untried_choice(n) for n in self.numbers}
        decided_cases = [n for n in self.tried_cases if is_decided(self.study, n, trials)]
        for n in decided_cases:
            reason = "the reference is periodic, so its trial is the result"
            choices[n] = Choice(
                REFERENCE, cases[n].model, reason if evidence.reference_values[n] else "the reference fails", {}
            )
        for group in self._undecided_groups(friction):
            choices |= self._choices_of_group(group, evidence, friction)
        friction_choices = {
            n: Choice(WITH_FRICTION, cases[n].model, reason, {}) for n, reason in friction.required_cases.items()
        }
        return choices | friction_choices

    def _untried_choice(self, n: int) -> Choice:
        """Return the initial choice for a case.

        It is the reference, with friction if the case has no trials and does not specify friction.
        """
        case = self.study.cases()[n]
        if with_friction(case) is None or can_be_tried(case):
            return Choice(REFERENCE, case.model, NOTHING_CHEAPER, {})
        return Choice(WITH_FRICTION, case.model, FRICTION_NOT_TRIED, {})

    def _discretisation(self, evidence: Evidence, choices: Mapping[int, Choice]) -> Discretisation:
        """Return the discretisation errors of the choices, from trials."""
        return Discretisation(evidence, self.curves, choices, lambda n, name: self.candidate_cases[name][n])

    def _undecided_groups(self, friction: FrictionEffect) -> list[list[int]]:
        """Group the undecided cases, whose reference is not periodic and needs no friction, by shared curves."""
        trials = friction.evidence.trials
        undecided = [
            n
            for n in self.tried_cases
            if n not in friction.required_cases and not is_decided(self.study, n, trials)
        ]
        return group_cases(undecided, self.curves)

    @cached_property
    def candidate_cases(self) -> dict[str, dict[int, Case]]:
        """Cases of every candidate, by name, most detailed candidate first."""
        return list_candidates(self.study, self.tried_cases)

    def _is_worth_compiling(self, name: str, numbers: Sequence[int]) -> bool:
        """Check if a candidate saves more CPU time over some cases than compiling its model takes."""
        study_cases = self.study.cases()
        cases = {n: self.candidate_cases[name][n] for n in numbers if n in self.candidate_cases[name]}
        new_models = [case for n, case in cases.items() if case.model != study_cases[n].model]
        compile_time = max(map(self.compile_time_of, new_models), default=0.0)
        if compile_time == 0.0:
            return True
        savings = (
            estimated_cpu_time(make_reference(study_cases[n])) - estimated_cpu_time(case)
            for n, case in cases.items()
        )
        return sum(savings) > compile_time

    def _candidate_trials(
        self, group: Sequence[int], names: Sequence[str], evidence: Evidence, friction: FrictionEffect
    ) -> list[TrialRequest]:
        """List trials of the cheapest candidate not yet tried on a group, unless a cheaper one is accepted."""
        accepted_cost = inf
        for cost, name in sorted((self._cost(name, group), name) for name in names):
            if accepted_cost < SIMPLER_COST_RATIO * cost:
                return []
            cases = {n: self.candidate_cases[name][n] for n in group if n in self.candidate_cases[name]}
            trials = [trial for n, case in cases.items() for trial in trials_of(self.study, n, case)]
            missing = [trial for trial in trials if trial.id not in evidence.trials]
            if missing:
                return missing
            if len(cases) == len(group) and all(
                self._is_accurate(evidence.errors(n, case), friction.errors(n)) for n, case in cases.items()
            ):
                accepted_cost = min(accepted_cost, cost)
        return []

    def _cost(self, name: str, group: Sequence[int]) -> float:
        """Return the total cost of a candidate for the cases of a group to which it applies."""
        cases = self.candidate_cases[name]
        return sum(estimated_cpu_time(cases[n]) for n in group if n in cases)

    def _is_accurate(self, errors: Mapping[str, float], friction: Mapping[str, float | None]) -> bool:
        """Check if the errors of model and friction are known and within ``MODEL_ERROR_SHARE`` of the accuracy."""
        assert self.study.goal is not None
        return bool(errors) and _largest_sum(errors, friction) <= MODEL_ERROR_SHARE * self.study.goal.within

    def _choices_of_group(
        self, group: Sequence[int], evidence: Evidence, friction: FrictionEffect
    ) -> dict[int, Choice]:
        """Choose one model for the cases of a group, or several if these cost far less (``MIXED_COST_RATIO``)."""
        costs = {REFERENCE: {n: estimated_cpu_time(make_reference(self.study.cases()[n])) for n in group}}
        for name, cases in self.candidate_cases.items():
            accurate = [
                n
                for n in group
                if n in cases and self._is_accurate(evidence.errors(n, cases[n]), friction.errors(n))
            ]
            costs[name] = {n: estimated_cpu_time(cases[n]) for n in accurate}
        group_costs = {
            name: sum(case_costs.values()) for name, case_costs in costs.items() if len(case_costs) == len(group)
        }
        single_choice = _cheapest(group_costs)
        cheapest = {
            n: _cheapest({name: model_costs[n] for name, model_costs in costs.items() if n in model_costs})
            for n in group
        }
        mixed_cost = sum(costs[name][n] for n, name in cheapest.items())
        names = (
            cheapest
            if mixed_cost < MIXED_COST_RATIO * group_costs[single_choice]
            else dict.fromkeys(group, single_choice)
        )
        return {n: self._make_choice(n, name, evidence, friction) for n, name in names.items()}

    def _make_choice(self, n: int, name: str, evidence: Evidence, friction: FrictionEffect) -> Choice:
        """Make the choice of a candidate for a case, with its reason."""
        study_case = self.study.cases()[n]
        if name == REFERENCE:
            # friction adds no cost, because the response is not periodic without it either
            candidate = REFERENCE if with_friction(study_case) is None else WITH_FRICTION
            return Choice(candidate, study_case.model, self._reference_reason(n, evidence, friction), {})
        case = self.candidate_cases[name][n]
        errors = evidence.errors(n, case)
        reason = f"{percent(max(errors.values()))} from {study_case.model}, at the cost of {case.model}"
        return Choice(name, case.model, reason, errors)

    def _reference_reason(self, n: int, evidence: Evidence, friction: FrictionEffect) -> str:
        """Explain why the reference of a case is not replaced by a cheaper model."""
        assert self.study.goal is not None
        cases = [cases[n] for cases in self.candidate_cases.values() if n in cases]
        all_errors = [evidence.errors(n, case) for case in cases]
        errors = [case_errors for case_errors in all_errors if case_errors]
        if not errors:
            untried = [case for case in cases if trials_of(self.study, n, case)[0].id not in evidence.trials]
            return SAVING_TOO_SMALL if untried else NOTHING_CHEAPER
        total, model_error = min(
            (_largest_sum(case_errors, friction.errors(n)), max(case_errors.values())) for case_errors in errors
        )
        limit = MODEL_ERROR_SHARE * self.study.goal.within
        if model_error == inf:
            return "trials have too few ball passes to compare cheaper models with it"
        reason = f"the nearest cheaper model is {percent(model_error)} off"
        if model_error > limit:
            return f"{reason}: over {percent(limit)}"
        if total == inf:
            return f"{reason}, and the effect of friction is unknown"
        if total > limit:
            return f"{reason}, {percent(total)} with the effect of friction: over {percent(limit)}"
        return f"{reason} for this case, but not shown to be within {percent(limit)} elsewhere on a curve"


def _largest_sum(errors: Mapping[str, float], friction: Mapping[str, float | None]) -> float:
    """Return the largest sum of the errors of model and friction of a feature; infinite if friction is unknown."""
    changes = {name: friction.get(name, 0.0) for name in errors}
    return max(inf if (change := changes[name]) is None else error + change for name, error in errors.items())


def _cheapest(costs: Mapping[str, float]) -> str:
    """Return the cheapest candidate, where each simpler one must save a tenth of the cost.

    costs: by name, most detailed candidate first, with the reference.
    """
    best = REFERENCE
    for name, cost in costs.items():
        if cost < SIMPLER_COST_RATIO * costs[best]:
            best = name
    return best
