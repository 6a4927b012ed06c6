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
    """The speed goes linearly from the case's `speed` to `to` (rad/s) in `time` (s), then stays."""

    to: Rotation
    time: Duration


class _Curve(Section):
    """The static-dynamic curve: odd, up to `static` at `static_speed`, down to `dynamic` at `dynamic_speed`."""

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
    """Dry friction of rollers on races, by the paper's curve (0.3 and 0.15)."""

    law: Literal["static-dynamic"] = "static-dynamic"
    static: Number = 0.3
    dynamic: Number = 0.15


class Traction(Section):
    """Lubricated traction, mu = (a + b s) exp(-c s) + d with s the slip over the rolling speed (Kragelskii)."""

    law: Literal["traction"] = "traction"
    a: SignedNumber = -0.1
    b: SignedNumber = 22.28
    c: Number = 181.46
    d: Number = 0.1


class Frictionless(Section):
    """Rollers that slide freely."""

    law: Literal["none"] = "none"


FRICTION = laws_of("friction", default="static-dynamic")

if TYPE_CHECKING:
    Friction = Section
else:
    Friction = FRICTION.field()


class CageFriction(_Curve):
    """Friction of the cage on rollers and guiding ring (the paper's 0.002 and 0.001)."""

    static: Number = 0.002
    dynamic: Number = 0.001


class Cage(Section):
    """The cage: how it moves, its mass (None: from its dimensions), clearances (m, whole gap) and contacts.

    `pocket_stiffness` (N/m) is linear, `pocket_damping` is chi (s/m) of a Hunt-Crossley contact; both hold for the
    guide too. `radial_pocket_clearance` is the gap that guides a cage on its rollers, the pocket's if not given.
    `axial_clearance` is the gap along a roller in its pocket, for the spatial model. Stiffness, damping and
    clearances are assumptions.
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
    """Drag on rollers and cage: churned oil, and the film between the cage and its guiding ring (`land`).

    The roller's drag is 1/2 (oil_fraction oil_density) drag_coefficient L D v^2; the film's stress is
    oil_viscosity U/land_gap on an area 2 pi R land_width (None: the ring's width less the roller's length).
    """

    oil_fraction: Share = 0.1
    oil_density: Density = 860.0
    drag_coefficient: Number = 1.0
    oil_viscosity: Viscosity = 0.05
    land: Annotated[Land, one_of(*get_args(Land))] = "outer"
    land_gap: Length = 2e-4
    land_width: Length | None = None


class Shaft(Section):
    """An inner ring that can move: spring (N/m) and damper (N s/m) that hold it, its mass with the shaft (kg).

    With `axial_stiffness` (N/m) and `tilting_stiffness` (N m/rad) it also moves along its axis and tilts.
    """

    stiffness: Stiffness
    damping: Damping = 0.0
    mass: Mass
    axial_stiffness: Stiffness | None = None
    axial_damping: Damping | None = None
    tilting_stiffness: TorsionalStiffness | None = None
    tilting_damping: TorsionalDamping | None = None


class Unbalance(Section):
    """A mass turning with the shaft: mass times radius (kg m), and its angle from the load line at t = 0 (rad)."""

    mass_radius: MassRadius
    angle: Angle = 0.0
