"""The path of a round roller over any profile, exactly, and the tables it is looked up from.

The roller's centre feels h(s) = min over t of p(t) + (t - s)^2/(2 R). With f(t) = R p(t) + t^2/2 that is
(s^2/2 - f*(s))/R, f* being the convex conjugate of f: what the roller touches is the lower convex hull of f, and
the place t it touches never moves back while s grows. Hence of any two pieces of a profile the left one is felt
first, then the right one for good, and one pass over the pieces with a stack finds all that are felt (as in the
distance transform of Felzenszwalb and Huttenlocher, Theory of Computing 8, 2012, for single points). A piece that
is quadratic in t is felt as a parabola in s: h'' = 1/R at a corner, c/(1 + R c) on a piece of curvature c.

Where one piece takes over from another that it does not touch, h has a cusp: its slope falls.
"""

from collections.abc import Sequence
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.profile import SLIVER, Profile

FAR = 1.0  # m: so far the race goes on to either side
LEVEL = 1e-15  # m: nearer to the race a depth is rounding
BINS_PER_PIECE, MOST_BINS = 2, 4096


class Path(NamedTuple):
    """h in pieces: h = H + SLOPE x + HALF_BEND x^2 with x = s - S, up to ``end`` (m); 0 outside.

    pieces: (n, 4): S (m), H (m), SLOPE (1), HALF_BEND (1/m).
    """

    pieces: np.ndarray
    end: float


S, H, SLOPE, HALF_BEND = range(4)
FLAT = Path(np.zeros((0, 4)), 0.0)
"""The path over the undamaged race."""


class Part(NamedTuple):
    """A piece that the roller can touch: from (t, p) on with slope m and curvature c, to (t, p).

    While ``low`` < s < ``high`` (m) it is touched between its ends.
    """

    t_0: float
    p_0: float
    m: float
    c: float
    t_1: float
    p_1: float
    low: float
    high: float


def parts_of(profile: Profile, R: float) -> list[Part]:
    """What a roller of relative radius ``R`` (m) can touch, in order, with the race around it and in gaps.

    Of a piece more hollow than the roller that is its two ends.
    """
    found, last = [], -FAR
    for t_0, t_1, p_0, m, c in profile.pieces.tolist():
        if t_0 > last + SLIVER:
            found.append(_part(last, t_0, 0.0, 0.0, 0.0, R))
        if 1.0 + R * c > 1e-9:
            found.append(_part(t_0, t_1, p_0, m, c, R))
        else:
            x = t_1 - t_0
            found += [_corner(t_0, p_0), _corner(t_1, p_0 + x * (m + x * c / 2.0))]
        last = t_1
    return [*found, _part(last, FAR, 0.0, 0.0, 0.0, R)]


def _part(t_0: float, t_1: float, p: float, m: float, c: float, R: float) -> Part:
    x = t_1 - t_0
    return Part(t_0, p, m, c, t_1, _levelled(p + x * (m + x * c / 2.0)), t_0 + R * m, t_1 + R * (m + c * x))


def _corner(t: float, p: float) -> Part:
    return Part(t, _levelled(p), 0.0, 0.0, t, _levelled(p), t, t)


def _levelled(p: float) -> float:
    return p if abs(p) > LEVEL else 0.0


def over_part(part: Part, s: float, R: float) -> tuple[float, float]:
    """h (m) and its slope (1) at ``s`` (m) over one part alone."""
    if part.low < s < part.high:
        x = (s - part.t_0 - R * part.m) / (1.0 + R * part.c)
        away = s - part.t_0 - x
        return part.p_0 + x * (part.m + x * part.c / 2.0) + away * away / (2.0 * R), away / R
    t, p = (part.t_0, part.p_0) if s <= part.low else (part.t_1, part.p_1)
    return p + (s - t) * (s - t) / (2.0 * R), (s - t) / R


def bend(part: Part, s: float, R: float) -> float:
    """h'' (1/m) at ``s`` over one part alone."""
    return part.c / (1.0 + R * part.c) if part.low < s < part.high else 1.0 / R


def takeover(left: Part, right: Part, R: float) -> float:
    """From which s (m) on the right one of two parts is felt; -inf always, inf never.

    h over the left less h over the right never falls, and is quadratic between the ends of contact.
    """
    ends = sorted((left.low, left.high, right.low, right.high))
    before = -inf
    for end in ends:
        D, rate = _excess(left, right, end, R)
        if D >= 0.0:
            return _root(left, right, before, end, R)
        before = end
    D, rate = _excess(left, right, before, R)
    return before - D / rate if rate > 0.0 else inf


def _excess(left: Part, right: Part, s: float, R: float) -> tuple[float, float]:
    h_1, slope_1 = over_part(left, s, R)
    h_2, slope_2 = over_part(right, s, R)
    return h_1 - h_2, slope_1 - slope_2


def _root(left: Part, right: Part, low: float, high: float, R: float) -> float:
    """Where the excess, negative at ``low`` and no longer at ``high``, is zero: by its parabola at ``high``."""
    D, rate = _excess(left, right, high, R)
    middle = max(0.5 * (low + high), high - FAR)
    curvature = bend(left, middle, R) - bend(right, middle, R)
    below = rate + sqrt(max(rate * rate - 2.0 * curvature * D, 0.0))
    if D == 0.0 or below == 0.0:
        return high if low > -inf or rate > 0.0 else -inf
    return max(high - 2.0 * D / below, low)


