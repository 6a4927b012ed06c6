"""Flanges: the shoulders of a ring that keep rollers from running out along the axis."""

from typing import Any, NamedTuple


class NoFlanges(NamedTuple):
    """Nothing holds a roller along the axis but friction."""


class Flanges(NamedTuple):
    """Shoulders of the two rings; a roller's flat end meets one at two points, apart along the race.

    inner_minus, inner_plus, outer_minus, outer_plus: 1.0 where there is one, else 0.0 (minus: on the side of -z);
    play: from a centred roller's end to the flange (m); height: of the flange above its race (m), half of which is
    where it is met; law: of the contact of one point; friction: between roller end and flange.
    """

    inner_minus: float
    inner_plus: float
    outer_minus: float
    outer_plus: float
    play: float
    height: float
    law: Any
    friction: Any
