"""One case: everything that one simulation needs to be told."""

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from bearingsim.config.fields import (
    Angle,
    Clearance,
    Delay,
    Duration,
    Force,
    Frequency,
    InverseVelocity,
    Length,
    Number,
    Rotation,
    Section,
    Step,
    Switch,
    one_of,
    raise_unknown_word,
    refuse,
    whole,
)
from bearingsim.config.machine import Bearing, Rig, default_rig, named
from bearingsim.config.names import CHANNELS
from bearingsim.units import show

Shape = Literal["rectangular", "triangular", "circular"]
StiffnessLaw = Literal["palmgren", "iso16281"]
Model = Literal["static", "ring", "rollers"]
Method = Literal["verlet", "rk4"]


class Defect(Section):
    """A pit in a race: lengths in m (`length` along the axis, `width` along rolling), angle in rad."""

    race: Annotated[Literal["outer", "inner", "roller"], one_of("outer", "inner", "roller")] = "outer"
    roller: int = 1
    shape: Annotated[Shape, one_of(*get_args(Shape))]
    length: Length
    width: Length
    depth: Length
    angle: Angle = 0.0


class HuntCrossley(Section):
    """Damping force `chi` (s/m) times the approach rate times the elastic force."""

    law: Literal["hunt-crossley"] = "hunt-crossley"
    chi: InverseVelocity = 50.0


class Kraemer(Section):
    """Damping proportional to the tangent stiffness, by the time `beta` (s)."""

    law: Literal["kraemer"] = "kraemer"
    beta: Delay = 1e-5


class General(Section):
    """c |v|^m2 delta^m3 with the coefficient in N, mm and s, as multibody tools print it."""

    law: Literal["general"] = "general"
    coefficient: Number
    velocity_exponent: Number = 1.0
    indentation_exponent: Number


DAMPING_LAWS: dict[str, type[Section]] = {
    "hunt-crossley": HuntCrossley,
    "kraemer": Kraemer,
    "general": General,
}


def _law(given: Any) -> Any:
    """The tag of a damping; a mapping without `law` is the default law's."""
    return given.get("law", "hunt-crossley") if isinstance(given, dict) else getattr(given, "law", None)


def _damping(given: Any) -> Any:
    """A bare word is a law with its default numbers."""
    found = {"law": given} if isinstance(given, str) else given
    if _law(found) not in DAMPING_LAWS:
        raise_unknown_word(_law(found), tuple(DAMPING_LAWS))
    return found


Damping = Annotated[
    Annotated[HuntCrossley, Tag("hunt-crossley")]
    | Annotated[Kraemer, Tag("kraemer")]
    | Annotated[General, Tag("general")],
    Discriminator(_law),
    BeforeValidator(_damping),
]


class Contact(Section):
    """How rollers and races press on each other."""

    stiffness: Annotated[StiffnessLaw, one_of(*get_args(StiffnessLaw))] = "palmgren"
    damping: Damping = HuntCrossley()
    length_nodes: Annotated[int, whole(1, 64)] = 24


def _one_or_many(given: Any) -> Any:
    if isinstance(given, str):
        refuse("list", f"expected a list of mappings, got `{given}`")
    return given


