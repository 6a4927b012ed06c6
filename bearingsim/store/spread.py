"""Spread of results due to uncertain parameters, over the variations of `uncertainty:` and the nominal jobs.

Results of chaotic motions are random samples, so the spread includes their standard errors.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bearingsim.config.names import ERROR_FEATURES, FAULT_LINES, QUIET_LINE, is_mean, read_band

if TYPE_CHECKING:
    import pandas as pd

BLOCK_ERRORS = {"velocity@BPFO": "standard_error.line", "velocity.rms": "standard_error.rms"}
"""Columns with relative standard errors from blocks of ball passes, by feature; results of earlier versions do not
have them."""
LARGEST_FORCE = "outer_force.max"
"""Feature whose scatter is estimated from the maxima of rollers."""
FORCE_ERROR = "features/error.start.force"
"""Column whose relative error of the largest outer force includes its scatter in a chaotic motion."""
NOTABLE_ERROR = 0.005
"""Relative standard error above which a result of a chaotic motion is reported as a random sample."""

SCATTER_FACTOR = 2.5
"""Smallest number of standard errors that `rms_scatter` contains; it contains more if few passes were compared."""


def spread(
    plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str, quantity: str | None = None
) -> "pd.DataFrame":
    """Return ``least`` and ``largest`` of a feature (SI) over a job and its variations.

    plan: from ``read_plan``; frame: from ``job_frame``; quantity: the varied quantity, None for all. Rows are the
    jobs that have a result, like all of their variations; the range is NaN if one of their standard errors is
    unknown. The column ``chaotic`` is True if any of the motions is chaotic. Empty for a phase, which has no
    range.
    """
    import numpy as np
    import pandas as pd

    columns = ["least", "largest", "chaotic"]
    entries = [
        variation for variation in plan.get("variations", ()) if quantity is None or variation["what"] == quantity
    ]
    name = f"features/{feature}"
    if not entries or name not in frame or name.endswith(".phase"):
        return pd.DataFrame(columns=columns)
    pairs = pd.DataFrame([(variation["of"], variation["job"]) for variation in entries], columns=["of", "job"])
    nominal = pd.DataFrame({"of": pairs["of"].unique(), "job": pairs["of"].unique()})
    pairs = pd.concat([nominal, pairs], ignore_index=True)
    is_missing = frame[name].reindex(pairs["job"]).isna().to_numpy()
    pairs = pairs[~pairs["of"].isin(pairs["of"][is_missing])]  # a partial range would be mistaken for the full one
    if pairs.empty:
        return pd.DataFrame(columns=columns)
    value = frame[name].reindex(pairs["job"]).to_numpy()
    standard_errors = standard_error(frame, feature).reindex(pairs["job"]).to_numpy()
    pairs = pairs.assign(least=value - standard_errors, largest=value + standard_errors)
    pairs["chaotic"] = chaotic_jobs(frame).reindex(pairs["job"]).to_numpy()
    ranges = pairs.groupby("of", sort=False).agg({"least": "min", "largest": "max", "chaotic": "any"})
    unknown = pairs["of"][np.isnan(standard_errors)]  # chaotic motions with too short a record
    ranges.loc[ranges.index.isin(unknown), ["least", "largest"]] = np.nan
    return ranges if (value < 0.0).any() else ranges.assign(least=ranges["least"].clip(lower=0.0))


def standard_error(frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the standard error (SI) of a feature for chaotic motions and for records that ended early.

    It is 0 for all other jobs, and NaN if no estimate exists or the record is too short for one. The relative
    error of an RMS is that of the velocity RMS, from blocks of ball passes, or from pilots if there are too few
    blocks; that of the largest outer force is estimated from the maxima of the rollers
    (``simulation/start_error.py``).
    """
    import numpy as np
    import pandas as pd

    error = pd.Series(np.nan, frame.index)
    if f"features/{feature}-scatter" in frame:
        error = frame[f"features/{feature}-scatter"]
    elif ".rms" in feature and "features/rms_scatter" in frame:
        relative = frame["features/rms_scatter"] / SCATTER_FACTOR
        blocks = frame.get(f"features/{BLOCK_ERRORS['velocity.rms']}")
        relative = relative if blocks is None else blocks.where(blocks.notna(), relative)
        error = relative * frame[f"features/{feature}"].abs()
    elif feature == LARGEST_FORCE and FORCE_ERROR in frame:
        error = frame[FORCE_ERROR] * frame[f"features/{feature}"].abs()
    chaotic_errors = error.replace(np.inf, np.nan).where(chaotic_jobs(frame), 0.0)
    early_errors = early_end_errors(frame, feature)
    if early_errors is None:
        return chaotic_errors
    value = frame[f"features/{feature}"].abs() * reference_ratio(frame, feature)
    return chaotic_errors.where(early_errors.isna(), early_errors * value)


