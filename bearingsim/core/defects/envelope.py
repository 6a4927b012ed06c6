"""Exact path of a rigid round roller over any profile, and lookup tables of such paths.

The roller's centre follows h(s) = min over t of p(t) + (t - s)^2/(2 R). With f(t) = R p(t) + t^2/2 this is
(s^2/2 - f*(s))/R, where f* is the convex conjugate of f: the roller touches the lower convex hull of f, and the
touched position t never decreases as s increases. Hence of any two pieces of a profile the left one is touched
first, then the right one for all larger s, and one pass over the pieces with a stack finds all that are touched
(as in the distance transform of Felzenszwalb and Huttenlocher, Theory of Computing 8, 2012, for single points). A
piece quadratic in t gives a parabola in s: h'' = 1/R at a corner, c/(1 + R c) on a piece of curvature c.

Where contact passes between two pieces that do not adjoin, h has a cusp, at which its slope drops.
"""

from collections.abc import Sequence
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.profile import Profile
from bearingsim.core.jit import jit

RACE_REACH = 1.0  # m: extent of the race on either side
ROUNDING_DEPTH = 1e-15  # m: smaller depths are rounding errors
BINS_PER_PIECE, MAX_BINS = 2, 4096


class Path(NamedTuple):
    """h in pieces: h = H + SLOPE x + HALF_CURVATURE x^2 with x = s - S, up to ``end`` (m); 0 outside.

    pieces: (n, 4): S (m), H (m), SLOPE (1), HALF_CURVATURE (1/m).
    """

    pieces: np.ndarray
    end: float


S, H, SLOPE, HALF_CURVATURE = range(4)
FLAT = Path(np.zeros((0, 4)), 0.0)
"""The path over the undamaged race."""


T_0, P_0, SLOPE_0, CURVATURE, T_1, P_1, LOW, HIGH = range(8)
"""Columns of a part, a piece that the roller can touch: start (t, p), slope and curvature there, end (t, p).

For s between LOW and HIGH (m) the roller touches it between its ends.
"""


def touchable_parts(profile: Profile, R: float) -> np.ndarray:
    """Return the parts (n, 8) that a roller of reduced radius ``R`` (m) can touch, in order, including the
    surrounding race.

    A piece more concave than the roller contributes only its two ends.
    """
    parts, last = [], -RACE_REACH
    for t_0, t_1, p_0, m, c in profile.pieces.tolist():
        if t_0 > last:
            parts.append(_part(last, t_0, 0.0, 0.0, 0.0, R))
        if 1.0 + R * c > 1e-9:
            parts.append(_part(t_0, t_1, p_0, m, c, R))
        else:
            x = t_1 - t_0
            parts += [_corner(t_0, p_0), _corner(t_1, p_0 + x * (m + x * c / 2.0))]
        last = t_1
    return np.array([*parts, _part(last, RACE_REACH, 0.0, 0.0, 0.0, R)])


def _part(t_0: float, t_1: float, p: float, m: float, c: float, R: float) -> tuple[float, ...]:
    x = t_1 - t_0
    return t_0, p, m, c, t_1, _without_rounding(p + x * (m + x * c / 2.0)), t_0 + R * m, t_1 + R * (m + c * x)


def _corner(t: float, p: float) -> tuple[float, ...]:
    return t, _without_rounding(p), 0.0, 0.0, t, _without_rounding(p), t, t


def _without_rounding(p: float) -> float:
    return p if abs(p) > ROUNDING_DEPTH else 0.0


@jit
def drop_over_part(part, s, R):
    """Return h (m) and its slope (1) at ``s`` (m) over one part alone."""
    if part[LOW] < s < part[HIGH]:
        x = (s - part[T_0] - R * part[SLOPE_0]) / (1.0 + R * part[CURVATURE])
        distance = s - part[T_0] - x
        return part[P_0] + x * (part[SLOPE_0] + x * part[CURVATURE] / 2.0) + distance * distance / (
            2.0 * R
        ), distance / R
    t, p = (part[T_0], part[P_0]) if s <= part[LOW] else (part[T_1], part[P_1])
    return p + (s - t) * (s - t) / (2.0 * R), (s - t) / R


