"""YAML reader that keeps every scalar as text, with its position in the file.

PyYAML's loader reads `1e-3` as a string, `12:30:45` as a number and `no` as False, and keeps the last of duplicate
keys. This reader does not convert values: a file becomes a tree of `Node`, whose marks locate later errors.
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
"""File name of values from the command line."""
MAX_CHARACTERS = 100_000
"""Limit of the characters of a file with aliases expanded, read in about 2 s. Usual studies have up to 4000."""
MAX_DEPTH = 20
"""Limit of the nesting of lists and mappings. Studies need 8; the recursion of Python fails at about 300."""
MAX_PROBLEMS = 50
"""Limit of the problems reported at once, because the search for each suggestion takes milliseconds."""
MAX_ECHO, MAX_MESSAGE, MAX_LINE = 200, 2000, 160
"""Limits of the characters of a quoted value, of a message, and of the source line shown with it."""


@dataclass(frozen=True, slots=True)
class Mark:
    """Position in a file: line and column, counted from 1. Line 0 is the whole file, or the command line."""

    file: str
    line: int = 0
    column: int = 0
    source_line: str = ""


@dataclass(frozen=True, slots=True)
class Node:
    """Value in a file, its position, and the position of its key if it has one."""

    value: str | tuple[Node, ...] | dict[str, Node]
    mark: Mark
    key: Mark | None = None

    @property
    def mapping(self) -> dict[str, Node]:
        """Entries of a mapping; empty for other values."""
        return self.value if isinstance(self.value, dict) else {}

    @property
    def items(self) -> tuple[Node, ...]:
        """Elements of a list; empty for other values."""
        return self.value if isinstance(self.value, tuple) else ()

    @property
    def text(self) -> str:
        """Scalar as written, or mapping or list in flow style."""
        if isinstance(self.value, dict):
            return "{" + ", ".join(f"{key}: {node.text}" for key, node in self.value.items()) + "}"
        if isinstance(self.value, tuple):
            return "[" + ", ".join(node.text for node in self.value) + "]"
        return self.value


@dataclass(frozen=True, slots=True)
class Problem:
    """Mistake in a file, with its position and a remedy."""

    file: str
    line: int
    column: int
    source_line: str
    message: str
    hint: str | None = None

    def __str__(self) -> str:
        location = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        text = f"{location}: {_shorten_message(self.message)}" + (
            f" ({_shorten_message(self.hint)})" if self.hint else ""
        )
        text = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
        if not self.column:
            return text
        start = max(0, self.column - MAX_LINE // 2) if self.column > MAX_LINE else 0
        line = self.source_line[start : start + MAX_LINE]
        line = "".join(letter if letter.isprintable() else " " for letter in line)
        return f"{text}\n    {line}\n    {' ' * (self.column - 1 - start)}^"


def _shorten_message(text: str) -> str:
    """Shorten a message and the values quoted in it."""
    return _QUOTED.sub(lambda match: _shorten(match[1], MAX_ECHO).join("``"), text)[:MAX_MESSAGE]


def _shorten(text: str, limit: int) -> str:
    return text if len(text) <= limit else text[:limit] + "..."


_QUOTED = re.compile(r"`([^`]*)`")


class StudyError(UserError):
    """Error with all mistakes in a study and its files, as `problems`."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        excess = len(self.problems) - MAX_PROBLEMS
        more = [f"and {excess} more like these"] if excess > 0 else []
        super().__init__("\n".join([*map(str, self.problems[:MAX_PROBLEMS]), *more]))


def problem(mark: Mark, message: str, hint: str | None = None) -> Problem:
    """Create a problem at a position."""
    return Problem(mark.file, mark.line, mark.column, mark.source_line, message, hint)


def plain(node: Node) -> Any:
    """Convert a tree to dictionaries, lists and strings."""
    if isinstance(node.value, dict):
        return {key: plain(child) for key, child in node.value.items()}
    if isinstance(node.value, tuple):
        return [plain(child) for child in node.value]
    return node.value


def read_text(path: Path) -> str:
    """Read a file. Raises StudyError if it is not UTF-8 text, or too long."""
    content = _content(path)
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8", "replace")
        mark = _mark_at(before, len(before), str(path))
        raise StudyError([problem(mark, "not a text file in UTF-8", "save it as UTF-8")]) from None
    if len(text) > MAX_CHARACTERS:
        raise StudyError([problem(Mark(str(path)), *_TOO_LONG)])
    return text


