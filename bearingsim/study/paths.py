"""Paths into a case, as typed by users: `load`, `defect.length`, `defects.2.width`, `contact.damping.chi`.

Items of a list are counted from 1, as in `surfaces.outer.harmonics.2.amplitude`; a single item needs no number.
"""

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
"""Alternative paths of a value, each with the path that replaces it."""
ITEM_LISTS = (
    "surfaces.outer.harmonics",
    "surfaces.inner.harmonics",
    "surfaces.rollers.harmonics",
    "surfaces.rollers.diameter.deviations",
)
"""Lists other than `defects` whose items can be swept."""
LIST_VALUED = (
    "defects",
    "record",
    "features",
    "rig.load.angles",
    "rig.load.at",
    *(f"surfaces.{part}.spectrum.orders" for part in ("outer", "inner", "rollers")),
    *(f"surfaces.{race}.roundness.orders" for race in ("outer", "inner")),
    *ITEM_LISTS,
)
"""Paths whose value is a list, so that sweeping them takes a list of lists."""


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
    return {path: fields[-1].dimension for path, fields in fields_by_path().items()}


@cache
def fields_by_path() -> dict[str, list[Field]]:
    """List the fields at every path that can be swept; several laws may define a field at the same path."""
    fields: dict[str, list[Field]] = {}
    for path, field in _walk(Case, ""):
        fields.setdefault(path, []).append(field)
    return fields


STUDY_KEY_HINTS = {
    name: f"`{name}` is a key of the study: write it into the file{remark}"
    for name, remark in (("accuracy", ", instead of `model`"), ("uncertainty", ""), ("figures", ""), ("sweep", ""))
}
"""Hints for keys of a study that are not paths into its cases."""


@lru_cache(maxsize=1 << 12)
def dimension(path: str) -> Dimension | None:
    """Return the dimension of the values at a path. Raises KeyError for an unknown path."""
    head, dot, rest = without_number(path).partition(".")
    current = DEPRECATED_KEYS.get(head, head) + dot + rest  # older results contain deprecated keys
    if current.startswith("rig.load."):  # in results the items of a list are numbered
        current = ".".join(step for step in current.split(".") if not step.isdecimal())
    return all_paths()[current]


@cache
def all_paths() -> dict[str, Dimension | None]:
    """List the paths that can be swept, and those into the items of `rig.load.at`, a list swept as a whole."""
    springs = {path: field.dimension for path, field in _walk(SupportPoint, "rig.load.at.")}
    return known_paths() | springs


def parse_path(text: str, tree: Node) -> Path:
    """Parse a path into a case with the lists of a tree. Raises ValueError for an unknown path."""
    plain = without_number(text)
    if plain not in known_paths():
        hint = STUDY_KEY_HINTS.get(text) or _renumber(path_hint(plain, known_paths()), text, plain)
        raise ValueError(f"no such path `{text}`" + (f" ({hint})" if hint else ""))
    head, *rest = text.split(".")
    n_defects = len(tree.mapping.get("defects", tree).items)
    if head == "defect":
        return ("defects", _only_defect(text, n_defects), *rest)
    if head == "defects" and rest:
        return ("defects", _numbered_defect(int(rest[0]), n_defects), *rest[1:])
    items = _list_of(plain)
    if items and (text != plain or plain != items):
        return _path_into_list(text, items, tree)
    return SYNONYMS.get((head, *rest), (head, *rest))


def _list_of(plain: str) -> str:
    """Return the list of ``ITEM_LISTS`` that a path without numbers leads to or into; empty without one."""
    return next((items for items in ITEM_LISTS if plain == items or plain.startswith(items + ".")), "")


def _path_into_list(text: str, items: str, tree: Node) -> Path:
    number, _, rest = text.removeprefix(items + ".").partition(".")
    if not number.isdecimal():
        number, rest = "", text.removeprefix(items + ".")
    path = tuple(items.split("."))
    node = node_at(tree, path)
    count = len(node.items) if node is not None else 0
    name = path[-1]
    if count == 0:
        raise ValueError(f"`{text}`: the study has no `{items}` (give the list; the sweep replaces its values)")
    if not number and count > 1:
        raise ValueError(f"which of the {count} {name}? (use `{items}.1.{rest}`)")
    if not rest and dimension(items) is None:
        raise ValueError(f"`{text}` has several values (name one, as in `{text}.amplitude`)")
    if number and not 1 <= int(number) <= count:
        raise ValueError(f"`{text}`: the list has {count} {name}, counted from 1")
    return (*path, int(number or 1) - 1, *(rest.split(".") if rest else ()))


def intended_paths(text: str) -> list[str]:
    """List the valid paths that an unknown path may misspell; empty for a valid path."""
    plain = without_number(text)
    if plain in known_paths():
        return []
    return [_renumber(path, text, plain) for path in nearest_words(plain, known_paths())]


def _renumber(hint: str, text: str, plain: str) -> str:
    """Insert the number of the list's item, which ``text`` has and ``plain`` lacks, into a path or hint."""
    if text == plain:
        return hint
    items = _list_of(plain) or "defect"
    number = text.removesuffix(plain.removeprefix(items))  # `defects.1` of `defects.1.widht`
    return hint.replace(items + ".", number + ".")


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
    if (items := _list_of(without_number(text))) and text != items:
        number, *keys = text.removeprefix(items + ".").split(".")
        item = (number.lstrip("0"), *keys) if _is_number(number) else ("1", number, *keys)
        return (*items.split("."), *item)
    return SYNONYMS.get((head, *rest), (head, *rest))


def path_label(path: Path, n_defects: int) -> str:
    """Format a path without the numbers of items, except for that of one of several ``defects``."""
    if len(path) > 1 and path[0] == "defects":
        head = "defect" if n_defects <= 1 else f"defects.{int(path[1]) + 1}"
        return ".".join([head, *map(str, path[2:])])
    return ".".join(str(step) for step in path if isinstance(step, str))


def path_text(path: Path, n_defects: int) -> str:
    """Format a path as users type it."""
    plain = path_label(path, n_defects)
    steps = (str(step + 1) if isinstance(step, int) else step for step in path)
    return ".".join(steps) if _list_of(plain) else plain


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
    """Yield every path below a section, with its field; deeper sections follow the section that contains them."""
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


def without_number(path: str) -> str:
    """Return a path without the number of a list's item: `defect.width` for `defects.2.width`."""
    head, *rest = path.split(".")
    if head == "defects" and rest and _is_number(rest[0]):
        return ".".join(["defect", *rest[1:]])
    for items in ITEM_LISTS:
        number, dot, rest_text = path.removeprefix(items + ".").partition(".")
        if path.startswith(items + ".") and _is_number(number):
            return items + dot + rest_text
    return path


def _is_number(step: str) -> bool:
    return step.isdecimal() and len(step) < 5


def _only_defect(text: str, n_defects: int) -> int:
    if n_defects > 1:
        raise ValueError(f"which of the {n_defects} defects? (use `{text.replace('defect', 'defects.1', 1)}`)")
    if n_defects == 0 and text != "defect":
        raise ValueError(f"`{text}`: the study has no `defect`")
    return 0


def _numbered_defect(number: int, n_defects: int) -> int:
    if not 1 <= number <= n_defects:
        raise ValueError(f"there is no defect {number} (the study has {n_defects}, counted from 1)")
    return number - 1