@jit
def part_curvature(part, s, R):
    """Return h'' (1/m) just after ``s`` over one part alone."""
    return part[CURVATURE] / (1.0 + R * part[CURVATURE]) if part[LOW] <= s < part[HIGH] else 1.0 / R


@jit
def excess(left, right, s, R):
    """Return h (m) over the left of two parts less h over the right, and its slope.

    The excess never decreases with s.
    """
    h_1, slope_1 = drop_over_part(left, s, R)
    h_2, slope_2 = drop_over_part(right, s, R)
    return h_1 - h_2, slope_1 - slope_2


@jit
def takeover(left, right, R):
    """Return the s (m) beyond which the right one of two parts is touched; -inf: always, inf: never.

    The excess never decreases, and is quadratic between the limits of contact.
    """
    previous = -inf
    min_high, max_low = min(left[HIGH], right[HIGH]), max(left[LOW], right[LOW])
    low, high = min(left[LOW], right[LOW]), max(left[HIGH], right[HIGH])
    for end in (low, min(min_high, max_low), max(min_high, max_low), high):
        D, rate = excess(left, right, end, R)
        if D >= 0.0:
            return root(left, right, previous, end, R)
        previous = end
    D, rate = excess(left, right, previous, R)
    return previous - D / rate if rate > 0.0 else inf


@jit
def root(left, right, low, high, R):
    """Return the zero of the excess, negative at ``low`` and not at ``high``, from its parabola at ``high``."""
    D, rate = excess(left, right, high, R)
    middle = max(0.5 * (low + high), high - RACE_REACH)
    curvature = part_curvature(left, middle, R) - part_curvature(right, middle, R)
    denominator = rate + sqrt(max(rate * rate - 2.0 * curvature * D, 0.0))
    if D == 0.0 or denominator == 0.0:
        return high if low > -inf or rate > 0.0 else -inf
    return max(high - 2.0 * D / denominator, low)


@jit
def touched_parts(parts, R, touched):
    """Fill ``touched`` (2, n) with the indices of the parts (n, 8) that the roller touches and the s (m) where
    each begins.

    Returns the number of columns used.
    """
    touched[0, 0], touched[1, 0] = 0.0, -inf
    last = 0
    for n in range(1, len(parts)):
        start = takeover(parts[int(touched[0, last])], parts[n], R)
        while start <= touched[1, last] and last > 0:
            last -= 1
            start = takeover(parts[int(touched[0, last])], parts[n], R)
        if start < inf:
            last = last if start == -inf else last + 1
            touched[0, last], touched[1, last] = n, start
    return last + 1


def path_over(profile: Profile, R: float) -> Path:
    """Return the path h(s) of a roller of reduced radius ``R`` (m) over a profile, exact.

    Equation (M4) of docs/defects.md.
    """
    parts = touchable_parts(profile, R)
    pieces = np.empty((2, len(parts)))
    count = touched_parts(parts, R, pieces)
    touched, starts = parts[pieces[0, :count].astype(int)], pieces[1, :count].tolist()
    rows = [
        _row(part, s, R)
        for part, start, end in zip(touched, starts, [*starts[1:], inf], strict=True)
        for s in dict.fromkeys((start, part[LOW], part[HIGH]))
        if s == start or start < s < end
    ]
    begin, end_of_path = min(touched[0][HIGH], *starts[1:], RACE_REACH), max(touched[-1][LOW], starts[-1])
    path_rows = [row for row in rows if begin <= row[S] < end_of_path]
    return Path(np.array(path_rows), float(end_of_path)) if path_rows else FLAT


def _row(part: np.ndarray, s: float, R: float) -> tuple[float, float, float, float]:
    """Return the piece of a path that begins at ``s`` (m) on a part."""
    h, slope = drop_over_part(part, s, R) if s > -inf else (0.0, 0.0)
    return s, h, slope, 0.5 * part_curvature(part, s, R)