def _content(path: Path) -> bytes:
    """Read the bytes of a file. Raises StudyError if that is impossible, or the file too long."""
    try:
        if path.exists() and not path.is_file():  # pipes and devices may never end
            kind = "a folder" if path.is_dir() else "a pipe or a device"
            raise StudyError([problem(Mark(str(path)), f"this is {kind}", "name a file")])
        with path.open("rb") as file:
            content = file.read(4 * MAX_CHARACTERS + 1)  # UTF-8 has at most four bytes per character
    except (FileNotFoundError, ValueError):  # ValueError: invalid file name
        raise StudyError([problem(Mark(str(path)), "no such file")]) from None
    except OSError as error:
        raise StudyError([problem(Mark(str(path)), f"cannot be read: {error.strerror}")]) from None
    if len(content) > 4 * MAX_CHARACTERS:
        raise StudyError([problem(Mark(str(path)), *_TOO_LONG)])
    return content


_TOO_LONG = (f"more than {MAX_CHARACTERS} characters, with aliases expanded", "give ranges, or more studies")


class Document(NamedTuple):
    """Tree of a file, and its mistakes, such as duplicate keys and tags, despite which the tree is complete."""

    root: Node
    problems: tuple[Problem, ...]


def parse(text: str, file: str) -> Document:
    """Parse a YAML text. Raises StudyError for a syntax error, and for a tree too deep or too large."""
    import yaml

    class Loader(yaml.BaseLoader):
        """PyYAML's loader with limited depth."""

        depth = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            """Compose the next node."""
            self.depth += 1
            if self.depth > MAX_DEPTH:
                start = self.peek_event().start_mark
                raise yaml.MarkedYAMLError(None, None, f"more than {MAX_DEPTH} nested levels", start)
            node = super().compose_node(parent, index)
            self.depth -= 1
            return node

    try:
        root = yaml.compose(text, Loader=Loader)
    except yaml.YAMLError as error:
        raise StudyError([_syntax_problem(error, text, file)]) from None
    if root is None:
        return Document(Node({}, Mark(file)), ())
    converter = _Converter(file, _lines(text))
    return Document(converter.node(root), tuple(converter.problems))


_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_YAML_TAG = "tag:yaml.org,2002:"
_CONTROL_CHARACTERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
"""Rejected characters, which HDF5 cannot store or terminals interpret."""


def _lines(text: str) -> list[str]:
    """Split a text at the line breaks of YAML."""
    return _BREAK.split(text.removesuffix("\n"))


def _mark_at(text: str, index: int, file: str) -> Mark:
    """Return the position of a character of a text."""
    lines = _BREAK.split(text[:index])
    remainder = _BREAK.split(text[index:], maxsplit=1)[0]
    return Mark(file, len(lines), len(lines[-1]) + 1, lines[-1] + remainder)


def parse_argument(text: str, argument: str) -> Document:
    """Parse a value ``text`` from the command line, the end of ``argument``.

    Raises StudyError for a syntax error.
    """
    option = argument[: len(argument) - len(text)].replace("\n", " ")
    indented = " " * len(option) + text.replace("\n", " ")
    try:
        root, problems = parse(indented, ARGUMENT)
    except StudyError as error:
        raise StudyError(_relocate_problem(entry, argument) for entry in error.problems) from None
    return Document(_relocate(root, argument), tuple(_relocate_problem(entry, argument) for entry in problems))


def argument_mark(argument: str, column: int) -> Mark:
    """Return a position on the command line."""
    return Mark(ARGUMENT, 0, column, argument)


def _relocate_problem(entry: Problem, argument: str) -> Problem:
    return replace(entry, line=0, source_line=argument)


def _relocate(node: Node, argument: str) -> Node:
    value = node.value
    if isinstance(value, dict):
        value = {key: _relocate(child, argument) for key, child in value.items()}
    elif isinstance(value, tuple):
        value = tuple(_relocate(child, argument) for child in value)
    key = argument_mark(argument, node.key.column) if node.key else None
    return Node(value, argument_mark(argument, node.mark.column), key)


def _syntax_problem(error: yaml.YAMLError, text: str, file: str) -> Problem:
    start, position = getattr(error, "problem_mark", None), getattr(error, "position", None)
    reason = getattr(error, "problem", None) or str(error).splitlines()[0]
    context = getattr(error, "context", None)
    if context == "expected a single document in the stream":
        reason = "a second document begins here"
    elif context == "while scanning a simple key":
        start = getattr(error, "context_mark", None)  # the key without a colon; the scanner reports a later line
    if start is not None:
        lines = _lines(text)
        line = min(start.line, len(lines) - 1)
        column = start.column if line == start.line else len(lines[line])
        mark = Mark(file, line + 1, column + 1, lines[line])
    else:
        mark = Mark(file) if position is None else _mark_at(text, position, file)
    return problem(mark, f"not valid YAML: {reason}", _syntax_hint(reason))


_COLON = "a key ends with a colon and a space"
_SYNTAX_HINTS = {
    "found character '\\t'": "indent with spaces, not tabs",
    "could not find expected ':'": _COLON,
    "mapping values are not allowed": f"keys of one level have the same indentation, and {_COLON}",
    "expected <block end>, but found '<block mapping start>'": "keys of one level have the same indentation",
}


