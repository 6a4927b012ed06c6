"""Abilities of the model that a case needs, and the simplest model of the catalogue that has them.

A need is required if a model without the ability cannot represent the case; such a model is rejected. Other needs
are desired; a model without the ability computes the case with poor accuracy. ``simplest_model`` and
``reference_model`` consider both, but a model that the study names is only checked for the required ones.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim import catalogue
from bearingsim.config.channels import without_numbers
from bearingsim.config.names import LINE_LOADS
from bearingsim.config.sections.defect import IMPULSE_EXCITATIONS, STIFFNESS_EXCITATIONS
from bearingsim.config.sections.free import Frictionless
from bearingsim.core.geometry.kinematics import cage_speed

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields

STRIBECK_NUMBER = 4.08
"""Largest roller load over F/Z, for line contacts without clearance; also used for balls, which have 4.37."""
MIN_CENTRIFUGAL_SHARE = 0.1
"""Centrifugal force, relative to the largest roller load, above which the model needs roller inertia."""

KINEMATIC_CHANNELS = (
    "cage.slip",
    "cage.axial",
    "cage.lean",
    "roller.cage_force",
    "roller.skew",
    "roller.axial",
    "roller.flange_force",
)
"""Channels that stay zero with a kinematic cage."""

NEEDS_ROLLER_MASS = "a damping force at first contact needs the mass of a roller"
"""Reason to advise a model with roller mass if a run stalls: without that mass, the contacts of a ring that has
lifted off close in ever smaller and more frequent impacts (docs/stability.md)."""

Path = tuple[str | int, ...]


class Need(NamedTuple):
    """Need of a case: an ability of the model, its reason for messages, and the paths of the keys that cause it.

    required: False if a model without the ability is only less accurate.
    """

    ability: str
    reason: str
    paths: tuple[Path, ...]
    required: bool = True


def needs(case: "CaseFields") -> list[Need]:
    """List all abilities of the model that a case needs."""
    checks = [_defect_needs, _section_needs, _shape_needs, _record_needs, _mass_needs]
    return [need for check in checks for need in check(case)]


def simplest_model(case: "CaseFields") -> str | None:
    """Return the first model with all needed abilities, or else with all required ones; None if there is none."""
    all_needs = needs(case)
    desired, required = {need.ability for need in all_needs}, {need.ability for need in all_needs if need.required}
    models = catalogue.MODELS.values()
    names = [model.name for abilities in (desired, required) for model in models if abilities <= model.abilities]
    return names[0] if names else None


def reference_model(case: "CaseFields") -> str | None:
    """Return the reference model: the first of ``catalogue.REFERENCES`` with all needed abilities.

    If there is none, return the first with all required ones, or None.
    """
    all_needs = needs(case)
    desired, required = {need.ability for need in all_needs}, {need.ability for need in all_needs if need.required}
    models = [catalogue.MODELS[name] for name in catalogue.REFERENCES]
    names = [model.name for abilities in (desired, required) for model in models if abilities <= model.abilities]
    return names[0] if names else None


def omitted_needs(case: "CaseFields") -> list[Need]:
    """List the needs of a case, required or desired, that its model does not meet."""
    return [need for need in needs(case) if need.ability not in catalogue.MODELS[case.model].abilities]


def specifies_slip(case: "CaseFields") -> bool:
    """Check if a case specifies cage, drag or friction (other than `none`), or records a related quantity.

    Such quantities are slip, cage motion, and motions and forces that are zero with a kinematic cage.
    """
    is_specified = any(_is_specified(case, name) for name in ("cage", "friction", "drag"))
    slips, channels = ("slip", "cage"), [without_numbers(name) for name in case.record]
    return is_specified or any(
        name in KINEMATIC_CHANNELS or _RECORD_ABILITIES.get(name, ("", ""))[0] in slips for name in channels
    )


def has_default_friction(case: "CaseFields") -> bool:
    """Check if the model of a case computes slip, but the case neither specifies nor records it.

    A case specifies slip by `friction`, even `none`, by `cage` or by `drag`.
    """
    slips = catalogue.MODELS[case.model].slips
    return slips and not specifies_slip(case) and "friction" not in case.model_fields_set


def unmet_needs(case: "CaseFields") -> list[Need]:
    """List the required needs of a case that its model does not meet."""
    return [
        need
        for need in needs(case)
        if need.required and need.ability not in catalogue.MODELS[case.model].abilities
    ]


def reasons(case: "CaseFields") -> list[str]:
    """List the reasons why the simplest suitable model is needed instead of the next simpler one.

    The list has no duplicates, and is empty if no model is suitable.
    """
    model = simplest_model(case)
    if model is None:
        return []
    order = list(catalogue.MODELS)
    simpler = catalogue.MODELS[order[order.index(model) - 1]].abilities if model != order[0] else frozenset()
    added = catalogue.MODELS[model].abilities - simpler
    return list(dict.fromkeys(need.reason for need in needs(case) if need.ability in added))


# Needs by field of a case


def _defect_needs(case: "CaseFields") -> Iterator[Need]:
    excitation: tuple[Path, ...] = (("excitation",),)
    if case.excitation in IMPULSE_EXCITATIONS and "excitation" not in case.model_fields_set:
        return  # filled in by default for a model without defect geometry
    if case.excitation in IMPULSE_EXCITATIONS:
        yield Need(
            "impulses", f"`{case.excitation}` is a force history, which only `impulse` computes", excitation
        )
    elif case.defects:
        reason = f"`{case.excitation}` needs elastic contacts"
        yield Need("shapes", reason, excitation)
    else:
        yield Need("balance", "a healthy bearing vibrates due to varying compliance", (("defects",),))
    if case.defects and case.excitation in STIFFNESS_EXCITATIONS:
        reason = f"`{case.excitation}` changes the contact force, which needs the mass of a ring"
        yield Need("weakened contact", reason, excitation)
    if case.defects and case.excitation == "pressure-share":
        reason = "`pressure-share` splits the pressure of a whole roller, not of its slices"
        yield Need("shared pressure", reason, excitation)
    for number, defect in enumerate(case.defects):
        if defect.offset != 0.0:
            reason = "an `offset` tilts the roller"
            yield Need("tilt", reason, (("defects", number, "offset"),), required=False)


_SECTIONS: tuple[tuple[str, str, str], ...] = (
    ("ramp", "ramp", "a `ramp` changes the speed"),
    ("friction", "friction", "`friction` needs rollers that can slip"),
    ("cage", "cage", "`cage` needs a cage that can move"),
    ("drag", "drag", "`drag` needs rollers and a cage that can slip"),
    ("shaft", "shaft", "a `shaft` needs a moving inner ring"),
    ("unbalance", "shaft", "an `unbalance` needs a moving inner ring"),
    ("surfaces", "form", "`surfaces` needs a model that includes surface form"),
    ("misalignment", "tilting rings", "a `misalignment` loads the rollers unevenly along their length"),
)
"""Sections with the ability that each needs, and the reason."""


def _section_needs(case: "CaseFields") -> Iterator[Need]:
    for name, ability, reason in _SECTIONS:
        if _is_specified(case, name):
            yield Need(ability, reason, ((name,),))
    if case.gravity:
        yield Need("gravity", "`gravity` needs rollers that can slip", (("gravity",),))
    if case.load_across != 0.0:
        yield Need("a second load", "`load_across` changes the direction of the load", (("load_across",),))
    if case.rig.ring is not None:
        paths: tuple[Path, ...] = (("rig", "ring", "bends"), ("rig", "ring"), ("rig",))
        yield Need("bending ring", "`rig.ring` lets the outer ring bend", paths)
    for name in ("torsion_stiffness", "torsion_damping"):
        if getattr(case.rig, name) is not None:
            yield Need("ring rotation", f"`rig.{name}` lets the outer ring rotate", (("rig", name), ("rig",)))
    for name in ("axial_stiffness", "axial_damping", "tilting_stiffness", "tilting_damping"):
        if getattr(case.rig, name) is not None:
            yield Need("tilting rings", f"`rig.{name}` lets the outer ring tilt", (("rig", name), ("rig",)))
        if case.shaft is not None and getattr(case.shaft, name) is not None:
            yield Need("tilting rings", f"`shaft.{name}` lets the inner ring tilt", (("shaft", name),))
    if "damping" in case.contact.model_fields_set:
        yield Need("damping", "`contact.damping` needs a moving ring", (("contact", "damping"),), required=False)


def _shape_needs(case: "CaseFields") -> Iterator[Need]:
    if case.bearing.roller_profile.shape != "straight":
        reason = "`roller_profile` needs the load distribution along the roller"
        yield Need("profile", reason, (("bearing", "roller_profile"), ("bearing",)))
    if case.bearing.element == "ball":
        yield Need("balls", "tilt and skew are defined for rollers, not for balls", (("bearing",),))


def _is_specified(case: "CaseFields", name: str) -> bool:
    """Check if a section is specified by the study, not filled in by default."""
    section: Any = getattr(case, name)
    return section is not None and not isinstance(section, Frictionless) and name in case.model_fields_set


_RECORD_ABILITIES = {
    "ring.acceleration": ("acceleration", "acceleration depends on the masses"),
    "sensor.acceleration": ("acceleration", "acceleration depends on the masses"),
    "ring.rotation": ("ring rotation", "the rotation of the outer ring is recorded"),
    "roller.radial": ("roller inertia", "the radial motion of a roller is recorded"),
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
    "roller.tilt": ("tilt", "the tilt of a roller is recorded"),
    "roller.skew": ("tilt", "the skew of a roller is recorded"),
    "roller.axial": ("tilt", "the axial motion of a roller is recorded"),
    "roller.flange_force": ("tilt", "the flange force of a roller is recorded"),
    **dict.fromkeys((f"roller.{load}" for load in LINE_LOADS), ("tilt", "the line load of a roller is recorded")),
    **dict.fromkeys(
        ("ring.axial", "ring.lean", "inner.axial", "inner.lean", "cage.axial", "cage.lean"),
        ("tilting rings", "the out-of-plane motion of a ring is recorded"),
    ),
}
"""Ability that each channel needs, and the reason; a channel that is not listed needs none."""


def _record_needs(case: "CaseFields") -> Iterator[Need]:
    for index, name in enumerate(case.record):
        entry = _RECORD_ABILITIES.get(without_numbers(name))
        if entry:
            ability, reason = entry
            yield Need(ability, reason, (("record", index),), required=ability != "acceleration")


def _mass_needs(case: "CaseFields") -> Iterator[Need]:
    """Yield the needs for roller inertia due to impacts at a defect, a jump of the damping force, or rotation."""
    channels = [without_numbers(name) for name in case.record]
    records_impacts = any(name.startswith("roller.") or name.endswith(".acceleration") for name in channels)
    if case.defects and case.excitation not in IMPULSE_EXCITATIONS and records_impacts:
        reason = "the impact depends on a roller's mass"
        yield Need("roller inertia", reason, (("record",),), required=False)
    if case.defects and case.excitation not in IMPULSE_EXCITATIONS and case.contact.jumps:
        yield Need(
            "roller inertia",
            "this damping law needs the mass of the rollers",
            (("contact", "damping"),),
            required=False,
        )
    force = _centrifugal_force(case)
    roller_load = STRIBECK_NUMBER * math.hypot(case.load, case.load_across) / case.bearing.rollers
    if force > MIN_CENTRIFUGAL_SHARE * roller_load:
        reason = f"centrifugal force {100.0 * force / roller_load:.0f} % of roller load"
        yield Need("roller inertia", reason, (("speed",), ("load",)), required=False)


def _centrifugal_force(case: "CaseFields") -> float:
    """Compute the centrifugal force m omega_c^2 d_m/2 (N) of a rolling element at the highest speed."""
    bearing = case.bearing
    speed = max(case.speed, case.ramp.to) if case.ramp else case.speed
    omega = cage_speed(speed, bearing.roller_diameter, bearing.pitch_diameter)
    return bearing.element_mass * omega**2 * bearing.pitch_diameter / 2.0
