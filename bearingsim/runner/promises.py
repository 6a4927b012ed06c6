"""Statements on a run with `accuracy`: models, cases within the accuracy, audits."""

from collections import Counter
from collections.abc import Iterator, Mapping
from math import inf
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.store.nearness import incomplete_audits
from bearingsim.store.spread import chaotic_jobs, variation_errors
from bearingsim.study.uncertainty import PARAMETER_KINDS, RIGID_RING
from bearingsim.text.numbers import percent

if TYPE_CHECKING:
    import pandas as pd


def selection_notes(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the models chosen for an accuracy, the result of audits, and uncertainties not included in it."""
    accuracy = plan.get("accuracy")
    if accuracy is None:
        return
    models = Counter(entry["model"] for entry in accuracy["jobs"].values())
    counts = ", ".join(f"`{model}` in {count}" for model, count in models.most_common())
    yield f"models for {_accuracy_text(accuracy)}: {counts} of {len(accuracy['jobs'])} cases"
    yield from accuracy["notes"]
    audits = _audits_by_job(plan, frame)
    if audits:
        passed = sum(
            not any(audit.fails(accuracy["within"]) for audit in job_audits) for job_audits in audits.values()
        )
        largest = max(audit.difference for job_audits in audits.values() for audit in job_audits)
        yield (
            f"audit: {passed} of {len(audits)} jobs recomputed with their reference are within the accuracy;"
            f" largest difference {percent(largest)}"
        )
    incomplete = incomplete_audits(plan, frame)
    if incomplete:
        count = f"{len(incomplete)} of {_count_text(len(accuracy['audits']), 'audit')}"
        yield f"{count} failed, are missing or have no value of a feature, whose accuracy they do not test"
    varied = {name.split(".")[1] for name in variation_errors(plan, frame).columns}
    unvaried = [quantity for quantity in PARAMETER_KINDS if quantity not in varied]
    if unvaried:
        yield f"not included in the accuracy: {', '.join(unvaried)}"


def withdrawals(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of cases whose accuracy is withdrawn, and the largest difference found by audits."""
    refuted_jobs = store.withdrawn_errors(plan, frame)
    if not refuted_jobs:
        return
    accuracy = plan["accuracy"]
    worst = max(store.audit_results(plan, frame), key=lambda audit: audit.difference - audit.scatter)
    cases = f"{len(refuted_jobs)} of {len(accuracy['jobs'])} cases"
    text = f"{worst.feature} is {percent(worst.difference)} different from its reference"
    yield f"accuracy of {_accuracy_text(accuracy)} withdrawn for {cases}: {text}"
    yield f"  in job {worst.job}; `model: reference` instead of `accuracy` computes all cases with the reference"


def accuracy_notes(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of cases within the accuracy, and remedies for the others.

    Cases whose accuracy is withdrawn are left out.
    """
    accuracy = plan.get("accuracy")
    if accuracy is None:
        return
    refuted_jobs, bounds = store.withdrawn_errors(plan, frame), store.error_bounds(plan, frame)
    jobs = [job for job in accuracy["jobs"] if job not in refuted_jobs]
    done = [job for job in jobs if frame["status"].get(job) == "done"]
    parts = {feature: part.loc[done] for feature, part in store.error_parts(plan, frame).items()}
    total_errors = store.total_errors(parts)
    total_errors = total_errors[total_errors < inf]
    exceeding = total_errors[total_errors > accuracy["within"]]
    within = len(total_errors) - len(exceeding)
    unknown = bounds.loc[done, [*store.ERROR_PARTS]].drop(index=total_errors.index)
    further = f"{len(exceeding)} more" if len(unknown) else "the others"
    others = f", {further} within {percent(exceeding.max())}" if len(exceeding) else ""
    if done and refuted_jobs:
        count = f"{within} of the other {len(done)} cases"
        yield f"{count} are within {_accuracy_text(accuracy)} according to their trials{others}"
    elif done:
        count = (
            f"{within} of {len(done)} cases are within {_accuracy_text(accuracy)} of the reference model{others}"
        )
        yield f"{count}; relative to the largest value of the curve"
    yield from _remedies({name: part.loc[exceeding.index] for name, part in parts.items()}, accuracy["within"])
    yield from _unknown_texts(unknown, chaotic_jobs(frame))
    if done:
        yield from empty_error_notes(plan)


def _unknown_texts(parts: "pd.DataFrame", is_chaotic: "pd.Series[bool]") -> Iterator[str]:
    """Yield the number of cases of unknown accuracy, with the reason.

    parts: ``ERROR_PARTS`` of these cases; is_chaotic: by job.
    """
    chaotic = parts.drop(columns="error.scatter").notna().all(axis=1) & is_chaotic.reindex(parts.index)
    if chaotic.any():
        count = _count_text(int(chaotic.sum()), "chaotic case")
        yield f"{count}: standard error of a line unknown, and thus the accuracy"
    others = parts[~chaotic]
    has_no_value = others.isna().all(axis=1)
    if has_no_value.any():
        count = _count_text(int(has_no_value.sum()), "case")
        yield f"{count}: accuracy unknown, because a feature named in `of` has no value"
    others = others[~has_no_value]
    if len(others):
        names = " or ".join(f"`{name}`" for name in others if others[name].isna().any())
        yield f"{_count_text(len(others), 'case')}: accuracy unknown, because {names} is unknown"


def _count_text(count: int, noun: str) -> str:
    """Format a number with its noun, as `2 cases`."""
    return f"{count} {noun}{'s' * (count != 1)}"


def empty_error_notes(plan: Mapping[str, Any]) -> Iterator[str]:
    """Yield the reason why the column `error` of a study with `accuracy` is empty, and its remedy."""
    if plan.get("accuracy") and RIGID_RING in plan.get("assumptions", ()):
        yield "`error` is empty because the ring may bend: if it is rigid, add `rig: {ring: {bends: false}}`"


def _accuracy_text(accuracy: Mapping[str, Any]) -> str:
    """Format the requested accuracy, as `2 %`."""
    return percent(accuracy["within"], 3)


def _audits_by_job(plan: Mapping[str, Any], frame: "pd.DataFrame") -> dict[str, list[store.AuditResult]]:
    """Return the results of audits by audited job."""
    audits: dict[str, list[store.AuditResult]] = {}
    for audit in store.audit_results(plan, frame):
        audits.setdefault(audit.job, []).append(audit)
    return audits


def _remedies(parts: "Mapping[str, pd.DataFrame]", limit: float) -> Iterator[str]:
    """Yield the number of cases that a longer record or a finer discretisation would bring within the accuracy.

    parts: ``ERROR_PARTS`` of the cases that exceed the accuracy ``limit``, by requested feature.
    """
    import pandas as pd

    scatter = pd.DataFrame({feature: part["error.scatter"] for feature, part in parts.items()})
    others = {feature: part.drop(columns="error.scatter").sum(axis=1) for feature, part in parts.items()}
    margin = limit - pd.DataFrame(others)
    factors = ((scatter / margin) ** 2)[(margin > 0.0).all(axis=1)].max(axis=1)  # scatter ~ 1/sqrt(duration)
    if len(factors):
        yield f"  {len(factors)} more would be within the accuracy with {factors.max():.1f} times the `duration`"
    finer = {feature: part.drop(columns="error.nodes") for feature, part in parts.items()}
    finer_count = int((store.total_errors(finer) <= limit).sum())
    if finer_count:
        remedy = "more `contact.length_nodes` (slices, harmonics)"
        yield f"  {finer_count} more would be within the accuracy with {remedy}"
