"""The chart's text: a table of what to take, and a section for each scene, made from its numbers."""

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
    by,
    chosen,
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
ASKED = [(of, within) for of in (("line",), QUANTITIES) for within in WITHIN]
"""Of what, how close: the columns of the first table."""
HEADS = ("scene", *(f"{'line' if len(of) == 1 else 'all three'} within {percent(within)}" for of, within in ASKED))
WIDTH = 138  # letters in a line
NOTABLE = 1.5  # times the cheapest run of a model that is as close: less is no news


class Part(NamedTuple):
    """A scene: its rows with their errors; duration of its record, s."""

    name: str
    title: str
    rows: Sequence[Row]
    duration: float


def figure_name(part: Part) -> str:
    """The file of a scene's chart."""
    return f"speed-accuracy-{part.name}.png"


def line_of(part: Part) -> tuple[str, ...]:
    """A scene's row of the table of verdicts."""
    return part.title, *(_cell(verdict(part.rows, within, of)) for of, within in ASKED)


def _cell(found: Verdict) -> str:
    if found.job is not None:
        return f"{found.job['variant']}, {seconds(found.job['cpu_per_s'])}"
    if found.point is not None:
        return f"{found.point['variant']} by {by(found.point)}, {seconds(found.point['cpu_per_s'])} in full"
    return "not to be told" if found.unknown else "none"


def write(parts: Sequence[Part], folder: Path) -> Path:
    """Write the text beside the figures; its path."""
    about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
    path = folder / NAME
    path.write_text("\n".join(lines(parts, about)) + "\n", encoding="utf-8")
    return path


def lines(parts: Sequence[Part], about: dict[str, Any]) -> Iterator[str]:
    """The text in Markdown. about: where the numbers come from."""
    how = Path(__file__).with_name("how_to_read.md").read_text(encoding="utf-8")
    yield from ("# Speed against accuracy", "", how.rstrip(), "", "## What to take", "")
    yield "The cheapest automatic choice that is so close, and its CPU seconds for a simulated second, as a job."
    yield "All three: the line, the RMS and the largest force at once."
    yield ""
    yield from _table(HEADS, [line_of(part) for part in parts])
    for part in parts:
        yield from ("", f"## {part.title}", "")
        yield f"![Error against CPU time: {part.title}]({figure_name(part)})"
        yield ""
        for told in (*why(part.rows), *_method(part), *_peers(part), *_remarks(part)):
            yield from wrap(
                f"- {told}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
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
    """Each model's automatic choice: what it comes to, its costs, and its total errors as a job."""
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
    """What to take for each quantity alone, and for all."""
    asked = [(WORDS[name], (name,)) for name in QUANTITIES] + [("all three", QUANTITIES)]
    return [(words, *(_cell(verdict(part.rows, within, of)) for within in WITHIN)) for words, of in asked]


def _method(part: Part) -> Iterator[str]:
    """Of the cheapest model within 1 % (or 5 %): how its automatic choice compares with its other runs in full."""
    named = [found.model for found in (verdict(part.rows, w) for w in reversed(WITHIN)) if found.model]
    for off in off_the_front(part.rows, NUMERICAL):
        if named and off.row["variant"] == named[0] and worst(off.row, NUMERICAL) < 1.0:
            which = f"of `{named[0]}` the automatic choice, {off.row['method']}"
            error = f"{percent(worst(off.row, NUMERICAL))} numerical error of the worst of the three"
            told = f"**Method, in full:** {which} ({seconds(off.row['cpu_per_s'])}, {error})"
            if off.times < NOTABLE:
                yield f"{told}, is near the front: nothing as close costs less by over {NOTABLE} times."
            else:
                yield f"{told}, is off the front: {by(off.cheapest)} is as close for {_cost(off.cheapest)}."


def _peers(part: Part) -> Iterator[str]:
    """The cheapest solver of another package within 1 % of its model, and the cheapest of our own runs there."""
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
        told = f"**Peers:** the cheapest within 1 % (numerical) of line and RMS is {by(best)}, {_cost(best)}"
        yield f"{told}; of our methods " + (f"{by(in_full)}, {_cost(in_full)}." if in_full else "none.")


def _cost(row: Row) -> str:
    return seconds(row["cpu_per_s"])


def _both(row: Row) -> float:
    """The larger numerical error of line and RMS: peers that do not show their steps have no largest force."""
    return worst(row, NUMERICAL, QUANTITIES[:2])


def _remarks(part: Part) -> Iterator[str]:
    """What else the reader of a chart must know: chaos, and what was refused."""
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
    """Provenance."""
    yield f"bearingsim {about['bearingsim']} ({about['commit']}), {about['date']}."
    yield f"{about['processor']}, {about['cores']} cores."
    packages = ", ".join(f"{name} {about[name]}" for name in ("python", "numpy", "numba", "scipy"))
    yield f"{packages[0].upper()}{packages[1:]}."
    yield f"{about['runs']} runs, {about['jobs']} at a time. CPU times are of the thread."
    yield "Other work on the machine makes them longer: compare within a scene."
    for name, reason in about["left_out"].items():
        yield f"Left out: {name} ({reason})."
