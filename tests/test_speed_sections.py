"""Each section of ``make bench`` runs, on few and short jobs; loops that are only timed are not compiled."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.speed import __main__ as bench
from benchmarks.speed import accuracy, compiling, first_run, friction, prices, start_up, steps, study
from benchmarks.speed.report import Section
from benchmarks.speed.timing import Measure, Task

SHORT = "30 ms"


def run_once(tasks: Mapping[str, Task], rounds: int) -> dict[str, Measure]:
    """Run each task once."""
    return {name: Measure(task(), 1.0, 0.0, 1) for name, task in tasks.items()}


def replace_names(monkeypatch: pytest.MonkeyPatch, module: Any, **values: Any) -> None:
    """Replace names of a section's module."""
    for name, value in values.items():
        monkeypatch.setattr(module, name, value)


def report_of(section: Callable[[Section], None]) -> Section:
    """Run a section."""
    report = Section()
    section(report)
    assert report.lines()
    json.dumps(report.to_json())
    return report


@pytest.fixture(autouse=True)
def without_turns(monkeypatch):
    for module in (steps, accuracy, study, prices):
        monkeypatch.setattr(module, "measure_in_turns", run_once)


@pytest.mark.slow
def test_steps(monkeypatch):
    replace_names(monkeypatch, steps, cpu_time=lambda *called: 1e-3, ROLLERS=(8, 16), SLICES=(6, 12))
    assert set(steps.MAX_RATIOS) == {row[0] for row in report_of(steps.section).tables[0][2]}


def test_peers(monkeypatch):
    def run(start: Any, method: Any, places: np.ndarray, instants: int, per: int = 1) -> accuracy.Result:
        return 1.0, np.arange(2.0 * instants).reshape(2, -1)

    monkeypatch.setattr(accuracy.Start, "run", run)
    replace_names(monkeypatch, accuracy.peers, solvers=lambda problem: [])
    replace_names(
        monkeypatch, accuracy, FIXED={"verlet": (42,)}, PLANAR_FIXED={"verlet": (6,)}, TOLERANCES=(1e-3,)
    )
    replace_names(monkeypatch, accuracy.peers, missing_peers=lambda: {"exudyn": "not tried"})
    assert {curve.scene for curve in report_of(accuracy.section).curves} == {"rollers", "planar"}


def test_study(monkeypatch):
    models: list[str] = []

    def phases_of(case: Any) -> dict[str, float]:
        models.append(case.model)
        return dict.fromkeys(study.PHASES, 1e-3)

    replace_names(
        monkeypatch, study, phases_of=phases_of, simulate=lambda case: None, peak_memory=lambda duration: 1e8
    )
    replace_names(
        monkeypatch, study, run_study=lambda model, duration, jobs, workers: jobs, JOB_COUNTS=(2, 3), SHARED_JOBS=2
    )
    report_of(study.section)
    assert models == [model for model in study.MODELS for _ in range(study.CASES_PER_MODEL)]


def test_study_is_computed_with_healthy_cases():
    assert study.run_study("ring", "10 ms", 2, workers=1) == 4


@pytest.mark.slow
def test_friction(monkeypatch):
    replace_names(monkeypatch, friction, LOADS=("300 N",), DURATION=SHORT)
    assert [len(rows) for _, _, rows in report_of(friction.section).tables] == [1, 1]


def test_start_up(monkeypatch):
    commands = {name: start_up.COMMANDS[name] for name in ("bearingsim --help", "bearingsim show")}
    replace_names(monkeypatch, start_up, COMMANDS=commands, MAX_CPU={"bearingsim show": 60.0}, ROUNDS=1)
    assert [target.met for target in report_of(start_up.section).targets] == [True]


def test_compiling(monkeypatch):
    original = compiling.process_time
    replace_names(
        monkeypatch, compiling, MAX_CPU={"static": 7.0}, process_time=lambda model, cache: original(model, {})
    )
    assert ("compile", "static") in report_of(compiling.section).prices


def test_first_run(monkeypatch):
    replace_names(monkeypatch, first_run, DEMO=(["freq", "nf308"],))
    assert report_of(first_run.section).tables


def test_prices(monkeypatch):
    replace_names(monkeypatch, prices, cpu_time=lambda *called: 1e-3, job_overhead=lambda: 1e-3)
    monkeypatch.setattr(prices.Steps, "__call__", lambda steps: 1e-3 * steps.count)
    assert ("evaluation", "rollers") in report_of(prices.section).prices


def test_report_is_written_after_each_section(monkeypatch, tmp_path: Path):
    def fail(report: Section) -> None:
        raise RuntimeError("no such case")

    monkeypatch.setattr(
        bench, "SECTIONS", {"one": lambda report: report.add_table("a", ["b"], [[1.0]]), "two": fail}
    )
    monkeypatch.setattr(sys, "argv", ["speed", "--out", str(tmp_path)])
    with pytest.raises(RuntimeError, match="no such case"):
        bench.main()
    assert list(json.loads((tmp_path / "bench.json").read_text())["sections"]) == ["one"]
