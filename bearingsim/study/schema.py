"""A JSON schema of study files, for editors."""

from typing import Any

from bearingsim.config import Case
from bearingsim.config.case import LAWS
from bearingsim.designs import KINDS
from bearingsim.study.distributions import DISTRIBUTIONS
from bearingsim.study.figures import DRAWN
from bearingsim.study.sweep import GENERATORS
from bearingsim.study.uncertainty import NONE, UNKNOWN, UNKNOWNS

_WORDS = {"type": ["string", "array"], "items": {"type": "string"}}


def json_schema() -> dict[str, Any]:
    """The schema of a study file (JSON Schema 2020-12)."""
    case = Case.model_json_schema()
    fields = _case_fields(case)
    own = {
        "study": {"type": "string", "description": "name of the study: letters, digits, - _ ."},
        "figures": {"type": "array", "items": _figure()},
        "sweep": _sweep(),
        "uncertainty": _uncertainty(),
        "quick": {"type": "object", "properties": fields | {"sweep": _sweep()}},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "bearingsim study",
        "type": "object",
        "properties": own | fields,
        "required": ["study"],
        "additionalProperties": False,
        "$defs": case["$defs"],
    }


def _case_fields(case: dict[str, Any]) -> dict[str, Any]:
    """The fields of a case; what is a section in Python may be a name in a file."""
    fields = dict(case["properties"])
    del case["$defs"]["Defect"]["properties"]["digest"]  # not for users to set
    for name in ("bearing", "rig"):
        fields[name] = {"anyOf": [{"type": "string"}, {"$ref": f"#/$defs/{name.capitalize()}"}]}
    material = {"anyOf": [{"type": "string"}, {"$ref": "#/$defs/Material"}]}
    case["$defs"]["Bearing"]["properties"]["material"] = material
    for path, laws in LAWS.items():
        where = case["$defs"]["Contact"]["properties"] if path[0] == "contact" else fields
        where[path[-1]] = {"anyOf": [{"type": "string", "enum": list(laws.words)}, where[path[-1]]]}
    rig = case["$defs"]["Rig"]["properties"]
    for holder, names in ((fields, ("ramp", "drag", "shaft", "unbalance")), (rig, ("ring", "load"))):
        holder.update({name: {"anyOf": [{"const": "none"}, holder[name]]} for name in names})
    return fields | {"defect": {"$ref": "#/$defs/Defect"}}


def _uncertainty() -> dict[str, Any]:
    values = {"type": "array", "items": {"type": ["string", "number"]}, "minItems": 2}
    properties = {what: {"const": UNKNOWN} if known.choices else values for what, known in UNKNOWNS.items()}
    return {
        "anyOf": [
            {"const": NONE},
            {"type": "object", "properties": properties, "additionalProperties": False},
        ]
    }


def _figure() -> dict[str, Any]:
    names = {"type": "string", "enum": list(DRAWN)}
    properties = {
        "y": {"anyOf": [names, {"type": "array", "items": names}]},
        "x": {"type": "string"},
        "by": _WORDS,
        "panels": _WORDS,
        "where": {"type": "object"},
        "title": {"type": "string"},
        "log": _WORDS,
    }
    return {"type": "object", "properties": properties, "required": ["y", "x"], "additionalProperties": False}


def _sweep() -> dict[str, Any]:
    three = {"type": "array", "minItems": 3, "maxItems": 3}
    generated = [
        {"type": "object", "properties": {word: three}, "required": [word], "additionalProperties": False}
        for word in GENERATORS
    ]
    values = {"anyOf": [{"type": "array", "minItems": 1}, *generated]}
    block = {"type": "object", "additionalProperties": values}
    zipped = {"anyOf": [block, {"type": "array", "items": block}]}
    words = {"type": "string"}
    own: dict[str, Any] = {
        "zip": zipped,
        **dict.fromkeys(KINDS, _design()),
        "derived": {"type": "object", "additionalProperties": {"type": ["string", "number"]}},
        "where": {"anyOf": [words, {"type": "array", "items": words}]},
        "repeat": {"type": "integer", "minimum": 1},
    }
    return {"type": "object", "properties": own, "additionalProperties": values}


def _design() -> dict[str, Any]:
    two = {"type": "array", "items": {"type": ["string", "number"]}, "minItems": 2, "maxItems": 2}
    spread = dict.fromkeys((*DISTRIBUTIONS, "within"), two)
    ranges = {"anyOf": [two, {"type": "object", "properties": spread, "additionalProperties": False}]}
    keys = {
        "n": {"type": "integer", "minimum": 1},
        "seed": {"type": "integer", "minimum": 0},
        "over": {"type": "object", "additionalProperties": ranges},
    }
    return {"type": "object", "properties": keys, "additionalProperties": False}
