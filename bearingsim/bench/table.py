"""Runs of all scenes, distributed over processes and stored row by row; stored rows are not recomputed."""

import csv
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from bearingsim.bench import measure, outside
from bearingsim.bench.measure import COLUMNS, Row
from bearingsim.bench.plan import JOB, Run, Settings, kinds, runs
from bearingsim.bench.provenance import provenance
from bearingsim.bench.scene import Scene
from bearingsim.runner.pool import spread
from bearingsim.runner.progress import duration
from bearingsim.store import claim
from bearingsim.text.terminal import say

RUNS, ABOUT = "runs.csv", "provenance.json"
LINE_EVERY_S = 5.0
NUMBERS = ("step_s", "tolerance", "cpu_per_s", *measure.QUANTITIES, "chaotic", "period_passes")


def compute(
    scenes: Sequence[Scene],
    folder: Path,
    quick: bool = False,
    jobs: int = 1,
    others: Mapping[str, Settings] | None = None,
    left_out: dict[str, str] | None = None,
) -> list[Row]:
    """Compute the runs missing in ``folder``; return all rows of the scenes, in the order of the plan.

    others: by scene, solvers of other packages (``outside.SOLVERS``) at their settings; left_out: solvers
    not installed, with reasons. Reports progress on stderr. Finished rows survive an interruption.
    """
    claim(folder, "a chart", "bearingsim bench", "results/bench-chart-2")
    wanted = [run for scene in scenes for run in runs(scene, quick, (others or {}).get(scene.name))]
    path, began = folder / RUNS, (time.monotonic(), time.process_time())
    stored = read(path)
    todo = [run for run in wanted if run.key not in stored]
    if todo:
        _compile(todo, jobs)
        _append(path, todo, jobs)
        stored = read(path)
    about = provenance(left_out or {}) | {"runs": len(wanted), "computed": len(todo), "jobs": jobs, "quick": quick}
    about["wall_s"] = round(time.monotonic() - began[0], 1)
    if todo or not (folder / ABOUT).exists():
        (folder / ABOUT).write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    return [row for run in wanted for row in stored.get(run.key, [])]


def read(path: Path) -> dict[str, list[Row]]:
    """Read the rows of a file by the key of their run, without incomplete ones."""
    if not path.exists():
        return {}
    stored: dict[str, list[Row]] = {}
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if set(row) == set(COLUMNS) and all(value is not None for value in row.values()):
                stored.setdefault(row["key"], []).append(_with_numbers(row))
    return {key: rows for key, rows in stored.items() if len(rows) == _rows_of(rows[0])}


def _rows_of(leading: Row) -> int:
    """Return the number of rows of a run, given the first."""
    return 2 if leading["role"] == JOB and not leading["failure"] else 1


def _with_numbers(row: dict[str, str]) -> Row:
    return {name: (float(value or "nan") if name in NUMBERS else value) for name, value in row.items()}


def _append(path: Path, todo: Sequence[Run], jobs: int) -> None:
    """Compute runs, writing rows as runs finish."""
    new, done, began = not path.exists(), 0, time.monotonic()
    last = began
    with path.open("a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        if new:
            table.writeheader()
        elif not path.read_text(encoding="utf-8").endswith("\n"):
            file.write("\n")  # a previous run was stopped in the middle of a row
        try:
            for rows in spread(_rows, [(run, outside.SOLVERS.get(run.method)) for run in todo], jobs):
                table.writerows({name: _text(value) for name, value in row.items()} for row in rows)
                file.flush()
                done += 1
                if time.monotonic() - last > LINE_EVERY_S:
                    last = time.monotonic()
                    left = duration((last - began) * (len(todo) - done) / done)
                    say(f"{done}/{len(todo)} runs, about {left} left", err=True)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"interrupted: {path} has {done} of {len(todo)} runs; run it again") from None


def _rows(run: Run, solver: outside.Solver | None) -> list[Row]:
    """Call ``measure.rows`` in a process that may lack the run's solver."""
    if solver is not None:
        outside.SOLVERS.setdefault(run.method, solver)
    return measure.rows(run)


def _compile(todo: Sequence[Run], jobs: int) -> None:
    """Compile the code before timing, each model in one process."""
    groups = kinds(todo)
    say(f"compiling {len(groups)} models for {len(todo)} runs", err=True)
    for done, model in enumerate(spread(_ready, [(group, dict(outside.SOLVERS)) for group in groups], jobs), 1):
        say(f"ready, {done} of {len(groups)}: {model}", err=True)


def _ready(group: Sequence[Run], solvers: dict[str, outside.Solver]) -> str:
    outside.SOLVERS.update(solvers)
    return [measure.ready(run) for run in group][-1]


def _text(value: Any) -> Any:
    """Format numbers with seven digits."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.7g}"
    return value


def written(rows: Sequence[Row], path: Path) -> Path:
    """Write rows as a CSV file; return its path."""
    names = list(dict.fromkeys(chain.from_iterable(rows)))
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, names)
        table.writeheader()
        table.writerows(_texts(rows))
    return path


def _texts(rows: Sequence[Row]) -> Iterator[Row]:
    for row in rows:
        yield {name: _text(value) for name, value in row.items()}
