"""Statements on results: assumptions that were not varied, failed jobs."""

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.config.rules import damping
from bearingsim.config.sections.clearance import class_limits
from bearingsim.text.numbers import span

if TYPE_CHECKING:
    from bearingsim.store import Results

BRACKET_FACTORS = "0.5, 2"
"""Example range of the factor on the bracket stiffness."""
VALUES = {
    "clearance": ("clearance", "clearance", "amplitudes at light load depend on it several-fold"),
    "bracket": (
        "stiffness of the bracket",
        "rig.bracket_stiffness",
        "halving or doubling it changes the RMS by up to half, the line at the defect frequency by up to a tenth",
    ),
}
"""Name and path of the parameter that an entry of `uncertainty` varies, and its effect (docs/evidence/form.md)."""
PAGES = re.compile(r" \(docs/[^)]*\)|; docs/[^)]*(?=\))")
"""References to pages of the documentation in a statement."""
CLEARANCE_MARGIN = 10.0  # um; example of the uncertainty of a clearance given as a length


def assumption_texts(results: "Results") -> list[str]:
    """List a sentence for each assumption of a study, and the setting that varies it."""
    from bearingsim.runner.findings import assumption_notes, findings
    from bearingsim.store import job_frame

    frame = job_frame(results.path)
    is_damping_varied = any(variation["what"] == "damping" for variation in results.variations)
    remarks = [] if is_damping_varied else damping.result_remarks(results.info())
    examples = {"clearance": _clearance_range, "bracket": lambda _: BRACKET_FACTORS}
    unvaried_names = [name for name in findings(results.plan, frame).assumptions if name in examples]
    return [*assumption_notes(results.plan, frame), *remarks] + [
        f"{VALUES[name][0]} {_values(results, VALUES[name][1])}, not varied; {VALUES[name][2]} "
        f"(docs/uncertainty.md); `uncertainty: {{{name}: [{examples[name](results)}]}}` varies it"
        for name in unvaried_names
    ]


def _values(results: "Results", path: str) -> str:
    """Format the value of a parameter, or its range over the cases."""
    from bearingsim.plots.caption import SMALL_UNITS
    from bearingsim.plots.labels import value_text

    values, units = results.parameters()[path].dropna(), SMALL_UNITS | dict(results.plan["units"])
    return span(float(values.min()), float(values.max()), lambda end: value_text(path, end, units))


def plain(text: str) -> str:
    """Remove settings of `uncertainty` and references to the documentation from a statement."""
    return PAGES.sub("", re.sub(r"[;:] `uncertainty: .*", "", text))


def _clearance_range(results: "Results") -> str:
    """Return an example clearance range, `30 um, 60 um`: the limits of its class, else the value with a margin."""
    parameters = results.parameters()
    low, high = float(parameters["clearance"].min()), float(parameters["clearance"].max())
    bores = set(parameters["bearing.bore"].dropna()) if "bearing.bore" in parameters else set()
    elements = set(parameters["bearing.element"])
    if low == high and len(bores) == len(elements) == 1:
        limits = class_limits(low, elements.pop(), bores.pop())
        if limits is not None:
            return ", ".join(f"{1e6 * limit:.4g} um" for limit in limits)
    low, high = 1e6 * low, 1e6 * high
    lower = max(0.0, low - CLEARANCE_MARGIN) if low >= 0.0 else low - CLEARANCE_MARGIN
    return f"{lower:.4g} um, {high + CLEARANCE_MARGIN:.4g} um"


class FailedJob(NamedTuple):
    """Failed job: id, swept values or variation, reason with advice, command to repeat it, traceback."""

    job: str
    case: str
    explanation: str
    command: str
    traceback: str


def list_failures(results: "Results") -> list[FailedJob]:
    """List the failed jobs of a study, in the order of its plan."""
    stored, swept = results.failures(), {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    rows = set(results.jobs)
    variations = {entry["job"]: entry for entry in results.variations if entry["job"] not in rows}
    failed = []
    for job in filter(stored.__contains__, results.planned):
        failure = stored[job]
        has_no_time = failure.time is None or "into the run" in failure.reason
        time_text = "" if has_no_time else f", {1e3 * (failure.time or 0.0):.4g} ms into the run"
        explanation = f"{failure.reason}{time_text}" + (f" ({failure.advice})" if failure.advice else "")
        case = _case_text(swept, results.plan["units"], job, variations.get(job))
        failed.append(FailedJob(job, case, explanation, failure.command or "", failure.traceback))
    return failed


def _case_text(
    swept: Mapping[str, dict[str, Any]], units: Mapping[str, str], job: str, variation: dict[str, Any] | None
) -> str:
    """Describe a job by its swept values; a variation by those of its case and the varied value."""
    from bearingsim.plots.labels import format_quantity, swept_text
    from bearingsim.study.uncertainty import PARAMETER_KINDS

    if variation is None:
        return swept_text(swept[job], units)
    value = format_quantity(PARAMETER_KINDS[variation["what"]].range_text([variation["value"]]))
    return ", ".join(filter(None, [swept_text(swept[variation["of"]], units), f"{variation['what']} {value}"]))
