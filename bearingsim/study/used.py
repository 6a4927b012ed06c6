"""Parameters of a case that affect its results, and therefore its id."""

import json
from functools import lru_cache, reduce
from operator import getitem
from typing import Any

from bearingsim import catalogue
from bearingsim.config import Case
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.config.channels import is_contact_force
from bearingsim.config.fields import Section
from bearingsim.config.rules.conflicts import MOUNT_FIELDS

INACTIVE: dict[str, Any] = {
    "ramp": None,
    "load_across": 0.0,
    "gravity": False,
    "excitation": "envelope",
    "friction": None,
    "cage": None,
    "drag": None,
    "shaft": None,
    "unbalance": None,
    "misalignment": None,
    "surfaces": {
        "outer": {"roundness": None, "spectrum": {"seed": None}},
        "inner": {"roundness": None, "spectrum": {"seed": None}},
    },
    "tolerance": "auto",
    "prove": True,
    "periodic": True,
    "until": None,
    "features": (),
    "bearing": {"element": "roller", "inner_groove_radius": None, "outer_groove_radius": None},
    "rig": {
        **dict.fromkeys(("torsion_stiffness", "torsion_damping", *MOUNT_FIELDS, "ring")),
        "sensor": {"on": "ring"},
        "load": dict.fromkeys(("angles", "at", "stiffness", "fit", "mass")),
    },
    "defects": {"roller": None, "offset": 0.0, "edge": None, "grown": None, "seed": None, "digest": None},
}
"""Values of fields without effect; ids omit them, so that a new field does not change the ids of results."""

OLD_NAMES = {new: old for old, new in DEPRECATED_KEYS.items()}
"""Deprecated names of keys, which ids still use so that renaming does not change the ids of results."""

SPATIAL_FIELDS: dict[str, tuple[str, ...]] = {
    "bearing": ("roller_profile", "flanges"),
    "contact": ("slices",),
    "cage": ("axial_clearance",),
    "shaft": MOUNT_FIELDS,
}
"""Fields that only affect the spatial model, by section."""


SENSOR_ANGLE = "sensor.angle"
"""Path of the sensor's angle in the rig, a duplicate of `sensor_angle`."""


def relevant_fields(case: Case) -> dict[str, str]:
    """Return the fields that affect a case's results, as JSON text with 12 significant digits, by name."""
    values = {OLD_NAMES.get(name, name): getattr(case, name) for name in Case.model_fields}
    texts = {
        name: _text(name, value, _unused(name, case))
        for name, value in values.items()
        if not _is_inactive(name, value)
    }
    if not case.defects:
        texts.pop("excitation", None)
    if case.method is None:
        texts.pop("prove", None)
    if case.antialias and any(map(is_contact_force, case.record)):
        texts["forces"] = '"raw"'  # earlier versions filtered them
    if not catalogue.MODELS[case.model].slips and case.excitation != "random-impulses":
        texts.pop("seed", None)
    return texts


def _is_inactive(name: str, value: Any) -> bool:
    """Return True for a field without effect; a section with inactive keys is one if it is None."""
    inactive = INACTIVE.get(name, ...)
    return value is None if isinstance(inactive, dict) else bool(value == inactive)


def is_random(case: Case) -> bool:
    """Return True if results depend on `seed`: with random impulses, or rollers with play in a free cage."""
    has_play = case.cage is not None and case.cage.motion == "free" and catalogue.MODELS[case.model].slips
    return case.excitation == "random-impulses" or has_play


def _unused(name: str, case: Case) -> tuple[str, ...]:
    """List the paths within a field that do not affect the case's results."""
    sliced = catalogue.MODELS[case.model].sliced
    paths = () if sliced else SPATIAL_FIELDS.get(name, ())
    if name == "bearing" and case.bearing.element == "roller" and not _uses_material(case):
        return (*paths, "material.young_modulus", "material.poisson_ratio")
    if name == "rig":
        return ("sensor", "load") if case.rig.ring is None else (SENSOR_ANGLE,)
    if name == "defects":
        return ("file",)  # the content affects results, not its location
    if name == "surfaces" and case.surfaces is not None:
        return tuple(f"{race}.roundness.file" for race in case.surfaces.profiles)
    return (*paths, "length_nodes") if name == "contact" and sliced else paths


