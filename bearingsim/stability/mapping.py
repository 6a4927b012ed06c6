"""Computation of a whole stability map by several processes, with rows written as they are computed."""

import csv
import time
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from bearingsim import extensions
from bearingsim.runner.pool import map_in_new_processes, map_unordered
from bearingsim.runner.progress import duration
from bearingsim.stability.matrix import (
    Grid,
    Material,
    compile_cells,
    compute_rows,
    count_cells,
    materials,
    reference_methods,
)
from bearingsim.store import claim
from bearingsim.text.terminal import say

FILE_NAME = "stability.csv"
PROGRESS_INTERVAL_S = 5.0


def compute_map(models: Sequence[str], methods: Sequence[str], grid: Grid, folder: Path, jobs: int) -> Path:
    """Compute the map into a new ``folder``; return the CSV file.

    Progress is reported on stderr. Rows computed before an interruption are kept. Raises BrokenExtension, and the
    errors of ``store.claim``.
    """
    extensions.raise_if_broken()
    claim(folder, "a map", "bearingsim stability", "results/stability-2")
    path = folder / FILE_NAME
    _compile(models, methods, grid, jobs)
    tasks = [(material, methods, grid) for material in materials(models, grid)]
    total, done, start = count_cells(models, methods, grid), 0, time.monotonic()
    last_report = start
    with path.open("w", newline="", encoding="utf-8") as file:
        writer: csv.DictWriter | None = None
        try:
            for row in chain.from_iterable(
                map_unordered(compute_rows if jobs == 1 else _collect_rows, tasks, jobs)
            ):
                if writer is None:
                    writer = csv.DictWriter(file, list(row))
                    writer.writeheader()
                writer.writerow({name: _format(value) for name, value in row.items()})
                done += 1
                if time.monotonic() - last_report > PROGRESS_INTERVAL_S:
                    file.flush()
                    last_report = time.monotonic()
                    _report_progress(done, total, last_report - start)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"interrupted: {path} has {done} of {total} cells") from None
    return path


def _compile(models: Sequence[str], methods: Sequence[str], grid: Grid, jobs: int) -> None:
    """Compile all code before running cells, to keep compilation out of their CPU time.

    Each model is compiled by new processes: compiling all models takes 7 GB of memory in a single one.
    """
    solvers = (*methods, *reference_methods(methods))
    total, done = len(models) * len(solvers), 0
    say(f"compiling {total} pairs of model and method", err=True)
    for model in models:
        for method in map_in_new_processes(_compile_pair, [(model, method, grid) for method in solvers], jobs):
            done += 1
            say(f"compiled {done} of {total}: {model}, {method}", err=True)


def _compile_pair(model: str, method: str, grid: Grid) -> str:
    """Compile the code of a pair; return the name of the method, which the progress report needs."""
    compile_cells(model, method, grid)
    return method


def _collect_rows(material: Material, methods: Sequence[str], grid: Grid) -> list[dict[str, Any]]:
    """Collect the rows of ``compute_rows`` in a list, because a worker process cannot return a generator."""
    return list(compute_rows(material, methods, grid))


def _format(value: Any) -> Any:
    """Format a number with six digits, NaN as an empty string."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    return value


def _report_progress(done: int, total: int, elapsed: float) -> None:
    remaining = duration(elapsed * (total - done) / done)
    say(f"{done}/{total} cells, about {remaining} left", err=True)


def summary_rows(path: Path) -> Iterator[tuple[str, ...]]:
    """Yield the rows of a summary table of a map: model, method, and number of cells of each class."""
    import pandas as pd

    from bearingsim.stability.classification import CLASSES

    table = pd.read_csv(path)
    for (model, method), group in table.groupby(["model", "method"], sort=False):
        counts = group["class"].value_counts()
        yield (str(model), str(method), *(str(int(counts.get(name, 0))) for name in CLASSES))
