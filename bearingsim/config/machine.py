"""What the user has on the bench: materials, bearings, rigs."""

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from bearingsim.config.fields import (
    Angle,
    Damping,
    Density,
    Length,
    Mass,
    Section,
    Stiffness,
    Text,
    refuse,
    whole,
)
from bearingsim.config.library import Kind, described
from bearingsim.core.kinematics import ball_pass_frequency_outer
from bearingsim.units import show


def named(kind: Kind) -> BeforeValidator:
    """Validator that lets a section be given by name or path."""
    return BeforeValidator(lambda given: described(kind, given))


class Material(Section):
    """What rollers and rings are made of."""

    name: Text = ""
    density: Density
    source: Text = ""


def _steel() -> Any:
    return Material.model_validate(described("materials", "steel"))


class Bearing(Section):
    """A cylindrical roller bearing: nominal dimensions in m, without clearance."""

    name: Text = ""
    rollers: Annotated[int, whole(3, 64)]
    roller_diameter: Length
    roller_length: Length
    pitch_diameter: Length
    bore: Length
    outside_diameter: Length
    width: Length
    material: Annotated[Material, named("materials")] = Field(default_factory=_steel)
    source: Text = ""

    @property
    def roller_spacing(self) -> float:
        """Distance along the outer race between neighbouring rollers, m."""
        return math.pi * (self.pitch_diameter + self.roller_diameter) / self.rollers

    def ball_pass_frequency(self, speed: float) -> float:
        """Rollers passing a point of the outer race per second (BPFO), Hz; `speed` in rad/s."""
        return ball_pass_frequency_outer(speed, self.roller_diameter, self.pitch_diameter, self.rollers)

    @model_validator(mode="after")
    def _fits(self) -> "Bearing":
        pitch, roller = self.pitch_diameter, self.roller_diameter
        if roller >= pitch * math.sin(math.pi / self.rollers):
            most = int(math.pi / math.asin(min(roller / pitch, 1.0)))
            refuse("crowded", f"{self.rollers} rollers do not fit: at most {most}", at="rollers")
        if pitch + roller >= self.outside_diameter:
            race = show(pitch + roller, "mm")
            refuse("outside", f"the outer race ({race}) is outside the outer ring", at="outside_diameter")
        if pitch - roller <= self.bore:
            race = show(pitch - roller, "mm")
            refuse("bore", f"the inner race ({race}) is inside the bore", at="bore")
        return self


class Rig(Section):
    """The bracket that holds the outer ring, and the sensor on it."""

    name: Text = ""
    bracket_stiffness: Stiffness = 1e7
    bracket_damping: Damping = 200.0
    sensor_angle: Angle = 0.0
    ring_mass: Mass | None = None
    source: Text = ""


def default_rig() -> Rig:
    """The rig taken when none is named."""
    return Rig.model_validate(described("rigs", "bvt5"))
