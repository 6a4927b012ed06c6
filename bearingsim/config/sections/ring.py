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

MAX_HARMONICS = 100
LoadPath = Literal["point", "pads", "points", "housing"]
CARRIED: tuple[LoadPath, ...] = ("points", "housing")
"""Load paths with springs between the ring and a rigid carrier; load and bracket act on the carrier."""

KEYS: dict[LoadPath, tuple[str, ...]] = {
    "point": (),
    "pads": ("angles",),
    "points": ("at", "mass"),
    "housing": ("stiffness", "fit", "mass"),
}
"""Keys of each load path besides `by`; the first is required."""


class Mapped(Section):
    """Section that must be a mapping; the error for any other value shows an example."""

    example: ClassVar[str]

    @model_validator(mode="before")
    @classmethod
    def _is_a_mapping(cls, raw: Any) -> Any:
        if isinstance(raw, dict | cls):
            return raw
        return refuse("mapping", f"expected a mapping such as `{cls.example}`, got {describe_value(raw)}")


class RingSection(Mapped):
    """Cross-section of the outer ring (m); by default from the dimensions of the bearing."""

    example = "{height: 6.5 mm, width: 23 mm}"
    height: Length | None = None
    width: Length | None = None


class FlexibleRing(Mapped):
    """Flexible outer ring.

    harmonics: order of the highest harmonic computed; damping: damping ratio of each harmonic.
    """

    example = "{bends: true}"
    bends: Switch = True
    harmonics: Annotated[int | Literal["auto"], integer_or_auto(2, MAX_HARMONICS)] = "auto"
    damping: DampingRatio = 0.01
    section: RingSection = RingSection()


class SupportPoint(Mapped):
    """Spring between ring and carrier: angle (rad) from the load line, stiffness (N/m)."""

    example = "{angle: 0 deg, stiffness: 1e8 N/m}"
    angle: Angle
    stiffness: Stiffness


class RingLoad(Mapped):
    """Load path into a flexible ring.

    `point`: a force on the load line. `pads`: equal radial forces at `angles` (rad), whose resultant is the load.
    `points`: springs `at` discrete angles. `housing`: springs all round with `stiffness` (N/m per m of
    circumference) and `fit` (m; interference positive, gap negative). The springs transmit compression only, to a
    rigid carrier of `mass` (kg), on which load and bracket act.
    """

    example = "{by: housing, stiffness: 1e10 N/m/m}"
    by: Annotated[LoadPath, one_of(*get_args(LoadPath))] = "point"
    angles: tuple[Angle, ...] | None = None
    at: tuple[SupportPoint, ...] | None = None
    stiffness: LineStiffness | None = None
    fit: SignedLength | None = None
    mass: Mass | None = None

    @property
    def carried(self) -> bool:
        """True if springs connect the ring to a carrier."""
        return self.by in CARRIED

    @model_validator(mode="after")
    def _told_what_it_needs(self) -> "RingLoad":
        for name in ("angles", "at", "stiffness", "fit", "mass"):
            if getattr(self, name) is not None and name not in KEYS[self.by]:
                of = next(by for by, keys in KEYS.items() if name in keys)
                refuse("load", f"`by: {self.by}` has none", f"leave it out, or use `by: {of}`", at=name)
        needed = KEYS[self.by][:1]
        if needed and not getattr(self, needed[0]):
            example = {"angles": "[-45 deg, 45 deg]", "at": "[{angle: 0 deg, stiffness: 1e8 N/m}]"}
            shown = example.get(needed[0], "1e10 N/m/m")
            refuse("load", f"`by: {self.by}` needs `{needed[0]}`", f"use `{needed[0]}: {shown}`", at="by")
        return self


class Sensor(Mapped):
    """Position of the sensor, and its outward direction (rad, from the load line)."""

    example = "{on: ring, angle: 0 deg}"
    on: Annotated[Literal["ring", "housing"], one_of("ring", "housing")] = "ring"
    angle: Angle | None = None

    @property
    def on_ring(self) -> bool:
        """True if the sensor is on the ring itself."""
        return self.on == "ring"
