"""What does not go together about an outer ring that bends, its load and its sensor."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from bearingsim import catalogue
from bearingsim.config.rules.conflict import Conflict, Path
from bearingsim.config.sections.ring import KEYS
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields
    from bearingsim.config.sections.ring import RingLoad

LOAD: Path = ("rig", "load")
BENDS: Path = ("rig", "ring", "bends")
STIFFEST, LARGEST_FIT = 1e13, 1e-4  # N/m per m; m
SAME_SECTION = 0.01  # of height and width
BALANCED = 1e-6  # of the load: what pads may push across it
SAME_ANGLE = 1e-6  # rad


def flexible_ring_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Everything about the ring, its load and its sensor that does not fit together."""
    rig = case.rig
    if rig.ring is None:
        yield from _of_rigid_ring(case)
        return
    assert rig.load is not None
    yield from _section(case)
    yield from _method(case)
    told = list(_told(rig.load))
    yield from told or _load(rig.load)
    if case.load_across != 0.0 and not rig.load.carried:
        paths: tuple[Path, ...] = (("load_across",), LOAD)
        message = f"`by: {rig.load.by}` gives the ring forces along the load line alone"
        yield Conflict("across", paths, message, "leave it out, or say `by: points` or `by: housing`")
    if rig.sensor.on == "housing" and not rig.load.carried:
        paths = (("rig", "sensor", "on"), LOAD)
        yield Conflict("sensor", paths, f"`by: {rig.load.by}` has no housing for a sensor", "say `by: housing`")


def _of_rigid_ring(case: "CaseFields") -> Iterator[Conflict]:
    bend = "say `ring: {bends: true}`"
    if case.rig.load is not None:
        yield Conflict("rigid", (LOAD, BENDS, ("rig",)), "where the load enters is nothing to a rigid ring", bend)
    if case.rig.sensor.on == "housing":
        yield Conflict(
            "rigid",
            (("rig", "sensor", "on"), BENDS, ("rig",)),
            "a rigid ring has no housing around it",
            f"{bend}, or `on: ring`",
        )
    if case.rig.bracket_stiffness == 0.0:
        paths: tuple[Path, ...] = (("rig", "bracket_stiffness"), BENDS, ("rig",))
        yield Conflict("bracket", paths, "a rigid ring needs a bracket", f"say `1e7 N/m`, or {bend[4:]}")


def _section(case: "CaseFields") -> Iterator[Conflict]:
    b, section = case.bearing, case.rig.ring.section  # type: ignore[union-attr]
    usual = {"height": 0.5 * (b.outside_diameter - b.pitch_diameter - b.roller_diameter), "width": b.width}
    for name, expected in usual.items():
        given = getattr(section, name)
        if abs(given - expected) > SAME_SECTION * expected:
            message = f"the bearing's outer ring has a {name} of {show(expected, 'mm')}, not {show(given, 'mm')}"
            paths: tuple[Path, ...] = (("rig", "ring", "section", name), ("rig", "ring"), ("bearing",))
            yield Conflict(f"section {name}", paths, message, "leave it out")


def _method(case: "CaseFields") -> Iterator[Conflict]:
    method = catalogue.METHODS.get(str(case.method))
    if method is not None and method.implicit:
        paths: tuple[Path, ...] = (("method",), ("rig", "ring"))
        message = f"`{case.method}` solves with derivatives, which a ring that bends does not have"
        yield Conflict("implicit", paths, message, "leave `method` out, or take an explicit one")


EXAMPLES = {
    "angles": "[-45 deg, 45 deg]",
    "at": "[{angle: 0 deg, stiffness: 1e8 N/m}]",
    "stiffness": "1e10 N/m/m",
}


def _told(load: "RingLoad") -> Iterator[Conflict]:
    """What this way of loading the ring needs, and what belongs to another one."""
    by: Path = (*LOAD, "by")
    for name in load.foreign:
        others = " or ".join(f"`by: {other}`" for other, keys in KEYS.items() if name in keys)
        hint = f"leave it out, or say {others}; a sweep takes all of `rig.load`"
        yield Conflict(f"foreign {name}", ((*LOAD, name), by, LOAD), f"`by: {load.by}` has no `{name}`", hint)
    if load.lacks:
        hint = f"say `{load.lacks}: {EXAMPLES[load.lacks]}`"
        paths: tuple[Path, ...] = (by, (*LOAD, load.lacks), LOAD)
        yield Conflict("lacks", paths, f"`by: {load.by}` needs `{load.lacks}`", hint)


def _load(load: "RingLoad") -> Iterator[Conflict]:
    if load.by == "pads":
        yield from _pads(load.angles or ())
    elif load.by == "points":
        yield from _points([point.angle for point in load.at or ()])
    elif load.by == "housing":
        yield from _housing(load)


def _pads(angles: tuple[float, ...]) -> Iterator[Conflict]:
    at: tuple[Path, ...] = ((*LOAD, "angles"), LOAD)
    along, across = sum(map(math.cos, angles)), sum(map(math.sin, angles))
    if _twice(angles):
        yield Conflict("pads", at, "two pads stand at the same angle", "give each angle once")
    elif along <= BALANCED * len(angles) or abs(across) > BALANCED * along:
        message = "equal forces at these angles do not add up to a load along the load line"
        yield Conflict("pads", at, message, "take angles on both sides of it, such as `[-45 deg, 45 deg]`")


def _points(angles: list[float]) -> Iterator[Conflict]:
    at: tuple[Path, ...] = ((*LOAD, "at"), LOAD)
    if _twice(angles):
        yield Conflict("points", at, "two springs stand at the same angle", "give each angle once")
    elif not any(math.cos(angle) > BALANCED for angle in angles):
        message = "no spring stands within 90 deg of the load line: nothing carries the load"
        yield Conflict("points", at, message, "give one at `angle: 0 deg`")


def _housing(load: "RingLoad") -> Iterator[Conflict]:
    assert load.stiffness is not None
    assert load.fit is not None
    if load.stiffness > STIFFEST:
        shown = f"{load.stiffness:.3g}".replace("e+", "e")
        message = f"a housing of {shown} N/m/m holds the ring as a rigid one"
        yield Conflict(
            "housing", ((*LOAD, "stiffness"), LOAD), message, "take a rigid ring, or at most 1e13 N/m/m"
        )
    if abs(load.fit) > LARGEST_FIT:
        message = f"a fit of {show(load.fit, 'um')} is beyond {show(LARGEST_FIT, 'um')}"
        yield Conflict("fit", ((*LOAD, "fit"), LOAD), message, "is the unit right?")


def _twice(angles: "tuple[float, ...] | list[float]") -> bool:
    """Whether two angles (rad) are the same."""
    turned = sorted(angle % (2.0 * math.pi) for angle in angles)
    gaps = [after - before for before, after in zip(turned, [*turned[1:], turned[0] + 2.0 * math.pi], strict=True)]
    return len(turned) > 1 and min(gaps) < SAME_ANGLE
