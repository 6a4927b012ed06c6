"""YAML as written: every scalar stays text, every value knows its place.

PyYAML's own loader reads `1e-3` as a string, `12:30:45` as a number, `no` as False and keeps the last of two
equal keys. Here nothing is guessed: a file becomes a tree of `Node`, whose marks let a later error point at
the character that caused it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.errors import UserError

if TYPE_CHECKING:
    import yaml


ARGUMENT = "command line"
"""Stands for the file's name where a value came from the command line."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in a file: line and column count from 1 (0: the file as a whole)."""

    file: str
    line: int = 0
    column: int = 0
    source_line: str = ""


@dataclass(frozen=True, slots=True)
class Node:
    """A value of the file, its place, and the place of its key where it has one."""

    value: str | tuple[Node, ...] | dict[str, Node]
    mark: Mark
    key: Mark | None = None

    @property
    def mapping(self) -> dict[str, Node]:
        """The entries; empty if this is not a mapping."""
        return self.value if isinstance(self.value, dict) else {}

    @property
    def items(self) -> tuple[Node, ...]:
        """The elements; empty if this is not a list."""
        return self.value if isinstance(self.value, tuple) else ()

    @property
    def text(self) -> str:
        """The scalar as written, or the mapping or list in flow style."""
        if isinstance(self.value, dict):
            return "{" + ", ".join(f"{key}: {node.text}" for key, node in self.value.items()) + "}"
        if isinstance(self.value, tuple):
            return "[" + ", ".join(node.text for node in self.value) + "]"
        return self.value


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong, where, and what would mend it."""

    file: str
    line: int
    column: int
    source_line: str
    message: str
    hint: str | None = None

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        text = f"{place}: {self.message}" + (f" ({self.hint})" if self.hint else "")
        if not self.column:
            return text
        return f"{text}\n    {self.source_line}\n    {' ' * (self.column - 1)}^"


class StudyError(UserError):
    """Everything found wrong in a study and the files it names, as `problems`."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        super().__init__("\n".join(map(str, self.problems)))


def problem(mark: Mark, message: str, hint: str | None = None) -> Problem:
    """A problem at a place."""
    return Problem(mark.file, mark.line, mark.column, mark.source_line, message, hint)


def plain(node: Node) -> Any:
    """The tree as dicts, lists and texts."""
    if isinstance(node.value, dict):
        return {key: plain(child) for key, child in node.value.items()}
    if isinstance(node.value, tuple):
        return [plain(child) for child in node.value]
    return node.value


def read_text(path: Path) -> str:
    """The text of a file; raises StudyError if it cannot be read as UTF-8 text."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise StudyError([Problem(str(path), 0, 0, "", "no such file")]) from None
    except UnicodeDecodeError:
        raise StudyError([Problem(str(path), 0, 0, "", "not a text file in UTF-8")]) from None
    except OSError as error:
        raise StudyError([Problem(str(path), 0, 0, "", f"cannot be read: {error.strerror}")]) from None


class Document(NamedTuple):
    """A file's tree, and what is wrong with it (doubled keys, tags); the tree is complete all the same."""

    root: Node
    problems: tuple[Problem, ...]


def parse(text: str, file: str) -> Document:
    """The tree of a YAML text; raises StudyError on a syntax error."""
    import yaml

    try:
        root = yaml.compose(text, Loader=yaml.BaseLoader)
    except yaml.YAMLError as error:
        raise StudyError([_syntax_problem(error, text, file)]) from None
    if root is None:
        return Document(Node({}, Mark(file)), ())
    walk = _Walk(file, text.splitlines())
    return Document(walk.node(root), tuple(walk.problems))


def parse_argument(text: str, typed: str) -> Document:
    """The tree of a value given on the command line, at the end of what was `typed` there.

    Raises StudyError on a syntax error.
    """
    before = typed[: len(typed) - len(text)].replace("\n", " ")
    indented = " " * len(before) + text.replace("\n", " ")
    try:
        root, problems = parse(indented, ARGUMENT)
    except StudyError as error:
        raise StudyError(_retyped(found, typed) for found in error.problems) from None
    return Document(_moved(root, typed), tuple(_retyped(found, typed) for found in problems))


def argument_mark(typed: str, column: int) -> Mark:
    """A place on the command line."""
    return Mark(ARGUMENT, 0, column, typed)


def _retyped(found: Problem, typed: str) -> Problem:
    return replace(found, line=0, source_line=typed)


