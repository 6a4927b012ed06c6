"""Full disks and repeated worker deaths, which end a run without failed jobs."""

import contextlib
import resource
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bearingsim import store
from bearingsim.runner import RepeatedWorkerDeaths, RunSummary, run
from bearingsim.store import DiskFull, files
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy
from tests.scenes.study_text import Write
from tests.scenes.trials import DEATHS, accuracy_study
from tests.scenes.trials import ENGINE as TRIALS


def compute(study: Any, out: Path, jobs: int = 1) -> RunSummary:
    return run(study, out, jobs=jobs, progress=False, engine=ENGINE)


@contextlib.contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Limit files of this process and its children to ``size`` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("size", [100, 1000, 8_000, 24_000])
def test_full_disk_ends_the_run_without_failed_jobs(tmp_path: Path, size: int) -> None:
    study, out = FakeStudy([1e-3 * (i + 1) for i in range(40)]), tmp_path / "out"
    with largest_file(size), pytest.raises(DiskFull, match="ulimit -f") as error:
        compute(study, out)
    assert str(tmp_path / "out") in str(error.value)
    assert not list(out.glob("failed/*"))
    assert not list(out.rglob("*.part"))
    compute(study, out)
    assert set(store.open_results(out).table()["status"]) == {"done"}


def test_full_disk_is_reported_by_workers(tmp_path: Path) -> None:
    with largest_file(8_000), pytest.raises(DiskFull, match="free some space"):
        compute(FakeStudy([1e-3 * (i + 1) for i in range(40)]), tmp_path, jobs=2)
    assert not list(tmp_path.glob("failed/*"))


def test_job_that_raises_a_full_disk_does_not_fail(tmp_path: Path) -> None:
    with pytest.raises(DiskFull):
        compute(FakeStudy(actions={0: "no room"}), tmp_path)
    assert not list(tmp_path.glob("failed/*"))


def test_free_space_is_checked_before_the_first_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bearingsim.store.files.shutil.disk_usage", lambda _: SimpleNamespace(free=500))
    with pytest.raises(DiskFull, match=r"too full for .*0.0005 MB are left of at least 0.00\d+ MB"):
        compute(FakeStudy(), tmp_path)
    assert not list(tmp_path.glob("units/*"))


@pytest.mark.parametrize("arguments", [("plot",), ("export", "--features"), ("export", "--series")])
def test_full_disk_is_reported_by_figures_and_exports(
    done: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    job = store.open_results(done).jobs[0]
    options: dict[str, list[Any]] = {"--features": [tmp_path / "f.csv"]}
    options["--series"] = [job, "--out", tmp_path / "s.mat"]
    with largest_file(1000):
        _, message = type_(
            arguments[0], done, *arguments[1:], *options.get(arguments[-1], ["--out", tmp_path]), code=2
        )
    assert len(message.splitlines()) == 1
    assert str(tmp_path) in message
    assert not list(tmp_path.iterdir())


def test_full_disk_is_named(tmp_path: Path) -> None:
    with pytest.raises(DiskFull, match=r"the disk /\S* is full"), files.full_disk_errors(tmp_path / "new" / "a"):
        raise OSError(28, "No space left on device")


# Workers that die


def test_three_worker_deaths_without_a_result_end_the_run(tmp_path: Path) -> None:
    study = FakeStudy([1e-3 * (i + 1) for i in range(6)], actions=dict.fromkeys(range(6), "exit"))
    study.actions[3] = "kill"
    with pytest.raises(RepeatedWorkerDeaths, match=r"3 times without finishing a job \((EXIT\(3\)|SIGKILL)"):
        compute(study, tmp_path, jobs=2)
    assert not list(tmp_path.glob("failed/*"))


def test_two_jobs_that_kill_workers_fail(tmp_path: Path) -> None:
    study = FakeStudy([1e-3 * (i + 1) for i in range(8)], actions={0: "exit", 5: "kill"}, seconds=0.02)
    summary = compute(study, tmp_path, jobs=2)
    assert (summary.done, summary.failed) == (7, 2)


def test_worker_deaths_during_trials_are_reported(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(DEATHS, "1")
    with pytest.raises(RepeatedWorkerDeaths, match="while models were tried 3 times"):
        run(accuracy_study(write), tmp_path / "out", jobs=2, progress=False, engine=TRIALS)