def _syntax_hint(reason: str) -> str | None:
    """Return the remedy of a frequent mistake; reason: the parser's message, compared by its beginning."""
    return next((hint for start, hint in _SYNTAX_HINTS.items() if reason.startswith(start)), None)


_UNIT = re.compile(r"[^\W\d]|%|°")


def _is_decimal_comma(previous: yaml.Node | None, following: yaml.Node) -> bool:
    """Check if two entries result from the comma of a decimal such as `0,2 mm`."""
    if previous is None or not isinstance(previous.value, str) or not isinstance(following.value, str):
        return False
    adjacent = previous.end_mark.index + 1 == following.start_mark.index
    return adjacent and bool(re.fullmatch(r"[+-]?\d+", previous.value)) and following.value[:1].isdecimal()


def _join(previous: Node, following: Node) -> Node:
    return replace(previous, value=f"{previous.text},{following.text}")


class _Converter:
    """Converter of PyYAML's nodes, which collects all mistakes."""

    def __init__(self, file: str, lines: list[str]) -> None:
        self.file, self.lines = file, lines
        self.problems: list[Problem] = []
        self.converted: dict[int, tuple[Node, int] | None] = {}  # with its characters; None while in conversion
        self.characters = 0  # characters so far, aliases expanded

    def mark(self, node: yaml.Node) -> Mark:
        start = node.start_mark
        line = self.lines[start.line] if start.line < len(self.lines) else ""
        return Mark(self.file, start.line + 1, start.column + 1, line)

    def node(self, raw: yaml.Node) -> Node:
        if id(raw) in self.converted:  # an alias
            result = self.converted[id(raw)]
            if result is None:
                return self.reject(raw, "an alias inside its own anchor")
            self.count(raw, result[1])
            return result[0]
        self.converted[id(raw)] = None
        start = self.characters
        self.count(raw, 1 + len(raw.value) * isinstance(raw.value, str))
        node = self.convert(raw)
        self.converted[id(raw)] = node, self.characters - start
        return node

    def count(self, raw: yaml.Node, characters: int) -> None:
        """Count characters. Raises StudyError for too many: nine nested lists of ten aliases have 1e9 values."""
        self.characters += characters
        if self.characters > MAX_CHARACTERS:
            raise StudyError([problem(self.mark(raw), *_TOO_LONG)])

    def convert(self, raw: yaml.Node) -> Node:
        import yaml

        tags = {yaml.MappingNode: "map", yaml.SequenceNode: "seq", yaml.ScalarNode: "str"}
        if raw.tag != _YAML_TAG + tags[type(raw)]:
            return self.reject(raw, f"the tag `{raw.tag.replace(_YAML_TAG, '!!')}` means nothing here")
        if isinstance(raw, yaml.MappingNode):
            return Node(self.entries(raw), self.mark(raw))
        if isinstance(raw, yaml.SequenceNode):
            items = [self.node(child) for child in raw.value]
            return Node(tuple(self.join_decimals(raw.value, items)), self.mark(raw))
        if _CONTROL_CHARACTERS.search(raw.value):
            return self.reject(raw, f"a character that is not allowed in {ascii(raw.value)[:MAX_ECHO]}")
        return Node(str(raw.value), self.mark(raw))

    def entries(self, raw: yaml.MappingNode) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        previous: tuple[str, yaml.Node | None] = ("", None)  # the last key, and its value
        for raw_key, raw_value in raw.value:
            key, value = self.node(raw_key), self.node(raw_value)
            if _is_decimal_comma(previous[1], raw_key) and value.value == "":
                entries[previous[0]] = _join(entries[previous[0]], key)
                continue
            self.add(entries, key, value)
            previous = (key.text, raw_value if key.text in entries else None)
        return entries

    def add(self, entries: dict[str, Node], key: Node, value: Node) -> None:
        if not isinstance(key.value, str):
            self.problems.append(problem(key.mark, "a key must be a word"))
        elif key.value in entries:
            earlier = entries[key.value].key
            location = f", first on line {earlier.line}" if earlier else ""
            self.problems.append(problem(key.mark, f"the key `{key.value}` is given twice{location}"))
        else:
            entries[key.value] = replace(value, key=key.mark)

    def join_decimals(self, raw: list[yaml.Node], items: list[Node]) -> Iterator[Node]:
        """Yield the items of a list, after joining `0` and `2 mm` that were written as `0,2 mm`."""
        skip = False
        for i, item in enumerate(items):
            following = raw[i + 1] if i + 1 < len(raw) else None
            is_split = (
                following is not None and _is_decimal_comma(raw[i], following) and _UNIT.search(items[i + 1].text)
            )
            if not skip:
                yield _join(item, items[i + 1]) if is_split else item
            skip = bool(is_split) and not skip

    def reject(self, raw: yaml.Node, message: str) -> Node:
        self.problems.append(problem(self.mark(raw), message))
        return Node("", self.mark(raw))
