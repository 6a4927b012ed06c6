"""Statements on results: assumptions that were not varied, failed jobs."""

from typing import TYPE_CHECKING, NamedTuple

from bearingsim.config.rules import damping

if TYPE_CHECKING:
    from bearingsim.store import Results

EXAMPLE_VALUES = {"clearance": "0 um, 10 um", "bracket": "0.5, 2"}
"""Example values of uncertain quantities without an assumption text of their own."""


def assumption_texts(results: "Results") -> list[str]:
    """List a sentence for each assumption of a study, and the setting that varies it."""
    from bearingsim.runner.findings import assumption_notes, findings
    from bearingsim.store import job_frame

    frame = job_frame(results.path)
    texts = [*assumption_notes(results.plan, frame), *damping.result_remarks(results.info())]
    unvaried_names = [name for name in findings(results.plan, frame).assumptions if name in EXAMPLE_VALUES]
    return texts + [
        f"{name} has one value per case; `uncertainty: {{{name}: [{EXAMPLE_VALUES[name]}]}}` varies it"
        for name in unvaried_names
    ]


class FailedJob(NamedTuple):
    """Failed job: id, swept values or variation, reason with advice, command to repeat it, traceback."""

    job: str
    case: str
    explanation: str
    command: str
    traceback: str


def failures_of(results: "Results") -> list[FailedJob]:
    """List the failed jobs of a study, in the order of its plan."""
    from bearingsim.plots.labels import described

    swept_values = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    variation_texts = {
        entry["job"]: f"{entry['what']} {entry['value']:.3g} (SI) of {entry['of']}" for entry in results.variations
    }
    stored = results.failures()
    failed = []
    for job in results.planned:
        if job not in stored:
            continue
        failure = stored[job]
        has_no_time = failure.time is None or "into the run" in failure.reason
        time_text = "" if has_no_time else f", {1e3 * (failure.time or 0.0):.4g} ms into the run"
        explanation = f"{failure.reason}{time_text}" + (f" ({failure.advice})" if failure.advice else "")
        case = variation_texts.get(job) or described(swept_values[job], results.plan["units"])
        failed.append(FailedJob(job, case, explanation, failure.command or "", failure.traceback))
    return failed
