"""Conflicts of a flexible outer ring, its load and its sensor."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from bearingsim import catalogue
from bearingsim.config.fields import Conflict, Path
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields
    from bearingsim.config.sections.ring import FlexibleRing, RingLoad, SupportPoint

RING: tuple[Path, ...] = (("rig", "ring", "bends"), ("rig", "ring"), ("rig",))
LOAD: Path = ("rig", "load")
BY_PATHS: tuple[Path, ...] = ((*LOAD, "by"), LOAD)
MAX_HOUSING_STIFFNESS, MAX_FIT = 1e13, 1e-4  # N/m per m of circumference; m
SECTION_TOLERANCE = 0.01  # largest relative difference of the cross-section from the bearing's dimensions
BALANCE_TOLERANCE = 1e-6  # largest resultant of the pads perpendicular to the load line, relative to that along it
MIN_LOAD_SHARE = 0.1  # minimum mean cosine of the pads' angles from the load line
MAX_POINTS = 100  # largest number of springs at discrete angles
MAX_DISPLACEMENT = 1e-3  # m, largest displacement of a carrier under its load
MIN_CARRIER_MASS = 1e-3  # kg; the natural frequency of a lighter carrier would need too short a step
ANGLE_TOLERANCE = 1e-6  # rad; angles that differ by less count as equal
COSINE_TOLERANCE = 1e-9  # tolerance of the cosine of the angle between a displacement and a spring or the load


def flexible_ring_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield all conflicts of the ring, its load and its sensor."""
    rig = case.rig
    if rig.ring is None:
        yield from _rigid_ring_conflicts(case)
        return
    assert rig.load is not None
    yield from _section_conflicts(case, rig.ring)
    yield from _method_conflicts(case)
    yield from _load_conflicts(case, rig.load)
    if case.load_across != 0.0 and not rig.load.has_carrier:
        paths: tuple[Path, ...] = (("load_across",), *BY_PATHS)
        message = f"`by: {rig.load.by}` exerts no force across the load line"
        yield Conflict("across", paths, message, "remove `load_across`, or use `by: points` or `by: housing`")
    if not rig.sensor.on_ring and not rig.load.has_carrier:
        paths = (("rig", "sensor", "on"), ("rig", "sensor"), *BY_PATHS)
        yield Conflict("sensor", paths, f"`by: {rig.load.by}` has no housing for a sensor", "use `by: housing`")


def _rigid_ring_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    hint = "use `ring: {bends: true}`"
    if case.rig.load is not None:
        yield Conflict("rigid", (LOAD, *RING), "the load path has no effect on a rigid ring", hint)
    if not case.rig.sensor.on_ring:
        sensor_paths: tuple[Path, ...] = (("rig", "sensor", "on"), ("rig", "sensor"), *RING)
        yield Conflict("rigid sensor", sensor_paths, "a rigid ring has no housing around it", hint)
    if case.rig.bracket_stiffness == 0.0:
        paths: tuple[Path, ...] = (("rig", "bracket_stiffness"), *RING)
        yield Conflict("bracket", paths, "a rigid ring needs a bracket", f"use `1e7 N/m`, or {hint[4:]}")


def _section_conflicts(case: "CaseFields", ring: "FlexibleRing") -> Iterator[Conflict]:
    for name, expected in case.bearing.ring_section.items():
        size = getattr(ring.section, name)
        if abs(size - expected) > SECTION_TOLERANCE * expected:
            message = f"the bearing's outer ring has a {name} of {show(expected, 'mm')}, not {show(size, 'mm')}"
            paths: tuple[Path, ...] = (("rig", "ring", "section", name), ("rig", "ring"), ("bearing",))
            yield Conflict(f"section {name}", paths, message, f"remove `{name}`")


