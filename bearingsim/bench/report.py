"""Text of the chart: a table of recommendations and a section per scene."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

from bearingsim.bench.errors import NUMERICAL, TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import AUTOMATIC, PEER, POINT
from bearingsim.bench.table import ABOUT
from bearingsim.bench.verdict import (
    WITHIN,
    WORDS,
    Verdict,
    automatic_rows,
    chosen,
    method_text,
    off_the_front,
    percent,
    seconds,
    verdict,
    why,
    worst,
)

CHOICES = (
    "automatic choice",
    "method",
    "step or tolerance",
    "repeats",
    "as a job",
    "in full",
    "line",
    "RMS",
    "force",
)
NAME = "speed-accuracy.md"
QUESTIONS = [(of, within) for of in (("line",), QUANTITIES) for within in WITHIN]
"""Quantities and accuracies of the columns of the first table."""
HEADS = (
    "scene",
    *(f"{'line' if len(of) == 1 else 'all three'} within {percent(within)}" for of, within in QUESTIONS),
)
WIDTH = 138  # characters in a line
NOTABLE = 1.5  # cost ratio to the cheapest run of equal accuracy, from which a choice is off the front


class Part(NamedTuple):
    """Scene of the report: rows with errors, and duration of its record (s)."""

    name: str
    title: str
    rows: Sequence[Row]
    duration: float


def figure_name(part: Part) -> str:
    """Return the file name of a scene's chart."""
    return f"speed-accuracy-{part.name}.png"


def line_of(part: Part) -> tuple[str, ...]:
    """Return a scene's row of the table of verdicts."""
    return part.title, *(_cell(verdict(part.rows, within, of)) for of, within in QUESTIONS)


def _cell(best: Verdict) -> str:
    if best.job is not None:
        return f"{best.job['variant']}, {seconds(best.job['cpu_per_s'])}"
    if best.point is not None:
        return f"{best.point['variant']} by {method_text(best.point)}, {seconds(best.point['cpu_per_s'])} in full"
    return "not to be told" if best.unknown else "none"


def write(parts: Sequence[Part], folder: Path) -> Path:
    """Write the text into the folder of the figures; return its path."""
    about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
    path = folder / NAME
    path.write_text("\n".join(lines(parts, about)) + "\n", encoding="utf-8")
    return path


