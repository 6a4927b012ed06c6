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
    """Surface with defects (lengths in m).

    max_width: largest width of a defect; spacing: name of that limit; max_depth: largest depth; location: region
    reached by a deeper defect, for messages; key: dimension of the bearing that determines ``max_depth``.
    """

    radius: float
    max_width: float
    spacing: str
    max_depth: float
    location: str
    key: str


def surface(bearing: "Bearing", race: str) -> Surface:
    """Return the surface of a race, or of a roller, of a bearing without clearance."""
    pitch, roller = bearing.pitch_diameter, bearing.roller_diameter
    if race == "outer":
        radius = (pitch + roller) / 2.0
        max_depth = (bearing.outside_diameter - pitch - roller) / 2.0
        return Surface(
            radius,
            bearing.roller_spacing,
            "roller spacing",
            max_depth,
            "through the outer ring",
            "outside_diameter",
        )
    if race == "inner":
        radius, spacing = (pitch - roller) / 2.0, "roller spacing on the inner race"
        max_depth = (pitch - roller - bearing.bore) / 2.0
        return Surface(radius, bearing.inner_spacing, spacing, max_depth, "through the inner ring", "bore")
    return Surface(
        roller / 2.0, roller, "roller's diameter", roller / 2.0, "past the roller's middle", "roller_diameter"
    )


def defect_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield all conflicts of a case's defects."""
    for number, defect in enumerate(case.defects):
        path = ("defects", number)
        yield from _roller_of(path, defect, case.bearing)
        yield from _length(path, defect, case.bearing)
        yield from _offset(path, defect, case.bearing)
        yield from _width(path, defect, case.bearing)
        yield from _ramp(path, defect)
        yield from _depth(path, defect, case.bearing)
        yield from _shape(path, defect, case)
    for earlier, later in combinations(range(len(case.defects)), 2):
        yield from _overlap(earlier, later, case)
    yield from _overlap_width(case)


def _roller_of(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*path, "roller"), (*path, "race"))
    if defect.roller is not None and defect.race != "roller":
        message = f"a defect of the {defect.race} race has no `roller`"
        yield Conflict("roller", paths, message, "use `race: roller`, or remove `roller`")
    elif defect.roller is not None and defect.roller > bearing.rollers:
        message = f"there is no roller {defect.roller}: the bearing has {bearing.rollers}"
        yield Conflict("roller", (paths[0], ("bearing", "rollers")), message, "numbers start at 1")


def _track(defect: "Defect", bearing: "Bearing") -> tuple[float, str, str]:
    """Return the axial extent (m) available for defects on an element, its name, and its key in the bearing."""
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


