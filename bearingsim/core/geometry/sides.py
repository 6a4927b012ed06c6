"""The two sides on which a roller touches a race, as types: the same code serves both, compiled for each."""

from typing import Any, NamedTuple

from bearingsim.core.jit import generic
from bearingsim.core.layout import (
    APART_I,
    APART_O,
    DELTA_I,
    DELTA_O,
    INNER_SIDE,
    M_R,
    M_T,
    N_R,
    N_T,
    OUTER_SIDE,
    Q_I,
    Q_O,
    RHO_I,
    RHO_O,
    SLIP_I,
    SLIP_O,
    T_I,
    T_O,
    TILT_I,
    TILT_O,
    V_I,
    V_O,
    X_I,
    X,
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


@generic
def frame(side: Any) -> tuple[int, int, int, int, int]:
    """Rows of n along e_r and e_theta, of rho, of the speed across n, and of rho's rate over a pit."""


@generic
def ring_of(side: Any) -> int:
    """The first shared coordinate of the race's ring."""


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


@frame.register(OuterSide)
def _frame_outer(side):
    return N_R, N_T, RHO_O, T_O, APART_O


@frame.register(InnerSide)
def _frame_inner(side):
    return M_R, M_T, RHO_I, T_I, APART_I


@ring_of.register(OuterSide)
def _ring_of_outer(side):
    return X


@ring_of.register(InnerSide)
def _ring_of_inner(side):
    return X_I
