"""Profile of a defect along rolling at one axial position: a piecewise quadratic depth p(t) (m).

Depth is positive into the material. Outside and between its pieces the profile is the race, p = 0. Pieces may meet
with a step (a vertical wall) or a corner. Straight lines and parabolas are exact; ``fit_parabolas`` approximates
other curves.
"""

from typing import NamedTuple

import numpy as np

START, END, P, M, C = range(5)  # columns of a piece: p = P + M (t - START) + C (t - START)^2/2
MIN_SPACING = 1e-15  # m: ends closer than this are merged


class Profile(NamedTuple):
    """Pieces (n, 5) in order: start and end t (m); depth (m), slope (1) and curvature (1/m) at the start."""

    pieces: np.ndarray


RACE = Profile(np.zeros((0, 5)))
"""The undamaged race."""


def make_piece(start: float, end: float, depth: float, slope: float = 0.0, curvature: float = 0.0) -> Profile:
    """Return a profile of one piece."""
    return Profile(np.array([[start, end, depth, slope, curvature]]))


def make_polyline(t: np.ndarray, p: np.ndarray) -> Profile:
    """Return the profile of straight lines between the points (``t``, ``p``) (n,) in m, without lines on the
    race."""
    pieces = np.stack([t[:-1], t[1:], p[:-1], np.diff(p) / np.diff(t), np.zeros(len(t) - 1)], axis=1)
    return Profile(pieces[(p[:-1] != 0.0) | (p[1:] != 0.0)])


def fit_parabolas(t: np.ndarray, p: np.ndarray, slope: np.ndarray) -> Profile:
    """Return a smooth profile through the points (``t``, ``p``) (n,) in m, with two parabolas per interval.

    slope: (n,), the slopes (1) at the points; an interval with a non-finite slope at either end is a straight
    line.
    """
    width, rise = np.diff(t), np.diff(p)
    curved = np.isfinite(slope[:-1]) & np.isfinite(slope[1:])
    start_slope, end_slope = np.where(curved, slope[:-1], rise / width), np.where(curved, slope[1:], rise / width)
    centre_slope = 2.0 * rise / width - (start_slope + end_slope) / 2.0
    half = width / 2.0
    left = np.stack([t[:-1], t[:-1] + half, p[:-1], start_slope, (centre_slope - start_slope) / half], axis=1)
    centre_p = p[:-1] + half * (start_slope + centre_slope) / 2.0
    right = np.stack([t[:-1] + half, t[1:], centre_p, centre_slope, (end_slope - centre_slope) / half], axis=1)
    return Profile(np.stack([left, right], axis=1).reshape(-1, 5))


def shift_profile(profile: Profile, offset: float) -> Profile:
    """Return the profile moved by ``offset`` (m)."""
    pieces = profile.pieces.copy()
    pieces[:, [START, END]] += offset
    return Profile(pieces)


def mirror_profile(profile: Profile) -> Profile:
    """Return the profile mirrored, p(-t)."""
    start, end, _, m, c = profile.pieces.T
    return Profile(np.stack([-end, -start, end_depths(profile), -(m + (end - start) * c), c], axis=1)[::-1])


def separate_parts(profile: Profile) -> list[Profile]:
    """Return the parts of a profile that are separated by undamaged race."""
    gaps = profile.pieces[1:, START] - profile.pieces[:-1, END]
    return [Profile(part) for part in np.split(profile.pieces, np.flatnonzero(gaps > MIN_SPACING) + 1)]


def end_depths(profile: Profile) -> np.ndarray:
    """Return the depths (n,), m, at the ends of the pieces."""
    width = profile.pieces[:, END] - profile.pieces[:, START]
    return profile.pieces[:, P] + width * (profile.pieces[:, M] + width * profile.pieces[:, C] / 2.0)


def relief(profile: Profile) -> float:
    """Return the height (m) from the lowest to the highest point of a profile, the surrounding race included."""
    start, end, _, m, c = profile.pieces.T
    vertex = start + np.clip(-m / np.where(c == 0.0, 1.0, c), 0.0, end - start)
    x = np.where(c == 0.0, 0.0, vertex - start)
    extremes = profile.pieces[:, P] + x * (m + x * c / 2.0)
    return float(np.ptp(np.concatenate([[0.0], profile.pieces[:, P], end_depths(profile), extremes])))


