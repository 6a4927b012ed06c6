"""`bearingsim show`: jobs and failures as tables."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.cli.screen import needed_width, print_table, significant, terminal_width
from bearingsim.config.rules import damping
from bearingsim.errors import UserError
from bearingsim.runner.findings import repetitions
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

Column = tuple[str, list[str]]  # heading and cells
STATISTICS = ("velocity.rms", "outer_force.max")
MOST_ROWS = 1000
"""Largest number of printed rows; 100 000 rows take minutes."""
PROOF = ("step_error.line", "step_error.rms", "step_error.record", "chaotic")


def show_jobs(results: "Results", columns: Sequence[str], failed: bool, as_json: bool) -> None:
    """Print a row per job; columns: replace the usual ones. As JSON: all columns, in SI."""
    from bearingsim.runner.promises import withdrawals
    from bearingsim.store import job_frame

    table = results.table()
    rows = table[table["status"] == "failed"] if failed else table
    swept = list(results.plan["units"])
    features = usual_features(results, table)
    chosen = list(columns) or [*swept, *features, "status", "seconds"]
    _check(chosen, [str(name) for name in table])
    if as_json:
        requested = rows[["job", *chosen]] if columns else rows
        say(json.dumps([_plain(row) for row in requested.to_dict("records")], indent=1))
        return
    shown = rows[:MOST_ROWS]
    all_columns = [("job", [job[:8] for job in shown["job"]]), *(_column(results, shown, name) for name in chosen)]
    kept = all_columns if columns else _fitting(all_columns, [name in features for name in ["job", *chosen]])
    print_table([head for head, _ in kept], list(zip(*(cells for _, cells in kept), strict=True)))
    if len(shown) < len(rows):
        say(f"and {len(rows) - len(shown)} more jobs in results.csv (or use `--json`)")
    say(_counts(table) + _varied(results))
    for text in withdrawals(results.plan, job_frame(results.path)):
        say(text)
    info = results.info().reindex(table["job"])
    of_choices = (results.plan.get("accuracy") or {}).get("notes", ())
    assumed = results.plan.get("assumptions", ())
    for text in (*of_choices, *repetitions(info), *assumed, *damping.job_sentences(info)):
        say(text)
    if len(kept) < len(all_columns):
        heads = {_stacked(head) for head, _ in kept}
        left = ", ".join(head for head, _ in all_columns if _stacked(head) not in heads)
        count = len(all_columns) - len(kept)
        say(f"{count} columns too wide for the terminal: {left} (`--columns NAME`, `--json` or a pipe)")


UNVARIED = {"clearance": "0 um, 10 um", "bracket": "0.5, 2"}
"""Example values of uncertain quantities without an assumption text of their own."""


def show_assumptions(results: "Results") -> None:
    """Print a sentence for each assumption of a study, and the setting that varies it."""
    from bearingsim.runner.findings import assumed, findings
    from bearingsim.store import job_frame

    frame = job_frame(results.path)
    texts = [*assumed(results.plan, frame), *damping.job_sentences(results.info())]
    unvaried = [name for name in findings(results.plan, frame).assumed if name in UNVARIED]
    texts += [
        f"{name} has one value per case; to vary it: `uncertainty: {{{name}: [{UNVARIED[name]}]}}` varies it"
        for name in unvaried
    ]
    for text in texts or ["every uncertain parameter is varied"]:
        say(text)


def usual_features(results: "Results", table: "pd.DataFrame") -> list[str]:
    """List the default columns that have a value.

    Defect line, cage slip of models with slip, change from healthy, bands, statistics, errors.
    """
    from bearingsim.config.names import read_band
    from bearingsim.plots import lines

    parameters = results.parameters()
    shown = [f"velocity@{line}" for line in lines.fitting(parameters)]
    slip = ["cage.slip.mean"] if lines.may_slip(parameters) else []
    moved = [name for name in map(str, table) if name.startswith("error.")]
    banded = [name for name in map(str, table) if read_band(name) is not None]
    wanted = (*shown, *slip, *(f"{line}-healthy" for line in shown), *banded, *STATISTICS, *moved, *PROOF)
    present = [name for name in wanted if name in table and table[name].notna().any()]
    return [name for name in present if name != "chaotic" or (table[name] > 0.0).any()]


def _fitting(columns: list[Column], features: Sequence[bool]) -> list[Column]:
    """Select the columns that fit into the terminal: stack the headings, then drop features from the right."""
    if _fits(columns):
        return columns
    kept = [(_stacked(head), cells) for head, cells in columns]
    for column, feature in reversed(list(zip(list(kept), features, strict=True))):
        if _fits(kept):
            break
        if feature:
            kept.remove(column)
    return kept


def _fits(columns: Sequence[Column]) -> bool:
    width, whole = terminal_width(), [[head, *cells] for head, cells in columns]
    return width is None or needed_width([column[0] for column in whole], zip(*whole, strict=True)) <= width


def _stacked(head: str) -> str:
    """Break a heading into lines, before `.width` and `-healthy` and before the unit."""
    return re.sub(r"(?<=\w)(?=[.-][a-z])", "\n", head).replace(" (", "\n(")


def _check(chosen: Sequence[str], columns: Sequence[str]) -> None:
    from bearingsim.text.units import suggestion

    for name in chosen:
        if name not in columns:
            near = suggestion(name, columns)
            raise UserError(f"no column `{name}`" + (f" ({near})" if near else ""))


def _plain(row: Mapping[Any, Any]) -> dict[str, Any]:
    """Convert a row for JSON: null for missing and infinite values."""
    return {
        str(key): None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in row.items()
    }


def _varied(results: "Results") -> str:
    """Count the variations, and those without a result."""
    jobs = {entry["job"] for entry in results.variations} - set(results.table()["job"])
    lacking = len(jobs - set(results.info().index))
    return f", and {len(jobs)} variations{f' ({lacking} without a result)' * bool(lacking)}" if jobs else ""


def _counts(table: "pd.DataFrame") -> str:
    counts = table["status"].value_counts()
    return f"{len(table)} jobs: " + ", ".join(f"{count} {status}" for status, count in counts.items())


def _column(results: "Results", rows: "pd.DataFrame", name: str) -> Column:
    """Return heading and cells of a column, in the study's unit or a readable one."""
    from bearingsim.plots import labels

    units = results.plan["units"]
    if name in units:
        return name, ["" if _missing(v) else labels.value_text(name, v, units) for v in rows[name]]
    if rows[name].dtype.kind != "f":
        return name, [str(value) for value in rows[name]]
    largest = rows[name].abs().max()
    unit, factor = labels.feature_axis(name, float(largest)) if name != "seconds" else ("s", 1.0)
    cells = [significant(value * factor, 4) for value in rows[name]]
    return f"{name} ({unit})" if unit else name, cells


def _missing(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def show_failures(folder: Path, tracebacks: bool = False) -> None:
    """Print failed jobs with reason and advice, and the command that repeats them."""
    from bearingsim.plots.labels import described
    from bearingsim.store import open_results

    results = open_results(folder)
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    stored = results.failures()
    failures = {job: stored[job] for job in results.planned if job in stored}
    varied = {
        entry["job"]: f"{entry['what']} {entry['value']:.3g} (SI) of {entry['of']}" for entry in results.variations
    }
    for job, failure in islice(failures.items(), MOST_ROWS):
        say(f"{job}  {varied.get(job) or described(swept[job], results.plan['units'])}")
        timeless = failure.time is None or "into the run" in failure.reason
        when = "" if timeless else f", {1e3 * (failure.time or 0.0):.4g} ms into the run"
        say(f"    {failure.reason}{when}" + (f" ({failure.advice})" if failure.advice else ""))
        if tracebacks:
            say(failure.traceback)
    if len(failures) > MOST_ROWS:
        say(f"and {len(failures) - MOST_ROWS} more jobs, one file each in failed/")
    commands = dict.fromkeys(failure.command for failure in failures.values() if failure.command)
    say("\n".join(f"again: {command}" for command in commands) if failures else "no job failed")
