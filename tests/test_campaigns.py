"""Campaigns on random scenes with one record for all scenes: their tables, and what they print."""

import importlib
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim.config import Case
from bearingsim.simulation import simulate, time_grid
from bearingsim.simulation.record import Record

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SCENE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "static", "defect": SLOT}
ROWS = {"job_cost": (11, ""), "random_scenes": (3, "--scenes 3")}
"""Rows of the table of each benchmark, and arguments."""
LINES = ("BPFO", "BPFI", "2BSF")


@pytest.fixture(scope="module")
def record() -> Record:
    result = simulate(Case.model_validate(SCENE | {"duration": "80 ms"}))
    return replace(result, info=result.info | {"method": "verlet"}, features=result.features | {"chaotic": 0.0})


@pytest.fixture(autouse=True)
def limit_of_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_grid, "MAX_CPU", time_grid.MAX_CPU)  # restored after a benchmark that changes it


def in_this_process(*arguments: Any, **options: Any) -> Any:
    """Replace ``joblib.Parallel``."""
    return lambda tasks: [function(*values, **named) for function, values, named in tasks]


def run(monkeypatch: pytest.MonkeyPatch, name: str, arguments: str, **replaced: Any) -> None:
    """Run a benchmark in this process, with some of its functions replaced."""
    benchmark = importlib.import_module(f"benchmarks.{name}")
    monkeypatch.setattr(benchmark, "Parallel", in_this_process, raising=False)
    for function, replacement in replaced.items():
        monkeypatch.setattr(benchmark, function, replacement)
    monkeypatch.setattr(sys, "argv", [name, *arguments.split()])
    with suppress(SystemExit):  # its exit code depends on the results
        benchmark.main()


@pytest.mark.parametrize("name", ROWS)
def test_a_campaign_writes_a_row_for_each_scene(name, record, tmp_path: Path, monkeypatch):
    rows, arguments = ROWS[name]
    table = tmp_path / "table.csv"
    run(monkeypatch, name, f"{arguments} --csv {table}", simulate=lambda case: record)
    assert len(pd.read_csv(table)) == rows


def scaled(record: Record, factor: float, names: Iterable[str]) -> Record:
    """Multiply features of a record."""
    return replace(record, features=record.features | {name: factor * record.features[name] for name in names})


def test_a_stated_step_error_is_compared_with_the_change_by_an_eighth_of_the_step(record, monkeypatch, capsys):
    """Line, RMS and force are 2 % off the finer run; 4 %, 1 % and 4 % are stated."""
    quantities = (*(f"velocity@{line}" for line in LINES), "velocity.rms", "outer_force.max")
    stated = {"step_error.line": 0.04, "step_error.rms": 0.01, "step_error.force": 0.04}
    finer = replace(record, features=record.features | dict.fromkeys(quantities, 1.0) | stated)
    fractions: list[float] = []

    def run_finer(attempt: Any, usage: Any) -> Record:
        fractions.append(attempt.step_fraction / record.info["step_part"])
        return finer

    coarse = scaled(finer, 0.98, quantities)
    run(monkeypatch, "step_error", "--scenes 3", simulate=lambda case: coarse, _attempt_simulation=run_finer)
    assert fractions == [1 / 8] * 3
    printed = capsys.readouterr().out
    assert "3 scenes, 0 failed, 0 chaotic" in printed
    assert "line   within 3 of 3; ratio 0.50, 0.50, 0.50; change at most 0.02" in printed
    assert "rms    within 0 of 3; ratio 2.00, 2.00, 2.00; change at most 0.02" in printed
    assert "force  within 3 of 3; ratio 0.50" in printed
    assert "all within: 0 of 3" in printed


def test_an_early_stop_with_another_feature_than_the_full_record_is_wrong(record, monkeypatch, capsys):
    """Two of the six scenes stop at a period whose RMS is 1e-3 off."""
    periodic = {"period_passes": 1, "passes_computed": 5, "passes": 60}
    full = replace(record, info=record.info | periodic)
    short = {"rollers": scaled(full, 1.001, ("velocity.rms",))}
    run(
        monkeypatch,
        "repetition",
        "--ring 2 --rollers 2 --planar 2 --spatial 0",
        simulate=lambda case: short.get(case.model, full),
        full_record=lambda case: (full, 1.0 if case.model == "planar" else 0.0),
    )
    printed = capsys.readouterr().out
    passes = "passes 5 (max 5) of 60"
    assert f"ring     2 scenes (0 failed): 2 periodic, 2 of them stopped; 2 stopped, 0 wrong; {passes}" in printed
    assert f"rollers  2 scenes (0 failed): 2 periodic, 2 of them stopped; 2 stopped, 2 wrong; {passes}" in printed
    assert f"planar   2 scenes (0 failed): 0 periodic, 0 of them stopped; 2 stopped, 0 wrong; {passes}" in printed
    assert "worst 1.0e-03 (velocity.rms, scene 0)" in printed
    assert "spatial  0 scenes" in printed
