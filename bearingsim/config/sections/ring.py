"""An outer ring that bends: its harmonics, where its load enters, where its sensor sits."""

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

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
    mapping_such_as,
    one_of,
    refuse,
    whole,
)

MAX_HARMONICS = 100
LoadPath = Literal["point", "pads", "points", "housing"]
CARRIED: tuple[LoadPath, ...] = ("points", "housing")
"""Where springs stand between the ring and a rigid carrier, on which load and bracket act."""

KEYS: dict[LoadPath, tuple[str, ...]] = {
    "point": (),
    "pads": ("angles",),
    "points": ("at", "mass"),
    "housing": ("stiffness", "fit", "mass"),
}
"""What each way of loading the ring can be told besides; the first is needed."""


def _word_or_number(given: Any) -> Any:
    try:
        return given if given == "auto" else whole(2, MAX_HARMONICS).func(given)  # type: ignore[call-arg]
    except PydanticCustomError as error:
        message = (error.context or {})["message"]
        refuse("whole", message.replace("expected", "expected `auto`, or", 1))


class RingSection(Section):
    """The ring's section (m); without them as the bearing's dimensions say."""

    height: Length | None = None
    width: Length | None = None


class FlexibleRing(Section):
    """An outer ring that bends.

    harmonics: the highest that is computed; damping: of each harmonic, over the critical.
    """

    bends: Switch = True
    harmonics: Annotated[int | Literal["auto"], BeforeValidator(_word_or_number)] = "auto"
    damping: DampingRatio = 0.01
    section: RingSection = RingSection()

    _mapping = model_validator(mode="before")(mapping_such_as("{bends: true}"))


class SupportPoint(Section):
    """A spring between ring and carrier: angle (rad) from the load line, stiffness (N/m)."""

    angle: Angle
    stiffness: Stiffness


class RingLoad(Section):
    """Where the load enters a ring that bends.

    `point`: a force at the load line. `pads`: equal radial forces at `angles` (rad), whose resultant is the load.
    `points`: springs `at` some angles; `housing`: springs all round, of `stiffness` (N/m per m of circumference),
    with a `fit` (m; interference is positive, a gap negative). Both stand between the ring and a rigid carrier of
    a `mass` (kg), on which load and bracket act, and push only.
    """

    by: Annotated[LoadPath, one_of(*get_args(LoadPath))] = "point"
    angles: tuple[Angle, ...] | None = None
    at: tuple[SupportPoint, ...] | None = None
    stiffness: LineStiffness | None = None
    fit: SignedLength | None = None
    mass: Mass | None = None

    @property
    def carried(self) -> bool:
        """Whether springs stand between the ring and a carrier."""
        return self.by in CARRIED

    _mapping = model_validator(mode="before")(mapping_such_as("{by: housing, stiffness: 1e10 N/m/m}"))

    @property
    def foreign(self) -> tuple[str, ...]:
        """What is said that belongs to another way of loading the ring."""
        names = ("angles", "at", "stiffness", "fit", "mass")
        return tuple(name for name in names if getattr(self, name) is not None and name not in KEYS[self.by])

    @property
    def lacks(self) -> str:
        """What this way of loading the ring needs and is not said, or nothing."""
        needed = KEYS[self.by][:1]
        return needed[0] if needed and not getattr(self, needed[0]) else ""


class Sensor(Section):
    """Where the sensor sits, and the direction (rad, from the load line) in which it looks outwards."""

    on: Annotated[Literal["ring", "housing"], one_of("ring", "housing")] = "ring"
    angle: Angle | None = None

    _mapping = model_validator(mode="before")(mapping_such_as("{angle: 0 deg}"))
