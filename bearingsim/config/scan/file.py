"""Reader of measured depth maps, which returns them in SI and without repairs.

A CSV file (.csv or .txt) has one point per line, and columns named with their units:

    s [mm],z [mm],depth [um]
    -1.0,-3.0,0.1

or it contains a grid, whose first cell names its values, its rows and its columns:

    depth [um] | z [mm] | s [mm],-1.0,-0.9
    -3.0,0.1,0.2

An HDF5 file has the datasets `s` (n_s,), `z` (n_z,) and `depth` (n_z, n_s), each with the attribute `units`. s is
the coordinate in the rolling direction, z that in the axial direction. `height`, positive out of the material, may
replace `depth`, positive into it. In CSV, lines that begin with # are comments.
"""

import csv
import hashlib
import io
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from os.path import isdir, isfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.errors import UserError
from bearingsim.text.units import UnitError, parse

COLUMN_NAMES = ("s", "z", "depth", "height")
MAX_POINTS = 4_000_000
POINT_BYTES, MAX_BYTES = 16, 200_000_000
"""Largest sizes (bytes) of a number in an HDF5 file, and of a file: 4 million cells of text take about 100 MB."""
MIN_FILLED_FRACTION = 0.5  # minimum number of points, relative to the cells of the grid of their coordinates
MAX_QUOTE, MIN_QUOTE = 60, 12  # limits of the characters of a file's first line quoted in a message
TRANSFERRED_FILES: dict[str, Path] = {}
"""Measured files that were transferred to this machine with the jobs, by digest."""
COLUMN = re.compile(r"\s*([A-Za-z]\w*)\s*(?:\[([^\]]*)\])?\s*")
"""Header of a column: its name, and its unit in brackets."""


class ScanError(UserError, ValueError):
    """Error in a measured file. message: its cause; hint: its remedy, or None."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.message, self.hint = message, hint
        super().__init__(message + (f" ({hint})" if hint else ""))


class Wording(NamedTuple):
    """Words for messages on a file format.

    columns: name of its columns; example: valid columns; unit: hint on the unit of the column `{}`.
    """

    columns: str
    example: str
    unit: str


CSV_WORDING = Wording("columns", "the first line is `s [mm],z [mm],depth [um]`", "write `{} [um]`, or mm, m, nm")
HDF5_WORDING = Wording(
    "datasets",
    "`s` (n_s,), `z` (n_z,) and `depth` (n_z, n_s), each with the attribute `units`",
    "give `{}` the attribute `units`: um, or mm, m, nm",
)
HDF5_HINT = "write `s`, `z` and `depth` as floating-point numbers into the file itself, with gzip or uncompressed"


class Grid(NamedTuple):
    """Depth map: ascending positions s (n_s,) and z (n_z,), and depth (n_z, n_s), in m; NaN for missing cells.

    notes: repairs that were made.
    """

    s: np.ndarray
    z: np.ndarray
    depth: np.ndarray
    notes: tuple[str, ...]


def read_file(path: Path) -> tuple[Grid, str]:
    """Return the depth map in a file and the digest of its content. Raises ScanError for an invalid file."""
    check_exists(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise ScanError(f"expected a file that ends in .csv, .txt, .h5 or .hdf5, got `{path.name}`")
    content = read_content(path)
    try:
        return reader(path.name, content), digest_of(content)
    except MemoryError:
        raise ScanError(f"`{path.name}` needs more memory than is available", "use fewer points") from None


def check_exists(path: Path) -> None:
    """Raise ScanError unless there is a file at ``path``."""
    if isdir(path):
        raise ScanError(f"`{path}` is a folder", "name the file in it")
    if not isfile(path):
        raise ScanError(f"no file `{path}`", "a path is relative to the working folder, or else to the study")


def read_content(path: Path) -> bytes:
    """Return the content of a file. Raises ScanError if it cannot be read or exceeds ``MAX_BYTES``."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ScanError(f"`{path.name}` has more than {MAX_BYTES / 1e6:.0f} MB", "use fewer points")
        return path.read_bytes()
    except OSError as error:
        raise ScanError(f"`{path.name}` cannot be read: {error.strerror}") from None
    except MemoryError:
        raise ScanError(f"`{path.name}` needs more memory than is available", "use fewer points") from None


