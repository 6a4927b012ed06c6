"""Sections for the `spatial` model: roller profile, flanges, misalignment."""

from typing import Annotated, Any, Literal, get_args

from pydantic import model_validator

from bearingsim.config.fields import (
    Angle,
    FileFormat,
    InverseVelocity,
    Length,
    LengthOrZero,
    Section,
    Stiffness,
    integer,
    one_of,
    or_words,
    refuse,
)

ProfileShape = Literal["straight", "crowned", "logarithmic"]


def _spelled(raw: Any) -> Any:
    """Convert a word to the mapping of a shape without parameters."""
    return {"shape": raw} if isinstance(raw, str) else raw


class Profile(Section):
    """Profile of a roller: reduction of its radius towards the ends.

    `crowned`: a parabola from zero at the ends of `straight_length` (m) to `drop` (m) at the roller's ends.
    `logarithmic`: 0.00035 D_w ln[1/(1 - (2 z/L_w)^2)], as in ISO/TS 16281.
    """

    shape: Annotated[ProfileShape, one_of(*get_args(ProfileShape))] = "straight"
    drop: Length | None = None
    straight_length: LengthOrZero | None = None

    @model_validator(mode="after")
    def _has_its_numbers(self) -> "Profile":
        if self.shape == "crowned" and self.drop is None:
            refuse("missing", "a crowned profile needs `drop`, a length such as `5 um`", at="drop")
        for name in ("drop", "straight_length"):
            if self.shape != "crowned" and getattr(self, name) is not None:
                refuse("foreign", f"a {self.shape} profile has none", "leave it out, or use `crowned`", at=name)
        return self


BARE = ("straight", "logarithmic")
"""Shapes without parameters."""
RollerProfile = Annotated[Profile, FileFormat(_spelled, lambda own: or_words(own, *BARE))]


class Flanges(Section):
    """Flanges that guide rollers axially: their number on each ring, clearance and contact.

    A single flange of a ring is on the +z side. `clearance` is the total axial play of a roller between two
    flanges (m), `height` the height above the race (m; by default a fifth of the roller's diameter). A roller
    touches a flange at two points, each with a linear `stiffness` (N/m) and Hunt-Crossley `damping` chi (s/m).
    Clearance, height and contact are assumptions.
    """

    inner: Annotated[int, integer(0, 2)] = 0
    outer: Annotated[int, integer(0, 2)] = 0
    clearance: Length = 5e-5
    height: Length | None = None
    stiffness: Stiffness = 1e8
    damping: InverseVelocity = 10.0


class Misalignment(Section):
    """Misalignment of the rings: tilt of each axis, and the direction towards which its +z end tilts (rad).

    The direction is measured from the load line, in the sense of rotation, and is fixed in space.
    """

    inner: Angle = 0.0
    outer: Angle = 0.0
    direction: Angle = 0.0
