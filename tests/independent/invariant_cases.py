"""Cases in other units of length, seen from another angle, with rollers numbered otherwise, or in a mirror.

With lengths and times times L, masses times L^3 and forces times L^2, and the same material, the mechanics are
equal: velocities stay, approaches grow by L. A turned case has its load, defects, supports and start at angles
greater by the same amount. Renumbered rollers start one pocket further, and the defect is on another number. In a
mirror in the middle plane of the bearing, offsets, misalignment, tilt and axial motion change their sign.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bearingsim.config import Case

ROLLERS = 13


@dataclass(frozen=True)
class View:
    """Size, angle (deg), number of the first roller and orientation along the axis (1 or -1)."""

    size: float = 1.0
    angle: float = 0.0
    renumbered: int = 0
    mirror: float = 1.0

    def quantity(self, value: float, unit: str, power: float) -> str:
        """Quantity that grows with the size to this power."""
        return f"{value * self.size**power!r} {unit}"

    def at(self, angle: float) -> str:
        return f"{angle + self.angle!r} deg"

    def mm(self, value: float) -> str:
        return self.quantity(value, "mm", 1)

    def um(self, value: float) -> str:
        return self.quantity(value, "um", 1)

    def roller(self, number: int) -> int:
        return (number - 1 - self.renumbered) % ROLLERS + 1


def base(view: View, model: str) -> dict[str, Any]:
    """Bearing, speed, load and support."""
    load, angle = 250.0, math.radians(view.angle)
    return {
        "bearing": {
            "element": "roller", "rollers": ROLLERS, "roller_diameter": view.mm(12), "roller_length": view.mm(12),
            "pitch_diameter": view.mm(65), "bore": view.mm(40), "outside_diameter": view.mm(90),
            "width": view.mm(23),
        },
        "model": model, "method": "verlet", "step_check": False, "speed": view.quantity(1800, "rpm", -1),
        "load": view.quantity(load * math.cos(angle), "N", 2), "clearance": view.um(3),
        "load_across": view.quantity(load * math.sin(angle), "N", 2),
        "start_angle": view.at(-4.0 + view.renumbered * 360 / ROLLERS),
        "contact": {"damping": {"law": "kraemer", "beta": view.quantity(2.5, "us", 1)}},
        "rig": {
            "bracket_stiffness": view.quantity(1e7, "N/m", 1), "bracket_damping": view.quantity(200, "N s/m", 2),
            "ring_mass": view.quantity(0.3, "kg", 3),
        },
    }  # fmt: skip


def defect(
    view: View, shape: str, length: float, width: float, depth: float, angle: float = 0.0, **other: Any
) -> dict:
    """Defect with lengths in mm, depth in um; on a race it turns with the view."""
    offset = view.mirror * other.pop("offset", 0.0)
    on_roller = other.get("race") == "roller"
    return {
        "shape": shape, "length": view.mm(length), "width": view.mm(width), "depth": view.um(depth),
        "angle": f"{angle!r} deg" if on_roller else view.at(angle), "offset": view.mm(offset),
    } | other  # fmt: skip


def sharp(view: View) -> list[dict]:
    """Defects of all elements with closed forms, soon after the start."""
    return [
        defect(view, "rectangular", 7, 0.5, 30),
        defect(view, "circular", 8, 0.9, 9, 12.0, race="inner", offset=1.0),
        defect(view, "rectangular", 12, 0.5, 20, 7.0, race="roller", roller=view.roller(1)),
    ]


def rollers(view: View) -> dict[str, Any]:
    return base(view, "rollers") | {"defects": sharp(view)}


def ring(view: View) -> dict[str, Any]:
    return base(view, "ring") | {"defects": sharp(view)}


def planar(view: View) -> dict[str, Any]:
    fields = base(view, "planar") | {
        "defects": sharp(view), "friction": "traction",
        "shaft": {
            "stiffness": view.quantity(3e7, "N/m", 1), "mass": view.quantity(1.2, "kg", 3),
            "damping": view.quantity(300, "N s/m", 2),
        },
        "unbalance": {"mass_radius": view.quantity(50, "g mm", 4), "angle": view.at(30)},
        "cage": {"pocket_clearance": view.mm(0.15), "pocket_stiffness": view.quantity(1e7, "N/m", 1)},
    }  # fmt: skip
    torsion = {"stiffness": view.quantity(1e4, "N m/rad", 3), "damping": view.quantity(0.3, "N m s/rad", 4)}
    fields["rig"] |= {f"torsion_{name}": value for name, value in torsion.items()}
    return fields


def spatial(view: View) -> dict[str, Any]:
    """Tilted rings on springs, a crowned roller between flanges, three defects off the middle; not for sizes."""
    mount = {
        "axial_stiffness": "1e7 N/m", "axial_damping": "100 N s/m", "tilting_stiffness": "2e4 N m/rad",
        "tilting_damping": "1 N m s/rad",
    }  # fmt: skip
    fields = base(view, "spatial") | {
        "misalignment": {
            "inner": f"{0.4 * view.mirror!r} mrad", "outer": f"{-0.2 * view.mirror!r} mrad",
            "direction": view.at(30),
        },
        "shaft": {"stiffness": "3e7 N/m", "mass": "1.2 kg", "damping": "300 N s/m"} | mount,
        "defects": [
            defect(view, "rectangular", 3, 0.5, 20, offset=2.0),
            defect(view, "circular", 6, 0.9, 15, 12.0, race="inner", offset=-3.0),
            defect(view, "rectangular", 4, 0.5, 10, 7.0, race="roller", roller=view.roller(1), offset=1.5),
        ],
    }  # fmt: skip
    fields["bearing"] |= {
        "roller_profile": {"shape": "crowned", "drop": "3 um", "straight_length": "6 mm"},
        "flanges": {"inner": 2, "outer": 2, "clearance": "40 um"},
    }
    fields["rig"] |= mount
    return fields


def flexible(view: View) -> dict[str, Any]:
    """A ring that bends on four unequal springs; not for sizes."""
    fields = base(view, "rollers") | {"defects": sharp(view)}
    springs = ((-120, 1e8), (-30, 4e8), (40, 3e8), (170, 2e8))
    at = [{"angle": view.at(angle), "stiffness": f"{k!r} N/m"} for angle, k in springs]
    fields["rig"] |= {
        "ring": {"bends": True, "harmonics": 8, "damping": "1 %"},
        "load": {"by": "points", "mass": "1 kg", "at": at},
        "sensor": {"on": "ring", "angle": view.at(10)},
    }
    return fields


def case_of(make: Callable, view: View, **other: Any) -> Case:
    """The case of one of the functions above."""
    return Case.model_validate(make(view) | other)
