"""Text of the chart: a table of recommendations and a section per scene."""

import json
from collections.abc import Iterator, Sequence
from math import isfinite
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

from bearingsim.bench.errors import NUMERICAL, TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import AUTOMATIC, PEER, POINT
from bearingsim.bench.table import PROVENANCE_FILE
from bearingsim.bench.verdict import (
    ACCURACIES,
    QUANTITY_NAMES,
    Verdict,
    automatic_rows,
    coarse_floor,
    compare_with_front,
    method_text,
    percent,
    seconds,
    step_text,
    verdict,
    verdict_texts,
    worst_error,
)

CHOICE_HEADERS = (
    "automatic choice",
    "method",
    "step or tolerance",
    "periodic",
    "as a job",
    "full integration",
    "line",
    "RMS",
    "force",
)
FILE_NAME = "speed-accuracy.md"
QUESTIONS = [(quantities, accuracy) for quantities in (("line",), QUANTITIES) for accuracy in ACCURACIES]
"""Quantities and accuracies of the columns of the first table."""
HEADERS = (
    "scene",
    *(
        f"{'line' if len(quantities) == 1 else 'all three'} within {percent(accuracy)}"
        for quantities, accuracy in QUESTIONS
    ),
)
LINE_AND_RMS = QUANTITIES[:2]
WIDTH = 138  # characters in a line
NOTABLE_COST_RATIO = 1.5
"""Ratio of the cost of a choice to that of the cheapest run of equal accuracy, from which the text reports it."""


class Section(NamedTuple):
    """Scene of the report: rows with errors, and duration of its record (s)."""

    name: str
    title: str
    rows: Sequence[Row]
    duration: float


def figure_name(section: Section) -> str:
    """Return the file name of a scene's chart."""
    return f"speed-accuracy-{section.name}.png"


def summary_row(section: Section) -> tuple[str, ...]:
    """Return a scene's row of the table of verdicts."""
    return section.title, *(
        _cell(verdict(section.rows, accuracy, quantities)) for quantities, accuracy in QUESTIONS
    )


def _cell(best: Verdict) -> str:
    if best.job is not None:
        return f"{best.job['variant']}, {seconds(best.job['cpu_per_s'])}"
    if best.point is not None:
        cost = f"{seconds(best.point['cpu_per_s'])} (full integration)"
        return f"{best.point['variant']} by {method_text(best.point)}, {cost}"
    return "unknown" if best.unknown else "none"


def write(sections: Sequence[Section], folder: Path) -> Path:
    """Write the text into the folder of the figures; return its path."""
    provenance = json.loads((folder / PROVENANCE_FILE).read_text(encoding="utf-8"))
    path = folder / FILE_NAME
    path.write_text("\n".join(markdown_lines(sections, provenance)) + "\n", encoding="utf-8")
    return path


