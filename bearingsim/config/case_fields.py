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
from bearingsim.config.sections.machine import Bearing, Rig, default_rig, library_section
from bearingsim.config.sections.space import Misalignment
from bearingsim.config.sections.surfaces import Surfaces
from bearingsim.config.vocabulary import explanation

if TYPE_CHECKING:
    ModelName = str
    MethodName = str
else:
    ModelName = Literal[(catalogue.REFERENCE, *catalogue.MODELS)]
    MethodName = Literal[(catalogue.AUTO, *catalogue.METHODS)]


MAX_DEFECTS = 100
"""Largest number of defects of a case; checking 100 defects for overlaps takes half a second."""

MAX_BANDS = 100
"""Largest number of entries in `features`; each band feature needs a Fourier transform of the record."""

DEPRECATED_KEYS = {"prove": "step_check"}
"""Deprecated keys of a case, which are still accepted, and the keys that replace them."""


def _check_list(raw: Any) -> Any:
    if isinstance(raw, str):
        refuse("list", f"expected a list of mappings, got `{raw}`")
    return raw


def _check_speed(raw: Any) -> Any:
    if isinstance(raw, dict):
        refuse("quantity", "expected one speed such as `1800 rpm`, got a mapping", explanation("outer_speed"))
    return raw


class CaseFields(Section):
    """One simulation, in SI: speed in rad/s, loads in N, lengths in m, angles in rad, times in s.

    Values that depend on others are filled in: `clearance` by class becomes a length; `model` is never
    `reference`; `method` is None for models without one; `contact.stiffness` is the law for rollers or for balls.
    `friction` and `cage` are None for models without slip, and set for all others. `drag`, `ramp`, `shaft`,
    `unbalance`, `misalignment` and `surfaces` are None if absent. A line load in `record` becomes one channel per
    slice of the roller.
    """

    bearing: Annotated[Bearing, library_section("bearings")]
    """Bearing: a name from the catalogue, a file, or a mapping."""
    rig: Annotated[Rig, library_section("rigs")] = Field(default_factory=default_rig)
    """Support of the outer ring and sensor: a name in configs/rigs, a file, or a mapping. Default: `bvt5`."""
    speed: Annotated[Rotation, BeforeValidator(_check_speed)]
    """Rotational speed of the inner ring."""
    ramp: Annotated[free.Ramp | None, OPTIONAL] = None
    """Linear change of the speed, from `speed`. Default: constant speed."""
    load: Force
    """Radial load on the outer ring, along the load line."""
    load_across: SignedForce = 0.0
    """Second radial load, perpendicular to `load`; positive values shift the load zone towards 90 deg."""
    gravity: Switch = False
    """Weight of rollers and cage: `true` includes it."""
    clearance: Clearance = 0.0
    """Operating radial internal clearance (diametral): a length (negative: preload), or a class of ISO 5753-1."""
    defects: Annotated[tuple[Defect, ...], Field(max_length=MAX_DEFECTS), BeforeValidator(_check_list)] = ()
    """Defects of the bearing. A single one may be given as `defect`. Default: none (healthy bearing)."""
    surfaces: Annotated[Surfaces | None, OPTIONAL] = None
    """Surface form: waviness of races and rollers, unequal roller diameters. Default: smooth races, equal rollers.
    """
    excitation: Annotated[Excitation, one_of(*get_args(Excitation))] = "envelope"
    """Effect of a defect on the contact. `envelope`: geometric path of the roller's centre; the others: pulses and
    stiffness changes from the literature. Default of the model `impulse`: `impulse-train`.
    """
    contact: Contact = Contact()
    """Stiffness and damping of the contacts between rolling elements and races."""
    friction: free.Friction | None = None
    """Friction between rollers and races: a law, or a mapping with its parameters."""
    cage: free.Cage | None = None
    """Mass, clearances, contacts and guidance of the cage."""
    drag: Annotated[free.Drag | None, OPTIONAL] = None
    """Drag of the oil on rollers and cage. Default: none."""
    shaft: Annotated[free.Shaft | None, OPTIONAL] = None
    """Elastic support and mass of a moving inner ring. Default: the inner ring's centre is fixed."""
    unbalance: Annotated[free.Unbalance | None, OPTIONAL] = None
    """Unbalance of the shaft. Default: none."""
    misalignment: Annotated[Misalignment | None, OPTIONAL] = None
    """Tilt of the rings' axes. Default: none."""
    model: Annotated[ModelName, one_of(catalogue.REFERENCE, *catalogue.MODELS)] = catalogue.DEFAULT_MODEL
    """Dynamic model, in order of detail; `reference`: the most detailed that the case needs. `accuracy`
    chooses the model.
    """
    method: Annotated[MethodName, one_of(catalogue.AUTO, *catalogue.METHODS)] | None = None
    """Integrator. `auto`: the cheapest that stiffness and damping of the case allow."""
    step: Step = "auto"
    """Time step of methods with a fixed step. `auto`: shortened until the step check passes."""
    tolerance: Tolerance = "auto"
    """Relative tolerance of adaptive methods. `auto`: reduced until the step check passes."""
    step_check: StepCheckMode = True
    """Comparison of the step with one 2.24 times shorter: at the start of the run (`true`), over the whole run
    (`strict`), or not at all (`false`).
    """
    periodic: Switch = True
    """Period search: a periodic response is computed until it repeats, then filled in; `false` integrates the
    whole record.
    """
    until: Accuracy | None = None
    """End of the record once the relative standard errors of amplitudes at defect frequencies, RMS and `features`
    are below this value, at the latest after `duration`.
    """
    duration: Duration = 1.0
    """Length of the record, after settling."""
    settle: Settling = "auto"
    """Time simulated before the record. `auto`: until transients have decayed."""
    start_angle: Angle = 0.0
    """Angle of the first roller at t = 0, from the load line. Default: half the angle between two rollers."""
    seed: Annotated[int, integer(0, 999_999_999)] = 0
    """Seed of random initial values and random impulses."""
    sampling: Frequency = 10240.0
    """Sampling rate of the stored signals; they contain frequencies up to 0.4 of it."""
    antialias: Switch = True
    """Low-pass filter of signals before sampling."""
    record: tuple[Annotated[str, FileFormat(validate_channel, channel_schema)], ...] = ("ring.velocity",)
    """Channels whose time signals are stored; an empty list stores features only."""
    features: Annotated[
        tuple[Annotated[str, FileFormat(validate_feature, feature_schema)], ...], Field(max_length=MAX_BANDS)
    ] = ()
    """Additional features of frequency bands, and means that `until` monitors."""

    @property
    def checks_step(self) -> bool:
        """True if the run checks its step: the model has a method, and `step_check` is not false."""
        return bool(self.step_check) and self.method is not None

    @property
    def automatic(self) -> bool:
        """True if the program chooses the step of the method."""
        return self.method is not None and self.step == "auto"

    @property
    def settle_s(self) -> float:
        """Settling time, s; `auto` must have been resolved (``simulation/settling.py``)."""
        assert not isinstance(self.settle, str)
        return self.settle
