"""Runs of studies: stored results, failures, interruptions and shards."""

import contextlib
import io
import json
import os
import re
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim import store
from bearingsim.runner import pool, progress, run
from bearingsim.runner.packing import Cost, pack, select_shard, unit_seconds
from bearingsim.runner.summary import group_failures
from bearingsim.text import announcer
from bearingsim.text.terminal import LINE_WIDTH
from tests.scenes.fake_runs import assert_tidy, compute, other_process, table_of
from tests.scenes.fake_studies import ENGINE, FakeStudy, record_of


def journal_of(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for path in out.glob("journal-*.jsonl") for line in path.read_text().splitlines()]


# What a run gives


@pytest.mark.parametrize("jobs", [1, 2])
def test_study_is_computed_and_stored(tmp_path: Path, jobs: int) -> None:
    study = FakeStudy()
    summary = compute(study, tmp_path, jobs)
    assert (summary.planned, summary.done, summary.failed, summary.missing) == (4, 4, 0, 0)
    assert summary.exit_code == 0
    assert "4 of 4 jobs done" in str(summary)
    results = store.open_results(tmp_path)
    for job in study.jobs():
        expected = record_of(job.case).series["ring.velocity.x"].astype("f4")
        np.testing.assert_array_equal(results.series(job.id)["ring.velocity.x"], expected)
    assert (tmp_path / "results.csv").is_file()
    assert_tidy(tmp_path)


def test_one_worker_starts_no_process(tmp_path: Path) -> None:
    compute(FakeStudy(actions={0: f"pid {tmp_path / 'pid'}"}), tmp_path / "out")
    assert int((tmp_path / "pid").read_text()) == os.getpid()


def test_workers_are_single_threaded_processes(tmp_path: Path) -> None:
    compute(
        FakeStudy(actions={0: f"pid {tmp_path / 'pid'}", 1: f"threads {tmp_path / 'threads'}"}),
        tmp_path / "out",
        2,
    )
    assert int((tmp_path / "pid").read_text()) != os.getpid()
    assert (tmp_path / "threads").read_text() == "1"


def test_summary_reports_the_integrator_share(tmp_path: Path) -> None:
    summary = compute(FakeStudy(seconds=0.3, actions=dict.fromkeys(range(3), "spin")), tmp_path)
    assert 0.5 < summary.integrator_share < 1.0
    assert "CPU time of the workers: " in str(summary)


def test_progress_lines_report_counts_and_remaining_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bearingsim.runner.progress.LINE_INTERVAL_S", 0.0)
    study: Any = FakeStudy(actions={1: "raise"}, seconds=0.3)
    run(study, tmp_path, jobs=1, engine=ENGINE)
    cost, *lines = capsys.readouterr().err.splitlines()
    assert cost.startswith("4 jobs: about ")
    assert len(lines) == 2  # units
    assert "left" in lines[0]
    assert lines[-1] == "4/4 jobs, 1 failed"


@pytest.mark.parametrize(("shown", "is_said"), [(None, True), (False, False)])
def test_a_long_start_is_explained(
    shown: bool | None, is_said: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(announcer, "ANNOUNCEMENT_DELAY_S", 0.05)
    with announcer.announcer(shown) as start:
        announce = progress.compilation_callback(start)
        announce(1, 5, 7.0)
        announce(2, 5, 22.0)
        assert "compiling" not in capsys.readouterr().err
        time.sleep(0.3)
    output = capsys.readouterr().err
    assert ("compiling the solver, 2 of 5 (about 22 s; needed once, then cached)" in output) == is_said
    assert "1 of 5" not in output


def test_bar_counts_jobs_and_failures(capsys: pytest.CaptureFixture[str]) -> None:
    with progress._bar(4, 4.0) as report:
        report(1, 0, 1.0)
        report(2, 1, 3.0)
    output = capsys.readouterr().err
    assert "4/4 jobs, 1 failed" in output
    assert re.search(r"elapsed \S+ remaining \S+", output)


def test_last_progress_line_is_printed_within_the_interval(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.progress(None, 3, 3.0) as report:
        report(1, 0, 1.0)
        report(2, 0, 2.0)
    assert capsys.readouterr().err == "3/3 jobs\n"


def test_progress_line_has_no_remaining_time_once_the_estimate_is_used_up() -> None:
    lines: list[str] = []
    with progress._lines(3, 3.0, 0.0, lines.append) as report:
        report(1, 0, 1.0)
        report(1, 0, 2.5)
        report(0, 1, 1.0)
    assert lines[0].startswith("1/3 jobs, about ")
    assert lines[1:] == ["2/3 jobs", "3/3 jobs, 1 failed"]


def test_a_notebook_has_one_line_that_is_rewritten(monkeypatch: pytest.MonkeyPatch) -> None:
    """ipykernel's streams are no terminals, but return to the start of a line at a carriage return."""
    stream = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})()
    monkeypatch.setattr(sys, "stderr", stream)
    with contextlib.suppress(KeyboardInterrupt), progress.progress(None, 4, 4.0) as report:
        report(1, 0, 1.0)
        report(1, 1, 2.0)
        raise KeyboardInterrupt
    start, first, second = stream.getvalue().split("\r")
    assert (start, len(first)) == ("", LINE_WIDTH)
    assert first.startswith("1/4 jobs, about ")
    assert second.startswith("3/4 jobs, 1 failed, about ")
    assert second.endswith(" left" + " " * (LINE_WIDTH - len(second.strip())) + "\n")


