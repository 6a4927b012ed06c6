"""A new study through every stage, up to figures and tables; `make smoke-lowest` uses the lowest versions."""

import sys
from pathlib import Path

import pandas as pd

from bearingsim.cli.app import app
from tests.scenes.commands import type_


def test_a_new_study_is_checked_computed_shown_drawn_and_exported(study_folder: Path, monkeypatch) -> None:
    type_("new", "spall.yaml")
    assert "5 jobs" in type_("check", "spall.yaml", "--quick")[0]
    summary, _ = type_("run", "spall.yaml", "--quick", "--jobs", "2", "--out", "results/spall")
    assert "5 of 5 jobs done" in summary
    assert "5 jobs: 5 done" in type_("show")[0]
    assert all(Path(figure).stat().st_size for figure in type_("plot")[0].split())
    type_("report")
    assert "5 of 5 jobs done" in Path("results/spall/report.html").read_text(encoding="utf-8")
    type_("export", "--features", "table.csv")
    table = pd.read_csv("table.csv")
    assert (table["velocity@BPFO (m/s)"] > 0.0).all()
    series = type_("export", "--series", table["job"][0])[0].strip()
    assert "ring.velocity.y [m/s]" in pd.read_csv(series)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert "pip install 'bearingsim[parquet]'" in type_("export", "--features", "table.parquet", code=2)[1]
    assert not Path("table.parquet").exists()


def test_help_lists_every_command() -> None:
    text = type_("--help")[0]
    for command in app.registered_commands:
        assert command.callback is not None
        name = command.callback.__name__
        assert name in text
        assert "Usage" in type_(name, "--help")[0]
