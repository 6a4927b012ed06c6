"""Form of the surfaces: waviness of the races, and waviness and diameters of the rollers.

The recess of a surface is its depth (m) below the nominal one, so a contact's approach is smaller by the recesses
of race and roller at their common point. Its rate is dw/dphi times the speed at which the contact point travels
along that surface: on the outer race that of the roller about the ring's centre, on the inner race that minus the
ring's, on a roller its speed of rolling. (The sliding speed is zero in rolling.) Equation (F1) of docs/form.md.

A recess is stored in cubic pieces with continuous slope, from values and slopes at their ends. A race has a whole
number of pieces in each of Z sectors. Evenly spaced rollers are at the same point of their pieces, whose
coefficients lie side by side.
"""

from math import floor, pi
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.jit import absent, generic, inlined
from bearingsim.core.parameters import kinematic_angles, lanes

# recess at the outer and inner contact of each roller, and its rate, for rollers at kinematic angles
RECESS_O, RECESS_V_O, RECESS_I, RECESS_V_I = lay.rows(
    lay.WORK + 9 * lay.ROW, "m, m/s, m, m/s", "ring rollers rest bent", "evaluation"
)
# with slip, at the outer and at the inner contact: recess of the race and its derivative with respect to the
# angle (first index of the coefficients and position in the piece); the same of the roller; rate of both
RACE_O, RACE_SLOPE_O, ROLLER_O, ROLLER_SLOPE_O, RATE_O, RACE_I, RACE_SLOPE_I, ROLLER_I, ROLLER_SLOPE_I, RATE_I = (
    lay.rows(lay.JACOBIAN_WORK + lay.FIRST_LANE, "m, m, m, m, m/s", "planar spatial", "evaluation", count=2)
)
FULL_TURN = 2.0 * pi
OUT_OF_REACH = 1.0  # m, recess at the padding lanes after the last roller: no contact closes there


@absent
class Smooth(NamedTuple):
    """Surface or bearing without deviations of form."""


class Race(NamedTuple):
    """Form of a race.

    pieces: (M, 4, 1 + Z + lanes), coefficients of 1, x, x^2, x^3 (m) in piece m of each sector, x from 0 to 1 on
    the piece; sector s is in columns s + 1, s + 1 + Z ..., and the last one in column 0, too. table: the same,
    flat. padding: (lanes,), ``OUT_OF_REACH`` in the lanes after the last roller, where the columns go on, else 0.
    """

    pieces: np.ndarray
    table: np.ndarray
    padding: np.ndarray


class WavyRollers(NamedTuple):
    """Form of rollers with waviness. pieces: (N, 4, lanes), coefficients (m) in piece n of each roller, N even;
    table: the same, flat."""

    pieces: np.ndarray
    table: np.ndarray


class UnequalRollers(NamedTuple):
    """Round rollers of unequal diameters. recess: (lanes,), half of a diameter below the nominal one (m)."""

    recess: np.ndarray


class Form(NamedTuple):
    """Forms of outer race, inner race (``Race``) and rollers, each ``Smooth`` if absent."""

    outer: Any
    inner: Any
    rollers: Any


@inlined
def fraction_of_turn(angle):
    """Return ``angle`` (rad) in turns, from 0 to below 1; 0 for an angle that is not finite."""
    turn = angle * (1.0 / FULL_TURN)
    turn = turn - floor(turn)
    return turn if 0.0 <= turn < 1.0 else 0.0


@inlined
def split(position, count):
    """Return the whole part of a ``position`` from 0 to ``count``, below ``count``, and the rest; both floats."""
    whole = min(floor(position), count - 1.0)
    return whole, position - whole


# rollers at kinematic angles


def clear_rows(race, angle, omega, Z, recess, rate, y, n):
    """Implement ``set_race`` of a smooth race."""
    for j in range(n):
        y[recess + j], y[rate + j] = 0.0, 0.0


@generic(inline="late", absent=clear_rows)
def set_race(race: Any, angle: float, omega: float, Z: int, recess: int, rate: int, y: np.ndarray, n: int) -> None:
    """Fill the rows ``recess`` and ``rate`` of ``n`` lanes with the recess of a race.

    angle: of roller 0 on the race (rad); omega: its rate (rad/s).
    """


