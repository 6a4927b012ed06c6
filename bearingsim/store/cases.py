"""Reconstruction of a job's case from the parameters stored with its results."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.store.scans import own_scan

if TYPE_CHECKING:
    from bearingsim.config import Case

WORDS = ("record", "features")  # stored as words joined by spaces


def case_of(parameters: Mapping[Any, Any], root: Path | None = None) -> "Case":
    """Build the case of a job from its resolved parameters in SI, as ``Results.parameters`` returns them.

    Parameters that are not set (NaN or an empty text) and the recorded channels are left out. Scans are read from
    the results folder ``root`` only. Raises ValueError (pydantic's ValidationError, ScanError) for parameters that
    form no valid case, such as those of another version.
    """
    from bearingsim.config import Case

    tree: dict[str, Any] = {}
    for path, value in parameters.items():
        if value == value and value != "":
            _plant(tree, str(path).split("."), _plain(value))
    if root is not None:
        for defect in _mapping(tree.get("defects", {})).values():
            _take_kept(root, _mapping(defect))
    return Case.model_validate({name: _lists(item) for name, item in tree.items() if name not in WORDS})


def _take_kept(root: Path, defect: dict[str, Any]) -> None:
    """Point a defect to the stored copy of its scan, if it has one. Raises ScanError without a copy."""
    if "file" in defect:
        defect["file"] = str(own_scan(root, str(defect.get("digest")), str(defect["file"])))


def _plain(value: Any) -> Any:
    """Convert whole numbers, which are stored as floats, to int."""
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 1e9 else value


def _plant(tree: dict[str, Any], path: list[str], value: Any) -> None:
    for name in path[:-1]:
        tree = _mapping(tree.setdefault(name, {}))
    tree[path[-1]] = value


def _mapping(item: Any) -> dict[str, Any]:
    if not isinstance(item, dict):
        raise ValueError("a parameter is a value and has parts")
    return item


def _lists(item: Any) -> Any:
    """Convert mappings with keys 1, 2, ... to lists."""
    if not isinstance(item, dict):
        return item
    inner = {name: _lists(value) for name, value in item.items()}
    return [inner[name] for name in sorted(inner, key=int)] if all(map(str.isdecimal, inner)) else inner
