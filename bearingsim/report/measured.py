"""Table of measured features and the simulated ones at the same parameters."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.plots import labels
from bearingsim.store.measured import difference, gives_factor
from bearingsim.study.measured_values import listed
from bearingsim.text.numbers import significant

if TYPE_CHECKING:
    from bearingsim.store import MeasuredSet, Results

DIFFERENCE, RATIO = "simulated\n- measured", "simulated\n/ measured"
"""Headings of the difference and of the ratio of two values, also in `compare`."""
HEADERS = ("feature", "source", "parameters", "unit", "measured", "simulated", DIFFERENCE, RATIO, "job")
TEXT_COLUMNS = 4
MAX_ROWS = 1000
"""Largest number of rows of a table on a page."""
BETWEEN = "between"
"""Cell of a simulated value that is interpolated between two cases."""


class MeasuredTable(NamedTuple):
    """Comparison of one source: its title, rows of cells, and remarks."""

    title: str
    rows: list[list[str]]
    remarks: list[str]
    headers: tuple[str, ...] = HEADERS
    numeric: tuple[int, ...] = (4, 5, 6, 7)


def make_measured_tables(results: "Results", max_rows: int = MAX_ROWS) -> list[MeasuredTable]:
    """Return a table for each measured source of a study, of at most ``max_rows`` rows."""
    return [_table(results, entry, max_rows) for entry in results.measured]


def _table(results: "Results", entry: "MeasuredSet", max_rows: int) -> MeasuredTable:
    units = results.plan["units"]
    rows = []
    for item in entry.comparisons[:max_rows]:
        measured = entry.scaled(item.feature, item.measured)
        unit, factor = labels.feature_axis(item.feature, max(abs(measured), abs(item.simulated)))
        change = difference(item.feature, item.simulated, measured)
        values = measured * factor, item.simulated * factor, change * factor
        has_ratio = measured != 0.0 and not item.feature.endswith(".phase")
        ratio = item.simulated / measured if has_ratio else math.nan
        parameters = labels.swept_text({**item.parameters, **item.others}, units)
        numbers = [significant(value, 4) if math.isfinite(value) else "-" for value in (*values, ratio)]
        rows.append([item.feature, item.place, parameters, unit, *numbers, item.job[:8] or BETWEEN])
    return MeasuredTable(_title(entry), rows, _remarks(entry, max_rows))


def _title(entry: "MeasuredSet") -> str:
    scaled = "" if entry.factor == 1.0 else f", measured values times {entry.factor:.4g}, the median of the ratios"
    return f"measured: {entry.label}{scaled}"


def _remarks(entry: "MeasuredSet", max_rows: int) -> list[str]:
    between = any(not item.job for item in entry.comparisons)
    more = len(entry.comparisons) - max_rows
    return [
        *([f"and {more} more rows: `bearingsim show --measured --json` prints all"] if more > 0 else []),
        *([f"{BETWEEN}: interpolated linearly between two cases"] if between else []),
        *entry.remarks,
        *_unmatched(entry),
        *([] if entry.points else ["no point is at the fixed values of the study: `bearingsim check` names them"]),
        *(["`scale: true` without effect: no ratio to a simulated motion"] if _lacks_factor(entry) else []),
    ]


def _lacks_factor(entry: "MeasuredSet") -> bool:
    return entry.is_scaled and not any(map(gives_factor, entry.comparisons))


def _key(location: str, parameters: Mapping[str, float | str]) -> str:
    return f"{location} {sorted(parameters.items())}"  # a study may name a file of signals at several positions


def _unmatched(entry: "MeasuredSet") -> list[str]:
    """Return remarks on measured values without a simulated one: features that the jobs lack, and other points."""
    compared: dict[str, set[str]] = {}
    for item in entry.comparisons:
        compared.setdefault(_key(item.place, item.parameters), set()).add(item.feature)
    features = [compared.get(_key(point["place"], point["parameters"]), set()) for point in entry.points]
    pairs = list(zip(entry.points, features, strict=True))
    lacking = list(
        dict.fromkeys(name for point, names in pairs if names for name in point["features"] if name not in names)
    )
    positions = list(dict.fromkeys(point["place"] for point, names in pairs if not names))
    return [
        *([f"without a simulated value: {listed(lacking)}"] if lacking else []),
        *([f"no finished case is at {listed(positions)}, or on both sides in one parameter"] if positions else []),
    ]
