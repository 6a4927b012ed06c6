"""Spread of results under uncertain parameters: the jobs of `uncertainty:` beside the nominal ones.

A value of a chaotic motion is a random sample: it counts with its standard error to both sides.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bearingsim.config.names import ERRORS, FAULT_LINES, is_mean

if TYPE_CHECKING:
    import pandas as pd

BY_BLOCKS = {"velocity@BPFO": "standard_error.line", "velocity.rms": "standard_error.rms"}
"""The relative standard errors by blocks of ball passes; results of earlier versions do not have them."""
NOTABLE = 0.005
"""Of a value: a standard error beyond which a result of a chaotic motion is one draw of many."""

STANDARD_DEVIATIONS = 2.5  # that `rms_scatter` stands for, or more: it counts how few passes tell


def spread(
    plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str, what: str | None = None
) -> "pd.DataFrame":
    """Return ``least`` and ``largest`` of a feature (SI) among a job and its variations of ``what`` (or of all).

    frame: of ``job_frame``. Indexed by the jobs whose variations all have a result; ``chaotic``: whether one of
    the motions is. None of a phase, which has no least value.
    """
    import numpy as np
    import pandas as pd

    columns = ["least", "largest", "chaotic"]
    entries = [varied for varied in plan.get("variations", ()) if what is None or varied["what"] == what]
    name = f"features/{feature}"
    if not entries or name not in frame or name.endswith(".phase"):
        return pd.DataFrame(columns=columns)
    pairs = pd.DataFrame([(varied["of"], varied["job"]) for varied in entries], columns=["of", "job"])
    lacking = frame[name].reindex(pairs["job"]).isna().to_numpy()
    pairs = pairs[~pairs["of"].isin(pairs["of"][lacking])]  # a part of the range would look like all of it
    if pairs.empty:
        return pd.DataFrame(columns=columns)
    own = pd.DataFrame({"of": pairs["of"].unique(), "job": pairs["of"].unique()})
    pairs = pd.concat([own, pairs], ignore_index=True)
    value = frame[name].reindex(pairs["job"]).to_numpy()
    beside = standard_error(frame, feature).reindex(pairs["job"]).to_numpy()
    pairs = pairs.assign(least=value - beside, largest=value + beside)
    pairs["chaotic"] = _chaotic(frame).reindex(pairs["job"]).to_numpy()
    ranges = pairs.groupby("of", sort=False).agg({"least": "min", "largest": "max", "chaotic": "any"})
    unknown = pairs["of"][np.isnan(beside)]  # chaotic, and not seen for long enough
    ranges = ranges[~ranges.index.isin(unknown)]
    return ranges if (value < 0.0).any() else ranges.assign(least=ranges["least"].clip(lower=0.0))


def standard_error(frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the standard error (SI) of a feature of chaotic motions and of records that have ended early.

    0 where neither is so, or nothing tells it; NaN where the record is too short to tell.
    """
    import numpy as np
    import pandas as pd

    error = pd.Series(0.0, frame.index)
    if f"features/{feature}-scatter" in frame:
        error = frame[f"features/{feature}-scatter"]
    elif ".rms" in feature and "features/rms_scatter" in frame:
        error = frame["features/rms_scatter"] / STANDARD_DEVIATIONS * frame[f"features/{feature}"].abs()
    chaotic_jobs = error.replace(np.inf, np.nan).where(_chaotic(frame), 0.0)
    reached = early_end_errors(frame, feature)
    return (
        chaotic_jobs
        if reached is None
        else chaotic_jobs.where(reached.isna(), reached * frame[f"features/{feature}"].abs())
    )


def early_end_errors(frame: "pd.DataFrame", feature: str) -> "pd.Series[float] | None":
    """Return the relative standard error of lines, or of RMS values, by which records ended; None of an extreme.

    NaN of other jobs.
    """
    name = f"info/standard_error_{'line' if is_line(feature) else 'rms'}"
    if name not in frame or not is_mean(feature):
        return None
    return frame[name].where(frame["info/passes_computed"] < frame["info/passes"])


def is_line(feature: str) -> bool:
    """Check if a feature is a spectral line."""
    return "@" in feature and ".rms@" not in feature


def is_one_draw(table: "pd.DataFrame", feature: str, notable: float = NOTABLE) -> "pd.Series[bool]":
    """Mark jobs in which a feature is one draw of many: chaotic, with a standard error over ``notable``.

    ``notable``: part of the value.
    """
    return _chaotic(table.add_prefix("features/")) & ~(relative_error(table, feature) <= notable)


def relative_error(table: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the standard error of a feature of a table as a part of it; NaN where nothing tells it.

    What is neither line nor RMS has that of the velocity's RMS.
    """
    import pandas as pd

    frame = table.add_prefix("features/")
    plain = feature.removesuffix("-healthy.phase").removesuffix(".phase").removesuffix("-healthy")
    judged = plain if is_line(plain) else "velocity.rms"
    if f"features/{judged}" not in frame or (is_line(plain) and f"features/{plain}-scatter" not in frame):
        return pd.Series(float("nan"), frame.index)
    relative = standard_error(frame, judged) / frame[f"features/{judged}"].abs()
    block_errors = frame.get(f"features/{BY_BLOCKS.get(judged, '')}")
    if block_errors is not None:
        relative = block_errors.where(block_errors.notna(), relative)
    if plain != feature.removesuffix(".phase") and f"features/{plain}-healthy" in frame:  # the change may be small
        relative = relative * (frame[f"features/{judged}"] / frame[f"features/{plain}-healthy"]).abs()
    return relative


def scatters_unknown(frame: "pd.DataFrame", feature: str) -> "pd.Series[bool]":
    """Mark jobs in which a feature is a line of a chaotic motion without a standard error: no multiple of BPFO."""
    has_scatter = not is_line(feature) or f"features/{feature}-scatter" in frame
    reached = early_end_errors(frame, feature)
    return _chaotic(frame) & (not has_scatter) & (True if reached is None else reached.isna())


def _chaotic(frame: "pd.DataFrame") -> "pd.Series[bool]":
    import pandas as pd

    return frame["features/chaotic"] == 1.0 if "features/chaotic" in frame else pd.Series(False, frame.index)


def errors(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return (largest - least)/value by job: `error.damping` of the line, `.rms`, `.force`, and so on."""
    import pandas as pd

    table = pd.DataFrame(index=frame.index)
    for what in dict.fromkeys(varied["what"] for varied in plan.get("variations", ())):
        for ending in ERRORS:
            features = _features(frame, ending)
            parts = [_relative(plan, frame, name, what)[features == name] for name in features.unique()]
            table[f"error.{what}{ending}"] = pd.concat(parts)
    return table.dropna(how="all", axis=1)


def _features(frame: "pd.DataFrame", ending: str) -> "pd.Series[str]":
    """Return the feature by job that a column of ``ERRORS`` is of: the line that of its first defect."""
    import pandas as pd

    if ending:
        return pd.Series({".rms": "velocity.rms", ".force": "outer_force.max"}[ending], frame.index)
    races = frame.get("parameters/defects.1.race", pd.Series("", frame.index))
    return "velocity@" + races.map(FAULT_LINES).fillna(FAULT_LINES["outer"])


def _relative(plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str, what: str) -> "pd.Series[float]":
    """Return (largest - least)/value of a feature, NaN for jobs that were not varied."""
    import numpy as np
    import pandas as pd

    between = spread(plan, frame, feature, what).reindex(frame.index)
    value = frame.get(f"features/{feature}", pd.Series(np.nan, frame.index))
    return (between["largest"] - between["least"]) / value.abs()
