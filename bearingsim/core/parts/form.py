"""Form of the surfaces: waviness of the races, and waviness and diameters of the rollers.

The recess of a surface is its depth (m) below the nominal one, so a contact's approach is smaller by the recesses
of race and roller at their common point. Its rate is dw/dphi times the speed at which the contact point travels
along that surface: on the outer race that of the roller about the ring's centre, on the inner race that minus the
ring's, on a roller its speed of rolling. (It is not the sliding speed, which is zero in pure rolling.) Equation
(F1) of docs/form.md.

A recess is stored in cubic pieces with continuous slope, from values and slopes at their ends. A race has a whole
number of pieces in each of Z sectors. Evenly spaced rollers are at the same point of their pieces, so the
coefficients of these pieces are stored next to each other.
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
# with slip, at the outer and at the inner contact: recess of the race and its derivative with respect to the angle
# (before ``read_surface`` replaces them: index of the first coefficient, and position in the piece); the same for
# the roller; rate of both recesses
RACE_O, RACE_SLOPE_O, ROLLER_O, ROLLER_SLOPE_O, RATE_O, RACE_I, RACE_SLOPE_I, ROLLER_I, ROLLER_SLOPE_I, RATE_I = (
    lay.rows(lay.JACOBIAN_WORK + lay.FIRST_LANE, "m, m, m, m, m/s", "planar spatial", "evaluation", count=2)
)
REVOLUTION = 2.0 * pi  # rad
PADDING_RECESS = 1.0  # m, recess in padded lanes, where no contact may close


@absent
class Smooth(NamedTuple):
    """Surface or bearing without deviations of form."""


class Race(NamedTuple):
    """Form of a race.

    pieces: (M, 4, 1 + Z + lanes), coefficients of 1, x, x^2, x^3 (m) in piece m of each sector, x from 0 to 1 on
    the piece; sector s is in columns s + 1, s + 1 + Z ..., and the last one also in column 0. table: the same,
    flat. padding: (lanes,), ``PADDING_RECESS`` in padded lanes, whose columns contain further sectors, else 0.
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
def fraction_of_revolution(angle):
    """Return ``angle`` (rad) as a fraction of a revolution, from 0 to below 1; 0 for an angle that is not
    finite."""
    revolutions = angle * (1.0 / REVOLUTION)
    fraction = revolutions - floor(revolutions)
    return fraction if 0.0 <= fraction < 1.0 else 0.0


@inlined
def split_position(position, count):
    """Return the integer part of ``position`` (0 to ``count``), at most ``count`` - 1, and the rest, as floats."""
    whole = min(floor(position), count - 1.0)
    return whole, position - whole


# rollers at kinematic angles


def clear_recesses(race, angle, omega, Z, recess, rate, y, n):
    """Implement ``fill_race_recesses`` of a smooth race."""
    for j in range(n):
        y[recess + j], y[rate + j] = 0.0, 0.0


@generic(inline="late", absent=clear_recesses)
def fill_race_recesses(
    race: Any, angle: float, omega: float, Z: int, recess: int, rate: int, y: np.ndarray, n: int
) -> None:
    """Fill the rows ``recess`` and ``rate`` of ``n`` lanes with the recess of a race.

    angle: position of roller 0 on the race (rad); omega: its rate (rad/s).
    """


@fill_race_recesses.register(Race)
def _fill_race_recesses(race, angle, omega, Z, recess, rate, y, n):
    per_sector = race.pieces.shape[0]
    # sector and piece are computed independently, so that the processor computes both at the same time
    position, sector = angle * (Z * per_sector / REVOLUTION), floor(angle * (Z / REVOLUTION))
    sector_start = sector * per_sector
    m = min(max(floor(position) - sector_start, 0.0), per_sector - 1.0)
    x = position - sector_start - m
    column = int(sector - Z * floor((sector + 0.5) / Z)) + 1
    piece, padding, speed = race.pieces[int(m)], race.padding, omega * (Z * per_sector / REVOLUTION)
    c_0, c_1, c_2, c_3 = piece[0, column:], piece[1, column:], piece[2, column:], piece[3, column:]
    for j in range(n):
        y[recess + j] = padding[j] + (c_0[j] + x * (c_1[j] + x * (c_2[j] + x * c_3[j])))
        y[rate + j] = speed * (c_1[j] + x * (2.0 * c_2[j] + x * (3.0 * c_3[j])))


@generic(inline="late", absent=None)
def add_roller_recesses(
    rollers: Any, angle: float, omega: float, recess: int, rate: int, y: np.ndarray, n: int
) -> None:
    """Add the recess of the rollers, in contact at ``angle`` (rad) of their surface, to two rows."""


