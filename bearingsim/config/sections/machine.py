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
from bearingsim.config.names import Line
from bearingsim.config.sections.ring import FlexibleRing, RingLoad, Sensor
from bearingsim.config.sections.space import Flanges, Profile, RollerProfile
from bearingsim.core.geometry.kinematics import (
    ball_pass_frequency_inner,
    ball_pass_frequency_outer,
    ball_spin_frequency,
    fundamental_train_frequency,
)
from bearingsim.text.units import show

Element = Literal["roller", "ball"]

MAX_LOGARITHMIC_LENGTH = 2.5
"""Largest ratio of a roller's length to its diameter for which ISO/TS 16281 defines the logarithmic profile by one
formula."""

_GROOVE_RADII = ("inner_groove_radius", "outer_groove_radius")
_ELEMENT_FIELDS = {"roller_length": "roller"} | dict.fromkeys(_GROOVE_RADII, "ball")
"""Rolling elements that each optional field belongs to."""


def library_section(kind: Kind) -> FileFormat:
    """Return the annotation of a section that may be given by the name or the path of a file."""
    return FileFormat(
        lambda source: load_mapping(kind, source),
        lambda schema: {"anyOf": [{"type": ["string", "number"], "examples": library_names(kind)}, schema]},
    )


class Material(Section):
    """Material of rolling elements and rings."""

    name: Text = ""
    """Name of the material; not used in computations."""
    density: SolidDensity
    """Density."""
    young_modulus: Pressure = 207e9
    """Young's modulus."""
    poisson_ratio: PoissonRatio = 0.3
    """Poisson's ratio."""
    source: Text = ""
    """Source of the data; not used in computations."""


def _steel() -> Any:
    return Material.model_validate(load_mapping("materials", "steel"))


class Bearing(Section):
    """Radial bearing: nominal dimensions in m, without clearance."""

    name: Text = ""
    """Designation of the bearing; not used in computations."""
    element: Annotated[Element, one_of(*get_args(Element))] = "roller"
    """Rolling elements: `roller` (cylindrical) or `ball`."""
    rollers: Annotated[int, integer(3, 104)]
    """Number of rolling elements."""
    roller_diameter: Length
    """Diameter of the rolling elements."""
    roller_length: Length | None = None
    """Length of the rollers; required for `roller`."""
    inner_groove_radius: Length | None = None
    """Radius of the inner groove in the axial plane; required for `ball`."""
    outer_groove_radius: Length | None = None
    """Radius of the outer groove in the axial plane; required for `ball`."""
    pitch_diameter: Length
    """Pitch diameter: diameter of the circle of the rolling elements' centres."""
    bore: Length
    """Bore of the inner ring."""
    outside_diameter: Length
    """Outside diameter of the outer ring."""
    width: Length
    """Width of the rings."""
    roller_profile: RollerProfile = Profile()
    """Profile of the rollers: `straight`, `crowned` or `logarithmic` (model `spatial`)."""
    flanges: Flanges | None = None
    """Flanges that guide the rollers axially (model `spatial`)."""
    material: Annotated[Material, library_section("materials")] = Field(default_factory=_steel)
    """Material of rings and rolling elements: a name, a file, or a mapping. Default: `steel`."""
    source: Text = ""
    """Source of the dimensions; not used in computations."""

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
    def element_length(self) -> float:
        """Axial length of a rolling element, m: that of a roller, the diameter of a ball."""
        return self.roller_diameter if self.roller_length is None else self.roller_length

    @property
    def land_width(self) -> float:
        """Width of the rings minus the length of the rolling elements, m: default width of the land of a cage."""
        return self.width - self.element_length

    @property
    def element_mass(self) -> float:
        """Mass of one rolling element, a cylinder or sphere, kg."""
        cross_section = math.pi / 4.0 * self.roller_diameter**2
        length = 2.0 / 3.0 * self.roller_diameter if self.roller_length is None else self.roller_length
        return self.material.density * cross_section * length

    def ball_pass_frequency(self, speed: float) -> float:
        """Compute the ball pass frequency of the outer race (BPFO), Hz; `speed` in rad/s."""
        return ball_pass_frequency_outer(speed, self.roller_diameter, self.pitch_diameter, self.rollers)

    def line_frequency(self, line: Line, speed: float) -> float:
        """Compute the frequency (Hz) of a spectral line without slip; `speed` in rad/s."""
        D_w, d_m = self.roller_diameter, self.pitch_diameter
        return line.frequency(
            ball_pass_frequency_outer(speed, D_w, d_m, self.rollers),
            ball_pass_frequency_inner(speed, D_w, d_m, self.rollers),
            ball_spin_frequency(speed, D_w, d_m),
            fundamental_train_frequency(speed, D_w, d_m),
            speed / (2.0 * math.pi),
        )

    @model_validator(mode="after")
    def _check_elements(self) -> "Bearing":
        for name, element in _ELEMENT_FIELDS.items():
            if getattr(self, name) is not None and element != self.element:
                refuse("foreign", f"a {self.element} bearing has no `{name}`", f"remove `{name}`", at=name)
            if getattr(self, name) is None and element == self.element:
                refuse("missing", f"a {self.element} bearing needs `{name}`, a length such as `12 mm`", at=name)
            if name in _GROOVE_RADII and element == self.element:
                self._check_groove(name)
        return self

    def _check_groove(self, name: str) -> None:
        ball_radius = self.roller_diameter / 2.0
        if not ball_radius < getattr(self, name) <= 2.0 * ball_radius:
            radii = getattr(self, name), ball_radius, 2.0 * ball_radius
            radius, low, high = (show(value, "mm") for value in radii)
            refuse("groove", f"a groove of {radius} does not fit the ball (over {low}, at most {high})", at=name)

    @model_validator(mode="after")
    def _check_fit(self) -> "Bearing":
        d_m, D_w = self.pitch_diameter, self.roller_diameter
        _check_circle(self)
        if d_m + D_w >= self.outside_diameter:
            race_diameter = show(d_m + D_w, "mm")
            refuse("outside", f"the outer race ({race_diameter}) is outside the outer ring", at="outside_diameter")
        if d_m - D_w <= self.bore:
            race_diameter = show(d_m - D_w, "mm")
            refuse("bore", f"the inner race ({race_diameter}) is inside the bore", at="bore")
        if self.element_length > self.width:
            size, width = show(self.element_length, "mm"), show(self.width, "mm")
            refuse("width", f"a {self.element} of {size} is longer than the rings are wide ({width})", at="width")
        return self

    @model_validator(mode="after")
    def _check_profile(self) -> "Bearing":
        length, straight_length = self.roller_length, self.roller_profile.straight_length or 0.0
        if length is None:
            return self
        if self.roller_profile.shape == "crowned" and straight_length >= length:
            straight_part = f"a straight part of {show(straight_length, 'mm')}"
            message = f"{straight_part} leaves no crown on a roller of {show(length, 'mm')}"
            refuse("crown", message, "use a shorter one", at="roller_profile")
        ratio = round(length / self.roller_diameter, 9)
        if self.roller_profile.shape == "logarithmic" and ratio > MAX_LOGARITHMIC_LENGTH:
            message = f"this profile is defined for rollers of at most {MAX_LOGARITHMIC_LENGTH:g} diameters"
            refuse("long", message, "use `shape: crowned`", at="roller_profile")
        return self

    @model_validator(mode="after")
    def _check_flanges(self) -> "Bearing":
        flanges = self.flanges
        if flanges is None or flanges.height is None:
            return self
        height = flanges.height * ((flanges.inner > 0) + (flanges.outer > 0))
        if round(height / self.roller_diameter, 9) >= 1.0:
            size, gap = show(flanges.height, "mm"), show(self.roller_diameter, "mm")
            refuse("flanges", f"flanges of {size} do not fit between the races, {gap} apart", at="flanges")
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
    def _check_fit(self) -> "RollingParts":
        _check_circle(self)
        return self


