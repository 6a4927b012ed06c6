"""What a study expands to: cases, their ids, and the jobs that a runner works through."""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.catalogue import AUTO, MODELS
from bearingsim.config import Case
from bearingsim.config.channels import slice_number
from bearingsim.config.rules.hierarchy import leaves_friction_open, speaks_of_slip
from bearingsim.study.design import Design, Drawn
from bearingsim.study.uncertainty import (
    NO_OIL,
    NO_SLIP,
    RIGID,
    USUAL,
    Uncertain,
    assumes_rigid_ring,
    sampled,
    variations,
)
from bearingsim.study.used import extensions, json_text, used

if TYPE_CHECKING:
    from bearingsim.study.goal import Goal


@dataclass(frozen=True)
class Figure:
    """A figure of a study: features against a swept path, one curve per `by`, one panel per `panels`."""

    y: tuple[str, ...]
    x: str
    by: tuple[str, ...] = ()
    panels: tuple[str, ...] = ()
    where: dict[str, str] = field(default_factory=dict)
    title: str | None = None
    log: tuple[str, ...] = ()


@dataclass(frozen=True)
class Job:
    """One simulation of a study: its case, its swept values (SI, or words), and its healthy baseline.

    `baseline` is None for a bearing without defects, which is its own; `is_baseline` tells a job that is there
    only to be compared with, `is_variation` one that shows what the unknown does to another.
    """

    case: Case
    swept: dict[str, float | str] = field(default_factory=dict)
    baseline: "Job | None" = None
    is_baseline: bool = False
    is_variation: bool = False

    @cached_property
    def id(self) -> str:
        """16 hex digits (``case_id``), which take the limits of the case's step to find."""
        return case_id(self.case)

    @property
    def healthy(self) -> str | None:
        """The id of the baseline."""
        return None if self.baseline is None else self.baseline.id


@dataclass(frozen=True)
class Variation:
    """A job with another value (SI) of what is not known in a case."""

    case: Case
    what: str
    value: float
    job: Job

    @property
    def of(self) -> str:
        """The id of the job it is compared with."""
        return case_id(self.case)


@dataclass(frozen=True)
class Audit:
    """A job computed again by the model that others are judged by; ``of``: the id of the job that it checks.

    healthy: its baseline, if it is compared with one.
    """

    of: str
    job: Job
    healthy: Job | None = None


class Chosen(NamedTuple):
    """A model that was chosen for a case, why, and its errors, relative, by feature.

    error: against the reference; nodes: of nodes along defects, slices and harmonics; friction: of friction, if it
    is left out; both None where they are unknown.
    """

    model: str
    why: str
    error: dict[str, float]
    nodes: dict[str, float | None]
    friction: dict[str, float | None]


