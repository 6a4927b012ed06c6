"""Results of model version 9, in a folder without a marker."""

import tarfile
from pathlib import Path

import pandas as pd
import pytest

import bearingsim as bs
from tests.scenes.commands import type_

ARCHIVE = Path(__file__).parents[1] / "data" / "results_of_model_9.tar.xz"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Extract the archived folder."""
    with tarfile.open(ARCHIVE) as archive:
        archive.extractall(tmp_path, filter="data")
    return tmp_path / "kept"


def test_results_are_shown(folder: Path) -> None:
    output, _ = type_("show", folder)
    assert output.count("static") >= 2
    assert output.count("ring") >= 2


def test_results_are_drawn(folder: Path) -> None:
    type_("plot", folder)
    assert list((folder / "figures").glob("*.png"))
    type_("plot", folder, "--kind", "series", "--job", "all")


def test_results_are_exported(folder: Path) -> None:
    type_("export", folder, "--features", folder / "features.csv")
    written = pd.read_csv(folder / "features.csv", comment="#")
    before = pd.read_csv(folder / "results.csv", comment="#")
    assert (written["velocity@BPFO (m/s)"] == before["velocity@BPFO"]).all()


def test_series_are_read(folder: Path) -> None:
    results = bs.open_results(folder)
    table = results.table()
    series = results.series(table["job"].iloc[0])
    assert len(series.time) == 100  # 20 ms at 5 kHz
    assert table["velocity@BPFO"].notna().all()