def digest_of(content: bytes) -> str:
    """Return 16 hex digits that identify the content of a file."""
    return hashlib.sha256(content).hexdigest()[:16]


# CSV


def _read_csv(name: str, content: bytes) -> Grid:
    """Parse a CSV file, which contains a list of points or a grid."""
    rows, numbers = split_rows(name, content)
    if "|" in rows[0][0]:
        return _ascending_grid(*_parse_grid(rows, numbers))
    return _arrange_points(rows, numbers)


def split_rows(name: str, content: bytes) -> tuple[list[list[str]], list[int]]:
    """Split a CSV file into rows of cells, without comments; return them and their line numbers.

    Raises ScanError for a file that is too large, is not text, has no points or another separator.
    """
    if content.count(b",") + content.count(b"\n") > 2 * MAX_POINTS:  # before parsing; includes comments
        raise ScanError(f"`{name}` has more than {MAX_POINTS} cells", "use fewer points")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ScanError(f"`{name}` is not a text file in UTF-8", "save it as UTF-8") from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    if len(lines) < 2:
        raise ScanError("no points in this file")
    try:
        rows = list(csv.reader(line for _, line in lines))
    except csv.Error:
        raise ScanError(
            f"`{name}` has a quotation mark that is not closed", "write numbers without quotes"
        ) from None
    _check_separator(rows[0][0])
    return rows, [n for n, _ in lines]


def _check_separator(line: str) -> None:
    """Reject semicolons and tabs, which spreadsheets write in locales with a decimal comma."""
    for separator, name in ((";", "`;`"), ("\t", "a tab")):
        if separator in line.strip():
            raise ScanError(f"the separator is {name}", "use a comma, and a point for decimals")


def quote(text: str, limit: int = MAX_QUOTE) -> str:
    """Quote a text, abbreviated to ``limit`` characters."""
    stripped = text.strip()
    return f"`{stripped}`" if len(stripped) <= limit else f"`{stripped[: limit - 3]}...`"


def column_matches(headers: Sequence[str], names: Sequence[str]) -> dict[str, tuple[int, str | None]]:
    """Return the index and the unit of each column with one of the names. Raises ScanError for two of one name."""
    columns: dict[str, tuple[int, str | None]] = {}
    for number, match in enumerate(map(COLUMN.fullmatch, headers)):
        if match and match[1] in names:
            if match[1] in columns:
                raise ScanError(f"two columns are named `{match[1]}`", "rename or remove one of them")
            columns[match[1]] = (number, match[2])
    return columns


def unused_columns(headers: Sequence[str], used: Collection[int]) -> list[str]:
    """Return a note on the columns that are not used and have a header; an empty list if there are none."""
    unused = [header.strip() for number, header in enumerate(headers) if number not in used and header.strip()]
    return [f"columns not used: {', '.join(unused)}"] if unused else []