def _length(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    track, name, key = _track(defect, bearing)
    if defect.length > track:
        length, limit = show(defect.length, "mm"), show(track, "mm")
        paths, hint = _size_paths(path, "length", defect)
        message = f"a defect of {length} is longer than the {name} ({limit})"
        yield Conflict("long", (*paths, ("bearing", key)), message, hint)


def _offset(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    track, name, key = _track(defect, bearing)
    paths: tuple[Path, ...] = ((*path, "offset"), (*path, "length"), ("bearing", key))
    is_outside = abs(defect.offset) - defect.length / 2.0 >= track / 2.0 - 1e-9
    overhangs = defect.race == "roller" and abs(defect.offset) + defect.length / 2.0 > track / 2.0 + 1e-9
    if defect.length > track or not (is_outside or overhangs):
        return
    offset, end = show(defect.offset, "mm"), show(track / 2.0, "mm")
    if is_outside:
        message = f"a defect {offset} off the middle lies beyond the {name}'s end ({end}) and has no effect"
        yield Conflict("offset", paths, message)
    else:
        message = (
            f"a defect of {show(defect.length, 'mm')}, {offset} off the middle, extends beyond the {name}'s end"
        )
        yield Conflict("offset", paths, message, f"the end is {end} from the middle")


def _width(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    element_surface = surface(bearing, defect.race)
    if defect.width > element_surface.max_width:
        width, limit = show(defect.width, "mm"), show(element_surface.max_width, "mm")
        message = f"a defect of {width} is wider than the {element_surface.spacing} ({limit})"
        paths, hint = _size_paths(path, "width", defect)
        yield Conflict("wide", (*paths, ("bearing",)), message, hint)


def _ramp(path: Path, defect: "Defect") -> Iterator[Conflict]:
    ramp = defect.edge.ramp if defect.edge is not None else None
    if ramp is not None and ramp > defect.width:
        message = f"a ramp of {show(ramp, 'mm')} is longer than the defect is wide ({show(defect.width, 'mm')})"
        yield Conflict("ramp", ((*path, "edge", "ramp"), (*path, "width")), message, "make it shorter")


def _depth(path: Path, defect: "Defect", bearing: "Bearing") -> Iterator[Conflict]:
    element_surface = surface(bearing, defect.race)
    if defect.depth >= element_surface.max_depth:
        depth, limit = show(defect.depth, "mm"), show(element_surface.max_depth, "mm")
        paths, hint = _size_paths(path, "depth", defect)
        message = f"a defect {depth} deep goes {element_surface.location} ({limit})"
        yield Conflict("deep", (*paths, ("bearing", element_surface.key)), message, hint)


def _shape(path: Path, defect: "Defect", case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of a shape or edge for which the excitation is not defined."""
    if case.excitation in PATH_EXCITATIONS:
        return
    hint = "use `excitation: envelope`, or use a rectangular, triangular or circular defect with sharp edges"
    if defect.shape not in SIMPLE_SHAPES:
        article = "an" if defect.shape[0] in "aeiou" else "a"
        noun = f"{article} {defect.shape}" + (" defect" if defect.shape == "elliptical" else "")
        paths: tuple[Path, ...] = (("excitation",), (*path, "shape"))
        yield Conflict("form", paths, f"`{case.excitation}` has no form for {noun}", hint)
    elif case.excitation == "elastic-edge":
        yield from _elastic_edge(path, defect, case)
    elif defect.edge is not None:
        paths = (("excitation",), (*path, "edge"))
        yield Conflict("form", paths, f"`{case.excitation}` is defined for sharp edges only", hint)


def _elastic_edge(path: Path, defect: "Defect", case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of `elastic-edge` unless edges are rounded, equal, and in line contacts."""
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
    return abs(math.remainder(a.angle - b.angle, 2.0 * math.pi)) * surface(bearing, a.race).radius


def _overlap(earlier: int, later: int, case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of overlapping defects, unless the excitation follows the path of a roller."""
    a, b = case.defects[earlier], case.defects[later]
    if a.element != b.element or case.excitation in PATH_EXCITATIONS:
        return
    distance = _distance(a, b, case.bearing)
    if distance < (a.width + b.width) / 2.0:
        paths = tuple(("defects", i, key) for i in (later, earlier) for key in ("angle", "width"))
        message = f"overlaps defect {earlier + 1}: their centres are only {show(distance, 'mm')} apart"
        hint = f"move one: only `excitation: envelope` merges defects, not `{case.excitation}`"
        yield Conflict("overlap", paths, message, hint)


def _overlap_width(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of overlapping defects whose total width exceeds the limit."""
    if case.excitation not in PATH_EXCITATIONS:
        return
    for number, defect in enumerate(case.defects):
        element_surface = surface(case.bearing, defect.race)
        width = chain_width(number, case)
        if width > element_surface.max_width >= defect.width:
            total, limit = show(width, "mm"), show(element_surface.max_width, "mm")
            message = (
                f"the defects that overlap here are {total} wide,"
                f" wider than the {element_surface.spacing} ({limit})"
            )
            yield Conflict("overlap", (("defects", number, "angle"), ("defects", number)), message, "move one")
            return


def chain_width(number: int, case: "CaseFields") -> float:
    """Compute the total width (m) of a defect and all that overlap it, directly or through others."""
    chain, others = {number}, set(range(len(case.defects))) - {number}
    while neighbours := {i for i in others if any(_is_overlap(case, i, j) for j in chain)}:
        chain |= neighbours
        others -= neighbours
    reference = case.defects[number]
    radius = surface(case.bearing, reference.race).radius
    centres = {i: math.remainder(case.defects[i].angle - reference.angle, 2.0 * math.pi) * radius for i in chain}
    low = min(centres[i] - case.defects[i].width / 2.0 for i in chain)
    return max(centres[i] + case.defects[i].width / 2.0 for i in chain) - low


def _is_overlap(case: "CaseFields", earlier: int, later: int) -> bool:
    a, b = case.defects[earlier], case.defects[later]
    return a.element == b.element and _distance(a, b, case.bearing) < (a.width + b.width) / 2.0
