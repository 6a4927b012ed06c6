"""Conflicts of defects with their element, with each other, and with the excitation."""

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.config.fields import Conflict, Path
from bearingsim.config.sections.defect import PATH_EXCITATIONS, SIMPLE_SHAPES
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields
    from bearingsim.config.sections.defect import Defect
    from bearingsim.config.sections.machine import Bearing


class Surface(NamedTuple):
    """Surface on which defects may lie, with limits of their sizes; lengths in m.

    max_width: largest width; width_limit: name of that limit, for messages; max_depth: limit of the depth;
    beyond_depth: region that a deeper defect reaches, for messages; depth_key: key of the bearing that determines
    ``max_depth``.
    """

    radius: float
    max_width: float
    width_limit: str
    max_depth: float
    beyond_depth: str
    depth_key: str


def surface_of(bearing: "Bearing", race: str) -> Surface:
    """Return the surface of a race, or of a roller, of a bearing without clearance."""
    d_m, D_w = bearing.pitch_diameter, bearing.roller_diameter
    if race == "outer":
        radius = (d_m + D_w) / 2.0
        max_depth = (bearing.outside_diameter - d_m - D_w) / 2.0
        return Surface(
            radius,
            bearing.roller_spacing,
            "roller spacing",
            max_depth,
            "through the outer ring",
            "outside_diameter",
        )
    if race == "inner":
        radius, width_limit = (d_m - D_w) / 2.0, "roller spacing on the inner race"
        max_depth = (d_m - D_w - bearing.bore) / 2.0
        return Surface(radius, bearing.inner_spacing, width_limit, max_depth, "through the inner ring", "bore")
    return Surface(D_w / 2.0, D_w, "roller's diameter", D_w / 2.0, "past the roller's axis", "roller_diameter")


def defect_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield all conflicts of a case's defects."""
    for number, defect in enumerate(case.defects):
        path = ("defects", number)
        yield from _roller_conflicts(path, defect, case.bearing)
        yield from _length_conflicts(path, defect, case.bearing)
        yield from _offset_conflicts(path, defect, case.bearing)
        yield from _width_conflicts(path, defect, case.bearing)
        yield from _ramp_conflicts(path, defect)
        yield from _depth_conflicts(path, defect, case.bearing)
        yield from _shape_conflicts(path, defect, case)
    for earlier, later in combinations(range(len(case.defects)), 2):
        yield from _overlap_conflicts(earlier, later, case)
    yield from _merged_width_conflicts(case)


def _roller_conflicts(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*path, "roller"), (*path, "race"))
    if defect.roller is not None and defect.race != "roller":
        message = f"a defect of the {defect.race} race has no `roller`"
        yield Conflict("roller", paths, message, "use `race: roller`, or remove `roller`")
    elif defect.roller is not None and defect.roller > bearing.rollers:
        message = f"there is no roller {defect.roller}: the bearing has {bearing.rollers}"
        yield Conflict("roller", (paths[0], ("bearing", "rollers")), message, "numbers start at 1")


def _available_length(defect: "Defect", bearing: "Bearing") -> tuple[float, str, str]:
    """Return the length (m) along the axis available for a defect, the part that limits it, and its key."""
    if bearing.roller_length is not None:
        return bearing.roller_length, "roller", "roller_length"
    if defect.race == "roller":
        return bearing.roller_diameter, "ball", "roller_diameter"
    return bearing.width, "bearing", "width"


def _size_paths(path: Path, name: str, defect: "Defect") -> tuple[tuple[Path, ...], str | None]:
    """Return the paths of a defect's size, and a hint if it is from a scan."""
    if defect.shape == "scan":
        return ((*path, name), (*path, "file")), "is the scan's unit right?"
    return ((*path, name),), None


