"""A random spall that grows bowl by bowl, along rolling and axially.

Material breaks out where rolling elements land, at the trailing rim, so each new bowl has its centre on this rim.
Its axial position is one of ``DRAWS`` positions drawn uniformly from the extent of the spall, the one at which the
rim lies least far along rolling, because a straight roller lands there first. Its half sizes and depth are drawn
uniformly from ``SIZES`` and ``DEPTHS``; the half sizes of the first bowl are 1. The spall thus grows along rolling
and becomes longer axially. A full-grown spall has ``BOWLS`` bowls and is scaled to its length, width and depth; a
less grown one lacks the later bowls, and its last bowl is smaller. These numbers are assumptions, not
measurements: docs/evidence/defects.md.
"""

from functools import lru_cache, reduce
from math import sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.depth import ROUGH_SECTION, extent, section, section_intervals
from bearingsim.core.defects.profile import RACE, Profile, make_piece, merge_profiles

BOWLS = 32  # bowls of a full-grown spall
SIZES = (0.6, 1.2)  # range of the half sizes of a bowl, relative to the first bowl
DEPTHS, FIRST_DEPTH = (0.5, 1.0), 0.7  # range of the depths, depth of the first bowl; scaled to the deepest bowl
DRAWS = 2  # axial positions that are compared for each bowl

Bowl = tuple[float, float, float, float, float]
"""Centre along rolling and axially, half size along rolling and axially, depth."""


class Spall(NamedTuple):
    """A spall.

    length, width, depth: axially, along rolling and into the material (m), full-grown; grown: stage of growth (0
    to 1); seed: of its random numbers.
    """

    length: float
    width: float
    depth: float
    grown: float
    seed: int


@lru_cache(maxsize=64)
def draw_bowls(seed: int) -> tuple[Bowl, ...]:
    """Return the bowls of a full-grown spall in order of formation, scaled to a box of unit sides.

    The box extends from -1/2 to 1/2 along rolling and axially, and has the depth 1.
    """
    rng = np.random.default_rng(seed)
    bowls: list[Bowl] = [(0.0, 0.0, 1.0, 1.0, FIRST_DEPTH)]
    for _ in range(BOWLS - 1):
        low, high = min(v - b for _, v, _, b, _ in bowls), max(v + b for _, v, _, b, _ in bowls)
        rims = [(trailing_rim(bowls, z), z) for z in rng.uniform(low, high, DRAWS).tolist()]
        a, b, d = rng.uniform(*SIZES), rng.uniform(*SIZES), rng.uniform(*DEPTHS)
        bowls.append((*min(rims), a, b, d))
    return _normalise(bowls)


def trailing_rim(bowls: list[Bowl], z: float) -> float:
    """Return the position along rolling of a spall's trailing rim at the axial position ``z``."""
    return max(u + a * sqrt(1.0 - ((z - v) / b) ** 2) for u, v, a, b, _ in bowls if abs(z - v) <= b)


def _normalise(bowls: list[Bowl]) -> tuple[Bowl, ...]:
    """Scale bowls to a box of unit sides (``draw_bowls``)."""
    u, v, a, b, d = np.array(bowls).T
    low_u, low_v = np.min(u - a), np.min(v - b)
    width, length, max_depth = np.max(u + a) - low_u, np.max(v + b) - low_v, np.max(d)
    box = np.stack(
        [(u - low_u) / width - 0.5, (v - low_v) / length - 0.5, a / width, b / length, d / max_depth], axis=1
    )
    return tuple(map(tuple, box.tolist()))


def grown_bowls(spall: Spall) -> list[Bowl]:
    """Return the bowls of a spall, in m, the last one partly grown."""
    all_bowls = draw_bowls(spall.seed)
    count = spall.grown * (len(all_bowls) - 1)
    bowls = []
    for n, (u, v, a, b, d) in enumerate(all_bowls):
        scale = min(count - n + 1.0, 1.0)
        if scale > 0.0:
            width, length = spall.width, spall.length
            bowls.append((u * width, v * length, scale * a * width, scale * b * length, scale * d * spall.depth))
    return bowls


@section.register(Spall)
def _section(spall: Spall, z: float) -> Profile:
    profiles = [RACE]
    for u, v, a, b, d in grown_bowls(spall):
        scale = 1.0 - ((z - v) / b) ** 2
        if scale > 0.0:
            half, curvature = a * sqrt(scale), 2.0 * d / (a * a)
            profiles.append(make_piece(u - half, u + half, 0.0, curvature * half, -curvature))
    return reduce(merge_profiles, profiles)


@extent.register(Spall)
def _extent(spall: Spall) -> tuple[float, float, float, float]:
    u, v, a, b, _ = np.array(grown_bowls(spall)).T
    return float(np.min(u - a)), float(np.max(u + a)), float(np.min(v - b)), float(np.max(v + b))


@section_intervals.register(Spall)
def _section_intervals(spall: Spall) -> list[tuple[float, float, int]]:
    _, _, low, high = extent(spall)
    return [(low, high, ROUGH_SECTION)]
