"""Columns of a table of results: which are shown, and their cells as text."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from bearingsim.text.numbers import significant

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

Column = tuple[str, list[str]]  # heading and cells
STATISTICS = ("velocity.rms", "outer_force.max")
STEP_CHECK = ("step_error.line", "step_error.rms", "step_error.record", "chaotic")


def main_features(results: "Results", table: "pd.DataFrame") -> list[str]:
    """List the features with a value that the figures of the study name, else the default ones without errors."""
    from bearingsim.study import plotted_features

    features = with_values(plotted_features(results.plan), table)
    return features or [name for name in default_features(results, table) if not name.startswith("error.")]


def default_features(results: "Results", table: "pd.DataFrame") -> list[str]:
    """List the default columns that have a value.

    Defect line, cage slip of models with slip, change from healthy, bands, statistics, errors.
    """
    from bearingsim.config.names import read_band
    from bearingsim.plots import lines

    parameters = results.parameters()
    line_columns = [f"velocity@{line}" for line in lines.fundamental_lines(parameters)]
    slip_columns = ["cage.slip.mean"] if lines.may_slip(parameters) else []
    errors = [name for name in map(str, table) if name.startswith("error.")]
    band_columns = [name for name in map(str, table) if read_band(name) is not None]
    changes = [f"{line}-healthy" for line in line_columns]
    candidates = [*line_columns, *slip_columns, *changes, *band_columns, *STATISTICS, *errors, *STEP_CHECK]
    return [name for name in with_values(candidates, table) if name != "chaotic" or (table[name] > 0.0).any()]


def error_columns(results: "Results", table: "pd.DataFrame") -> list[str]:
    """List the error columns with a value, the total first; none for a study without an accuracy."""
    if not results.plan.get("accuracy"):
        return []
    return with_values(["error", *(name for name in map(str, table) if name.startswith("error."))], table)


def with_values(names: Iterable[str], table: "pd.DataFrame") -> list[str]:
    """List the names of the columns of ``table`` that have a value."""
    return [name for name in names if name in table and table[name].notna().any()]


def column_of(results: "Results", rows: "pd.DataFrame", name: str) -> Column:
    """Return heading and cells of a column, in the study's unit or a readable one."""
    from bearingsim.plots import labels

    units = results.plan["units"]
    if name in units:
        return name, ["" if _is_nan(v) else labels.value_text(name, v, units) for v in rows[name]]
    if name == "status":
        return name, status_texts(rows)
    if rows[name].dtype.kind != "f":
        return name, [str(value) for value in rows[name]]
    largest = rows[name].abs().max()
    unit, factor = labels.feature_axis(name, float(largest)) if name != "seconds" else ("s", 1.0)
    cells = [significant(value * factor, 4) for value in rows[name]]
    return f"{name} ({unit})" if unit else name, cells


def status_texts(rows: "pd.DataFrame") -> list[str]:
    """Return the status of each job of a table; for a chaotic one `done, chaotic`."""
    is_chaotic = rows["chaotic"] == 1.0 if "chaotic" in rows else [False] * len(rows)
    return [
        status + ", chaotic" * bool(chaotic) for status, chaotic in zip(rows["status"], is_chaotic, strict=True)
    ]


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)
