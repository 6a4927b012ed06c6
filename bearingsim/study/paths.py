"""Paths into a case, as a user types them: `load`, `defect.length`, `defects.2.width`, `contact.damping.chi`."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, NamedTuple, get_args

from bearingsim.config import Case
from bearingsim.config.case_fields import OLD_WORDS
from bearingsim.config.fields import Quantity, Section
from bearingsim.config.rules.conflicts import Path
from bearingsim.config.sections.ring import SupportPoint
from bearingsim.config.vocabulary import sentence
from bearingsim.text.units import Dimension, suggestion
from bearingsim.text.yamlfile import Node

SAME_PLACE: dict[Path, Path] = {("rig", "sensor_angle"): ("rig", "sensor", "angle")}
"""Paths that are another word for a place, and that place."""


class Field(NamedTuple):
    """A field of a section."""

    section: type[Section]
    name: str

    @property
    def marks(self) -> list[Any]:
        """The classes and marks of its type."""
        field = self.section.model_fields[self.name]
        return [*field.metadata, *_leaves(field.annotation)]

    @property
    def dimension(self) -> Dimension | None:
        """That of its values; None of words and sections."""
        return next((mark.dimension for mark in self.marks if isinstance(mark, Quantity)), None)


@cache
def known_paths() -> dict[str, Dimension | None]:
    """Every path that can be swept, with its dimension (None: words or whole sections)."""
    return {path: fields[-1].dimension for path, fields in fields_at().items()}


@cache
def fields_at() -> dict[str, list[Field]]:
    """The field at every path that can be swept; laws that stand for each other may each have one there."""
    fields: dict[str, list[Field]] = {}
    for path, field in _walk(Case, ""):
        fields.setdefault(path, []).append(field)
    return fields


@lru_cache(maxsize=1 << 12)
def dimension(path: str) -> Dimension | None:
    """The dimension of the values at a path; KeyError if there is no such path."""
    first, dot, rest = _without_number(path).partition(".")
    in_new_words = OLD_WORDS.get(first, first) + dot + rest  # results keep the words of their time
    if in_new_words.startswith("rig.load."):  # in results the items of a list are numbered
        in_new_words = ".".join(step for step in in_new_words.split(".") if not step.isdecimal())
    return all_paths()[in_new_words]


@cache
def all_paths() -> dict[str, Dimension | None]:
    """The paths that can be swept, and those into the springs of `rig.load.at`, which is swept as a whole."""
    springs = {path: field.dimension for path, field in _walk(SupportPoint, "rig.load.at.")}
    return known_paths() | springs


def parse_path(text: str, defects: int) -> Path:
    """Where a path leads in a case with that many defects; ValueError if nowhere."""
    plain = _without_number(text)
    if plain not in known_paths():
        near = advice_on(plain, known_paths())
        raise ValueError(f"no such path `{text}`" + (f" ({near})" if near else ""))
    head, *rest = text.split(".")
    if head == "defect":
        return ("defects", _only_defect(text, defects), *rest)
    if head == "defects" and rest:
        return ("defects", _numbered_defect(int(rest[0]), defects), *rest[1:])
    return SAME_PLACE.get((head, *rest), (head, *rest))


MOST_PLACES = 4  # that are listed of a key: of more the list says nothing


def advice_on(path: str, known: Collection[str], section: str | None = None) -> str:
    """A hint for a path, or a key of a section, that there is not; empty if there is none.

    What is true of its last word, which other sections have a key of that name, or the nearest of ``known``.
    """
    word = path.rpartition(".")[2]
    return sentence(word) or _places(word, section) or suggestion(path, known)


def _places(word: str, section: str | None) -> str:
    """The sections that have a key of a name; nothing of a key that a section has with another law."""
    paths = [path.rpartition(".") for path in all_paths()]
    sections = sorted((above for above, _, key in paths if key == word), key=lambda above: above.count("."))
    if section in sections or not 0 < len(sections) <= MOST_PLACES:
        return ""
    *others, last = (f"`{above}`" if above else "the study" for above in sections)
    return f"`{word}` is a key of {', '.join(others)}{' and ' * bool(others)}{last}"


def unspelled(text: str) -> Path:
    """What all spellings of a path have in common, be it right or wrong: `defect.width` and `defects.1.width`."""
    head, *rest = text.split(".")
    if head == "defect":
        return ("defects", "1", *rest)
    if head == "defects" and rest:
        return ("defects", rest[0].lstrip("0"), *rest[1:])
    return SAME_PLACE.get((head, *rest), (head, *rest))


def label(path: Path, defects: int) -> str:
    """A path as a user types it."""
    if len(path) > 1 and path[0] == "defects":
        head = "defect" if defects <= 1 else f"defects.{int(path[1]) + 1}"
        return ".".join([head, *map(str, path[2:])])
    return ".".join(str(step) for step in path if isinstance(step, str))


def put(tree: Node, path: Path, value: Node) -> Node:
    """The tree with another value at a path; sections missing on the way are made."""
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
    """What a tree says at a path; None if nothing."""
    for step in path:
        below = tree.mapping.get(step) if isinstance(step, str) else dict(enumerate(tree.items)).get(step)
        if below is None:
            return None
        tree = below
    return tree


def value_at(case: Case, path: Path) -> Any:
    """What stands at a path of a case; None in a section that was left out for doing nothing."""
    found: Any = case
    for step in path:
        if found is None:
            return None
        found = found[step] if isinstance(step, int) else getattr(found, step)
    return found


def _walk(section: type[Section], prefix: str) -> Iterator[tuple[str, Field]]:
    for name in section.model_fields:
        if name in ("name", "source", "digest"):  # not for users to set, or labels that shape no result
            continue
        field = Field(section, name)
        yield prefix + name, field
        below = prefix + ("defect" if name == "defects" else name)
        if name == "defects":
            yield below, field
        for inner in field.marks if name != "at" else ():  # that list is swept as a whole
            if isinstance(inner, type) and issubclass(inner, Section):
                yield from _walk(inner, below + ".")


def _leaves(annotation: Any) -> Iterator[Any]:
    """Classes and marks inside a type such as `tuple[Defect, ...]` or `Annotated[float, ...] | None`."""
    yield annotation
    for inner in get_args(annotation):
        yield from _leaves(inner)


def _without_number(path: str) -> str:
    head, *rest = path.split(".")
    numbered = head == "defects" and rest and rest[0].isdecimal() and len(rest[0]) < 5
    return ".".join(["defect", *rest[1:]]) if numbered else path


def _only_defect(text: str, defects: int) -> int:
    if defects > 1:
        raise ValueError(f"which of the {defects} defects? (say `{text.replace('defect', 'defects.1', 1)}`)")
    if defects == 0 and text != "defect":
        raise ValueError(f"`{text}`: the study has no `defect`")
    return 0


def _numbered_defect(number: int, defects: int) -> int:
    if not 1 <= number <= defects:
        raise ValueError(f"there is no defect {number} (the study has {defects}, counted from 1)")
    return number - 1