# Resuming


def test_summary_reports_each_note_on_the_cases_once(tmp_path: Path) -> None:
    """Each note appears once for all cases."""
    summary = compute(FakeStudy(actions={0: "note a", 1: "note b", 2: "note a"}), tmp_path)
    assert summary.notes == ("the action is note a", "the action is note b")
    assert summary.events == summary.notes
    assert str(summary).splitlines()[1:3] == list(summary.notes)


def test_notes_are_collected_before_their_source_is_removed(tmp_path: Path) -> None:
    (tmp_path / "action").write_text("a file's")
    summary = compute(FakeStudy(actions={0: f"note in {tmp_path / 'action'}"}), tmp_path / "out")
    assert not (tmp_path / "action").exists()
    assert summary.notes == ("the action is a file's",)
    assert journal_of(tmp_path / "out")[-1]["event"] == "end"


def test_second_run_computes_nothing(tmp_path: Path) -> None:
    study = FakeStudy()
    compute(study, tmp_path)
    before = table_of(tmp_path)
    summary = compute(FakeStudy(actions={}), tmp_path)
    assert (summary.done, summary.resumed) == (0, 4)
    assert np.isnan(summary.integrator_share)
    assert table_of(tmp_path).equals(before)


def test_wider_study_computes_new_jobs_only(tmp_path: Path) -> None:
    compute(FakeStudy([1e-3]), tmp_path)
    summary = compute(FakeStudy([1e-3, 2e-3]), tmp_path)
    assert (summary.done, summary.resumed) == (1, 2)


def test_truncated_unit_is_computed_again(tmp_path: Path) -> None:
    study = FakeStudy()
    compute(study, tmp_path)
    before = table_of(tmp_path)
    [path] = tmp_path.glob("units/??/*.h5")
    path.write_bytes(path.read_bytes()[:-100])
    assert compute(study, tmp_path).done == 4
    assert table_of(tmp_path).equals(before)


def test_verify_reads_unchanged_units(tmp_path: Path) -> None:
    study = FakeStudy()
    compute(study, tmp_path)
    [path] = tmp_path.glob("units/??/*.h5")
    content, before = bytearray(path.read_bytes()), path.stat()
    content[len(content) // 2] ^= 16
    path.write_bytes(bytes(content))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))  # as after bit rot on the disk
    assert compute(study, tmp_path).done == 0
    assert compute(study, tmp_path, verify=True).done == 4


def test_fresh_run_computes_everything_again(tmp_path: Path) -> None:
    study = FakeStudy(actions={0: "raise"})
    compute(study, tmp_path)
    note = tmp_path / "notes.txt"
    note.touch()
    summary = compute(study, tmp_path, fresh=True)
    assert (summary.done, summary.failed, summary.resumed) == (3, 1, 0)
    assert note.exists()


# Failures


