"""Runs of each scene and model: automatic choice, methods at some settings, reference runs, peers."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from bearingsim.bench import external
from bearingsim.bench.provenance import code_version, processor
from bearingsim.bench.scene import ORDER, Scene, Variant
from bearingsim.catalogue import AUTO, DEFAULT_MODEL, METHODS, MODELS
from bearingsim.config import Case
from bearingsim.study.jobs import identity

JOB, AUTOMATIC, POINT, PEER, REFERENCE = "job", "automatic", "point", "peer", "reference"
"""Role of a row: automatic choice; its method and step, fully integrated; another method or setting; solver of
another package; reference run for the errors."""


class Setting(NamedTuple):
    """Step relative to the automatic one, or tolerance; neither for the automatic choice."""

    step: float = float("nan")
    tolerance: float = float("nan")


Settings = Mapping[str, tuple[Setting, ...]]
"""Settings by method."""


class Plan(NamedTuple):
    """Methods, reference runs and peers for one kind of model."""

    methods: Settings
    references: Settings
    peers: Settings


@dataclass(frozen=True)
class Run:
    """Timed run. case: None if the model cannot compute the scene; refusal: the reason."""

    scene: str
    variant: str
    model: str
    role: str
    method: str
    setting: Setting
    line: str
    case: Case | None
    refusal: str = ""

    @property
    def key(self) -> str:
        """Hash of 16 hex digits of run, code and machine."""
        problem = identity(self.case) if self.case is not None else self.refusal
        parts = (self.scene, self.variant, problem, self.role, self.method, *map(repr, self.setting))
        return hashlib.sha256("|".join((*parts, code_version(), processor())).encode()).hexdigest()[:16]


@cache
def _read_plan() -> dict[str, Any]:
    return dict(yaml.safe_load((Path(__file__).parent / "plan.yaml").read_text(encoding="utf-8")))


def default_scenes(quick: bool) -> tuple[str, ...]:
    """Return the scenes computed by default."""
    return tuple(_read_plan()["quick"]["scenes"]) if quick else ORDER


def make_plan(case: Case, quick: bool) -> Plan:
    """Select the plan of runs for a case: by the flexibility of its ring and the slices of its model."""
    kind = "quick" if quick else "usual"
    if MODELS[case.model].sliced:
        kind = "sliced"
    elif case.rig.ring is not None:
        kind = "bent"
    entries = _read_plan()[kind]
    return Plan(*(_settings(entries.get(field, {})) for field in Plan._fields))


def _settings(entries: Mapping[str, Mapping[str, Sequence[float]]]) -> Settings:
    return {
        name: tuple(
            [Setting(step=float(step)) for step in values.get("steps", ())]
            + [Setting(tolerance=float(tolerance)) for tolerance in values.get("tolerances", ())]
        )
        for name, values in entries.items()
    }


def plan_runs(scene: Scene, quick: bool, peers: Settings | None = None) -> Iterator[Run]:
    """Yield all runs of a scene. peers: solvers of other packages at their settings, in addition to the plan's."""
    for variant in scene.variants:
        yield from _variant_runs(scene, variant, quick, peers or {})


def _variant_runs(scene: Scene, variant: Variant, quick: bool, peers: Settings) -> Iterator[Run]:
    def run(role: str, method: str, setting: Setting) -> Run:
        names = scene.name, variant.name, variant.model
        return Run(*names, role, method, setting, scene.line, variant.case, variant.refusal)

    yield run(JOB, AUTO, Setting())
    if variant.case is None:
        return
    if variant.case.method is None:
        yield run(REFERENCE, "", Setting(step=0.25))  # four times as many instants
        return
    plan = make_plan(variant.case, quick)
    for role, settings in ((POINT, plan.methods), (REFERENCE, _solvable_settings(variant, plan.references))):
        for method, values in settings.items():
            yield from (run(role, method, setting) for setting in values)
    for method, values in _solvable_settings(variant, {**plan.peers, **peers}).items():
        yield from (run(PEER, method, setting) for setting in values)


def _solvable_settings(variant: Variant, settings: Settings) -> Settings:
    """Drop methods of other packages, unless the model is the default one and they can integrate the case."""
    if variant.model == DEFAULT_MODEL and variant.case is not None and external.can_solve(variant.case):
        return settings
    return {name: values for name, values in settings.items() if name in METHODS}


def group_by_model(missing: Sequence[Run]) -> list[list[Run]]:
    """Group runs by model for compilation, with one run for each code that must be compiled."""
    groups: dict[str, dict[tuple, Run]] = {}
    for run in missing:
        if run.case is not None:
            groups.setdefault(run.model, {}).setdefault((run.scene, run.variant, run.role, run.method), run)
    return [list(group.values()) for group in groups.values()]