@set_race.register(Race)
def _set_race(race, angle, omega, Z, recess, rate, y, n):
    per_sector = race.pieces.shape[0]
    # sector and piece are computed independently of each other, in parallel
    position, whole = angle * (Z * per_sector / FULL_TURN), floor(angle * (Z / FULL_TURN))
    sector_start = whole * per_sector
    m = min(max(floor(position) - sector_start, 0.0), per_sector - 1.0)
    x = position - sector_start - m
    column = int(whole - Z * floor((whole + 0.5) / Z)) + 1
    piece, padding, speed = race.pieces[int(m)], race.padding, omega * (Z * per_sector / FULL_TURN)
    c_0, c_1, c_2, c_3 = piece[0, column:], piece[1, column:], piece[2, column:], piece[3, column:]
    for j in range(n):
        y[recess + j] = padding[j] + (c_0[j] + x * (c_1[j] + x * (c_2[j] + x * c_3[j])))
        y[rate + j] = speed * (c_1[j] + x * (2.0 * c_2[j] + x * (3.0 * c_3[j])))


@generic(inline="late", absent=None)
def add_rollers(rollers: Any, angle: float, omega: float, recess: int, rate: int, y: np.ndarray, n: int) -> None:
    """Add the recess of the rollers, in contact at ``angle`` (rad) of their surface, to two rows."""


@add_rollers.register(WavyRollers)
def _add_wavy_rollers(rollers, angle, omega, recess, rate, y, n):
    count = rollers.pieces.shape[0]
    m, x = split(fraction_of_turn(angle) * count, count)
    piece, speed = rollers.pieces[int(m)], omega * (count / FULL_TURN)
    c_0, c_1, c_2, c_3 = piece[0], piece[1], piece[2], piece[3]
    for j in range(n):
        y[recess + j] += c_0[j] + x * (c_1[j] + x * (c_2[j] + x * c_3[j]))
        y[rate + j] += speed * (c_1[j] + x * (2.0 * c_2[j] + x * (3.0 * c_3[j])))


@add_rollers.register(UnequalRollers)
def _add_unequal_rollers(rollers, angle, omega, recess, rate, y, n):
    for j in range(n):
        y[recess + j] += rollers.recess[j]


@generic(inline="late", absent=None)
def fill_recesses(form: Any, bearing: Any, t: float, y: np.ndarray) -> None:
    """Fill the rows RECESS_O to RECESS_V_I at time ``t`` (s), for rollers that roll without slip."""


@fill_recesses.register(Form)
def _fill_recesses(form, bearing, t, y):
    theta_c, theta_i, roll = kinematic_angles(bearing, t)
    n, omega_c, omega_b = lanes(bearing), bearing.omega_c, bearing.omega_b
    set_race(form.outer, theta_c, omega_c, bearing.Z, RECESS_O, RECESS_V_O, y, n)
    set_race(form.inner, theta_c - theta_i, omega_c - bearing.omega_i, bearing.Z, RECESS_I, RECESS_V_I, y, n)
    add_rollers(form.rollers, roll, omega_b, RECESS_O, RECESS_V_O, y, n)
    add_rollers(form.rollers, roll + pi, omega_b, RECESS_I, RECESS_V_I, y, n)


@generic(inline="late", absent=0.0)
def recess(form: Any, row: int, y: np.ndarray, j: int) -> float:
    """Return the entry of roller ``j`` in one of the rows that ``fill_recesses`` fills."""


@recess.register(Form)
def _recess(form, row, y, j):
    return y[row + j]


# rollers with slip: the index in the table is computed in a vectorised loop, and the table read in a second one


@generic(inline="early")
def form_rows(side: Any) -> tuple[int, int, int, int, int]:
    """Return the rows of one side: recess and slope of the race, of the roller, and rate of both."""


@form_rows.register(OuterSide)
def _form_rows_outer(side):
    return RACE_O, RACE_SLOPE_O, ROLLER_O, ROLLER_SLOPE_O, RATE_O


@form_rows.register(InnerSide)
def _form_rows_inner(side):
    return RACE_I, RACE_SLOPE_I, ROLLER_I, ROLLER_SLOPE_I, RATE_I


