"""Paths into a case, as typed by users: `load`, `defect.length`, `defects.2.width`, `contact.damping.chi`."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, NamedTuple, get_args

from bearingsim.config import Case
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.config.fields import Path, Quantity, Section
from bearingsim.config.sections.ring import SupportPoint
from bearingsim.config.vocabulary import explanation
from bearingsim.text.units import Dimension, nearest_words, suggestion
from bearingsim.text.yamlfile import Node

SYNONYMS: dict[Path, Path] = {("rig", "sensor_angle"): ("rig", "sensor", "angle")}
"""Paths that are replaced by synonyms."""


class Field(NamedTuple):
    """Field of a section."""

    section: type[Section]
    name: str

    @property
    def marks(self) -> list[Any]:
        """Classes and annotations of the field's type."""
        field = self.section.model_fields[self.name]
        return [*field.metadata, *_leaves(field.annotation)]

    @property
    def dimension(self) -> Dimension | None:
        """Dimension of the field's values; None for words and sections."""
        return next((mark.dimension for mark in self.marks if isinstance(mark, Quantity)), None)


@cache
def known_paths() -> dict[str, Dimension | None]:
    """List every path that can be swept, with its dimension (None: words or whole sections)."""
    return {path: fields[-1].dimension for path, fields in fields_at().items()}


@cache
def fields_at() -> dict[str, list[Field]]:
    """List the fields at every path that can be swept; several laws may define a field at the same path."""
    fields: dict[str, list[Field]] = {}
    for path, field in _walk(Case, ""):
        fields.setdefault(path, []).append(field)
    return fields


@lru_cache(maxsize=1 << 12)
def dimension(path: str) -> Dimension | None:
    """Return the dimension of the values at a path. Raises KeyError for an unknown path."""
    head, dot, rest = _without_number(path).partition(".")
    current = DEPRECATED_KEYS.get(head, head) + dot + rest  # older results contain deprecated keys
    if current.startswith("rig.load."):  # in results the items of a list are numbered
        current = ".".join(step for step in current.split(".") if not step.isdecimal())
    return all_paths()[current]


@cache
def all_paths() -> dict[str, Dimension | None]:
    """List the paths that can be swept, and those into the items of `rig.load.at`, a list swept as a whole."""
    springs = {path: field.dimension for path, field in _walk(SupportPoint, "rig.load.at.")}
    return known_paths() | springs


def parse_path(text: str, defects: int) -> Path:
    """Parse a path into a case with ``defects`` defects. Raises ValueError for an unknown path."""
    plain = _without_number(text)
    if plain not in known_paths():
        hint = path_hint(plain, known_paths())
        raise ValueError(f"no such path `{text}`" + (f" ({hint})" if hint else ""))
    head, *rest = text.split(".")
    if head == "defect":
        return ("defects", _only_defect(text, defects), *rest)
    if head == "defects" and rest:
        return ("defects", _numbered_defect(int(rest[0]), defects), *rest[1:])
    return SYNONYMS.get((head, *rest), (head, *rest))


def intended_paths(text: str) -> list[str]:
    """List the valid paths that an unknown path may misspell; empty for a valid path."""
    plain = _without_number(text)
    if plain in known_paths():
        return []
    number = text.removesuffix(plain.removeprefix("defect"))  # `defects.1` of `defects.1.widht`
    paths = nearest_words(plain, known_paths())
    return paths if plain == text else [number + path.removeprefix("defect") for path in paths]


MAX_SECTIONS = 4  # limit of the sections with the same key that a hint lists


def path_hint(path: str, valid: Collection[str], section: str | None = None) -> str:
    """Return a hint for an unknown path, or unknown key of a section; empty if there is none.

    The hint is the glossary entry of the last word, the other sections with that key, or similar valid words.
    """
    word = path.rpartition(".")[2]
    return explanation(word) or _sections_with(word, section) or suggestion(path, valid)