@add_roller_recesses.register(WavyRollers)
def _add_wavy_roller_recesses(rollers, angle, omega, recess, rate, y, n):
    count = rollers.pieces.shape[0]
    m, x = split_position(fraction_of_revolution(angle) * count, count)
    piece, speed = rollers.pieces[int(m)], omega * (count / REVOLUTION)
    c_0, c_1, c_2, c_3 = piece[0], piece[1], piece[2], piece[3]
    for j in range(n):
        y[recess + j] += c_0[j] + x * (c_1[j] + x * (c_2[j] + x * c_3[j]))
        y[rate + j] += speed * (c_1[j] + x * (2.0 * c_2[j] + x * (3.0 * c_3[j])))


@add_roller_recesses.register(UnequalRollers)
def _add_unequal_roller_recesses(rollers, angle, omega, recess, rate, y, n):
    for j in range(n):
        y[recess + j] += rollers.recess[j]


@generic(inline="late", absent=None)
def fill_recesses(form: Any, bearing: Any, t: float, y: np.ndarray) -> None:
    """Fill the rows RECESS_O to RECESS_V_I at time ``t`` (s), for rollers that roll without slip."""


@fill_recesses.register(Form)
def _fill_recesses(form, bearing, t, y):
    theta_c, theta_i, roll = kinematic_angles(bearing, t)
    n, omega_c, omega_b = lanes(bearing), bearing.omega_c, bearing.omega_b
    fill_race_recesses(form.outer, theta_c, omega_c, bearing.Z, RECESS_O, RECESS_V_O, y, n)
    fill_race_recesses(
        form.inner, theta_c - theta_i, omega_c - bearing.omega_i, bearing.Z, RECESS_I, RECESS_V_I, y, n
    )
    add_roller_recesses(form.rollers, roll, omega_b, RECESS_O, RECESS_V_O, y, n)
    add_roller_recesses(form.rollers, roll + pi, omega_b, RECESS_I, RECESS_V_I, y, n)


@generic(inline="late", absent=0.0)
def recess(form: Any, row: int, y: np.ndarray, j: int) -> float:
    """Return the recess or rate of roller ``j`` in a row that ``fill_recesses`` fills; 0 for smooth surfaces."""


@recess.register(Form)
def _recess(form, row, y, j):
    return y[row + j]


# rollers with slip: a vectorised loop computes the indices in the table, a second loop reads the table


@generic(inline="early")
def form_rows(side: Any) -> tuple[int, int, int, int, int]:
    """Return the rows of one side: recess and slope of the race, the same of the roller, and the rate of both
    recesses."""


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

    angle: position of the centre of pocket 0 on the race (rad); offset: angle (rad) of the contact from the centre
    of its own pocket, less than the roller spacing.
    """


@locate_on_race.register(Race)
def _locate_on_race(race, angle, offset, Z, index, position, y, j):
    per_sector, columns = race.pieces.shape[0], race.pieces.shape[2]
    sector, rest = split_position(fraction_of_revolution(angle) * Z, Z)
    rest = rest + offset * (Z / REVOLUTION)
    shift = floor(rest)
    shift = shift if -1.0 <= shift <= 1.0 else 0.0
    rest = rest - shift
    rest = rest if 0.0 <= rest <= 1.0 else 0.0
    m, x = split_position(rest * per_sector, per_sector)
    y[index + j], y[position + j] = m * (4 * columns) + (sector + shift + (j + 1)), x


@generic(inline="late", absent=None)
def locate_on_roller(rollers: Any, angle: float, index: int, position: int, y: np.ndarray, j: int) -> None:
    """Fill the rows ``index`` and ``position`` of roller ``j``, in contact at ``angle`` (rad) of its surface."""


@locate_on_roller.register(WavyRollers)
def _locate_on_roller(rollers, angle, index, position, y, j):
    count, columns = rollers.pieces.shape[0], rollers.pieces.shape[2]
    m, x = split_position(fraction_of_revolution(angle) * count, count)
    y[index + j], y[position + j] = m * (4 * columns) + j, x


@locate_on_roller.register(UnequalRollers)
def _locate_on_unequal_roller(rollers, angle, index, position, y, j):
    """Do nothing, because a round roller has the same radius at every angle."""


@generic(inline="late", absent=None)
def read_surface(surface: Any, Z: int, index: int, position: int, y: np.ndarray, n: int) -> None:
    """Replace the rows ``index`` and ``position`` by the recess (m) and its derivative with respect to the angle
    (m)."""


@read_surface.register(Race)
def _read_race(surface, Z, index, position, y, n):
    per_angle = Z * surface.pieces.shape[0] / REVOLUTION
    read_pieces(surface.table, surface.pieces.shape[2], per_angle, index, position, y, n)
    for j in range(n):
        y[index + j] += surface.padding[j]


@read_surface.register(WavyRollers)
def _read_wavy_rollers(surface, Z, index, position, y, n):
    per_angle = surface.pieces.shape[0] / REVOLUTION
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
def surface_entry(surface: Any, row: int, y: np.ndarray, j: int) -> float:
    """Return the entry of roller ``j`` in a row that ``read_surface`` fills; 0 for a smooth surface."""


def _surface_entry(surface, row, y, j):
    return y[row + j]


for surface_type in (Race, WavyRollers, UnequalRollers):
    surface_entry.register(surface_type)(_surface_entry)
