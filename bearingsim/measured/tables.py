"""Tables of signals: CSV and parquet, a column per channel and one of time."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bearingsim.measured.arrays import TIMES
from bearingsim.measured.content import Content, MeasuredError, Stated

if TYPE_CHECKING:
    pass

HEAD = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
"""Head of a column: name, and unit in brackets."""
SEPARATORS = (";", "\t", ",")
FIRST_BYTES = 1 << 16
"""Bytes in which separator and heads are sought."""
MOST_HEAD_LINES = 50
"""Lines before the numbers, of which the last is the heads."""
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}


def read_csv(path: Path) -> Content:
    """Read a CSV file: separator `,`, `;`, tab or blanks, with heads such as `time [s]`, or without."""
    import pandas as pd

    with path.open("rb") as file:
        beginning = file.read(FIRST_BYTES)
    if b"\0" in beginning:
        raise MeasuredError(path, "is no text, so no CSV file")
    lines = beginning.decode("utf-8-sig", "replace").splitlines()
    separator = next((letter for letter in SEPARATORS if any(letter in line for line in lines[-2:])), None)
    rows = [number for number, line in enumerate(lines[:MOST_HEAD_LINES]) if _is_numeric(line, separator)]
    if not rows:
        raise MeasuredError(path, f"has no row of numbers in its first {min(len(lines), MOST_HEAD_LINES)} lines")
    width = len(_cells(lines[rows[0]], separator))
    heads = _cells(lines[rows[0] - 1], separator) if rows[0] else []
    if len(heads) != width:
        heads = [f"column {number + 1}" for number in range(width)]
    try:
        table = pd.read_csv(
            path, sep=separator or r"\s+", skiprows=rows[0], header=None, names=list(range(width)), dtype=float,
            encoding="utf-8-sig", encoding_errors="replace", skip_blank_lines=True, index_col=False,
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError) as error:
        reason = str(error).splitlines()[0][:120]
        raise MeasuredError(path, f"is no table of numbers ({reason}); use a decimal point") from None
    return _content(path, heads, [table[number].to_numpy() for number in range(width)])


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


def _is_numeric(line: str, separator: str | None) -> bool:
    """Check if a line consists of numbers; missing ones are empty or `nan`."""
    cells = _cells(line, separator)
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