def depth_at(profile: Profile, t: np.ndarray) -> np.ndarray:
    """Return the depth (n,), m, at ``t`` (n,), m; on a step the depth of the piece that begins there."""
    pieces = profile.pieces
    if len(pieces) == 0:
        return np.zeros(len(t))
    k = np.maximum(np.searchsorted(pieces[:, START], t, side="right") - 1, 0)
    x = t - pieces[k, START]
    inside = (x >= 0.0) & (t < pieces[k, END])
    return np.where(inside, pieces[k, P] + x * (pieces[k, M] + x * pieces[k, C] / 2.0), 0.0)


def merge_profiles(left: Profile, right: Profile) -> Profile:
    """Return the deeper of two profiles where both have a piece, elsewhere the one that has a piece."""
    if len(left.pieces) == 0 or len(right.pieces) == 0:
        return right if len(left.pieces) == 0 else left
    ends = _distinct_ends(np.concatenate([left.pieces[:, :P].ravel(), right.pieces[:, :P].ravel()]))
    ends = _distinct_ends(np.concatenate([ends, _crossings(left, right, ends)]))
    midpoints = (ends[1:] + ends[:-1]) / 2.0
    a, b = _piece_at(left, midpoints), _piece_at(right, midpoints)
    left_is_deeper = _values_at(left, a, midpoints)[:, 0] >= _values_at(right, b, midpoints)[:, 0]
    source = np.where(left_is_deeper, a, np.where(b >= 0, b + len(left.pieces), -1))
    rows = np.where(left_is_deeper[:, None], _values_at(left, a, ends[:-1]), _values_at(right, b, ends[:-1]))
    is_start = np.append(True, np.diff(source) != 0)
    piece_ends = np.append(ends[:-1][is_start][1:], ends[-1])
    pieces = np.column_stack([ends[:-1][is_start], piece_ends, rows[is_start]])
    return Profile(pieces[source[is_start] >= 0])


def _distinct_ends(ends: np.ndarray) -> np.ndarray:
    """Return the ends (m) in ascending order, only one of several that are closer than ``MIN_SPACING``."""
    ordered = np.sort(ends)
    return ordered[np.append(True, np.diff(ordered) > MIN_SPACING)]


def _piece_at(profile: Profile, t: np.ndarray) -> np.ndarray:
    """Return the index (n,) of the piece at each ``t`` (n,), m, -1 for the race."""
    k = np.searchsorted(profile.pieces[:, START], t, side="right") - 1
    return np.where((k >= 0) & (t < profile.pieces[k, END]), k, -1)


def _values_at(profile: Profile, k: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return depth, slope and curvature (n, 3) of the pieces ``k`` at ``t``; a depth of -inf for the race.

    With -inf, a raised rim is not replaced by the race where the other profile has no piece.
    """
    start, _, p, m, c = profile.pieces[k].T
    x = t - start
    return np.column_stack([np.where(k >= 0, p + x * (m + x * c / 2.0), -np.inf), m + x * c, c])


def _crossings(left: Profile, right: Profile, ends: np.ndarray) -> np.ndarray:
    """Return the positions (m) between ``ends`` at which two profiles have the same depth."""
    low, midpoints = ends[:-1], (ends[1:] + ends[:-1]) / 2.0
    a, b = _piece_at(left, midpoints), _piece_at(right, midpoints)
    overlap = (a >= 0) & (b >= 0)
    p, m, c = (_values_at(left, a[overlap], low[overlap]) - _values_at(right, b[overlap], low[overlap])).T
    with np.errstate(all="ignore"):  # no root, or not quadratic
        q = -0.5 * (m + np.copysign(np.sqrt(m * m - 2.0 * c * p), m))
        roots = np.concatenate([2.0 * q / c, p / q])
    lengths = np.tile(np.diff(ends)[overlap], 2)
    return np.asarray((np.tile(low[overlap], 2) + roots)[(roots > 0.0) & (roots < lengths)])
