"""Sections for the models from `planar` on: friction, cage, drag, shaft, ramp."""

from typing import TYPE_CHECKING, Annotated, Literal, get_args

from pydantic import model_validator

from bearingsim.config.fields import (
    Angle,
    Damping,
    Density,
    Duration,
    InverseVelocity,
    Length,
    LengthOrZero,
    Mass,
    MassRadius,
    Number,
    PositiveNumber,
    Rotation,
    Section,
    Share,
    SignedNumber,
    Stiffness,
    TorsionalDamping,
    TorsionalStiffness,
    Velocity,
    Viscosity,
    one_of,
    refuse,
)
from bearingsim.config.sections.laws import laws_of

Motion = Literal["free", "kinematic"]
Guide = Literal["centred", "rollers", "inner-ring", "outer-ring"]
Land = Literal["inner", "outer"]


class Ramp(Section):
    """Linear change of the speed, from the case's `speed` to another constant speed."""

    to: Rotation
    """Speed of the inner ring after the ramp."""
    time: Duration
    """Duration of the ramp, from t = 0, the start of settling."""


class _FrictionCurve(Section):
    """Friction coefficient, odd in speed: `static` at `static_speed`, falling to `dynamic` at `dynamic_speed`."""

    static: Number
    """Largest friction coefficient, reached at `static_speed`."""
    dynamic: Number
    """Friction coefficient from `dynamic_speed` on."""
    static_speed: Velocity = 0.02
    """Sliding speed of the largest friction coefficient; below it friction rises from zero."""
    dynamic_speed: Velocity = 0.1
    """Sliding speed from which the friction coefficient is `dynamic`."""

    @model_validator(mode="after")
    def _check_curve(self) -> "_FrictionCurve":
        if self.dynamic > self.static:
            refuse("curve", f"dynamic friction ({self.dynamic:g}) is above static ({self.static:g})", at="dynamic")
        if self.dynamic_speed <= self.static_speed:
            refuse("curve", "must be above `static_speed`", at="dynamic_speed")
        return self


class StaticDynamic(_FrictionCurve):
    """Dry friction of rollers on races, by default with the coefficients of Yang et al. (docs/paper.md)."""

    law: Literal["static-dynamic"] = "static-dynamic"
    static: Number = 0.3
    dynamic: Number = 0.15


ROUNDING_ERROR = 1e-12  # limit of the rounding error of a + d, whose terms may be computed by a sweep


class Traction(Section):
    """Lubricated traction, mu = (a + b s) exp(-c s) + d, with s the slide-to-roll ratio (Kragelskii)."""

    law: Literal["traction"] = "traction"
    a: SignedNumber = -0.1
    """Coefficient a of mu = (a + b s) exp(-c s) + d, with s the slide-to-roll ratio."""
    b: Number = 22.28
    """Coefficient b of the traction curve."""
    c: PositiveNumber = 181.46
    """Coefficient c of the traction curve."""
    d: Number = 0.1
    """Friction coefficient at large slip, d of the traction curve."""

    @model_validator(mode="after")
    def _check_sign(self) -> "Traction":
        """Refuse a curve that is negative somewhere, because friction would then drive the slip."""
        if self.a > 0.0:
            refuse("curve", f"a = {self.a:g} is above zero: friction would decrease with slip", at="a")
        if self.a + self.d < -ROUNDING_ERROR:
            message = f"a + d = {self.a + self.d:g} is below zero: friction would drive the slip"
            refuse("curve", message, "a curve that starts from zero has a = -d", at="a")
        return self


class Frictionless(Section):
    """Frictionless contact of rollers and races."""

    law: Literal["none"] = "none"


FRICTION = laws_of("friction", default="static-dynamic")

if TYPE_CHECKING:
    Friction = Section
else:
    Friction = FRICTION.field()


class CageFriction(_FrictionCurve):
    """Friction of the cage on rollers and guiding ring, by default as given by Yang et al. (docs/paper.md)."""

    static: Number = 0.002
    dynamic: Number = 0.001


class Cage(Section):
    """Cage: its motion, mass, clearances (m) and contacts."""

    motion: Annotated[Motion, one_of(*get_args(Motion))] = "free"
    """`free`: moved by its contacts and friction; `kinematic`: rotates at the speed of pure rolling."""
    mass: Mass | None = None
    """Mass of the cage. Default: from the dimensions of the bearing."""
    pocket_clearance: Length = 2e-4
    """Total circumferential gap of a roller in its pocket (assumed)."""
    pocket_stiffness: Stiffness = 1e7
    """Linear stiffness of the contacts of a roller and its pocket, and of the cage and its guide (assumed)."""
    pocket_damping: InverseVelocity = 10.0
    """Hunt-Crossley coefficient chi of these contacts (assumed)."""
    friction: CageFriction = CageFriction()
    """Friction of the cage on rollers and guiding ring."""
    guide: Annotated[Guide, one_of(*get_args(Guide))] = "centred"
    """Guidance of the cage: `centred` (its centre is fixed), by the rollers, or by the inner or outer ring."""
    guide_clearance: Length = 4e-4
    """Diametral gap of the cage and its guiding ring (assumed)."""
    radial_pocket_clearance: Length | None = None
    """Total radial gap of a roller in its pocket, for a cage guided by its rollers. Default: `pocket_clearance`.
    """
    axial_clearance: Length = 4e-4
    """Total axial gap of a roller in its pocket (model `spatial`)."""

    @model_validator(mode="after")
    def _fill_clearance(self) -> "Cage":
        if self.radial_pocket_clearance is None:
            object.__setattr__(self, "radial_pocket_clearance", self.pocket_clearance)
        return self


class Drag(Section):
    """Drag of the oil on rollers, and of the film between the cage and its guiding ring.

    Drag on a roller is 1/2 (oil_fraction oil_density) drag_coefficient L D v^2. The shear stress of the film is
    oil_viscosity U/land_gap on the area 2 pi R land_width.
    """

    oil_fraction: Share = 0.1
    """Volume fraction of oil in the bearing's free space."""
    oil_density: Density = 860.0
    """Density of the oil."""
    drag_coefficient: Number = 1.0
    """Drag coefficient of a roller moving through the mixture of oil and air."""
    oil_viscosity: Viscosity = 0.05
    """Dynamic viscosity of the oil film between cage and guiding land."""
    land: Annotated[Land, one_of(*get_args(Land))] = "outer"
    """Ring whose land guides the cage and shears the film: `inner` or `outer`."""
    land_gap: Length = 2e-4
    """Thickness of the oil film between cage and land."""
    land_width: LengthOrZero | None = None
    """Width of the land, 0 for a cage without land. Default: width of the ring minus length of the roller."""


class Shaft(Section):
    """Support of a moving inner ring."""

    stiffness: Stiffness
    """Radial stiffness of the support of the inner ring."""
    damping: Damping = 0.0
    """Radial damping of this support."""
    mass: Mass
    """Mass of inner ring and shaft."""
    axial_stiffness: Stiffness | None = None
    """Axial stiffness of the support; without it the inner ring does not move axially (model `spatial`)."""
    axial_damping: Damping | None = None
    """Axial damping of the support."""
    tilting_stiffness: TorsionalStiffness | None = None
    """Tilting stiffness of the support; without it the inner ring does not tilt (model `spatial`)."""
    tilting_damping: TorsionalDamping | None = None
    """Tilting damping of the support."""


class Unbalance(Section):
    """Unbalance of the shaft."""

    mass_radius: MassRadius
    """Unbalance: mass times its distance from the axis."""
    angle: Angle = 0.0
    """Angle of the unbalance from the load line at t = 0."""
