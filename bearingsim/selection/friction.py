"""Effect of friction and a free cage on cases whose reference has none, from trials where it may be largest.

The motion with a free cage is not periodic, so a trial with friction is expensive. Friction is tried at both ends
of each curve and at its maximum (at every case if x is a word), and at the maxima of requested features without a
figure. The effect on the cases in between is assumed to be no larger, and some of them are audited. Cases in which
the effect cannot be determined, as in short records, are computed with friction.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from math import inf, isnan

from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.selection.candidates import with_friction
from bearingsim.selection.curves import Curve, curve_extremes
from bearingsim.selection.evidence import Evidence, largest_error
from bearingsim.selection.trials import TrialRequest, trials_of
from bearingsim.simulation.settling import resolve_settling
from bearingsim.simulation.trial import (
    CAGE_REVOLUTIONS,
    LARGEST_FORCE,
    ReferenceValues,
    lengthen_for_trial,
    may_become_record,
    shows_friction,
)
from bearingsim.text.numbers import percent

EARLY_END_FACTOR = 2.0
"""Multiple of the allowed change by friction above which a trial ends after two revolutions of the cage."""

TOO_SHORT = f"the record has fewer than {CAGE_REVOLUTIONS} revolutions of the cage, too few to assess friction"
NOT_PERIODIC = (
    "the response without friction is not periodic, and half the record has under"
    f" {CAGE_REVOLUTIONS} cage revolutions"
)
DIFFERENT_LENGTHS = (
    "the trials of the case and of the healthy bearing have different lengths, because only one is periodic"
)
REFERENCE_FAILS = "the trial without friction fails, so the effect of friction is unknown"


class FrictionEffect:
    """Effect of friction on the cases that do not specify it, from trials.

    tried: numbers of the cases with candidates; limit: largest allowed relative change.
    """

    def __init__(self, evidence: Evidence, tried: Sequence[int], curves: Sequence[Curve], limit: float) -> None:
        self.evidence, self.limit = evidence, limit
        cases = evidence.study.cases()
        self.friction_cases = {n: case for n in tried if (case := with_friction(cases[n])) is not None}
        short_records = {n for n in self.friction_cases if not shows_friction(cases[n])}
        usable = [n for n in self.friction_cases if evidence.reference_values[n] and n not in short_records]
        few_revolutions = {n for n in usable if evidence.revolutions(n) < CAGE_REVOLUTIONS}
        values = {n: [value.value for value in evidence.reference_values[n].values()] for n in usable}
        different_lengths = {n for n in usable if any(map(isnan, values[n]))}
        sufficient = [n for n in usable if n not in few_revolutions | different_lengths]
        failed = [n for n in self.friction_cases if not evidence.reference_values[n]]
        self.undetermined = dict.fromkeys(failed, REFERENCE_FAILS) | dict.fromkeys(few_revolutions, NOT_PERIODIC)
        self.undetermined |= dict.fromkeys(different_lengths, DIFFERENT_LENGTHS) | dict.fromkeys(
            short_records, TOO_SHORT
        )
        tried_curves = [replace(curve, cases=tuple(n for n in curve.cases if n in sufficient)) for curve in curves]
        cases_on_no_curve = set(sufficient) - {n for curve in tried_curves for n in curve.cases}
        self.curves = [curve for curve in tried_curves if curve.cases] + [
            Curve("", (n,)) for n in sorted(cases_on_no_curve)
        ]

    @cached_property
    def extremes(self) -> list[int]:
        """Numbers of the cases tried with friction.

        They are both ends of each curve, and the maxima of its feature and of requested features without a figure.
        """
        assert self.evidence.study.goal is not None
        drawn = {curve.feature for curve in self.curves}
        undrawn = [name for name in self.evidence.study.goal.of if name not in drawn]
        curves = [replace(curve, feature=name) for curve in self.curves for name in (curve.feature, *undrawn)]
        return list(
            dict.fromkeys(n for curve in curves for n in curve_extremes(curve, self.evidence.reference_values))
        )

    def trials(self) -> list[TrialRequest]:
        """Return the trials with friction that are still to be computed."""
        trials = [trial for n in self.extremes for trial in self._trials_of(n)]
        return [trial for trial in trials if trial.id not in self.evidence.trials]

    def _trials_of(self, n: int) -> list[TrialRequest]:
        """Return the trials of a case with friction, and of its healthy counterpart.

        The trial of a case alone may end early; two trials must cover the same number of cage revolutions.
        """
        trials = trials_of(self.evidence.study, n, self._trial_case(n))
        reference_values = self.evidence.reference_values[n]
        features = trials[0].features if len(trials) == 1 else ()
        names = [name for name in features if name in reference_values and name != LARGEST_FORCE]
        limits = {name: EARLY_END_FACTOR * self.limit * self.evidence.scales[name][n] for name in names}
        early_end = ReferenceValues({name: reference_values[name].value for name in names}, limits)
        return [replace(trial, reference_values=(early_end,)) for trial in trials]

    def _trial_case(self, n: int) -> Case:
        """Return the case tried with friction for case number ``n``.

        If its trial may become the record, it is that with friction. Otherwise it settles as long as without
        friction, because the cage's remaining transient is then within the scatter between cage revolutions.
        """
        case, study_case = self.friction_cases[n], self.evidence.study.cases()[n]
        if may_become_record(case):
            return case
        case = case.model_copy(update={"until": None})  # a trial of a lengthened case cannot become a record
        with suppress(Refused):  # the trial reports it
            case = case.model_copy(update={"settle": resolve_settling(study_case).settle})
        return lengthen_for_trial(case)

    @cached_property
    def _changes_at_extremes(self) -> dict[int, dict[str, float | None]]:
        """Bound of the change by friction of each case tried with it, by feature; None if the trial failed."""
        changes: dict[int, dict[str, float | None]] = {}
        for n in self.extremes:
            errors = self.evidence.errors(n, self._trial_case(n))
            changes[n] = dict(errors) if errors else dict.fromkeys(self.evidence.reference_values[n])
        return changes

    def errors(self, n: int) -> Mapping[str, float | None]:
        """Return the change of a case by friction, by feature: its own, or the largest of those on its curves.

        None if unknown; empty for a case that specifies friction.
        """
        if n in self._changes_at_extremes:
            return self._changes_at_extremes[n]
        others = {other for curve in self.curves if n in curve.cases for other in curve.cases}
        changes = [
            self._changes_at_extremes[other] for other in sorted(others) if other in self._changes_at_extremes
        ]
        names = self.evidence.reference_values[n] if changes else ()
        return {name: largest_error([change[name] for change in changes]) for name in names}

    def is_inferred(self, n: int) -> bool:
        """Check if the effect of friction on a case is inferred from other cases on its curves."""
        return bool(self.errors(n)) and n not in self._changes_at_extremes

    @cached_property
    def required_cases(self) -> dict[int, str]:
        """Reasons for friction, by case number: its effect is too large on a curve, or unknown."""
        reasons = dict(self.undetermined)
        for curve in self.curves:
            tried_cases = [n for n in curve.cases if n in self._changes_at_extremes]
            if max(self._largest_at(n)[0] for n in tried_cases) > self.limit:
                reasons |= dict.fromkeys(curve.cases, self._reason(tried_cases))
        return reasons

    def _largest_at(self, n: int) -> tuple[float, str]:
        """Return the largest known change of a case by friction, and its feature."""
        return max(
            ((change, name) for name, change in self._changes_at_extremes[n].items() if change is not None),
            default=(0.0, ""),
        )

    def _reason(self, tried_cases: Sequence[int]) -> str:
        """Explain why a curve is computed with friction, from its cases tried with it.

        The standard errors of a trial that ended early are unknown, and so are the bounds of all features. It
        ended because of the feature with the largest difference.
        """
        change, name = max(map(self._largest_at, tried_cases))
        if change < inf:
            return f"friction changes {name} by up to {percent(change)} on its curve, over {percent(self.limit)}"
        all_differences = [self.evidence.differences(n, self._trial_case(n)) for n in tried_cases]
        changes = [
            (value, feature)
            for differences in all_differences
            for feature, value in differences.items()
            if value < inf
        ]
        difference, largest_feature = max(changes, default=(0.0, ""))
        if difference > self.limit:
            return f"friction changes {largest_feature} by about {percent(difference)}, over {percent(self.limit)}"
        return f"the effect of friction on {name} is unknown, because its trial does not determine it"
