"""Removal of files that a plan no longer contains."""

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from filelock import FileLock

from bearingsim import selection, store
from bearingsim.config.scan.file import digest_of
from bearingsim.runner import RunSummary, run, with_models
from bearingsim.store.files import temporary
from bearingsim.store.units import write_units
from tests.scenes import fake_studies, trials
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy, record_of
from tests.scenes.study_text import Write

ID, OTHER = "0123456789abcdef", "1123456789abcdef"
UNITS, FAILURES = "units of jobs outside the plan", "failures of jobs outside the plan"


def compute(study: Any, out: Path) -> RunSummary:
    return run(study, out, jobs=1, progress=False, engine=ENGINE)


def files_of(root: Path) -> set[Path]:
    return {path for path in root.rglob("*") if path.is_file() and path.name != ".lock"}


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the log of the calls of the engine."""
    path = tmp_path / "log"
    path.touch()
    monkeypatch.setenv(trials.LOG, str(path))
    return path


@pytest.fixture
def narrowed_results(tmp_path: Path) -> Path:
    """Compute wider studies, then one of one width: one unit contains a planned job, another none."""
    compute(FakeStudy([2e-3]), tmp_path)
    compute(FakeStudy([2e-3, 5e-3], actions={1: "raise"}), tmp_path)
    compute(FakeStudy([3e-3]), tmp_path)
    [(job, *_)] = [FakeStudy([4e-3]).jobs()]
    write_units(tmp_path, [(job, record_of(job.case))], {})
    compute(FakeStudy([3e-3]), tmp_path)
    return tmp_path


def test_unplanned_files_are_listed_without_removal(narrowed_results: Path) -> None:
    before = {path: path.read_bytes() for path in files_of(narrowed_results)}
    output, _ = type_("prune", narrowed_results)
    removable = store.find_removable(narrowed_results)
    assert {kind: len(paths) for kind, paths in removable.files.items()} == {UNITS: 1, FAILURES: 1}
    assert removable.bytes == sum(len(before[path]) for path in removable.paths)
    assert f"in all 2 files, {removable.bytes} bytes" in output
    assert "nothing is removed yet" in output
    assert "1 unit is kept whole, although the plan names only 1 of 2 jobs there" in output
    assert {path: path.read_bytes() for path in files_of(narrowed_results)} == before


def test_only_unplanned_files_are_removed(narrowed_results: Path) -> None:
    before, table = files_of(narrowed_results), store.open_results(narrowed_results).table()
    removable = store.find_removable(narrowed_results)
    output, _ = type_("prune", narrowed_results, "--no-dry-run", "-v")
    assert output.splitlines()[-1] == "removed"
    assert all(path.name in output for path in removable.paths)
    assert before - files_of(narrowed_results) == set(removable.paths)
    assert files_of(narrowed_results) <= before
    pd.testing.assert_frame_equal(store.open_results(narrowed_results).table(), table)
    assert compute(FakeStudy([3e-3]), narrowed_results).resumed == 2
    assert type_("prune", narrowed_results, "--no-dry-run")[0].splitlines()[-1] == "nothing to remove"


def test_damaged_and_leftover_files_are_removed(tmp_path: Path) -> None:
    compute(FakeStudy(), tmp_path)
    for name in (
        f"units/01/{ID}.damaged",
        f"failed/{ID}.damaged",
        f"units/01/{ID}.h5.host-1-0123abcd.part",
        f"units/01/{ID}.host-1-0123abcd.started",
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"12345")
    removed = store.prune(tmp_path)
    assert removed.bytes == 20
    assert {kind: len(paths) for kind, paths in removed.files.items()} == {
        "damaged files (.damaged)": 2,
        "temporary files of ended processes": 2,
    }
    assert not [*tmp_path.rglob("*.damaged"), *tmp_path.rglob("*.part"), *tmp_path.rglob("*.started")]


def test_unreadable_unit_is_kept(tmp_path: Path) -> None:
    compute(FakeStudy(), tmp_path)
    [path] = tmp_path.glob("units/??/*.h5")
    path.write_bytes(path.read_bytes()[:-3])
    removed = store.prune(tmp_path)
    assert not removed.paths
    assert f"{path.name}: its checksum is missing: kept" in str(removed)
    assert path.exists()


def with_scan(root: Path, text: bytes) -> Path:
    scan = root / "scans" / f"{digest_of(text)}.csv"
    scan.parent.mkdir(exist_ok=True)
    scan.write_bytes(text)
    return scan


def test_unused_scans_are_removed_once_all_jobs_are_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = tmp_path / "results"
    flag = tmp_path / "flag"
    study: Any = FakeStudy(actions={1: f"raise-unless {flag}"})
    used, orphan_content = with_scan(tmp_path, b"1 2"), b"3 4"
    original = store.flat_parameters

    def with_digest(case: Any) -> dict[str, float | str]:
        return original(case) | ({} if case.healthy else {"defects.1.digest": used.stem})

    monkeypatch.setattr("bearingsim.store.units.flat_parameters", with_digest)
    compute(study, root)
    scans = [with_scan(root, b"1 2"), with_scan(root, orphan_content)]
    assert "scans are kept (2 files): 1 job that may need them is not done" in str(store.find_removable(root))
    assert not store.find_removable(root).paths
    flag.touch()
    run(study, root, jobs=1, progress=False, engine=ENGINE, retry_failed=True)
    assert store.prune(root).paths == [scans[1]]
    assert scans[0].exists()


def test_trials_are_removed_from_a_study_without_accuracy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compute(FakeStudy(), tmp_path)
    selection.write_trials(tmp_path, ID, {"one": None})
    (tmp_path / f"trials/{OTHER}.json").write_text("{")
    assert [path.name for path in store.find_removable(tmp_path).paths] == [f"{ID}.json", f"{OTHER}.json"]
    monkeypatch.setattr(store.Results, "plan", store.read_plan(tmp_path) | {"accuracy": {"within": 0.05}})
    assert [path.name for path in store.prune(tmp_path).paths] == [f"{OTHER}.json"]


def test_a_folder_in_use_is_refused(narrowed_results: Path) -> None:
    removable = store.find_removable(narrowed_results)
    with FileLock(narrowed_results / ".lock"):
        assert "another run has locked" in type_("prune", narrowed_results, "--no-dry-run", code=2)[1]
    with temporary(narrowed_results / "units/00", ID, "started"):
        assert "another run is writing" in type_("prune", narrowed_results, "--no-dry-run", code=2)[1]
        type_("prune", narrowed_results)
    assert all(path.exists() for path in removable.paths)
    assert len(store.prune(narrowed_results).paths) == len(removable.paths)


def test_folder_without_a_plan_is_unchanged(tmp_path: Path) -> None:
    compute(FakeStudy(), tmp_path)
    plan = tmp_path / "plan.json"
    plan.write_bytes(plan.read_bytes()[:-10])
    before = files_of(tmp_path)
    assert "plan.json is damaged" in type_("prune", tmp_path, "--no-dry-run", code=2)[1]
    assert files_of(tmp_path) == before
    os.remove(plan)
    assert "contains no results" in type_("prune", tmp_path, "--no-dry-run", code=2)[1]


def assert_in_use(root: Path, study: Any) -> None:
    """Check that the folder cannot be cleared because a run uses it."""
    before = files_of(root)
    with pytest.raises(store.FolderInUse, match="another run is writing"):
        store.prune(root)
    with pytest.raises(store.FolderInUse, match="another run is writing"):
        run(study, root, jobs=1, fresh=True, progress=False, engine=ENGINE)
    assert files_of(root) >= before


def test_nothing_is_removed_during_trials(
    write: Write, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plan is still the earlier one, without an accuracy."""
    out, calls = tmp_path / "out", list[bool]()
    compute(FakeStudy(name="near"), out)
    original = trials.try_out

    def try_out(*arguments: Any) -> Any:
        assert_in_use(out, FakeStudy(name="near"))
        calls.append(True)
        return original(*arguments)

    monkeypatch.setattr(trials, "try_out", try_out)
    run(trials.accuracy_study(write), out, jobs=1, progress=False, engine=trials.ENGINE)
    assert len(calls) == len([line for line in log.read_text().splitlines() if line.startswith("try")]) > 3
    assert not list(out.rglob("*.started"))


def test_nothing_is_removed_before_the_first_job(narrowed_results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run has already checked the contents of the folder."""
    original, calls, study = fake_studies.estimate, list[bool](), FakeStudy([4e-3, 6e-3])

    def estimate(case: Any) -> Any:
        calls.append(True)
        assert_in_use(narrowed_results, FakeStudy())
        if len(calls) == 1:
            compute(study, narrowed_results)
        return original(case)

    monkeypatch.setattr(fake_studies, "estimate", estimate)
    assert compute(study, narrowed_results).resumed == 2
    assert len(calls) == 2  # including the inner run


def test_nothing_is_removed_while_a_check_runs_trials(
    write: Write, narrowed_results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = list[bool]()

    def check_use(study: Any, *_: Any, **__: Any) -> Any:
        assert_in_use(narrowed_results, FakeStudy())
        calls.append(True)
        return study

    monkeypatch.setattr(sys.modules[with_models.__module__], "choose_models", check_use)
    study = trials.accuracy_study(write)
    with_models(replace(study, name="fake"), narrowed_results, 1, run_trials=True)
    assert calls
    assert store.prune(narrowed_results).paths
