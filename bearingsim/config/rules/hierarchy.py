"""The models from the lowest to the highest, what each can do, and which of them a case needs.

A need is firm where a model below would compute something else than what the case says: it is refused. A need
that is not firm is one of quality: a model below computes the case, but what is asked for is not worth much.
`least` heeds both; who names a model takes it as it is.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.config.channels import plain
from bearingsim.config.names import LINE_LOADS
from bearingsim.config.sections.contact import Constant, General, Kraemer
from bearingsim.config.sections.defect import IMPULSES, WEAKENED
from bearingsim.config.sections.free import Frictionless
from bearingsim.core.geometry.kinematics import cage_speed
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case import Case

LADDER = ("impulse", "static", "ring", "rollers", "planar", "spatial")
METHODLESS = ("impulse", "static")
ADAPTIVE = ("dop853", "dormand-prince", "rodas", "backward-euler")
"""Methods that choose their own steps by a tolerance; a case's `step` is then the time between records."""
FREE = ("planar", "spatial")
"""Models whose rollers and cage move freely."""
SLICED = ("spatial",)
"""Models whose rollers are cut into slices, and tilt."""

_STATIC = frozenset({"balance", "forces", "a second load", "shapes", "balls"})
_RING = _STATIC | {"damping", "acceleration", "weakened contact", "shared pressure"}
_ROLLERS = _RING | {"inertia of rollers"}
_PLANAR = _ROLLERS | {"ramp", "gravity", "friction", "cage", "drag", "shaft", "ring rotation", "slip"}
_SPATIAL = _PLANAR - {"balls", "shared pressure"} | {"tilt", "leaning rings", "profile"}

ABILITIES: dict[str, frozenset[str]] = {
    "impulse": frozenset({"impulses", "acceleration"}),
    "static": _STATIC,
    "ring": _RING,
    "rollers": _ROLLERS,
    "planar": _PLANAR,
    "spatial": _SPATIAL,
}

STRIBECK = 4.08  # largest load of a roller over the mean: no clearance, line contact (balls: 4.37)
NOTABLE = 0.1  # share of the largest load at rest from which the rollers' centrifugal force counts

MASSLESS = "damping that acts in full as a contact closes needs the mass of a roller"
"""Without, a ring that is thrown up closes contacts all round, ever smaller and faster (docs/stability.md)."""

Path = tuple[str | int, ...]


class Need(NamedTuple):
    """Something a case asks of its model: an ability, why in words, the paths that ask for it."""

    what: str
    why: str
    paths: tuple[Path, ...]
    firm: bool = True


def needs(case: "Case") -> list[Need]:
    """All that a case asks of its model."""
    found = [_of_defects, _of_sections, _of_shapes_along, _of_record, _of_masses]
    return [need for of in found for need in of(case)]


def least(case: "Case") -> str | None:
    """The lowest model that can do all that the case asks for, or else all that is firm; None if there is none."""
    found = needs(case)
    asked, firm = {need.what for need in found}, {need.what for need in found if need.firm}
    able = [model for wanted in (asked, firm) for model in LADDER if wanted <= ABILITIES[model]]
    return able[0] if able else None


def lacking(case: "Case") -> list[Need]:
    """The firm needs that the case's own model cannot meet."""
    return [need for need in needs(case) if need.firm and need.what not in ABILITIES[case.model]]


def reasons(case: "Case") -> list[str]:
    """What the case asks for that the least model can do and the one below it cannot, in words."""
    chosen = least(case)
    if chosen is None:
        return []
    below = ABILITIES[LADDER[LADDER.index(chosen) - 1]] if chosen != LADDER[0] else frozenset()
    able = ABILITIES[chosen] - below
    return list(dict.fromkeys(need.why for need in needs(case) if need.what in able))


# What asks for what


def _of_defects(case: "Case") -> Iterator[Need]:
    excitation: tuple[Path, ...] = (("excitation",),)
    if case.excitation in IMPULSES and "excitation" not in case.model_fields_set:
        return  # it came with the model
    if case.excitation in IMPULSES:
        yield Need("impulses", f"`{case.excitation}` is forces in time, which only `impulse` computes", excitation)
    elif case.defects:
        why = f"`{case.excitation}` moves the rollers on the bearing's elastic contacts"
        yield Need("shapes", why, excitation)
    else:
        yield Need("balance", "a healthy bearing vibrates by its varying compliance", (("defects",),))
    if case.defects and case.excitation in WEAKENED:
        why = f"`{case.excitation}` changes the force at the pit, which acts on the mass of a ring"
        yield Need("weakened contact", why, excitation)
    if case.defects and case.excitation == "pressure-share":
        why = "`pressure-share` splits the pressure of a whole roller, not of its slices"
        yield Need("shared pressure", why, excitation)
    for number, defect in enumerate(case.defects):
        if defect.offset != 0.0:
            why = "a defect off the roller's middle tilts the roller"
            yield Need("tilt", why, (("defects", number, "offset"),), firm=False)


_SECTIONS: tuple[tuple[str, str, str], ...] = (
    ("ramp", "ramp", "a `ramp` changes the speed under way"),
    ("friction", "friction", "`friction` acts where rollers can slip"),
    ("cage", "cage", "`cage` says how the cage moves"),
    ("drag", "drag", "`drag` brakes rollers and cage that can slip"),
    ("shaft", "shaft", "a `shaft` lets the inner ring move"),
    ("unbalance", "shaft", "an `unbalance` moves the inner ring"),
    ("misalignment", "leaning rings", "a `misalignment` loads the rollers unevenly along their length"),
)