@dataclass(frozen=True)
class Selection:
    """What was chosen for a study that names an accuracy (``bearingsim/selection``).

    jobs: by the id of each case; curves: features, and the ids on each curve; notes: remarks on choices that were
    made for an earlier plan.
    """

    jobs: Mapping[str, Chosen]
    curves: tuple[tuple[str, tuple[str, ...]], ...]
    audits: tuple[Audit, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Study:
    """A study file, read and checked: `text` as written, `units` of the swept paths as written there.

    notes: what the user is to be told of the file, though it is read. goal: the accuracy that is asked for; then
    the swept cases have the model that others are judged by, and ``otherwise`` gives the same cases with other
    values at some paths, None for those that cannot be. drawn: the design that is swept, by numbers of cases;
    ``design`` says it by the jobs' ids, those of the models that have been chosen. files: what it is made of
    (``text/files_read.py``). left_out: what `uncertainty` varies, and `quick` does not.
    """

    name: str
    path: str
    text: str
    overrides: dict[str, str]
    quick: bool
    figures: tuple[Figure, ...]
    units: dict[str, str]
    swept_cases: tuple[tuple[Case, dict[str, float | str]], ...] = field(repr=False)
    notes: tuple[str, ...] = ()
    uncertainty: tuple[Uncertain, ...] | None = None
    left_out: tuple[Uncertain, ...] = ()
    files: Mapping[str, str | None] = field(default_factory=dict, repr=False)
    goal: "Goal | None" = None
    selection: Selection | None = None
    otherwise: "Callable[[Mapping[str, str]], list[Case | None]] | None" = field(default=None, repr=False)
    drawn: Drawn | None = None

    def cases(self) -> list[Case]:
        """The swept cases, in order: the last entry of `sweep` changes fastest."""
        return [case for case, _ in self.swept_cases]

    def jobs(self) -> list[Job]:
        """Every job once: the cases, the healthy baselines they are compared with, then what is varied of them."""
        audited = () if self.selection is None else self.selection.audits
        again = [job for one in audited for job in (one.job, one.healthy) if job is not None]
        return _each_once([*self._planned, *(one.job for one in self.variations()), *again])

    def planned(self) -> list[Job]:
        """The cases, then the healthy baselines they are compared with."""
        return list(self._planned)

    @cached_property
    def design(self) -> Design | None:
        """The design that the study sweeps, with the ids of its rows; None of a study without."""
        found = self.drawn
        if found is None:
            return None
        ids = tuple(case_id(self.swept_cases[number][0]) for number in found.cases)
        return Design(found.kind, found.n, found.seed, found.paths, found.ranges, ids)

    @cached_property
    def _planned(self) -> tuple[Job, ...]:
        jobs: list[Job] = []
        twins: dict[str, Job] = {}  # each once: many cases share one
        for case, swept in self.swept_cases:
            twin = _baseline(case, swept)
            jobs.append(Job(case, swept, twin and twins.setdefault(identity(twin.case), twin)))
        return tuple(_each_once([*jobs, *twins.values()]))

    @cached_property
    def assumptions(self) -> tuple[str, ...]:
        """What is assumed because the study says nothing of it, and what it takes out of its range, in words."""
        from bearingsim.study.ranges import beyond, unheld  # imports the core, which takes a second

        drawn = [name for figure in self.figures for name in figure.y]
        rigid = assumes_rigid_ring(self.cases(), drawn, self.uncertainty)
        cases = self.cases()
        named = unheld(cases) if self.goal is None else ()
        return (RIGID,) * rigid + self._of_slip() + (*named, *beyond(cases, drawn))

    def _of_slip(self) -> tuple[str, ...]:
        """Return what a study that names an accuracy assumes of friction and oil, in words."""
        if self.goal is None or any(case.drag is not None for case in self.cases()):
            return ()
        tried = self.selection is not None and any(one.friction for one in self.selection.jobs.values())
        rubs = tried or any(speaks_of_slip(case) or leaves_friction_open(case) for case in self.cases())
        return (NO_OIL,) if rubs else (NO_SLIP,)

    def variations(self) -> list[Variation]:
        """What is varied of the cases: of all by `uncertainty`; of a few if the study does not speak of it.

        Of a design nothing unasked: a larger one computes its new points only.
        """
        return self._variations

    @cached_property
    def _variations(self) -> list[Variation]:
        if self.uncertainty is not None or self.drawn is not None:  # what a design is to vary is in it
            cases, uncertain = self.cases(), self.uncertainty or ()
        else:
            cases, uncertain = sampled(self.cases(), len(self.planned())), (USUAL,)
        return [
            Variation(case, what, value, Job(varied, is_variation=True))
            for case in cases
            for what, value, varied in variations(case, uncertain)
        ]


def _each_once(jobs: Iterable[Job]) -> list[Job]:
    """The jobs, each once, in order."""
    found: dict[str, Job] = {}
    for job in jobs:
        found.setdefault(identity(job.case), job)
    return list(found.values())


def case_id(case: Case) -> str:
    """16 hex digits that name a result: equal for equal physics, however it was written.

    `auto` counts as the methods that it tries, in their order: a price that changes them gives other numbers, and
    so another id.
    """
    if case.method != AUTO:
        return identity(case)
    from bearingsim.simulation.choice import tried

    return identity(case, {"method": tried(case)})


def identity(case: Case, found: Mapping[str, Any] | None = None) -> str:
    """16 hex digits, equal for cases that ask for the same, whatever that may come to.

    Covers all that shapes the numbers (12 significant digits), what was found for it besides, and the model's
    version; not the names and sources of bearing, rig and material, nor what the case does not use.
    """
    from bearingsim.core import MODEL_VERSION

    besides = ((name, tuple(value) if isinstance(value, list) else value) for name, value in (found or {}).items())
    return _digest(case, tuple(besides), MODEL_VERSION)


@lru_cache(maxsize=1 << 18)
def _digest(case: Case, found: tuple[tuple[str, Any], ...], version: int) -> str:
    besides = {"model_version": version} | extensions(case) | dict(found)
    texts = used(case) | {name: json_text(value) for name, value in besides.items()}
    whole = ",".join(f'"{name}":{texts[name]}' for name in sorted(texts))
    return hashlib.sha256(f"{{{whole}}}".encode()).hexdigest()[:16]


def _baseline(case: Case, swept: dict[str, float | str]) -> Job | None:
    """The job of the healthy twin of a case, if it has one."""
    healthy = healthy_twin(case)
    if healthy is None:
        return None
    dropped = _of_defects(case)
    kept = {path: value for path, value in swept.items() if path.split(".")[0] not in dropped}
    return Job(healthy, kept, is_baseline=True)


def healthy_twin(case: Case) -> Case | None:
    """The same bearing without its defects; none for a model that knows pits as impulses only."""
    if not case.defects or not MODELS[case.model].takes_pits:
        return None
    plain: dict[str, Any] = {
        name: Case.model_fields[name].default for name in _of_defects(case) & Case.model_fields.keys()
    }
    plain["record"] = tuple(name for name in case.record if slice_number(name) is None)  # it is cut otherwise
    return case.model_copy(update=plain)


def _of_defects(case: Case) -> set[str]:
    """The keys that a healthy twin has not."""
    return {"defect", "defects", "excitation"} | ({"seed"} if not MODELS[case.model].slips else set())
