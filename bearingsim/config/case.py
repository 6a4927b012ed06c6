"""One case: everything that one simulation needs to be told."""

import math
from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field, model_validator

from bearingsim.config.channels import channel
from bearingsim.config.fields import (
    Angle,
    Delay,
    Duration,
    Force,
    Frequency,
    Laws,
    Proving,
    Rotation,
    Section,
    SignedForce,
    Step,
    Switch,
    Tolerance,
    one_of,
    refuse,
    unless_none,
    whole,
)
from bearingsim.config.rules import hierarchy
from bearingsim.config.rules.conflicts import conflicts
from bearingsim.config.rules.slicing import by_slices
from bearingsim.config.sections import contact, free
from bearingsim.config.sections.clearance import Clearance
from bearingsim.config.sections.contact import Contact
from bearingsim.config.sections.defect import EDGE_RADIUS, Defect, Edge, Excitation
from bearingsim.config.sections.machine import Bearing, Rig, default_rig, named
from bearingsim.config.sections.space import Misalignment

Model = Literal["least", "impulse", "static", "ring", "rollers", "planar", "spatial"]
Method = Literal[
    "auto",
    "verlet",
    "dop853",
    "rodas",
    "backward-euler",
    "symplectic-euler",
    "rk4",
    "dormand-prince",
    "nystrom",
    "generalized-alpha",
    "velocity-implicit-euler",
    "stabilised",
]

LAWS: dict[tuple[str | int, ...], Laws] = {
    ("contact", "damping"): contact.DAMPING,
    ("contact", "stiffness"): contact.STIFFNESS,
    ("friction",): free.FRICTION,
}
"""The fields that hold one of several laws, by their path."""


def _one_or_many(given: Any) -> Any:
    if isinstance(given, str):
        refuse("list", f"expected a list of mappings, got `{given}`")
    return given


class Case(Section):
    """One simulation, in SI: speed in rad/s, loads in N, lengths in m, angles in rad, times in s.

    `defect` (one mapping) may be given instead of `defects`. What depends on other values is filled in, so that a
    case says what is computed: `clearance` by class is a length; `model` is never `least`; `method` is None for
    models without one; `start_angle` is the first roller's angle at t = 0, pi / rollers if not given; `excitation`
    is `impulse-train` for the impulse model if not given; `contact.stiffness` suits the bearing. `friction` and
    `cage` are None below the planar model, and never None from it on. `drag`, `ramp`, `shaft`, `unbalance` and
    `misalignment` are None where absent. A line load in `record` is one channel for each slice of the roller. With
    `prove` the step, automatic or given, is tried on the run's beginning before it is trusted; `strict` tries all
    of the run, and refuses a chaotic record that is too short for its RMS.
    """

    bearing: Annotated[Bearing, named("bearings")]
    rig: Annotated[Rig, named("rigs")] = Field(default_factory=default_rig)
    speed: Rotation
    ramp: Annotated[free.Ramp | None, BeforeValidator(unless_none)] = None
    load: Force
    load_across: SignedForce = 0.0
    gravity: Switch = False
    clearance: Clearance = 0.0
    defects: Annotated[tuple[Defect, ...], BeforeValidator(_one_or_many)] = ()
    excitation: Annotated[Excitation, one_of(*get_args(Excitation))] = "envelope"
    contact: Contact = Contact()
    friction: free.Friction | None = None
    cage: free.Cage | None = None
    drag: Annotated[free.Drag | None, BeforeValidator(unless_none)] = None
    shaft: Annotated[free.Shaft | None, BeforeValidator(unless_none)] = None
    unbalance: Annotated[free.Unbalance | None, BeforeValidator(unless_none)] = None
    misalignment: Annotated[Misalignment | None, BeforeValidator(unless_none)] = None
    model: Annotated[Model, one_of(*get_args(Model))] = "rollers"
    method: Annotated[Method, one_of(*get_args(Method))] | None = None
    step: Step = "auto"
    tolerance: Tolerance = "auto"
    prove: Proving = True
    duration: Duration = 1.0
    settle: Delay = 0.05
    start_angle: Angle = 0.0
    seed: Annotated[int, whole(0, 999_999_999)] = 0
    sampling: Frequency = 10240.0
    antialias: Switch = True
    record: tuple[Annotated[str, BeforeValidator(channel)], ...] = ("ring.velocity",)

    @property
    def proven(self) -> bool:
        """Whether the step is to be proven: there is one, and the case does not forbid it."""
        return bool(self.prove) and self.method is not None

    @property
    def automatic(self) -> bool:
        """Whether there is a step, and it is left to be chosen."""
        return self.method is not None and self.step == "auto"

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
        if self.model == "least":
            self._fill("model", hierarchy.least(self) or hierarchy.LADDER[-1])
        if self.model == "impulse" and "excitation" not in self.model_fields_set:
            self._fill("excitation", "impulse-train")
        if self.method is None and self.model not in hierarchy.METHODLESS:
            self._fill("method", "auto")
        if "start_angle" not in self.model_fields_set:
            self._fill("start_angle", math.pi / self.bearing.rollers)
        self._fill("contact", self._suited_contact())
        self._fill("defects", tuple(self._completed(_numbered(defect)) for defect in self.defects))
        if self.misalignment is not None and self.misalignment.inner == self.misalignment.outer == 0.0:
            self._fill("misalignment", None)
        self._fill_free_motion()
        self._fill("record", tuple(name for channel in self.record for name in by_slices(channel, self)))
        return self

    def _fill_free_motion(self) -> None:
        if self.model not in hierarchy.FREE:
            if isinstance(self.friction, free.Frictionless):
                self._fill("friction", None)
            return
        cage = self.cage or free.Cage()
        self._fill("cage", cage)
        if self.friction is None:
            self._fill("friction", free.Frictionless() if cage.motion == "kinematic" else free.StaticDynamic())

    def _completed(self, defect: Defect) -> Defect:
        """A defect with the edges that its excitation takes it to have."""
        if self.excitation != "elastic-edge" or defect.edge is not None:
            return defect
        return defect.model_copy(update={"edge": Edge(radius=EDGE_RADIUS)})

    def _suited_contact(self) -> Contact:
        if self.contact.stiffness is not None:
            return self.contact
        law = "palmgren" if self.bearing.element == "roller" else "point"
        return self.contact.model_copy(update={"stiffness": law})

    def _fill(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @model_validator(mode="after")
    def _consistent(self) -> "Case":
        found = list(conflicts(self))
        if found:
            message = "; ".join(conflict.message for conflict in found)
            refuse("conflict", message, conflicts=found)
        return self


def _numbered(defect: Defect) -> Defect:
    """A roller's defect with the number of its roller."""
    if defect.race != "roller" or defect.roller is not None:
        return defect
    return defect.model_copy(update={"roller": 1})