def _moved(node: Node, typed: str) -> Node:
    value = node.value
    if isinstance(value, dict):
        value = {key: _moved(child, typed) for key, child in value.items()}
    elif isinstance(value, tuple):
        value = tuple(_moved(child, typed) for child in value)
    key = argument_mark(typed, node.key.column) if node.key else None
    return Node(value, argument_mark(typed, node.mark.column), key)


def _syntax_problem(error: yaml.YAMLError, text: str, file: str) -> Problem:
    place = getattr(error, "problem_mark", None)
    what = getattr(error, "problem", None) or str(error).splitlines()[0]
    if place is None:
        return Problem(file, 0, 0, "", f"not valid YAML: {what}")
    lines = text.splitlines()
    line = min(place.line, len(lines) - 1)
    column = place.column if line == place.line else len(lines[line])
    return Problem(file, line + 1, column + 1, lines[line], f"not valid YAML: {what}")


_UNIT = re.compile(r"[^\W\d]|%|°")


def _is_decimal_comma(before: yaml.Node | None, after: yaml.Node) -> bool:
    """Whether YAML took the comma of `0,2 mm` for the one between two entries."""
    if before is None or not isinstance(before.value, str) or not isinstance(after.value, str):
        return False
    touching = before.end_mark.index + 1 == after.start_mark.index
    return touching and bool(re.fullmatch(r"[+-]?\d+", before.value)) and after.value[:1].isdecimal()


def _joined(before: Node, after: Node) -> Node:
    return replace(before, value=f"{before.text},{after.text}")


class _Walk:
    """One pass over PyYAML's nodes; collects what is wrong and goes on."""

    def __init__(self, file: str, lines: list[str]) -> None:
        self.file, self.lines = file, lines
        self.problems: list[Problem] = []
        self.done: dict[int, Node | None] = {}  # None while a node is being walked

    def mark(self, node: yaml.Node) -> Mark:
        place = node.start_mark
        line = self.lines[place.line] if place.line < len(self.lines) else ""
        return Mark(self.file, place.line + 1, place.column + 1, line)

    def node(self, raw: yaml.Node) -> Node:
        if id(raw) in self.done:  # an alias: the same node again
            known = self.done[id(raw)]
            return known or self.refuse(raw, "an alias inside its own anchor")
        self.done[id(raw)] = None
        node = self.fresh(raw)
        self.done[id(raw)] = node
        return node

    def fresh(self, raw: yaml.Node) -> Node:
        import yaml

        if raw.tag.startswith("!"):
            return self.refuse(raw, f"the tag `{raw.tag}` means nothing here")
        if isinstance(raw, yaml.MappingNode):
            return Node(self.entries(raw), self.mark(raw))
        if isinstance(raw, yaml.SequenceNode):
            items = [self.node(child) for child in raw.value]
            return Node(tuple(self.rejoined(raw.value, items)), self.mark(raw))
        return Node(str(raw.value), self.mark(raw))

    def entries(self, raw: yaml.MappingNode) -> dict[str, Node]:
        found: dict[str, Node] = {}
        before: tuple[str, yaml.Node | None] = ("", None)  # the last key, and its value
        for raw_key, raw_value in raw.value:
            key, value = self.node(raw_key), self.node(raw_value)
            if _is_decimal_comma(before[1], raw_key) and value.value == "":
                found[before[0]] = _joined(found[before[0]], key)
                continue
            self.enter(found, key, value)
            before = (key.text, raw_value if key.text in found else None)
        return found

    def enter(self, found: dict[str, Node], key: Node, value: Node) -> None:
        if not isinstance(key.value, str):
            self.problems.append(problem(key.mark, "a key must be a word"))
        elif key.value in found:
            first = found[key.value].key
            where = f", first on line {first.line}" if first else ""
            self.problems.append(problem(key.mark, f"the key `{key.value}` is given twice{where}"))
        else:
            found[key.value] = replace(value, key=key.mark)

    def rejoined(self, raw: list[yaml.Node], items: list[Node]) -> Iterator[Node]:
        """The items of a list; `0` and `2 mm` that were written `0,2 mm` as the one that was meant."""
        skip = False
        for i, item in enumerate(items):
            after = raw[i + 1] if i + 1 < len(raw) else None
            splits = after is not None and _is_decimal_comma(raw[i], after) and _UNIT.search(items[i + 1].text)
            if not skip:
                yield _joined(item, items[i + 1]) if splits else item
            skip = bool(splits) and not skip

    def refuse(self, raw: yaml.Node, message: str) -> Node:
        self.problems.append(problem(self.mark(raw), message))
        return Node("", self.mark(raw))