def _text(name: str, value: Any, unused: tuple[str, ...]) -> str:
    if isinstance(value, Section):
        return _text_of_section(name, value, unused)
    if name == "defects":
        return "[" + ",".join(_text_of_section(name, defect, unused) for defect in value) + "]"
    return _text_of_plain(tuple(sorted(set(value))) if name in ("record", "features") else value)


@lru_cache(maxsize=1 << 16, typed=True)
def _text_of_plain(value: Any) -> str:
    return json_text(value)


@lru_cache(maxsize=1 << 16)
def _text_of_section(name: str, section: Section, unused: tuple[str, ...]) -> str:
    """Return the JSON text of a section, cached because many cases share one."""
    values = _remove_inactive(section.model_dump(), INACTIVE.get(name))
    for path in unused:
        *sections, last = path.split(".")
        del reduce(getitem, sections, values)[last]
    return json_text(values)


def json_text(value: Any) -> str:
    """Return a value as JSON with 12 significant digits, without names and sources."""
    return json.dumps(_canonical(value), sort_keys=True, separators=(",", ":"))


def _canonical(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.12g}") + 0.0  # no negative zero
    if isinstance(value, dict):
        return {key: _canonical(inner) for key, inner in value.items() if key not in ("name", "source")}
    if isinstance(value, list | tuple):
        return [_canonical(inner) for inner in value]
    return value


def extensions(case: Case) -> dict[str, str]:
    """Return the digest of the code of extensions, if the case uses any, because edited code changes results.

    Features of extensions count for every case, because they are computed from every record.
    """
    laws = {"stiffness": case.contact.elastic_law, "damping": getattr(case.contact.damping, "law", "")}
    laws |= {"friction": getattr(case.friction, "law", "none")}
    entries: list[catalogue.Entry] = [
        catalogue.MODELS[case.model],
        *(method for method in catalogue.METHODS.values() if method.name == case.method),
        *(catalogue.LAWS[kind][name] for kind, name in laws.items()),
        *(catalogue.SHAPES[defect.shape] for defect in case.defects),
        *catalogue.FEATURES.values(),
    ]
    uses_extension = any(
        catalogue.is_foreign(reference) for entry in entries for reference in catalogue.references(entry)
    )
    return {"extensions": catalogue.extension_digest()} if uses_extension else {}


def _uses_material(case: Case) -> bool:
    """Return True if results with rollers depend on the elastic constants: by a contact law, a flexible ring, or
    the width of the contact.
    """
    damping = getattr(case.contact.damping, "law", "")
    laws = catalogue.LAWS["stiffness"][case.contact.elastic_law], catalogue.LAWS["damping"][damping]
    return case.rig.ring is not None or any(law.material for law in laws) or _uses_width(case)


def _uses_width(case: Case) -> bool:
    """Return True if results depend on the width of the contact: by the excitation, or because it averages
    waviness.
    """
    is_wavy = case.surfaces is not None and bool(case.surfaces.highest_orders)
    return is_wavy or (bool(case.defects) and case.excitation in ("pressure-share", "elastic-edge"))


def _remove_inactive(value: Any, inactive: Any) -> Any:
    """Remove the entries without effect from a mapping, or from each mapping of a list."""
    if isinstance(value, list | tuple):
        return [_remove_inactive(inner, inactive) for inner in value]
    if not isinstance(value, dict) or not isinstance(inactive, dict):
        return value
    return {
        key: _remove_inactive(inner, inactive[key]) if isinstance(inactive.get(key), dict) else inner
        for key, inner in value.items()
        if key not in inactive or inner != inactive[key]
    }
