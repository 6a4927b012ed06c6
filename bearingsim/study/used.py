"""What a case uses of all it can say: the part that shapes its numbers, and so its id."""

import json
from functools import lru_cache, reduce
from operator import getitem
from typing import Any

from bearingsim import catalogue
from bearingsim.config import Case
from bearingsim.config.case_fields import OLD_WORDS
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
"""Values that do nothing. They are left out, so that a field that is new does not rename results that exist."""

OLD_NAMES = {new: old for old, new in OLD_WORDS.items()}
"""The words that ids were first made of: a new word must not rename results that exist."""

IN_SPACE: dict[str, tuple[str, ...]] = {
    "bearing": ("roller_profile", "flanges"),
    "contact": ("slices",),
    "cage": ("axial_clearance",),
    "shaft": MOUNT_FIELDS,
}
"""Values that only the spatial model looks at."""


ANGLE_OF_SENSOR = "sensor.angle"
"""It stands in `rig.sensor_angle`, too."""


def used(case: Case) -> dict[str, str]:
    """What shapes a case's numbers: the JSON text of each field, by name, 12 significant digits to a number."""
    found = {OLD_NAMES.get(name, name): getattr(case, name) for name in Case.model_fields}
    texts = {
        name: _text(name, value, _unused(name, case))
        for name, value in found.items()
        if name not in INACTIVE or isinstance(INACTIVE[name], dict) or value != INACTIVE[name]
    }
    if not case.defects:
        texts.pop("excitation", None)
    if case.method is None:
        texts.pop("prove", None)
    if case.antialias and any(map(is_contact_force, case.record)):
        texts["forces"] = '"raw"'  # earlier versions low-passed them
    if not catalogue.MODELS[case.model].slips and case.excitation != "random-impulses":
        texts.pop("seed", None)
    return texts


def is_random(case: Case) -> bool:
    """Whether another `seed` gives another result: of impulses at random, or of where rollers begin in a cage."""
    loose = case.cage is not None and case.cage.motion == "free" and catalogue.MODELS[case.model].slips
    return case.excitation == "random-impulses" or loose


def _unused(name: str, case: Case) -> tuple[str, ...]:
    """The paths within a field that do not shape the case's numbers."""
    sliced = catalogue.MODELS[case.model].sliced
    found = () if sliced else IN_SPACE.get(name, ())
    if (
        name == "bearing"
        and not _by_material(case)
        and case.bearing.element == "roller"
        and not _by_pressure(case)
    ):
        return (*found, "material.young_modulus", "material.poisson_ratio")
    if name == "rig":
        return ("sensor", "load") if case.rig.ring is None else (ANGLE_OF_SENSOR,)
    if name == "defects":
        return ("file",)  # what is in it counts, not where it lies
    return (*found, "length_nodes") if name == "contact" and sliced else found


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
    """Cached, because many cases share a section."""
    values = _without(section.model_dump(), INACTIVE.get(name))
    for path in unused:
        *sections, last = path.split(".")
        del reduce(getitem, sections, values)[last]
    return json_text(values)


def json_text(value: Any) -> str:
    """JSON with 12 significant digits, without names and sources."""
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
    """Return what the code of other packages was, if the case uses any: results of an edited law are others.

    Features of other packages are read from the record of every case.
    """
    laws = {"stiffness": case.contact.elastic_law, "damping": getattr(case.contact.damping, "law", "")}
    laws |= {"friction": getattr(case.friction, "law", "none")}
    entries: list[catalogue.Entry] = [
        catalogue.MODELS[case.model],
        *(method for method in catalogue.METHODS.values() if method.name == case.method),
        *(catalogue.LAWS[what][name] for what, name in laws.items()),
        *(catalogue.SHAPES[defect.shape] for defect in case.defects),
        *catalogue.FEATURES.values(),
    ]
    used = any(catalogue.foreign(place) for entry in entries for place in catalogue.places(entry))
    return {"extensions": catalogue.extension_digest()} if used else {}


def _by_material(case: Case) -> bool:
    """Whether the material's elastic constants enter: a contact law (as in any ball's contact), a bent ring."""
    damping = getattr(case.contact.damping, "law", "")
    used = catalogue.LAWS["stiffness"][case.contact.elastic_law], catalogue.LAWS["damping"][damping]
    return case.rig.ring is not None or any(law.material for law in used)


def _by_pressure(case: Case) -> bool:
    """Whether pits are felt by the elastic contact, which depends on the material."""
    return bool(case.defects) and case.excitation in ("pressure-share", "elastic-edge")


def _without(value: Any, idle: Any) -> Any:
    """The value less the entries that are idle; of a list, each of its mappings."""
    if isinstance(value, list | tuple):
        return [_without(inner, idle) for inner in value]
    if not isinstance(value, dict) or not isinstance(idle, dict):
        return value
    return {
        key: _without(inner, idle[key]) if isinstance(idle.get(key), dict) else inner
        for key, inner in value.items()
        if key not in idle or inner != idle[key]
    }