class Case(Section):
    """One simulation, in SI: speed in rad/s, load in N, lengths in m, angles in rad, times in s.

    `defect` (one mapping) may be given instead of `defects`. `start_angle` is the first roller's angle at
    t = 0 (pi / rollers if not given); `method` is None for the static model, which needs none.
    """

    bearing: Annotated[Bearing, named("bearings")]
    rig: Annotated[Rig, named("rigs")] = Field(default_factory=default_rig)
    speed: Rotation
    load: Force
    clearance: Clearance = 0.0
    defects: Annotated[tuple[Defect, ...], BeforeValidator(_one_or_many)] = ()
    contact: Contact = Contact()
    model: Annotated[Model, one_of(*get_args(Model))] = "rollers"
    method: Annotated[Method, one_of(*get_args(Method))] | None = None
    step: Step = "auto"
    duration: Duration = 1.0
    settle: Delay = 0.05
    start_angle: Angle = 0.0
    sampling: Frequency = 10240.0
    antialias: Switch = True
    record: tuple[Annotated[str, one_of(*CHANNELS)], ...] = ("ring.velocity",)

    @model_validator(mode="before")
    @classmethod
    def _single_defect(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "defect" not in data:
            return data
        if "defects" in data:
            refuse("defects", "say `defect` (one mapping) or `defects` (a list), not both", at="defect")
        return {key: value for key, value in data.items() if key != "defect"} | {"defects": [data["defect"]]}

    @model_validator(mode="after")
    def _resolved(self) -> "Case":
        if self.method is None and self.model != "static":
            object.__setattr__(self, "method", "verlet")
        if "start_angle" not in self.model_fields_set:
            object.__setattr__(self, "start_angle", math.pi / self.bearing.rollers)
        return self

    @model_validator(mode="after")
    def _consistent(self) -> "Case":
        found = list(conflicts(self))
        if found:
            message = "; ".join(conflict.message for conflict in found)
            refuse("conflict", message, conflicts=found)
        return self


Path = tuple[str | int, ...]
"""Where a value stands in a case: `("defects", 0, "length")`."""


class Conflict(NamedTuple):
    """Values that are right alone but not together: a kind, the paths concerned, and why."""

    kind: str
    paths: tuple[Path, ...]
    message: str
    hint: str | None = None


def conflicts(case: Case) -> Iterator[Conflict]:
    """Everything in a case that does not fit together."""
    for number, defect in enumerate(case.defects):
        yield from _defect_conflicts(number, defect, case.bearing)
    for first, second in combinations(range(len(case.defects)), 2):
        yield from _overlap(first, second, case)
    if case.model == "static" and case.method is not None:
        paths = (("method",), ("model",))
        yield Conflict("method", paths, f"the static model has no method, got `{case.method}`", "leave it out")
    if not -0.01 <= case.clearance / case.bearing.roller_diameter <= 0.05:
        shown = show(case.clearance, "um")
        message = f"a clearance of {shown} is beyond -1 % to 5 % of the roller diameter"
        yield Conflict("clearance", (("clearance",), ("bearing",)), message, "is the unit right?")
    ball_pass = 1.0 / case.bearing.ball_pass_frequency(case.speed)
    if case.duration < ball_pass:
        shown, needed = show(case.duration, "ms"), show(ball_pass, "ms")
        timing: tuple[Path, ...] = (("duration",), ("speed",), ("bearing",))
        yield Conflict("duration", timing, f"{shown} is shorter than one ball pass ({needed})")


def _defect_conflicts(number: int, defect: Defect, bearing: Bearing) -> Iterator[Conflict]:
    at = ("defects", number)
    if defect.length > bearing.roller_length:
        length, roller = show(defect.length, "mm"), show(bearing.roller_length, "mm")
        paths: tuple[Path, ...] = ((*at, "length"), ("bearing", "roller_length"))
        yield Conflict("long", paths, f"a defect of {length} is longer than the roller ({roller})")
    if defect.width > bearing.roller_spacing:
        width, spacing = show(defect.width, "mm"), show(bearing.roller_spacing, "mm")
        paths = ((*at, "width"), ("bearing",))
        yield Conflict("wide", paths, f"a defect of {width} is wider than the roller spacing ({spacing})")

    wall = (bearing.outside_diameter - bearing.pitch_diameter - bearing.roller_diameter) / 2.0
    if defect.depth >= wall:
        depth, thick = show(defect.depth, "mm"), show(wall, "mm")
        paths = ((*at, "depth"), ("bearing", "outside_diameter"))
        yield Conflict("deep", paths, f"a defect {depth} deep goes through the outer ring ({thick})")


def _overlap(first: int, second: int, case: Case) -> Iterator[Conflict]:
    a, b = case.defects[first], case.defects[second]
    radius = (case.bearing.pitch_diameter + case.bearing.roller_diameter) / 2.0
    distance = abs(math.remainder(a.angle - b.angle, 2.0 * math.pi)) * radius
    if a.race == b.race and distance < (a.width + b.width) / 2.0:
        paths = tuple(("defects", i, key) for i in (second, first) for key in ("angle", "width"))
        message = f"overlaps defect {first + 1}: their centres are {show(distance, 'mm')} apart"
        yield Conflict("overlap", paths, message, "move one, or make one wider defect of them")
