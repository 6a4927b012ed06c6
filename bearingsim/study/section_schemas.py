"""JSON schemas of the sections of a study file, as users write them."""

from collections.abc import Iterable, Mapping

from pydantic.json_schema import models_json_schema

from bearingsim.config.fields import Schema, Section
from bearingsim.config.sections.ring import SupportPoint
from bearingsim.study.descriptions import field_descriptions
from bearingsim.study.paths import fields_by_path


def section_schemas() -> tuple[dict[type[Section], str], dict[str, Schema]]:
    """Return the names of the sections with swept fields, and the schemas of all sections by name."""
    swept: dict[type[Section], None] = dict.fromkeys(
        field.section for fields in fields_by_path().values() for field in fields
    )
    listed: tuple[type[Section], ...] = (*swept, SupportPoint)  # the items of a list that is swept as a whole
    refs, document = models_json_schema([(section, "validation") for section in listed])
    names = {section: refs[section, "validation"]["$ref"].rpartition("/")[2] for section in listed}
    sections = {name: _as_written(schema) for name, schema in document["$defs"].items()}
    for section, name in names.items():
        describe(sections[name]["properties"], field_descriptions(section))
        if section in swept:
            sections[name].pop("required", None)
    return names, sections


def describe(properties: Schema, descriptions: Mapping[str, str]) -> None:
    """Add the descriptions of keys to their schemas, before the format of their values."""
    for key, text in descriptions.items():
        if key in properties:
            value_format = properties[key].get("description")
            properties[key] = properties[key] | {
                "description": f"{text} Format: {value_format}." if value_format else text
            }


def _as_written(schema: Schema) -> Schema:
    """Remove the parts of a schema that apply to Python only: titles, defaults in SI, and None."""
    reduced = {key: value for key, value in schema.items() if key not in ("title", "default", "anyOf", "oneOf")}
    if "properties" in reduced:
        reduced["properties"] = {name: _as_written(inner) for name, inner in reduced["properties"].items()}
    if "items" in reduced:
        reduced["items"] = _as_written(reduced["items"])
    choices = [_as_written(inner) for inner in schema.get("anyOf") or schema.get("oneOf") or ()]
    return reduced | (one_of(choice for choice in choices if choice != {"type": "null"}) if choices else {})


def one_of(choices: Iterable[Schema]) -> Schema:
    """Return the schema of a value with alternatives; nested alternatives are flattened."""
    flat = [inner for choice in choices for inner in (choice["anyOf"] if choice.keys() == {"anyOf"} else [choice])]
    return flat[0] if len(flat) == 1 else {"anyOf": flat}
