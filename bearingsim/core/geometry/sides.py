"""The two sides on which a roller touches a race, as types: the same code serves both, compiled for each."""

from typing import Any, NamedTuple

from bearingsim.core.jit import generic
from bearingsim.core.layout import (
    DELTA_I,
    DELTA_O,
    INNER_SIDE,
    OUTER_SIDE,
    Q_I,
    Q_O,
    SLIP_I,
    SLIP_O,
    TILT_I,
    TILT_O,
    V_I,
    V_O,
)


class OuterSide(NamedTuple):
    """Where a roller touches the outer race."""


class InnerSide(NamedTuple):
    """Where a roller touches the inner race."""


@generic
def sign(side: Any) -> float:
    """1 where the roller lies inside the race, -1 where outside."""


@generic
def rows_of(side: Any) -> int:
    """Where the rows of this side of the rollers begin."""


@generic
def totals(side: Any) -> tuple[int, int, int, int, int]:
    """Rows of what the planar models call force, approach, its rate, slip and tangential force."""


@sign.register(OuterSide)
def _sign_outer(side):
    return 1.0


@sign.register(InnerSide)
def _sign_inner(side):
    return -1.0


@rows_of.register(OuterSide)
def _rows_of_outer(side):
    return OUTER_SIDE


@rows_of.register(InnerSide)
def _rows_of_inner(side):
    return INNER_SIDE


@totals.register(OuterSide)
def _totals_outer(side):
    return Q_O, DELTA_O, V_O, SLIP_O, TILT_O


@totals.register(InnerSide)
def _totals_inner(side):
    return Q_I, DELTA_I, V_I, SLIP_I, TILT_I
