"""Runs of `bearingsim bench` that are counted instead of computed."""

from typing import Any

from bearingsim.bench import measure
from bearingsim.bench.measure import QUANTITIES
from bearingsim.bench.plan import AUTOMATIC, JOB, Plan, Setting

FEW_RUNS = Plan({"verlet": (Setting(step=1.0),)}, {"verlet": (Setting(step=0.25),)}, {})


def rows_of(run: Any) -> list[measure.Row]:
    """The rows of a run in which every number is 1."""
    row = measure._empty_row(run) | dict.fromkeys(QUANTITIES, 1.0) | {"cpu_per_s": 1.0}
    return [row, row | {"role": AUTOMATIC, "method": "verlet"}] if run.role == JOB else [row]
