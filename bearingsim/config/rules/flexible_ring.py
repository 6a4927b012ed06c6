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
BY: tuple[Path, ...] = ((*LOAD, "by"), LOAD)
STIFFEST, LARGEST_FIT = 1e13, 1e-4  # N/m per m; m
SAME_SECTION = 0.01  # relative tolerance of height and width
BALANCED = 1e-6  # largest resultant of the pads perpendicular to the load line, relative to that along it
LEAST_SHARE = 0.1  # least mean cosine of the pads' angles from the load line
MAX_POINTS = 100
FARTHEST = 1e-3  # m, largest displacement of a carrier under its load
LIGHTEST = 1e-3  # kg, least mass of a carrier: a lighter one has too high a natural frequency for the step
SAME_ANGLE = 1e-6  # rad
NO_FORCE = 1e-9  # tolerance of the cosine between a displacement and a spring


def flexible_ring_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield all conflicts of the ring, its load and its sensor."""
    rig = case.rig
    if rig.ring is None:
        yield from _rigid_ring_conflicts(case)
        return
    assert rig.load is not None
    yield from _section(case, rig.ring)
    yield from _method(case)
    yield from _load(case, rig.load)
    if case.load_across != 0.0 and not rig.load.carried:
        paths: tuple[Path, ...] = (("load_across",), *BY)
        message = f"`by: {rig.load.by}` gives the ring forces along the load line alone"
        yield Conflict("across", paths, message, "leave it out, or use `by: points` or `by: housing`")
    if not rig.sensor.on_ring and not rig.load.carried:
        paths = (("rig", "sensor", "on"), ("rig", "sensor"), *BY)
        yield Conflict("sensor", paths, f"`by: {rig.load.by}` has no housing for a sensor", "use `by: housing`")


def _rigid_ring_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    bend = "use `ring: {bends: true}`"
    if case.rig.load is not None:
        yield Conflict("rigid", (LOAD, *RING), "the point of load has no effect on a rigid ring", bend)
    if not case.rig.sensor.on_ring:
        where: tuple[Path, ...] = (("rig", "sensor", "on"), ("rig", "sensor"), *RING)
        yield Conflict("rigid sensor", where, "a rigid ring has no housing around it", bend)
    if case.rig.bracket_stiffness == 0.0:
        paths: tuple[Path, ...] = (("rig", "bracket_stiffness"), *RING)
        yield Conflict("bracket", paths, "a rigid ring needs a bracket", f"use `1e7 N/m`, or {bend[4:]}")


def _section(case: "CaseFields", ring: "FlexibleRing") -> Iterator[Conflict]:
    for name, expected in case.bearing.ring_section.items():
        size = getattr(ring.section, name)
        if abs(size - expected) > SAME_SECTION * expected:
            message = f"the bearing's outer ring has a {name} of {show(expected, 'mm')}, not {show(size, 'mm')}"
            paths: tuple[Path, ...] = (("rig", "ring", "section", name), ("rig", "ring"), ("bearing",))
            yield Conflict(f"section {name}", paths, message, "leave it out")


def _method(case: "CaseFields") -> Iterator[Conflict]:
    method = catalogue.METHODS.get(str(case.method))
    if method is not None and method.implicit:
        paths: tuple[Path, ...] = (("method",), *RING)
        message = f"`{case.method}` solves with derivatives, which a ring that bends does not have"
        yield Conflict("implicit", paths, message, "leave `method` out, or take an explicit one")


def _load(case: "CaseFields", load: "RingLoad") -> Iterator[Conflict]:
    if load.by == "pads":
        yield from _pads(load.angles or ())
    elif load.by == "points":
        yield from _points(case, load.at or ())
    elif load.by == "housing":
        yield from _housing(case, load)
    if load.mass is not None and load.mass < LIGHTEST:
        message = f"a carrier of {show(load.mass, 'g')} on its springs needs too short a step"
        yield Conflict("mass", ((*LOAD, "mass"), LOAD), message, "take 1 g or more, or leave it out: 1 kg")


def _pads(angles: tuple[float, ...]) -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*LOAD, "angles"), LOAD)
    along, across = sum(map(math.cos, angles)), sum(map(math.sin, angles))
    if _twice(angles):
        yield Conflict("pads", paths, "two pads stand at the same angle", "give each angle once")
    elif 0.0 < along <= LEAST_SHARE * len(angles):
        message = "pads at these angles carry almost none of the load: their forces act across it"
        yield Conflict("pads", paths, message, "use angles nearer to the load line, such as `[-45 deg, 45 deg]`")
    elif along <= 0.0 or abs(across) > BALANCED * along:
        message = "equal forces at these angles do not add up to a load along the load line"
        yield Conflict("pads", paths, message, "take angles on both sides of it, such as `[-45 deg, 45 deg]`")


def _points(case: "CaseFields", points: "tuple[SupportPoint, ...]") -> Iterator[Conflict]:
    paths: tuple[Path, ...] = ((*LOAD, "at"), LOAD, ("load_across",))
    load_line, angles = math.atan2(case.load_across, case.load), [point.angle for point in points]
    stiff = sum(point.stiffness * max(math.cos(point.angle - load_line), 0.0) ** 2 for point in points)
    moved = math.hypot(case.load, case.load_across) / stiff if stiff > 0.0 else math.inf
    if len(points) > MAX_POINTS:
        yield Conflict("points", paths, f"more than {MAX_POINTS} springs", "use `by: housing`")
    elif _twice(angles):
        yield Conflict("points", paths, "two springs stand at the same angle", "give each angle once")
    elif not any(math.cos(angle - load_line) > BALANCED for angle in angles):
        message = "no spring within 90 deg of the load line carries the load"
        yield Conflict("points", paths, message, f"give one at `angle: {show(load_line, 'deg')}`")
    elif not _hold(angles, load_line) and not _stands_on_one(case, angles, load_line):
        message = "springs that push only do not hold the carrier here"
        yield Conflict("points", paths, message, "give springs on both sides of the load line")
    elif moved > FARTHEST:
        message = f"under its load the carrier would move by {show(float(f'{moved:.3g}'), 'mm')}"
        yield Conflict("points", paths, message, "take stiffer springs, or some nearer to the load line")


def _stands_on_one(case: "CaseFields", angles: list[float], load_line: float) -> bool:
    """Check if the only spring is on the load line, and a bracket supports the carrier sideways."""
    return len(angles) == 1 and math.cos(angles[0] - load_line) > 1.0 - 1e-12 and case.rig.bracket_stiffness > 0.0


def _hold(angles: list[float], load_line: float) -> bool:
    """Check if compression springs at these angles support a carrier under its load, without a bracket.

    They do unless a displacement of the carrier compresses no spring and is not opposed by the load. It is
    sufficient to test the directions perpendicular to each spring.
    """
    sideways = [angle + turn for angle in angles for turn in (-math.pi / 2.0, math.pi / 2.0)]
    return not any(
        all(math.cos(way - angle) > -NO_FORCE for angle in angles) and math.cos(way - load_line) < NO_FORCE
        for way in sideways
    )


def _housing(case: "CaseFields", load: "RingLoad") -> Iterator[Conflict]:
    assert load.stiffness is not None
    assert load.fit is not None
    stiffness: tuple[Path, ...] = ((*LOAD, "stiffness"), LOAD)
    half_seat = 0.25 * math.pi * case.bearing.outside_diameter * load.stiffness  # N/m, of half the springs
    moved = math.hypot(case.load, case.load_across) / half_seat
    if load.stiffness > STIFFEST:
        message = f"a housing of {load.stiffness:.3g} N/m/m holds the ring as a rigid one"
        yield Conflict("housing", stiffness, message, "take a rigid ring, or at most 1e13 N/m/m")
    elif moved > FARTHEST:
        message = f"under its load the housing would move by {show(float(f'{moved:.3g}'), 'mm')}"
        yield Conflict("housing", stiffness, message, "take a stiffer one, such as `1e10 N/m/m`")
    if abs(load.fit) > LARGEST_FIT:
        message = f"a fit of {show(load.fit, 'um')} is beyond {show(LARGEST_FIT, 'um')}"
        yield Conflict("fit", ((*LOAD, "fit"), LOAD), message, "is the unit right?")


def _twice(angles: "tuple[float, ...] | list[float]") -> bool:
    """Check if two angles (rad) are equal."""
    turned = sorted(angle % (2.0 * math.pi) for angle in angles)
    gaps = [after - before for before, after in zip(turned, [*turned[1:], turned[0] + 2.0 * math.pi], strict=True)]
    return len(turned) > 1 and min(gaps) < SAME_ANGLE
