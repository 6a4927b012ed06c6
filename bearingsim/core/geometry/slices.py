"""Slices of a roller across its axis, and its profile.

A slice is a short disc with its centre at zeta (m) along the axis from the roller's centre. Its weight w is its
share of the roller's length, and its radius is reduced by the drop of the profile. Slices end where defects end
and have equal lengths in between. This is the midpoint rule, of second order for any load distribution at the
roller's ends (docs/spatial.md).
"""

from collections.abc import Callable, Iterable
from math import log
from typing import NamedTuple

import numpy as np

ZETA, WEIGHT, DROP = range(3)  # columns of ``Slices.table``
MAX_SLICES = 64  # per roller
DEFECT_DENSITY = 3.0  # density of slices over a defect relative to the rest


class Slices(NamedTuple):
    """Slices of a roller.

    table: (n, 3), zeta (m, ascending), weight (1; the sum is 1) and drop (m) of each slice.
    """

    table: np.ndarray


def slice_edges(L_w: float, defects: Iterable[tuple[float, float]], n: int) -> np.ndarray:
    """Return the ends (m, from the centre) of m >= ``n`` slices of a roller of length ``L_w`` (m), (m + 1,).

    defects: ends (m, m) of each along the roller. Every end of a defect is an end of a slice, so there can be more
    than ``n`` slices. Raises ValueError if there are more than ``MAX_SLICES``.
    """
    inside = [(max(a, -L_w / 2.0), min(b, L_w / 2.0)) for a, b in defects]
    edges = np.unique(np.round([-L_w / 2.0, L_w / 2.0, *(end for defect in inside for end in defect)], 12))
    centres, lengths = (edges[1:] + edges[:-1]) / 2.0, np.diff(edges)
    densities = [DEFECT_DENSITY if any(a < centre < b for a, b in inside) else 1.0 for centre in centres]
    target_counts = n * lengths * densities / np.sum(lengths * densities)
    counts = np.maximum(1, np.ceil(target_counts - 1e-9)).astype(int)
    if counts.sum() > MAX_SLICES:
        raise ValueError(f"{counts.sum()} slices, at most {MAX_SLICES}")
    parts = [np.linspace(a, b, m + 1)[:-1] for a, b, m in zip(edges[:-1], edges[1:], counts, strict=True)]
    return np.append(np.concatenate(parts), edges[-1])


def make_slices(ends: np.ndarray, drop: Callable[[float], float]) -> Slices:
    """Return the slices between ``ends`` (n + 1,), m, with the roller's ``drop`` (m) at their centres."""
    centres = (ends[1:] + ends[:-1]) / 2.0
    table = np.stack([centres, np.diff(ends) / (ends[-1] - ends[0]), [drop(float(z)) for z in centres]], axis=1)
    return Slices(np.ascontiguousarray(table))


def crowned_drop(z: float, L_w: float, straight: float, max_drop: float) -> float:
    """Return the drop (m) at ``z`` (m) from the centre of a roller with parabolic ends.

    The drop increases from 0 at the ends of the straight part, of length ``straight`` (m), to ``max_drop`` (m) at
    the ends of the roller, of length ``L_w`` (m).
    """
    x = max(abs(z) - straight / 2.0, 0.0) / (L_w / 2.0 - straight / 2.0) if straight < L_w else 0.0
    return max_drop * x * x


def logarithmic_drop(z: float, L_w: float, D_w: float) -> float:
    """Return the drop (m) at ``z`` (m) from the centre of ISO/TS 16281's logarithmic profile.

    0.00035 D_w ln[1/(1 - (2 z/L_w)^2)], for rollers of L_w <= 2.5 D_w (ISO/TS 16281:2008, 5.4; after Lundberg).
    """
    return 0.00035 * D_w * log(1.0 / (1.0 - (2.0 * z / L_w) ** 2))
