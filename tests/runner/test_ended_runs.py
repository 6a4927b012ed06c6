"""Runs that end early: Ctrl-C, signals to the pool, SIGKILL."""

import contextlib
import os
import random
import signal
import sys
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim import store
from bearingsim.runner import Interrupted
from tests.scenes.fake_runs import assert_tidy, compute, other_process, table_of
from tests.scenes.fake_studies import FakeStudy

# Interruptions


def test_interrupted_run_keeps_finished_jobs(tmp_path: Path) -> None:
    study = FakeStudy([1e-3, 2e-3, 3e-3], actions={2: "interrupt"}, seconds=0.3)
    with pytest.raises(Interrupted) as interruption:
        compute(study, tmp_path)
    summary = interruption.value.summary
    assert (summary.done, summary.missing, summary.exit_code) == (2, 2, 130)
    assert list(table_of(tmp_path)["status"]) == ["done", "done", "missing", "missing"]
    assert_tidy(tmp_path)
    study.actions = {}
    assert compute(study, tmp_path).resumed >= 1


def wait_for(condition: Any, timeout: float = 20.0) -> None:
    """Poll until a condition is true; fail the test at the timeout."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


SIGNALS = ["SIGINT", "SIGTERM", "SIGHUP"]


@pytest.mark.parametrize("name", SIGNALS)
def test_running_job_finishes_and_is_stored_after_a_signal(tmp_path: Path, name: str) -> None:
    study = FakeStudy([1e-3 * (i + 1) for i in range(9)], actions={4: f"signal {name}"})  # one unit
    before = signal.getsignal(getattr(signal, name))
    with pytest.raises(Interrupted) as interruption:
        compute(study, tmp_path)
    number = getattr(signal, name)
    assert interruption.value.number == number
    assert interruption.value.summary.exit_code == 128 + number
    assert (interruption.value.summary.done, interruption.value.summary.missing) == (5, 5)
    assert list(table_of(tmp_path)["status"]) == ["done"] * 5 + ["missing"] * 5
    assert signal.getsignal(number) == before
    study.actions[4] = "signal SIGURG"
    assert compute(study, tmp_path).resumed == 4


@pytest.mark.parametrize("name", SIGNALS)
def test_signals_end_a_pool_cleanly(tmp_path: Path, name: str) -> None:
    number = getattr(signal, name)
    with other_process(tmp_path, jobs=2, count=600, seconds=0.1) as process:  # more than a busy machine gets done
        wait_for(lambda: any(len(path.read_text().split()) > 2 for path in tmp_path.glob("units/??/*.started")))
        os.killpg(process.pid, number)
        output, _ = process.communicate(timeout=20)
    assert process.returncode == 128 + number
    assert "of 601 jobs done" in output
    assert list(table_of(tmp_path)["status"]).count("done") >= 3  # of units of twenty
    assert_tidy(tmp_path)


def test_signal_ends_a_run_although_a_worker_dies_then(tmp_path: Path) -> None:
    """The jobs of a dead worker are repeated, but not after a signal."""
    with other_process(tmp_path, jobs=2, count=600, seconds=0.3) as process:
        wait_for(lambda: any(path.read_text() for path in tmp_path.glob("units/??/*.started")))
        worker = int(next(tmp_path.glob("units/??/*.started")).stem.split("-")[-2])
        process.send_signal(signal.SIGTERM)
        time.sleep(0.1)
        os.kill(worker, signal.SIGKILL)
        output, _ = process.communicate(timeout=20)
    assert process.returncode == 128 + signal.SIGTERM
    assert "of 601 jobs done" in output
    assert not list(tmp_path.glob("failed/*"))
    assert_tidy(tmp_path)


def test_a_second_signal_ends_at_once(tmp_path: Path) -> None:
    with other_process(tmp_path, jobs=2, count=2, seconds=30.0) as process:
        wait_for(lambda: len([*tmp_path.glob("units/??/*.started")]) == 2)
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.2)
        assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(timeout=5) == -signal.SIGINT


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_workers_die_with_their_parent(tmp_path: Path) -> None:
    with other_process(tmp_path, jobs=2, count=2, seconds=30.0) as process:
        wait_for(lambda: len([*tmp_path.glob("units/??/*.started")]) == 2)
        workers = [int(path.stem.split("-")[-2]) for path in tmp_path.glob("units/??/*.started")]
        process.kill()
        process.wait()
        assert len(workers) == 2
        wait_for(lambda: not any(is_running(pid) for pid in workers), timeout=2.0)
        assert [pid for pid in workers if is_running(pid)] == []


def is_running(pid: int) -> bool:
    """Check if a process exists and is not a zombie."""
    with contextlib.suppress(FileNotFoundError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def test_sigkill_at_any_time_loses_no_stored_job(tmp_path: Path) -> None:
    count, seconds = 24, 0.03
    undisturbed = FakeStudy([1e-3 * (i + 1) for i in range(count)], seconds=seconds)
    compute(undisturbed, tmp_path / "undisturbed", 2)
    out, moments = tmp_path / "killed", random.Random(5)
    sealed = 0
    for _ in range(5):
        with other_process(out, 2, count, seconds) as process:
            wait_for(lambda: (out / "plan.json").exists())
            time.sleep(moments.uniform(0.3, 1.2))
            process.send_signal(signal.SIGKILL)
            process.wait()
        units = list(out.glob("units/??/*.h5"))
        for path in units:
            store.check_unit(path)
        assert len(units) >= sealed
        sealed = len(units)
    summary = compute(undisturbed, out, 2)
    assert summary.resumed + summary.done == count + 1
    assert_tidy(out)
    features = [name for name in table_of(out).columns if "velocity" in name]
    pd.testing.assert_frame_equal(
        table_of(out)[["job", *features]], table_of(tmp_path / "undisturbed")[["job", *features]], check_exact=True
    )
