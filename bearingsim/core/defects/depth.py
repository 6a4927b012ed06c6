"""Defects as depth maps p(s, z), m, positive downwards: s along rolling, z along the axis, from the defect's
middle.

Each kind of map is a type: ``section`` returns its profile at one z, exact or in parabolas; ``extent`` its size;
``cuts`` the intervals along z between changes in the kind of section. Plain Python, run once per defect.
"""

from dataclasses import dataclass, field
from functools import reduce
from itertools import pairwise
from math import inf, pi, sqrt, tan
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.defects.profile import (
    END,
    RACE,
    START,
    Profile,
    curve,
    deeper_profile,
    depth_at,
    mirror_profile,
    polygon,
    quadratic,
    separate_parts,
    shift_profile,
)
from bearingsim.core.jit import generic

ARC_POINTS = 17  # on a rounded edge; denser where it is flat, because no roller reaches its steep part
ELLIPSE_POINTS = 65
EVEN, SMOOTH, ROUGH = range(3)
EDGE_POINTS = 401  # candidate positions for the intersection of edge and wall


@generic
def section(depth_map: Any, z: float) -> Profile:
    """Return the profile at ``z`` (m) from the defect's middle; ``RACE`` beyond the defect."""


@generic
def extent(depth_map: Any) -> tuple[float, float, float, float]:
    """Return the extent (m, m) of the defect along rolling, then along the axis, burrs included."""


@generic
def cuts(depth_map: Any) -> list[tuple[float, float, int]]:
    """Return intervals (m, m) along z and how the section changes within them: EVEN, SMOOTH or ROUGH."""


class Rectangular(NamedTuple):
    """A box. length: along the axis; width: along rolling; depth: m."""

    length: float
    width: float
    depth: float


class Triangular(NamedTuple):
    """A V groove along the axis; fields as in ``Rectangular``."""

    length: float
    width: float
    depth: float


class Circular(NamedTuple):
    """A bowl with an elliptic footprint and parabolic sections, p = d [1 - (2 s/w)^2 - (2 z/l)^2]."""

    length: float
    width: float
    depth: float


class Elliptical(NamedTuple):
    """Half an ellipsoid, p = d sqrt(1 - (2 s/w)^2 - (2 z/l)^2): steeper walls and a flatter floor than a bowl."""

    length: float
    width: float
    depth: float


class EasedDefect(NamedTuple):
    """A defect whose edges along rolling are rounded with ``radius`` (m), or whose walls are no steeper than
    ``depth`` over ``ramp`` (m, m).

    One of radius and ramp is zero; depth: the defect's largest depth, so that the slope is the same in all
    sections. Material above the rounded or sloping edge is removed from the race, so the opening is wider than the
    defect.
    """

    defect: Any
    radius: float
    ramp: float
    depth: float


class MirroredDefect(NamedTuple):
    """A defect with the direction of s reversed."""

    defect: Any


class ShiftedDefect(NamedTuple):
    """A defect with its middle at s, z (m)."""

    defect: Any
    s: float
    z: float


class MergedDefects(NamedTuple):
    """Several defects as one: the deepest of those present at each position."""

    defects: tuple[Any, ...]


@dataclass(frozen=True)
class ScannedDefect:
    """A measured grid: depth (n_z, n_s) in m at ``s`` (n_s,) and ``z`` (n_z,) in m, linear in between.

    digest: of the file; identifies the scan.
    """

    digest: str
    s: np.ndarray = field(compare=False, repr=False)
    z: np.ndarray = field(compare=False, repr=False)
    depth: np.ndarray = field(compare=False, repr=False)


# Shapes with a formula


def _box_extent(defect):
    return -defect.width / 2.0, defect.width / 2.0, -defect.length / 2.0, defect.length / 2.0


for _shape in (Rectangular, Triangular, Circular, Elliptical):
    extent.register(_shape)(_box_extent)


@cuts.register(Rectangular)
@cuts.register(Triangular)
def _cuts_even(defect):
    return [(-defect.length / 2.0, defect.length / 2.0, EVEN)]


@cuts.register(Circular)
@cuts.register(Elliptical)
def _cuts_round(defect):
    return [(-defect.length / 2.0, 0.0, SMOOTH), (0.0, defect.length / 2.0, SMOOTH)]


@section.register(Rectangular)
def _section_rectangular(defect, z):
    if abs(z) >= defect.length / 2.0:
        return RACE
    return quadratic(-defect.width / 2.0, defect.width / 2.0, defect.depth)


@section.register(Triangular)
def _section_triangular(defect, z):
    if abs(z) >= defect.length / 2.0:
        return RACE
    b = defect.width / 2.0
    return polygon(np.array([-b, 0.0, b]), np.array([0.0, defect.depth, 0.0]))


@section.register(Circular)
def _section_circular(defect, z):
    zeta = 2.0 * z / defect.length
    if abs(zeta) >= 1.0:
        return RACE
    b, curvature = defect.width / 2.0 * sqrt(1.0 - zeta * zeta), 8.0 * defect.depth / defect.width**2
    return quadratic(-b, b, 0.0, curvature * b, -curvature)


@section.register(Elliptical)
def _section_elliptical(defect, z):
    zeta = 2.0 * z / defect.length
    if abs(zeta) >= 1.0:
        return RACE
    scale = sqrt(1.0 - zeta * zeta)
    theta = np.linspace(-pi / 2.0, pi / 2.0, ELLIPSE_POINTS)
    t, p = defect.width / 2.0 * scale * np.sin(theta), defect.depth * scale * np.cos(theta)
    p[[0, -1]] = 0.0
    slope = np.full(len(t), inf)
    slope[1:-1] = -2.0 * defect.depth / defect.width * np.tan(theta[1:-1])
    return curve(t, p, slope)