def markdown_lines(sections: Sequence[Section], provenance: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of the text in Markdown. provenance: that of the numbers."""
    instructions = Path(__file__).with_name("how_to_read.md").read_text(encoding="utf-8")
    yield from ("# Speed against accuracy", "", instructions.rstrip(), "", "## Recommendations", "")
    yield "The cheapest automatic choice within the accuracy, and its CPU time per second of signal, as a job."
    yield "All three: the line, the RMS and the largest force at once."
    yield ""
    yield from _table(HEADERS, [summary_row(section) for section in sections])
    for section in sections:
        yield from ("", f"## {section.title}", "")
        yield f"![Error against CPU time: {section.title}]({figure_name(section)})"
        yield ""
        for sentence in (
            *verdict_texts(section.rows),
            *_method_texts(section),
            *_peer_texts(section),
            *_remarks(section),
        ):
            yield from wrap(
                f"- {sentence}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
            )
        yield ""
        yield from _table(CHOICE_HEADERS, _choice_rows(section))
        yield ""
        yield from _table(
            ("quantity", *(f"within {percent(accuracy)}" for accuracy in ACCURACIES)), _verdict_rows(section)
        )
    yield from ("", "## Where these numbers come from", "", *_provenance_lines(provenance))


def _table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(headers)} |"
    yield "|" + "---|" * len(headers)
    yield from (f"| {' | '.join(row)} |" for row in rows)


def _choice_rows(section: Section) -> list[tuple[str, ...]]:
    """List the automatic choice of each model with its costs and its total errors as a job."""
    full_cost = {row["variant"]: row["cpu_per_s"] for row in section.rows if row["role"] == AUTOMATIC}
    return [
        (
            row["variant"],
            row["method"] or "none",
            step_text(row, section.rows),
            "yes" if row["period_passes"] > 0 else "no",
            seconds(row["cpu_per_s"]),
            seconds(full_cost[row["variant"]]),
            *(percent(row[f"{TOTAL}.{name}"]) for name in QUANTITIES),
        )
        for row in automatic_rows(section.rows)
    ]


def _verdict_rows(section: Section) -> list[tuple[str, ...]]:
    """List the verdicts for each quantity alone, and for all."""
    questions = [(QUANTITY_NAMES[name], (name,)) for name in QUANTITIES] + [("all three", QUANTITIES)]
    return [
        (words, *(_cell(verdict(section.rows, accuracy, quantities)) for accuracy in ACCURACIES))
        for words, quantities in questions
    ]


def _method_texts(section: Section) -> Iterator[str]:
    """Compare the automatic choice of the cheapest model within 1 % (or 5 %) with its other full integrations."""
    models = [
        best.model for best in (verdict(section.rows, accuracy) for accuracy in reversed(ACCURACIES)) if best.model
    ]
    for comparison in compare_with_front(section.rows, NUMERICAL):
        if models and comparison.row["variant"] == models[0] and worst_error(comparison.row, NUMERICAL) < 1.0:
            choice = f"of `{models[0]}` the automatic choice, {comparison.row['method']}"
            error = f"{percent(worst_error(comparison.row, NUMERICAL))} largest numerical error of the three"
            text = f"**Method, full integration:** {choice} ({seconds(comparison.row['cpu_per_s'])}, {error})"
            if comparison.cost_ratio < NOTABLE_COST_RATIO:
                ratio = f"over {NOTABLE_COST_RATIO} times cheaper"
                yield f"{text}, is near the Pareto front: no run as accurate is {ratio}."
            else:
                cheaper = method_text(comparison.cheapest)
                cost = _cost(comparison.cheapest)
                yield f"{text}, is not on the Pareto front: {cheaper} is as accurate for {cost}."


def _peer_texts(section: Section) -> Iterator[str]:
    """Describe the cheapest solver of another package within 1 % of its model, and the cheapest own run."""
    rows = [row for row in section.rows if not row["failure"]]
    peers = [row for row in rows if row["role"] == PEER]
    accurate = [row for row in peers if _line_and_rms_error(row) <= ACCURACIES[-1]]
    floors = {name: max((row[f"{NUMERICAL}.{name}.floor"] for row in peers), default=0.0) for name in LINE_AND_RMS}
    unknown = coarse_floor(floors, ACCURACIES[-1], "the model's")
    if unknown:
        yield f"**Other packages:** unknown: {unknown}."
    elif peers and not accurate:
        methods = _quote(sorted({row["method"] for row in peers}))
        yield f"**Other packages:** none of {methods} is within 1 % (numerical) of line and RMS."
    if accurate:
        best = min(accurate, key=lambda row: row["cpu_per_s"])
        own_rows = [r for r in rows if r["variant"] == best["variant"] and r["role"] in (POINT, AUTOMATIC)]
        cheapest_own = min(
            (r for r in own_rows if _line_and_rms_error(r) <= ACCURACIES[-1]),
            key=lambda row: row["cpu_per_s"],
            default=None,
        )
        text = f"the cheapest within 1 % (numerical) of line and RMS is {method_text(best)}, {_cost(best)}"
        yield f"**Other packages:** {text}; of the methods of bearingsim " + (
            f"{method_text(cheapest_own)}, {_cost(cheapest_own)}." if cheapest_own else "none."
        )


def _cost(row: Row) -> str:
    return seconds(row["cpu_per_s"])


def _line_and_rms_error(row: Row) -> float:
    """Return the larger numerical error of line and RMS, since some peers have no largest force."""
    return worst_error(row, NUMERICAL, LINE_AND_RMS)


def _remarks(section: Section) -> Iterator[str]:
    """Describe chaotic models, record, reference and refused models."""
    chaotic = list(dict.fromkeys(row["variant"] for row in section.rows if row["chaotic"] == 1.0))
    if chaotic:
        yield (
            f"**Chaotic** in {_quote(chaotic)}: no step reproduces the motion pass by pass. Errors are relative to"
            " the mean of all solutions; their scatter is the floor."
        )
    reference = section.rows[0]
    floors = ", ".join(
        f"{percent(reference[f'{TOTAL}.{name}.floor'])} ({QUANTITY_NAMES[name]})" for name in QUANTITIES
    )
    yield f"**The record** is {section.duration:g} s."
    text = f"**The reference** is `{reference['variant']}`"
    if not reference["against"]:
        yield f"{text}, of which there is no solution."
    elif isfinite(reference[f"{TOTAL}.{QUANTITIES[0]}.floor"]):
        yield f"{text}, by {reference['against']}, which differ by {floors}."
    else:
        yield f"{text}, by {reference['against']}, which no second solution confirms."
    refused = [row for row in section.rows if row["failure"] and row["role"] == "job"]
    if refused:
        yield f"**Not possible:** {_quote([row['variant'] for row in refused])}."


def _quote(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _provenance_lines(provenance: dict[str, Any]) -> Iterator[str]:
    """Describe the provenance."""
    yield f"bearingsim {provenance['bearingsim']} ({provenance['commit']}), {provenance['date']}."
    yield f"{provenance['processor']}, {provenance['cores']} cores."
    packages = ", ".join(f"{name} {provenance[name]}" for name in ("python", "numpy", "numba", "scipy"))
    yield f"{packages[0].upper()}{packages[1:]}."
    yield f"{provenance['runs']} runs, {provenance['jobs']} at a time. CPU times are of the thread."
    yield "Other processes on the machine increase them: compare within a scene."
    for name, reason in provenance["left_out"].items():
        yield f"Skipped: {name} ({reason})."