def _find_columns(headers: Sequence[str], wording: Wording) -> dict[str, tuple[int, float]]:
    """Return the index of each recognised column and its factor to SI, by name.

    Raises ScanError if a column or its unit is missing.
    """
    matches = column_matches(headers, COLUMN_NAMES)
    columns = {name: (number, _factor_to_si(name, unit, wording)) for name, (number, unit) in matches.items()}
    missing = [name for name in ("s", "z") if name not in columns]
    if missing or ("depth" in columns) == ("height" in columns):
        required = "`s`, `z` and either `depth` or `height`"
        first_headers = headers[:6]
        limit = max(MAX_QUOTE // max(len(first_headers), 1), MIN_QUOTE)
        listing = ", ".join(quote(header, limit) for header in first_headers) or "none"
        raise ScanError(f"expected {wording.columns} {required}, got {listing}", wording.example)
    return columns


def _factor_to_si(name: str, unit: str | None, wording: Wording) -> float:
    """Return the factor from a unit to m, which is negative for heights because grids contain depths."""
    if not unit:
        raise ScanError(f"the unit of `{name}` is missing", wording.unit.format(name))
    try:
        metres = parse(f"1 {unit}", "length")
    except UnitError as error:
        raise ScanError(f"`{name} [{unit}]` has no unit of length", error.hint) from None
    return -metres if name == "height" else metres


def _arrange_points(rows: list[list[str]], numbers: list[int]) -> Grid:
    """Arrange a list of points as a grid."""
    columns = _find_columns(rows[0], CSV_WORDING)
    table = cell_values(rows[1:], numbers[1:], len(rows[0]))
    values = {name: table[:, number] * factor for name, (number, factor) in columns.items()}
    depths = values.get("depth", values.get("height"))  # `_factor_to_si` converts heights to depths
    s, column = np.unique(values["s"], return_inverse=True)
    z, row = np.unique(values["z"], return_inverse=True)
    if np.isnan(s).any() or np.isnan(z).any():
        raise ScanError("a point has no coordinates", "`s` and `z` must be in every line")
    if len(table) < MIN_FILLED_FRACTION * len(s) * len(z):
        counts = f"{len(table)} points at {len(s)} values of s and {len(z)} of z"
        raise ScanError(f"the points do not form a grid: {counts}", "interpolate them onto one")
    if len(np.unique(row * len(s) + column)) < len(table):
        raise ScanError("two points have the same coordinates")
    depth = np.full((len(z), len(s)), np.nan)
    depth[row, column] = depths
    notes = [f"{name} is decreasing and was sorted" for name in ("s", "z") if _is_descending(values[name])]
    notes += unused_columns(rows[0], {number for number, _ in columns.values()})
    return Grid(s, z, depth, tuple(notes))


def _is_descending(values: np.ndarray) -> bool:
    """Check if the coordinates of a list of points are mostly in descending order."""
    steps = np.diff(values)
    return bool(np.count_nonzero(steps < 0.0) > np.count_nonzero(steps > 0.0)) if values[0] > values[-1] else False


def _parse_grid(rows: list[list[str]], numbers: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return s (n_s,), z (n_z,) and depth (n_z, n_s), m, of a grid, whose rows may be along s or along z."""
    headers = rows[0][0].split("|")
    columns = _find_columns(headers, CSV_WORDING)
    order = [name for name, _ in sorted(columns.items(), key=lambda item: item[1][0])]
    if len(headers) != 3 or order[0] not in ("depth", "height"):
        raise ScanError(f"expected a first cell such as `depth [um] | z [mm] | s [mm]`, got {quote(rows[0][0])}")
    table = cell_values([["", *rows[0][1:]], *rows[1:]], numbers, len(rows[0]))
    row_axis, column_axis = table[1:, 0] * columns[order[1]][1], table[0, 1:] * columns[order[2]][1]
    depth = table[1:, 1:] * columns[order[0]][1]
    return (column_axis, row_axis, depth) if order[2] == "s" else (row_axis, column_axis, depth.T)


def cell_values(rows: list[list[str]], numbers: list[int], width: int) -> np.ndarray:
    """Convert rows of cells to numbers (n, width); empty cells become NaN.

    numbers: line numbers of the rows, for messages. Raises ScanError for too many cells, a row of another width,
    or a cell that is not a finite number.
    """
    if len(rows) * width > MAX_POINTS:
        raise ScanError(f"{len(rows) * width} cells; at most {MAX_POINTS}", "use fewer points")
    table = np.full((len(rows), width), np.nan)
    for target, row, number in zip(table, rows, numbers, strict=True):
        if len(row) != width:
            hint = "cells end with a comma, numbers have a decimal point"
            raise ScanError(f"line {number}: {len(row)} cells, the first line has {width}", hint)
        target[:] = [_parse_number(cell, number) for cell in row]
    return table


def _parse_number(cell: str, line: int) -> float:
    try:
        value = float(cell) if cell.strip() else math.nan
    except ValueError:
        hint = "use a point for decimals" if "," in cell else None
        raise ScanError(f"line {line}: expected a number, got {quote(cell)}", hint) from None
    if math.isinf(value):
        raise ScanError(f"line {line}: `{cell.strip()}` is not finite", "leave a missing cell empty")
    return value


# HDF5


def _read_hdf5(name: str, content: bytes) -> Grid:
    """Parse an HDF5 file; infinite depths count as missing."""
    from bearingsim.hdf5 import Hdf5, Unsafe

    try:
        with Hdf5(io.BytesIO(content), MAX_POINTS * POINT_BYTES) as file:
            names = [dataset for dataset in COLUMN_NAMES if dataset in file]
            headers = [f"{dataset} [{file.attribute('units', dataset, '', variable=True)}]" for dataset in names]
            columns = _find_columns(headers or file.names(), HDF5_WORDING)
            _check_shapes({dataset: file.shape(dataset) for dataset in names})
            values = {dataset: file.numbers(dataset).astype(float) * columns[dataset][1] for dataset in names}
    except Unsafe as error:
        raise ScanError(str(error), HDF5_HINT) from None
    except (OSError, RuntimeError, KeyError):
        raise ScanError(f"`{name}` is not an HDF5 file, or truncated") from None
    depth = values["depth" if "depth" in values else "height"]  # `_factor_to_si` converts heights to depths
    depth[np.isinf(depth)] = np.nan
    return _ascending_grid(values["s"], values["z"], depth)


def _check_shapes(shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Raise ScanError for datasets of inconsistent shape, or with too many points."""
    s, z, depth = shapes["s"], shapes["z"], shapes["depth" if "depth" in shapes else "height"]
    if len(s) != 1 or len(z) != 1 or depth != (*z, *s):
        raise ScanError(f"expected s (n_s,), z (n_z,) and depth (n_z, n_s), got s {s}, z {z}, depth {depth}")
    if math.prod(depth) > MAX_POINTS:
        raise ScanError(f"{math.prod(depth)} points; at most {MAX_POINTS}", "use fewer points")


def _ascending_grid(s: np.ndarray, z: np.ndarray, depth: np.ndarray) -> Grid:
    """Build a depth map, with descending axes reversed. Raises ScanError for axes that are not monotonic."""
    notes: list[str] = []
    for name, axis in (("s", s), ("z", z)):
        _check_axis(name, axis)
        if axis[0] > axis[-1]:
            notes.append(f"{name} is decreasing and was reversed")
    if s[0] > s[-1]:
        s, depth = s[::-1], depth[:, ::-1]
    if z[0] > z[-1]:
        z, depth = z[::-1], depth[::-1]
    return Grid(s, z, depth, tuple(notes))


def _check_axis(name: str, axis: np.ndarray) -> None:
    """Raise ScanError unless the coordinates of an axis are complete and strictly monotonic."""
    steps = np.diff(axis)
    if len(axis) == 0:
        raise ScanError("no points in this file")
    if not np.isfinite(axis).all():
        raise ScanError(f"a value of {name} is missing or infinite")
    if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        k = int(np.flatnonzero(steps * np.sign(axis[-1] - axis[0]) <= 0.0)[0]) + 1
        raise ScanError(f"{name} is not monotonic between values {k} and {k + 1}")


READERS: dict[str, Callable[[str, bytes], Grid]] = {
    ".csv": _read_csv,
    ".txt": _read_csv,
    ".h5": _read_hdf5,
    ".hdf5": _read_hdf5,
}
"""Readers of file contents, by suffix."""


def format_positions(cells: Iterable[tuple[int, int]], grid: Grid) -> str:
    """Format the positions of the first three of some cells (row, column)."""
    indices = list(cells)
    texts = [f"s = {format_mm(grid.s[j])}, z = {format_mm(grid.z[i])}" for i, j in indices[:3]]
    return "; ".join(texts) + ("; ..." if len(indices) > 3 else "")


def format_mm(metres: float) -> str:
    """Format a position in mm; values that are zero except for rounding errors become zero."""
    return f"{round(1e3 * float(metres), 9) + 0.0:.4g} mm"
