"""Conversion of a case to stored parameters and back; units and names of parameters, channels and features."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.store.scans import find_scan_copy, short_path
from bearingsim.text.numbers import is_number
from bearingsim.text.units import UNITS, Dimension

if TYPE_CHECKING:
    from bearingsim.config import Case

UNSTORED_FIELDS = ("source",)  # free text, which does not influence results
PATH_FIELDS = ("file",)  # stored as short paths
OMITTED_FIELDS = ("record", "features")  # left out by ``case_of``


def flat_parameters(case: Any) -> dict[str, float | str]:
    """Flatten a case to one mapping in SI: ``bearing.roller_diameter``, ``defects.1.width``, ``model`` ...

    List items are numbered from 1, and lists of strings are joined by spaces. Values that are not set and the
    fields in ``UNSTORED_FIELDS`` are omitted. Paths outside the working folder are reduced to the file name.
    """
    return dict(_flatten("", case.model_dump()))


def _flatten(path: str, value: Any) -> Iterator[tuple[str, float | str]]:
    if isinstance(value, Mapping):
        for name, item in value.items():
            if name not in UNSTORED_FIELDS:
                yield from _flatten(f"{path}.{name}" if path else str(name), item)
    elif isinstance(value, list | tuple) and value and all(isinstance(item, str) for item in value):
        yield path, " ".join(value)
    elif isinstance(value, list | tuple):
        for number, item in enumerate(value, 1):
            yield from _flatten(f"{path}.{number}", item)
    elif isinstance(value, bool):
        yield path, str(value).lower()
    elif isinstance(value, int | float):
        yield path, float(value)
    elif value is not None:
        yield path, short_path(value) if path.rpartition(".")[2] in PATH_FIELDS else str(value)


def case_of(parameters: Mapping[Any, Any], root: Path | None = None) -> "Case":
    """Build the case of a job from its resolved parameters in SI, as ``Results.parameters`` returns them.

    Parameters that are not set (NaN or an empty string), recorded channels and requested features are left out.
    If ``root`` is set, scans are read only from that results folder. Raises ValueError (pydantic's
    ValidationError, ScanError) for parameters that do not form a valid case, such as those of another version.
    """
    from bearingsim.config import Case

    tree: dict[str, Any] = {}
    for path, value in parameters.items():
        if value == value and value != "":
            _set_nested(tree, str(path).split("."), _as_integer(as_number(str(path), value)))
    if root is not None:
        surfaces = _check_mapping(tree.get("surfaces", {}))
        races = [_check_mapping(surfaces.get(race, {})) for race in ("outer", "inner")]
        profiles = [race.get("roundness", {}) for race in races]
        for section in (*_check_mapping(tree.get("defects", {})).values(), *profiles):
            _use_scan_copy(root, _check_mapping(section))
    return Case.model_validate(
        {name: _convert_to_lists(item) for name, item in tree.items() if name not in OMITTED_FIELDS}
    )


def _use_scan_copy(root: Path, section: dict[str, Any]) -> None:
    """Set the file of a scanned defect or race to its stored copy. Raises ScanError if there is no copy."""
    if "file" in section:
        section["file"] = str(find_scan_copy(root, str(section.get("digest")), str(section["file"])))


def as_number(path: str, value: Any) -> Any:
    """Convert a number stored as text to float; other values are returned unchanged.

    A column is stored as text if some jobs have a word such as `auto` there.
    """
    from bearingsim.study import dimension

    if not isinstance(value, str) or not is_number(value):
        return value
    try:
        dimension(path)
    except KeyError:  # a name or a digest, which cannot be swept
        return value
    return float(value)


def _as_integer(value: Any) -> Any:
    """Convert a float with an integer value to int; other values are returned unchanged."""
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 1e9 else value


def _set_nested(tree: dict[str, Any], path: list[str], value: Any) -> None:
    for name in path[:-1]:
        tree = _check_mapping(tree.setdefault(name, {}))
    tree[path[-1]] = value


def _check_mapping(item: Any) -> dict[str, Any]:
    """Return a mapping unchanged. Raises ValueError for another value."""
    if not isinstance(item, dict):
        raise ValueError("a parameter is a value and has parts")
    return item


def _convert_to_lists(item: Any) -> Any:
    """Convert mappings with keys 1, 2, ... to lists, at all levels."""
    if not isinstance(item, dict):
        return item
    items = {name: _convert_to_lists(value) for name, value in item.items()}
    return [items[name] for name in sorted(items, key=int)] if all(map(str.isdecimal, items)) else items


def parameter_attributes(name: str) -> dict[str, str]:
    """Return ``units`` of a parameter; an empty mapping for strings and dimensionless numbers."""
    from bearingsim.study import dimension

    try:
        quantity = dimension(name)
    except KeyError:
        return {}
    unit = "" if quantity is None else si_unit(quantity)
    return {"units": unit} if unit else {}


def si_unit(dimension: Dimension) -> str:
    """Return the SI unit of a dimension, that with the factor 1; "" for a ratio."""
    return next((unit for unit, factor in UNITS[dimension].items() if factor.exact == 1 and not factor.pi), "")


def channel_attributes(name: str) -> dict[str, str]:
    """Return ``units`` and ``long_name`` of a stored channel such as ``ring.velocity.x``. Raises KeyError."""
    from bearingsim.config import CHANNELS

    base, _, component = name.rpartition(".")
    if name in CHANNELS:
        base, component = name, ""
    channel = CHANNELS[base]
    return {"units": channel.unit, "long_name": f"{channel.long_name} {component}".strip()}


def channel_unit(name: str) -> str:
    """Return the unit of a stored channel; "" for a channel unknown to this version."""
    try:
        return channel_attributes(name)["units"]
    except KeyError:
        return ""


def feature_attributes(name: str) -> dict[str, str]:
    """Return ``units`` and ``long_name`` of a feature; an empty mapping for an unknown feature."""
    from bearingsim.config import FEATURES

    if name not in FEATURES:
        return {}
    feature = FEATURES[name]
    return {"units": feature.unit or "1", "long_name": feature.long_name}


def sort_features(names: Iterable[str]) -> list[str]:
    """Sort feature names in the order of ``FEATURES``; unknown names come last, sorted by name."""
    from bearingsim.config import FEATURES

    order = {name: number for number, name in enumerate(FEATURES)}
    return sorted(names, key=lambda name: (order.get(name, len(order)), name))