def _method_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of an implicit method, for which models with a flexible ring have no Jacobian."""
    method = catalogue.METHODS.get(str(case.method))
    if method is not None and method.implicit:
        paths: tuple[Path, ...] = (("method",), *RING)
        message = f"`{case.method}` needs the Jacobian, which models with a flexible ring do not have"
        yield Conflict("implicit", paths, message, "omit `method`, or use an explicit one")


def _load_conflicts(case: "CaseFields", load: "RingLoad") -> Iterator[Conflict]:
    if load.by == "pads":
        yield from _pad_conflicts(load.angles or ())
    elif load.by == "points":
        yield from _point_conflicts(case, load.at or ())
    elif load.by == "housing":
        yield from _housing_conflicts(case, load)
    if load.mass is not None and load.mass < MIN_CARRIER_MASS:
        message = f"a carrier of {show(load.mass, 'g')} on its springs needs too short a step"
        yield Conflict(
            "mass", ((*LOAD, "mass"), LOAD), message, "use 1 g or more, or omit `mass`, 1 kg by default"
        )


def _pad_conflicts(angles: tuple[float, ...]) -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*LOAD, "angles"), LOAD)
    along, across = sum(map(math.cos, angles)), sum(map(math.sin, angles))
    if _has_duplicates(angles):
        yield Conflict("pads", paths, "two pads have the same angle", "give each angle once")
    elif 0.0 < along <= MIN_LOAD_SHARE * len(angles):
        message = "pads at these angles carry almost none of the load: their forces act across it"
        yield Conflict("pads", paths, message, "use angles nearer to the load line, such as `[-45 deg, 45 deg]`")
    elif along <= 0.0 or abs(across) > BALANCE_TOLERANCE * along:
        message = "equal forces at these angles do not add up to a load along the load line"
        yield Conflict("pads", paths, message, "use angles on both sides of it, such as `[-45 deg, 45 deg]`")


def _point_conflicts(case: "CaseFields", points: "tuple[SupportPoint, ...]") -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*LOAD, "at"), LOAD, ("load_across",))
    load_line, angles = math.atan2(case.load_across, case.load), [point.angle for point in points]
    stiffness = sum(point.stiffness * max(math.cos(point.angle - load_line), 0.0) ** 2 for point in points)
    displacement = math.hypot(case.load, case.load_across) / stiffness if stiffness > 0.0 else math.inf
    if len(points) > MAX_POINTS:
        yield Conflict("points", paths, f"more than {MAX_POINTS} springs", "use `by: housing`")
    elif _has_duplicates(angles):
        yield Conflict("points", paths, "two springs have the same angle", "give each angle once")
    elif not any(math.cos(angle - load_line) > BALANCE_TOLERANCE for angle in angles):
        message = "no spring within 90 deg of the load line carries the load"
        yield Conflict("points", paths, message, f"give one at `angle: {show(load_line, 'deg')}`")
    elif not _is_supported(angles, load_line) and not _has_single_support(case, angles, load_line):
        message = "compression springs at these angles do not support the carrier"
        yield Conflict("points", paths, message, "give springs on both sides of the load line")
    elif displacement > MAX_DISPLACEMENT:
        message = f"under its load the carrier would move by {show(float(f'{displacement:.3g}'), 'mm')}"
        yield Conflict("points", paths, message, "use stiffer springs, or some nearer to the load line")


def _has_single_support(case: "CaseFields", angles: list[float], load_line: float) -> bool:
    """Check if the only spring is on the load line, and a bracket supports the carrier across it."""
    return len(angles) == 1 and math.cos(angles[0] - load_line) > 1.0 - 1e-12 and case.rig.bracket_stiffness > 0.0


def _is_supported(angles: list[float], load_line: float) -> bool:
    """Check if compression springs at these angles (rad) support a carrier under its load, without a bracket.

    They do unless some displacement of the carrier compresses no spring and is not opposed by the load. It is
    sufficient to test the directions perpendicular to each spring.
    """
    directions = [angle + quarter for angle in angles for quarter in (-math.pi / 2.0, math.pi / 2.0)]
    return not any(
        all(math.cos(direction - angle) > -COSINE_TOLERANCE for angle in angles)
        and math.cos(direction - load_line) < COSINE_TOLERANCE
        for direction in directions
    )


def _housing_conflicts(case: "CaseFields", load: "RingLoad") -> Iterator[Conflict]:
    assert load.stiffness is not None
    assert load.fit is not None
    stiffness: tuple[Path, ...] = ((*LOAD, "stiffness"), LOAD)
    # half of the springs are compressed; the mean square of the cosine of their angles from the load is 1/2
    effective_stiffness = 0.25 * math.pi * case.bearing.outside_diameter * load.stiffness  # N/m
    displacement = math.hypot(case.load, case.load_across) / effective_stiffness
    if load.stiffness > MAX_HOUSING_STIFFNESS:
        message = f"a housing of {load.stiffness:.3g} N/m/m makes the ring practically rigid"
        yield Conflict("housing", stiffness, message, "use a rigid ring, or at most 1e13 N/m/m")
    elif displacement > MAX_DISPLACEMENT:
        message = f"under its load the housing would move by {show(float(f'{displacement:.3g}'), 'mm')}"
        yield Conflict("housing", stiffness, message, "use a stiffer one, such as `1e10 N/m/m`")
    if abs(load.fit) > MAX_FIT:
        message = f"a fit of {show(load.fit, 'um')} is beyond {show(MAX_FIT, 'um')}"
        yield Conflict("fit", ((*LOAD, "fit"), LOAD), message, "is the unit right?")


def _has_duplicates(angles: "tuple[float, ...] | list[float]") -> bool:
    """Check if two of the angles (rad) are equal, up to whole revolutions."""
    wrapped = sorted(angle % (2.0 * math.pi) for angle in angles)
    gaps = [
        following - previous
        for previous, following in zip(wrapped, [*wrapped[1:], wrapped[0] + 2.0 * math.pi], strict=True)
    ]
    return len(wrapped) > 1 and min(gaps) < ANGLE_TOLERANCE
