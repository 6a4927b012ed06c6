"""Measured roundness profiles of races: reading, checks and repairs, and their harmonics.

A CSV file (.csv or .txt) has one point per line, and columns named with their units:

    angle [deg],deviation [um]
    0.0,0.12
    0.5,0.10

`deviation` is positive where there is more material than on the nominal surface. `radius` may replace it: it is
positive away from the axis and may contain any constant. Lines that begin with # are comments.
"""

from collections.abc import Iterable
from functools import lru_cache
from math import degrees, pi
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.config.scan.file import (
    MAX_QUOTE,
    ScanError,
    cell_values,
    check_exists,
    column_matches,
    digest_of,
    quote,
    read_content,
    split_rows,
    unused_columns,
)
from bearingsim.text.units import UnitError, parse

DEVIATION, RADIUS = "deviation", "radius"
POINTS_PER_UNDULATION = 7
"""Minimum number of points per shortest undulation."""
MAX_GAP = 0.5  # longest gap, in lengths of the shortest undulation
MIN_POINTS = 2 * POINTS_PER_UNDULATION
MAX_MISSING, MAX_SPIKES = 0.05, 0.01  # largest fractions of missing values and of spikes
SPIKE_WINDOW = 5  # points of the running median with which the values are compared
MIN_SPIKE = 8.0  # minimum height of a spike above the running median, in standard deviations
MIN_SPIKE_HEIGHT = 0.2  # minimum height of a spike, relative to the range of the profile
MAX_JUMP = 0.1  # largest jump between the ends of a revolution, relative to the range of the profile
MAX_JUMP_STEPS = 3.0  # largest jump between the ends, relative to the largest step between neighbours
MIN_ECCENTRICITY = 1e-9  # m; smaller ones are not reported
ANGLE_TOLERANCE = 1e-6  # rad; angles that differ by less count as equal
SPACING_TOLERANCE = 1e-3  # tolerance of even spacing, relative to the spacing
ROUNDING = 0.05  # largest deviation of printed angles from a revolution, relative to the spacing
EXAMPLE = "the first line is `angle [deg],deviation [um]`"
CACHED_PROFILES = 64


class Profile(NamedTuple):
    """Measured profile: values (n,), m, at ascending angles (n,), rad, within one revolution.

    column: meaning of the values, ``DEVIATION`` or ``RADIUS``; digest: of the content of its file; notes: repairs.
    """

    angles: np.ndarray
    values: np.ndarray
    column: str
    digest: str
    notes: tuple[str, ...]


def read_roundness(path: str | Path) -> Profile:
    """Read and repair the profile in a file. Raises ScanError for an invalid format or unusable data."""
    file = Path(path)
    check_exists(file)
    stat = file.stat()
    return _read(file.absolute(), stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=CACHED_PROFILES)
def _read(path: Path, modified: int, size: int) -> Profile:
    if path.suffix.lower() not in (".csv", ".txt"):
        raise ScanError(f"expected a file that ends in .csv or .txt, got `{path.name}`")
    content = read_content(path)
    profile = _parse_table(*split_rows(path.name, content))._replace(digest=digest_of(content))
    for repair in (_remove_missing, _arrange_revolution, _remove_spikes):
        profile = repair(profile)
    return profile


def _parse_table(rows: list[list[str]], numbers: list[int]) -> Profile:
    """Convert the rows of a file, with their line numbers, to a profile without digest and repairs."""
    columns = _find_columns(rows[0])
    table = cell_values(rows[1:], numbers[1:], len(rows[0]))
    column = DEVIATION if DEVIATION in columns else RADIUS
    angles, values = (table[:, number] * factor for number, factor in (columns["angle"], columns[column]))
    notes = unused_columns(rows[0], {number for number, _ in columns.values()})
    if np.isnan(angles).any():
        line = numbers[1 + int(np.flatnonzero(np.isnan(angles))[0])]
        raise ScanError(f"line {line}: a point has no angle", "`angle` must be in every line")
    return Profile(angles, values, column, "", tuple(notes))


