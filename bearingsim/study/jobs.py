"""Cases of a study, their ids, and the jobs to compute."""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import Any, NamedTuple

from bearingsim.catalogue import AUTO, MODELS
from bearingsim.config import Case
from bearingsim.config.channels import slice_number
from bearingsim.config.names import MEANS
from bearingsim.config.rules.hierarchy import has_default_friction, specifies_slip
from bearingsim.study.design import Design, SampledDesign
from bearingsim.study.figures import Figure
from bearingsim.study.goal import Goal
from bearingsim.study.measured_values import MeasuredSet
from bearingsim.study.paths import dimension
from bearingsim.study.uncertainty import (
    DEFAULT_DAMPING,
    NO_OIL,
    NO_SLIP,
    RIGID_RING,
    TRIED_FRICTION,
    WITHOUT_FRICTION,
    UncertainParameter,
    assumes_rigid_ring,
    sample_cases,
    variations,
)
from bearingsim.study.used import extensions, json_text, relevant_fields
from bearingsim.text.html import describe_values, table_html
from bearingsim.text.units import DISPLAY, show


@dataclass(frozen=True)
class Job:
    """Simulation of a study: its case, its swept values (SI, or words), and its healthy baseline.

    baseline: None for a bearing without defects; is_baseline: the job is only computed for comparison;
    is_variation: the job is only computed for the uncertainty of another one.
    """

    case: Case
    swept: dict[str, float | str] = field(default_factory=dict)
    baseline: "Job | None" = None
    is_baseline: bool = False
    is_variation: bool = False

    @cached_property
    def id(self) -> str:
        """Id of 16 hex digits (``case_id``); for `method: auto` this computes the step limits of the case."""
        return case_id(self.case)

    @property
    def healthy(self) -> str | None:
        """Id of the baseline; None without one."""
        return None if self.baseline is None else self.baseline.id


@dataclass(frozen=True)
class Variation:
    """Job with another ``value`` (SI) of the uncertain parameter ``what`` of a case."""

    case: Case
    what: str
    value: float
    job: Job

    @property
    def of(self) -> str:
        """Id of the job that this one is compared with."""
        return case_id(self.case)


@dataclass(frozen=True)
class Audit:
    """Recomputation of a job with the reference model; ``of``: id of the job that it checks.

    baseline: healthy baseline of the recomputation, if it has one.
    """

    of: str
    job: Job
    baseline: Job | None = None


class ModelChoice(NamedTuple):
    """Model chosen for a case, the reason, and its relative errors by feature.

    error: deviation from the reference; nodes: discretisation error of nodes along defects, slices and harmonics;
    friction: error of omitted friction; each is None if unknown.
    """

    model: str
    why: str
    error: dict[str, float | None]
    nodes: dict[str, float | None]
    friction: dict[str, float | None]


