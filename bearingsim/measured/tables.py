"""Tables of signals: CSV and parquet, a column per channel and one of time."""

import codecs
import csv
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.measured.arrays import MAX_CHANGE, TIMES, rate_of_other_times, rises, sampled_speed, word_of
from bearingsim.measured.content import Content, MeasuredError, Stated, differ
from bearingsim.measured.si import FACTORS, SECONDS
from bearingsim.measured.statements import HEADER, MARKS, Statements, is_speed, speed_factor, statements
from bearingsim.text.numbers import is_number

SEPARATORS = (";", "\t", ",", "|")
FIRST_BYTES = 1 << 16
"""Bytes searched for the separator and the column headers."""
BYTE_ORDERS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
"""Encodings by the first two bytes of a file."""
WESTERN = "cp1252"
"""Encoding of other files: that of Windows in western Europe, in which nearly every byte is a character."""
LINE_END = re.compile(r"\r\n?|\n")
"""Ends of lines as pandas counts them; `str.splitlines` has others, such as form feeds."""
DIGITS = re.compile(r"[+-]?\d+")
FRACTION = re.compile(r"\d+(?:[eE][+-]?\d+)?")
"""Digits before and after a decimal comma."""
DECIMAL_COMMAS = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?:\s+[+-]?\d+,\d+(?:[eE][+-]?\d+)?)+\s*")
"""Row of several numbers with decimal commas, separated by blanks."""
GROUPED = re.compile(r"[+-]?\d{1,3}(?:(?P<thousands>[.,])\d{3})(?:(?P=thousands)\d{3})*(?P<decimal>[.,])\d+")
"""Number with a thousands separator and a different decimal sign."""
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""Number whose comma may separate thousands as well as decimals."""
BLANKS = re.compile(r"\s+(?![\[(])")
"""Blanks between the headers of columns, not those before a unit."""
CLOCK = re.compile(r"\d:\d\d")
UNITS = {unit for unit in SECONDS if unit} | {unit for units in FACTORS.values() for unit in units}
"""Units by which a second header line is recognised."""
TIME_UNIT = re.compile(r"^(?P<name>t|time)[ _](?P<unit>s|ms|us)$", re.IGNORECASE)
"""Header of a column of time with its unit, such as `time_ms`."""
REMARK_HEADS = ("", "comment")
"""Headers of columns behind the last one with numbers."""


class Layout(NamedTuple):
    """Layout of a CSV file: separator (None: blanks), decimal sign and thousands separator, first line of numbers,
    column headers, and lines above."""

    separator: str | None
    decimal: str
    thousands: str | None
    begin: int
    headers: list[str]
    above: list[str]


def read_csv(path: Path) -> Content:
    """Read a CSV file: separator `,`, `;`, tab, `|` or blanks, with column headers such as `time [s]`, or without.

    Headers may be two lines, names and units, and a comment. A decimal comma is read if the separator is another,
    thousands separators if a number has both signs. Rate, speed and unit may be stated above the headers, and the
    speed by a column.
    """
    import pandas as pd

    with path.open("rb") as file:
        beginning = file.read(FIRST_BYTES)
    encoding, text = decoded(path, beginning)
    lines = LINE_END.split(text.removesuffix("\n").removesuffix("\r"))
    is_whole = len(beginning) < FIRST_BYTES or len(lines) == 1
    separator, decimal, thousands, begin, headers, above = _layout(path, lines if is_whole else lines[:-1])
    try:
        table = pd.read_csv(
            path, sep=separator or r"\s+", skiprows=begin, header=None, names=list(range(len(headers))),
            dtype=float, decimal=decimal, thousands=thousands, encoding=encoding, encoding_errors="replace",
            skip_blank_lines=True, index_col=False,
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError) as error:
        reason = str(error).splitlines()[0][:120]
        raise MeasuredError(
            path, f"is not a table of numbers ({reason}); remove text below the headers, and use a decimal point"
        ) from None
    columns = [table[number].to_numpy() for number in range(len(headers))]
    return _content(path, headers, columns, statements(above, decimal, separator))


def decoded(path: Path, beginning: bytes) -> tuple[str, str]:
    """Return the encoding of a file, and its first bytes as text. Raises MeasuredError for other than text.

    UTF-16, as in Excel's "Unicode text", is recognised by its byte-order mark; other text is UTF-8 or ``WESTERN``.
    """
    encoding = BYTE_ORDERS.get(beginning[:2])
    if encoding is not None:
        return encoding, beginning.decode(encoding, "replace")
    if b"\0" in beginning:
        raise MeasuredError(path, "is not a text file, so it cannot be CSV")
    decoder = codecs.getincrementaldecoder("utf-8-sig")()
    try:
        return "utf-8-sig", decoder.decode(beginning, final=len(beginning) < FIRST_BYTES)
    except UnicodeDecodeError:
        return WESTERN, beginning.decode(WESTERN, "replace")


def _layout(path: Path, lines: list[str]) -> Layout:
    """Find the layout in the first lines of a CSV file. Raises MeasuredError without numbers, or if a comma may be
    a separator as well as a decimal sign."""
    ends = lines[-2:]
    separator = next((letter for letter in SEPARATORS if any(letter in _unquoted(line) for line in ends)), None)
    if separator == "," and all(DECIMAL_COMMAS.fullmatch(line) for line in ends):
        separator = None
    decimal, thousands = _signs(path, lines, separator)
    rows = [n for n, line in enumerate(lines) if _is_numeric(line, separator, decimal, thousands)]
    if not rows:
        has_clock = any(CLOCK.search(line) for line in ends)
        advice = ": its times are clock times; export them in seconds" if has_clock else ""
        raise MeasuredError(path, f"has no row of numbers in its first {len(lines)} lines{advice}")
    is_counted = len(rows) > 1 and _counts_columns(*(_cells(lines[row], separator) for row in rows[:2]))
    if is_counted:
        rows = rows[1:]
    table = [_cells(lines[row], separator) for row in rows]
    width = len(table[0])
    filled = max(number + 1 for row in table for number, cell in enumerate(row) if cell)
    heads = [line for line in lines[: rows[0]] if any(map(str.isalnum, line))]  # the others are rules
    above = [[line] if width == 1 else _header_cells(line, separator) for line in heads]
    headers = None if is_counted else _headers(above, width) or _headers(above, filled)
    if separator == "," and headers is None and not is_counted:
        _refuse_ambiguous(path, lines[rows[0] :], above)
    names = headers or [f"column {number + 1}" for number in range(width)]
    names += [""] * (width - len(names))  # rows end with separators
    return Layout(separator, decimal, thousands, rows[0], names, lines[: rows[0]])


def _signs(path: Path, lines: list[str], separator: str | None) -> tuple[str, str | None]:
    """Return the decimal sign of rows of numbers, and their thousands separator if a number has both signs.

    Raises MeasuredError if all commas may separate thousands as well as decimals.
    """
    rows = [row for row in (_cells(line, separator) for line in lines) if all(map(_may_be_number, row))]
    for match in (GROUPED.fullmatch(cell) for row in rows for cell in row):
        if match and match["decimal"] != match["thousands"]:
            return match["decimal"], match["thousands"]
    cells = [cell for row in rows for cell in row if "," in cell and separator != ","]
    if cells and all(map(THOUSANDS.fullmatch, cells)):
        raise MeasuredError(
            path,
            f"has commas that may separate thousands or decimals, as in `{cells[0]}`: export with decimal points",
        )
    return ("," if cells else "."), None


def _may_be_number(cell: str) -> bool:
    """Check if a cell is empty or a number with a decimal point or comma, or with thousands separators."""
    return not cell or bool(GROUPED.fullmatch(cell)) or is_number(cell.replace(",", "."))


def _headers(above: list[list[str]], width: int) -> list[str] | None:
    """Return the column headers from the cells above the numbers, `name [unit]`; None if there are none.

    A header line states no value, and may be a comment; columns of remarks behind the last are ignored.
    """
    rows = [[row[0].strip(MARKS), *row[1:]] for row in above]
    for row in rows:
        while len(row) > width and row[-1].lower() in REMARK_HEADS:
            row.pop()
    if not rows or len(rows[-1]) != width or any(is_number(cell) and not cell.isdecimal() for cell in rows[-1]):
        return None
    if width == 1 and any(statements(rows[-1])):
        return None
    units = [cell.strip("[]()") for cell in rows[-1]]
    if len(rows) > 1 and len(rows[-2]) == width and any(unit in UNITS for unit in units):
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(rows[-2], units, strict=True)]
    return rows[-1]


def _refuse_ambiguous(path: Path, lines: list[str], above: list[list[str]]) -> None:
    """Raise MeasuredError if each comma of rows of numbers may be a decimal sign: digits on both sides only."""
    cells = [_cells(line, ",") for line in lines if line.strip()]
    if all(len(row) % 2 == 0 and all(map(DIGITS.fullmatch, row[::2])) for row in cells) and all(
        FRACTION.fullmatch(cell) for row in cells for cell in row[1::2]
    ):
        columns = len(cells[0])
        names = f", and {len(above[-1])} in the line above" if above else ""
        raise MeasuredError(
            path,
            f"has commas that may separate {columns} columns or be the decimal sign of {columns // 2}{names}: "
            f"export with decimal points, with `;` between columns, or with a line of {columns} names",
        )


def read_parquet(path: Path) -> Content:
    """Read a parquet file, with its index if that has a name; needs pyarrow, the extra `parquet`."""
    import pandas as pd

    try:
        table: pd.DataFrame = pd.read_parquet(path)
    except ImportError:
        raise MeasuredError(path, "parquet needs pyarrow: `pip install 'bearingsim[parquet]'`") from None
    if table.index.name is not None:
        table = table.reset_index()
    names = [str(name) for name in table if table[name].dtype.kind in "fiu"]
    return _content(path, names, [table[name].to_numpy() for name in names], Statements())


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line, without blanks and quotes; quotes may enclose a separator."""
    if separator is not None and '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    return [cell.strip() for cell in (line.split(separator) if separator else line.split())]


