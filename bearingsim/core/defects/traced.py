"""Conversion of depth maps for the core: slices of a defect along the roller, their paths, and the table of
paths."""

from collections.abc import Sequence
from functools import lru_cache
from math import ceil
from typing import Any

import numpy as np

from bearingsim.core.defects.closed_forms import NO_DEFECT
from bearingsim.core.defects.depth import (
    EVEN,
    SMOOTH,
    MergedDefects,
    ScannedDefect,
    ShiftedDefect,
    cuts,
    extent,
    section,
)
from bearingsim.core.defects.envelope import FLAT, Path, cusp, pack_paths, path_over, steepest
from bearingsim.core.defects.excitations import TracedPath
from bearingsim.core.defects.pairs import KAPPA, Defects, RollerDefectPair, pack_defects
from bearingsim.core.defects.profile import Profile, relief

PIECE_RESOLUTION = np.array([1e-12, 1e-18, 1e-12, 1e-6])  # m, m, 1, 1/m: resolution in comparing pieces of paths
RollerSlice = tuple[float, float]
"""Weight (1) and middle z (m, from the roller's) of a slice of a roller."""


def cut_along_roller(defect: Any, L_w: float, nodes: int) -> list[RollerSlice]:
    """Return the slices of a roller of length ``L_w`` (m) over a defect, their weights summing to its share of the
    roller.

    An interval of constant section has one slice. An interval of smoothly varying section has Gauss nodes,
    ``nodes`` on the longest interval and in proportion on others. One of rough section has as many slices of equal
    length.
    """
    intervals = [(max(a, -L_w / 2.0), min(b, L_w / 2.0), kind) for a, b, kind in cuts(defect)]
    intervals = [(a, b, kind) for a, b, kind in intervals if b > a]
    longest = max((b - a for a, b, _ in intervals), default=0.0)
    return [
        ((b - a) / L_w * float(weight) / 2.0, (a + b) / 2.0 + (b - a) / 2.0 * float(x))
        for a, b, kind in intervals
        for x, weight in zip(*_quadrature(kind, max(1, ceil(nodes * (b - a) / longest - 1e-9))), strict=True)
    ]


def _quadrature(kind: int, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes in (-1, 1) and weights (sum 2) of a quadrature."""
    if kind == EVEN:
        return np.zeros(1), np.full(1, 2.0)
    if kind == SMOOTH:
        return np.polynomial.legendre.leggauss(nodes)
    return (2.0 * np.arange(nodes) + 1.0) / nodes - 1.0, np.full(nodes, 2.0 / nodes)


TracedGroup = tuple[tuple[float, ...], Path]
"""Group without its weight (b, x_e, 0, depth), and its path."""


def paths_over(defect: Any, R: float, positions: Sequence[float] | np.ndarray) -> tuple[TracedGroup, ...]:
    """Return the roller path over a defect at each z (m) of ``positions``, cached."""
    return _paths_over(defect, repr(defect), R, tuple(float(z) for z in positions))


@lru_cache(maxsize=256)
def _paths_over(defect: Any, shape_key: str, R: float, positions: tuple[float, ...]) -> tuple[TracedGroup, ...]:
    """Cache ``paths_over``; ``shape_key`` distinguishes shapes that are equal as tuples. The paths of a rough
    defect in 41 slices take 20 kB, so the cache covers a sweep."""
    return tuple(_trace(section(defect, z), R) for z in positions)


def _trace(profile: Profile, R: float) -> TracedGroup:
    path = path_over(profile, R)
    if len(path.pieces) == 0:
        return NO_DEFECT, path
    x_e = R * steepest(path)
    return (max(-path.pieces[0, 0], path.end, x_e), x_e, 0.0, relief(profile)), path


def group_paths(defect: Any, R: float, slices: Sequence[RollerSlice]) -> tuple[list, list[Path]]:
    """Return groups and paths of a roller over a defect; equal slices form one group, the undamaged length
    another."""
    merged: dict[bytes, tuple[float, tuple, Path]] = {}
    for (weight, _), (row, path) in zip(slices, paths_over(defect, R, [z for _, z in slices]), strict=True):
        key = (np.round(np.append(path.pieces / PIECE_RESOLUTION, path.end / PIECE_RESOLUTION[0])) + 0.0).tobytes()
        previous = merged[key][0] if key in merged else 0.0
        merged[key] = (previous + weight, row, path)
    undamaged_weight = 1.0 - sum(weight for weight, _ in slices)
    undamaged = [(undamaged_weight, NO_DEFECT, FLAT)] if undamaged_weight > 1e-12 else []
    parts = [*undamaged, *merged.values()]
    return [(weight, *row) for weight, row, _ in parts], [path for _, _, path in parts]


def slice_paths(defect: Any, R: float, middles: Sequence[float] | np.ndarray) -> tuple[list, list[Path]]:
    """Return a group of weight 1 and a path for each slice of a roller, with slice middles at ``middles`` (m)."""
    traced = paths_over(defect, R, middles)
    return [(1.0, *row) for row, _ in traced], [path for _, path in traced]


def sharpest_cusp(groups: Sequence[tuple[float, ...]], paths: Sequence[Path]) -> float:
    """Return the position (m) of the cusp with the largest product of slope drop and share of the roller; 0 if
    there is none."""
    cusps = [(cusp(path), row[0]) for row, path in zip(groups, paths, strict=True) if len(path.pieces)]
    position, largest = 0.0, 0.0
    for (cusp_position, slope_drop), weight in cusps:
        if slope_drop * weight > largest:
            position, largest = cusp_position, slope_drop * weight
    return position


def defect_span(defect: Any, R: float) -> float:
    """Return the extent (m) of a defect along its middle, the shortest of merged ones; ``R``: reduced radius
    (m)."""
    if isinstance(defect, MergedDefects):
        return min(defect_span(part, R) for part in defect.defects)
    low, high, z_0, z_1 = extent(defect)
    path = path_over(section(defect, (z_0 + z_1) / 2.0), R)
    return path.end - float(path.pieces[0, 0]) if len(path.pieces) else high - low


def burr_height(defect: Any) -> float:
    """Return the height (m) of a defect's highest point above the race; 0 except for a scan."""
    if isinstance(defect, ShiftedDefect):
        return burr_height(defect.defect)
    return max(0.0, -float(defect.depth.min())) if isinstance(defect, ScannedDefect) else 0.0


def pack_traced_defects(pairs: Sequence[RollerDefectPair]) -> Defects:
    """Pack the roller-defect pairs, and their paths in one table."""
    paths = [path for pair in pairs for path in pair.paths if len(path.pieces)]
    table, offsets = pack_paths(paths)
    defects, remaining_offsets = pack_defects(pairs, TracedPath(table)), iter(offsets)
    for groups, pair in zip(defects.groups, pairs, strict=True):
        for row, path in zip(groups, pair.paths, strict=False):
            row[KAPPA] = next(remaining_offsets) if len(path.pieces) else 0.0
    return defects
