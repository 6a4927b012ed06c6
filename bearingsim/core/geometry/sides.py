"""Sides of a roller, on which it touches a race, as types, so that the same code is compiled for each."""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import generic


class OuterSide(NamedTuple):
    """Contact of a roller with the outer race."""


class InnerSide(NamedTuple):
    """Contact of a roller with the inner race."""


@generic
def sign(side: Any) -> float:
    """Return 1 if the roller lies inside the race, -1 if outside."""


@generic(inline="early")
def side_rows(side: Any) -> int:
    """Return the base of the rows of this side of the rollers."""


@generic(inline="early")
def contact_rows(side: Any) -> tuple[int, int, int, int, int]:
    """Return the rows of force, approach, its rate, slip and tangential force over a defect in the planar
    models."""


@generic(inline="early")
def normal_rows(side: Any) -> tuple[int, int, int, int, int]:
    """Return the rows of the normal n along e_r and e_theta, of rho, of the speed transverse to n, and of the rate
    of rho over a defect."""


@generic(inline="early")
def load_cells(side: Any) -> tuple[int, int, int]:
    """Return the cells of a ring's loads: the first in the plane, the first out of the plane, and the moment about
    the axis."""


@generic(inline="early")
def slice_rows(side: Any) -> tuple[int, int]:
    """Return the rows of load and approach on this side, among the rows of a slice."""


@slice_rows.register(OuterSide)
def _slice_rows_outer(side):
    return lay.LOAD_O * lay.ROW, lay.APPROACH_O * lay.ROW


@slice_rows.register(InnerSide)
def _slice_rows_inner(side):
    return lay.LOAD_I * lay.ROW, lay.APPROACH_I * lay.ROW


@load_cells.register(OuterSide)
def _load_cells_outer(side):
    return lay.F_X, lay.F_Z, lay.M_RING


@load_cells.register(InnerSide)
def _load_cells_inner(side):
    return lay.F_X_I, lay.F_Z_I, lay.M_INNER


@sign.register(OuterSide)
def _sign_outer(side):
    return 1.0


@sign.register(InnerSide)
def _sign_inner(side):
    return -1.0


@side_rows.register(OuterSide)
def _side_rows_outer(side):
    return lay.OUTER_SIDE


@side_rows.register(InnerSide)
def _side_rows_inner(side):
    return lay.INNER_SIDE


@contact_rows.register(OuterSide)
def _contact_rows_outer(side):
    return lay.Q_O, lay.DELTA_O, lay.V_O, lay.SLIP_O, lay.DEFECT_FORCE_O


@contact_rows.register(InnerSide)
def _contact_rows_inner(side):
    return lay.Q_I, lay.DELTA_I, lay.V_I, lay.SLIP_I, lay.DEFECT_FORCE_I


@normal_rows.register(OuterSide)
def _normal_rows_outer(side):
    return lay.NORMAL_O_R, lay.NORMAL_O_T, lay.RHO_O, lay.TANGENTIAL_V_O, lay.RHO_V_O


@normal_rows.register(InnerSide)
def _normal_rows_inner(side):
    return lay.NORMAL_I_R, lay.NORMAL_I_T, lay.RHO_I, lay.TANGENTIAL_V_I, lay.RHO_V_I