def scatters_by_known_amount(frame: "pd.DataFrame", feature: str) -> bool:
    """Check if chaotic motions have a standard error of a feature, unless their records are too short."""
    return f"features/{feature}-scatter" in frame or ".rms" in feature or feature == LARGEST_FORCE


def reference_ratio(frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return by job the ratio of the value to which the errors of a feature are relative to the feature itself.

    These are the errors of step and start, and the standard error. The ratio is 1, except for a line weaker than
    ``QUIET_LINE`` times the velocity RMS, whose errors are relative to that product.
    """
    import pandas as pd

    line = feature.partition("@")[2]
    velocity, rms = (frame.get(f"features/{name}") for name in (f"velocity@{line}", "velocity.rms"))
    if read_band(feature) is not None or velocity is None or rms is None:
        return pd.Series(1.0, frame.index)
    return (QUIET_LINE * rms / velocity.abs()).clip(lower=1.0)


def early_end_errors(frame: "pd.DataFrame", feature: str) -> "pd.Series[float] | None":
    """Return the relative standard error of a line or RMS at which the record was ended early, by job.

    NaN for jobs whose record did not end early; None for an extreme value, or if no such column exists.
    """
    name = f"info/standard_error_{'line' if is_line(feature) else 'rms'}"
    if name not in frame or not is_mean(feature):
        return None
    return frame[name].where(frame["info/passes_computed"] < frame["info/passes"])


def is_line(feature: str) -> bool:
    """Check if a feature is a spectral line."""
    return "@" in feature and ".rms@" not in feature


def is_uncertain(table: "pd.DataFrame", feature: str, notable: float = NOTABLE_ERROR) -> "pd.Series[bool]":
    """Mark chaotic jobs in which the relative standard error of a feature is unknown or above ``notable``."""
    return chaotic_jobs(table.add_prefix("features/")) & ~(relative_error(table, feature) <= notable)


def relative_error(table: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the relative standard error of a feature of a table by job; NaN if it is unknown.

    That of any RMS is that of the velocity RMS. A maximum, a crest factor or a cage slip may scatter many times
    more, so of other features only that of the largest outer force is known.
    """
    import pandas as pd

    frame = table.add_prefix("features/")
    if not has_error_estimate(table, feature):
        return pd.Series(float("nan"), frame.index)
    base = _base(feature)
    reference = _reference(base)
    relative = standard_error(frame, reference) / frame[f"features/{reference}"].abs()
    block_errors = frame.get(f"features/{BLOCK_ERRORS.get(reference, '')}")
    if block_errors is not None:
        relative = block_errors.where(block_errors.notna(), relative)
    # The error of a change from healthy is that of the feature, relative to the change, which may be smaller.
    if base != feature.removesuffix(".phase") and f"features/{base}-healthy" in frame:
        relative = relative * (frame[f"features/{base}"] / frame[f"features/{base}-healthy"]).abs()
    return relative


def has_error_estimate(table: "pd.DataFrame", feature: str) -> bool:
    """Check if a table has a column from which the standard error of a feature is estimated."""
    base = _base(feature)
    column = FORCE_ERROR.partition("/")[2] if base == LARGEST_FORCE else f"{base}-scatter" if is_line(base) else ""
    return _reference(base) in table and (not column or column in table)


def _base(feature: str) -> str:
    """Return the feature without the suffixes of a phase and of a change from healthy."""
    return feature.removesuffix("-healthy.phase").removesuffix(".phase").removesuffix("-healthy")


def _reference(base: str) -> str:
    """Return the feature whose relative standard error is that of a feature, "" if there is none."""
    if is_line(base) or base == LARGEST_FORCE:
        return base
    return "velocity.rms" if ".rms" in base else ""


def has_unknown_scatter(frame: "pd.DataFrame", feature: str) -> "pd.Series[bool]":
    """Mark jobs in which a feature scatters by an unknown amount.

    Such a feature is a line without a standard error in a chaotic record, or an extreme value in a record that
    ended early.
    """
    has_scatter = not is_line(feature) or f"features/{feature}-scatter" in frame
    is_unknown = chaotic_jobs(frame) & (not has_scatter)
    # The column of a mean value shows which records ended early.
    early_errors = early_end_errors(frame, feature if is_mean(feature) else "velocity.rms")
    if early_errors is None:
        return is_unknown
    return (is_unknown & early_errors.isna()) | ((early_errors > 0.0) & (not is_mean(feature)))


def chaotic_jobs(frame: "pd.DataFrame") -> "pd.Series[bool]":
    """Mark the jobs of a frame whose motion is chaotic."""
    import pandas as pd

    return frame["features/chaotic"] == 1.0 if "features/chaotic" in frame else pd.Series(False, frame.index)


def variation_errors(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return ``relative_range`` by job, in columns such as `error.damping` and `error.damping.rms`."""
    import pandas as pd

    table = pd.DataFrame(index=frame.index)
    for quantity in dict.fromkeys(variation["what"] for variation in plan.get("variations", ())):
        for suffix in ERROR_FEATURES:
            parts = list(_ranges(plan, frame, suffix, quantity).values())
            table[f"error.{quantity}{suffix}"] = pd.concat(parts).reindex(frame.index)
    return table.dropna(how="all", axis=1)


def default_ranges(plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str) -> "dict[str, pd.Series[float]]":
    """Return ``relative_range`` of the features of ``ERROR_FEATURES``, by feature and job.

    That of a line is only for the jobs with a defect on its race.
    """
    return {
        name: column
        for suffix in ERROR_FEATURES
        for name, column in _ranges(plan, frame, suffix, quantity).items()
    }


def _ranges(
    plan: Mapping[str, Any], frame: "pd.DataFrame", suffix: str, quantity: str
) -> "dict[str, pd.Series[float]]":
    """Return ``relative_range`` of the features of a suffix, each for the jobs of whose defect it is."""
    features = _default_features(frame, suffix)
    columns = {name: relative_range(plan, frame, name, quantity) for name in features.unique()}
    return {name: column[features.reindex(column.index) == name] for name, column in columns.items()}


def _default_features(frame: "pd.DataFrame", suffix: str) -> "pd.Series[str]":
    """Return by job the feature of a suffix of ``ERROR_FEATURES``; a line is that of the first defect's race."""
    import pandas as pd

    if suffix:
        return pd.Series({".rms": "velocity.rms", ".force": "outer_force.max"}[suffix], frame.index)
    races = frame.get("parameters/defects.1.race", pd.Series("", frame.index))
    return "velocity@" + races.map(FAULT_LINES).fillna(FAULT_LINES["outer"])


def relative_range(
    plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str, quantity: str
) -> "pd.Series[float]":
    """Return (largest - least)/|value| of a feature for the jobs with a value and a result of all variations.

    NaN if the range is unknown, or the value is zero.
    """
    import numpy as np
    import pandas as pd

    ranges = spread(plan, frame, feature, quantity)
    value = frame.get(f"features/{feature}", pd.Series(np.nan, frame.index)).reindex(ranges.index).dropna()
    widths = (ranges["largest"] - ranges["least"]).reindex(value.index).astype(float)
    return (widths / value.abs()).replace(np.inf, np.nan)
