"""What a study expands to: cases, their ids, and the jobs that a runner works through."""

import hashlib
import json
from dataclasses import dataclass, field
from typing import Any

from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.channels import slice_number
from bearingsim.study.used import used


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
    """One simulation of a study: its id, its swept values (SI, or words), and its healthy baseline's id.

    `healthy` is None for a bearing without defects, which is its own baseline; `is_baseline` tells a
    job that is there only to be compared with.
    """

    id: str
    case: Case
    swept: dict[str, float | str]
    healthy: str | None
    is_baseline: bool = False


@dataclass(frozen=True)
class Study:
    """A study file, read and checked: `text` as written, `units` of the swept paths as written there.

    notes: what the user is to be told of the file, though it is read.
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

    def cases(self) -> list[Case]:
        """The swept cases, in order: the last entry of `sweep` changes fastest."""
        return [case for case, _ in self.swept_cases]

    def jobs(self) -> list[Job]:
        """Every job once: the cases first, then the healthy baselines they are compared with."""
        jobs: dict[str, Job] = {}
        twins: dict[str, Job] = {}
        for case, swept in self.swept_cases:
            twin = _baseline(case, swept)
            job_id = case_id(case)
            jobs.setdefault(job_id, Job(job_id, case, swept, twin.id if twin else None))
            if twin:
                twins.setdefault(twin.id, twin)
        return list((jobs | {key: twin for key, twin in twins.items() if key not in jobs}).values())


def case_id(case: Case) -> str:
    """16 hex digits that name a result: equal for equal physics, however it was written.

    Covers all that shapes the numbers (12 significant digits) and the model's version; not the names and
    sources of bearing, rig and material, nor what the case does not use.
    """
    from bearingsim.core import MODEL_VERSION

    values = used(case) | {"record": sorted(set(case.record)), "model_version": MODEL_VERSION}
    text = json.dumps(_canonical(values), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _canonical(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.12g}") + 0.0  # no negative zero
    if isinstance(value, dict):
        return {key: _canonical(inner) for key, inner in value.items() if key not in ("name", "source")}
    if isinstance(value, list | tuple):
        return [_canonical(inner) for inner in value]
    return value


def _baseline(case: Case, swept: dict[str, float | str]) -> Job | None:
    """The same bearing without its defects; none for a model that knows pits as impulses only."""
    if not case.defects or not MODELS[case.model].takes_pits:
        return None
    dropped = {"defect", "defects", "excitation"} | ({"seed"} if not MODELS[case.model].slips else set())
    plain: dict[str, Any] = {name: Case.model_fields[name].default for name in dropped & Case.model_fields.keys()}
    plain["record"] = tuple(name for name in case.record if slice_number(name) is None)  # it is cut otherwise
    healthy = case.model_copy(update=plain)
    kept = {path: value for path, value in swept.items() if path.split(".")[0] not in dropped}
    return Job(case_id(healthy), healthy, kept, None, is_baseline=True)
