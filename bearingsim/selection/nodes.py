"""Discretisation errors of cases with the chosen models: nodes along defects, slices, harmonics.

A trial with another mesh costs as much as the original trial. The error is assumed to vary smoothly along a curve,
so only the ends of a curve and its maximum are computed with another mesh. A case in between gets the largest
error of the nearest remeshed cases on all its curves. Ends and neighbours are those in the order of x; in a
design, neighbours in x may differ in other parameters. If x is a word, all cases are remeshed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from bearingsim.catalogue import MODELS, REFERENCE
from bearingsim.config import Case
from bearingsim.selection.candidates import WITH_FRICTION, reference, remeshed
from bearingsim.selection.curves import Curve, extremes
from bearingsim.selection.evidence import Evidence, MeshPair, largest
from bearingsim.selection.trials import TrialRequest, trials_of, unique
from bearingsim.simulation.trial import with_trial_step
from bearingsim.store.choices import Choice


class Discretisation:
    """Discretisation errors of cases with the chosen models, from trials.

    mesh_pairs: by case number, the case and the same case with another mesh at the same time step (``MeshPair``);
    failed_cases: numbers of the cases whose mesh can be changed and whose own trial is missing or failed;
    uniform_curves: parts of curves whose cases have the same candidate, model and defect shapes.
    """

    def __init__(
        self,
        evidence: Evidence,
        curves: Sequence[Curve],
        choices: Mapping[int, Choice],
        case_with: Callable[[int, str], Case],
    ) -> None:
        """Select the cases whose mesh can be changed.

        curves: of the study (``curves.curves``); choices: by case number; case_with: function of case number and
        candidate name, returns the case with the candidate's settings.
        """
        self.evidence, cases = evidence, evidence.study.cases()
        self.mesh_pairs: dict[int, MeshPair] = {}
        self.failed_cases: set[int] = set()
        groups: dict[int, tuple] = {}
        for n, choice in choices.items():
            is_reference = choice.candidate in (REFERENCE, WITH_FRICTION)
            # also for a case with friction the trial without it is used: it is cheaper, and the mesh is the same
            chosen = reference(cases[n]) if is_reference else case_with(n, choice.candidate)
            mesh_change = remeshed(chosen, is_reference)
            trial = evidence.trials.get(trials_of(evidence.study, n, chosen)[0].id)
            if mesh_change is None:
                continue
            if trial is None:
                self.failed_cases.add(n)
            else:
                remeshed_case, factor = mesh_change
                remeshes_healthy = is_reference and (MODELS[chosen.model].sliced or chosen.rig.ring is not None)
                other_mesh = with_trial_step(remeshed_case, trial)
                self.mesh_pairs[n] = MeshPair(chosen, other_mesh, factor, remeshes_healthy)
                groups[n] = choice.candidate, chosen.model, *(defect.shape for defect in chosen.defects)
        self.uniform_curves = [
            replace(curve, cases=tuple(n for n in curve.cases if groups.get(n) == group))
            for curve in curves
            for group in dict.fromkeys(groups[n] for n in curve.cases if n in groups)
        ]

    @cached_property
    def remeshed_cases(self) -> dict[int, None]:
        """Numbers (ascending keys) of the cases computed with another mesh: extremes of each curve, and all cases
        on no curve."""
        on_curve = {n for curve in self.uniform_curves for n in curve.cases}
        extreme_cases = [
            n for curve in self.uniform_curves for n in extremes(curve, self.evidence.reference_values)
        ]
        return dict.fromkeys(sorted({*extreme_cases, *(n for n in self.mesh_pairs if n not in on_curve)}))

    def trials(self) -> list[TrialRequest]:
        """Return the missing trials with another mesh, in ascending order of the cases."""
        trials: list[TrialRequest] = []
        for n in self.remeshed_cases:
            pair = self.mesh_pairs[n]
            remeshed_trials = trials_of(self.evidence.study, n, pair.remeshed_case)
            trials += remeshed_trials if pair.remeshes_healthy else remeshed_trials[:1]
        return unique([trial for trial in trials if trial.id not in self.evidence.trials])

    def errors(self, n: int) -> dict[str, float | None]:
        """Return the discretisation error of a case by feature, relative to ``curves.scales``.

        None if a trial failed; empty, which counts as no error, if the mesh cannot be changed.
        """
        assert self.evidence.study.goal is not None
        if n in self.failed_cases:
            return dict.fromkeys(self.evidence.study.goal.of)
        if n not in self.mesh_pairs:
            return {}
        if n in self.remeshed_cases:
            return self.evidence.discretisation_errors(n, self.mesh_pairs[n])
        neighbours = {
            number for curve in self.uniform_curves if n in curve.cases for number in self._neighbours(n, curve)
        }
        errors = [
            self.evidence.discretisation_errors(number, self.mesh_pairs[number]) for number in sorted(neighbours)
        ]
        return {name: largest([values[name] for values in errors]) for name in errors[0]}

    def _neighbours(self, n: int, curve: Curve) -> tuple[int, int]:
        """Return the nearest remeshed cases before and after case ``n`` on a curve."""
        position = curve.cases.index(n)
        preceding = next(number for number in reversed(curve.cases[:position]) if number in self.remeshed_cases)
        return preceding, next(number for number in curve.cases[position:] if number in self.remeshed_cases)