@dataclass(frozen=True)
class Selection:
    """Models chosen for a study with `accuracy` (``bearingsim/selection``).

    jobs: choices by the id of the case; curves: pairs of a feature and the ids on its curve; notes: remarks on
    choices that were made for an earlier plan.
    """

    jobs: Mapping[str, ModelChoice]
    curves: tuple[tuple[str, tuple[str, ...]], ...]
    audits: tuple[Audit, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Study:
    """Validated study: ``text`` of its file, and ``units`` of the swept paths as written in it.

    notes: remarks on the file for the user; goal: required accuracy, with which the swept cases have the reference
    model; cases_with: function that returns these cases with changed values at some paths, None for invalid ones;
    sampled_design: swept design, by indices of cases (``design``: by ids of jobs);
    files: those read (``text/files_read.py``); left_out: parameters of `uncertainty` that `quick` omits.
    """

    name: str
    path: str
    text: str
    overrides: dict[str, str]
    quick: bool
    figures: tuple[Figure, ...]
    units: dict[str, str]
    swept_cases: tuple[tuple[Case, dict[str, float | str]], ...] = field(repr=False)
    cases_with: Callable[[Mapping[str, str]], list[Case | None]] = field(repr=False, compare=False)
    notes: tuple[str, ...] = ()
    uncertainty: tuple[UncertainParameter, ...] | None = None
    left_out: tuple[UncertainParameter, ...] = ()
    files: Mapping[str, str | None] = field(default_factory=dict, repr=False)
    goal: Goal | None = None
    selection: Selection | None = None
    sampled_design: SampledDesign | None = None
    measured: tuple[MeasuredSet, ...] = ()

    def cases(self) -> list[Case]:
        """List the swept cases; the last entry of `sweep` varies fastest."""
        return [case for case, _ in self.swept_cases]

    def jobs(self) -> list[Job]:
        """List every job once: the cases, their healthy baselines, their variations, then the audits."""
        audits = () if self.selection is None else self.selection.audits
        audit_jobs = [job for audit in audits for job in (audit.job, audit.baseline) if job is not None]
        return _unique([*self._planned, *(variation.job for variation in self.variations()), *audit_jobs])

    def _repr_html_(self) -> str:
        """Return a summary for notebooks."""
        rows = [("file", self.path), ("cases", str(len(self.swept_cases)))]
        for path, unit in self.units.items():
            values = list(dict.fromkeys(swept[path] for _, swept in self.swept_cases if path in swept))
            rows.append((path, describe_values(values, partial(_format_value, path, unit))))
        if self.goal is not None:
            rows.append(("accuracy", self.goal.text))
        rows.append(("figures", str(len(self.figures))))
        return table_html(f"Study {self.name}{' (quick)' if self.quick else ''}", rows)

    def planned(self) -> list[Job]:
        """List the cases, then their healthy baselines."""
        return list(self._planned)

    @cached_property
    def design(self) -> Design | None:
        """Design that the study sweeps, with the ids of its rows; None without a design."""
        design = self.sampled_design
        if design is None:
            return None
        ids = tuple(case_id(self.swept_cases[number][0]) for number in design.cases)
        return Design(design.kind, design.n, design.seed, design.paths, design.ranges, ids)

    @cached_property
    def _planned(self) -> tuple[Job, ...]:
        jobs: list[Job] = []
        healthy_jobs: dict[str, Job] = {}  # by ``identity``, because many cases share a baseline
        for case, swept in self.swept_cases:
            healthy_job = _healthy_baseline(case, swept)
            jobs.append(
                Job(case, swept, healthy_job and healthy_jobs.setdefault(identity(healthy_job.case), healthy_job))
            )
        return tuple(_unique([*jobs, *healthy_jobs.values()]))

    @cached_property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions about effects that the study does not specify, and warnings of its cases, in words."""
        from bearingsim.study.ranges import (  # imports the core, which takes a second
            omission_warnings,
            range_warnings,
        )

        plotted = [name for figure in self.figures for name in figure.features]
        rigid = assumes_rigid_ring(self.cases(), plotted, self.uncertainty)
        cases = self.cases()
        warnings = omission_warnings(cases) if self.goal is None else ()
        return (RIGID_RING,) * rigid + self._slip_assumption() + (*warnings, *range_warnings(cases, plotted))

    def _slip_assumption(self) -> tuple[str, ...]:
        """Return the assumption on friction and oil of a study with `accuracy`, in words."""
        if self.goal is None or any(case.drag is not None for case in self.cases()):
            return ()
        if self.selection is None and any(map(has_default_friction, self.cases())):
            return (f"{TRIED_FRICTION} (docs/accuracy.md)",)
        choices = [] if self.selection is None else list(self.selection.jobs.values())
        frictionless = sum(bool(choice.friction) for choice in choices)
        if frictionless:
            return (f"{frictionless} of {len(choices)} cases computed {WITHOUT_FRICTION}",)
        return (NO_OIL,) if any(map(specifies_slip, self.cases())) else (NO_SLIP,)

    def variations(self) -> list[Variation]:
        """List the variations of cases: those of `uncertainty`, by default of the damping in a few cases.

        A design without `uncertainty` has no variations, so that extending it only adds its new points; a reduced
        grid has none either.
        """
        return self._variations

    @cached_property
    def _variations(self) -> list[Variation]:
        if self.uncertainty is not None or self.sampled_design is not None or self.quick:
            cases, uncertain = self.cases(), self.uncertainty or ()
        else:
            cases, uncertain = sample_cases(self.cases(), len(self.planned())), (DEFAULT_DAMPING,)
        return [
            Variation(case, what, value, Job(varied, is_variation=True))
            for case in cases
            for what, value, varied in variations(case, uncertain)
        ]


def _format_value(path: str, unit: str, value: float | str) -> str:
    """Format a swept value in the unit of the study file; without one, in that of ``DISPLAY``."""
    if isinstance(value, str):
        return value
    kind = dimension(path)
    return show(value, unit or (DISPLAY[kind] if kind else ""), kind)


def _unique(jobs: Iterable[Job]) -> list[Job]:
    """Remove duplicate jobs, preserving the order."""
    unique: dict[str, Job] = {}
    for job in jobs:
        unique.setdefault(identity(job.case), job)
    return list(unique.values())


def case_id(case: Case) -> str:
    """Return the id of a case's result, 16 hex digits: equal for equal physics, independent of the notation.

    `auto` is replaced by the methods that it tries, in order, because a new cost model can change these and thus
    the results.
    """
    if case.method != AUTO:
        return identity(case)
    from bearingsim.simulation.choice import candidate_methods

    return identity(case, {"method": candidate_methods(case)})


def identity(case: Case, extra: Mapping[str, Any] | None = None) -> str:
    """Return the hash of a case, 16 hex digits that are equal for cases with equal parameters.

    They depend on all parameters that affect the results (12 significant digits), on ``extra`` entries and the
    model's version, but not on unused parameters, or the names and sources of bearing, rig and material.
    """
    from bearingsim.core import FORM_VERSION, MODEL_VERSION

    extra = dict(extra or {}) | ({"form_version": FORM_VERSION} if case.surfaces is not None else {})
    entries = ((name, tuple(value) if isinstance(value, list) else value) for name, value in extra.items())
    return _digest(case, tuple(entries), MODEL_VERSION)


@lru_cache(maxsize=1 << 18)
def _digest(case: Case, extra: tuple[tuple[str, Any], ...], version: int) -> str:
    entries = {"model_version": version} | extensions(case) | dict(extra)
    texts = relevant_fields(case) | {name: json_text(value) for name, value in entries.items()}
    text = ",".join(f'"{name}":{texts[name]}' for name in sorted(texts))
    return hashlib.sha256(f"{{{text}}}".encode()).hexdigest()[:16]


def _healthy_baseline(case: Case, swept: dict[str, float | str]) -> Job | None:
    """Return the healthy baseline of a case, or None."""
    healthy = healthy_case(case)
    if healthy is None:
        return None
    excluded = _defect_keys(case)
    values = {path: value for path, value in swept.items() if path.split(".")[0] not in excluded}
    return Job(healthy, values, is_baseline=True)


def healthy_case(case: Case) -> Case | None:
    """Return the case without its defects; None if it has none, or for the impulse model."""
    if not case.defects or not MODELS[case.model].has_defect_geometry:
        return None
    changes: dict[str, Any] = {
        name: Case.model_fields[name].default for name in _defect_keys(case) & Case.model_fields.keys()
    }
    # slices, and the spectral lines of defects, exist only with the defects
    changes["record"] = tuple(name for name in case.record if slice_number(name) is None)
    changes["features"] = tuple(name for name in case.features if name not in MEANS)
    return case.model_copy(update=changes)


def _defect_keys(case: Case) -> set[str]:
    """Return the keys that the healthy baseline does not use."""
    return {"defect", "defects", "excitation"} | ({"seed"} if not MODELS[case.model].slips else set())
