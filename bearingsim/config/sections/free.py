"""Sections for the models from `planar` on: friction, cage, drag, shaft, ramp. Absent sections are None."""

from typing import TYPE_CHECKING, Annotated, Literal, get_args

from pydantic import model_validator

from bearingsim.config.fields import (
    Angle,
    Damping,
    Density,
    Duration,
    InverseVelocity,
    Length,
    Mass,
    MassRadius,
    Number,
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
    """Linear change of the speed from the case's `speed` to `to` (rad/s) in `time` (s), then constant."""

    to: Rotation
    time: Duration


class _Curve(Section):
    """Friction coefficient, odd in speed: `static` at `static_speed`, falling to `dynamic` at `dynamic_speed`."""

    static: Number
    dynamic: Number
    static_speed: Velocity = 0.02
    dynamic_speed: Velocity = 0.1

    @model_validator(mode="after")
    def _falls(self) -> "_Curve":
        if self.dynamic > self.static:
            refuse("curve", f"dynamic friction ({self.dynamic:g}) is above static ({self.static:g})", at="dynamic")
        if self.dynamic_speed <= self.static_speed:
            refuse("curve", "must be above `static_speed`", at="dynamic_speed")
        return self


class StaticDynamic(_Curve):
    """Dry friction of rollers on races, by default with the coefficients of the paper."""

    law: Literal["static-dynamic"] = "static-dynamic"
    static: Number = 0.3
    dynamic: Number = 0.15


class Traction(Section):
    """Lubricated traction, mu = (a + b s) exp(-c s) + d, with s the slide-to-roll ratio (Kragelskii)."""

    law: Literal["traction"] = "traction"
    a: SignedNumber = -0.1
    b: SignedNumber = 22.28
    c: Number = 181.46
    d: Number = 0.1


class Frictionless(Section):
    """Frictionless contact of rollers and races."""

    law: Literal["none"] = "none"


FRICTION = laws_of("friction", default="static-dynamic")

if TYPE_CHECKING:
    Friction = Section
else:
    Friction = FRICTION.field()


class CageFriction(_Curve):
    """Friction of the cage on rollers and guiding ring, by default with the coefficients of the paper."""

    static: Number = 0.002
    dynamic: Number = 0.001


class Cage(Section):
    """Cage: its motion, mass (None: from its dimensions), clearances (m, total gap) and contacts.

    `pocket_stiffness` (N/m) is linear, `pocket_damping` is chi (s/m) of a Hunt-Crossley contact; both also apply
    to the guide. `radial_pocket_clearance` is the gap of a cage guided by its rollers, by default
    `pocket_clearance`. `axial_clearance` is the axial gap of a roller in its pocket, for the spatial model.
    Stiffness, damping and clearances are assumptions.
    """

    motion: Annotated[Motion, one_of(*get_args(Motion))] = "free"
    mass: Mass | None = None
    pocket_clearance: Length = 2e-4
    pocket_stiffness: Stiffness = 1e7
    pocket_damping: InverseVelocity = 10.0
    friction: CageFriction = CageFriction()
    guide: Annotated[Guide, one_of(*get_args(Guide))] = "centred"
    guide_clearance: Length = 4e-4
    radial_pocket_clearance: Length | None = None
    axial_clearance: Length = 4e-4

    @model_validator(mode="after")
    def _resolved(self) -> "Cage":
        if self.radial_pocket_clearance is None:
            object.__setattr__(self, "radial_pocket_clearance", self.pocket_clearance)
        return self


class Drag(Section):
    """Drag of the oil on rollers, and of the film between the cage and its guiding ring (`land`).

    Drag on a roller is 1/2 (oil_fraction oil_density) drag_coefficient L D v^2. The shear stress of the film is
    oil_viscosity U/land_gap on the area 2 pi R land_width (None: the ring's width minus the roller's length).
    """

    oil_fraction: Share = 0.1
    oil_density: Density = 860.0
    drag_coefficient: Number = 1.0
    oil_viscosity: Viscosity = 0.05
    land: Annotated[Land, one_of(*get_args(Land))] = "outer"
    land_gap: Length = 2e-4
    land_width: Length | None = None


class Shaft(Section):
    """Support of a moving inner ring: spring (N/m), damper (N s/m), mass of ring and shaft (kg).

    With `axial_stiffness` (N/m) and `tilting_stiffness` (N m/rad) the ring can also move axially and tilt.
    """

    stiffness: Stiffness
    damping: Damping = 0.0
    mass: Mass
    axial_stiffness: Stiffness | None = None
    axial_damping: Damping | None = None
    tilting_stiffness: TorsionalStiffness | None = None
    tilting_damping: TorsionalDamping | None = None


class Unbalance(Section):
    """Unbalance of the shaft: mass times radius (kg m), and its angle from the load line at t = 0 (rad)."""

    mass_radius: MassRadius
    angle: Angle = 0.0
