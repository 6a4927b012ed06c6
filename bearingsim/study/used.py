"""What a case uses of all it can say: the part that shapes its numbers, and so its id."""

from typing import Any

from bearingsim import catalogue
from bearingsim.config import Case
from bearingsim.config.case_fields import OLD_WORDS
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
    "bearing": {"element": "roller", "inner_groove_radius": None, "outer_groove_radius": None},
    "rig": {
        **dict.fromkeys(("torsion_stiffness", "torsion_damping", *MOUNT_FIELDS, "ring")),
        "sensor": {"on": "ring"},
        "load": dict.fromkeys(("angles", "at", "stiffness", "fit", "mass")),
    },
    "defects": {"roller": None, "offset": 0.0, "edge": None, "grown": None, "seed": None, "digest": None},
}
"""Values that do nothing. They are left out, so that a field that is new does not rename results that exist."""

IN_SPACE: dict[str, tuple[str, ...]] = {
    "bearing": ("roller_profile", "flanges"),
    "contact": ("slices",),
    "cage": ("axial_clearance",),
    "shaft": MOUNT_FIELDS,
}
"""Values that only the spatial model looks at."""


def used(case: Case) -> dict[str, Any]:
    """The case as nested values, without what does not shape its numbers."""
    values: dict[str, Any] = _without(_in_old_words(case.model_dump()), INACTIVE)
    if not _by_material(case) and case.bearing.element == "roller" and not _by_pressure(case):
        material = values["bearing"]["material"]
        del material["young_modulus"], material["poisson_ratio"]
    del values["rig"]["sensor"]["angle"]  # that of `sensor_angle`
    if case.rig.ring is None:
        del values["rig"]["sensor"], values["rig"]["load"]
    if not case.defects:
        values.pop("excitation", None)
    for defect in values["defects"]:
        defect.pop("file")  # what is in it counts, not where it lies
    if case.method is None:
        values.pop("prove", None)
    if not catalogue.MODELS[case.model].slips and case.excitation != "random-impulses":
        values.pop("seed", None)
    if catalogue.MODELS[case.model].sliced:
        del values["contact"]["length_nodes"]
    else:
        for section, names in IN_SPACE.items():
            for name in names if section in values else ():
                del values[section][name]
    return values | _extensions(case)


def _extensions(case: Case) -> dict[str, str]:
    """What the code of other packages was, if the case uses any: results of an edited law are others."""
    code = [catalogue.MODELS[case.model].module]
    code += [method.module for method in catalogue.METHODS.values() if method.name == case.method]
    laws = {"stiffness": case.contact.elastic_law, "damping": getattr(case.contact.damping, "law", "")}
    laws |= {"friction": getattr(case.friction, "law", "none")}
    code += [catalogue.LAWS[what][name].build for what, name in laws.items()]
    code += [catalogue.SHAPES[defect.shape].build for defect in case.defects]
    foreign = any(not where.startswith("bearingsim.") for where in code)
    return {"extensions": catalogue.extension_digest()} if foreign else {}


def _in_old_words(values: dict[str, Any]) -> dict[str, Any]:
    """The values by the words that ids were first made of: a new word must not rename results that exist."""
    new_to_old = {new: old for old, new in OLD_WORDS.items()}
    return {new_to_old.get(key, key): value for key, value in values.items()}


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
    kept = {key: _without(inner, idle.get(key)) for key, inner in value.items()}
    return {key: inner for key, inner in kept.items() if key not in idle or inner != idle[key]}