def path_drop(path: Path, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return h (n,) m and its slope (n,) at ``s`` (n,) m; ``drop_at`` is the compiled form for one s."""
    if len(path.pieces) == 0:
        return np.zeros(len(s)), np.zeros(len(s))
    k = np.maximum(np.searchsorted(path.pieces[:, S], s) - 1, 0)
    start, h, slope, half_curvature = path.pieces[k].T
    x, inside = s - start, (s >= path.pieces[0, S]) & (s < path.end)
    return np.where(inside, h + x * (slope + x * half_curvature), 0.0), np.where(
        inside, slope + 2.0 * x * half_curvature, 0.0
    )


def piece_ends(path: Path) -> np.ndarray:
    """Return h and slope (n, 2) at the end of each piece."""
    start, h, slope, half_curvature = path.pieces.T
    x = np.append(start[1:], path.end) - start
    return np.stack([h + x * (slope + x * half_curvature), slope + 2.0 * x * half_curvature], axis=1)


def steepest(path: Path) -> float:
    """Return the steepest slope (1) of a path, up or down."""
    return float(max(np.abs(path.pieces[:, SLOPE]).max(), np.abs(piece_ends(path)[:, 1]).max()))


def cusp(path: Path) -> tuple[float, float]:
    """Return the position (m) of the sharpest cusp of a path, and by how much its slope falls there (1)."""
    next_slopes = np.append(path.pieces[1:, SLOPE], 0.0)
    slope_drops = piece_ends(path)[:, 1] - next_slopes
    k = int(np.argmax(slope_drops))
    return float(np.append(path.pieces[1:, S], path.end)[k]), float(max(slope_drops[k], 0.0))


# Tables: paths one after the other in one array, each addressed by its offset


FIRST, LAST, BINS_PER_METRE, ROWS = range(4)  # of a table's head; then the bins, then its rows
HEAD_OF_TABLE, ROW_OF_TABLE = 4, 4


def pack_paths(paths: Sequence[Path]) -> tuple[np.ndarray, list[int]]:
    """Return all paths in one array (n,), and the offset at which each begins."""
    tables = [_table(path) for path in paths]
    offsets = np.cumsum([0, *(len(table) for table in tables)])
    return np.concatenate([np.zeros(0), *tables]), [int(offset) for offset in offsets[:-1]]


def _table(path: Path) -> np.ndarray:
    """Return head, bins and rows of a path. A bin contains the number of the piece at its beginning."""
    starts = path.pieces[:, S]
    begin, span = starts[0], path.end - starts[0]
    bins = int(min(max(BINS_PER_PIECE * len(starts), 8), MAX_BINS))
    pieces = np.searchsorted(starts, begin + np.arange(bins) / bins * span) - 1.0
    head = [begin, path.end, bins / span, HEAD_OF_TABLE + bins]
    return np.concatenate([head, np.maximum(pieces, 0.0), path.pieces.ravel(), [inf]])


@jit
def row_at(table, table_start, s):
    """Return the start of the row of the piece at ``s`` (m), of the path whose table begins at ``table_start``."""
    bin_of_s = int((s - table[table_start + FIRST]) * table[table_start + BINS_PER_METRE])
    row = table_start + int(table[table_start + ROWS])
    row += ROW_OF_TABLE * int(
        table[table_start + HEAD_OF_TABLE + min(bin_of_s, int(table[table_start + ROWS]) - HEAD_OF_TABLE - 1)]
    )
    while s > table[row + ROW_OF_TABLE]:  # the last row is followed by infinity
        row += ROW_OF_TABLE
    return row


@jit
def drop_at(table, table_start, s):
    """Return h (m) and its slope (1), the left one on a cusp, at ``s`` (m) of the path whose table begins at
    ``table_start``."""
    if not table[table_start + FIRST] <= s < table[table_start + LAST]:  # written so that NaN is outside, too
        return 0.0, 0.0
    row = row_at(table, table_start, s)
    x = s - table[row + S]
    return table[row + H] + x * (table[row + SLOPE] + x * table[row + HALF_CURVATURE]), (
        table[row + SLOPE] + 2.0 * x * table[row + HALF_CURVATURE]
    )


@jit
def drop_curvature_at(table, table_start, s):
    """Return the second derivative of h along ``s`` (1/m)."""
    if not table[table_start + FIRST] <= s < table[table_start + LAST]:
        return 0.0
    return 2.0 * table[row_at(table, table_start, s) + HALF_CURVATURE]
