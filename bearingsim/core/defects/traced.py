"""Conversion of depth maps for the core: slices of a roller over a defect, their paths, and the table of paths."""

from collections.abc import Sequence
from functools import lru_cache
from math import ceil
from typing import Any

import numpy as np

from bearingsim.core.defects.closed_forms import NO_DEFECT
from bearingsim.core.defects.depth import (
    CONSTANT_SECTION,
    SMOOTH_SECTION,
    MergedDefects,
    ScannedDefect,
    ShiftedDefect,
    extent,
    section,
    section_intervals,
)
from bearingsim.core.defects.envelope import FLAT, Path, find_cusp, max_slope, pack_paths, trace_path
from bearingsim.core.defects.excitations import TracedPath
from bearingsim.core.defects.pairs import KAPPA, Defects, RollerDefectPair, pack_defects
from bearingsim.core.defects.profile import Profile, relief

PIECE_RESOLUTION = np.array([1e-12, 1e-18, 1e-12, 1e-6])
"""Differences (m, m, 1, 1/m) below which pieces of paths are equal."""
RollerSlice = tuple[float, float]
"""Weight (1) of a slice of a roller and the position z (m) of its centre from the roller's."""


def cut_along_roller(defect: Any, L_w: float, nodes: int) -> list[RollerSlice]:
    """Return the slices of a roller of length ``L_w`` (m) over a defect.

    Their weights sum to the part of the roller over the defect. An interval of constant section has one slice. On
    one of smoothly varying section the slices are Gauss nodes: ``nodes`` on the longest interval, in proportion on
    others. One of rough section has the same number of slices, of equal length.
    """
    intervals = [(max(a, -L_w / 2.0), min(b, L_w / 2.0), kind) for a, b, kind in section_intervals(defect)]
    intervals = [(a, b, kind) for a, b, kind in intervals if b > a]
    longest = max((b - a for a, b, _ in intervals), default=0.0)
    return [
        ((b - a) / L_w * float(weight) / 2.0, (a + b) / 2.0 + (b - a) / 2.0 * float(x))
        for a, b, kind in intervals
        for x, weight in zip(*_quadrature(kind, max(1, ceil(nodes * (b - a) / longest - 1e-9))), strict=True)
    ]


def _quadrature(kind: int, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes in (-1, 1) and the weights (sum 2) of the quadrature for a ``kind`` of interval."""
    if kind == CONSTANT_SECTION:
        return np.zeros(1), np.full(1, 2.0)
    if kind == SMOOTH_SECTION:
        return np.polynomial.legendre.leggauss(nodes)
    return (2.0 * np.arange(nodes) + 1.0) / nodes - 1.0, np.full(nodes, 2.0 / nodes)


TracedGroup = tuple[tuple[float, ...], Path]
"""Group without its weight, (b, x_e, 0, depth), and its path."""


def trace_paths(defect: Any, R: float, positions: Sequence[float] | np.ndarray) -> tuple[TracedGroup, ...]:
    """Return group and path of a roller over a defect at each z (m) of ``positions``, cached."""
    return _trace_paths(defect, repr(defect), R, tuple(float(z) for z in positions))


@lru_cache(maxsize=256)
def _trace_paths(defect: Any, shape_key: str, R: float, positions: tuple[float, ...]) -> tuple[TracedGroup, ...]:
    """Cache ``trace_paths``; ``shape_key`` distinguishes shapes that are equal as tuples. The paths of a rough
    defect in 41 slices take 20 kB, so the cache covers a sweep."""
    return tuple(_trace(section(defect, z), R) for z in positions)


def _trace(profile: Profile, R: float) -> TracedGroup:
    """Return group and path of a roller of reduced radius ``R`` (m) over a profile."""
    path = trace_path(profile, R)
    if len(path.pieces) == 0:
        return NO_DEFECT, path
    x_e = R * max_slope(path)  # no wall; bounds the slope, as in ``defects/excitations.py``
    return (max(-path.pieces[0, 0], path.end, x_e), x_e, 0.0, relief(profile)), path


def trace_groups(defect: Any, R: float, slices: Sequence[RollerSlice]) -> tuple[list, list[Path]]:
    """Return groups and paths of a roller over a defect: one for all slices with equal paths, and one for the
    undamaged length."""
    merged: dict[bytes, tuple[float, tuple, Path]] = {}
    for (weight, _), (row, path) in zip(slices, trace_paths(defect, R, [z for _, z in slices]), strict=True):
        key = (np.round(np.append(path.pieces / PIECE_RESOLUTION, path.end / PIECE_RESOLUTION[0])) + 0.0).tobytes()
        previous = merged[key][0] if key in merged else 0.0
        merged[key] = (previous + weight, row, path)
    undamaged_weight = 1.0 - sum(weight for weight, _ in slices)
    undamaged = [(undamaged_weight, NO_DEFECT, FLAT)] if undamaged_weight > 1e-12 else []
    parts = [*undamaged, *merged.values()]
    return [(weight, *row) for weight, row, _ in parts], [path for _, _, path in parts]


def trace_slices(defect: Any, R: float, centres: Sequence[float] | np.ndarray) -> tuple[list, list[Path]]:
    """Return a group of weight 1 and a path for each slice of a roller, from the ``centres`` (m) of the slices."""
    traced = trace_paths(defect, R, centres)
    return [(1.0, *row) for row, _ in traced], [path for _, path in traced]


def sharpest_cusp(groups: Sequence[tuple[float, ...]], paths: Sequence[Path]) -> float:
    """Return the position (m) of the cusp with the largest product of slope drop and group weight; 0 if there is
    none."""
    cusps = [(find_cusp(path), row[0]) for row, path in zip(groups, paths, strict=True) if len(path.pieces)]
    position, largest = 0.0, 0.0
    for (cusp_position, slope_drop), weight in cusps:
        if slope_drop * weight > largest:
            position, largest = cusp_position, slope_drop * weight
    return position


def defect_span(defect: Any, R: float) -> float:
    """Return the length (m) along rolling over which a defect acts at its axial centre, the shortest of merged
    defects; ``R``: reduced radius (m)."""
    if isinstance(defect, MergedDefects):
        return min(defect_span(part, R) for part in defect.defects)
    low, high, z_0, z_1 = extent(defect)
    path = trace_path(section(defect, (z_0 + z_1) / 2.0), R)
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