def _find_columns(headers: list[str]) -> dict[str, tuple[int, float]]:
    """Return the index of each recognised column and its factor to SI, by name.

    Raises ScanError if a column or its unit is missing.
    """
    matches = column_matches(headers, ("angle", DEVIATION, RADIUS))
    columns = {name: (number, _factor_to_si(name, unit)) for name, (number, unit) in matches.items()}
    if "angle" not in columns or (DEVIATION in columns) == (RADIUS in columns):
        listing = ", ".join(quote(header, MAX_QUOTE // 3) for header in headers[:3])
        raise ScanError(f"expected columns `angle` and either `deviation` or `radius`, got {listing}", EXAMPLE)
    return columns


def _factor_to_si(name: str, unit: str | None) -> float:
    """Return the factor from a unit to rad for an angle, else to m."""
    is_angle = name == "angle"
    if not unit:
        units = "`angle [deg]`, or rad" if is_angle else f"`{name} [um]`, or mm, m, nm"
        raise ScanError(f"the unit of `{name}` is missing", f"write {units}")
    try:
        return parse(f"1 {unit}", "angle" if is_angle else "length")
    except UnitError as error:
        raise ScanError(
            f"`{name} [{unit}]` has no unit of {'angle' if is_angle else 'length'}", error.hint
        ) from None


def _remove_missing(profile: Profile) -> Profile:
    """Remove points without a value; ``harmonics`` interpolates the gaps. Raises ScanError for too many."""
    missing = np.isnan(profile.values)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return profile
    angles = _format_angles(profile.angles[missing])
    if count > MAX_MISSING * len(missing):
        raise ScanError(f"{count} of {len(missing)} values are missing ({angles})", "repeat the measurement")
    note = f"{count} missing value{'s' * (count > 1)} removed: {angles}"
    present = ~missing
    return profile._replace(
        angles=profile.angles[present], values=profile.values[present], notes=(*profile.notes, note)
    )


def _arrange_revolution(profile: Profile) -> Profile:
    """Sort the points by angle, and merge the ends of the revolution if both are given.

    Raises ScanError for too few points, equal angles, equal values, more than one revolution, or a profile that
    does not close.
    """
    if len(profile.angles) < MIN_POINTS:
        raise ScanError(f"{len(profile.angles)} points: at least {MIN_POINTS} are needed")
    order, notes = np.argsort(profile.angles, kind="stable"), list(profile.notes)
    angles, values = profile.angles[order], profile.values[order]
    if np.any(np.diff(order) != 1):
        notes.append("the angles are not ascending and were sorted")
    steps = np.diff(angles)
    span, rounding = float(angles[-1] - angles[0]), max(ANGLE_TOLERANCE, ROUNDING * float(np.median(steps)))
    if span > 2.0 * pi + rounding:
        message = f"the angles cover {degrees(span):.4g} deg; a profile covers one revolution"
        raise ScanError(message, "give one revolution, and check the unit of `angle`")
    if np.any(steps < ANGLE_TOLERANCE):
        k = int(np.argmin(steps))
        raise ScanError(f"two points have the angle {degrees(angles[k]):.6g} deg", "give one value for each angle")
    if np.ptp(values) == 0.0:
        raise ScanError(
            f"all values are the same ({_format_um(values[0])})", "omit `roundness` for a round surface"
        )
    has_both_ends = span > 2.0 * pi - rounding
    notes += _closing_notes(angles, values, has_both_ends)
    if has_both_ends:
        values = np.append(0.5 * (values[0] + values[-1]), values[1:-1])
        angles = angles[:-1]
    return profile._replace(angles=angles, values=values, notes=tuple(notes))


def _closing_notes(angles: np.ndarray, values: np.ndarray, has_both_ends: bool) -> list[str]:
    """Return a note if both ends of the revolution are given and differ.

    Raises ScanError if the values at the ends differ much more than those of neighbours.
    """
    value_range, jump = float(np.ptp(values)), abs(float(values[0] - values[-1]))
    gap, spacing = angles[0] + 2.0 * pi - angles[-1], float(np.median(np.diff(angles)))
    step = float(np.max(np.abs(np.diff(values)))) * max(1.0, gap / spacing)
    if jump > MAX_JUMP * value_range and jump > MAX_JUMP_STEPS * step and gap < pi:
        ends = f"{degrees(angles[0]):.4g} and {degrees(angles[-1]):.4g} deg"
        raise ScanError(
            f"the profile does not close: it differs by {_format_um(jump)} between {ends}",
            "remove the drift first",
        )
    if has_both_ends and jump > 1e-3 * value_range:
        return [f"the values at both ends of the revolution differ by {_format_um(jump)}; their mean is used"]
    return []


def _remove_spikes(profile: Profile) -> Profile:
    """Remove spikes of one or two points; ``harmonics`` interpolates the gaps. Raises ScanError for too many."""
    values = profile.values
    shifts = range(-(SPIKE_WINDOW // 2), SPIKE_WINDOW // 2 + 1)
    deviations = values - np.median([np.roll(values, shift) for shift in shifts], axis=0)
    low, high = np.percentile(values, [1.0, 99.0])
    standard_deviation = 1.4826 * float(np.median(np.abs(deviations)))  # robust estimate
    spikes = np.abs(deviations) > max(MIN_SPIKE * standard_deviation, MIN_SPIKE_HEIGHT * float(high - low))
    count = int(np.count_nonzero(spikes))
    if count == 0:
        return profile
    angles, size = (
        _format_angles(profile.angles[spikes]),
        f"{_format_um(np.abs(deviations[spikes]).min())} or more",
    )
    if count > MAX_SPIKES * len(values):
        raise ScanError(f"{count} spikes of {size} ({angles})", "filter the profile first")
    note = f"{count} spike{'s' * (count > 1)} of {size} removed: {angles}"
    return profile._replace(angles=profile.angles[~spikes], values=values[~spikes], notes=(*profile.notes, note))


def check_resolution(profile: Profile, orders: tuple[int, int]) -> None:
    """Raise ScanError if a profile has too few points, or too wide a gap, for the highest of the ``orders``."""
    low, high = orders
    count = len(profile.angles)
    if count < POINTS_PER_UNDULATION * high:
        possible = count // POINTS_PER_UNDULATION
        hint = f"`orders: [{low}, {possible}]`, or more points" if possible >= low else "measure more points"
        message = f"{count} points are too few for order {high}, which needs {POINTS_PER_UNDULATION * high}"
        raise ScanError(f"{message} ({POINTS_PER_UNDULATION} per undulation)", hint)
    gaps = np.diff(profile.angles, append=profile.angles[0] + 2.0 * pi)
    k = int(np.argmax(gaps))
    if gaps[k] > MAX_GAP * 2.0 * pi / high:
        possible = int(MAX_GAP * 2.0 * pi / gaps[k])
        message = f"a gap of {degrees(gaps[k]):.3g} deg from {degrees(profile.angles[k]):.4g} deg"
        hint = (
            f"`orders: [{low}, {possible}]`, or measure a full revolution"
            if possible >= low
            else "measure a full revolution"
        )
        raise ScanError(f"{message} is over half an undulation of order {high}", hint)


def harmonics(profile: Profile, highest: int, on_outer: bool) -> np.ndarray:
    """Return the complex amplitudes C_n (highest + 1,), m, of the heights Re sum C_n exp(i n angle).

    Heights are positive where there is material. Unevenly spaced values are first interpolated by a periodic cubic
    spline. Orders 0 and 1 are then those of the least-squares circle (ISO 12181-1) in linear approximation.
    """
    angles, values = profile.angles, profile.values
    count, start = len(angles), float(angles[0])
    spacing = 2.0 * pi / count
    gaps = np.diff(angles, append=start + 2.0 * pi)
    if np.max(np.abs(gaps - spacing)) > SPACING_TOLERANCE * spacing:
        from scipy.interpolate import CubicSpline

        ends = np.append(angles, start + 2.0 * pi), np.append(values, values[0])
        count = 2 * count
        values = CubicSpline(*ends, bc_type="periodic")(start + 2.0 * pi / count * np.arange(count))
    C = 2.0 / count * np.fft.rfft(values)[: highest + 1] * np.exp(-1j * start * np.arange(highest + 1))
    C[0] /= 2.0
    return np.asarray(-C if profile.column == RADIUS and on_outer else C)


def form_harmonics(profile: Profile, orders: tuple[int, int], on_outer: bool) -> np.ndarray:
    """Return ``harmonics`` up to the highest of the ``orders``, with zeros below the lowest."""
    low, high = orders
    C = harmonics(profile, high, on_outer)
    C[:low] = 0.0
    return C


def form_range(profile: Profile, orders: tuple[int, int]) -> float:
    """Return the peak-to-valley height (m) of the form in the given orders."""
    C = form_harmonics(profile, orders, on_outer=False)
    count = 2 * POINTS_PER_UNDULATION * orders[1]
    return float(np.ptp(np.fft.irfft(0.5 * count * C, count)))


def remarks(profile: Profile, orders: tuple[int, int]) -> tuple[str, ...]:
    """Return notes on a profile: its repairs, the height of the orders used, and the eccentricity removed."""
    eccentricity = float(abs(harmonics(profile, 1, on_outer=False)[1]))
    height = form_range(profile, orders)
    text = f"orders {orders[0]} to {orders[1]}: {_format_um(height)} from peak to valley"
    removed = (
        f"; an eccentricity of {_format_um(eccentricity)} is removed" if eccentricity > MIN_ECCENTRICITY else ""
    )
    return (*profile.notes, text + removed)


def _format_angles(angles: Iterable[float]) -> str:
    """Format the first three angles."""
    values = [float(angle) for angle in angles]
    return ", ".join(f"{degrees(angle):.4g} deg" for angle in values[:3]) + ", ..." * (len(values) > 3)


def _format_um(metres: float) -> str:
    """Format a length in um."""
    return f"{1e6 * float(metres):.3g} um"
