"""Numerical errors of features: step, scatter of chaotic responses, and initial transient."""

from collections.abc import Iterator, Sequence
from math import inf, nan
from typing import TYPE_CHECKING

from bearingsim.config.names import STEP_ACCURACY
from bearingsim.plots import labels
from bearingsim.store import feature_bounds, relative_error
from bearingsim.store.nearness import scales
from bearingsim.store.spread import reference_ratio
from bearingsim.text.numbers import percent

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

STEP_ERRORS = {
    "velocity.rms": "rms",
    "velocity@": "line",
    "outer_force.max": "force",
    "acceleration.rms": "record",
}
"""Column ``step_error.*`` that bounds the step error of a feature, by the beginning of its name."""
START_ERRORS = {"line": "error.start", "rms": "error.start.rms", "force": "error.start.force"}
"""Column with the relative error of the initial transient, by the kind of step error."""
STANDARD_ERRORS = 2.0  # standard errors in the error bound of a chaotic response, for about 95 % confidence
SMALLEST_VALUE = 1e-3
"""Smallest value, relative to the largest, whose error is reported; smaller errors are within a curve's width."""


def with_errors(results: "Results", rows: "pd.DataFrame", features: Sequence[str]) -> "pd.DataFrame":
    """Add columns ``error NAME`` (SI), the error bounds of the features that the `accuracy` of the study covers.

    They are relative to the curves of the study, which may be longer than those of the figure.
    """
    if results.plan.get("accuracy") is None:
        return rows
    bounds = feature_bounds(results.plan, results.frame).replace(inf, nan)
    columns = {
        f"error {name}": bounds[name] * scales(results.plan, results.frame, name)
        for name in features
        if name in bounds and results.has_feature(name)
    }
    return rows.assign(**{name: column.reindex(rows["job"]).to_numpy() for name, column in columns.items()})


def numerical_errors(results: "Results", rows: "pd.DataFrame", name: str) -> "pd.Series[float] | None":
    """Return the numerical error (SI) of a feature by row: step error plus two standard errors if chaotic.

    It is infinite if the standard error is unknown. None for a feature not covered by the step check, which covers
    lines and RMS of the velocity, the largest force, and the RMS of recorded channels.
    """
    base, kind = _base_and_kind(name)
    step = rows.get(f"step_error.{kind}")
    if kind == "record" and not _is_recorded(results, base.partition(".")[0]):
        return None
    if step is None or base not in rows or not step.notna().any():
        return None
    scatter = relative_error(rows, base).where(rows["chaotic"] == 1.0, 0.0).fillna(inf)
    step = step * reference_ratio(rows.add_prefix("features/"), base)
    return (step + STANDARD_ERRORS * scatter) * rows[base].abs()


def error_texts(results: "Results", rows: "pd.DataFrame", names: Sequence[str]) -> Iterator[str]:
    """Yield the errors of features that exceed 1 % of a value, for the caption of a figure of these rows.

    Features with error bars, which are those in the columns of ``with_errors``, are omitted.
    """
    for name in (name for name in names if f"error {name}" not in rows):
        numerical, start = numerical_errors(results, rows, name), _start_errors(results, rows, name)
        for text, error in (("numerical error", numerical), ("start error", start)):
            if error is not None and (share := _largest_shares(error, rows[name].abs())) is not None:
                of_value, of_largest = map(percent, share)
                feature = labels.in_sentence(labels.feature_text(name))
                unknown = int((~(error < inf) & rows[name].notna()).sum())
                exception = f", unknown in {unknown} of {len(rows)}" if unknown else ""
                shares = f"up to {of_value} of its value ({of_largest} of the largest)"
                yield f"{text} of the {feature} {shares}{exception}"


def _largest_shares(error: "pd.Series[float]", values: "pd.Series[float]") -> tuple[float, float] | None:
    """Return the largest error relative to its value and to the largest value; None if all are within 1 %.

    error, values: by row, in SI.
    """
    largest = float(values.max())
    is_drawn = (values > SMALLEST_VALUE * largest) & (error < inf)
    shares = (error / values)[is_drawn]
    if not (shares > STEP_ACCURACY).any():
        return None
    return float(shares.max()), float(error[is_drawn].max() / largest)


def _start_errors(results: "Results", rows: "pd.DataFrame", name: str) -> "pd.Series[float] | None":
    """Return the error (SI) of the initial transient of a feature by row; None if it is not estimated.

    It is 0 for jobs with random scatter, because the parts of their records also differ by chance, which the
    standard error contains.
    """
    base, kind = _base_and_kind(name)
    if kind not in START_ERRORS or base not in rows:
        return None
    start = results.values(START_ERRORS[kind]).reindex(rows["job"]).set_axis(rows.index)
    is_random = rows.filter(items=["standard_error.line", "cage.slip.mean"]).notna().any(axis=1)
    start = start.where(~is_random, 0.0) * reference_ratio(rows.add_prefix("features/"), base)
    return start * rows[base].abs()


def _base_and_kind(name: str) -> tuple[str, str]:
    """Return a feature without the suffix `-healthy`, and the kind of its step error, "" without one."""
    base = name.removesuffix("-healthy")
    return base, next((kind for start, kind in STEP_ERRORS.items() if base.startswith(start)), "")


def _is_recorded(results: "Results", quantity: str) -> bool:
    """Check if all jobs of a study record a quantity of the outer ring or of the sensor."""
    channels = [set(str(text).replace(",", " ").split()) for text in results.parameters()["record"]]
    return bool(channels) and all({f"ring.{quantity}", f"sensor.{quantity}"} & names for names in channels)
