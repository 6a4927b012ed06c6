"""Flexible outer ring: its harmonics, load path and sensor."""

from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import model_validator

from bearingsim.config.fields import (
    Angle,
    DampingRatio,
    Length,
    LineStiffness,
    Mass,
    Section,
    SignedLength,
    Stiffness,
    Switch,
    describe_value,
    integer_or_auto,
    one_of,
    refuse,
)

MAX_HARMONICS = 100  # largest order of a bending harmonic
LoadPath = Literal["point", "pads", "points", "housing"]
CARRIER_PATHS: tuple[LoadPath, ...] = ("points", "housing")
"""Load paths with springs between the ring and a rigid carrier; load and bracket act on the carrier."""

LOAD_PATH_KEYS: dict[LoadPath, tuple[str, ...]] = {
    "point": (),
    "pads": ("angles",),
    "points": ("at", "mass"),
    "housing": ("stiffness", "fit", "mass"),
}
"""Keys of each load path besides `by`; the first is required."""


class MappingSection(Section):
    """Section that must be a mapping; the error for any other value shows an example."""

    example: ClassVar[str]

    @model_validator(mode="before")
    @classmethod
    def _check_mapping(cls, raw: Any) -> Any:
        if isinstance(raw, dict | cls):
            return raw
        return refuse("mapping", f"expected a mapping such as `{cls.example}`, got {describe_value(raw)}")


class RingSection(MappingSection):
    """Cross-section of the outer ring."""

    example = "{height: 6.5 mm, width: 23 mm}"
    height: Length | None = None
    """Radial height of the cross-section, from race to outside diameter."""
    width: Length | None = None
    """Axial width of the cross-section."""


class FlexibleRing(MappingSection):
    """Flexible outer ring."""

    example = "{bends: true}"
    bends: Switch = True
    """Bending of the outer ring; `false` makes it rigid."""
    harmonics: Annotated[int | Literal["auto"], integer_or_auto(2, MAX_HARMONICS)] = "auto"
    """Order of the highest bending harmonic. `auto`: from the number of rollers."""
    damping: DampingRatio = 0.01
    """Damping ratio of each bending mode."""
    section: RingSection = RingSection()
    """Cross-section of the ring. Default: from the dimensions of the bearing."""


class SupportPoint(MappingSection):
    """Spring between ring and carrier."""

    example = "{angle: 0 deg, stiffness: 1e8 N/m}"
    angle: Angle
    """Position of the spring, from the load line."""
    stiffness: Stiffness
    """Radial stiffness of the spring."""


class RingLoad(MappingSection):
    """Load path into a flexible ring. Springs transmit compression only, to a rigid carrier."""

    example = "{by: housing, stiffness: 1e10 N/m/m}"
    by: Annotated[LoadPath, one_of(*get_args(LoadPath))] = "point"
    """Load path: `point` (a force on the load line), `pads` (equal radial forces), `points` (springs at discrete
    angles) or `housing` (springs all round).
    """
    angles: tuple[Angle, ...] | None = None
    """Positions of the forces of `pads`, from the load line."""
    at: tuple[SupportPoint, ...] | None = None
    """Springs of `points`, each with its angle and stiffness."""
    stiffness: LineStiffness | None = None
    """Stiffness of a `housing` per length of circumference."""
    fit: SignedLength | None = None
    """Fit of the ring in a `housing`: radial interference (positive) or gap (negative)."""
    mass: Mass | None = None
    """Mass of the carrier behind the springs of `points` and `housing`, on which load and bracket act."""

    @property
    def has_carrier(self) -> bool:
        """True if springs connect the ring to a carrier."""
        return self.by in CARRIER_PATHS

    @model_validator(mode="after")
    def _check_keys(self) -> "RingLoad":
        for name in ("angles", "at", "stiffness", "fit", "mass"):
            if getattr(self, name) is not None and name not in LOAD_PATH_KEYS[self.by]:
                path = next(by for by, keys in LOAD_PATH_KEYS.items() if name in keys)
                refuse(
                    "load", f"`by: {self.by}` has no `{name}`", f"remove `{name}`, or use `by: {path}`", at=name
                )
        required = LOAD_PATH_KEYS[self.by][:1]
        if required and not getattr(self, required[0]):
            example = {"angles": "[-45 deg, 45 deg]", "at": "[{angle: 0 deg, stiffness: 1e8 N/m}]"}
            value = example.get(required[0], "1e10 N/m/m")
            refuse("load", f"`by: {self.by}` needs `{required[0]}`", f"use `{required[0]}: {value}`", at="by")
        return self


class Sensor(MappingSection):
    """Position of the sensor, and its outward direction (rad, from the load line)."""

    example = "{on: ring, angle: 0 deg}"
    on: Annotated[Literal["ring", "housing"], one_of("ring", "housing")] = "ring"
    """Body with the sensor: the outer `ring`, or the `housing`."""
    angle: Angle | None = None
    """Position and outward direction of the sensor, from the load line."""

    @property
    def on_ring(self) -> bool:
        """True if the sensor is on the ring itself."""
        return self.on == "ring"