def test_failed_jobs_are_reported_and_stored(tmp_path: Path) -> None:
    study = FakeStudy(actions={0: "raise", 1: "divide"})
    summary = compute(study, tmp_path)
    assert (summary.done, summary.failed, summary.exit_code) == (2, 2, 1)
    first, second = (store.read_failures(tmp_path)[job.id] for job in study.jobs()[:2])
    assert (first.reason, first.advice, first.time) == ("no steady state after 0.3 s", "shorten the step", 0.3)
    assert second.reason == "ZeroDivisionError: division by zero"
    assert "print(1 / 0)" in second.traceback
    assert first.command == (
        f"bearingsim run studies/fake.yaml --out {tmp_path} --set 'load=200 N' --retry-failed"
    )
    assert list(table_of(tmp_path)["status"]) == ["failed", "failed", "done", "done"]
    assert_tidy(tmp_path)


def test_failed_jobs_are_repeated_only_on_request(tmp_path: Path) -> None:
    flag = tmp_path / "flag"
    study = FakeStudy(actions={0: f"raise-unless {flag}"})
    out = tmp_path / "out"
    compute(study, out)
    flag.touch()
    second_summary = compute(study, out)
    assert (second_summary.done, second_summary.failed, second_summary.exit_code) == (0, 1, 1)
    flag.unlink()
    compute(study, out, retry_failed=True)
    [failure] = store.read_failures(out).values()
    assert failure.attempts == 2
    flag.touch()
    retried = compute(study, out, retry_failed=True)
    assert (retried.done, retried.failed, retried.exit_code) == (1, 0, 0)
    assert not store.read_failures(out)


def test_failures_are_grouped_by_reason_apart_from_numbers() -> None:
    reasons = ["diverged at 0.12 s", "no such law", "diverged at 3e-05 s"]
    groups = group_failures(store.Failure(f"job{i}", reason, "halve the step") for i, reason in enumerate(reasons))
    assert [len(group.jobs) for group in groups] == [2, 1]
    assert str(groups[0]) == "2 jobs failed: diverged at 0.12 s (halve the step), for example job0"


def test_durations_are_readable() -> None:
    texts = [progress.duration(seconds) for seconds in (0.123, 12.4, 99.4, 99.6, 3725.0)]
    assert texts == ["0.12 s", "12 s", "99 s", "1 min 40 s", "1 h 2 min"]


def test_refused_case_fails_alone(tmp_path: Path) -> None:
    summary = compute(FakeStudy(actions={0: "raise refused"}), tmp_path)
    assert (summary.done, summary.failed) == (3, 1)


def test_failed_warm_up_does_not_fail_jobs(tmp_path: Path) -> None:
    engine = replace(ENGINE, warm="tests.scenes.fake_studies:fail_to_warm")
    study: Any = FakeStudy()
    summary = run(study, tmp_path, jobs=1, progress=False, engine=engine)
    assert (summary.done, summary.failed) == (4, 0)
    assert "warm-up failed" in [line["event"] for line in journal_of(tmp_path)]


@pytest.mark.parametrize(("action", "cause"), [("exit", "EXIT(3)"), ("kill", "SIGKILL(-9)")])
def test_worker_death_fails_its_job_only(tmp_path: Path, action: str, cause: str) -> None:
    study = FakeStudy([1e-3 * (i + 1) for i in range(8)], actions={3: action}, seconds=0.02)
    summary = compute(study, tmp_path, 2)
    assert (summary.done, summary.failed, summary.exit_code) == (8, 1, 1)
    [failure] = store.read_failures(tmp_path).values()
    assert failure.job == study.jobs()[3].id
    assert failure.reason == f"the worker process died: {cause}"
    assert failure.attempts == 2
    assert "--retry-failed" in failure.command
    assert_tidy(tmp_path)


def test_job_that_succeeds_alone_does_not_fail(tmp_path: Path) -> None:
    study = FakeStudy(actions={1: f"die-once {tmp_path / 'died'}"})
    summary = compute(study, tmp_path / "out", 2)
    assert (tmp_path / "died").exists()
    assert (summary.done, summary.failed) == (4, 0)
    assert "worker died" in [line["event"] for line in journal_of(tmp_path / "out")]


