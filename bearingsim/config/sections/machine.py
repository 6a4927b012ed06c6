"""Materials, bearings and rigs."""

import math
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, model_validator

from bearingsim.config.fields import (
    OPTIONAL,
    Angle,
    ContactAngle,
    Damping,
    FileFormat,
    Length,
    Mass,
    PoissonRatio,
    Pressure,
    Section,
    SolidDensity,
    Stiffness,
    StiffnessOrZero,
    Text,
    TorsionalDamping,
    TorsionalStiffness,
    integer,
    one_of,
    refuse,
)
from bearingsim.config.library import Kind, library_names, load_mapping
from bearingsim.config.sections.ring import FlexibleRing, RingLoad, Sensor
from bearingsim.config.sections.space import Flanges, Profile, RollerProfile
from bearingsim.core.geometry.kinematics import ball_pass_frequency_outer
from bearingsim.text.units import show

Element = Literal["roller", "ball"]

_GROOVES = ("inner_groove_radius", "outer_groove_radius")
_ELEMENT_FIELDS = {"roller_length": "roller"} | dict.fromkeys(_GROOVES, "ball")


def named(kind: Kind) -> FileFormat:
    """Return the annotation of a section that may be given by name or path."""
    return FileFormat(
        lambda source: load_mapping(kind, source),
        lambda own: {"anyOf": [{"type": ["string", "number"], "examples": library_names(kind)}, own]},
    )


class Material(Section):
    """Material of rolling elements and rings."""

    name: Text = ""
    density: SolidDensity
    young_modulus: Pressure = 207e9
    poisson_ratio: PoissonRatio = 0.3
    source: Text = ""


def _steel() -> Any:
    return Material.model_validate(load_mapping("materials", "steel"))


class Bearing(Section):
    """Radial bearing: nominal dimensions in m, without clearance.

    `rollers` and `roller_diameter` are number and diameter of the rolling elements, rollers or balls. Cylindrical
    rollers have a `roller_length`, ball bearings the radii of their grooves in the axial plane (m). `flanges` and
    `roller_profile` are used by the spatial model.
    """

    name: Text = ""
    element: Annotated[Element, one_of(*get_args(Element))] = "roller"
    rollers: Annotated[int, integer(3, 104)]
    roller_diameter: Length
    roller_length: Length | None = None
    inner_groove_radius: Length | None = None
    outer_groove_radius: Length | None = None
    pitch_diameter: Length
    bore: Length
    outside_diameter: Length
    width: Length
    roller_profile: RollerProfile = Profile()
    flanges: Flanges | None = None
    material: Annotated[Material, named("materials")] = Field(default_factory=_steel)
    source: Text = ""

    @property
    def roller_spacing(self) -> float:
        """Distance along the outer race between adjacent rollers, m."""
        return math.pi * (self.pitch_diameter + self.roller_diameter) / self.rollers

    @property
    def inner_spacing(self) -> float:
        """Distance along the inner race between adjacent rollers, m."""
        return math.pi * (self.pitch_diameter - self.roller_diameter) / self.rollers

    @property
    def ring_section(self) -> dict[str, float]:
        """Cross-section of the outer ring: `height`, from race to outside diameter, and `width`, m."""
        height = 0.5 * (self.outside_diameter - self.pitch_diameter - self.roller_diameter)
        return {"height": round(height, 12), "width": self.width}

    @property
    def element_mass(self) -> float:
        """Mass of one rolling element, a cylinder or sphere, kg."""
        cross_section = math.pi / 4.0 * self.roller_diameter**2
        length = 2.0 / 3.0 * self.roller_diameter if self.roller_length is None else self.roller_length
        return self.material.density * cross_section * length

    def ball_pass_frequency(self, speed: float) -> float:
        """Compute the ball pass frequency of the outer race (BPFO), Hz; `speed` in rad/s."""
        return ball_pass_frequency_outer(speed, self.roller_diameter, self.pitch_diameter, self.rollers)

    @model_validator(mode="after")
    def _has_its_elements(self) -> "Bearing":
        for name, element in _ELEMENT_FIELDS.items():
            if getattr(self, name) is not None and element != self.element:
                refuse("foreign", f"a {self.element} bearing has none", "leave it out", at=name)
            if getattr(self, name) is None and element == self.element:
                refuse("missing", f"a {self.element} bearing needs `{name}`, a length such as `12 mm`", at=name)
            if name in _GROOVES and element == self.element:
                self._check_groove(name)
        return self

    def _check_groove(self, name: str) -> None:
        ball = self.roller_diameter / 2.0
        if not ball < getattr(self, name) <= 2.0 * ball:
            radius, least, most = (show(value, "mm") for value in (getattr(self, name), ball, 2.0 * ball))
            refuse("groove", f"a groove of {radius} does not fit the ball (over {least}, at most {most})", at=name)

    @model_validator(mode="after")
    def _fits(self) -> "Bearing":
        pitch, roller = self.pitch_diameter, self.roller_diameter
        _check_circle(self)
        if pitch + roller >= self.outside_diameter:
            race = show(pitch + roller, "mm")
            refuse("outside", f"the outer race ({race}) is outside the outer ring", at="outside_diameter")
        if pitch - roller <= self.bore:
            race = show(pitch - roller, "mm")
            refuse("bore", f"the inner race ({race}) is inside the bore", at="bore")
        return self