@generic(inline="late")
def race_on(side: Any, form: Any) -> Any:
    """Return the form of the race on one side."""


@race_on.register(OuterSide)
def _race_on_outer_side(side, form):
    return form.outer


@race_on.register(InnerSide)
def _race_on_inner_side(side, form):
    return form.inner


@generic(inline="late", absent=None)
def locate_on_race(
    race: Any, angle: float, offset: float, Z: int, index: int, position: int, y: np.ndarray, j: int
) -> None:
    """Fill the rows ``index`` and ``position`` of roller ``j`` on a race.

    angle: of the middle of pocket 0 on the race (rad); offset: of the contact from the middle of its own pocket
    (rad), less than their spacing.
    """


@locate_on_race.register(Race)
def _locate_on_race(race, angle, offset, Z, index, position, y, j):
    per_sector, columns = race.pieces.shape[0], race.pieces.shape[2]
    sector, rest = split(fraction_of_turn(angle) * Z, Z)
    rest = rest + offset * (Z / FULL_TURN)
    shift = floor(rest)
    shift = shift if -1.0 <= shift <= 1.0 else 0.0
    rest = rest - shift
    rest = rest if 0.0 <= rest <= 1.0 else 0.0
    m, x = split(rest * per_sector, per_sector)
    y[index + j], y[position + j] = m * (4 * columns) + (sector + shift + (j + 1)), x


@generic(inline="late", absent=None)
def locate_on_roller(rollers: Any, angle: float, index: int, position: int, y: np.ndarray, j: int) -> None:
    """Fill the rows ``index`` and ``position`` of roller ``j``, in contact at ``angle`` (rad) of its surface."""


@locate_on_roller.register(WavyRollers)
def _locate_on_roller(rollers, angle, index, position, y, j):
    count, columns = rollers.pieces.shape[0], rollers.pieces.shape[2]
    m, x = split(fraction_of_turn(angle) * count, count)
    y[index + j], y[position + j] = m * (4 * columns) + j, x


@locate_on_roller.register(UnequalRollers)
def _locate_on_unequal_roller(rollers, angle, index, position, y, j):
    """Do nothing, because a round roller has the same radius at every angle."""


@generic(inline="late", absent=None)
def read_surface(surface: Any, Z: int, index: int, position: int, y: np.ndarray, n: int) -> None:
    """Replace the rows ``index`` and ``position`` by recess (m) and its derivative by the angle (m)."""


@read_surface.register(Race)
def _read_race(surface, Z, index, position, y, n):
    per_angle = Z * surface.pieces.shape[0] / FULL_TURN
    read_pieces(surface.table, surface.pieces.shape[2], per_angle, index, position, y, n)
    for j in range(n):
        y[index + j] += surface.padding[j]


@read_surface.register(WavyRollers)
def _read_wavy_rollers(surface, Z, index, position, y, n):
    per_angle = surface.pieces.shape[0] / FULL_TURN
    read_pieces(surface.table, surface.pieces.shape[2], per_angle, index, position, y, n)


@read_surface.register(UnequalRollers)
def _read_unequal_rollers(surface, Z, index, position, y, n):
    for j in range(n):
        y[index + j], y[position + j] = surface.recess[j], 0.0


@inlined
def read_pieces(table, columns, per_angle, index, position, y, n):
    """Implement ``read_surface`` for a flat table of pieces; per_angle: dx per rad."""
    for j in range(n):
        k, x = int(y[index + j]), y[position + j]
        c_0, c_1, c_2, c_3 = table[k], table[k + columns], table[k + 2 * columns], table[k + 3 * columns]
        y[index + j] = c_0 + x * (c_1 + x * (c_2 + x * c_3))
        y[position + j] = per_angle * (c_1 + x * (2.0 * c_2 + x * (3.0 * c_3)))


@generic(inline="late", absent=0.0)
def stored(surface: Any, row: int, y: np.ndarray, j: int) -> float:
    """Return the entry of roller ``j`` in a row that ``read_surface`` has filled."""


def _stored(surface, row, y, j):
    return y[row + j]


for surface_type in (Race, WavyRollers, UnequalRollers):
    stored.register(surface_type)(_stored)
