"""Sections for the `spatial` model: roller profile, flanges, misalignment."""

from typing import Annotated, Any, Literal, get_args

from pydantic import model_validator

from bearingsim.config.fields import (
    Angle,
    InverseVelocity,
    Length,
    LengthOrZero,
    Section,
    Stiffness,
    Written,
    one_of,
    or_words,
    refuse,
    whole,
)

ProfileShape = Literal["straight", "crowned", "logarithmic"]


def _spelled(raw: Any) -> Any:
    """Convert a bare word to a shape without numbers."""
    return {"shape": raw} if isinstance(raw, str) else raw


class Profile(Section):
    """Profile of a roller: decrease of its radius towards the ends.

    `crowned`: by a parabola that begins at the ends of `straight_length` (m) and sinks to `drop` (m, of the
    radius) at the roller's ends. `logarithmic`: by 0.00035 D_w ln[1/(1 - (2 z/L_w)^2)], that of ISO/TS 16281.
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
"""Shapes that need no numbers."""
RollerProfile = Annotated[Profile, Written(_spelled, lambda own: or_words(own, *BARE))]


class Flanges(Section):
    """The shoulders that keep rollers from running out: how many of each ring, play and contact.

    One flange of a ring stands on the side of +z. `clearance` is the whole axial play of a roller between two
    flanges (m), `height` that above the race (m; a fifth of the roller's diameter if not given). `stiffness` (N/m)
    is linear and that of each of the two points in which a roller meets a flange; `damping` is chi (s/m) of their
    Hunt-Crossley contact. Clearance, height and contact are assumptions.
    """

    inner: Annotated[int, whole(0, 2)] = 0
    outer: Annotated[int, whole(0, 2)] = 0
    clearance: Length = 5e-5
    height: Length | None = None
    stiffness: Stiffness = 1e8
    damping: InverseVelocity = 10.0


class Misalignment(Section):
    """Rings mounted askew: tilt of each ring's axis (rad), and the angle (rad) towards which its +z end tilts.

    The direction counts from the load line, in the sense of rotation, and does not turn with the shaft.
    """

    inner: Angle = 0.0
    outer: Angle = 0.0
    direction: Angle = 0.0
