"""The profile of a pit along rolling, at one place across it: depth p(t), m, downwards, in quadratic pieces.

Outside its pieces, and between them, the profile is the race, p = 0. Pieces may meet with a step (a vertical wall)
or a corner. Straight lines and parabolas are exact; other curves are drawn by ``curve``.
"""

from typing import NamedTuple

import numpy as np

FROM, TO, P, M, C = range(5)  # columns of a piece: p = P + M (t - FROM) + C (t - FROM)^2/2
SLIVER = 1e-15  # m: ends nearer to each other are one


class Profile(NamedTuple):
    """pieces: (n, 5): from t to t (m); depth (m), slope (1) and curvature (1/m) at the beginning; in order."""

    pieces: np.ndarray


RACE = Profile(np.zeros((0, 5)))
"""The undamaged race."""


def quadratic(start: float, end: float, depth: float, slope: float = 0.0, curvature: float = 0.0) -> Profile:
    """A profile of one piece."""
    return Profile(np.array([[start, end, depth, slope, curvature]]))


def polygon(t: np.ndarray, p: np.ndarray) -> Profile:
    """Straight lines between the points (``t``, ``p``) (n,) in m; lines that lie in the race are left out."""
    pieces = np.stack([t[:-1], t[1:], p[:-1], np.diff(p) / np.diff(t), np.zeros(len(t) - 1)], axis=1)
    return Profile(pieces[(p[:-1] != 0.0) | (p[1:] != 0.0)])


def curve(t: np.ndarray, p: np.ndarray, slope: np.ndarray) -> Profile:
    """Two parabolas between neighbours of the points (``t``, ``p``) (n,) in m, without corners.

    They have the curve's ``slope`` (n,) at the points; an interval with a slope that is not finite is one straight
    line.
    """
    width, rise = np.diff(t), np.diff(p)
    bent = np.isfinite(slope[:-1]) & np.isfinite(slope[1:])
    first, last = np.where(bent, slope[:-1], rise / width), np.where(bent, slope[1:], rise / width)
    middle = 2.0 * rise / width - (first + last) / 2.0
    half = width / 2.0
    left = np.stack([t[:-1], t[:-1] + half, p[:-1], first, (middle - first) / half], axis=1)
    at_half = p[:-1] + half * (first + middle) / 2.0
    right = np.stack([t[:-1] + half, t[1:], at_half, middle, (last - middle) / half], axis=1)
    return Profile(np.stack([left, right], axis=1).reshape(-1, 5))


def shifted(profile: Profile, by: float) -> Profile:
    """The profile ``by`` (m) further along."""
    pieces = profile.pieces.copy()
    pieces[:, [FROM, TO]] += by
    return Profile(pieces)


def mirrored(profile: Profile) -> Profile:
    """The profile seen from the other side, p(-t)."""
    start, end, _, m, c = profile.pieces.T
    return Profile(np.stack([-end, -start, last_depths(profile), -(m + (end - start) * c), c], axis=1)[::-1])


def last_depths(profile: Profile) -> np.ndarray:
    """Depth (n,) m where each piece ends."""
    width = profile.pieces[:, TO] - profile.pieces[:, FROM]
    return profile.pieces[:, P] + width * (profile.pieces[:, M] + width * profile.pieces[:, C] / 2.0)


def relief(profile: Profile) -> float:
    """Height (m) from the highest to the lowest point of a profile and the race around it."""
    start, end, _, m, c = profile.pieces.T
    bottom = start + np.clip(-m / np.where(c == 0.0, 1.0, c), 0.0, end - start)
    x = np.where(c == 0.0, 0.0, bottom - start)
    extremes = profile.pieces[:, P] + x * (m + x * c / 2.0)
    return float(np.ptp(np.concatenate([[0.0], profile.pieces[:, P], last_depths(profile), extremes])))


def depth_at(profile: Profile, t: np.ndarray) -> np.ndarray:
    """Depth (m) at ``t`` (n,) m; on a step that of the piece that begins there."""
    pieces = profile.pieces
    if len(pieces) == 0:
        return np.zeros(len(t))
    k = np.maximum(np.searchsorted(pieces[:, FROM], t, side="right") - 1, 0)
    x = t - pieces[k, FROM]
    inside = (x >= 0.0) & (t < pieces[k, TO])
    return np.where(inside, pieces[k, P] + x * (pieces[k, M] + x * pieces[k, C] / 2.0), 0.0)


