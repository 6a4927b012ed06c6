"""A results folder of before files had digests, with a dataset for each feature: it is read, and gone on with."""

import tarfile
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from bearingsim import store
from tests.scenes.commands import type_
from tests.scenes.reading import EVERY_DIGIT

KEPT = Path(__file__).parents[1] / "data" / "results_without_digests.tar.xz"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with tarfile.open(KEPT) as kept:
        kept.extractall(tmp_path, filter="data")
    return tmp_path / "kept"


def test_its_table_is_what_it_was(folder: Path) -> None:
    before = pd.read_csv(folder / "results.csv", dtype={"job": str, "unit": str, "healthy": str}, **EVERY_DIGIT)
    table = store.open_results(folder).table()
    assert list(table["status"]) == ["done"] * 4
    for name in before.columns[before.dtypes == np.float64].drop("reason"):
        np.testing.assert_array_equal(table[name], before[name], err_msg=name)
    assert store.open_results(folder).parameters()["contact.stiffness"].notna().all()


def test_its_jobs_count_as_done(folder: Path) -> None:
    held = store.holdings(folder)
    assert (len(held.sealed), held.damaged) == (4, [])
    assert set(held.failures) == {"0123456789abcdef"}
    assert len(store.read_choices(folder)) == 3
    assert len(store.read_trials(folder)) == 3


def test_its_series_are_read(folder: Path) -> None:
    results = store.open_results(folder)
    assert len(results.series(results.jobs[0])["ring.velocity.x"]) == 400
    type_("plot", folder, "--kind", "series", "--job", "all")


def test_a_flipped_bit_of_its_series_is_found(folder: Path) -> None:
    path = sorted(folder.glob("units/??/*.h5"))[0]
    with h5py.File(path) as file:
        offset = file["ring.velocity.x"].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[offset + 50] ^= 1
    path.write_bytes(bytes(content))
    assert len(store.holdings(folder).sealed) == 3
