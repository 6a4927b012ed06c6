"""Campaigns on random scenes get to the end, and write their tables, with one record for all scenes."""

import importlib
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim.config import Case
from bearingsim.simulation import simulate, time_grid
from bearingsim.simulation.simulate import Record

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SCENE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "static", "defect": SLOT}
ARGUMENTS = {
    "job_cost": "",
    "random_scenes": "--scenes 3",
    "repetition": "--ring 2 --rollers 2 --planar 2 --spatial 2",
    "step_error": "--scenes 3 --each",
}
"""Arguments of each benchmark, apart from its table."""
ROWS = {"job_cost": 11, "random_scenes": 3}
"""Rows of the tables of those that write one."""


@pytest.fixture(scope="module")
def record() -> Record:
    return simulate(Case.model_validate(SCENE | {"duration": "80 ms"}))


def in_this_process(*arguments: Any, **options: Any) -> Any:
    """Replace ``joblib.Parallel``."""
    return lambda tasks: [function(*values, **named) for function, values, named in tasks]


@pytest.mark.parametrize("name", ARGUMENTS)
def test_a_campaign_gets_to_the_end(name, record, tmp_path: Path, monkeypatch, capsys):
    benchmark, table = importlib.import_module(f"benchmarks.{name}"), tmp_path / "table.csv"
    features = record.features | {"chaotic": 0.0}
    stand_in = replace(record, info=record.info | {"method": "verlet"}, features=features)
    monkeypatch.setattr(time_grid, "MAX_CPU", time_grid.MAX_CPU)  # which one of them changes
    monkeypatch.setattr(benchmark, "simulate", lambda case: stand_in)
    monkeypatch.setattr(benchmark, "_simulate", lambda attempt, usage: stand_in, raising=False)
    monkeypatch.setattr(benchmark, "full_record", lambda case: (stand_in, 0.0), raising=False)
    monkeypatch.setattr(benchmark, "Parallel", in_this_process, raising=False)
    arguments = ["--csv", str(table)] if name in ROWS else []
    monkeypatch.setattr(sys, "argv", [name, *ARGUMENTS[name].split(), *arguments])
    with suppress(SystemExit):  # its exit code depends on the results
        benchmark.main()
    assert len(pd.read_csv(table)) == ROWS[name] if name in ROWS else capsys.readouterr().out