def deepest(first: Profile, second: Profile) -> Profile:
    """The deeper of two profiles at each place that both cover, and either where only one does."""
    if len(first.pieces) == 0 or len(second.pieces) == 0:
        return second if len(first.pieces) == 0 else first
    ends = _distinct(np.concatenate([first.pieces[:, :P].ravel(), second.pieces[:, :P].ravel()]))
    ends = _distinct(np.concatenate([ends, _crossings(first, second, ends)]))
    middles, starts = (ends[1:] + ends[:-1]) / 2.0, ends[:-1]
    a, b = _covering(first, middles), _covering(second, middles)
    depth_a, depth_b = _depth(first, a, middles), _depth(second, b, middles)
    chosen = [
        (*_from(source, k, start), number, k)
        for number, source, k, start in (
            (0, first, i, start) if depth_1 >= depth_2 else (1, second, j, start)
            for i, j, depth_1, depth_2, start in zip(a, b, depth_a, depth_b, starts, strict=True)
        )
    ]
    return _joined(chosen, ends)


def _distinct(ends: np.ndarray) -> np.ndarray:
    ordered = np.sort(ends)
    return ordered[np.append(True, np.diff(ordered) > SLIVER)]


def _covering(profile: Profile, t: np.ndarray) -> np.ndarray:
    """The piece at each ``t``, -1 for the race."""
    k = np.searchsorted(profile.pieces[:, FROM], t, side="right") - 1
    return np.where((k >= 0) & (t < profile.pieces[k, TO]), k, -1)


def _depth(profile: Profile, k: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Depth of the pieces ``k`` at ``t``, -inf for the race: so that a raised rim counts where nothing else is."""
    x = t - profile.pieces[k, FROM]
    p = profile.pieces[k, P] + x * (profile.pieces[k, M] + x * profile.pieces[k, C] / 2.0)
    return np.where(k >= 0, p, -np.inf)


def _from(profile: Profile, k: int, start: float) -> tuple[float, float, float]:
    """Depth, slope and curvature of a piece at ``start``."""
    if k < 0:
        return 0.0, 0.0, 0.0
    _, _, p, m, c = profile.pieces[k]
    x = start - profile.pieces[k, FROM]
    return p + x * (m + x * c / 2.0), m + x * c, c


def _crossings(first: Profile, second: Profile, ends: np.ndarray) -> np.ndarray:
    """Where two profiles are equally deep, between ``ends``."""
    middles = (ends[1:] + ends[:-1]) / 2.0
    a, b = _covering(first, middles), _covering(second, middles)
    found = []
    for i, j, low, high in zip(a, b, ends[:-1], ends[1:], strict=True):
        if i >= 0 and j >= 0:
            p, m, c = np.subtract(_from(first, i, low), _from(second, j, low))
            found += [low + x for x in _roots(p, m, c / 2.0) if 0.0 < x < high - low]
    return np.array(found)


def _roots(p: float, m: float, c: float) -> list[float]:
    """Real roots of p + m x + c x^2 where it changes sign."""
    inside = m * m - 4.0 * c * p
    if inside <= 0.0:
        return []
    q = -0.5 * (m + np.copysign(np.sqrt(inside), m))
    return [float(root) for root in ([q / c] if c != 0.0 else []) + ([p / q] if q != 0.0 else [])]


def _joined(chosen: list, ends: np.ndarray) -> Profile:
    """Pieces from (depth, slope, curvature, profile, piece) of each interval, those of one source in one."""
    rows: list = []
    last: tuple | None = None
    for (p, m, c, *source), start, end in zip(chosen, ends[:-1], ends[1:], strict=True):
        if source[1] >= 0 and source == last:
            rows[-1][TO] = end
        elif source[1] >= 0:
            rows.append([start, end, p, m, c])
        last = source if source[1] >= 0 else None
    return Profile(np.array(rows).reshape(-1, 5))
