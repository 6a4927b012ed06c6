"""Tables of measured points: a head with units, and rows of parameters and features."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

from bearingsim.measured.statements import HEAD
from bearingsim.measured.tables import SEPARATORS
from bearingsim.text.numbers import is_number
from bearingsim.text.yamlfile import MAX_CHARACTERS, Mark, Node, Problem, StudyError, problem, read_text

MOST_BYTES = MAX_CHARACTERS
"""Limit of the size of a table, some thousand rows."""
COMMENT = "#"


def table_rows(path: FilePath, problems: list[Problem]) -> Iterator[tuple[str, Node]]:
    """Yield place and entries of each row of a table in a text file; values have the unit of their head.

    Columns are separated by a semicolon, tab, comma or bar. Mistakes are added to ``problems``.
    """

    def fail(mark: Mark, message: str, hint: str | None = None) -> None:
        problems.append(problem(mark, message, hint))

    if path.stat().st_size > MOST_BYTES:
        hint = "give means of repeated measurements, or fewer columns"
        fail(Mark(str(path)), f"has over {MOST_BYTES // 1000} kB, too much for a table of points", hint)
        return
    try:
        lines = read_text(path).lstrip("\ufeff").splitlines()
    except StudyError as error:
        problems += error.problems
        return
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith(COMMENT)]
    if len(numbered) < 2:
        fail(Mark(str(path)), "has no row below a line of heads", "as in `load [N], velocity@BPFO [um/s]`")
        return
    (head_line, head), *rows = numbered
    separator = next((mark for mark in SEPARATORS if mark in head), ",")
    heads = [HEAD.match(text) for text, _ in _cells(head, separator)]
    names = [((match and match["name"]) or "", (match and match["unit"]) or "") for match in heads]
    columns = [name for name, _ in names]
    twice = next((name for name in columns if columns.count(name) > 1), None)
    if twice is not None:
        fail(Mark(str(path), head_line, 1, head), f"has two columns `{twice}`", "remove one of them")
        return
    for number, line in rows:
        cells = _cells(line, separator)
        mark = Mark(str(path), number, 1, line)
        if len(cells) != len(names):
            message = f"has {len(cells)} values for the {len(names)} heads of line {head_line}"
            fail(mark, message, "is the separator right?")
            return
        yield f"{path.name}:{number}", Node(dict(_entries(names, cells, mark, separator)), mark)


def _entries(
    names: Sequence[tuple[str, str]], cells: Sequence[tuple[str, int]], mark: Mark, separator: str
) -> Iterator[tuple[str, Node]]:
    """Yield the values of a row that are not empty; decimal commas are read if they do not separate."""
    for (name, unit), (cell, column) in zip(names, cells, strict=True):
        if cell:
            number = cell if separator == "," else cell.replace(",", ".")
            text = f"{number} {unit}".strip() if is_number(number) else cell
            yield name, Node(text, replace(mark, column=column), Mark(mark.file, mark.line))


def _cells(line: str, separator: str) -> list[tuple[str, int]]:
    """Return the cells of a line, without quotes, with their columns from 1."""
    cells, column = [], 1
    for text in line.split(separator):
        cells.append((text.strip().strip('"').strip(), column + len(text) - len(text.lstrip())))
        column += len(text) + 1
    return cells