def _check_circle(bearing: Bearing | RollingParts) -> None:
    """Reject rolling elements that do not fit on the pitch circle."""
    d_m, D_w = bearing.pitch_diameter, bearing.roller_diameter
    if D_w >= d_m * math.sin(math.pi / bearing.rollers):
        limit = int(math.pi / math.asin(min(D_w / d_m, 1.0)))
        message = f"{bearing.rollers} rollers do not fit: at most {limit}"
        refuse("crowded", message, "are the units of both diameters right?", at="rollers")


class Rig(Section):
    """Support of the outer ring by a bracket, and its sensor.

    In a validated case, `load` is not None if the ring is flexible, and both angles of the sensor are equal.
    """

    name: Text = ""
    """Name of the rig; not used in computations."""
    bracket_stiffness: StiffnessOrZero = 1e7
    """Radial stiffness of the support of the outer ring."""
    bracket_damping: Damping = 200.0
    """Radial damping of this support."""
    torsion_stiffness: TorsionalStiffness | None = None
    """Torsional stiffness of the support; without it the outer ring does not rotate."""
    torsion_damping: TorsionalDamping | None = None
    """Torsional damping of the support."""
    axial_stiffness: Stiffness | None = None
    """Axial stiffness of the support; without it the outer ring does not move axially (model `spatial`)."""
    axial_damping: Damping | None = None
    """Axial damping of the support."""
    tilting_stiffness: TorsionalStiffness | None = None
    """Tilting stiffness of the support; without it the outer ring does not tilt (model `spatial`)."""
    tilting_damping: TorsionalDamping | None = None
    """Tilting damping of the support."""
    sensor_angle: Angle = 0.0
    """Synonym of `sensor.angle`."""
    sensor: Sensor = Sensor()
    """Position of the vibration sensor."""
    ring: Annotated[FlexibleRing | None, OPTIONAL] = None
    """Flexible outer ring. Default: rigid."""
    load: Annotated[RingLoad | None, OPTIONAL] = None
    """Load path into a flexible ring. Default: a force on the load line."""
    ring_mass: Mass | None = None
    """Mass of the outer ring with its housing. Default: from the dimensions of the ring."""
    source: Text = ""
    """Source of the data; not used in computations."""

    @model_validator(mode="after")
    def _unify_sensor(self) -> "Rig":
        """Set both angles of the sensor to the same value; remove ring and load if the ring does not bend."""
        angle = self.sensor_angle if self.sensor.angle is None else self.sensor.angle
        if "sensor_angle" in self.model_fields_set and angle != self.sensor_angle:
            refuse("twice", "`sensor_angle` is a synonym of `sensor.angle`", "keep one of them", at="sensor_angle")
        object.__setattr__(self, "sensor_angle", angle)
        object.__setattr__(self, "sensor", self.sensor.model_copy(update={"angle": angle}))
        if self.ring is not None and not self.ring.bends:
            object.__setattr__(self, "ring", None)
            object.__setattr__(self, "load", None)
        return self


def default_rig() -> Rig:
    """Return the default rig, `bvt5`."""
    return Rig.model_validate(load_mapping("rigs", "bvt5"))
