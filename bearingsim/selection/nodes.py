"""Discretisation errors of cases with the chosen models: nodes along defects, slices, harmonics.

A trial with another mesh costs as much as the original trial. The error is assumed to vary smoothly along a curve,
so only the ends of a curve and its maximum are computed with another mesh. A case in between gets the largest
error of the nearest remeshed cases on all its curves. Ends and neighbours are those in the order of x; in a
design, neighbours in x may differ in other parameters. If x is a word or a seed, all cases are remeshed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from bearingsim.catalogue import MODELS, REFERENCE
from bearingsim.config import Case
from bearingsim.selection.candidates import WITH_FRICTION, change_mesh, make_reference
from bearingsim.selection.curves import Curve, curve_extremes
from bearingsim.selection.evidence import Evidence, MeshPair, largest_error
from bearingsim.selection.trials import TrialRequest, trials_of, unique
from bearingsim.simulation.trial import with_trial_step
from bearingsim.store.choices import Choice


class Discretisation:
    """Discretisation errors of cases with the chosen models, from trials.

    mesh_pairs: by case number, the case and the same case with another mesh at the same time step (``MeshPair``);
    failed_cases: numbers of the cases whose mesh can be changed and whose own trial is missing or failed;
    uniform_curves: subsets of curves whose cases have the same candidate, model and defect shapes.
    """

    def __init__(
        self,
        evidence: Evidence,
        curves: Sequence[Curve],
        choices: Mapping[int, Choice],
        case_with: Callable[[int, str], Case],
    ) -> None:
        """Select the cases whose mesh can be changed.

        curves: of the study (``curves.list_curves``); choices: by case number; case_with: function that returns
        the case of a number with the settings of a candidate name.
        """
        self.evidence, cases = evidence, evidence.study.cases()
        self.mesh_pairs: dict[int, MeshPair] = {}
        self.failed_cases: set[int] = set()
        group_of: dict[int, tuple] = {}
        for n, choice in choices.items():
            is_reference = choice.candidate in (REFERENCE, WITH_FRICTION)
            # also for a case with friction: the trial without friction is cheaper, and has the same mesh
            chosen = make_reference(cases[n]) if is_reference else case_with(n, choice.candidate)
            mesh_change = change_mesh(chosen, is_reference)
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
                group_of[n] = choice.candidate, chosen.model, *(defect.shape for defect in chosen.defects)
        self.uniform_curves = [
            replace(curve, cases=tuple(n for n in curve.cases if group_of.get(n) == group))
            for curve in curves
            for group in dict.fromkeys(group_of[n] for n in curve.cases if n in group_of)
        ]

    @cached_property
    def remeshed_cases(self) -> dict[int, None]:
        """Numbers (ascending keys) of the cases computed with another mesh.

        They are the extremes of each curve, and the cases on no curve.
        """
        on_curve = {n for curve in self.uniform_curves for n in curve.cases}
        extreme_cases = [
            n for curve in self.uniform_curves for n in curve_extremes(curve, self.evidence.reference_values)
        ]
        return dict.fromkeys(sorted({*extreme_cases, *(n for n in self.mesh_pairs if n not in on_curve)}))

    def trials(self) -> list[TrialRequest]:
        """Return the trials with another mesh that are still to be computed, in ascending order of the cases."""
        trials: list[TrialRequest] = []
        for n in self.remeshed_cases:
            mesh_pair = self.mesh_pairs[n]
            remeshed_trials = trials_of(self.evidence.study, n, mesh_pair.remeshed_case)
            trials += remeshed_trials if mesh_pair.remeshes_healthy else remeshed_trials[:1]
        return unique([trial for trial in trials if trial.id not in self.evidence.trials])

    def errors(self, n: int) -> dict[str, float | None]:
        """Return the discretisation error of a case by feature, relative to ``curves.error_scales``.

        None if a trial failed or the error is unknown; empty if the mesh cannot be changed, which counts as no
        error.
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
        return {name: largest_error([values[name] for values in errors]) for name in errors[0]}

    def _neighbours(self, n: int, curve: Curve) -> tuple[int, int]:
        """Return the nearest remeshed cases before and after case ``n`` on a curve."""
        position = curve.cases.index(n)
        preceding = next(number for number in reversed(curve.cases[:position]) if number in self.remeshed_cases)
        return preceding, next(number for number in curve.cases[position:] if number in self.remeshed_cases)