def _length_conflicts(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    available_length, part, key = _available_length(defect, bearing)
    if defect.length > available_length:
        length, limit = show(defect.length, "mm"), show(available_length, "mm")
        paths, hint = _size_paths(path, "length", defect)
        message = f"a defect of {length} is longer than the {part} ({limit})"
        yield Conflict("long", (*paths, ("bearing", key)), message, hint)


def _offset_conflicts(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    available_length, part, key = _available_length(defect, bearing)
    half_length = available_length / 2.0
    paths: tuple[Path, ...] = ((*path, "offset"), (*path, "length"), ("bearing", key))
    is_outside = abs(defect.offset) - defect.length / 2.0 >= half_length - 1e-9
    overhangs = defect.race == "roller" and abs(defect.offset) + defect.length / 2.0 > half_length + 1e-9
    if defect.length > available_length or not (is_outside or overhangs):
        return
    offset, end = show(defect.offset, "mm"), show(half_length, "mm")
    if is_outside:
        message = f"a defect {offset} from the centre lies beyond the {part}'s end ({end}) and has no effect"
        yield Conflict("offset", paths, message)
    else:
        length = show(defect.length, "mm")
        message = f"a defect of {length}, {offset} from the centre, extends beyond the {part}'s end"
        yield Conflict("offset", paths, message, f"the end is {end} from the centre")


def _width_conflicts(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    element_surface = surface_of(bearing, defect.race)
    if defect.width > element_surface.max_width:
        width, limit = show(defect.width, "mm"), show(element_surface.max_width, "mm")
        message = f"a defect of {width} is wider than the {element_surface.width_limit} ({limit})"
        paths, hint = _size_paths(path, "width", defect)
        yield Conflict("wide", (*paths, ("bearing",)), message, hint)


def _ramp_conflicts(path: Path, defect: "Defect") -> Iterator[Conflict]:
    ramp = defect.edge.ramp if defect.edge is not None else None
    if ramp is not None and ramp > defect.width:
        message = f"a ramp of {show(ramp, 'mm')} is longer than the defect is wide ({show(defect.width, 'mm')})"
        yield Conflict("ramp", ((*path, "edge", "ramp"), (*path, "width")), message, "make it shorter")


def _depth_conflicts(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    element_surface = surface_of(bearing, defect.race)
    if defect.depth >= element_surface.max_depth:
        depth, limit = show(defect.depth, "mm"), show(element_surface.max_depth, "mm")
        paths, hint = _size_paths(path, "depth", defect)
        message = f"a defect {depth} deep goes {element_surface.beyond_depth} ({limit})"
        yield Conflict("deep", (*paths, ("bearing", element_surface.depth_key)), message, hint)


def _shape_conflicts(path: Path, defect: "Defect", case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of a shape or edge for which the excitation is not defined."""
    if case.excitation in PATH_EXCITATIONS:
        return
    hint = "use `excitation: envelope`, or use a rectangular, triangular or circular defect with sharp edges"
    if defect.shape not in SIMPLE_SHAPES:
        article = "an" if defect.shape[0] in "aeiou" else "a"
        noun = f"{article} {defect.shape}" + (" defect" if defect.shape == "elliptical" else "")
        paths: tuple[Path, ...] = (("excitation",), (*path, "shape"))
        yield Conflict("form", paths, f"`{case.excitation}` is not defined for {noun}", hint)
    elif case.excitation == "elastic-edge":
        yield from _elastic_edge_conflicts(path, defect, case)
    elif defect.edge is not None:
        paths = (("excitation",), (*path, "edge"))
        yield Conflict("form", paths, f"`{case.excitation}` is defined for sharp edges only", hint)


def _elastic_edge_conflicts(path: Path, defect: "Defect", case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of `elastic-edge` with balls, or with edges that are not rounded or not all equal."""
    paths: tuple[Path, ...] = (("excitation",), (*path, "edge"))
    if case.bearing.element == "ball":
        message = "`elastic-edge` is for line contacts, which balls do not have"
        yield Conflict("form", (("excitation",), ("bearing",)), message, "use `excitation: soft-edge`")
    elif defect.edge is not None and defect.edge.radius is None:
        message = "`elastic-edge` is defined for rounded edges only"
        yield Conflict("form", paths, message, "as in `edge: {radius: 20 um}`, the default")
    elif defect.edge != case.defects[0].edge:
        message = "`elastic-edge` needs the same edge radius for all defects"
        yield Conflict("form", paths, message, "give all the same")


def _distance(a: "Defect", b: "Defect", bearing: "Bearing") -> float:
    """Compute the distance (m) between the centres of two defects in the rolling direction."""
    return abs(math.remainder(a.angle - b.angle, 2.0 * math.pi)) * surface_of(bearing, a.race).radius


def _overlap_conflicts(earlier: int, later: int, case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of overlapping defects, which only ``PATH_EXCITATIONS`` merge."""
    a, b = case.defects[earlier], case.defects[later]
    if a.element != b.element or case.excitation in PATH_EXCITATIONS:
        return
    distance = _distance(a, b, case.bearing)
    if distance < (a.width + b.width) / 2.0:
        paths = tuple(("defects", i, key) for i in (later, earlier) for key in ("angle", "width"))
        message = f"overlaps defect {earlier + 1}: their centres are only {show(distance, 'mm')} apart"
        hint = f"move one: only `excitation: envelope` merges defects, not `{case.excitation}`"
        yield Conflict("overlap", paths, message, hint)


def _merged_width_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of the first overlapping defects whose total width exceeds the limit."""
    if case.excitation not in PATH_EXCITATIONS:
        return
    for number, defect in enumerate(case.defects):
        element_surface = surface_of(case.bearing, defect.race)
        width = merged_width(number, case)
        if width > element_surface.max_width >= defect.width:
            total, limit = show(width, "mm"), show(element_surface.max_width, "mm")
            message = (
                f"the defects that overlap here are {total} wide,"
                f" wider than the {element_surface.width_limit} ({limit})"
            )
            yield Conflict("overlap", (("defects", number, "angle"), ("defects", number)), message, "move one")
            return


def merged_width(number: int, case: "CaseFields") -> float:
    """Compute the total width (m) of a defect and all that overlap it, directly or through others."""
    merged, others = {number}, set(range(len(case.defects))) - {number}
    while neighbours := {i for i in others if any(_overlap(case, i, j) for j in merged)}:
        merged |= neighbours
        others -= neighbours
    reference = case.defects[number]
    radius = surface_of(case.bearing, reference.race).radius
    centres = {i: math.remainder(case.defects[i].angle - reference.angle, 2.0 * math.pi) * radius for i in merged}
    low = min(centres[i] - case.defects[i].width / 2.0 for i in merged)
    return max(centres[i] + case.defects[i].width / 2.0 for i in merged) - low


def _overlap(case: "CaseFields", earlier: int, later: int) -> bool:
    """Check if two defects of a case are on the same element and overlap in the rolling direction."""
    a, b = case.defects[earlier], case.defects[later]
    return a.element == b.element and _distance(a, b, case.bearing) < (a.width + b.width) / 2.0
