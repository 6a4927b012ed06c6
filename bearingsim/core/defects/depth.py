"""Depth maps of defects: depth p(s, z) (m, positive into the material), s along rolling and z along the axis from
the defect's centre.

Each kind of map is a type: ``section`` returns its profile at one z, exact or approximated by parabolas;
``extent`` its ends; ``section_intervals`` the intervals along z and how the section varies within each. Plain
Python, run once per defect.
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
    depth_at,
    fit_parabolas,
    make_piece,
    make_polyline,
    merge_profiles,
    mirror_profile,
    separate_parts,
    shift_profile,
)
from bearingsim.core.jit import generic

ARC_POINTS = 17  # on a rounded edge; denser where it is flat, because no roller reaches its steep part
ELLIPSE_POINTS = 65  # on the section of an ellipsoid
CONSTANT_SECTION, SMOOTH_SECTION, ROUGH_SECTION = range(3)  # variation of the section along z, from least to most
EDGE_POINTS = 401  # trial positions of the intersection of edge and wall


@generic
def section(depth_map: Any, z: float) -> Profile:
    """Return the profile at ``z`` (m) from the defect's centre; ``RACE`` beyond the defect."""


@generic
def extent(depth_map: Any) -> tuple[float, float, float, float]:
    """Return the ends (m) of the defect along rolling, s_0 and s_1, and along the axis, z_0 and z_1, burrs
    included."""


@generic
def section_intervals(depth_map: Any) -> list[tuple[float, float, int]]:
    """Return intervals (m, m) along z, each with the variation of the section within it.

    The variation is CONSTANT_SECTION, SMOOTH_SECTION or ROUGH_SECTION.
    """


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
    sections. The material above the rounded or sloping edge is removed from the race, so the opening is wider than
    the original defect.
    """

    defect: Any
    radius: float
    ramp: float
    depth: float


class MirroredDefect(NamedTuple):
    """A defect with the direction of s reversed."""

    defect: Any


class ShiftedDefect(NamedTuple):
    """A defect with its centre at s, z (m)."""

    defect: Any
    s: float
    z: float


class MergedDefects(NamedTuple):
    """Several defects as one, with the depth of the deepest at each position."""

    defects: tuple[Any, ...]


@dataclass(frozen=True)
class ScannedDefect:
    """A measured defect: depth (n_z, n_s) in m at ``s`` (n_s,) and ``z`` (n_z,) in m, linear in between.

    digest: hash of the file, which identifies the scan.
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


@section_intervals.register(Rectangular)
@section_intervals.register(Triangular)
def _intervals_constant(defect):
    return [(-defect.length / 2.0, defect.length / 2.0, CONSTANT_SECTION)]


@section_intervals.register(Circular)
@section_intervals.register(Elliptical)
def _intervals_smooth(defect):
    return [(-defect.length / 2.0, 0.0, SMOOTH_SECTION), (0.0, defect.length / 2.0, SMOOTH_SECTION)]


@section.register(Rectangular)
def _section_rectangular(defect, z):
    if abs(z) >= defect.length / 2.0:
        return RACE
    return make_piece(-defect.width / 2.0, defect.width / 2.0, defect.depth)


@section.register(Triangular)
def _section_triangular(defect, z):
    if abs(z) >= defect.length / 2.0:
        return RACE
    b = defect.width / 2.0
    return make_polyline(np.array([-b, 0.0, b]), np.array([0.0, defect.depth, 0.0]))


@section.register(Circular)
def _section_circular(defect, z):
    zeta = 2.0 * z / defect.length
    if abs(zeta) >= 1.0:
        return RACE
    b, curvature = defect.width / 2.0 * sqrt(1.0 - zeta * zeta), 8.0 * defect.depth / defect.width**2
    return make_piece(-b, b, 0.0, curvature * b, -curvature)


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
    return fit_parabolas(t, p, slope)


# Edges


@extent.register(EasedDefect)
def _extent_eased(eased):
    s_0, s_1, z_0, z_1 = extent(eased.defect)
    margin = eased.radius + eased.ramp
    return s_0 - margin, s_1 + margin, z_0, z_1


@section_intervals.register(EasedDefect)
def _intervals_eased(eased):
    return section_intervals(eased.defect)


@section.register(EasedDefect)
def _section_eased(eased, z):
    profile = section(eased.defect, z)
    if len(profile.pieces) == 0:
        return profile
    sizes = eased.radius, eased.ramp, eased.depth
    for part in separate_parts(profile):
        before, after = _edge_profile(part, *sizes), _edge_profile(mirror_profile(part), *sizes)
        profile = merge_profiles(merge_profiles(profile, before), mirror_profile(after))
    return profile


