"""Flipped bits in stored files, which are refused or repaired and never change a result."""

import random
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.errors import DamageWarning
from bearingsim.runner import RunSummary, run
from bearingsim.selection import Choice
from bearingsim.store import sealed
from bearingsim.store.units import read_unit
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy

STUDY: Any = FakeStudy(actions={1: "raise"})


def compute(out: Path, **options: Any) -> RunSummary:
    return run(STUDY, out, jobs=1, progress=False, engine=ENGINE, **options)


def flip(path: Path, bit: int) -> None:
    content = bytearray(path.read_bytes())
    content[bit // 8 % len(content)] ^= 1 << bit % 8
    path.write_bytes(bytes(content))


def read_all(out: Path) -> tuple[pd.DataFrame, list[Any]]:
    """Read table, parameters, failures and series."""
    results = store.open_results(out)
    table = results.table()
    series = [results.series(job)["ring.velocity.x"].tolist() for job in table["job"][table["status"] == "done"]]
    failures = [(job, failure.reason, failure.advice) for job, failure in results.failures().items()]
    return table, [results.parameters(), failures, series]


def are_equal(first: tuple[pd.DataFrame, list[Any]], second: tuple[pd.DataFrame, list[Any]]) -> bool:
    return first[0].equals(second[0]) and first[1][0].equals(second[1][0]) and first[1][1:] == second[1][1:]


@pytest.fixture(scope="module")
def complete_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole") / "out"
    compute(out)
    return out


@pytest.mark.parametrize(
    "kind", ["units/??/*.h5", "failed/*.json", "study.h5", "plan.json", "results.csv", "bearingsim.json"]
)
@pytest.mark.parametrize("without_table", [False, True])
def test_one_run_repairs_a_flipped_bit(
    complete_results: Path, tmp_path: Path, kind: str, without_table: bool
) -> None:
    expected, csv = read_all(complete_results), (complete_results / "results.csv").read_bytes()
    [relative_path] = [path.relative_to(complete_results) for path in complete_results.glob(kind)]
    for bit in random.Random(kind).sample(range(8 * (complete_results / relative_path).stat().st_size), 4):
        out = tmp_path / str(bit)
        shutil.copytree(complete_results, out)
        if without_table:
            (out / "study.h5").unlink(missing_ok=True)
        if (out / relative_path).exists():
            flip(out / relative_path, bit)
        summary = compute(out)
        assert (summary.done + summary.resumed, summary.failed, summary.missing) == (3, 1, 0)
        assert are_equal(read_all(out), expected)
        assert (out / "results.csv").read_bytes() == csv
        if kind.startswith(("units", "failed")):
            assert f"1 damaged file ({relative_path})" in str(summary)


def test_every_flipped_bit_of_a_unit_is_detected(complete_results: Path, tmp_path: Path) -> None:
    [unit] = complete_results.glob("units/??/*.h5")
    content, path = unit.read_bytes(), tmp_path / unit.name
    digest_bits = range(8 * len(content) - 8 * 80, 8 * len(content))  # the digest itself
    for bit in [*random.Random(1).sample(range(8 * len(content)), 300), *digest_bits]:
        path.write_bytes(content)
        flip(path, bit)
        with pytest.raises(store.DamagedUnit):
            store.check_unit(path)


def test_every_flipped_bit_of_choices_is_detected(tmp_path: Path) -> None:
    choice = Choice(candidate="planar", model="planar", why="it is the reference", error={"velocity.rms": 0.01})
    store.write_choices(tmp_path, {"a" * 16: choice})
    path = tmp_path / "choices.json"
    content = path.read_bytes()
    for bit in random.Random(2).sample(range(8 * len(content)), 200):
        flip(path, bit)
        with pytest.raises(store.DamagedChoices, match=r"choices.json cannot be read .*: restore it"):
            store.read_choices(tmp_path)
        path.write_bytes(content)
    assert store.read_choices(tmp_path) == {"a" * 16: choice}


def test_a_flipped_bit_of_a_trial_loses_the_trial_only(tmp_path: Path) -> None:
    selection.write_trials(tmp_path, "ab" * 8, {"one": None})
    selection.write_trials(tmp_path, "cd" * 8, {"two": None})
    flip(tmp_path / "trials" / f"{'ab' * 8}.json", 200)
    assert selection.read_trials(tmp_path) == {"two": None}


def test_damaged_series_is_refused_with_a_remedy(complete_results: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(complete_results, out)
    results = store.open_results(out)
    [path] = out.glob("units/??/*.h5")
    results.table()
    flip(path, 8 * 3000)
    with pytest.raises(store.DamagedUnit, match=rf"{path}: .* \(run the study again with --verify"):
        results.series(results.jobs[0])
    with pytest.warns(DamageWarning, match=r"cannot be read .* Run the study again"):
        assert set(store.open_results(out).table()["status"]) == {"missing", "failed"}


# Files of other versions, or of no version


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "its checksum is missing"),
        ('{"schema": 2, "job": "x"}', "its checksum is missing"),
        ("{" + sealed._json_seal("{}"), "its content does not match its checksum"),
        ("{" + sealed._json_seal("{"), "Expecting property name"),
    ],
)
def test_unreadable_failure_is_reported(complete_results: Path, tmp_path: Path, text: str, reason: str) -> None:
    out = tmp_path / "out"
    shutil.copytree(complete_results, out)
    [path] = out.glob("failed/*.json")
    path.write_text(text)
    output, warnings = type_("show", out)
    assert "3 done, 1 missing" in output
    assert f"{path} cannot be read ({reason}" in warnings
    assert "Run the study again" in warnings
    assert len(warnings.splitlines()) == 1


def test_known_entries_of_a_failure_of_another_version_are_read(tmp_path: Path) -> None:
    (tmp_path / "failed").mkdir()
    first, second = "ab" * 8, "cd" * 8
    sealed.write_json(tmp_path / f"failed/{first}.json", {"reason": "diverged", "mood": "bad"})
    sealed.write_json(tmp_path / f"failed/{second}.json", {"job": "cd", "advice": "none"})
    failures = store.read_failures(tmp_path)
    assert (failures[first].job, failures[first].reason) == (first, "diverged")
    assert (failures[second].reason, failures[second].advice) == ("unknown", "none")


def test_another_schema_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bearingsim.store.sealed.SCHEMA", 9)
    store.write_choices(tmp_path, {})
    monkeypatch.undo()
    with pytest.raises(store.DamagedChoices, match="it has schema 9, and this version reads 2"):
        store.read_choices(tmp_path)


def test_a_unit_is_read_once(complete_results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    shutil.copytree(complete_results, out)
    (out / "study.h5").unlink()
    paths = list[Path]()

    def record(path: Path) -> Any:
        paths.append(path)
        return read_unit(path)

    monkeypatch.setattr("bearingsim.store.checked_units.read_unit", record)
    for _ in range(3):
        assert compute(out).resumed == 3
    assert len(paths) == 1
    assert np.isfinite(store.open_results(out).table()["velocity@BPFO"]).sum() == 3
