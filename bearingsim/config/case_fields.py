"""Fields of a case: the parameters of one simulation."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field

from bearingsim import catalogue
from bearingsim.config.channels import channel_schema, feature_schema, validate_channel, validate_feature
from bearingsim.config.fields import (
    OPTIONAL,
    Accuracy,
    Angle,
    Duration,
    FileFormat,
    Force,
    Frequency,
    Rotation,
    Section,
    Settling,
    SignedForce,
    Step,
    StepCheckMode,
    Switch,
    Tolerance,
    integer,
    one_of,
    refuse,
)
from bearingsim.config.sections import free
from bearingsim.config.sections.clearance import Clearance
from bearingsim.config.sections.contact import Contact
from bearingsim.config.sections.defect import Defect, Excitation
from bearingsim.config.sections.machine import Bearing, Rig, default_rig, named
from bearingsim.config.sections.space import Misalignment
from bearingsim.config.vocabulary import sentence

if TYPE_CHECKING:
    ModelName = str
    MethodName = str
else:
    ModelName = Literal[(catalogue.REFERENCE, *catalogue.MODELS)]
    MethodName = Literal[(catalogue.AUTO, *catalogue.METHODS)]


MAX_DEFECTS = 100
"""Limit of the defects of a case: checking so many for overlaps takes half a second."""

MAX_BANDS = 100
"""Limit of the band features of a case: each needs a transform of the record."""

DEPRECATED_KEYS = {"prove": "step_check"}
"""Deprecated keys of a case, which are still accepted, and the keys that replace them."""


def _check_list(raw: Any) -> Any:
    if isinstance(raw, str):
        refuse("list", f"expected a list of mappings, got `{raw}`")
    return raw


def _check_speed(raw: Any) -> Any:
    if isinstance(raw, dict):
        refuse("quantity", "expected one speed such as `1800 rpm`, got a mapping", sentence("outer_speed"))
    return raw


class CaseFields(Section):
    """One simulation, in SI: speed in rad/s, loads in N, lengths in m, angles in rad, times in s.

    `defect` (one mapping) may be given instead of `defects`. Values that depend on others are filled in:
    `clearance` by class becomes a length; `model` is never `reference`; `method` is None for models without one;
    `start_angle` is the first roller's angle at t = 0, by default pi / rollers; `excitation` of the impulse model
    is `impulse-train` by default; `contact.stiffness` suits the bearing. `friction` and `cage` are None for models
    without slip, and set for all others. `drag`, `ramp`, `shaft`, `unbalance` and `misalignment` are None if
    absent. A line load in `record` becomes one channel per slice of the roller. `step_check` checks the step,
    automatic or given, at the start of the run; `strict` checks it on the whole run, and rejects a chaotic record
    that is too short for its RMS. `periodic` stops the integration once the motion repeats itself, and fills in
    the rest of the record; without it the whole record is integrated. `features` adds features of bands, or means
    that `until` monitors. With `until`, the record ends once the relative standard errors of the defects' lines,
    the RMS and `features` are below this value, at the latest after `duration`.
    """

    bearing: Annotated[Bearing, named("bearings")]
    rig: Annotated[Rig, named("rigs")] = Field(default_factory=default_rig)
    speed: Annotated[Rotation, BeforeValidator(_check_speed)]
    ramp: Annotated[free.Ramp | None, OPTIONAL] = None
    load: Force
    load_across: SignedForce = 0.0
    gravity: Switch = False
    clearance: Clearance = 0.0
    defects: Annotated[tuple[Defect, ...], Field(max_length=MAX_DEFECTS), BeforeValidator(_check_list)] = ()
    excitation: Annotated[Excitation, one_of(*get_args(Excitation))] = "envelope"
    contact: Contact = Contact()
    friction: free.Friction | None = None
    cage: free.Cage | None = None
    drag: Annotated[free.Drag | None, OPTIONAL] = None
    shaft: Annotated[free.Shaft | None, OPTIONAL] = None
    unbalance: Annotated[free.Unbalance | None, OPTIONAL] = None
    misalignment: Annotated[Misalignment | None, OPTIONAL] = None
    model: Annotated[ModelName, one_of(catalogue.REFERENCE, *catalogue.MODELS)] = catalogue.USUAL_MODEL
    method: Annotated[MethodName, one_of(catalogue.AUTO, *catalogue.METHODS)] | None = None
    step: Step = "auto"
    tolerance: Tolerance = "auto"
    step_check: StepCheckMode = True
    periodic: Switch = True
    until: Accuracy | None = None
    duration: Duration = 1.0
    settle: Settling = "auto"
    start_angle: Angle = 0.0
    seed: Annotated[int, integer(0, 999_999_999)] = 0
    sampling: Frequency = 10240.0
    antialias: Switch = True
    record: tuple[Annotated[str, FileFormat(validate_channel, channel_schema)], ...] = ("ring.velocity",)
    features: Annotated[
        tuple[Annotated[str, FileFormat(validate_feature, feature_schema)], ...], Field(max_length=MAX_BANDS)
    ] = ()

    @property
    def checks_step(self) -> bool:
        """True if the run checks its step: the model has a method, and `step_check` is not false."""
        return bool(self.step_check) and self.method is not None

    @property
    def automatic(self) -> bool:
        """True if the step is chosen by the program."""
        return self.method is not None and self.step == "auto"

    @property
    def settle_s(self) -> float:
        """Time to settle in, s; `auto` must have been resolved (``simulation/settling.py``)."""
        assert not isinstance(self.settle, str)
        return self.settle