def _edge_profile(profile: Profile, radius: float, ramp: float, depth: float) -> Profile:
    """Return the profile of the material removed at the first rim of a profile without race between its pieces.

    An edge that meets the wall at depth p starts setback(p) (m) before that point. The edge that starts first is
    tangent to the wall, and its profile is returned; a rounded one is an arc of a disc below the race that touches
    the wall.
    """
    start = profile.pieces[0, START]
    x = np.linspace(0.0, 1.0, EDGE_POINTS) ** 2  # dense at the rim, where an edge meets a steep wall
    x[1] = min(x[1], 1e-9)  # just behind a vertical wall, if there is one
    t = start + (profile.pieces[-1, END] - start) * x
    p = depth_at(profile, t)
    setback = _setback_of_radius(p, radius) if radius > 0.0 else ramp * np.maximum(p, 0.0) / depth
    k = int(np.argmin(t - setback))
    begin, length = t[k] - setback[k], setback[k]
    if length <= 0.0:
        return RACE
    if radius == 0.0:
        return make_piece(begin, begin + length, 0.0, depth / ramp)
    max_angle = np.arcsin(min(length / radius, 1.0))
    theta = max_angle * np.linspace(0.0, 1.0, ARC_POINTS) ** 2
    slope = np.append(np.tan(theta[:-1]), tan(max_angle) if max_angle < 1.5 else inf)
    return fit_parabolas(begin + radius * np.sin(theta), radius * (1.0 - np.cos(theta)), slope)


def _setback_of_radius(p: np.ndarray, radius: float) -> np.ndarray:
    """Return the distance (m) from the start of a rounded edge at which its depth is ``p`` (m)."""
    depth = np.clip(p, 0.0, radius)
    return np.sqrt(depth * (2.0 * radius - depth))


# Mirrored, shifted and merged defects


@extent.register(MirroredDefect)
def _extent_mirrored(mirrored):
    s_0, s_1, z_0, z_1 = extent(mirrored.defect)
    return -s_1, -s_0, z_0, z_1


@section_intervals.register(MirroredDefect)
def _intervals_mirrored(mirrored):
    return section_intervals(mirrored.defect)


@section.register(MirroredDefect)
def _section_mirrored(mirrored, z):
    return mirror_profile(section(mirrored.defect, z))


@extent.register(ShiftedDefect)
def _extent_shifted(shifted):
    s_0, s_1, z_0, z_1 = extent(shifted.defect)
    return s_0 + shifted.s, s_1 + shifted.s, z_0 + shifted.z, z_1 + shifted.z


@section_intervals.register(ShiftedDefect)
def _intervals_shifted(shifted):
    return [(a + shifted.z, b + shifted.z, kind) for a, b, kind in section_intervals(shifted.defect)]


@section.register(ShiftedDefect)
def _section_shifted(shifted, z):
    return shift_profile(section(shifted.defect, z - shifted.z), shifted.s)


@extent.register(MergedDefects)
def _extent_merged(merged):
    s_0, s_1, z_0, z_1 = np.array([extent(defect) for defect in merged.defects]).T
    return float(s_0.min()), float(s_1.max()), float(z_0.min()), float(z_1.max())


@section_intervals.register(MergedDefects)
def _intervals_merged(merged):
    all_intervals = [interval for defect in merged.defects for interval in section_intervals(defect)]
    ends = sorted({end for a, b, _ in all_intervals for end in (a, b)})
    intervals = []
    for a, b in pairwise(ends):
        kinds = [kind for low, high, kind in all_intervals if low < (a + b) / 2.0 < high]
        if kinds:
            intervals.append((a, b, max(kinds)))
    return intervals


@section.register(MergedDefects)
def _section_merged(merged, z):
    return reduce(merge_profiles, (section(defect, z) for defect in merged.defects))


# Scans


@extent.register(ScannedDefect)
def _extent_scanned(scan):
    damaged_s, damaged_z = np.any(scan.depth != 0.0, axis=0), np.any(scan.depth != 0.0, axis=1)
    return *_damaged_extent(scan.s, damaged_s), *_damaged_extent(scan.z, damaged_z)


def _damaged_extent(positions: np.ndarray, is_damaged: np.ndarray) -> tuple[float, float]:
    """Return the position just before the first damaged one and the position just after the last."""
    k = np.flatnonzero(is_damaged)
    return float(positions[max(k[0] - 1, 0)]), float(positions[min(k[-1] + 1, len(positions) - 1)])


@section_intervals.register(ScannedDefect)
def _intervals_scanned(scan):
    _, _, z_0, z_1 = extent(scan)
    return [(z_0, z_1, ROUGH_SECTION)]


@section.register(ScannedDefect)
def _section_scanned(scan, z):
    if not scan.z[0] <= z <= scan.z[-1]:
        return RACE
    k = min(max(int(np.searchsorted(scan.z, z, side="right")) - 1, 0), len(scan.z) - 2)
    x = (z - scan.z[k]) / (scan.z[k + 1] - scan.z[k])
    return make_polyline(scan.s, (1.0 - x) * scan.depth[k] + x * scan.depth[k + 1])
