"""Schemas of the JSON files of a results folder, with the type of each entry.

Ids and the name of the study must match their patterns, because they are used as file names. Other strings may
contain anything: ``text/terminal.py`` removes control characters on printing.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import chain
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError

from bearingsim.designs import Kind, block_size
from bearingsim.figure_kinds import KINDS
from bearingsim.store.own_files import ID
from bearingsim.store.regular import Unreadable
from bearingsim.study.design import BLOCK_DESIGNS
from bearingsim.study.load import STUDY_NAME

__all__ = ["Choices", "Failure", "Trials", "check", "check_plan"]

Id = Annotated[str, StringConstraints(pattern=f"^{ID}$")]
Name = Annotated[str, StringConstraints(pattern=r"^[^\x00-\x1f\x7f-\x9f]{1,200}$")]
"""Name of a feature, or path of a parameter of a study."""
Count = Annotated[int, Field(ge=1)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
MAX_LOCATION_LENGTH = 100
"""Largest number of characters of the location of an entry in a message."""


def _kind_of_figure(name: str) -> str:
    if name not in KINDS:
        raise ValueError("unknown kind of figure")
    return name


class Layout(BaseModel):
    """Mapping with the entries of the subclass; further entries, of other versions, are ignored."""

    model_config = ConfigDict(strict=True, defer_build=True)


class View(Layout):
    start: float | None = None
    stop: float | None = None
    span: float | None = None
    around: str | None = None
    range: Pair | None = None
    band: Pair | None = None
    unit: str | None = None
    db: bool = False
    zero_mean: bool = False
    healthy: str | None = None
    orders: bool = False


class Figure(Layout):
    y: list[Name]
    x: Annotated[str, StringConstraints(pattern=r"^[^\x00-\x1f\x7f-\x9f]{0,200}$")]
    by: list[Name]
    panels: list[Name]
    where: dict[Name, str]
    title: str | None
    log: list[str]
    kind: Annotated[str, AfterValidator(_kind_of_figure)] = "sweep"
    view: View = View()


class Job(Layout):
    job: Id
    healthy: Id | None
    is_baseline: bool = Field(alias="twin")
    is_variation: bool = Field(alias="variation", default=False)
    swept: dict[Name, float | str]


class Design(Layout):
    kind: Kind
    n: Count
    seed: Annotated[int, Field(ge=0)]
    paths: list[Name]
    ranges: list[Pair]
    ids: list[Id]


class ModelChoice(Layout):
    model: str
    why: str
    error: dict[Name, float | None]
    nodes: dict[Name, float | None] = {}
    friction: dict[Name, float | None] = {}


class Curve(Layout):
    feature: Name
    jobs: list[Id]


class Audit(Layout):
    of: Id
    job: Id


class Accuracy(Layout):
    within: float
    of: list[Name]
    jobs: dict[Id, ModelChoice]
    curves: list[Curve]
    audits: list[Audit]
    notes: list[str] = []


class Variation(Layout):
    of: Id
    what: str
    value: float
    job: Id


class SignalFile(Layout):
    path: str
    channel: str
    unit: str
    request: dict[str, float | str | None] = {}


class MeasuredPoint(Layout):
    parameters: dict[Name, float | str]
    features: dict[Name, float]
    place: str
    signal: SignalFile | None = None


class MeasuredSet(Layout):
    label: str
    scale: bool
    points: list[MeasuredPoint]
    remarks: list[str] = []


class Plan(Layout):
    study: Annotated[str, StringConstraints(pattern=f"^{STUDY_NAME.pattern}$")]
    quick: bool
    units: dict[Name, str]
    figures: list[Figure]
    jobs: Annotated[list[Job], Field(min_length=1)]
    file: str | None = None
    text: str | None = None
    own_study_file: bool = False
    overrides: dict[str, str] = {}
    model_version: int = 0
    made_of: str = ""
    notes: list[str] = []
    design: Design | None = None
    assumptions: list[str] = []
    accuracy: Accuracy | None = None
    nothing_uncertain: bool = False
    variations: list[Variation] = []
    measured: list[MeasuredSet] = []


class Failure(Layout):
    reason: str = ""
    advice: str = ""
    time: float | None = None
    traceback: str = ""
    attempts: Count = 1
    command: str = ""
    when: str = ""


class Choice(Layout):
    candidate: str
    model: str
    why: str
    error: dict[Name, float]
    nodes: dict[Name, float | None] = {}
    friction: dict[Name, float | None] = {}
    inferred: bool = False
    values: dict[Name, float | None] = {}
    scales: dict[Name, float | None] = {}
    plan: str = ""


class Trial(Layout):
    passes: Count
    turns: Annotated[int, Field(ge=0)]
    repeats: bool
    lines: dict[Name, list[Pair]]
    powers: dict[Name, list[float]]
    forces: list[float]
    method: str = ""
    step: float = 0.0


Choices = dict[Name, Choice]
Trials = dict[Name, Trial | None]


@cache
def _adapter(layout: Any) -> TypeAdapter[Any]:
    return TypeAdapter(layout)


def check(layout: Any, value: Any) -> None:
    """Raise Unreadable if a value violates a layout, with the location of its first invalid entry."""
    try:
        _adapter(layout).validate_python(value)
    except ValidationError as error:
        entry = error.errors(include_url=False, include_context=False)[0]
        location = ".".join(map(str, entry["loc"])) or "its text"
        raise Unreadable(f"{location[:MAX_LOCATION_LENGTH]}: {entry['msg']}") from None


def check_plan(plan: Mapping[str, Any]) -> None:
    """Raise Unreadable for a plan with a wrong layout, duplicate or unknown job ids, or an inconsistent design."""
    check(Plan, plan)
    ids = {entry["job"] for entry in plan["jobs"]}
    if len(ids) < len(plan["jobs"]):
        raise Unreadable("jobs: an id occurs twice")
    unknown_id = next((job for job in _references(plan) if job not in ids), None)
    if unknown_id is not None:
        raise Unreadable(f"jobs: job {unknown_id} is missing, but other entries of the plan refer to it")
    design = plan.get("design")
    if design is not None:
        rows = block_size(design["kind"], len(design["paths"])) if design["kind"] in BLOCK_DESIGNS else 1
        if not design["paths"] or len(design["ranges"]) != len(design["paths"]) or len(design["ids"]) % rows:
            raise Unreadable("design: paths, ranges and jobs are inconsistent")


def _references(plan: Mapping[str, Any]) -> Iterator[str]:
    """Yield the job ids in a plan outside its list of jobs."""
    yield from (entry["healthy"] for entry in plan["jobs"] if entry["healthy"] is not None)
    yield from chain.from_iterable((variation["of"], variation["job"]) for variation in plan.get("variations", ()))
    yield from (plan.get("design") or {"ids": ()})["ids"]
    accuracy = plan.get("accuracy")
    if accuracy is not None:
        yield from accuracy["jobs"]
        yield from chain.from_iterable(curve["jobs"] for curve in accuracy["curves"])
        yield from chain.from_iterable((audit["of"], audit["job"]) for audit in accuracy["audits"])
