"""Exact path of a rigid round roller over any profile, and lookup tables of paths.

The roller's centre follows h(s) = min over t of p(t) + (t - s)^2/(2 R). With f(t) = R p(t) + t^2/2 this is (s^2/2
- f*(s))/R, where f* is the convex conjugate of f: the roller touches the lower convex hull of f, and the touched
position t never decreases as s increases. Of any two pieces of a profile the roller therefore touches the left one
up to some s and the right one beyond, and one pass over the pieces with a stack finds all that are touched (as in
the distance transform of Felzenszwalb and Huttenlocher, Theory of Computing 8, 2012, for single points). A piece
quadratic in t gives a parabola in s: h'' = 1/R at a corner, c/(1 + R c) on a piece of curvature c. Where the
contact moves between two pieces that do not adjoin, h has a cusp, at which its slope drops.
"""

from collections.abc import Sequence
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.profile import Profile
from bearingsim.core.jit import jit

RACE_EXTENT = 1.0  # m: extent of the race on either side
ROUNDING_DEPTH = 1e-15  # m: smaller depths are rounding errors
BINS_PER_PIECE, MAX_BINS = 2, 4096


class Path(NamedTuple):
    """Piecewise quadratic path: h = H + SLOPE x + HALF_CURVATURE x^2 with x = s - S, up to ``end`` (m); 0 outside.

    pieces: (n, 4), with the columns S (m), H (m), SLOPE (1), HALF_CURVATURE (1/m).
    """

    pieces: np.ndarray
    end: float


S, H, SLOPE, HALF_CURVATURE = range(4)  # columns of a path's pieces
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
    parts, previous_end = [], -RACE_EXTENT
    for t_0, t_1, p_0, m, c in profile.pieces.tolist():
        if t_0 > previous_end:
            parts.append(_make_part(previous_end, t_0, 0.0, 0.0, 0.0, R))
        if 1.0 + R * c > 1e-9:
            parts.append(_make_part(t_0, t_1, p_0, m, c, R))
        else:
            x = t_1 - t_0
            parts += [_make_corner(t_0, p_0), _make_corner(t_1, p_0 + x * (m + x * c / 2.0))]
        previous_end = t_1
    return np.array([*parts, _make_part(previous_end, RACE_EXTENT, 0.0, 0.0, 0.0, R)])


def _make_part(t_0: float, t_1: float, p: float, m: float, c: float, R: float) -> tuple[float, ...]:
    """Return the part from ``t_0`` to ``t_1`` (m) with depth (m), slope (1) and curvature (1/m) at its start."""
    x = t_1 - t_0
    return t_0, p, m, c, t_1, _without_rounding(p + x * (m + x * c / 2.0)), t_0 + R * m, t_1 + R * (m + c * x)


def _make_corner(t: float, p: float) -> tuple[float, ...]:
    """Return the part of one point, at which the roller's path is a parabola."""
    return t, _without_rounding(p), 0.0, 0.0, t, _without_rounding(p), t, t


def _without_rounding(p: float) -> float:
    """Return the depth ``p`` (m), 0 if it is only a rounding error."""
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
    """Return by how much h (m) over the left of two parts exceeds h over the right, and its slope (1).

    The excess never decreases with s.
    """
    h_1, slope_1 = drop_over_part(left, s, R)
    h_2, slope_2 = drop_over_part(right, s, R)
    return h_1 - h_2, slope_1 - slope_2


@jit
def crossover(left, right, R):
    """Return the s (m) beyond which the roller touches the right one of two parts;
    -inf: always, inf: never.

    It is the zero of the excess, which never decreases and is quadratic between the limits of contact.
    """
    previous = -inf
    min_high, max_low = min(left[HIGH], right[HIGH]), max(left[LOW], right[LOW])
    low, high = min(left[LOW], right[LOW]), max(left[HIGH], right[HIGH])
    for end in (low, min(min_high, max_low), max(min_high, max_low), high):
        difference, slope = excess(left, right, end, R)
        if difference >= 0.0:
            return crossover_within(left, right, previous, end, R)
        previous = end
    difference, slope = excess(left, right, previous, R)
    return previous - difference / slope if slope > 0.0 else inf


@jit
def crossover_within(left, right, low, high, R):
    """Return the zero (m) of the excess between ``low``, where it is negative, and ``high``, where it is not.

    Uses the parabola of the excess at ``high``.
    """
    difference, slope = excess(left, right, high, R)
    midpoint = max(0.5 * (low + high), high - RACE_EXTENT)
    curvature = part_curvature(left, midpoint, R) - part_curvature(right, midpoint, R)
    denominator = slope + sqrt(max(slope * slope - 2.0 * curvature * difference, 0.0))
    if difference == 0.0 or denominator == 0.0:
        return high if low > -inf or slope > 0.0 else -inf
    return max(high - 2.0 * difference / denominator, low)


@jit
def find_touched_parts(parts, R, touched):
    """Find the parts (n, 8) that the roller touches; return their number.

    Fills ``touched`` (2, n), a stack, with the index of each touched part and the s (m) where its contact begins.
    """
    touched[0, 0], touched[1, 0] = 0.0, -inf
    top = 0
    for n in range(1, len(parts)):
        start = crossover(parts[int(touched[0, top])], parts[n], R)
        while start <= touched[1, top] and top > 0:
            top -= 1
            start = crossover(parts[int(touched[0, top])], parts[n], R)
        if start < inf:
            top = top if start == -inf else top + 1
            touched[0, top], touched[1, top] = n, start
    return top + 1


