"""Computation of a whole stability map over several processes, with rows written as they finish."""

import csv
import time
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from bearingsim import extensions
from bearingsim.runner.pool import spread
from bearingsim.runner.progress import duration
from bearingsim.stability.matrix import Grid, Material, count, judges, map_of, materials, warm
from bearingsim.store import claim
from bearingsim.text.terminal import say

NAME = "stability.csv"
LINE_EVERY_S = 5.0


def compute(models: Sequence[str], methods: Sequence[str], grid: Grid, folder: Path, jobs: int) -> Path:
    """Compute the map into a new ``folder``; return the CSV file.

    Reports progress on stderr. Finished rows survive an interruption. Raises BrokenExtension, and the errors of
    ``store.claim``.
    """
    extensions.refuse_broken()
    claim(folder, "a map", "bearingsim stability", "results/stability-2")
    path = folder / NAME
    _compile(models, methods, grid, jobs)
    units = [(unit, methods, grid) for unit in materials(models, grid)]
    total, done, began = count(models, methods, grid), 0, time.monotonic()
    last = began
    with path.open("w", newline="", encoding="utf-8") as file:
        table: csv.DictWriter | None = None
        try:
            for row in chain.from_iterable(spread(map_of if jobs == 1 else _whole, units, jobs)):
                if table is None:
                    table = csv.DictWriter(file, list(row))
                    table.writeheader()
                table.writerow({name: _text(value) for name, value in row.items()})
                done += 1
                if time.monotonic() - last > LINE_EVERY_S:
                    file.flush()
                    last = time.monotonic()
                    _tell(done, total, last - began)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"interrupted: {path} has {done} of {total} cells") from None
    return path


def _compile(models: Sequence[str], methods: Sequence[str], grid: Grid, jobs: int) -> None:
    """Compile all code before running cells, to keep compilation out of their CPU time."""
    units = [(model, method, grid) for model in models for method in (*methods, *judges(methods))]
    say(f"getting ready: {len(units)} pairs of model and method", err=True)
    for done, (model, method) in enumerate(spread(_warmed, units, jobs), 1):
        say(f"ready, {done} of {len(units)}: {model}, {method}", err=True)


def _warmed(model: str, method: str, grid: Grid) -> tuple[str, str]:
    warm(model, method, grid)
    return model, method


def _whole(unit: Material, methods: Sequence[str], grid: Grid) -> list[dict[str, Any]]:
    """Collect the rows of ``map_of``, since a worker process cannot return a generator."""
    return list(map_of(unit, methods, grid))


def _text(value: Any) -> Any:
    """Format numbers with six digits."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    return value


def _tell(done: int, total: int, elapsed: float) -> None:
    left = duration(elapsed * (total - done) / done)
    say(f"{done}/{total} cells, about {left} left", err=True)


def summary(path: Path) -> Iterator[tuple[str, ...]]:
    """Yield the rows of a table: model, method, and number of cells of each class."""
    import pandas as pd

    from bearingsim.stability.judge import CLASSES

    table = pd.read_csv(path)
    for (model, method), group in table.groupby(["model", "method"], sort=False):
        counts = group["class"].value_counts()
        yield (str(model), str(method), *(str(int(counts.get(name, 0))) for name in CLASSES))
