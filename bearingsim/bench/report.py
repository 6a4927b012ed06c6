"""The chart's text: a table of what to take, and a section for each scene, made from its numbers."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

from bearingsim.bench.errors import NUMERICAL, TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import PEER
from bearingsim.bench.table import ABOUT
from bearingsim.bench.verdict import (
    WITHIN,
    WORDS,
    Verdict,
    automatic_rows,
    by,
    off_the_front,
    percent,
    seconds,
    verdict,
    why,
    worst,
)

NAME = "speed-accuracy.md"
HEADS = ("scene", *(f"least within {percent(within)}" for within in WITHIN))
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
    return part.title, *(_cell(verdict(part.rows, within)) for within in WITHIN)


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
    yield "CPU seconds for a simulated second, of a job as a user gets it, where nothing else is said."
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
        yield from _table(("automatic choice", "method", "as a job", "line", "RMS", "force"), _ladder(part))
    yield from ("", "## Where these numbers come from", "", *_origin(about))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield "|" + "---|" * len(heads)
    yield from (f"| {' | '.join(row)} |" for row in rows)


def _ladder(part: Part) -> list[tuple[str, ...]]:
    """Each model's automatic choice as a job: its cost and total errors."""
    return [
        (
            row["variant"],
            row["method"] or "none",
            seconds(row["cpu_per_s"]),
            *(percent(row[f"{TOTAL}.{name}"]) for name in QUANTITIES),
        )
        for row in automatic_rows(part.rows)
    ]


def _method(part: Part) -> Iterator[str]:
    """Of the least model within 1 % (or 5 %): how its automatic choice compares with its other runs in full."""
    named = [found.model for found in (verdict(part.rows, w) for w in reversed(WITHIN)) if found.model]
    for off in off_the_front(part.rows, NUMERICAL):
        if named and off.row["variant"] == named[0] and worst(off.row, NUMERICAL) < 1.0:
            chosen = f"of `{named[0]}` the automatic choice, {off.row['method']}"
            took = f"{seconds(off.row['cpu_per_s'])}, {percent(worst(off.row, NUMERICAL))} numerical error"
            if off.times < NOTABLE:
                yield f"**Method, in full:** {chosen} ({took}), is near the front."
            else:
                yield (
                    f"**Method, in full:** {chosen} ({took}), is off the front: {by(off.cheapest)} is as close for"
                    f" {seconds(off.cheapest['cpu_per_s'])}."
                )


def _peers(part: Part) -> Iterator[str]:
    """The cheapest solver of another package within 1 % of its model, and the cheapest of our own runs there."""
    rows = [row for row in part.rows if not row["failure"]]
    known = [row for row in rows if row["role"] == PEER and _both(row) <= WITHIN[-1]]
    if known:
        best = min(known, key=lambda row: row["cpu_per_s"])
        own = [r for r in rows if r["variant"] == best["variant"] and r["role"] != PEER and _both(r) <= WITHIN[-1]]
        in_full = [row["cpu_per_s"] for row in own if row["role"] != "job"]
        if in_full:
            yield (
                f"**Peers:** the cheapest within 1 % (numerical) of line and RMS is {by(best)},"
                f" {seconds(best['cpu_per_s'])}; of our methods {seconds(min(in_full))}."
            )


def _both(row: Row) -> float:
    """The larger numerical error of line and RMS: peers that do not show their steps have no largest force."""
    errors = [row[f"{NUMERICAL}.{name}"] for name in QUANTITIES[:2]]
    return max(errors) if all(error == error for error in errors) else float("inf")


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
