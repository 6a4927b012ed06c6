"""Validation of a tree: the case, or every problem with its position in the file."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from bearingsim.config import Case
from bearingsim.config.case import LAWS
from bearingsim.config.fields import Conflict, Path
from bearingsim.config.sections.contact import WORD_TAG
from bearingsim.study.paths import LIST_VALUED, all_paths, path_hint, path_label, path_text
from bearingsim.text.units import EXPECTED
from bearingsim.text.yamlfile import MAX_PROBLEMS, Mark, Node, Problem, plain, problem

STUDY_KEYS = ("study", "figures", "sweep", "quick", "uncertainty", "accuracy", "measured")

_NAMED_SECTIONS: tuple[Path, ...] = (("bearing",), ("bearing", "material"), ("rig",))
"""Sections with the keys `name` and `source`."""

NON_SECTION_ERRORS = ("word", "list", "mapping", "tuple_type", "model_type", "model_attributes_type", "dict_type")
"""Kinds of errors of a section that is not a mapping, so that no swept value can be set in it."""
SINGLE_VALUE_ERRORS = (
    *NON_SECTION_ERRORS,
    "quantity",
    "bound",
    "whole",
    "text",
    "scan",
    "value_error",
    "extra_forbidden",
)
"""Kinds of errors of a single value, independent of all others."""

Problems = dict[tuple[Mark, str, str], Problem]
"""Problems by position, path and kind. Of a problem shared by many cases only the first is kept."""

_PLACEHOLDERS: dict[str, Any] = {
    "bearing": "nf308",
    "speed": 100.0,
    "load": 1.0,
    "shape": "rectangular",
    "length": 1e-6,
    "width": 1e-6,
    "depth": 1e-6,
}


@dataclass
class Sections:
    """Cache of validated sections by the id of their node. Cases share one object per section."""

    validated: dict[int, tuple[Node, Any]] = field(default_factory=dict)

    def convert(self, tree: Node) -> dict[str, Any]:
        """Convert a tree to plain values and validated sections; invalid sections are left plain."""
        return {key: self._section(key, node) for key, node in tree.mapping.items()}

    def _section(self, key: str, node: Node) -> Any:
        if key not in _INDEPENDENT_SECTIONS:
            return plain(node)
        if id(node) not in self.validated:
            self.validated[id(node)] = node, _validate(key, plain(node))
        return self.validated[id(node)][1]


_INDEPENDENT_SECTIONS = frozenset(
    {"bearing", "rig", "contact", "friction", "cage", "drag", "shaft", "unbalance", "misalignment"}
)
"""Sections whose validity does not depend on other sections."""


def _validate(key: str, value: Any) -> Any:
    try:
        return _adapter(key).validate_python(value)
    except ValidationError:
        return value


@cache
def _adapter(key: str) -> TypeAdapter[Any]:
    model_field = Case.model_fields[key]
    annotation: Any = Annotated[model_field.annotation, Field(), *model_field.metadata]
    return TypeAdapter(annotation)


def case_of(tree: Node, swept: frozenset[Path], problems: Problems, sections: Sections) -> Case | None:
    """Build the case of an expanded tree. If it is invalid, add all problems and return None.

    A conflict is reported at a swept value if it involves one.
    """
    try:
        return Case.model_validate(sections.convert(tree))
    except ValidationError:
        pass
    data = plain(tree)
    try:
        Case.model_validate(data)
    except ValidationError as error:
        errors = error.errors(include_url=False)[:MAX_PROBLEMS]
    for details in errors:
        for path, kind, entry in _problems(details, tree, swept):
            problems.setdefault((mark_of(entry), path_label(path, 0), kind), entry)
    for conflict in _hidden_conflicts(data, errors):
        entry = _conflict_problem(conflict, tree, swept)
        problems.setdefault((mark_of(entry), path_label(conflict.paths[0], 0), conflict.kind), entry)
    return None


def check_replaced(tree: Node, swept: frozenset[Path], problems: Problems) -> None:
    """Add the problems of base values that a sweep replaces, although no case uses them.

    Missing values and conflicts are not reported, because the sweep replaces the values.
    """
    try:
        Case.model_validate(plain(tree))
    except ValidationError as error:
        for details in error.errors(include_url=False)[:MAX_PROBLEMS]:
            for path, kind, entry in _problems(details, tree, swept):
                is_parent = kind in NON_SECTION_ERRORS and any(s[: len(path)] == path for s in swept)
                if is_parent or (kind in SINGLE_VALUE_ERRORS and any(path[: len(s)] == s for s in swept)):
                    problems.setdefault((mark_of(entry), path_label(path, 0), kind), entry)


def problems_of(error: ValidationError, tree: Node) -> list[Problem]:
    """List the problems that pydantic found in a tree of another kind than a case."""
    errors = error.errors(include_url=False)[:MAX_PROBLEMS]
    return [entry for details in errors for _, _, entry in _problems(details, tree, frozenset())]


def mark_of(entry: Problem) -> Mark:
    """Return the position of a problem."""
    return Mark(entry.file, entry.line, entry.column, entry.source_line)


SIZE_DIRECTIONS = {"defect.length": "the size along the axis", "defect.width": "the size along rolling"}
"""Directions in which the length and the width of a defect, which are easily confused, are measured."""


def _problems(details: ErrorDetails, tree: Node, swept: frozenset[Path]) -> Iterator[tuple[Path, str, Problem]]:
    context = details.get("ctx", {})
    if "conflicts" in context:
        for conflict in context["conflicts"]:
            yield conflict.paths[0], conflict.kind, _conflict_problem(conflict, tree, swept)
        return
    path = _path_of(details)
    yield path, str(context.get("kind", details["type"])), _problem(details, path, tree, swept)


def _problem(details: ErrorDetails, path: Path, tree: Node, swept: frozenset[Path]) -> Problem:
    name, n_defects = str(path[-1]) if path else "", len(tree.mapping.get("defects", tree).items)
    if details["type"] == "missing":
        dimension, direction = all_paths().get(path_label(path, 0)), SIZE_DIRECTIONS.get(path_label(path, 0))
        hint = f"expected {EXPECTED[dimension]}{f', {direction}' if direction else ''}" if dimension else None
        return _located_problem(_key_mark(tree, path[:-1]), path[:-1], n_defects, f"`{name}` is missing", hint)
    if details["type"] == "extra_forbidden":
        return _located_problem(_key_mark(tree, path), path[:-1], n_defects, *_unknown_key(name, path, tree))
    node, (message, hint) = _nearest_node(tree, path), _message(details)
    is_single = path_label(path, 0) in all_paths().keys() - LIST_VALUED
    if node.items and is_single and path not in swept:
        hint = hint or f"for several values use `sweep: {{{path_text(path, n_defects)}: [...]}}`"
    return _located_problem(node.mark, path, n_defects, message, hint)


def _located_problem(mark: Mark, path: Path, n_defects: int, message: str, hint: str | None) -> Problem:
    location = path_text(path, n_defects)
    return problem(mark, f"{location}: {message}" if location else message, hint)


def _message(details: ErrorDetails) -> tuple[str, str | None]:
    context = details.get("ctx", {})
    if details["type"] == "bearingsim":
        return context["message"], context["hint"]
    if details["type"] == "too_long":
        return f"at most {context['max_length']} are possible", None
    if details["type"] == "tuple_type":
        return "expected a list such as `[a, b]`", None
    if details["type"] in ("model_type", "model_attributes_type", "dict_type"):
        return "expected a mapping of keys", None
    return details["msg"].removeprefix("Value error, "), None


def _unknown_key(name: str, path: Path, tree: Node) -> tuple[str, str]:
    keys = _keys_at(path[:-1], tree)
    return f"unknown key `{name}`", path_hint(name, keys, path_label(path[:-1], 0)) or f"valid: {', '.join(keys)}"


def _keys_at(path: Path, tree: Node) -> list[str]:
    """List the valid keys of a section."""
    if path in LAWS:
        entries = _nearest_node(tree, path).mapping
        law = entries["law"].text if "law" in entries else LAWS[path].match_law(entries)
        return list(LAWS[path].sections[law].model_fields)
    prefix = path_label(path, 0) + "." if path else ""
    keys = [key.removeprefix(prefix) for key in all_paths() if key.startswith(prefix)]
    extra = ["name", "source"] if path in _NAMED_SECTIONS else [] if path else list(STUDY_KEYS)
    return [key for key in keys if "." not in key] + extra


def _path_of(details: ErrorDetails) -> Path:
    """Return the path of an error in the tree, without the tags that pydantic adds for a law."""
    path = [step for i, step in enumerate(details["loc"]) if not _is_tag(details["loc"], i)]
    key = details.get("ctx", {}).get("at")
    return (*path, key) if key else tuple(path)


def _is_tag(loc: Path, index: int) -> bool:
    laws = LAWS.get(loc[:index])
    return laws is not None and (loc[index] in laws.sections or loc[index] == WORD_TAG)


def _nearest_node(tree: Node, path: Path) -> Node:
    """Return the node at a path, or its deepest existing parent."""
    for step in path:
        child = tree.mapping.get(str(step))
        if isinstance(step, int) and step < len(tree.items):
            child = tree.items[step]
        if child is None:
            break
        tree = child
    return tree


def _key_mark(tree: Node, path: Path) -> Mark:
    node = _nearest_node(tree, path)
    return node.key or node.mark


def _conflict_problem(conflict: Conflict, tree: Node, swept: frozenset[Path]) -> Problem:
    """Locate a conflict at a swept value if it involves one, else at the first value written in the file."""
    written_paths = [path for path in conflict.paths if _is_written(tree, path)] or [conflict.paths[0]]
    swept_paths = [path for path in written_paths if any(path[: len(s)] == s for s in swept)]
    path = (swept_paths or written_paths)[0]
    n_defects = len(tree.mapping.get("defects", tree).items)
    return _located_problem(_nearest_node(tree, path).mark, path, n_defects, conflict.message, conflict.hint)


def _is_written(tree: Node, path: Path) -> bool:
    return _nearest_node(tree, path) is not _nearest_node(tree, path[:-1])


def _hidden_conflicts(data: dict[str, Any], errors: list[ErrorDetails]) -> list[Conflict]:
    """List the conflicts among valid values, after replacing invalid ones by valid placeholders."""
    invalid = [_path_of(details) for details in errors]
    if () in invalid:
        return []
    for path, details in zip(invalid, errors, strict=True):
        _replace_invalid(data, path, details["type"] == "extra_forbidden")
    try:
        Case.model_validate(data)
    except ValidationError as error:
        context = error.errors(include_url=False)[0].get("ctx", {})
        return [c for c in context.get("conflicts", []) if not _overlap(c.paths, invalid)]
    return []


def _overlap(paths: tuple[Path, ...], others: list[Path]) -> bool:
    return any(path[: len(other)] == other or other[: len(path)] == path for path in paths for other in others)


def _replace_invalid(data: dict[str, Any], path: Path, unknown: bool) -> None:
    """Replace an invalid value by a placeholder, or remove it."""
    if path[0] == "defects" and len(path) > 1:
        _replace_in_defect(data, path, unknown)
    elif unknown and len(path) == 1:
        data.pop(str(path[0]), None)
    else:
        data.pop(str(path[0]), None)
        data |= {key: value for key, value in _PLACEHOLDERS.items() if key == path[0]}


def _replace_in_defect(data: dict[str, Any], path: Path, unknown: bool) -> None:
    defects, number = data["defects"], int(path[1])
    if len(path) == 2 or not isinstance(defects[number], dict):
        defects[number] = {key: _PLACEHOLDERS[key] for key in ("shape", "length", "width", "depth")}
        return
    defects[number].pop(path[2], None)
    if not unknown and path[2] in _PLACEHOLDERS:
        defects[number][path[2]] = _PLACEHOLDERS[str(path[2])]