class RollingParts(Section):
    """Parameters of a bearing that determine its characteristic frequencies; contact angle in rad."""

    name: Text = ""
    element: Annotated[Element, one_of(*get_args(Element))] = "roller"
    rollers: Annotated[int, integer(3, 104)]
    roller_diameter: Length
    pitch_diameter: Length
    contact_angle: ContactAngle = 0.0

    @model_validator(mode="after")
    def _fits(self) -> "RollingParts":
        _check_circle(self)
        return self


def _check_circle(bearing: Bearing | RollingParts) -> None:
    """Reject rolling elements that do not fit on the pitch circle."""
    pitch, roller = bearing.pitch_diameter, bearing.roller_diameter
    if roller >= pitch * math.sin(math.pi / bearing.rollers):
        most = int(math.pi / math.asin(min(roller / pitch, 1.0)))
        refuse("crowded", f"{bearing.rollers} rollers do not fit: at most {most}", at="rollers")


class Rig(Section):
    """Support of the outer ring by a bracket, and its sensor.

    Without `torsion_stiffness` (N m/rad) the ring cannot rotate; without `axial_stiffness` (N/m) and
    `tilting_stiffness` (N m/rad) it can neither move axially nor tilt. Without `ring` it is rigid; for a flexible
    `ring`, `load` is the load path, and is never None in a case. `sensor_angle` (rad) is a synonym of
    `sensor.angle`: a study defines one of them, a case has both.
    """

    name: Text = ""
    bracket_stiffness: StiffnessOrZero = 1e7
    bracket_damping: Damping = 200.0
    torsion_stiffness: TorsionalStiffness | None = None
    torsion_damping: TorsionalDamping | None = None
    axial_stiffness: Stiffness | None = None
    axial_damping: Damping | None = None
    tilting_stiffness: TorsionalStiffness | None = None
    tilting_damping: TorsionalDamping | None = None
    sensor_angle: Angle = 0.0
    sensor: Sensor = Sensor()
    ring: Annotated[FlexibleRing | None, OPTIONAL] = None
    load: Annotated[RingLoad | None, OPTIONAL] = None
    ring_mass: Mass | None = None
    source: Text = ""

    @model_validator(mode="after")
    def _whole(self) -> "Rig":
        """Unify the two angles of the sensor; remove ring and load if the ring does not bend."""
        angle = self.sensor_angle if self.sensor.angle is None else self.sensor.angle
        if "sensor_angle" in self.model_fields_set and angle != self.sensor_angle:
            refuse(
                "twice", "`sensor_angle` is another word for `sensor.angle`", "keep one of them", at="sensor_angle"
            )
        object.__setattr__(self, "sensor_angle", angle)
        object.__setattr__(self, "sensor", self.sensor.model_copy(update={"angle": angle}))
        if self.ring is not None and not self.ring.bends:
            object.__setattr__(self, "ring", None)
            object.__setattr__(self, "load", None)
        return self


def default_rig() -> Rig:
    """Return the default rig."""
    return Rig.model_validate(load_mapping("rigs", "bvt5"))
