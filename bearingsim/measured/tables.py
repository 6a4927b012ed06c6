"""Tables of signals: CSV and parquet, a column per channel and one of time."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.measured.arrays import TIMES
from bearingsim.measured.content import Content, MeasuredError, Stated
from bearingsim.measured.si import FACTORS

HEAD = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
"""Head of a column: name, and unit in brackets."""
SEPARATORS = (";", "\t", ",")
FIRST_BYTES = 1 << 16
"""Bytes in which separator and heads are sought."""
MOST_HEAD_LINES = 50
"""Lines before the numbers, of which the last are the heads."""
COMMA = re.compile(r"\d,\d")
DECIMAL_COMMAS = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?:\s+[+-]?\d+,\d+(?:[eE][+-]?\d+)?)+\s*")
"""Row of several numbers with decimal commas, separated by blanks."""
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
UNITS = {unit for unit in SECONDS if unit} | {unit for units in FACTORS.values() for unit in units}
"""Units by which a second line of heads is recognised."""


class Layout(NamedTuple):
    """Layout of a CSV file: separator (None: blanks), decimal sign, first line of numbers, heads of columns."""

    separator: str | None
    decimal: str
    begin: int
    heads: list[str]


def read_csv(path: Path) -> Content:
    """Read a CSV file: separator `,`, `;`, tab or blanks, with heads such as `time [s]`, or without.

    Heads may be two lines, names and units. A decimal comma is read if the separator is another.
    """
    import pandas as pd

    with path.open("rb") as file:
        beginning = file.read(FIRST_BYTES)
    if b"\0" in beginning:
        raise MeasuredError(path, "is no text, so no CSV file")
    lines = beginning.decode("utf-8-sig", "replace").splitlines()
    is_whole = len(beginning) < FIRST_BYTES or len(lines) == 1
    separator, decimal, begin, heads = _layout(path, lines if is_whole else lines[:-1])
    try:
        table = pd.read_csv(
            path, sep=separator or r"\s+", skiprows=begin, header=None, names=list(range(len(heads))), dtype=float,
            decimal=decimal, encoding="utf-8-sig", encoding_errors="replace", skip_blank_lines=True,
            index_col=False,
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError) as error:
        reason = str(error).splitlines()[0][:120]
        raise MeasuredError(path, f"is no table of numbers ({reason}); use a decimal point") from None
    return _content(path, heads, [table[number].to_numpy() for number in range(len(heads))])


def _layout(path: Path, lines: list[str]) -> Layout:
    """Find the layout in the first lines of a CSV file. Raises MeasuredError without numbers, or if a comma may be
    a separator as well as a decimal sign."""
    ends = lines[-2:]
    separator = next((letter for letter in SEPARATORS if any(letter in line for line in ends)), None)
    if separator == "," and all(DECIMAL_COMMAS.fullmatch(line) for line in ends):
        separator = None
    decimal = "," if separator != "," and any(COMMA.search(line) for line in lines[-MOST_HEAD_LINES:]) else "."
    rows = [n for n, line in enumerate(lines[:MOST_HEAD_LINES]) if _is_numeric(line, separator, decimal)]
    if not rows:
        raise MeasuredError(path, f"has no row of numbers in its first {min(len(lines), MOST_HEAD_LINES)} lines")
    width = len(_cells(lines[rows[0]], separator))
    above = [_cells(line, separator) for line in lines[: rows[0]] if line.strip()]
    heads = _heads(above, width)
    if separator == "," and heads is None:
        _refuse_ambiguous(path, lines[rows[0] :], above)
    return Layout(separator, decimal, rows[0], heads or [f"column {number + 1}" for number in range(width)])


def _heads(above: list[list[str]], width: int) -> list[str] | None:
    """Return the heads of columns from the cells above the numbers, `name [unit]`; None if there are none."""
    if not above or len(above[-1]) != width:
        return None
    units = [cell.strip("[]()") for cell in above[-1]]
    if len(above) > 1 and len(above[-2]) == width and any(unit in UNITS for unit in units):
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(above[-2], units, strict=True)]
    return above[-1]


def _refuse_ambiguous(path: Path, lines: list[str], above: list[list[str]]) -> None:
    """Raise MeasuredError if each comma of rows of numbers may be a decimal sign: digits on both sides only."""
    cells = [_cells(line, ",") for line in lines if line.strip()]
    if all(len(row) % 2 == 0 and all(map(str.isdecimal, row[1::2])) for row in cells):
        columns = len(cells[0])
        names = f", and {len(above[-1])} in the line above" if above else ""
        raise MeasuredError(
            path,
            f"has commas that may separate {columns} columns or be the decimal sign of {columns // 2}{names}: "
            f"export with decimal points, with `;` between columns, or with a line of {columns} names",
        )


def read_parquet(path: Path) -> Content:
    """Read a parquet file; needs pyarrow, the extra `parquet`."""
    import pandas as pd

    try:
        table: pd.DataFrame = pd.read_parquet(path)
    except ImportError:
        raise MeasuredError(path, "parquet needs pyarrow: `pip install 'bearingsim[parquet]'`") from None
    names = [str(name) for name in table if table[name].dtype.kind in "fiu"]
    return _content(path, names, [table[name].to_numpy() for name in names])


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip('"') for cell in (line.split(separator) if separator else line.split())]


def _is_numeric(line: str, separator: str | None, decimal: str) -> bool:
    """Check if a line consists of numbers; missing ones are empty or `nan`."""
    cells = [cell.replace(decimal, ".") for cell in _cells(line, separator)]
    try:
        return bool(cells) and any(cells) and all(cell == "" or float(cell) is not None for cell in cells)
    except ValueError:
        return False


def _content(path: Path, heads: list[str], columns: list[np.ndarray]) -> Content:
    """Return the content of columns: one named `time`, or a first one without a name that is evenly spaced."""
    channels, units, time = {}, {}, None
    for head, column in zip(heads, columns, strict=True):
        match = HEAD.match(head)
        name, unit = (match["name"] or head, match["unit"] or "") if match else (head, "")
        is_time = name.lower() in TIMES or (head == "column 1" and len(columns) > 1 and _is_even(column))
        if is_time and time is None:
            if unit not in SECONDS:
                raise MeasuredError(path, f"has times in `{unit}`: expected s, ms or us")
            time = Stated(SECONDS[unit] * column.astype(float), f"the column `{head}`")
        else:
            channels[name] = column
            if unit:
                units[name] = unit
    if not channels:
        raise MeasuredError(path, "has no column of a signal")
    return Content(channels, time, units=units)


def _is_even(column: np.ndarray) -> bool:
    """Check if a column is evenly spaced in time."""
    steps = np.diff(column[:1000])
    return bool(len(steps) > 2 and np.all(steps > 0.0) and np.ptp(steps) <= 0.02 * np.median(steps))
