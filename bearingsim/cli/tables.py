"""`bearingsim show`: jobs and failures as tables."""

import json
import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.cli.screen import print_table, table_width, terminal_width
from bearingsim.config.rules import damping
from bearingsim.errors import UserError
from bearingsim.report.columns import Column, column_of, default_features, error_columns, main_features
from bearingsim.report.statements import assumption_texts, list_failures
from bearingsim.runner.findings import chaos_notes, periodicity_notes
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

DEFAULT_WIDTH = 80
"""Largest width (characters) of a table without a terminal; more needs `--all` or `--columns`."""
MAX_ROWS = 1000
"""Largest number of printed rows; 100 000 rows take minutes."""
MAX_NAMES = 6
"""Largest number of columns that a hint names."""
MAX_MEASURED_ROWS = 100
"""Largest number of printed rows of a comparison with measured values."""


def show_jobs(
    results: "Results", columns: Sequence[str], failed: bool, as_json: bool, every: bool = False
) -> None:
    """Print a row per job, as wide as the terminal or 80 characters. As JSON: all columns, in SI.

    columns: replace the default ones, at any width. every: all default columns, at any width in a pipe.
    """
    from bearingsim.runner.promises import empty_error_notes, withdrawals

    table = results.table()
    rows = table[table["status"] == "failed"] if failed else table
    swept = list(results.plan["units"])
    if every:
        features = default_features(results, table)
        default_names = [*swept, *features, "status", "seconds"]
    else:
        features, errors = main_features(results, table), error_columns(results, table)
        default_names = [*swept, *features, "status", *errors]
        features = [*features, *errors]
    names = [name for name in dict.fromkeys(columns) if name != "job"] if columns else default_names
    width = None if columns else terminal_width() or (None if every else DEFAULT_WIDTH)
    _check_columns(names, [str(name) for name in table])
    if as_json:
        json_rows = rows[["job", *names]] if columns else rows
        say(json.dumps([_json_row(row) for row in json_rows.to_dict("records")], indent=1))
        return
    printed_rows = rows[:MAX_ROWS]
    all_columns = [
        ("job", [job[:8] for job in printed_rows["job"]]),
        *(column_of(results, printed_rows, name) for name in names),
    ]
    printed_columns = _fit(all_columns, [name in features for name in ["job", *names]], width)
    print_table(
        [header for header, _ in printed_columns], list(zip(*(cells for _, cells in printed_columns), strict=True))
    )
    if len(printed_rows) < len(rows):
        _print_wrapped(f"and {len(rows) - len(printed_rows)} more jobs in results.csv (or use `--json`)")
    _print_wrapped(_status_counts(table) + _text_of_further_jobs(results))
    for text in (*withdrawals(results.plan, results.frame), *empty_error_notes(results.plan)):
        _print_wrapped(text)
    _print_measured(results)
    info = results.info().reindex(table["job"])
    choice_notes = (results.plan.get("accuracy") or {}).get("notes", ())
    assumptions = results.plan.get("assumptions", ())
    notes = (*chaos_notes(results.frame.loc[table["job"]]), *choice_notes, *periodicity_notes(info))
    for text in (*notes, *assumptions, *damping.result_remarks(info)):
        _print_wrapped(text)
    if len(printed_columns) < len(all_columns):
        printed_headers = {_stack_header(header) for header, _ in printed_columns}
        hidden = ", ".join(header for header, _ in all_columns if _stack_header(header) not in printed_headers)
        count = len(all_columns) - len(printed_columns)
        remedy = "`--columns NAME` or `--json`" if every else "`--all`, `--columns NAME` or `--json`"
        _print_wrapped(f"{count} columns do not fit {width} characters: {hidden} ({remedy})")


def show_measured(results: "Results", as_json: bool) -> None:
    """Print measured and simulated features; as JSON in SI. Raises UserError for a study without `measured`."""
    if not results.plan.get("measured"):
        raise UserError("the study has no `measured` section, so there is nothing to compare")
    if not as_json:
        _print_measured(results)
        return
    rows = [
        {
            "source": entry.label,
            "factor": entry.factor,
            "place": item.place,
            "feature": item.feature,
            "parameters": {**item.parameters, **item.others},
            "measured": entry.scaled(item.feature, item.measured),
            "simulated": item.simulated,
            "job": item.job or None,
        }
        for entry in results.measured
        for item in entry.comparisons
    ]
    say(json.dumps(rows, indent=1))


