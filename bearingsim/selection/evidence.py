"""Evidence from the trials of a study: feature values of its cases, and errors of their candidates."""

from collections.abc import Mapping, Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from bearingsim.config import Case
from bearingsim.selection.candidates import reference
from bearingsim.selection.curves import Curve, scales
from bearingsim.selection.differences import Value, error, value
from bearingsim.selection.trials import TrialResults, trials_of
from bearingsim.study import Study


class MeshPair(NamedTuple):
    """Case, the same case with another mesh, and the ratio of its discretisation error to their difference.

    remeshes_healthy: whether the mesh of the healthy counterpart changes as well: slices or harmonics do, nodes
    along defects do not.
    """

    case: Case
    remeshed_case: Case
    factor: float
    remeshes_healthy: bool = False


class Evidence:
    """Relative errors of candidates from trials (relative to ``curves.scales``)."""

    def __init__(self, study: Study, curves: Sequence[Curve], trials: TrialResults) -> None:
        self.study, self.trials = study, trials
        assert self.study.goal is not None
        self.reference_values = [self._values(n, reference(case)) for n, case in enumerate(self.study.cases())]
        self.scales = {
            feature: scales(
                feature, [values[feature].value if values else nan for values in self.reference_values], curves
            )
            for feature in self.study.goal.of
        }

    def errors(self, n: int, case: Case) -> dict[str, float]:
        """Return error bounds of a case used for case number ``n``, by feature; empty if a trial failed."""
        values, reference_values = self._values(n, case), self.reference_values[n]
        if not values or not reference_values:
            return {}
        return {
            name: _relative(error(values[name], reference_values[name]), self.scales[name][n]) for name in values
        }

    def differences(self, n: int, case: Case) -> dict[str, float]:
        """Return the relative differences of a case used for case number ``n``, by feature, without their scatter.

        Infinite if unknown; empty if a trial failed.
        """
        values, reference_values = self._values(n, case), self.reference_values[n]
        if not values or not reference_values:
            return {}
        return {
            name: _relative(abs(values[name].value - reference_values[name].value), self.scales[name][n])
            for name in values
        }

    def sizes(self, n: int) -> tuple[dict[str, float | None], dict[str, float | None]]:
        """Return by feature the absolute value (SI) of the reference of case ``n``, and the scale of its errors.

        None if unknown.
        """
        values = {name: abs(value.value) for name, value in self.reference_values[n].items()}
        case_scales = {name: feature_scales[n] for name, feature_scales in self.scales.items()}
        return _known(values), _known(case_scales)

    def turns(self, n: int) -> int:
        """Return the number of revolutions in the trial of the reference of case ``n``, 0 if the trial failed."""
        trial = self.trials.get(trials_of(self.study, n, reference(self.study.cases()[n]))[0].id)
        return 0 if trial is None else trial.turns

    def discretisation_errors(self, n: int, meshes: MeshPair) -> dict[str, float | None]:
        """Return the relative discretisation errors for case number ``n``, by feature; None if unknown.

        No scatter is added for a periodic motion, because one period describes it completely.
        """
        assert self.study.goal is not None
        baseline_case = None if meshes.remeshes_healthy else meshes.case
        values, remeshed_values = (
            self._values(n, meshes.case),
            self._values(n, meshes.remeshed_case, baseline_case),
        )
        if not values or not remeshed_values:
            return dict.fromkeys(self.study.goal.of)
        trials = [
            self.trials[trials_of(self.study, n, case)[0].id] for case in (meshes.case, meshes.remeshed_case)
        ]
        is_periodic = all(trial is not None and trial.repeats for trial in trials)
        errors = {
            name: abs(values[name].value - remeshed_values[name].value)
            if is_periodic
            else error(values[name], remeshed_values[name])
            for name in values
        }
        shares = {name: meshes.factor * _relative(share, self.scales[name][n]) for name, share in errors.items()}
        return {name: share if share < inf else None for name, share in shares.items()}

    def _values(self, n: int, case: Case, baseline_case: Case | None = None) -> dict[str, Value]:
        """Read the features of a case from its trial and that of its healthy counterpart.

        Empty if one failed; NaN if the numbers of their revolutions differ.

        baseline_case: case whose healthy counterpart is used instead.
        """
        assert self.study.goal is not None
        baselines = trials_of(self.study, n, baseline_case or case)[1:]
        trials = [self.trials.get(trial.id) for trial in (trials_of(self.study, n, case)[0], *baselines)]
        trial, baseline = trials[0], trials[-1] if len(trials) > 1 else None
        if trial is None or None in trials:
            return {}
        if baseline is not None and baseline.turns != trial.turns:
            return dict.fromkeys(self.study.goal.of, Value(nan, np.empty(0), 0.0))  # cannot be compared
        return {feature: value(feature, trial, baseline) for feature in self.study.goal.of}


def _relative(error: float, size: float) -> float:
    """Return error / size, 0 without an error; infinite if either is unknown, or any error of a size of zero."""
    if error == 0.0:
        return 0.0
    share = error / size if size else inf
    return share if np.isfinite(share) else inf


def _known(sizes: Mapping[str, float]) -> dict[str, float | None]:
    """Replace NaN, for which JSON has no number, by None."""
    return {name: size if np.isfinite(size) else None for name, size in sizes.items()}


def largest(errors: Sequence[float | None]) -> float | None:
    """Return the largest of one or more errors; None if one of them is unknown."""
    numbers = [error for error in errors if error is not None]
    return max(numbers) if len(numbers) == len(errors) else None
