"""JSON schema of study files, for completion and validation in editors.

It uses draft 7, which YAML editors support. `check` rejects all files that the schema rejects, and also conflicts
between values, which a schema cannot express. Sections that can be swept have no required keys, because the sweep
may set them.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from bearingsim import figure_kinds
from bearingsim.catalogue import AUTO
from bearingsim.config import Case, Defect, Section, bands
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.config.fields import POSITIVE, Schema, integer_schema, quantity_schema
from bearingsim.designs import KINDS
from bearingsim.study import descriptions
from bearingsim.study.design import MAX_SEED
from bearingsim.study.distributions import DISTRIBUTIONS
from bearingsim.study.figures import PLOT_COLUMNS
from bearingsim.study.goal import EXCLUDED_KEYS, GOAL_FEATURES, STEP_REASON
from bearingsim.study.load import STUDY_NAME
from bearingsim.study.paths import ITEM_LISTS, fields_by_path, known_paths, without_number
from bearingsim.study.section_schemas import describe, one_of, section_schemas
from bearingsim.study.sweep import GENERATORS, MAX_VALUES
from bearingsim.study.uncertainty import NONE, PARAMETER_KINDS, UNKNOWN, ParameterKind
from bearingsim.text.units import UNITS

_TEXT = {"type": ["string", "number", "boolean"]}
BAND_NAME: Schema = {"type": "string", "pattern": bands.PATTERN}
_NUMBER = r"\.[0-9]{1,4}"
_NUMBERED_PATH = "^defects" + _NUMBER
_FIRST_QUANTITIES = tuple(f"{items}.1" for items in ITEM_LISTS if known_paths()[items])
"""Paths to the first items of lists of quantities."""
_ITEMS = "|".join(f"^{re.escape(items)}{_NUMBER}" for items in ITEM_LISTS)


def schema_text() -> str:
    """Return the schema as the text of a file."""
    return json.dumps(json_schema(), indent=1) + "\n"


def json_schema() -> Schema:
    """Build the schema of a study file."""
    names, sections = section_schemas()
    case = sections.pop(names[Case])["properties"]
    defect = case["defects"]["items"]

    def value_at(path: str) -> Schema:
        """Return the schema of one value of a path."""
        if path == "defect":
            return defect
        if path in _FIRST_QUANTITIES:
            return _definition(f"Any {known_paths()[without_number(path)]}")
        return one_of(_ref(names, *field) for field in fields_by_path()[DEPRECATED_KEYS.get(path, path)])

    schema: Schema = {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "bearingsim study",
        "type": "object",
        "properties": {
            "study": _TEXT | {"pattern": f"^{STUDY_NAME.pattern}$"},
            **case,
            "defect": defect,
            **{
                old: value_at(old) | {"deprecated": True, "description": f"Old name of `{new}`."}
                for old, new in DEPRECATED_KEYS.items()
            },
            "accuracy": _accuracy(),
            "sweep": _sweep(required=["n", "over"]),
            "figures": {"type": "array", "items": _figure()},
            "uncertainty": {
                "anyOf": [
                    {"const": NONE},
                    _closed_mapping(
                        {key: _uncertain_values(parameter) for key, parameter in PARAMETER_KINDS.items()}
                    ),
                ]
            },
            "measured": {"type": "array", "items": _measured(), "minItems": 1},
            "quick": _path_mapping(_paths(), value_at, {"sweep": _sweep(required=[])}),
        },
        "required": ["study"],
        "additionalProperties": False,
        "allOf": [*_exclusions(), *_requirements()],
        "$defs": sections | _definitions(value_at),
    }
    properties = schema["properties"]
    describe(properties, descriptions.STUDY_KEYS)
    describe(properties["accuracy"]["anyOf"][-1]["properties"], descriptions.ACCURACY_KEYS)
    describe(properties["uncertainty"]["anyOf"][-1]["properties"], descriptions.UNCERTAINTY_KEYS)
    return schema


def _definitions(value_at: Callable[[str], Schema]) -> dict[str, Schema]:
    """Return the schemas of features, paths and swept values, by the name in a reference."""
    definitions: dict[str, Schema] = {
        "Feature": {"anyOf": [{"enum": list(PLOT_COLUMNS)}, BAND_NAME]},
        "Path": {"anyOf": [{"enum": _paths()}, {"type": "string", "pattern": f"{_NUMBERED_PATH}|{_ITEMS}"}]},
        "Values": _path_mapping(_paths(), lambda path: _values(path, value_at(path))),
        "Ranges": _path_mapping(
            filter(_kind_of_quantity, _paths()), lambda path: _definition(f"Range {_kind(path)}")
        ),
        "Generated whole": _generator({"type": "number"}),
    }
    for dimension in UNITS:
        any_value = _definition(f"Any {dimension}")
        definitions |= {
            f"Any {dimension}": quantity_schema(dimension),
            f"Generated {dimension}": _generator(any_value),
            f"Range {dimension}": _range(any_value),
        }
    return {name.replace(" ", "-"): schema for name, schema in definitions.items()}


def _closed_mapping(properties: Mapping[str, Schema], required: Iterable[str] = ()) -> Schema:
    """Return the schema of a mapping with these keys and no others."""
    schema = {"type": "object", "properties": dict(properties), "additionalProperties": False}
    return schema | ({"required": [*required]} if required else {})


# Paths


def _paths() -> list[str]:
    """List every path that a study may sweep, including deprecated keys."""
    return [*known_paths(), *_FIRST_QUANTITIES, *DEPRECATED_KEYS]


def _ref(names: Mapping[type[Section], str], section: type[Section], name: str) -> Schema:
    pointer = "#" if section is Case else f"#/$defs/{names[section]}"
    return {"$ref": f"{pointer}/properties/{name}"}


def _definition(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name.replace(' ', '-')}"}


def _path_mapping(
    paths: Iterable[str], schema: Callable[[str], Schema], more: Mapping[str, Schema] = {}
) -> Schema:
    """Return the schema of a mapping with paths, numbered paths into lists, and ``more`` keys."""
    schemas = {path: schema(path) for path in paths}
    defect_paths = [path for path in schemas if path.split(".")[0] == "defect"]
    numbered = {
        _NUMBERED_PATH + re.escape(path.removeprefix("defect")) + "$": schemas[path] for path in defect_paths
    }
    for items in ITEM_LISTS:
        rests = [path.removeprefix(items).removeprefix(".1") for path in schemas if path.startswith(items + ".")]
        numbered |= {
            f"^{re.escape(items)}{_NUMBER}{re.escape(rest)}$": schemas[f"{items}{rest or '.1'}"] for rest in rests
        }
    return _closed_mapping(schemas | dict(more)) | {"patternProperties": numbered}


def _kind_of_quantity(path: str) -> str | None:
    return known_paths().get(without_number(path))


def _kind(path: str) -> str:
    """Return the kind of generated values of a path: a dimension, `whole`, or empty if none are possible."""
    plain = without_number(path)
    dimension = known_paths().get(plain)
    return dimension or ("whole" if any(int in field.marks for field in fields_by_path().get(plain, ())) else "")


def _values(path: str, value: Schema) -> Schema:
    """Return the schema of the values of a swept path: a list, or a generator for numbers."""
    array = {"type": "array", "items": value, "minItems": 1}
    kind = _kind(path)
    return one_of([array, _definition(f"Generated {kind}")] if kind else [array])


def _generator(number: Schema) -> Schema:
    last = dict.fromkeys(GENERATORS, integer_schema(2, MAX_VALUES)) | {"range": number}
    return one_of(
        _closed_mapping({generator: _list_of(number, number, last[generator])}, required=[generator])
        for generator in GENERATORS
    )


def _range(number: Schema) -> Schema:
    """Return the schema of a range of a design: two bounds, or a distribution between them."""
    bounds = _list_of(number, number)
    return one_of(
        [bounds, _closed_mapping(dict.fromkeys((*DISTRIBUTIONS, "within"), bounds)) | {"minProperties": 1}]
    )


def _list_of(*items: Schema) -> Schema:
    return {"type": "array", "items": [*items], "minItems": len(items), "maxItems": len(items)}


def _one_or_many(schema: Schema) -> Schema:
    """Return the schema of one value, or a list of values."""
    return one_of([schema, {"type": "array", "items": schema, "minItems": 1}])


# Settings of a study outside its cases


def _sweep(required: list[str]) -> Schema:
    """Return the schema of `sweep`; required: the keys of a design, which `quick` need not repeat."""
    values = _definition("Values")
    design: Schema = {
        "n": integer_schema(1, 10**99),
        "seed": integer_schema(0, MAX_SEED),
        "over": _definition("Ranges"),
    }
    describe(design, descriptions.DESIGN_KEYS)
    formulas = {
        "type": "object",
        "propertyNames": _definition("Path"),
        "additionalProperties": {"type": ["string", "number"]},
    }
    settings: dict[str, Schema] = {
        "zip": one_of([values, {"type": "array", "items": values}]),
        **dict.fromkeys(KINDS, _closed_mapping(design, required)),
        "derived": formulas,
        "where": one_of([{"type": "string"}, {"type": "array", "items": {"type": "string"}}]),
        "repeat": integer_schema(1, MAX_VALUES),
    }
    describe(settings, descriptions.SWEEP_KEYS)
    return _path_mapping(_paths(), lambda path: {"$ref": f"#/$defs/Values/properties/{path}"}, settings)


def _figure() -> Schema:
    """Return the schema of a figure: of features, with y and x, or of a kind that shows signals."""
    feature, path = _definition("Feature"), _definition("Path")
    channel = {"$ref": "#/properties/record/items"}
    text, time = _TEXT, _definition("Any time")
    signals = [name for name, kind in figure_kinds.KINDS.items() if kind.of_jobs]
    keys: Schema = {
        "kind": {"enum": [*figure_kinds.KINDS]},
        "y": _one_or_many(one_of([feature, channel, {"pattern": r"^[a-z_.]+\.[xy]$", "type": "string"}])),
        "x": path,
        "by": _one_or_many(path),
        "panels": _one_or_many(path),
        "where": {"type": "object", "propertyNames": path},
        "title": _TEXT,
        "log": _one_or_many({"enum": [*figure_kinds.LOG_AXES]}),
        "from": time,
        "to": time,
        "span": time,
        "around": {"enum": [*figure_kinds.AROUND]},
        "range": text,
        "band": text,
        "unit": text,
        "db": {"type": "boolean"},
        "mean": {"enum": [0]},
        "healthy": {"enum": [*figure_kinds.HEALTHY]},
        "orders": {"type": "boolean"},
    }
    describe(keys, figure_kinds.OPTION_HELP)
    of_signals = {"properties": {"kind": {"enum": [*signals, "design"]}}, "required": ["kind"]}
    return _closed_mapping(keys) | {"if": of_signals, "then": {}, "else": {"required": ["y", "x"]}}


def _uncertain_values(parameter: ParameterKind) -> Schema:
    if parameter.choices:
        return {"const": UNKNOWN}
    value = quantity_schema(parameter.dimension, POSITIVE if parameter.positive else "")
    if parameter.samples:
        return value
    return {"type": "array", "items": value, "minItems": 2}


def _measured() -> Schema:
    """Return the schema of measured points or signals."""
    path, feature = _definition("Path"), _definition("Feature")
    row = {"type": "object", "propertyNames": {"anyOf": [path, feature]}, "additionalProperties": _TEXT}
    signal: Schema = {
        "file": _TEXT,
        "at": {"type": "object", "propertyNames": path, "additionalProperties": _TEXT},
        "rate": _definition("Any frequency"),
        "speed": _definition("Any rotation"),
        "unit": _TEXT,
        "channel": _TEXT,
        "full_scale": _definition("Any number"),
    }
    describe(signal, descriptions.SIGNAL_KEYS)
    signals = {"type": "array", "items": _closed_mapping(signal, ["file"]), "minItems": 1}
    points = one_of([_TEXT, {"type": "array", "items": row, "minItems": 1}])
    keys = {"points": points, "signals": signals, "label": _TEXT, "scale": {"type": "boolean"}}
    describe(keys, descriptions.MEASURED_KEYS)
    return _closed_mapping(keys) | {"anyOf": [{"required": ["points"]}, {"required": ["signals"]}]}


def _accuracy() -> Schema:
    share = quantity_schema("share", POSITIVE)
    return one_of(
        [
            share,
            _closed_mapping(
                {"within": share, "of": _one_or_many({"anyOf": [{"enum": list(GOAL_FEATURES)}, BAND_NAME]})},
                required=["within"],
            ),
        ]
    )


# Dependencies between keys


def _exclusions() -> Iterator[Schema]:
    """Yield the conditions on keys that exclude each other."""
    for keys in (("defect", "defects"), *DEPRECATED_KEYS.items()):
        yield {"not": {"required": [*keys]}}
    excluded = {
        path: {"const": AUTO} if reason == STEP_REASON else False for path, reason in EXCLUDED_KEYS.items()
    }
    yield {"if": {"required": ["accuracy"]}, "then": {"properties": excluded}}


def _requirements() -> Iterator[Schema]:
    """Yield the conditions on required keys of a study and its defect."""
    for name in _required(Case):
        yield _unless_swept({"required": [name]}, name)
    is_scan = {"properties": {"shape": {"const": "scan"}}, "required": ["shape"]}
    for name in _required(Defect):
        defect = {"required": ["shape"]} if name == "shape" else one_of([{"required": [name]}, is_scan])
        swept = ("defect", "defect.shape", f"defect.{name}")
        yield _unless_swept({"properties": {"defect": defect}}, *swept)


def _required(section: type[Section]) -> list[str]:
    return [name for name, field in section.model_fields.items() if field.is_required()]


def _unless_swept(schema: Schema, *paths: str) -> Schema:
    """Require the schema ``schema`` unless the sweep may set one of the paths."""
    setters = [{"required": [key]} for key in (*paths, "zip", "derived", *KINDS)]
    return {"if": {"properties": {"sweep": {"not": {"anyOf": setters}}}}, "then": schema}
