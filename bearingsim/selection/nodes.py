"""Discretisation errors of chosen cases: nodes along defects, slices, harmonics.

A trial on another mesh costs as much as one of the case itself. Along a curve the error varies with the defect,
so only both ends and the case with the largest value are tried. A case in between gets the larger error of its
neighbours.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.selection.candidates import WITH_FRICTION, reference, remeshed
from bearingsim.selection.curves import Curve, extremes
from bearingsim.selection.evidence import Evidence, MeshPair, largest
from bearingsim.selection.trials import TrialRequest, trials_of, unique
from bearingsim.simulation.trial import with_trial_step
from bearingsim.store.choices import Choice


class Discretisation:
    """Discretisation errors of chosen cases from trials.

    mesh_pairs: by number, each case and the same case on another mesh at the same step; failed_cases: numbers of
    the cases whose mesh can be changed and whose own trial failed; uniform_curves: curves of
    cases with the same candidate, model and defect shapes.
    """

    def __init__(
        self,
        evidence: Evidence,
        curves: Sequence[Curve],
        choices: Mapping[int, Choice],
        computed: Callable[[int, str], Case],
    ) -> None:
        """Find the cases whose mesh can be changed.

        computed: returns a case, by number, with a candidate's settings.
        """
        self.evidence, cases = evidence, evidence.study.cases()
        self.mesh_pairs: dict[int, MeshPair] = {}
        self.failed_cases: set[int] = set()
        kinds: dict[int, tuple] = {}
        for n, choice in choices.items():
            is_reference = choice.candidate in (REFERENCE, WITH_FRICTION)
            chosen = reference(cases[n]) if is_reference else computed(n, choice.candidate)
            other = remeshed(chosen, is_reference)
            trial = evidence.trials.get(trials_of(evidence.study, n, chosen)[0].id)
            # for a case with friction the trial has none, because this is cheaper and the nodes are the same
            if other is None:
                continue
            if trial is None:
                self.failed_cases.add(n)
            else:
                self.mesh_pairs[n] = MeshPair(chosen, with_trial_step(other[0], trial), other[1])
                kinds[n] = choice.candidate, chosen.model, *(defect.shape for defect in chosen.defects)
        self.uniform_curves = [
            Curve(curve.feature, tuple(n for n in curve.cases if kinds.get(n) == kind))
            for curve in curves
            for kind in dict.fromkeys(kinds[n] for n in curve.cases if n in kinds)
        ]

    @cached_property
    def tried(self) -> dict[int, None]:
        """Cases that are tried: the extremes of each curve, and cases on no curve."""
        on_curve = {n for curve in self.uniform_curves for n in curve.cases}
        ends = [n for curve in self.uniform_curves for n in extremes(curve, self.evidence.reference_values)]
        return dict.fromkeys(sorted({*ends, *(n for n in self.mesh_pairs if n not in on_curve)}))

    def trials(self) -> list[TrialRequest]:
        """Return the trials on other meshes that are still to be computed."""
        trials = [trials_of(self.evidence.study, n, self.mesh_pairs[n].remeshed_case)[0] for n in self.tried]
        return unique([trial for trial in trials if trial.id not in self.evidence.trials])

    def errors(self, n: int) -> dict[str, float | None]:
        """Return the error of a case by feature, None if unknown; empty for a case without another mesh."""
        assert self.evidence.study.goal is not None
        if n in self.failed_cases:
            return dict.fromkeys(self.evidence.study.goal.of)
        if n not in self.mesh_pairs:
            return {}
        if n in self.tried:
            return self.evidence.node_errors(n, self.mesh_pairs[n])
        neighbours = {
            other for curve in self.uniform_curves if n in curve.cases for other in self._neighbours(n, curve)
        }
        errors = [self.evidence.node_errors(other, self.mesh_pairs[other]) for other in sorted(neighbours)]
        return {name: largest([values[name] for values in errors]) for name in errors[0]}

    def _neighbours(self, n: int, curve: Curve) -> tuple[int, int]:
        """Return the nearest tried cases before and after case ``n`` on a curve."""
        position = curve.cases.index(n)
        before = next(other for other in reversed(curve.cases[:position]) if other in self.tried)
        return before, next(other for other in curve.cases[position:] if other in self.tried)
