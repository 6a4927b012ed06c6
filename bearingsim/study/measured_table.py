"""Tables of measured points: a header with units, and rows of parameters and features."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

from bearingsim.measured.content import MeasuredError
from bearingsim.measured.statements import HEADER
from bearingsim.measured.tables import SEPARATORS, decode, find_ambiguous
from bearingsim.text.numbers import is_number
from bearingsim.text.yamlfile import MAX_CHARACTERS, Mark, Node, Problem, problem

MAX_BYTES = MAX_CHARACTERS
"""Limit of the size of a table, some thousand rows."""
COMMENT = "#"


def table_rows(
    path: FilePath, problems: list[Problem], check_header: Callable[[str, str, Mark], None]
) -> Iterator[tuple[str, Node]]:
    """Yield position and entries of each row of a table in a text file; values have the unit of their column.

    Columns are separated by a semicolon, tab, comma or bar. ``check_header`` receives the name of a column, a
    number with its unit ("" for a text column), and its position, and adds a problem if one is wrong; the rows
    are then not read. Other mistakes are added to ``problems``.
    """

    def fail(mark: Mark, message: str, hint: str | None = None) -> None:
        problems.append(problem(mark, message, hint))

    numbered = _numbered_lines(path, fail)
    if not numbered:
        return
    (header_line, header), *rows = numbered
    separator = next((mark for mark in SEPARATORS if mark in header), ",")
    header_cells = _cells(header, separator)
    matches = [HEADER.match(text) for text, _ in header_cells]
    names = [((match and match["name"]) or "", (match and match["unit"]) or "") for match in matches]
    columns = [name for name, _ in names]
    duplicate = next((name for name in columns if name and columns.count(name) > 1), None)
    if duplicate is not None:
        fail(Mark(str(path), header_line, 1, header), f"has two columns `{duplicate}`", "remove one of them")
        return
    count, table = len(problems), [_cells(line, separator) for _, line in rows]
    for index, ((name, unit), (_, column)) in enumerate(zip(names, header_cells, strict=True)):
        texts = [cells[index][0] for cells in table if index < len(cells) and cells[index][0]]
        has_numbers = unit or (texts and all(is_number(text.replace(",", ".")) for text in texts))
        if name:
            check_header(
                name, f"1 {unit}".strip() if has_numbers else "", Mark(str(path), header_line, column, header)
            )
    if len(problems) > count:
        return
    if separator != "," and (objection := _object_to_commas(table, separator)):
        fail(Mark(str(path), header_line, 1, header), *objection)
        return
    for (number, line), cells in zip(rows, table, strict=True):
        mark = Mark(str(path), number, 1, line)
        if len(cells) != len(names):
            values, hint = f"{len(cells)} value{'s' * (len(cells) != 1)}", "are separator and quotes right?"
            fail(
                mark,
                f"has {values} for the {len(names)} column{'s' * (len(names) != 1)} of line {header_line}",
                hint,
            )
            return
        nameless = [column for name, (text, column) in zip(columns, cells, strict=True) if text and not name]
        if nameless:
            fail(replace(mark, column=nameless[0]), "has a value in a column without a header", "name the column")
            return
        yield f"{path.name}:{number}", Node(dict(_entries(names, cells, mark, separator)), mark)


def _object_to_commas(table: Sequence[Sequence[tuple[str, int]]], separator: str) -> tuple[str, str] | None:
    """Return a problem and its remedy if commas in numbers may have two meanings."""
    if texts := _mixed_decimals(table):
        listed = " and ".join(f"`{text}`" for text in texts)
        return (
            f"has numbers with a point and with a comma, {listed}",
            "use one decimal sign, and no thousands separator",
        )
    numbers = [[text if is_number(text.replace(",", ".")) else "" for text, _ in cells] for cells in table]
    if ambiguous := find_ambiguous(numbers, separator):
        message = f"has commas that may separate thousands or decimals, as in `{ambiguous}`"
        return message, "use decimal points, and no thousands separator"
    return None


def _mixed_decimals(table: Sequence[Sequence[tuple[str, int]]]) -> list[str]:
    """Return a number with a decimal point and another with a comma; none unless the table has both."""
    texts = [text for cells in table for text, _ in cells if is_number(text.replace(",", "."))]
    pair = [next((text for text in texts if sign in text), None) for sign in (".", ",")]
    return [text for text in pair if text is not None] if None not in pair else []


def _numbered_lines(path: FilePath, fail: Callable[..., None]) -> list[tuple[int, str]]:
    """Return line number and text of the header and the rows of a file; none if a problem is added by ``fail``."""
    if path.stat().st_size > MAX_BYTES:
        hint = "give means of repeated measurements, or fewer columns"
        fail(Mark(str(path)), f"has over {MAX_BYTES // 1000} kB, too much for a table of points", hint)
        return []
    try:
        _, text = decode(path, path.read_bytes())
    except MeasuredError as error:
        fail(Mark(str(path)), error.reason, "export the table as CSV")
        return []
    except OSError as error:
        fail(Mark(str(path)), f"cannot be read: {error.strerror}")
        return []
    lines = text.lstrip("\ufeff").splitlines()
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith(COMMENT)]
    if len(numbered) < 2:
        fail(Mark(str(path)), "has no row below a header line", "as in `load [N], velocity@BPFO [um/s]`")
        return []
    return numbered


def _entries(
    names: Sequence[tuple[str, str]], cells: Sequence[tuple[str, int]], mark: Mark, separator: str
) -> Iterator[tuple[str, Node]]:
    """Yield the non-empty values of a row by column; commas are decimal unless they separate the columns."""
    for (name, unit), (cell, column) in zip(names, cells, strict=True):
        if cell:
            number = cell if separator == "," else cell.replace(",", ".")
            text = f"{number} {unit}".strip() if is_number(number) else cell
            yield name, Node(text, replace(mark, column=column), Mark(mark.file, mark.line))


def _cells(line: str, separator: str) -> list[tuple[str, int]]:
    """Return the cells of a line, without quotes, with their columns from 1.

    Separators in quotes do not separate; the text after an unclosed quote is omitted.
    """
    cells: list[tuple[str, int]] = []
    column, pieces, is_quoted = 1, list[str](), False
    for piece in line.split(separator):
        pieces.append(piece)
        is_quoted ^= piece.count('"') % 2 == 1
        if not is_quoted:
            text = separator.join(pieces)
            cells.append((text.strip().strip('"').strip(), column + len(text) - len(text.lstrip())))
            column += len(text) + 1
            pieces = []
    return cells