def trace_path(profile: Profile, R: float) -> Path:
    """Return the exact path h(s) of a roller of reduced radius ``R`` (m) over a profile.

    Equation (M4) of docs/defects.md.
    """
    parts = touchable_parts(profile, R)
    stack = np.empty((2, len(parts)))
    count = find_touched_parts(parts, R, stack)
    touched, starts = parts[stack[0, :count].astype(int)], stack[1, :count].tolist()
    rows = [
        _make_path_row(part, s, R)
        for part, start, end in zip(touched, starts, [*starts[1:], inf], strict=True)
        for s in dict.fromkeys((start, part[LOW], part[HIGH]))
        if s == start or start < s < end
    ]
    begin, end_of_path = min(touched[0][HIGH], *starts[1:], RACE_EXTENT), max(touched[-1][LOW], starts[-1])
    path_rows = [row for row in rows if begin <= row[S] < end_of_path]
    return Path(np.array(path_rows), float(end_of_path)) if path_rows else FLAT


def _make_path_row(part: np.ndarray, s: float, R: float) -> tuple[float, float, float, float]:
    """Return the piece of a path that begins at ``s`` (m) with the contact on a part."""
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
    """Return h (m) and slope (1), (n, 2), at the end of each piece."""
    start, h, slope, half_curvature = path.pieces.T
    x = np.append(start[1:], path.end) - start
    return np.stack([h + x * (slope + x * half_curvature), slope + 2.0 * x * half_curvature], axis=1)


def max_slope(path: Path) -> float:
    """Return the largest absolute slope (1) of a path."""
    return float(max(np.abs(path.pieces[:, SLOPE]).max(), np.abs(piece_ends(path)[:, 1]).max()))


def find_cusp(path: Path) -> tuple[float, float]:
    """Return the position (m) of the sharpest cusp of a path, and the drop (1) of the slope there."""
    next_slopes = np.append(path.pieces[1:, SLOPE], 0.0)
    slope_drops = piece_ends(path)[:, 1] - next_slopes
    k = int(np.argmax(slope_drops))
    return float(np.append(path.pieces[1:, S], path.end)[k]), float(max(slope_drops[k], 0.0))


# Tables of paths: one after the other in a flat array, each with a head, bins and rows


PATH_START, PATH_END, BINS_PER_METRE, ROWS_OFFSET = range(4)  # entries of a head
HEAD_LENGTH, ROW_LENGTH = 4, 4  # entries


def pack_paths(paths: Sequence[Path]) -> tuple[np.ndarray, list[int]]:
    """Return the tables of all paths in one array (n,), and the offset at which each begins."""
    tables = [_make_table(path) for path in paths]
    offsets = np.cumsum([0, *(len(table) for table in tables)])
    return np.concatenate([np.zeros(0), *tables]), [int(offset) for offset in offsets[:-1]]


def _make_table(path: Path) -> np.ndarray:
    """Return head, bins and rows of a path. A bin contains the index of the piece at its start."""
    starts = path.pieces[:, S]
    begin, span = starts[0], path.end - starts[0]
    bins = int(min(max(BINS_PER_PIECE * len(starts), 8), MAX_BINS))
    pieces = np.searchsorted(starts, begin + np.arange(bins) / bins * span) - 1.0
    head = [begin, path.end, bins / span, HEAD_LENGTH + bins]
    return np.concatenate([head, np.maximum(pieces, 0.0), path.pieces.ravel(), [inf]])


@jit
def row_at(table, table_start, s):
    """Return the index in ``table`` of the row of the piece at ``s`` (m).

    table_start: offset of the path's table.
    """
    bin_of_s = int((s - table[table_start + PATH_START]) * table[table_start + BINS_PER_METRE])
    row = table_start + int(table[table_start + ROWS_OFFSET])
    row += ROW_LENGTH * int(
        table[table_start + HEAD_LENGTH + min(bin_of_s, int(table[table_start + ROWS_OFFSET]) - HEAD_LENGTH - 1)]
    )
    while s > table[row + ROW_LENGTH]:  # the last row is followed by infinity
        row += ROW_LENGTH
    return row


@jit
def drop_at(table, table_start, s):
    """Return h (m) and its slope (1) at ``s`` (m), on a cusp the slope before it.

    table_start: offset of the path's table.
    """
    # negated, so that NaN is outside, too
    if not table[table_start + PATH_START] <= s < table[table_start + PATH_END]:
        return 0.0, 0.0
    row = row_at(table, table_start, s)
    x = s - table[row + S]
    return table[row + H] + x * (table[row + SLOPE] + x * table[row + HALF_CURVATURE]), (
        table[row + SLOPE] + 2.0 * x * table[row + HALF_CURVATURE]
    )


@jit
def drop_curvature_at(table, table_start, s):
    """Return the second derivative (1/m) of h at ``s`` (m); see ``drop_at``."""
    if not table[table_start + PATH_START] <= s < table[table_start + PATH_END]:
        return 0.0
    return 2.0 * table[row_at(table, table_start, s) + HALF_CURVATURE]