# Edges


@extent.register(EasedDefect)
def _extent_eased(eased):
    s_0, s_1, z_0, z_1 = extent(eased.defect)
    margin = eased.radius + eased.ramp
    return s_0 - margin, s_1 + margin, z_0, z_1


@cuts.register(EasedDefect)
def _cuts_eased(eased):
    return cuts(eased.defect)


@section.register(EasedDefect)
def _section_eased(eased, z):
    profile = section(eased.defect, z)
    if len(profile.pieces) == 0:
        return profile
    sizes = eased.radius, eased.ramp, eased.depth
    for part in separate_parts(profile):
        before, after = _edge_profile(part, *sizes), _edge_profile(mirror_profile(part), *sizes)
        profile = deeper_profile(deeper_profile(profile, before), mirror_profile(after))
    return profile


def _edge_profile(profile: Profile, radius: float, ramp: float, depth: float) -> Profile:
    """Return the material removed before and at the first rim of a profile without race between its pieces.

    At depth p an edge lies back(p) (m) before the wall. It begins where it is tangent to the wall; for a radius,
    where a disc rolling below the race touches the wall.
    """
    start = profile.pieces[0, START]
    x = np.linspace(0.0, 1.0, EDGE_POINTS) ** 2  # dense at the rim, where an edge meets a steep wall
    x[1] = min(x[1], 1e-9)  # behind a vertical wall
    t = start + (profile.pieces[-1, END] - start) * x
    p = depth_at(profile, t)
    setback = _setback_of_radius(p, radius) if radius > 0.0 else ramp * np.maximum(p, 0.0) / depth
    k = int(np.argmin(t - setback))
    begin, length = t[k] - setback[k], setback[k]
    if length <= 0.0:
        return RACE
    if radius == 0.0:
        return quadratic(begin, begin + length, 0.0, depth / ramp)
    steepest = np.arcsin(min(length / radius, 1.0))
    theta = steepest * np.linspace(0.0, 1.0, ARC_POINTS) ** 2
    slope = np.append(np.tan(theta[:-1]), tan(steepest) if steepest < 1.5 else inf)
    return curve(begin + radius * np.sin(theta), radius * (1.0 - np.cos(theta)), slope)


def _setback_of_radius(p: np.ndarray, radius: float) -> np.ndarray:
    low = np.clip(p, 0.0, radius)
    return np.sqrt(low * (2.0 * radius - low))


# Mirrored, shifted and merged defects


@extent.register(MirroredDefect)
def _extent_mirrored(mirrored):
    s_0, s_1, z_0, z_1 = extent(mirrored.defect)
    return -s_1, -s_0, z_0, z_1


@cuts.register(MirroredDefect)
def _cuts_mirrored(mirrored):
    return cuts(mirrored.defect)


@section.register(MirroredDefect)
def _section_mirrored(mirrored, z):
    return mirror_profile(section(mirrored.defect, z))


@extent.register(ShiftedDefect)
def _extent_placed(placed):
    s_0, s_1, z_0, z_1 = extent(placed.defect)
    return s_0 + placed.s, s_1 + placed.s, z_0 + placed.z, z_1 + placed.z


@cuts.register(ShiftedDefect)
def _cuts_placed(placed):
    return [(a + placed.z, b + placed.z, kind) for a, b, kind in cuts(placed.defect)]


@section.register(ShiftedDefect)
def _section_placed(placed, z):
    return shift_profile(section(placed.defect, z - placed.z), placed.s)


@extent.register(MergedDefects)
def _extent_merged(merged):
    s_0, s_1, z_0, z_1 = np.array([extent(defect) for defect in merged.defects]).T
    return float(s_0.min()), float(s_1.max()), float(z_0.min()), float(z_1.max())


@cuts.register(MergedDefects)
def _cuts_merged(merged):
    all_cuts = [cut for defect in merged.defects for cut in cuts(defect)]
    ends = sorted({end for a, b, _ in all_cuts for end in (a, b)})
    intervals = []
    for a, b in pairwise(ends):
        kinds = [kind for low, high, kind in all_cuts if low < (a + b) / 2.0 < high]
        if kinds:
            intervals.append((a, b, max(kinds)))
    return intervals


@section.register(MergedDefects)
def _section_merged(merged, z):
    return reduce(deeper_profile, (section(defect, z) for defect in merged.defects))


# Scans


@extent.register(ScannedDefect)
def _extent_scanned(scan):
    along, across = np.any(scan.depth != 0.0, axis=0), np.any(scan.depth != 0.0, axis=1)
    return *_marked_extent(scan.s, along), *_marked_extent(scan.z, across)


def _marked_extent(positions: np.ndarray, marked: np.ndarray) -> tuple[float, float]:
    """Return the extent from the last position before to the first position after those in ``marked``."""
    k = np.flatnonzero(marked)
    return float(positions[max(k[0] - 1, 0)]), float(positions[min(k[-1] + 1, len(positions) - 1)])


@cuts.register(ScannedDefect)
def _cuts_scanned(scan):
    _, _, z_0, z_1 = extent(scan)
    return [(z_0, z_1, ROUGH)]


@section.register(ScannedDefect)
def _section_scanned(scan, z):
    if not scan.z[0] <= z <= scan.z[-1]:
        return RACE
    k = min(max(int(np.searchsorted(scan.z, z, side="right")) - 1, 0), len(scan.z) - 2)
    x = (z - scan.z[k]) / (scan.z[k + 1] - scan.z[k])
    return polygon(scan.s, (1.0 - x) * scan.depth[k] + x * scan.depth[k + 1])