def felt_parts(parts: Sequence[Part], R: float) -> list[tuple[float, Part]]:
    """The parts that are felt, each with the s (m) from which it is."""
    felt = [(-inf, parts[0])]
    for part in parts[1:]:
        start = takeover(felt[-1][1], part, R)
        while start <= felt[-1][0] and len(felt) > 1:
            felt.pop()
            start = takeover(felt[-1][1], part, R)
        if start == -inf:
            felt = [(-inf, part)]
        elif start < inf:
            felt.append((start, part))
    return felt


def path_over(profile: Profile, R: float) -> Path:
    """The path h(s) of a roller of relative radius ``R`` (m) over a profile, exact."""
    felt = felt_parts(parts_of(profile, R), R)
    starts = [start for start, _ in felt]
    rows = [
        _row(part, s, R)
        for (start, part), end in zip(felt, [*starts[1:], inf], strict=True)
        for s in dict.fromkeys((start, part.low, part.high))
        if s == start or start < s < end
    ]
    first, last = min(felt[0][1].high, *starts[1:], FAR), max(felt[-1][1].low, starts[-1])
    kept = [row for row in rows if first <= row[S] < last]
    return Path(np.array(kept), last) if kept else FLAT


def _row(part: Part, s: float, R: float) -> tuple[float, float, float, float]:
    """The piece of a path that begins at ``s`` (m) on a part."""
    h, slope = over_part(part, s, R) if s > -inf else (0.0, 0.0)
    touched = part.low <= s < part.high
    return s, h, slope, 0.5 * (part.c / (1.0 + R * part.c) if touched else 1.0 / R)


def sinking(path: Path, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """h (n,) m and its slope (n,) at ``s`` (n,) m: the slow way, for all at once."""
    if len(path.pieces) == 0:
        return np.zeros(len(s)), np.zeros(len(s))
    k = np.maximum(np.searchsorted(path.pieces[:, S], s) - 1, 0)
    start, h, slope, half = path.pieces[k].T
    x, inside = s - start, (s >= path.pieces[0, S]) & (s < path.end)
    return np.where(inside, h + x * (slope + x * half), 0.0), np.where(inside, slope + 2.0 * x * half, 0.0)


def ends_of(path: Path) -> np.ndarray:
    """h and slope (n, 2) where each piece ends."""
    start, h, slope, half = path.pieces.T
    x = np.append(start[1:], path.end) - start
    return np.stack([h + x * (slope + x * half), slope + 2.0 * x * half], axis=1)


def steepest(path: Path) -> float:
    """The steepest slope (1) of a path, up or down."""
    return float(max(np.abs(path.pieces[:, SLOPE]).max(), np.abs(ends_of(path)[:, 1]).max()))


def cusp(path: Path) -> tuple[float, float]:
    """Place (m) of the sharpest cusp of a path, and by how much its slope falls there (1)."""
    after = np.append(path.pieces[1:, SLOPE], 0.0)
    falls = ends_of(path)[:, 1] - after
    k = int(np.argmax(falls))
    return float(np.append(path.pieces[1:, S], path.end)[k]), float(max(falls[k], 0.0))


# Tables: paths one after the other in one array, each found from its place in it


FIRST, LAST, BINS_PER_METRE, ROWS = range(4)  # of a table's head; then the bins, then its rows
HEAD_OF_TABLE, ROW_OF_TABLE = 4, 4


def packed(paths: Sequence[Path]) -> tuple[np.ndarray, list[int]]:
    """All paths in one array (n,), and the place in it where each begins."""
    tables = [_table(path) for path in paths]
    places = np.cumsum([0, *(len(table) for table in tables)])
    return np.concatenate([np.zeros(0), *tables]), [int(place) for place in places[:-1]]


def _table(path: Path) -> np.ndarray:
    """Head, bins and rows of a path. A bin holds the number of the piece at its beginning."""
    starts = path.pieces[:, S]
    first, span = starts[0], path.end - starts[0]
    bins = int(min(max(BINS_PER_PIECE * len(starts), 8), MOST_BINS))
    pieces = np.searchsorted(starts, first + np.arange(bins) / bins * span) - 1.0
    head = [first, path.end, bins / span, HEAD_OF_TABLE + bins]
    return np.concatenate([head, np.maximum(pieces, 0.0), path.pieces.ravel(), [inf]])


@jit
def looked_up(table, at, s):
    """h (m) and its slope (1), on a cusp the left one, at ``s`` (m) over the path whose table begins at ``at``."""
    if s < table[at + FIRST] or s >= table[at + LAST]:
        return 0.0, 0.0
    bin_of_s = int((s - table[at + FIRST]) * table[at + BINS_PER_METRE])
    row = at + int(table[at + ROWS])
    row += ROW_OF_TABLE * int(table[at + HEAD_OF_TABLE + min(bin_of_s, int(table[at + ROWS]) - HEAD_OF_TABLE - 1)])
    while s > table[row + ROW_OF_TABLE]:  # the last row is followed by infinity
        row += ROW_OF_TABLE
    x = s - table[row + S]
    return table[row + H] + x * (table[row + SLOPE] + x * table[row + HALF_BEND]), (
        table[row + SLOPE] + 2.0 * x * table[row + HALF_BEND]
    )