def _sections_with(word: str, section: str | None) -> str:
    """Describe the sections that have a key; empty for too many, or if ``section`` has it with another law."""
    paths = [path.rpartition(".") for path in all_paths()]
    sections = sorted((parent for parent, _, key in paths if key == word), key=lambda parent: parent.count("."))
    if section in sections or not 0 < len(sections) <= MAX_SECTIONS:
        return ""
    *others, last = (f"`{parent}`" if parent else "the study" for parent in sections)
    return f"`{word}` is a key of {', '.join(others)}{' and ' * bool(others)}{last}"


def normal_form(text: str) -> Path:
    """Return a normal form of a path, valid or not: equal for `defect.width` and `defects.1.width`."""
    head, *rest = text.split(".")
    if head == "defect":
        return ("defects", "1", *rest)
    if head == "defects" and rest:
        return ("defects", rest[0].lstrip("0"), *rest[1:])
    return SYNONYMS.get((head, *rest), (head, *rest))


def label(path: Path, defects: int) -> str:
    """Format a path as users type it."""
    if len(path) > 1 and path[0] == "defects":
        head = "defect" if defects <= 1 else f"defects.{int(path[1]) + 1}"
        return ".".join([head, *map(str, path[2:])])
    return ".".join(str(step) for step in path if isinstance(step, str))


def put(tree: Node, path: Path, value: Node) -> Node:
    """Return a copy of a tree with another value at a path; missing sections are created."""
    if not path:
        return replace(value, key=tree.key or value.key)
    head, rest = path[0], path[1:]
    empty = Node({}, value.mark)
    if isinstance(head, int):
        items = list(tree.items) or [empty]
        items[head] = put(items[head], rest, value)
        return Node(tuple(items), tree.mark, tree.key)
    child = put(tree.mapping.get(head, empty), rest, value)
    return Node({**tree.mapping, head: child}, tree.mark, tree.key)


def node_at(tree: Node, path: Path) -> Node | None:
    """Return the node at a path of a tree; None if there is none."""
    for step in path:
        child = tree.mapping.get(step) if isinstance(step, str) else dict(enumerate(tree.items)).get(step)
        if child is None:
            return None
        tree = child
    return tree


def value_at(case: Case, path: Path) -> Any:
    """Return the value at a path of a case; None in a section that is omitted because it has no effect."""
    value: Any = case
    for step in path:
        if value is None:
            return None
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return value


def _walk(section: type[Section], prefix: str) -> Iterator[tuple[str, Field]]:
    for name in section.model_fields:
        if name in ("name", "source", "digest"):  # computed, or labels without effect on results
            continue
        field = Field(section, name)
        yield prefix + name, field
        child_prefix = prefix + ("defect" if name == "defects" else name)
        if name == "defects":
            yield child_prefix, field
        for inner in field.marks if name != "at" else ():  # that list is swept as a whole
            if isinstance(inner, type) and issubclass(inner, Section):
                yield from _walk(inner, child_prefix + ".")


def _leaves(annotation: Any) -> Iterator[Any]:
    """Yield the classes and annotations in a type such as `tuple[Defect, ...]` or `Annotated[float, ...]`."""
    yield annotation
    for inner in get_args(annotation):
        yield from _leaves(inner)


def _without_number(path: str) -> str:
    head, *rest = path.split(".")
    numbered = head == "defects" and rest and rest[0].isdecimal() and len(rest[0]) < 5
    return ".".join(["defect", *rest[1:]]) if numbered else path


def _only_defect(text: str, defects: int) -> int:
    if defects > 1:
        raise ValueError(f"which of the {defects} defects? (use `{text.replace('defect', 'defects.1', 1)}`)")
    if defects == 0 and text != "defect":
        raise ValueError(f"`{text}`: the study has no `defect`")
    return 0


def _numbered_defect(number: int, defects: int) -> int:
    if not 1 <= number <= defects:
        raise ValueError(f"there is no defect {number} (the study has {defects}, counted from 1)")
    return number - 1
