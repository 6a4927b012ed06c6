"""Errors of candidates and feature values of the cases of a study, from trials."""

from collections.abc import Mapping, Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from bearingsim.config import Case
from bearingsim.selection.candidates import make_reference
from bearingsim.selection.curves import Curve, error_scales
from bearingsim.selection.differences import FeatureValue, difference_bound, feature_value
from bearingsim.selection.trials import TrialResults, trials_of
from bearingsim.study import Study


class MeshPair(NamedTuple):
    """Case, the same case with another mesh, and the ratio of its discretisation error to their difference.

    remeshes_healthy: whether the mesh of the healthy counterpart differs as well, as for slices or harmonics, but
    not for nodes along defects.
    """

    case: Case
    remeshed_case: Case
    factor: float
    remeshes_healthy: bool = False


class Evidence:
    """Relative errors of candidates from trials; they are relative to ``curves.error_scales``."""

    def __init__(self, study: Study, curves: Sequence[Curve], trials: TrialResults) -> None:
        self.study, self.trials = study, trials
        assert self.study.goal is not None
        self.reference_values = [
            self._values(n, make_reference(case)) for n, case in enumerate(self.study.cases())
        ]
        self.scales = {
            feature: error_scales(
                feature, [values[feature].value if values else nan for values in self.reference_values], curves
            )
            for feature in self.study.goal.of
        }

    def errors(self, n: int, case: Case) -> dict[str, float]:
        """Return error bounds by feature if ``case`` is used for case number ``n``; empty if a trial failed."""
        values, reference_values = self._values(n, case), self.reference_values[n]
        if not values or not reference_values:
            return {}
        return {
            name: _relative(difference_bound(values[name], reference_values[name]), self.scales[name][n])
            for name in values
        }

    def differences(self, n: int, case: Case) -> dict[str, float]:
        """Return the errors by feature if ``case`` is used for case number ``n``, without their standard errors.

        Infinite if unknown; empty if a trial failed.
        """
        values, reference_values = self._values(n, case), self.reference_values[n]
        if not values or not reference_values:
            return {}
        return {
            name: _relative(abs(values[name].value - reference_values[name].value), self.scales[name][n])
            for name in values
        }

    def magnitudes_and_scales(self, n: int) -> tuple[dict[str, float | None], dict[str, float | None]]:
        """Return absolute values (SI) of the reference of case ``n``, and the scales of its errors, by feature.

        None if unknown.
        """
        values = {name: abs(value.value) for name, value in self.reference_values[n].items()}
        case_scales = {name: feature_scales[n] for name, feature_scales in self.scales.items()}
        return _nan_to_none(values), _nan_to_none(case_scales)

    def revolutions(self, n: int) -> int:
        """Return the number of revolutions in the trial of the reference of case ``n``, 0 if the trial failed."""
        trial = self.trials.get(trials_of(self.study, n, make_reference(self.study.cases()[n]))[0].id)
        return 0 if trial is None else trial.revolutions

    def discretisation_errors(self, n: int, pair: MeshPair) -> dict[str, float | None]:
        """Return the relative discretisation errors for case number ``n``, by feature; None if unknown.

        No standard error is added for a periodic motion, because one period describes it completely.
        """
        assert self.study.goal is not None
        baseline_case = None if pair.remeshes_healthy else pair.case
        values, remeshed_values = (self._values(n, pair.case), self._values(n, pair.remeshed_case, baseline_case))
        if not values or not remeshed_values:
            return dict.fromkeys(self.study.goal.of)
        trials = [self.trials[trials_of(self.study, n, case)[0].id] for case in (pair.case, pair.remeshed_case)]
        is_periodic = all(trial is not None and trial.is_periodic for trial in trials)
        errors = {
            name: abs(values[name].value - remeshed_values[name].value)
            if is_periodic
            else difference_bound(values[name], remeshed_values[name])
            for name in values
        }
        relative_errors = {
            name: pair.factor * _relative(bound, self.scales[name][n]) for name, bound in errors.items()
        }
        return {name: bound if bound < inf else None for name, bound in relative_errors.items()}

    def _values(self, n: int, case: Case, baseline_case: Case | None = None) -> dict[str, FeatureValue]:
        """Return the features of a case from its trial and that of its healthy counterpart.

        Empty if one failed; NaN if the numbers of their revolutions differ. baseline_case: case whose healthy
        counterpart is used instead.
        """
        assert self.study.goal is not None
        baselines = trials_of(self.study, n, baseline_case or case)[1:]
        trials = [self.trials.get(trial.id) for trial in (trials_of(self.study, n, case)[0], *baselines)]
        trial, baseline = trials[0], trials[-1] if len(trials) > 1 else None
        if trial is None or None in trials:
            return {}
        if baseline is not None and baseline.revolutions != trial.revolutions:
            return dict.fromkeys(self.study.goal.of, FeatureValue(nan, np.empty(0), 0.0))  # cannot be compared
        return {feature: feature_value(feature, trial, baseline) for feature in self.study.goal.of}


def _relative(error: float, scale: float) -> float:
    """Return error / scale; 0 for no error, infinite if one of them is unknown or the scale is zero."""
    if error == 0.0:
        return 0.0
    ratio = error / scale if scale else inf
    return ratio if np.isfinite(ratio) else inf


def _nan_to_none(values: Mapping[str, float]) -> dict[str, float | None]:
    """Replace NaN and infinity, which JSON does not have, by None."""
    return {name: value if np.isfinite(value) else None for name, value in values.items()}


def largest_error(errors: Sequence[float | None]) -> float | None:
    """Return the largest of one or more errors; None if one of them is unknown."""
    finite_errors = [error for error in errors if error is not None]
    return max(finite_errors) if len(finite_errors) == len(errors) else None
