"""`bearingsim show`: jobs and failures as tables."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bearingsim.cli.screen import needed_width, print_table, significant, terminal_width
from bearingsim.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

__all__ = ["show_failures", "show_jobs"]

Column = tuple[str, list[str]]  # head and cells
FEATURES = ("velocity@BPFO", "velocity@BPFO-healthy", "velocity.rms", "outer_force.max")


def show_jobs(results: "Results", columns: Sequence[str], failed: bool, as_json: bool) -> None:
    """Print a row per job; columns: instead of the usual ones. As JSON: all of them, in SI."""
    table = results.table()
    rows = table[table["status"] == "failed"] if failed else table
    swept = list(results.plan["units"])
    chosen = list(columns) or [*swept, *(name for name in FEATURES if name in table), "status", "seconds"]
    _check(chosen, [str(name) for name in table])
    if as_json:
        asked = rows[["job", *chosen]] if columns else rows
        typer.echo(json.dumps([_plain(row) for row in asked.to_dict("records")], indent=1))
        return
    found = [("job", [job[:8] for job in rows["job"]]), *(_column(results, rows, name) for name in chosen)]
    kept = found if columns else _fitting(found, [name in FEATURES for name in ["job", *chosen]])
    print_table([head for head, _ in kept], list(zip(*(cells for _, cells in kept), strict=True)))
    typer.echo(_counts(table))
    if len(kept) < len(found):
        left = ", ".join(head for head, _ in found if head not in dict(kept))
        count = len(found) - len(kept)
        typer.echo(f"{count} columns too wide for the terminal: {left} (`--columns NAME`, `--json` or a pipe)")


def _fitting(found: list[Column], features: Sequence[bool]) -> list[Column]:
    """The columns that fit into the terminal: features are left out from the right, nothing else is."""
    width = terminal_width()
    kept = [head for head, _ in found]
    for (head, _), feature in reversed(list(zip(found, features, strict=True))):
        columns = [[name, *cells] for name, cells in found if name in kept]
        if width is None or needed_width([column[0] for column in columns], zip(*columns, strict=True)) <= width:
            break
        if feature:
            kept.remove(head)
    return [column for column in found if column[0] in kept]


def _check(chosen: Sequence[str], known: Sequence[str]) -> None:
    from bearingsim.units import suggestion

    for name in chosen:
        if name not in known:
            near = suggestion(name, known)
            raise UserError(f"no column `{name}`" + (f" ({near})" if near else ""))


def _plain(row: Mapping[Any, Any]) -> dict[str, Any]:
    """A row for JSON: null for what is not there."""
    return {
        str(key): None if isinstance(value, float) and math.isnan(value) else value for key, value in row.items()
    }


def _counts(table: "pd.DataFrame") -> str:
    counts = table["status"].value_counts()
    return f"{len(table)} jobs: " + ", ".join(f"{count} {status}" for status, count in counts.items())


def _column(results: "Results", rows: "pd.DataFrame", name: str) -> Column:
    """Head and cells of a column, in the study's unit or a readable one."""
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
    """Print failed jobs with reason and advice, and the command that tries them again."""
    from bearingsim.plots.labels import described
    from bearingsim.store import open_results

    results = open_results(folder)
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    known = results.failures()
    failures = {job: known[job] for job in results.jobs if job in known}
    for job, failure in failures.items():
        typer.echo(f"{job}  {described(swept[job], results.plan['units'])}")
        when = f", {1e3 * failure.time:.4g} ms into the run" if failure.time is not None else ""
        typer.echo(f"    {failure.reason}{when}" + (f" ({failure.advice})" if failure.advice else ""))
        if tracebacks:
            typer.echo(failure.traceback)
    commands = dict.fromkeys(failure.command for failure in failures.values())
    typer.echo("\n".join(f"again: {command}" for command in commands) or "no job failed")
