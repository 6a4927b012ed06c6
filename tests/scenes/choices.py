"""Studies that choose models with trials of known numbers, and what their folders contain."""

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim import store
from bearingsim.runner import RunSummary, run
from bearingsim.study import Study
from tests.scenes.study_text import Write
from tests.scenes.trials import ENGINE, LOG, TEXT, accuracy_study

RIGID = "rig: {ring: {bends: false}}\n"


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the log of the calls of the engine."""
    path = tmp_path / "log"
    path.touch()
    monkeypatch.setenv(LOG, str(path))
    return path


def compute(study: Study, out: Path, **options: Any) -> RunSummary:
    defaults: dict[str, Any] = {"jobs": 1, "progress": False, "engine": ENGINE}
    return run(study, out, **defaults | options)


def take_lines(log: Path) -> list[str]:
    lines = log.read_text().splitlines()
    log.write_text("")
    return lines


def count_trials(log: Path) -> int:
    return sum(line.startswith("try") for line in take_lines(log))


def read_choices(out: Path) -> dict[str, Any]:
    choices: dict[str, Any] = json.loads((out / "choices.json").read_text())["choices"]
    return choices


def read_results(out: Path) -> pd.DataFrame:
    """Read the table, without the columns that differ between runs."""
    return pd.read_csv(out / "results.csv").drop(columns=["seconds", "unit"])


LOADS = "150 N, 300 N, 450 N"


def make_extended(write: Write, loads: str) -> Study:
    return accuracy_study(write, TEXT.replace(LOADS, loads))


def plan_notes(out: Path) -> list[str]:
    notes: list[str] = store.read_plan(out)["accuracy"]["notes"]
    return notes


def model_errors(out: Path) -> dict[float, float]:
    """Return the error of the model of each case by load."""
    table = store.open_results(out).table()
    cases = table[table["healthy"] != ""]
    return dict(zip(cases["load"], cases["error.model"], strict=True))
