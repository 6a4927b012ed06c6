"""A pit, and how it is let act on the rollers."""

from typing import Annotated, Literal, get_args

from bearingsim.config.fields import Angle, Length, Section, SignedLength, one_of, whole

Shape = Literal["rectangular", "triangular", "circular"]
Race = Literal["outer", "inner", "roller"]
Excitation = Literal[
    "envelope",
    "rectangular-pulse",
    "half-sine-pulse",
    "piecewise-pulse",
    "clearance-increase",
    "pressure-share",
    "soft-edge",
    "impulse-train",
    "random-impulses",
]

IMPULSES: tuple[Excitation, ...] = ("impulse-train", "random-impulses")
"""Excitations that are forces in time, not shapes in space: the impulse model's."""

WEAKENED: tuple[Excitation, ...] = ("pressure-share", "soft-edge")
"""Excitations that change the contact's force at the pit, not only its place."""


class Defect(Section):
    """A pit: lengths in m (`length` along the axis, `width` along rolling), angle in rad.

    `offset` is how far the pit's middle lies off the roller's, towards +z (m).

    `race` is the element that carries it; `roller` counts from 1 and is 1 if not given. The angle is taken from
    the load line (outer race; inner race at t = 0, turning with the ring) or, on a roller, from the outward
    radial direction at t = 0.
    """

    race: Annotated[Race, one_of(*get_args(Race))] = "outer"
    roller: Annotated[int, whole(1, 64)] | None = None
    shape: Annotated[Shape, one_of(*get_args(Shape))]
    length: Length
    width: Length
    depth: Length
    angle: Angle = 0.0
    offset: SignedLength = 0.0

    @property
    def element(self) -> tuple[str, int]:
        """The element that carries it: the race, and the number of the roller (0: a race)."""
        return self.race, (self.roller or 1) if self.race == "roller" else 0
