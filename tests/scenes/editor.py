"""Validation of a study file as by an editor: YAML 1.2 against the JSON schema."""

import re
from typing import Any

import jsonschema
import yaml

from bearingsim.study import json_schema


class _Core(yaml.SafeLoader):
    """The core schema of YAML 1.2, whose mappings have the keys of JSON."""

    yaml_implicit_resolvers: dict = {}  # noqa: RUF012 (as in PyYAML)


_SCALARS = (
    ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", "[-+]?[0-9]+", "-+0123456789"),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
)
for _name, _pattern, _first in _SCALARS:
    _Core.add_implicit_resolver(f"tag:yaml.org,2002:{_name}", re.compile(f"^(?:{_pattern})$"), list(_first))


def _mapping(loader: _Core, node: yaml.MappingNode) -> dict[str, Any]:
    return {key.value: loader.construct_object(value, deep=True) for key, value in node.value}


_Core.add_constructor("tag:yaml.org,2002:map", _mapping)
_Core.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
_Core.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value))

VALIDATOR = jsonschema.Draft7Validator(json_schema())


def schema_errors(text: str) -> list[str]:
    """Return the errors that an editor marks: position and reason."""
    errors = VALIDATOR.iter_errors(yaml.load(text, _Core))
    return [f"{'.'.join(map(str, error.absolute_path))}: {error.message}" for error in errors]