def _of_sections(case: "Case") -> Iterator[Need]:
    for name, what, why in _SECTIONS:
        if _is_said(case, name):
            yield Need(what, why, ((name,),))
    if case.gravity:
        yield Need("gravity", "`gravity` pulls at rollers that move freely", (("gravity",),))
    if case.load_across != 0.0:
        yield Need("a second load", "`load_across` turns the load the rollers share", (("load_across",),))
    for name in ("torsion_stiffness", "torsion_damping"):
        if getattr(case.rig, name) is not None:
            yield Need("ring rotation", f"`rig.{name}` lets the outer ring rotate", (("rig", name), ("rig",)))
    for name in ("axial_stiffness", "axial_damping", "tilting_stiffness", "tilting_damping"):
        if getattr(case.rig, name) is not None:
            yield Need("leaning rings", f"`rig.{name}` lets the outer ring lean", (("rig", name), ("rig",)))
        if case.shaft is not None and getattr(case.shaft, name) is not None:
            yield Need("leaning rings", f"`shaft.{name}` lets the inner ring lean", (("shaft", name),))
    if "damping" in case.contact.model_fields_set:
        yield Need("damping", "`contact.damping` acts on motion", (("contact", "damping"),), firm=False)


def _of_shapes_along(case: "Case") -> Iterator[Need]:
    if case.bearing.roller_profile.shape != "straight":
        why = "`roller_profile` shapes the load along the roller"
        yield Need("profile", why, (("bearing", "roller_profile"), ("bearing",)))
    if case.bearing.element == "ball":
        yield Need("balls", "its elements are balls, which have no axis to tilt", (("bearing",),))


def _is_said(case: "Case", name: str) -> bool:
    """Whether a section is written: in a planar case some are filled in."""
    found: Any = getattr(case, name)
    return found is not None and not isinstance(found, Frictionless) and name in case.model_fields_set


_RECORDED = {
    "ring.acceleration": ("acceleration", "the ring's acceleration depends on its mass"),
    "ring.rotation": ("ring rotation", "`ring.rotation` is the turning of the outer ring"),
    "roller.radial": ("inertia of rollers", "where a roller is, apart from the races, is recorded"),
    "roller.outer_force": ("forces", "a contact force is recorded"),
    "roller.inner_force": ("forces", "a contact force is recorded"),
    "roller.outer_slip": ("slip", "slip is recorded"),
    "roller.inner_slip": ("slip", "slip is recorded"),
    "roller.cage_force": ("cage", "the force of a roller on the cage is recorded"),
    "roller.spin": ("slip", "the spin of a roller is recorded"),
    "cage.speed": ("cage", "the motion of the cage is recorded"),
    "cage.slip": ("cage", "the motion of the cage is recorded"),
    "cage.position": ("cage", "the motion of the cage is recorded"),
    "inner.displacement": ("shaft", "the motion of the inner ring is recorded"),
    "load_zone.rollers": ("forces", "the load zone is recorded"),
    **dict.fromkeys(
        (
            "roller.tilt",
            "roller.skew",
            "roller.axial",
            "roller.flange_force",
            *(f"roller.{x}" for x in LINE_LOADS),
        ),
        ("tilt", "how a roller leans and is loaded along its length is recorded"),
    ),
    **dict.fromkeys(
        ("ring.axial", "ring.lean", "inner.axial", "inner.lean", "cage.axial", "cage.lean"),
        ("leaning rings", "the motion of a ring out of its plane is recorded"),
    ),
}


def _of_record(case: "Case") -> Iterator[Need]:
    for index, name in enumerate(case.record):
        known = _RECORDED.get(plain(name))
        if known:
            what, why = known
            yield Need(what, why, (("record", index),), firm=what != "acceleration")


def _of_masses(case: "Case") -> Iterator[Need]:
    """Rollers that do not follow: thrown into a pit, or outwards by their orbit."""
    shown = [plain(name) for name in case.record]
    sharp = any(name.startswith("roller.") or name == "ring.acceleration" for name in shown)
    if case.defects and case.excitation not in IMPULSES and sharp:
        why = "how a roller strikes the far edge of a pit, and its force there, depend on its mass"
        yield Need("inertia of rollers", why, (("record",),), firm=False)
    if case.defects and case.excitation not in IMPULSES and jumps(case):
        yield Need("inertia of rollers", MASSLESS, (("contact", "damping"),), firm=False)
    force = _centrifugal_force(case)
    load = STRIBECK * math.hypot(case.load, case.load_across) / case.bearing.rollers
    if force > NOTABLE * load:
        why = (
            f"the centrifugal force of a roller ({show(force, 'N')}) is {force / load:.0%} of the largest load"
            f" at rest ({show(load, 'N')})"
        )
        yield Need("inertia of rollers", why, (("speed",), ("load",)), firm=False)


def jumps(case: "Case") -> bool:
    """Whether contacts are damped in full as soon as they close: their force jumps then."""
    match case.contact.damping:
        case General(coefficient=c, indentation_exponent=m3):
            return c > 0.0 and math.isclose(m3, 0.0, abs_tol=1e-12)
        case Kraemer(beta=beta):
            stiffness = case.contact.stiffness
            return beta > 0.0 and isinstance(stiffness, Constant) and math.isclose(stiffness.exponent, 1.0)
    return False


def _centrifugal_force(case: "Case") -> float:
    """m omega_c^2 d_m/2 of one rolling element at the highest speed, N."""
    bearing = case.bearing
    speed = max(case.speed, case.ramp.to) if case.ramp else case.speed
    omega = cage_speed(speed, bearing.roller_diameter, bearing.pitch_diameter)
    return bearing.element_mass * omega**2 * bearing.pitch_diameter / 2.0
