"""Evidence from the trials of a study: feature values of its cases, and errors of their candidates."""

from collections.abc import Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from bearingsim.config import Case
from bearingsim.selection.candidates import reference
from bearingsim.selection.curves import Curve, scales
from bearingsim.selection.judge import Value, error, value
from bearingsim.selection.trials import Known, trials_of
from bearingsim.study import Study


class Recut(NamedTuple):
    """Case, the same case with other nodes, and the ratio of its discretisation error to their difference."""

    case: Case
    recut: Case
    times: float


class Evidence:
    """Relative errors of candidates from trials (relative to ``curves.scales``)."""

    def __init__(self, study: Study, drawn: Sequence[Curve], trials: Known) -> None:
        self.study, self.known = study, trials
        assert self.study.goal is not None
        self.of_reference = [self._values(n, reference(case)) for n, case in enumerate(self.study.cases())]
        self.sizes = {
            feature: scales(feature, [of[feature].value if of else nan for of in self.of_reference], drawn)
            for feature in self.study.goal.of
        }

    def errors(self, n: int, case: Case) -> dict[str, float]:
        """Return error bounds of a case used for case number ``n``, by feature; empty if a trial failed."""
        own, other = self._values(n, case), self.of_reference[n]
        if not own or not other:
            return {}
        return {name: _relative(error(own[name], other[name]), self.sizes[name][n]) for name in own}

    def turns(self, n: int) -> int:
        """Return the number of turns in the trial of the reference of case ``n``, 0 if the trial failed."""
        trial = self.known.get(trials_of(self.study, n, reference(self.study.cases()[n]))[0].id)
        return 0 if trial is None else trial.turns

    def node_errors(self, n: int, other: Recut) -> dict[str, float | None]:
        """Return the discretisation errors for case number ``n``, by feature; None if unknown.

        No scatter is added for a periodic motion, because one period describes it completely.
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
        shares = {name: other.times * _relative(of, self.sizes[name][n]) for name, of in errors.items()}
        return {name: of if of < inf else None for name, of in shares.items()}

    def _values(self, n: int, case: Case, beside: Case | None = None) -> dict[str, Value]:
        """Read the features of a case from its trial and that of its healthy counterpart; empty if one failed.

        beside: case whose healthy counterpart is used instead.
        """
        assert self.study.goal is not None
        baselines = trials_of(self.study, n, beside or case)[1:]
        trials = [self.known.get(trial.id) for trial in (trials_of(self.study, n, case)[0], *baselines)]
        own, baseline = trials[0], trials[-1] if len(trials) > 1 else None
        if own is None or None in trials or (baseline is not None and baseline.turns != own.turns):
            return {}
        return {feature: value(feature, own, baseline) for feature in self.study.goal.of}


def _relative(error: float, size: float) -> float:
    """Return error / size, or the error itself if the size is zero; infinite if either is unknown."""
    share = error / (size or 1.0)
    return share if np.isfinite(share) else inf


def largest(errors: Sequence[float | None]) -> float | None:
    """Return the largest of one or more errors; None if one of them is unknown."""
    numbers = [error for error in errors if error is not None]
    return max(numbers) if len(numbers) == len(errors) else None
