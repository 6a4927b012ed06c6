"""Error bounds of the results of a study with `accuracy`, and differences found by audits.

Errors are relative to the scale of the result, which is the largest value on its curve. The scale of a result on
several curves is the smallest of these values, that of a result on no curve its own value.
"""

from collections.abc import Iterator, Mapping
from math import inf, nan
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.config.names import read_band
from bearingsim.store.spread import chaotic_jobs, has_unknown_scatter, reference_ratio, standard_error
from bearingsim.study.goal import HEALTHY_SUFFIX
from bearingsim.study.uncertainty import RIGID_RING

if TYPE_CHECKING:
    import pandas as pd

STEP_KINDS = {"rms": "rms", "max": "force"}  # kind by suffix of a feature; without one of these it is a line
RECORD_FEATURES = ("acceleration.rms", "displacement.rms")
"""Features bounded by the largest step error of all recorded channels, not by that of the velocity RMS."""
START_SUFFIXES = {"line": "", "rms": ".rms", "force": ".force"}
"""Suffixes of the column `error.start`, by kind of feature."""
ERROR_PARTS = ("error.model", "error.friction", "error.nodes", "error.start", "error.step", "error.scatter")
"""Columns whose sum is ``error``."""
STANDARD_ERRORS = 2.0
"""Half width of the confidence interval of a difference, in standard errors (about 95 %)."""


class AuditResult(NamedTuple):
    """Difference of a feature between an audited job and the same job computed with the reference model.

    job: id of the audited job; difference: relative difference; scatter: relative difference that random scatter
    explains (``STANDARD_ERRORS`` standard errors). Both are relative to the scale of the feature.
    """

    job: str
    feature: str
    difference: float
    scatter: float

    def fails(self, within: float) -> bool:
        """Return True if the difference exceeds the accuracy ``within`` by more than the scatter."""
        return self.difference > within + self.scatter