def test_unit_whose_outcome_is_lost_with_the_pool_is_of_this_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker dies after another has stored a unit, before this process has received its outcome."""
    original, deaths = pool._compute_in_pool, list[BrokenProcessPool]()

    def lose_first_unit(works: Any, workers: int) -> Any:
        if deaths:
            yield from original(works, workers)
            return
        list(original(works[:1], workers))
        deaths.append(BrokenProcessPool("died"))
        raise deaths[0]

    monkeypatch.setattr(pool, "_compute_in_pool", lose_first_unit)
    counts = tmp_path / "counts"
    study = FakeStudy([1e-3 * (i + 1) for i in range(5)], dict.fromkeys(range(5), f"count {counts}"), seconds=0.1)
    summary = compute(study, tmp_path / "out", 2)
    assert (summary.done, summary.missing, summary.exit_code) == (6, 0, 0)
    assert "another run" not in str(summary)
    assert sorted(counts.read_text().split()) == sorted(job.id for job in study.jobs()[:5])  # none twice


def test_failure_of_a_computed_job_does_not_prevent_its_repetition(tmp_path: Path) -> None:
    """The failure remains if `--retry-failed` is killed between storing the result and removing the failure."""
    study = FakeStudy()
    compute(study, tmp_path)
    store.Failure(study.jobs()[0].id, "left").write(tmp_path)
    compute(study, tmp_path)
    assert not store.read_failures(tmp_path)
    for path in tmp_path.glob("units/??/*.h5"):
        path.write_bytes(path.read_bytes()[:-100])
    assert compute(study, tmp_path).failed == 0
    assert set(table_of(tmp_path)["status"]) == {"done"}


# Shards and packing


def test_shards_share_the_study_and_a_folder(tmp_path: Path) -> None:
    study = FakeStudy([1e-3 * (i + 1) for i in range(6)])
    shards = [select_shard(study.jobs(), (k, 3)) for k in (1, 2, 3)]
    assert sorted(len(shard) for shard in shards) == [2, 2, 3]
    assert {job.id for shard in shards for job in shard} == {job.id for job in study.jobs()}
    assert shards[1] == [job for job in study.jobs() if job in select_shard(study.jobs()[::-1], (2, 3))]
    for k in (1, 2, 3):
        assert compute(study, tmp_path, shard=(k, 3)).done == len(shards[k - 1])
    table = table_of(tmp_path)
    assert set(table["status"]) == {"done"}
    assert table["velocity@BPFO-healthy"].notna().sum() == 6


def test_two_runs_share_a_folder(tmp_path: Path) -> None:
    with other_process(tmp_path, 1, 12, 0.02) as first, other_process(tmp_path, 1, 12, 0.02) as second:
        assert [process.wait(timeout=30) for process in (first, second)] == [0, 0]
    assert set(table_of(tmp_path)["status"]) == {"done"}
    assert len(list(tmp_path.glob("journal-*.jsonl"))) == 2
    assert_tidy(tmp_path)


@pytest.mark.parametrize("shard", [(0, 3), (4, 3)])
def test_shard_out_of_range_is_refused(shard: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="no shard"):
        select_shard(FakeStudy().jobs(), shard)


def test_contradictory_options_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="other shards"):
        compute(FakeStudy(), tmp_path, fresh=True, shard=(1, 2))
    with pytest.raises(ValueError, match="at least 1 worker"):
        compute(FakeStudy(), tmp_path, jobs=0)


def test_cheap_jobs_share_a_unit() -> None:
    study = FakeStudy([1e-6 * (i + 1) for i in range(999)])
    costs = [Cost(0.05, 1e5)] * 1000
    units = pack(study.jobs(), costs, workers=2)
    assert sorted(index for unit in units for index in unit) == list(range(1000))
    assert all(len(unit) == 40 for unit in units)


def test_long_jobs_have_their_own_unit_and_come_first() -> None:
    study = FakeStudy([1e-3, 2e-3, 3e-3, 4e-3])
    costs = [Cost(0.1, 1e5), Cost(30.0, 1e5), Cost(0.1, 1e5), Cost(60.0, 1e5), Cost(0.1, 1e5)]
    assert pack(study.jobs(), costs, workers=2) == [[3], [1], [0, 2, 4]]


def test_size_of_series_limits_a_unit() -> None:
    costs = [Cost(0.001, 5e7)] * 4
    assert [len(unit) for unit in pack(FakeStudy().jobs(), costs, workers=1)] == [2, 2]


def test_unit_duration_depends_on_the_study() -> None:
    assert unit_seconds(100.0, 2) == 2.0
    assert unit_seconds(6.0, 4) == 0.5  # short: three units for each worker
    assert unit_seconds(0.1, 64) == 0.25
    assert unit_seconds(500.0, 2) == 5.0  # long: fifty
    assert unit_seconds(1e6, 2) == 10.0
