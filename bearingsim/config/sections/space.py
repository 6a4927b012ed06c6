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


def _as_mapping(raw: Any) -> Any:
    """Convert the name of a shape without parameters to a mapping."""
    return {"shape": raw} if isinstance(raw, str) else raw


class Profile(Section):
    """Profile of a roller: reduction of its radius towards the ends.

    `crowned`: zero up to the ends of `straight_length`, then a parabola.
    `logarithmic`: 0.00035 D_w ln[1/(1 - (2 z/L_w)^2)], for rollers of L_w <= 2.5 D_w.
    """

    shape: Annotated[ProfileShape, one_of(*get_args(ProfileShape))] = "straight"
    """`straight`; `crowned`: a parabola towards the ends; `logarithmic`: the profile of ISO/TS 16281."""
    drop: Length | None = None
    """Reduction of the radius at the ends of a `crowned` roller."""
    straight_length: LengthOrZero | None = None
    """Length of the straight central part of a `crowned` roller. Default: 0."""

    @model_validator(mode="after")
    def _check_parameters(self) -> "Profile":
        if self.shape == "crowned" and self.drop is None:
            refuse("missing", "a crowned profile needs `drop`, a length such as `5 um`", at="drop")
        for name in ("drop", "straight_length"):
            if self.shape != "crowned" and getattr(self, name) is not None:
                refuse(
                    "foreign",
                    f"a {self.shape} profile has no `{name}`",
                    f"remove `{name}`, or use `shape: crowned`",
                    at=name,
                )
        return self


WORD_SHAPES = ("straight", "logarithmic")
"""Shapes without parameters."""
RollerProfile = Annotated[Profile, FileFormat(_as_mapping, lambda schema: or_words(schema, *WORD_SHAPES))]


class Flanges(Section):
    """Flanges that guide rollers axially: their number on each ring, clearance and contact."""

    inner: Annotated[int, integer(0, 2)] = 0
    """Number of flanges of the inner ring; a single flange is on the +z side."""
    outer: Annotated[int, integer(0, 2)] = 0
    """Number of flanges of the outer ring; a single flange is on the +z side."""
    clearance: Length = 5e-5
    """Total axial play of a roller between two flanges (assumed)."""
    height: Length | None = None
    """Height of the flanges above the race. Default: a fifth of the roller's diameter."""
    stiffness: Stiffness = 1e8
    """Linear stiffness of each of the two contact points of a roller and a flange (assumed)."""
    damping: InverseVelocity = 10.0
    """Hunt-Crossley coefficient chi of these contacts (assumed)."""


class Misalignment(Section):
    """Misalignment of the rings: tilt of each axis, and its direction."""

    inner: Angle = 0.0
    """Tilt of the inner ring's axis."""
    outer: Angle = 0.0
    """Tilt of the outer ring's axis."""
    direction: Angle = 0.0
    """Direction towards which the +z ends of the axes tilt, from the load line in the sense of rotation; fixed in
    space.
    """
