"""Runs of all scenes, distributed over processes and stored row by row; stored rows are not recomputed."""

import csv
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from bearingsim.bench import external, measure
from bearingsim.bench.measure import COLUMNS, Row
from bearingsim.bench.plan import JOB, Run, Settings, group_by_model, plan_runs
from bearingsim.bench.provenance import collect_provenance
from bearingsim.bench.scene import Scene
from bearingsim.runner.pool import map_in_new_processes, map_unordered
from bearingsim.runner.progress import duration
from bearingsim.store import claim
from bearingsim.text.terminal import say

RUNS_FILE, PROVENANCE_FILE = "runs.csv", "provenance.json"
PROGRESS_INTERVAL_S = 5.0
NUMERIC_COLUMNS = ("step_s", "tolerance", "cpu_per_s", *measure.QUANTITIES, "chaotic", "period_passes")


def compute(
    scenes: Sequence[Scene],
    folder: Path,
    quick: bool = False,
    jobs: int = 1,
    peers: Mapping[str, Settings] | None = None,
    missing_peers: dict[str, str] | None = None,
) -> list[Row]:
    """Compute the runs missing in ``folder``; return all rows of the scenes, in the order of the plan.

    peers: by scene, solvers of other packages (``external.SOLVERS``) at their settings; missing_peers: those
    not installed, with reasons. Reports progress on stderr. Finished rows survive an interruption.
    """
    claim(folder, "a chart", "bearingsim bench", "results/bench-chart-2")
    planned_runs = [run for scene in scenes for run in plan_runs(scene, quick, (peers or {}).get(scene.name))]
    path, start = folder / RUNS_FILE, (time.monotonic(), time.process_time())
    _drop_incomplete_line(path)
    stored = read(path)
    missing_runs = [run for run in planned_runs if run.key not in stored]
    if missing_runs:
        _compile(missing_runs, jobs)
        _append_rows(path, missing_runs, jobs)
        stored = read(path)
    entries = collect_provenance(missing_peers or {}) | {
        "runs": len(planned_runs),
        "computed": len(missing_runs),
        "jobs": jobs,
        "quick": quick,
    }
    entries["wall_s"] = round(time.monotonic() - start[0], 1)
    if missing_runs or not (folder / PROVENANCE_FILE).exists():
        (folder / PROVENANCE_FILE).write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    return [row for run in planned_runs for row in stored.get(run.key, [])]


def read(path: Path) -> dict[str, list[Row]]:
    """Read the rows of a file by the key of their run, without incomplete ones.

    Of a run that is stored twice, because its rows were incomplete, the last row of each role counts.
    """
    if not path.exists():
        return {}
    stored: dict[str, dict[str, Row]] = {}  # by key and role
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if set(row) == set(COLUMNS) and all(value is not None for value in row.values()):
                stored.setdefault(row["key"], {})[row["role"]] = _parse_row(row)
    runs_rows = {key: list(rows.values()) for key, rows in stored.items()}
    return {key: rows for key, rows in runs_rows.items() if len(rows) == _row_count(rows[0])}


def _row_count(leading_row: Row) -> int:
    """Return the number of rows of a run, given the first."""
    return 2 if leading_row["role"] == JOB and not leading_row["failure"] else 1


def _parse_row(row: dict[str, str]) -> Row:
    return {name: (float(value or "nan") if name in NUMERIC_COLUMNS else value) for name, value in row.items()}


def _append_rows(path: Path, missing_runs: Sequence[Run], jobs: int) -> None:
    """Compute runs, writing rows as runs finish."""
    is_new, done, start = not path.exists() or path.stat().st_size == 0, 0, time.monotonic()
    last_report = start
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if is_new:
            writer.writeheader()
        try:
            for rows in map_unordered(
                _rows_in_worker, [(run, external.SOLVERS.get(run.method)) for run in missing_runs], jobs
            ):
                writer.writerows({name: _format(value) for name, value in row.items()} for row in rows)
                file.flush()
                done += 1
                if time.monotonic() - last_report > PROGRESS_INTERVAL_S:
                    last_report = time.monotonic()
                    time_left = duration((last_report - start) * (len(missing_runs) - done) / done)
                    say(f"{done}/{len(missing_runs)} runs, about {time_left} left", err=True)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted: {path} has {done} of {len(missing_runs)} runs; repeat the command"
            ) from None


def _drop_incomplete_line(path: Path) -> None:
    """Remove an incomplete last row, which an interrupted run leaves.

    If it contains an opening quotation mark, the rows appended to it would be read as its text.
    """
    content = path.read_bytes() if path.exists() else b""
    if not content.endswith(b"\n") and content:
        path.write_bytes(content[: content.rfind(b"\n") + 1])


def _rows_in_worker(run: Run, solver: external.Solver | None) -> list[Row]:
    """Call ``measure.compute_rows`` in a process that may lack the run's solver."""
    if solver is not None:
        external.SOLVERS.setdefault(run.method, solver)
    return measure.compute_rows(run)


def _compile(missing_runs: Sequence[Run], jobs: int) -> None:
    """Compile the code before timing, in new processes: only their end frees the memory of the compiler."""
    groups = group_by_model(missing_runs)
    say(f"compiling {len(groups)} models for {len(missing_runs)} runs", err=True)
    tasks = [(group, dict(external.SOLVERS)) for group in groups]
    for done, model in enumerate(map_in_new_processes(_compile_group, tasks, jobs), 1):
        say(f"compiled {done} of {len(groups)}: {model}", err=True)


def _compile_group(group: Sequence[Run], solvers: dict[str, external.Solver]) -> str:
    external.SOLVERS.update(solvers)
    return [measure.compile_run(run) for run in group][-1]


def _format(value: Any) -> Any:
    """Format numbers with seven digits."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.7g}"
    return value


def write_csv(rows: Sequence[Row], path: Path) -> Path:
    """Write rows as a CSV file; return its path."""
    names = list(dict.fromkeys(chain.from_iterable(rows)))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(_formatted_rows(rows))
    return path


def _formatted_rows(rows: Sequence[Row]) -> Iterator[Row]:
    for row in rows:
        yield {name: _format(value) for name, value in row.items()}