def _print_measured(results: "Results") -> None:
    """Print a table of measured and simulated features for each measured source of the study."""
    from bearingsim.report.measured import HEADERS, TEXT_COLUMNS, make_measured_tables

    for table in make_measured_tables(results, MAX_MEASURED_ROWS):
        say("")
        _print_wrapped(table.title)
        if table.rows:
            print_table(HEADERS, table.rows, text_columns=TEXT_COLUMNS)
        for text in table.remarks:
            _print_wrapped(text)


def _print_wrapped(text: str) -> None:
    """Print a text; on a terminal, broken between words into lines of its width."""
    width = terminal_width()
    if width is None:
        say(text)
        return
    for line in text.splitlines():
        for part in textwrap.wrap(line, width, break_long_words=False, break_on_hyphens=False):
            say(part)


def show_assumptions(results: "Results") -> None:
    """Print a sentence for each assumption of a study, and the setting that varies it."""
    for text in assumption_texts(results) or ["every uncertain parameter is varied"]:
        say(text)


def _fit(columns: list[Column], features: Sequence[bool], width: int | None) -> list[Column]:
    """Select the columns that fit a width (None: any): stack the headings, then drop features from the right."""
    if _fits(columns, width):
        return columns
    stacked = [(_stack_header(header), cells) for header, cells in columns]
    for column, feature in reversed(list(zip(list(stacked), features, strict=True))):
        if _fits(stacked, width):
            break
        if feature:
            stacked.remove(column)
    return stacked


def _fits(columns: Sequence[Column], width: int | None) -> bool:
    texts = [[header, *cells] for header, cells in columns]
    return width is None or table_width([column[0] for column in texts], zip(*texts, strict=True)) <= width


def _stack_header(header: str) -> str:
    """Break a heading into lines, before `.width` and `-healthy` and before the unit."""
    return re.sub(r"(?<=\w)(?=[.-][a-z])", "\n", header).replace(" (", "\n(")


def _check_columns(names: Sequence[str], columns: Sequence[str]) -> None:
    from bearingsim.store import ERROR_PARTS
    from bearingsim.text.units import suggestion

    accuracy_columns = {"error", *ERROR_PARTS}
    for name in names:
        if name not in columns:
            hint = "needs `accuracy` in the study" if name in accuracy_columns else suggestion(name, columns)
            hint = hint or _containing(name, columns) or "`--json` prints all columns"
            raise UserError(f"no column `{name}`" + (f" ({hint})" if hint else ""))


def _containing(word: str, columns: Sequence[str]) -> str:
    """Name the columns that contain a word; empty without one."""
    names = [f"`{name}`" for name in columns if word in name]
    more = ", ..." if len(names) > MAX_NAMES else ""
    return f"columns with this word: {', '.join(names[:MAX_NAMES])}{more}" if names else ""


def _json_row(row: Mapping[Any, Any]) -> dict[str, Any]:
    """Convert a row for JSON: null for missing and infinite values."""
    return {
        str(key): None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in row.items()
    }


def _text_of_further_jobs(results: "Results") -> str:
    """Count the variations and the audits, which have no rows, and those without a result."""
    done = set(results.info().index)
    variations = {entry["job"] for entry in results.variations} - set(results.jobs)
    kinds = {"variation": variations, "audit": set(results.planned) - set(results.jobs) - variations}
    text = ""
    for kind, jobs in kinds.items():
        missing = len(jobs - done)
        count = f"{len(jobs)} {kind}{'s' * (len(jobs) != 1)}"
        text += f", and {count}{f' ({missing} without a result)' * bool(missing)}" * bool(jobs)
    return text


def _status_counts(table: "pd.DataFrame") -> str:
    counts = table["status"].value_counts()
    jobs = f"{len(table)} job{'s' * (len(table) != 1)}"
    return f"{jobs}: " + ", ".join(f"{count} {status}" for status, count in counts.items())


def show_failures(folder: Path, tracebacks: bool = False) -> None:
    """Print failed jobs with reason and advice, and the command that repeats them."""
    from bearingsim.store import open_results

    failures = list_failures(open_results(folder))
    for failure in failures[:MAX_ROWS]:
        say(f"{failure.job}  {failure.case}")
        say(f"    {failure.explanation}")
        if tracebacks:
            say(failure.traceback)
    if len(failures) > MAX_ROWS:
        say(f"and {len(failures) - MAX_ROWS} more jobs, one file each in failed/")
    commands = dict.fromkeys(failure.command for failure in failures if failure.command)
    say("\n".join(f"again: {command}" for command in commands) if failures else "no job failed")
