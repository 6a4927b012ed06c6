"""Readers of tables of signals, CSV and parquet: a column for each channel, and one of time or none."""

import codecs
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.measured.arrays import (
    MAX_CHANGE,
    MIN_SAMPLES,
    TIME_NAMES,
    is_evenly_spaced,
    is_rising,
    mean_speed,
    names_time,
    normalize,
)
from bearingsim.measured.content import Content, MeasuredError, Stated, differ
from bearingsim.measured.headers import (
    names_other_time_unit,
    parse_headers,
    split_cells,
    split_header,
    split_header_line,
)
from bearingsim.measured.si import TIME_FACTORS
from bearingsim.measured.statements import INNER_COMMA, Statements, is_speed, parse_statements, speed_factor
from bearingsim.text.numbers import is_number

SEPARATORS = (";", "\t", ",", "|")
"""Separators of columns, in the order in which they are tried; a comma may be a decimal sign."""
FIRST_BYTES = 1 << 16
"""Number of bytes at the beginning of a file from which its layout is detected."""
BYTE_ORDERS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
"""Encodings by the byte-order mark, the first two bytes of a file."""
WINDOWS_ENCODING = "cp1252"
"""Encoding of files that are neither UTF-16 nor UTF-8: that of Windows in western Europe."""
LINE_END = re.compile(r"\r\n?|\n")
"""Ends of lines that pandas recognises; `str.splitlines` recognises others, such as form feeds."""
INTEGER = re.compile(r"[+-]?\d+")
"""Cell that may be the digits before a decimal comma."""
FRACTION = re.compile(r"\d+(?:[eE][+-]?\d+)?")
"""Cell that may be the digits behind a decimal comma, with an exponent."""
DECIMAL_COMMAS = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?:\s+[+-]?\d+,\d+(?:[eE][+-]?\d+)?)+\s*")
"""Line of at least two numbers with decimal commas, separated by blanks."""
GROUPED = re.compile(r"[+-]?\d{1,3}(?:(?P<thousands>[.,])\d{3})(?:(?P=thousands)\d{3})*(?P<decimal>[.,])\d+")
"""Number with a thousands separator and a different decimal sign."""
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""Number whose comma may be a thousands separator or a decimal sign."""
CLOCK_TIME = re.compile(r"\d:\d\d")
CLOCK_CELL = re.compile(r"[\d/.:TZ+ -]*\d:\d\d[\d/.,:TZ+ -]*")
"""Cell of a clock time, with a date or without."""
PADDED = re.compile(r"[+-]?0\d+")
"""Integer with leading zeros."""


class Layout(NamedTuple):
    """Layout of a CSV file.

    separator: None for blanks; decimal: decimal sign; thousands: thousands separator, None without; begin: number
    of lines above the numbers; headers: of all columns, "" for those without a name; above: lines above the
    numbers; are_seconds: False if these name another unit of time; clocks: numbers of the columns of clock times.
    """

    separator: str | None
    decimal: str
    thousands: str | None
    begin: int
    headers: list[str]
    above: list[str]
    are_seconds: bool
    clocks: tuple[int, ...] = ()


def read_csv(path: Path) -> Content:
    """Read a CSV file, with columns separated by `,`, `;`, tab, `|` or blanks, with or without column headers.

    Headers, such as `time [s]`, may be a comment, or two lines of names and units. A comma is the decimal sign if
    it does not separate columns; thousands separators are recognised in numbers with both signs. Rate, speed and
    unit may be stated above the headers, and the speed by a column. Raises MeasuredError if the file is no such
    table.
    """
    import pandas as pd

    with path.open("rb") as file:
        beginning = file.read(FIRST_BYTES)
    encoding, text = decode(path, beginning)
    lines = LINE_END.split(text.removesuffix("\n").removesuffix("\r"))
    is_whole = len(beginning) < FIRST_BYTES or len(lines) == 1
    layout = _detect_layout(path, lines if is_whole else lines[:-1])
    separator, decimal, thousands, begin, headers, above, are_seconds, clocks = layout
    used = [number for number in range(len(headers)) if number not in clocks]
    try:
        table = pd.read_csv(
            path, sep=separator or r"\s+", skiprows=begin, header=None, names=list(range(len(headers))),
            usecols=used, dtype=float, decimal=decimal, thousands=thousands, encoding=encoding,
            encoding_errors="replace", skip_blank_lines=True, index_col=False,
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError) as error:
        reason = str(error).splitlines()[0][:120]
        raise MeasuredError(
            path, f"is not a table of numbers ({reason}); remove text below the headers, and use a decimal point"
        ) from None
    columns = [table[number].to_numpy() for number in used]
    if len(columns) == 1 and MIN_SAMPLES <= len(columns[0]) - 1 == columns[0][0]:
        columns = [columns[0][1:]]  # without the number of samples
    statements = parse_statements(above, decimal, separator)
    content = _make_content(path, [headers[number] for number in used], columns, statements, are_seconds)
    return replace(content, clock=f"the column `{headers[clocks[0]]}`" if clocks else "")


def decode(path: Path, beginning: bytes) -> tuple[str, str]:
    """Decode the first bytes of a file; return its encoding, and the text. Raises MeasuredError for a binary file.

    UTF-16, as in Excel's "Unicode text", is recognised by its byte-order mark; other text is UTF-8 or
    ``WINDOWS_ENCODING``.
    """
    encoding = BYTE_ORDERS.get(beginning[:2])
    if encoding is not None:
        return encoding, beginning.decode(encoding, "replace")
    if b"\0" in beginning:
        if _may_be_utf16(beginning):
            raise MeasuredError(path, "is UTF-16 without a byte-order mark: save it as UTF-8")
        raise MeasuredError(path, "is not a text file, so it cannot be CSV")
    decoder = codecs.getincrementaldecoder("utf-8-sig")()
    try:
        return "utf-8-sig", decoder.decode(beginning, final=len(beginning) < FIRST_BYTES)
    except UnicodeDecodeError:
        return WINDOWS_ENCODING, beginning.decode(WINDOWS_ENCODING, "replace")


def _may_be_utf16(beginning: bytes) -> bool:
    """Check if nearly every second of the first bytes is zero, and none of the others: numbers in UTF-16."""
    even, odd = beginning[::2], beginning[1::2]
    return any(high.count(0) > 0.9 * len(high) and 0 not in low for high, low in ((even, odd), (odd, even)))


def _detect_layout(path: Path, lines: list[str]) -> Layout:
    """Detect the layout of a CSV file from its first lines.

    Raises MeasuredError without numbers, and if the role of its commas is ambiguous.
    """
    last_lines = lines[-2:]
    separator = next(
        (sign for sign in SEPARATORS if any(sign in _remove_quoted(line) for line in last_lines)), None
    )
    if separator == "," and all(DECIMAL_COMMAS.fullmatch(line) for line in last_lines):
        separator = None
    decimal, thousands = _detect_signs(path, lines, separator)
    rows = [n for n, line in enumerate(lines) if _is_numeric(line, separator, decimal, thousands)]
    without_clocks = lines if rows else _remove_clock_times(lines, separator)
    if without_clocks != lines and _has_numbers(path, without_clocks, separator):
        layout = _detect_layout(path, without_clocks)
        numbers = enumerate(split_cells(lines[layout.begin], separator))
        clocks = tuple(number for number, cell in numbers if CLOCK_CELL.fullmatch(cell))
        is_named = not any(layout.headers[number] == f"column {number + 1}" for number in clocks)
        if separator != "," or is_named:  # else a comma may be the decimal sign of the times
            return layout._replace(above=lines[: layout.begin], clocks=clocks)
    if not rows:
        has_clock_times = any(CLOCK_TIME.search(line) for line in last_lines)
        advice = ": its times are clock times; export them in seconds" if has_clock_times else ""
        raise MeasuredError(path, f"has no row of numbers in its first {len(lines)} lines{advice}")
    has_column_numbers = len(rows) > 1 and _are_column_numbers(
        *(split_cells(lines[row], separator) for row in rows[:2])
    )
    if has_column_numbers or (len(rows) > 1 and _is_count(lines[rows[0]], lines[rows[1]], separator)):
        rows = rows[1:]
    table = [split_cells(lines[row], separator) for row in rows]
    width = len(table[0])
    filled_width = max(number + 1 for row in table for number, cell in enumerate(row) if cell)
    titles = [line for line in lines[: rows[0]] if any(map(str.isalnum, line))]  # the others are blank, or rules
    above = [[line] if width == 1 else split_header_line(line, separator, width) for line in titles]
    headers = None if has_column_numbers else parse_headers(above, width) or parse_headers(above, filled_width)
    if separator == "," and not has_column_numbers:
        is_named = headers is not None and not INNER_COMMA.search(titles[-1])
        _refuse_ambiguous(path, lines[rows[0] :], above, is_named)
    names = headers or [f"column {number + 1}" for number in range(width)]
    names += [""] * (width - len(names))  # rows end with more separators than the headers
    are_seconds = not any(map(names_other_time_unit, above))
    return Layout(separator, decimal, thousands, rows[0], names, lines[: rows[0]], are_seconds)


def _has_numbers(path: Path, lines: list[str], separator: str | None) -> bool:
    """Check if a line is a row of numbers."""
    decimal, thousands = _detect_signs(path, lines, separator)
    return any(_is_numeric(line, separator, decimal, thousands) for line in lines)


def _remove_clock_times(lines: list[str], separator: str | None) -> list[str]:
    """Return lines without the content of cells of clock times; unchanged between blanks, and with quotes."""
    if separator is None or any('"' in line for line in lines):
        return lines
    return [
        separator.join("" if CLOCK_CELL.fullmatch(cell) else cell for cell in split_cells(line, separator))
        for line in lines
    ]


def _detect_signs(path: Path, lines: list[str], separator: str | None) -> tuple[str, str | None]:
    """Return the decimal sign of rows of numbers, and their thousands separator if a number has both signs.

    Raises MeasuredError if all commas may be thousands separators or decimal signs.
    """
    rows = [row for row in (split_cells(line, separator) for line in lines) if all(map(_may_be_number, row))]
    for match in (GROUPED.fullmatch(cell) for row in rows for cell in row):
        if match and match["decimal"] != match["thousands"]:
            return match["decimal"], match["thousands"]
    if separator == "," or not any("," in cell for row in rows for cell in row):
        return ".", None
    ambiguous = find_ambiguous(rows, separator)
    if ambiguous is not None:
        raise MeasuredError(
            path,
            f"has commas that may separate thousands or decimals, as in `{ambiguous}`: export with decimal points",
        )
    return ",", None


def find_ambiguous(rows: Sequence[Sequence[str]], separator: str | None) -> str | None:
    """Return a cell of rows of numbers whose comma may separate thousands or decimals, if that holds for all.

    None between semicolons, which replace commas as separators where these are decimal signs, if all cells of
    columns with commas have three decimals.
    """
    cells = [cell for row in rows for cell in row]
    with_comma = [cell for cell in cells if "," in cell]
    if not with_comma or not all(map(THOUSANDS.fullmatch, with_comma)):
        return None
    numbers = {number for row in rows for number, cell in enumerate(row) if "," in cell}
    in_columns = [cell for row in rows for number, cell in enumerate(row) if cell and number in numbers]
    is_decimal = separator == ";" and len(in_columns) == len(with_comma) and not any("." in cell for cell in cells)
    return None if is_decimal else with_comma[0]


def _may_be_number(cell: str) -> bool:
    """Check if a cell is empty or a number with a decimal point or comma, or with thousands separators."""
    return not cell or bool(GROUPED.fullmatch(cell)) or is_number(cell.replace(",", "."))


def _is_count(line: str, below: str, separator: str | None) -> bool:
    """Check if a line is a single integer, such as the number of samples, above rows of several numbers."""
    return bool(INTEGER.fullmatch(line.strip())) and len(split_cells(below, separator)) > 1


def _refuse_ambiguous(path: Path, lines: list[str], above: list[list[str]], is_named: bool) -> None:
    """Raise MeasuredError if every second comma of rows of numbers may be a decimal sign, between digits only.

    above: cells of the lines above the numbers; is_named: these name all columns, which is no proof if leading
    zeros indicate decimals, because a title may contain a comma.
    """
    rows = [split_cells(line, ",") for line in lines if line.strip()]
    if all(len(row) % 2 == 0 and all(map(INTEGER.fullmatch, row[::2])) for row in rows) and all(
        FRACTION.fullmatch(cell) for row in rows for cell in row[1::2]
    ):
        padded = [any(PADDED.fullmatch(cell) for row in rows for cell in row[begin::2]) for begin in (0, 1)]
        if is_named and padded != [False, True]:
            return
        columns = len(rows[0])
        names = f", and {len(above[-1])} in the line above" if above else ""
        advice = "" if is_named else f", or with a line of {columns} names"
        raise MeasuredError(
            path,
            f"has commas that may separate {columns} columns or be the decimal sign of {columns // 2}{names}: "
            f"export with decimal points, or with `;` between columns{advice}",
        )


def read_parquet(path: Path) -> Content:
    """Read the numeric columns of a parquet file, and its index if the index has a name or contains dates.

    Without a numeric time, the first column of dates is the time if they increase.

    Raises MeasuredError without pyarrow, which the extra `parquet` installs.
    """
    import pandas as pd

    try:
        table: pd.DataFrame = pd.read_parquet(path)
    except ImportError:
        raise MeasuredError(path, "parquet needs pyarrow: `pip install 'bearingsim[parquet]'`") from None
    if table.index.name is not None or table.index.dtype.kind == "M":
        table = table.reset_index()
    names = [str(name) for name in table if table[name].dtype.kind in "fiu"]
    columns = [table[name].to_numpy() for name in names]
    clocks = [str(name) for name in table if table[name].dtype.kind == "M"]
    if clocks and len(table) and not any(normalize(name) in TIME_NAMES for name in names):
        dates = table[clocks[0]]
        instants = (dates - dates.iloc[0]).dt.total_seconds().to_numpy()
        if is_rising(instants):
            names, columns = [f"{clocks[0]} [s]", *names], [instants, *columns]
    return _make_content(path, names, columns, Statements(), True)


def _remove_quoted(line: str) -> str:
    """Remove the quoted parts of a line."""
    return re.sub(r'"[^"]*"', "", line)


def _is_numeric(line: str, separator: str | None, decimal: str, thousands: str | None) -> bool:
    """Check if all cells of a line are numbers or empty, and at least one is not empty."""
    cells = split_cells(line, separator)
    if thousands:
        cells = [cell.replace(thousands, "") for cell in cells]
    return any(cells) and all(not cell or is_number(cell.replace(decimal, ".")) for cell in cells)


def _are_column_numbers(cells: list[str], below: list[str]) -> bool:
    """Check if cells number the columns, as pandas writes above columns without names; below: the next row."""
    sequences = [[str(number) for number in range(start, start + len(below))] for start in (0, 1)]
    return cells in sequences and not all(map(INTEGER.fullmatch, below))


def _make_content(
    path: Path, headers: list[str], columns: list[np.ndarray], stated: Statements, are_seconds: bool
) -> Content:
    """Make the content of a table from its columns.

    The time is a column of a known name, the first column if its unit is one of time or, in a table without
    headers, the first column if it is evenly spaced and nothing names another unit than s. So are evenly spaced
    columns of a known name with a number. Columns without numbers and those of row numbers are omitted. Raises
    MeasuredError for times in an unknown unit, for two channels of one name, and without channels.
    """
    channels, units, other_speed = {}, {}, stated.other_speed
    times: list[Stated[np.ndarray]] = []
    speeds = {"": stated.speed} if stated.speed else {}
    used = [
        n for n, column in enumerate(columns) if not _is_empty(column) and not _are_row_numbers(headers[n], column)
    ]
    for number in used:
        header, column = headers[number], columns[number].astype(float)
        name, unit = split_header(header)
        group, _, own_name = name.rpartition("/")
        key = normalize(own_name)
        is_first = number == used[0] and len(used) > 1
        has_time_unit = unit != "" and unit.lower() in TIME_FACTORS
        is_unnamed = header == f"column {number + 1}" and are_seconds
        is_time = names_time(own_name, column) or (
            is_first and ((has_time_unit and is_rising(column)) or (is_unnamed and is_evenly_spaced(column)))
        )
        if is_time and (not times or (unit.lower() in TIME_FACTORS and is_rising(column))):
            if unit.lower() not in TIME_FACTORS:
                raise MeasuredError(path, f"has times in `{unit}`: expected s, ms or us")
            times.append(Stated(TIME_FACTORS[unit.lower()] * column, f"the column `{header}`", group))
        elif is_speed(key, unit.lower()):
            speed, highest = mean_speed(speed_factor(unit.lower()) * column, f"the column `{header}`")
            stated_speed = speeds.get(group, speed)
            if differ(stated_speed.value, speed.value, MAX_CHANGE):
                other_speed = stated_speed
            speeds[group], other_speed = speed, highest or other_speed
        else:
            if name in channels:
                raise MeasuredError(path, f"has two columns `{name}`: rename or remove one of them")
            channels[name or f"column {number + 1}"] = column
            units[name or f"column {number + 1}"] = unit or stated.unit or ""
    if not channels:
        raise MeasuredError(path, "has no column of a signal")
    units = {name: unit for name, unit in units.items() if unit}
    rates = [rate for rate in (stated.rate, stated.other_rate) if rate is not None]
    return Content(channels, times, rates, speeds, units, other_speed)


def _is_empty(column: np.ndarray) -> bool:
    """Check if a column has rows, but no number."""
    return len(column) > 0 and bool(np.all(np.isnan(column.astype(float))))


def _are_row_numbers(header: str, column: np.ndarray) -> bool:
    """Check if the values of a column increase by 1, and its header has no unit and is not that of a time."""
    name, unit = split_header(header)
    is_time = normalize(name.rpartition("/")[2]) in TIME_NAMES
    return not is_time and not unit and len(column) > 1 and bool(np.all(np.diff(column.astype(float)) == 1.0))
