"""Features that are zero within numerical errors: below what rounding or the accepted error of a line explains."""

from typing import TYPE_CHECKING

from bearingsim.config import FEATURES
from bearingsim.config.names import QUANTITIES, QUIET_LINE, STEP_ACCURACY
from bearingsim.store.spread import is_line
from bearingsim.study.goal import HEALTHY_SUFFIX

if TYPE_CHECKING:
    import pandas as pd

UNITS = (*QUANTITIES.values(), "N")
EXTREME_RATIO = 3.0  # largest value of a motion within rounding, relative to the bound of its RMS
EQUALITY_TOLERANCE = 1e-7
"""Relative difference up to which two values are equal: that of the passes of a periodic record."""


def zero_bounds(rows: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return by row the value (SI) up to which a feature is zero within numerical errors; NaN without a bound.

    It is the motion that rounding alone can produce (columns such as `velocity.rounding`). For a line it is also
    ``STEP_ACCURACY`` of ``QUIET_LINE`` of the RMS, the error that the step check accepts in a quiet line. A line
    of displacement or acceleration is zero if that of the velocity is. For a change from healthy it is also
    ``EQUALITY_TOLERANCE`` of the value.
    """
    import pandas as pd

    base = feature.removesuffix(HEALTHY_SUFFIX)
    bounds = pd.Series(0.0, rows.index)
    unit = FEATURES[feature].unit if feature in FEATURES else ""
    if unit not in UNITS or base.endswith(("-scatter", ".rounding")):
        return bounds * float("nan")
    quantity, _, line = base.partition("@")
    quantity, velocity_line = quantity.partition(".")[0], f"velocity@{line}"
    ratio: pd.Series[float] | float = 1.0
    if is_line(base) and {base, velocity_line}.issubset(rows):
        quantity, ratio = "velocity", rows[base] / rows[velocity_line]
    if f"{quantity}.rounding" in rows:
        bounds += rows[f"{quantity}.rounding"].fillna(0.0) * (EXTREME_RATIO if base.endswith(".peak") else 1.0)
    if is_line(base) and f"{quantity}.rms" in rows:
        bounds += STEP_ACCURACY * QUIET_LINE * rows[f"{quantity}.rms"].fillna(0.0)
    bounds = (ratio * bounds).fillna(0.0)
    if base != feature and base in rows:
        bounds += EQUALITY_TOLERANCE * rows[base].abs().fillna(0.0)
    return bounds


def is_zero(rows: "pd.DataFrame", feature: str) -> "pd.Series[bool]":
    """Mark the rows in which a feature is zero within numerical errors (``zero_bounds``)."""
    return rows[feature].abs() <= zero_bounds(rows, feature)


def all_zero(rows: "pd.DataFrame", feature: str) -> bool:
    """Check if all values of a feature are zero within numerical errors; False without a value."""
    has_value = rows[feature].notna()
    return bool(has_value.any() and (is_zero(rows, feature) | ~has_value).all())
