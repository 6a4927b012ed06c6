"""Tables of measured points: a head with units, and rows of parameters and features."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

from bearingsim.measured.statements import HEAD
from bearingsim.measured.tables import SEPARATORS
from bearingsim.text.yamlfile import Mark, Node, Problem, StudyError, problem, read_text

MOST_POINTS = 10_000
"""Limit of the rows of a table."""
COMMENT = "#"


def table_rows(path: FilePath, problems: list[Problem]) -> Iterator[tuple[str, Node]]:
    """Yield place and entries of each row of a table in a text file; values have the unit of their head.

    Columns are separated by a semicolon, tab, comma or bar. Mistakes are added to ``problems``.
    """

    def fail(mark: Mark, message: str, hint: str | None = None) -> None:
        problems.append(problem(mark, message, hint))

    try:
        lines = read_text(path).lstrip("\ufeff").splitlines()
    except (StudyError, OSError) as error:
        fail(Mark(str(path)), f"cannot be read as a table: {error}")
        return
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith(COMMENT)]
    if len(numbered) < 2:
        fail(Mark(str(path)), "has no row below a line of heads", "as in `load [N], velocity@BPFO [um/s]`")
        return
    if len(numbered) > MOST_POINTS:
        fail(Mark(str(path)), f"has {len(numbered) - 1} rows; at most {MOST_POINTS} are possible")
        return
    (head_line, head), *rows = numbered
    separator = next((mark for mark in SEPARATORS if mark in head), ",")
    heads = [HEAD.match(text) for text, _ in _cells(head, separator)]
    names = [((match and match["name"]) or "", (match and match["unit"]) or "") for match in heads]
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
            text = f"{number} {unit}".strip() if _is_number(number) else cell
            yield name, Node(text, replace(mark, column=column), Mark(mark.file, mark.line))


def _cells(line: str, separator: str) -> list[tuple[str, int]]:
    """Return the cells of a line, without quotes, with their columns from 1."""
    cells, column = [], 1
    for text in line.split(separator):
        cells.append((text.strip().strip('"').strip(), column + len(text) - len(text.lstrip())))
        column += len(text) + 1
    return cells


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