def scales(plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return by job the scale (SI) of a feature, to which its errors are relative."""
    values = frame[f"features/{feature}"].abs()
    largest = values.copy()
    largest[:] = float("inf")
    for curve in plan["accuracy"]["curves"]:
        if curve["feature"] == feature:
            jobs = [job for job in curve["jobs"] if job in values.index]
            largest.loc[jobs] = largest.loc[jobs].clip(upper=values.loc[jobs].max())
    return largest.where(largest < float("inf"), values)


def error_bounds(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return ``ERROR_PARTS`` and the error bound ``error`` by case, each the largest over the requested features.

    ``error`` is the largest of ``feature_bounds``. It is NaN if a rigid ring is among the assumptions of the
    study, because ring bending may change the results more than the choice of the model. A part and ``error`` are
    NaN if the part is unknown for a requested feature, or if the feature has no value, because the difference that
    a failed audit has found does not bound these. Empty without `accuracy`.
    """
    import pandas as pd

    table = pd.DataFrame(index=frame.index, columns=[*ERROR_PARTS, "error"], dtype=float)
    if plan.get("accuracy") is None:
        return table.iloc[:, :0]
    parts = error_parts(plan, frame)
    for name in ERROR_PARTS:
        by_feature = pd.DataFrame({feature: part[name] for feature, part in parts.items()})
        table[name] = by_feature.max(axis=1).replace(inf, nan).reindex(table.index)
    if RIGID_RING not in plan.get("assumptions", ()):
        largest = feature_bounds(plan, frame).max(axis=1)
        table["error"] = largest.replace(inf, nan).reindex(table.index)
    return table.where(frame["status"] == "done")


def error_parts(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "dict[str, pd.DataFrame]":
    """Return the columns ``ERROR_PARTS`` by case for each requested feature, infinite where unknown.

    NaN for cases that are not done, and for the change from healthy of a healthy bearing. If the difference found
    by the audit of a case exceeds the sum of the parts and its scatter, `error.model` is increased by the excess.
    """
    cases = [job for job in plan["accuracy"]["jobs"] if job in frame.index]
    parts = {feature: _parts(plan, frame, feature).loc[cases] for feature in plan["accuracy"]["of"]}
    for audit in audit_results(plan, frame):
        errors = parts[audit.feature]
        other_parts = errors.drop(columns="error.model").sum(axis=1, skipna=False)
        model_error = audit.difference - audit.scatter - other_parts
        is_larger = (errors.index == audit.job) & (model_error > errors["error.model"])
        errors["error.model"] = errors["error.model"].mask(is_larger, model_error)
    return parts


def total_errors(parts: "Mapping[str, pd.DataFrame]") -> "pd.Series[float]":
    """Return by case the largest sum of the parts of one feature, infinite if unknown; parts: ``error_parts``.

    The largest parts of a case may belong to different features, so the sum of these could exceed every error.
    """
    import pandas as pd

    sums = {feature: part.sum(axis=1, skipna=False) for feature, part in parts.items()}
    return pd.DataFrame(sums).max(axis=1)


def feature_bounds(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return the error bound of each requested feature by case, relative to the scale of the feature.

    It is the sum of the parts, or the difference of this feature found by a failed audit if that is larger;
    infinite if a part is unknown. The bending of a ring that is assumed rigid is not included.
    """
    import pandas as pd

    audited_differences = _failed_differences(plan, frame)
    bounds = {}
    for feature, parts in error_parts(plan, frame).items():
        total = parts.sum(axis=1, skipna=False)
        difference = pd.Series(audited_differences.get(feature, {}), dtype=float).reindex(total.index)
        bounds[feature] = total.where(~(difference > total), difference)
    return pd.DataFrame(bounds)


def _parts(plan: Mapping[str, Any], frame: "pd.DataFrame", feature: str) -> "pd.DataFrame":
    """Return the parts of the error of a feature by job, infinite if unknown.

    NaN for jobs that are not done, and for the change from healthy of a healthy bearing.
    """
    import pandas as pd

    has_error = frame["status"] == "done"
    if feature.endswith(HEALTHY_SUFFIX) and "healthy" in frame:
        has_error &= frame["healthy"] != ""
    if f"features/{feature}" not in frame:
        return pd.DataFrame(inf, index=frame.index, columns=[*ERROR_PARTS]).where(has_error)
    scale, base = scales(plan, frame, feature), feature.removesuffix(HEALTHY_SUFFIX)
    choices = plan["accuracy"]["jobs"]

    def trial_errors(part: str) -> "pd.Series[float]":
        errors = {job: choice.get(part, {}).get(feature, 0.0) for job, choice in choices.items()}
        return pd.Series(errors, dtype=float).fillna(inf).reindex(frame.index)

    baselines = frame["healthy"] if base != feature and "healthy" in frame else None

    def with_baselines(errors: "pd.Series[float]") -> "pd.DataFrame":
        """Return the errors (SI) of the jobs, and those of their healthy baselines if the feature is a change."""
        columns = {"job": errors}
        if baselines is not None:
            columns["healthy"] = pd.Series(errors.reindex(baselines).to_numpy(), errors.index)
        return pd.DataFrame(columns)

    value = frame[f"features/{base}"].abs() * reference_ratio(frame, base)
    step = with_baselines(_step_errors(frame, base) * value).sum(axis=1, skipna=False) / scale
    variance = with_baselines(standard_error(frame, base).where(~has_unknown_scatter(frame, base), inf)) ** 2
    scatter = (variance.sum(axis=1, skipna=False) ** 0.5 / scale).fillna(inf)
    from_trials = {
        "error.model": trial_errors("error"),
        "error.friction": trial_errors("friction"),
        "error.nodes": trial_errors("nodes"),
    }
    start_errors = frame.get(f"features/error.start{START_SUFFIXES[_kind(base)]}", pd.Series(0.0, frame.index))
    start = with_baselines(start_errors * value).sum(axis=1, skipna=False) / scale
    excess = (start - scatter).clip(lower=0.0)  # the error of the start of a non-periodic motion includes scatter
    parts = pd.DataFrame(from_trials | {"error.start": excess, "error.step": step, "error.scatter": scatter})
    is_unknown = parts.isna() | frame[f"features/{feature}"].isna().to_numpy()[:, None]
    return parts.mask(is_unknown, inf).where(has_error)


def _step_errors(frame: "pd.DataFrame", feature: str) -> "pd.Series[float]":
    """Return the relative step error of a feature.

    That of a line of the squared envelope is twice that of the acceleration.
    """
    band = read_band(feature)
    factor = 2.0 if band is not None and band.line else 1.0
    from_acceleration = band is not None and (band.line or band.quantity == "acceleration")
    kind = "record" if from_acceleration or feature.partition("@")[0] in RECORD_FEATURES else _kind(feature)
    return factor * _stored_error(frame, f"step_error.{kind}").where(
        ~chaotic_jobs(frame), _chaotic_step_errors(frame, kind)
    )


def _chaotic_step_errors(frame: "pd.DataFrame", kind: str) -> "pd.Series[float]":
    """Return the relative step errors of chaotic motions, as far as the RMS resolves them.

    Lines and largest forces of two chaotic motions differ whatever the step is, so that they have none of their
    own.
    """
    own, rms = (frame.get(f"features/step_error.{name}") for name in (kind, "rms"))
    if own is None or rms is None:
        return _stored_error(frame, f"step_error.{kind}")
    return own.where(own.notna(), rms).fillna(0.0)


def _kind(feature: str) -> str:
    """Return the kind of a feature, `line`, `rms` or `force`."""
    return STEP_KINDS.get(feature.partition("@")[0].rpartition(".")[2], "line")


def _stored_error(frame: "pd.DataFrame", name: str) -> "pd.Series[float]":
    """Return a relative error that is stored as a feature; 0 for jobs without it."""
    import pandas as pd

    return frame.get(f"features/{name}", pd.Series(0.0, frame.index)).fillna(0.0)


def audit_results(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[AuditResult]:
    """Yield the result of each audit and requested feature for which both jobs are done and have a value."""
    accuracy = plan.get("accuracy") or {"audits": [], "of": []}
    features = [feature for feature in accuracy["of"] if f"features/{feature}" in frame]
    scale_values = {feature: scales(plan, frame, feature) for feature in features if accuracy["audits"]}
    for audit in accuracy["audits"]:
        pair = [audit["of"], audit["job"]]
        if not frame["status"].reindex(pair).eq("done").all():
            continue
        for feature in features:
            value, reference = frame[f"features/{feature}"].loc[pair]
            if value != value or reference != reference:  # NaN
                continue
            scale = float(scale_values[feature][audit["of"]]) or abs(float(reference)) or 1.0
            jobs = [*pair, *frame["healthy"].loc[pair]] if feature.endswith(HEALTHY_SUFFIX) else pair
            errors = standard_error(frame, feature.removesuffix(HEALTHY_SUFFIX)).reindex(list(dict.fromkeys(jobs)))
            scatter = STANDARD_ERRORS * float((errors**2).sum() ** 0.5) / scale
            yield AuditResult(audit["of"], feature, abs(float(value - reference)) / scale, scatter)


def incomplete_audits(plan: Mapping[str, Any], frame: "pd.DataFrame") -> list[str]:
    """List the audited jobs without a difference of a requested feature that the job can have."""
    accuracy = plan.get("accuracy") or {"audits": [], "of": []}
    compared = {(audit.job, audit.feature) for audit in audit_results(plan, frame)}
    healthy = frame.get("healthy")
    return [
        audit["of"]
        for audit in accuracy["audits"]
        if any(
            (audit["of"], feature) not in compared
            and not (feature.endswith(HEALTHY_SUFFIX) and healthy is not None and healthy.get(audit["of"]) == "")
            for feature in accuracy["of"]
        )
    ]


def withdrawn_errors(plan: Mapping[str, Any], frame: "pd.DataFrame") -> dict[str, float]:
    """Return by job the largest difference found by failed audits on the curves of the job.

    The accuracy of these jobs is withdrawn. Jobs without a failed audit on one of their curves are left out.
    """
    largest: dict[str, float] = {}
    for differences in _failed_differences(plan, frame).values():
        largest |= {job: max(largest.get(job, 0.0), difference) for job, difference in differences.items()}
    return largest


def _failed_differences(plan: Mapping[str, Any], frame: "pd.DataFrame") -> dict[str, dict[str, float]]:
    """Return by feature and job the largest difference of the feature found by failed audits on its curves.

    A failed audit of a feature on no curve concerns only the audited job. For the other jobs of a curve the same
    difference (SI) is assumed, relative to their own ``scales``, which differ if a job lies on several curves.
    """
    accuracy = plan.get("accuracy") or {"within": inf, "curves": []}
    by_feature: dict[str, dict[str, float]] = {}
    for audit in audit_results(plan, frame):
        if not audit.fails(accuracy["within"]):
            continue
        largest, by_job = by_feature.setdefault(audit.feature, {}), scales(plan, frame, audit.feature)
        curves = [curve["jobs"] for curve in accuracy["curves"] if curve["feature"] == audit.feature]
        curve_jobs = [job for jobs in curves if audit.job in jobs for job in jobs]
        for job in (audit.job, *curve_jobs):
            scale, audited_scale = by_job.get(job, 0.0), by_job[audit.job]
            ratio = float(audited_scale / scale) if scale > 0.0 and audited_scale > 0.0 else 1.0
            largest[job] = max(largest.get(job, 0.0), ratio * audit.difference)
    return by_feature
