"""Lines of tables of signals, split into cells, and headers of columns, split into names and units."""

import csv
import re

from bearingsim.measured.arrays import normalize
from bearingsim.measured.si import FACTORS, SPEED_FACTORS, TIME_FACTORS
from bearingsim.measured.statements import COMMENT_MARKS, HEADER, parse_statements
from bearingsim.text.numbers import is_number

HEADER_BLANKS = [re.compile(pattern) for pattern in (r"\s+(?![\[(])", r"\s{2,}", r"(?<=[\])])\s+")]
"""Blanks that may separate headers: all but those before a unit in brackets, at least two, those after a unit."""
UNITS = {unit for unit in TIME_FACTORS if unit} | {unit for units in FACTORS.values() for unit in units}
"""Units by which a second header line is recognised."""
HEADER_UNITS = UNITS | set(SPEED_FACTORS) - {"rpm"}
"""Units behind a stroke or `in`; `a/rpm` is the speed of a group."""
TIME_UNIT = re.compile(r"^(?P<name>t|time|zeit)[ _](?P<unit>s|ms|us)$", re.IGNORECASE)
"""Header of a column of time with its unit, such as `time_ms`."""
NAME_AND_UNIT = re.compile(r"^(?P<name>[^\[\]()]+?)(?:\s*/\s*|\s+in\s+)[\[(]?(?P<unit>[^\[\]()]+)[\])]?$")
"""Header with its unit behind a stroke, as in DIN 461, or `in`, such as `t/ms`; the unit must be known."""
UNIT_LABELS = ("unit", "units", "einheit", "einheiten")
LABELS = (*UNIT_LABELS, "name", "names", "channel", "channels", "kanal", "signal", "signals")
"""Labels, as ``normalize`` returns them, of lines of headers, in front of the first of them."""
LINE_MARKS = "#%/ \t"
"""Marks of comments and blanks at the beginning of a line."""
REMARK_HEADERS = ("", "comment", "comments", "remark", "remarks", "bemerkung", "kommentar")
"""Headers, in lower case, of columns without numbers at the end of a line."""


def split_cells(line: str, separator: str | None) -> list[str]:
    """Split a line into cells, without blanks and quotes at their ends; separators in quotes do not separate."""
    if separator is not None and '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    return [cell.strip() for cell in (line.split(separator) if separator else line.split())]


def split_header_line(line: str, separator: str | None, width: int) -> list[str]:
    """Split a line of headers of ``width`` columns into cells, without quotes and marks of comments.

    Of separating blanks, those are chosen that yield ``width`` cells.
    """
    if separator:
        return split_cells(line, separator)
    text = line.strip().lstrip(LINE_MARKS)
    if '"' in text:
        return [cell for cell in next(csv.reader([text], delimiter=" ", skipinitialspace=True), []) if cell]
    splits = [blanks.split(text) for blanks in HEADER_BLANKS]
    return next((cells for cells in splits if len(cells) == width), splits[0])


def split_header(header: str) -> tuple[str, str]:
    """Split the header of a column into its name and its unit, "" without."""
    match = NAME_AND_UNIT.match(header)
    if match is None or match["unit"] not in HEADER_UNITS or header in UNITS:
        match = TIME_UNIT.match(header) or HEADER.match(header)
    return (match["name"], match["unit"] or "") if match else (header, "")


def parse_headers(above: list[list[str]], width: int) -> list[str] | None:
    """Return the headers, `name [unit]`, of ``width`` columns from the cells of the lines above the numbers.

    The line of headers may be a comment, and followed by one of units; columns of remarks at its end are ignored,
    as are labels, such as `Unit`, before the first column. None if the last line has another number of cells, or
    states a value.
    """
    rows = [[row[0].strip(COMMENT_MARKS), *row[1:]] for row in above]
    labelled_units: list[str] = []
    for row in rows:
        while len(row) > width and row[-1].lower() in REMARK_HEADERS:
            row.pop()
        label = normalize(row[0])
        if len(row) == width + 1 and label in LABELS and len(set(row[1:])) > 1:  # one unit is that of all channels
            row.pop(0)
            if label in UNIT_LABELS:
                labelled_units = row
    if not rows or len(rows[-1]) != width or any(is_number(cell) and not cell.isdecimal() for cell in rows[-1]):
        return None
    if width == 1 and any(parse_statements(rows[-1])):
        return None
    names, units = rows[-1], labelled_units
    if any(cell.strip("[]()") in UNITS for cell in names) or names is units:
        has_names = len(rows) > 1 and len(rows[-2]) == width
        if not has_names and names is not units:
            return names
        units = names
        names = rows[-2] if has_names else [f"column {number + 1}" for number in range(width)]
    if not units:
        return names
    cells = [cell.strip("[]()") for cell in units]
    return [f"{name} [{unit}]" if unit else name for name, unit in zip(names, cells, strict=True)]


def names_other_time_unit(cells: list[str]) -> bool:
    """Check if cells without numbers, such as headers, contain a unit of time other than the second."""
    units = [(split_header(cell)[1] or cell.strip("[]()")).lower() for cell in cells]
    return not any(map(is_number, cells)) and any(TIME_FACTORS.get(unit, 1.0) != 1.0 for unit in units)