def lines(parts: Sequence[Part], about: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of the text in Markdown. about: provenance of the numbers."""
    how = Path(__file__).with_name("how_to_read.md").read_text(encoding="utf-8")
    yield from ("# Speed against accuracy", "", how.rstrip(), "", "## What to take", "")
    yield "The cheapest automatic choice within the accuracy, and its CPU time per second of signal, as a job."
    yield "All three: the line, the RMS and the largest force at once."
    yield ""
    yield from _table(HEADS, [line_of(part) for part in parts])
    for part in parts:
        yield from ("", f"## {part.title}", "")
        yield f"![Error against CPU time: {part.title}]({figure_name(part)})"
        yield ""
        for sentence in (*why(part.rows), *_method(part), *_peers(part), *_remarks(part)):
            yield from wrap(
                f"- {sentence}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
            )
        yield ""
        yield from _table(CHOICES, _ladder(part))
        yield ""
        yield from _table(("asked of", *(f"within {percent(within)}" for within in WITHIN)), _taken(part))
    yield from ("", "## Where these numbers come from", "", *_origin(about))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield "|" + "---|" * len(heads)
    yield from (f"| {' | '.join(row)} |" for row in rows)


def _ladder(part: Part) -> list[tuple[str, ...]]:
    """List the automatic choice of each model with its costs and its total errors as a job."""
    full = {row["variant"]: row["cpu_per_s"] for row in part.rows if row["role"] == AUTOMATIC}
    return [
        (
            row["variant"],
            row["method"] or "none",
            chosen(row, part.rows),
            "yes" if row["period_passes"] > 0 else "no",
            seconds(row["cpu_per_s"]),
            seconds(full[row["variant"]]),
            *(percent(row[f"{TOTAL}.{name}"]) for name in QUANTITIES),
        )
        for row in automatic_rows(part.rows)
    ]


def _taken(part: Part) -> list[tuple[str, ...]]:
    """List the verdicts for each quantity alone, and for all."""
    questions = [(WORDS[name], (name,)) for name in QUANTITIES] + [("all three", QUANTITIES)]
    return [(words, *(_cell(verdict(part.rows, within, of)) for within in WITHIN)) for words, of in questions]


def _method(part: Part) -> Iterator[str]:
    """Compare the automatic choice of the cheapest model within 1 % (or 5 %) with its other runs in full."""
    named = [best.model for best in (verdict(part.rows, w) for w in reversed(WITHIN)) if best.model]
    for off in off_the_front(part.rows, NUMERICAL):
        if named and off.row["variant"] == named[0] and worst(off.row, NUMERICAL) < 1.0:
            which = f"of `{named[0]}` the automatic choice, {off.row['method']}"
            error = f"{percent(worst(off.row, NUMERICAL))} numerical error of the worst of the three"
            text = f"**Method, in full:** {which} ({seconds(off.row['cpu_per_s'])}, {error})"
            if off.times < NOTABLE:
                yield f"{text}, is near the front: nothing as close costs less by over {NOTABLE} times."
            else:
                cheaper = method_text(off.cheapest)
                yield f"{text}, is off the front: {cheaper} is as close for {_cost(off.cheapest)}."


def _peers(part: Part) -> Iterator[str]:
    """Describe the cheapest solver of another package within 1 % of its model, and the cheapest own run."""
    rows = [row for row in part.rows if not row["failure"]]
    peers = [row for row in rows if row["role"] == PEER]
    close = [row for row in peers if _both(row) <= WITHIN[-1]]
    if peers and not close:
        names = _words(sorted({row["method"] for row in peers}))
        yield f"**Peers:** none of {names} is within 1 % (numerical) of line and RMS."
    if close:
        best = min(close, key=lambda row: row["cpu_per_s"])
        own = [r for r in rows if r["variant"] == best["variant"] and r["role"] in (POINT, AUTOMATIC)]
        in_full = min((r for r in own if _both(r) <= WITHIN[-1]), key=lambda row: row["cpu_per_s"], default=None)
        text = (
            f"**Peers:** the cheapest within 1 % (numerical) of line and RMS is {method_text(best)}, {_cost(best)}"
        )
        yield f"{text}; of our methods " + (f"{method_text(in_full)}, {_cost(in_full)}." if in_full else "none.")


def _cost(row: Row) -> str:
    return seconds(row["cpu_per_s"])


def _both(row: Row) -> float:
    """Return the larger numerical error of line and RMS, since some peers have no largest force."""
    return worst(row, NUMERICAL, QUANTITIES[:2])


def _remarks(part: Part) -> Iterator[str]:
    """Describe chaotic models, record, reference and refused models."""
    chaotic = list(dict.fromkeys(row["variant"] for row in part.rows if row["chaotic"] == 1.0))
    if chaotic:
        yield (
            f"**Chaotic** in {_words(chaotic)}: no step holds the motion pass by pass. Errors count against the"
            " mean of all solutions, and what these scatter by is the floor."
        )
    judged = part.rows[0]
    floors = ", ".join(f"{percent(judged[f'{TOTAL}.{name}.floor'])} ({WORDS[name]})" for name in QUANTITIES)
    yield f"**The record** is {part.duration:g} s."
    yield f"**The reference** is `{judged['variant']}`, by {judged['against']}, which lie apart by {floors}."
    refused = [row for row in part.rows if row["failure"] and row["role"] == "job"]
    if refused:
        yield f"**Cannot do this:** {_words([row['variant'] for row in refused])}."


def _words(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _origin(about: dict[str, Any]) -> Iterator[str]:
    """Describe the provenance."""
    yield f"bearingsim {about['bearingsim']} ({about['commit']}), {about['date']}."
    yield f"{about['processor']}, {about['cores']} cores."
    packages = ", ".join(f"{name} {about[name]}" for name in ("python", "numpy", "numba", "scipy"))
    yield f"{packages[0].upper()}{packages[1:]}."
    yield f"{about['runs']} runs, {about['jobs']} at a time. CPU times are of the thread."
    yield "Other work on the machine makes them longer: compare within a scene."
    for name, reason in about["left_out"].items():
        yield f"Left out: {name} ({reason})."
