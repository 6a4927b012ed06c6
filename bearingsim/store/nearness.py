"""Error bounds of the results of a study with `accuracy`, and differences found by audits.

All are relative to the largest value of the curve with the result (the lowest of several; without one its own).
"""

from collections.abc import Iterator, Mapping
from math import inf, nan
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.config.names import read_band
from bearingsim.store.spread import scatters_unknown, standard_error
from bearingsim.study.goal import HEALTHY
from bearingsim.study.uncertainty import RIGID

if TYPE_CHECKING:
    import pandas as pd

STEP_OF = {"rms": "rms", "max": "force"}  # by the ending of a feature: all others are lines
RECORD_FEATURES = ("acceleration.rms", "displacement.rms")
"""They change otherwise than the RMS of the velocity: bounded by the largest change of all that is recorded."""
START_OF = {"line": "", "rms": ".rms", "force": ".force"}
"""Endings of `error.start`, by what it is of."""
PARTS = ("error.model", "error.friction", "error.nodes", "error.start", "error.step", "error.scatter")
"""Columns whose sum is ``error``."""
STANDARD_ERRORS = 2.0


class Audited(NamedTuple):
    """A feature of a job that was computed again by its reference: the difference, and what may be scatter.

    job: the id of the job that was audited; off, scatter: relative to the largest value of the feature's curve.
    """

    job: str
    feature: str
    off: float
    scatter: float

    def fails(self, within: float) -> bool:
        """Return whether the difference exceeds an accuracy by more than scatter explains."""
        return self.off > within + self.scatter


def scales(plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the value (SI) by job that errors of a feature are relative to: the largest of its curve."""
    values = frame[f"features/{feature}"].abs()
    largest = values.copy()
    largest[:] = float("inf")
    for curve in plan["accuracy"]["curves"]:
        if curve["feature"] == feature:
            jobs = [job for job in curve["jobs"] if job in values.index]
            largest.loc[jobs] = largest.loc[jobs].clip(upper=values.loc[jobs].max())
    return largest.where(largest < float("inf"), values)


def nearness(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return ``PARTS`` and their sum ``error`` by case, each the largest of what is asked.

    No ``error`` where the study leaves open what moves its results more than any model: whether its ring bends. No
    ``.scatter`` and no ``error`` of a chaotic motion if a line is asked for whose scatter is unknown. Where an
    audit failed, ``error`` is at least the difference that it found, on all of the curve.
    """
    import pandas as pd

    accuracy = plan.get("accuracy")
    table = pd.DataFrame(index=frame.index, columns=[*PARTS, "error"], dtype=float)
    if accuracy is None:
        return table.iloc[:, :0]
    cases = [job for job in accuracy["jobs"] if job in frame.index]
    parts = {feature: _parts(plan, frame, feature) for feature in accuracy["of"] if f"features/{feature}" in frame}
    for name in PARTS:
        of_features = pd.DataFrame({feature: part[name] for feature, part in parts.items()})
        table.loc[cases, name] = of_features.max(axis=1).replace(inf, nan).reindex(cases)
    if RIGID not in plan.get("assumptions", ()):
        sums = pd.DataFrame({feature: part.sum(axis=1, skipna=False) for feature, part in parts.items()})
        table.loc[cases, "error"] = sums.max(axis=1).replace(inf, nan).reindex(cases)
    refuted = pd.Series(withdrawn(plan, frame), dtype=float).reindex(table.index)
    table["error"] = table["error"].where(~(refuted > table["error"].fillna(0.0)), refuted)
    return table.where(frame["status"] == "done")


def _parts(plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str) -> "pd.DataFrame":
    """Return the parts of the error of a feature by job."""
    import pandas as pd

    size, plain = scales(plan, frame, feature), feature.removesuffix(HEALTHY)
    chosen = plan["accuracy"]["jobs"]

    def tried(part: str) -> "pd.Series[float]":
        errors = {job: choice.get(part, {}).get(feature, 0.0) for job, choice in chosen.items()}
        return pd.Series(errors, dtype=float).fillna(inf).reindex(frame.index)

    step = _step_errors(frame, plain) * frame[f"features/{plain}"].abs() / size
    scatter = standard_error(frame, plain).where(~scatters_unknown(frame, plain), inf) / size
    of_trials = {"error.model": tried("error"), "error.friction": tried("friction"), "error.nodes": tried("nodes")}
    start = _relative(frame, f"error.start{START_OF[_kind(plain)]}") * frame[f"features/{plain}"].abs() / size
    beyond = (start - scatter.fillna(0.0)).clip(lower=0.0)  # of what does not repeat itself it counts scatter, too
    parts = pd.DataFrame(of_trials | {"error.start": beyond, "error.step": step, "error.scatter": scatter})
    return parts.where(frame["status"] == "done")


def _step_errors(frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the relative step error of a feature; an envelope, a square, has twice that of the acceleration."""
    banded = read_band(feature)
    times = 2.0 if banded is not None and banded.line else 1.0
    of_acceleration = banded is not None and (banded.line or banded.quantity == "acceleration")
    kind = "record" if of_acceleration or feature.partition("@")[0] in RECORD_FEATURES else _kind(feature)
    return times * _relative(frame, f"step_error.{kind}")


def _kind(feature: str) -> str:
    """Return whether a feature is a `line`, an `rms`, or a `force`."""
    return STEP_OF.get(feature.partition("@")[0].rpartition(".")[2], "line")


def _relative(frame: "pd.DataFrame", name: str) -> "pd.Series[float]":
    """Return a relative error that each job has as a feature, 0 where it has none."""
    import pandas as pd

    return frame.get(f"features/{name}", pd.Series(0.0, frame.index)).fillna(0.0)


def audited(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[Audited]:
    """Yield the differences that audits found, by job and feature, of pairs whose jobs are both done."""
    accuracy = plan.get("accuracy") or {"audits": [], "of": []}
    features = [feature for feature in accuracy["of"] if f"features/{feature}" in frame]
    sizes = {feature: scales(plan, frame, feature) for feature in features if accuracy["audits"]}
    for audit in accuracy["audits"]:
        pair = [audit["of"], audit["job"]]
        if not frame["status"].reindex(pair).eq("done").all():
            continue
        for feature in features:
            own, reference = frame[f"features/{feature}"].loc[pair]
            if own != own or reference != reference:  # no value in one of them: nothing is compared
                continue
            size = float(sizes[feature][audit["of"]]) or 1.0
            errors = standard_error(frame, feature.removesuffix(HEALTHY)).reindex(pair)
            scatter = STANDARD_ERRORS * float((errors**2).sum() ** 0.5) / size
            yield Audited(audit["of"], feature, abs(float(own - reference)) / size, scatter)


def withdrawn(plan: Mapping[str, Any], frame: "pd.DataFrame") -> dict[str, float]:
    """Return the largest difference that a failed audit found on a curve of each case, by job.

    Only of cases on a curve of a feature whose audit failed: what was promised of them is withdrawn. A feature on
    no curve counts for its own job alone.
    """
    accuracy = plan.get("accuracy") or {"within": inf, "curves": []}
    largest: dict[str, float] = {}
    for audit in audited(plan, frame):
        if not audit.fails(accuracy["within"]):
            continue
        drawn = [curve["jobs"] for curve in accuracy["curves"] if curve["feature"] == audit.feature]
        on_it = [job for jobs in drawn if audit.job in jobs for job in jobs]
        for job in (audit.job, *on_it):
            largest[job] = max(largest.get(job, 0.0), audit.off)
    return largest
