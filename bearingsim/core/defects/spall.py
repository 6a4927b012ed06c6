"""A spall grown by a rule, bowl by bowl, along rolling and sideways.

Material breaks out where rolling elements land, at the trailing rim. Each new bowl therefore has its middle on
this rim. Of ``DRAWS`` positions across, drawn uniformly from the spall's extent, it is the one at which the rim is
nearest (a straight roller lands there first). Its half sizes and depth are drawn uniformly from ``SIZES`` and
``DEPTHS``; the first bowl's half sizes are 1. A spall thus grows along rolling and becomes wider. A full-grown
spall has ``BOWLS`` bowls and is scaled to its length, width and depth; a less grown one lacks the later bowls, and
its last bowl is smaller. The numbers are choices, not measurements: docs/evidence/defects.md.
"""

from functools import lru_cache, reduce
from math import sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.depth import ROUGH, cuts, extent, section
from bearingsim.core.defects.profile import RACE, Profile, deeper_profile, quadratic

BOWLS = 32  # bowls of a full-grown spall
SIZES = (0.6, 1.2)  # range of the half sizes of a bowl, relative to the first bowl
DEPTHS, FIRST_DEPTH = (0.5, 1.0), 0.7  # range of the depths, depth of the first bowl; scaled to the deepest one
DRAWS = 2  # positions across that are compared for each bowl

Bowl = tuple[float, float, float, float, float]
"""Middle along and across, half size along and across, depth."""


class Spall(NamedTuple):
    """A spall. length, width, depth: m, full-grown; grown: stage of growth (0 to 1); seed: of its random
    numbers."""

    length: float
    width: float
    depth: float
    grown: float
    seed: int


@lru_cache(maxsize=64)
def full_grown_bowls(seed: int) -> tuple[Bowl, ...]:
    """Return the bowls of a spall in order of formation, in a box from -1/2 to 1/2 along and across, 1 deep."""
    rng = np.random.default_rng(seed)
    bowls: list[Bowl] = [(0.0, 0.0, 1.0, 1.0, FIRST_DEPTH)]
    for _ in range(BOWLS - 1):
        low, high = min(v - b for _, v, _, b, _ in bowls), max(v + b for _, v, _, b, _ in bowls)
        rims = [(trailing_rim(bowls, across), across) for across in rng.uniform(low, high, DRAWS).tolist()]
        a, b, d = rng.uniform(*SIZES), rng.uniform(*SIZES), rng.uniform(*DEPTHS)
        bowls.append((*min(rims), a, b, d))
    return _normalise(bowls)


def trailing_rim(bowls: list[Bowl], across: float) -> float:
    """Return the trailing rim of a spall at one position across."""
    return max(u + a * sqrt(1.0 - ((across - v) / b) ** 2) for u, v, a, b, _ in bowls if abs(across - v) <= b)


def _normalise(bowls: list[Bowl]) -> tuple[Bowl, ...]:
    u, v, a, b, d = np.array(bowls).T
    low_u, low_v = np.min(u - a), np.min(v - b)
    along, across, max_depth = np.max(u + a) - low_u, np.max(v + b) - low_v, np.max(d)
    box = np.stack(
        [(u - low_u) / along - 0.5, (v - low_v) / across - 0.5, a / along, b / across, d / max_depth], axis=1
    )
    return tuple(map(tuple, box.tolist()))


def grown_bowls(spall: Spall) -> list[Bowl]:
    """Return the bowls of a spall in m, the last one partly grown."""
    all_bowls = full_grown_bowls(spall.seed)
    count = spall.grown * (len(all_bowls) - 1)
    bowls = []
    for n, (u, v, a, b, d) in enumerate(all_bowls):
        scale = min(count - n + 1.0, 1.0)
        if scale > 0.0:
            along, across = spall.width, spall.length
            bowls.append((u * along, v * across, scale * a * along, scale * b * across, scale * d * spall.depth))
    return bowls


@section.register(Spall)
def _section(spall: Spall, z: float) -> Profile:
    profiles = [RACE]
    for u, v, a, b, d in grown_bowls(spall):
        scale = 1.0 - ((z - v) / b) ** 2
        if scale > 0.0:
            half, curvature = a * sqrt(scale), 2.0 * d / (a * a)
            profiles.append(quadratic(u - half, u + half, 0.0, curvature * half, -curvature))
    return reduce(deeper_profile, profiles)


@extent.register(Spall)
def _extent(spall: Spall) -> tuple[float, float, float, float]:
    u, v, a, b, _ = np.array(grown_bowls(spall)).T
    return float(np.min(u - a)), float(np.max(u + a)), float(np.min(v - b)), float(np.max(v + b))


@cuts.register(Spall)
def _cuts(spall: Spall) -> list[tuple[float, float, int]]:
    _, _, low, high = extent(spall)
    return [(low, high, ROUGH)]