def _header_cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a header line; a blank before a unit in brackets does not separate."""
    return _cells(line, separator) if separator else BLANKS.split(line.strip())


def _unquoted(line: str) -> str:
    """Return a line without what quotes enclose."""
    return re.sub(r'"[^"]*"', "", line)


def _is_numeric(line: str, separator: str | None, decimal: str, thousands: str | None) -> bool:
    """Check if a line consists of numbers; missing ones are empty or `nan`."""
    cells = _cells(line, separator)
    if thousands:
        cells = [cell.replace(thousands, "") for cell in cells]
    return any(cells) and all(not cell or is_number(cell.replace(decimal, ".")) for cell in cells)


def _counts_columns(cells: list[str], below: list[str]) -> bool:
    """Check if cells count columns, as pandas writes above columns without names; below: the next row."""
    counts = [[str(number) for number in range(start, start + len(below))] for start in (0, 1)]
    return cells in counts and not all(map(DIGITS.fullmatch, below))


def _content(path: Path, headers: list[str], columns: list[np.ndarray], stated: Statements) -> Content:
    """Return the content of columns: one named `time`, or a first one without a name that is evenly spaced.

    Columns without numbers are omitted, and so are those of row numbers.
    """
    channels, units, other_speed = {}, {}, stated.other_speed
    times: list[Stated[np.ndarray]] = []
    speeds = {"": stated.speed} if stated.speed else {}
    filled = [n for n, column in enumerate(columns) if not _is_empty(column) and not _counts(headers[n], column)]
    for number in filled:
        header, column = headers[number], columns[number].astype(float)
        name, unit = _name_and_unit(header)
        owner, _, last = name.rpartition("/")
        is_first = number == filled[0] and len(filled) > 1
        is_time = word_of(last) in TIMES or (header == f"column {number + 1}" and is_first and _is_even(column))
        if is_time and (not times or (unit.lower() in SECONDS and rises(column))):
            if unit.lower() not in SECONDS:
                raise MeasuredError(path, f"has times in `{unit}`: expected s, ms or us")
            times.append(Stated(SECONDS[unit.lower()] * column, f"the column `{header}`"))
        elif is_speed(word_of(last), unit.lower()):
            factor = speed_factor(word_of(last), unit.lower())
            speed, end = sampled_speed(factor * column, f"the column `{header}`")
            stated_speed = speeds.get(owner, speed)
            if differ(stated_speed.value, speed.value, MAX_CHANGE):
                other_speed = stated_speed
            speeds[owner], other_speed = speed, end or other_speed
        else:
            if name in channels:
                raise MeasuredError(path, f"has two columns `{name}`: rename or remove one of them")
            channels[name or f"column {number + 1}"] = column
            units[name or f"column {number + 1}"] = unit or stated.unit or ""
    if not channels:
        raise MeasuredError(path, "has no column of a signal")
    units = {name: unit for name, unit in units.items() if unit}
    time, other_rate = times[0] if times else None, stated.other_rate or rate_of_other_times(times)
    return Content(channels, time, stated.rate, speeds, units, other_rate, other_speed)


def _name_and_unit(header: str) -> tuple[str, str]:
    """Split the header of a column into its name and unit."""
    match = TIME_UNIT.match(header) or HEADER.match(header)
    return (match["name"], match["unit"] or "") if match else (header, "")


def _is_empty(column: np.ndarray) -> bool:
    """Check if a column has rows, but no number."""
    return len(column) > 0 and bool(np.all(np.isnan(column.astype(float))))


def _counts(header: str, column: np.ndarray) -> bool:
    """Check if a column contains row numbers, and is not named as time."""
    is_time = word_of(_name_and_unit(header)[0].rpartition("/")[2]) in TIMES
    return not is_time and len(column) > 1 and bool(np.all(np.diff(column.astype(float)) == 1.0))


def _is_even(column: np.ndarray) -> bool:
    """Check if a column is evenly spaced in time."""
    steps = np.diff(column[:1000])
    return bool(len(steps) > 2 and np.all(steps > 0.0) and np.ptp(steps) <= 0.02 * np.median(steps))
