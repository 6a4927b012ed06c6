"""Numerical errors of features: step, scatter of chaotic responses, and initial transient."""

from collections.abc import Iterator, Sequence
from math import degrees, inf, nan
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.config.names import STEP_ACCURACY
from bearingsim.plots import labels
from bearingsim.store import feature_bounds, is_zero, relative_error
from bearingsim.store.nearness import scales
from bearingsim.store.spread import reference_ratio
from bearingsim.text.numbers import percent, significant

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

STEP_ERRORS = {
    "velocity.rms": "rms",
    "velocity@": "line",
    "acceleration@": "line",  # computed from that of the velocity
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


class Errors(NamedTuple):
    """Errors (SI) of a feature by row.

    step: bound of the step error, NaN if it was not checked; of a chaotic motion, the largest effect of the step
    on the RMS that its scatter hides, NaN for lines and the largest force, which no step reproduces; scatter:
    ``STANDARD_ERRORS`` standard errors of a chaotic motion, infinite if unknown, 0 for other motions.
    """

    step: "pd.Series[float]"
    scatter: "pd.Series[float]"


def numerical_errors(results: "Results", rows: "pd.DataFrame", name: str) -> Errors | None:
    """Return the numerical errors of a feature by row; 0 where it is zero within them.

    None for a feature not covered by the step check, which covers lines and RMS of the velocity, lines of the
    acceleration, the largest force, and the RMS of recorded channels.
    """
    base, kind = _base_and_kind(name)
    step, is_chaotic = rows.get(f"step_error.{kind}"), rows["chaotic"] == 1.0 if "chaotic" in rows else None
    if kind == "record" and not _is_recorded(results, base.partition(".")[0]):
        return None
    if step is None or is_chaotic is None or base not in rows or not (step.notna() | is_chaotic).any():
        return None
    frame, value = rows.add_prefix("features/"), _reference_value(rows, name)
    scatter = STANDARD_ERRORS * relative_error(rows, base).where(is_chaotic, 0.0).fillna(inf) * value
    step = (step * reference_ratio(frame, base) * value).where(~is_zero(rows, base), 0.0)
    return Errors(step, scatter)


def error_texts(results: "Results", rows: "pd.DataFrame", names: Sequence[str]) -> Iterator[str]:
    """Yield the errors of features that exceed 1 % of a value, for the caption of a figure of these rows.

    Features with error bars, in the columns of ``with_errors``, and values of zero are left out.
    """
    for name in (name for name in names if f"error {name}" not in rows):
        feature = labels.in_sentence(labels.feature_text(name))
        for text, error in _errors_by_cause(results, rows, name):
            share = _share_text(rows, name, error)
            unknown = int((~(error < inf) & rows[name].notna()).sum())
            exception = f"unknown in {unknown} of {len(rows)}" if unknown else ""
            if share:
                yield f"{text} of the {feature} {', '.join(filter(None, (share, exception)))}"
            elif (error == inf).any():
                yield f"{text} of the {feature} {exception}"


def _share_text(rows: "pd.DataFrame", name: str, error: "pd.Series[float]") -> str:
    """Describe the largest error (SI) of a feature; empty if all are within 1 %, of a phase within 0.01 rad."""
    if name.endswith(".phase"):
        largest = float(error[error < inf].max())
        return f"up to {degrees_text(largest)}" if largest > STEP_ACCURACY else ""
    value = rows[name].abs().where(~is_zero(rows, name), 0.0)
    shares = _largest_shares(error, value)
    return f"up to {percent(shares[0])} of its value ({percent(shares[1])} of the largest)" if shares else ""


def _errors_by_cause(
    results: "Results", rows: "pd.DataFrame", name: str
) -> "Iterator[tuple[str, pd.Series[float]]]":
    """Yield the cause of each error of a feature, and the error (SI) by row, 0 where it does not apply."""
    errors, start = numerical_errors(results, rows, name), _start_errors(results, rows, name)
    if errors is not None:
        is_chaotic = rows["chaotic"] == 1.0
        yield "numerical error", errors.step.where(~is_chaotic, 0.0)
        yield "statistical scatter", errors.scatter
        yield "unresolved step error", errors.step.where(is_chaotic, 0.0).fillna(0.0)
    if start is not None:
        yield "start error", start


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
    return start * _reference_value(rows, name)


def _base_and_kind(name: str) -> tuple[str, str]:
    """Return the feature of a phase or a change from healthy, and the kind of its step error, "" without one."""
    base = name.removesuffix(".phase").removesuffix("-healthy")
    return base, next((kind for start, kind in STEP_ERRORS.items() if base.startswith(start)), "")


def _reference_value(rows: "pd.DataFrame", name: str) -> "pd.Series[float]":
    """Return by row the value to which the relative errors of a feature refer, in SI.

    It is the feature itself, of a change from healthy the whole amplitude. A relative error of a complex amplitude
    is the largest error of its phase in rad.
    """
    value = rows[_base_and_kind(name)[0]].abs()
    return value / rows[name.removesuffix(".phase")].abs() if name.endswith(".phase") else value


def degrees_text(angle: float) -> str:
    """Format an error of a phase (rad): `3.2°`, at most 180°."""
    return f"{significant(min(degrees(angle), 180.0))}°"


def _is_recorded(results: "Results", quantity: str) -> bool:
    """Check if all jobs of a study record a quantity of the outer ring or of the sensor."""
    channels = [set(str(text).replace(",", " ").split()) for text in results.parameters()["record"]]
    return bool(channels) and all({f"ring.{quantity}", f"sensor.{quantity}"} & names for names in channels)
