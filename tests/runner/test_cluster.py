"""Studies computed by the workers of a dask scheduler, which are processes of this machine."""

import json
import logging
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import store
from bearingsim.runner import Interrupted, RepeatedWorkerDeaths, RunSummary, run
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy

pytest.importorskip("distributed", reason="needs the extra `cluster`")

from bearingsim.runner import cluster, handshake, packing
from bearingsim.runner.delivery import InstallationMismatch, required_installation
from tests.scenes.machines import Machines, count_workers, kill_all, machines, wait_until

__all__ = ["machines"]

SCANNED = """\
study: small
bearing: nf308
speed: 1800 rpm
load: 150 N
model: static
defect: {shape: scan, file: map.csv}
surfaces: {outer: {roundness: race.csv}}
sweep: {load: [150 N, 300 N]}
duration: 30 ms
settle: 10 ms
"""


@contextmanager
def in_thread(function: Callable[[], None]) -> Iterator[None]:
    """Run a function in another thread during the context."""
    thread = threading.Thread(target=function)
    thread.start()
    try:
        yield
    finally:
        thread.join()


def compute(study: Any, out: Path, address: str) -> RunSummary:
    return run(study, out, jobs=1, progress=False, engine=ENGINE, scheduler=address)


def job_counts(path: Path) -> Counter[str]:
    return Counter(path.read_text().split()) if path.exists() else Counter()


def journal_entries(out: Path, event: str) -> list[dict[str, Any]]:
    lines = [json.loads(line) for path in out.glob("journal-*.jsonl") for line in path.read_text().splitlines()]
    return [line for line in lines if line["event"] == event]


def computed_values(out: Path) -> pd.DataFrame:
    """Return all computed values except times."""
    frame = store.job_frame(out)
    assert "features/velocity@BPFO" in frame
    return frame.drop(columns=["unit", "stamp", "reason", *(name for name in frame if str(name).endswith("_s"))])


def is_same_series(first: Path, second: Path, jobs: list[str]) -> bool:
    first_results, second_results = store.open_results(first), store.open_results(second)
    return all(
        np.array_equal(data, second_results.series(job).channels[name])
        for job in jobs
        for name, data in first_results.series(job).channels.items()
    )


def test_results_equal_those_of_a_local_run(tmp_path: Path, machines: Machines) -> None:
    study: Any = FakeStudy([1e-3 * n for n in range(1, 30)], actions={3: "raise"}, seconds=0.02)
    summary = compute(study, tmp_path / "there", machines.address)
    local = run(study, tmp_path / "here", jobs=1, progress=False, engine=ENGINE)
    assert (summary.done, summary.failed) == (local.done, local.failed) == (29, 1)
    assert summary.failures == local.failures
    pd.testing.assert_frame_equal(
        computed_values(tmp_path / "there"), computed_values(tmp_path / "here"), check_exact=True
    )
    done = [job.id for n, job in enumerate(study.jobs()) if n != 3]
    assert is_same_series(tmp_path / "there", tmp_path / "here", done)
    assert not [*(tmp_path / "there").rglob("*.part"), *(tmp_path / "there").rglob("*.started")]
    assert compute(study, tmp_path / "there", machines.address).resumed == 29


def test_real_results_and_scans_equal_those_of_a_local_run(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a folder without workers
    s, z = np.meshgrid(np.linspace(-0.5, 0.5, 11), np.linspace(-6.0, 6.0, 7))
    points = np.stack([s, z, np.where(np.abs(s) < 0.4, 50.0, 0.0)], axis=-1).reshape(-1, 3)
    np.savetxt("map.csv", points, delimiter=",", header="s [mm],z [mm],depth [um]", comments="")
    angles = np.arange(0.0, 360.0, 0.5)
    profile = np.stack([angles, 0.2 * np.cos(np.radians(12.0 * angles))], axis=-1)
    np.savetxt("race.csv", profile, delimiter=",", header="angle [deg],deviation [um]", comments="")
    Path("small.yaml").write_text(SCANNED)
    type_("run", "small.yaml", "--jobs", "1", "--out", "here")
    output, _ = type_("run", "small.yaml", "--scheduler", machines.address, "--out", "there")
    assert "4 of 4 jobs done" in output
    local_values, cluster_values = computed_values(Path("here")), computed_values(Path("there"))
    pd.testing.assert_frame_equal(cluster_values, local_values, check_exact=True)
    assert is_same_series(Path("there"), Path("here"), list(local_values.index))


def test_only_the_job_that_kills_its_worker_fails(tmp_path: Path, machines: Machines) -> None:
    out, count = tmp_path / "out", tmp_path / "count"
    study: Any = FakeStudy([1e-3 * n for n in range(1, 9)], actions={3: f"kill {count}"}, seconds=0.05)
    summary = compute(study, out, machines.address)
    (failure,) = store.read_failures(out).values()
    assert (summary.done, summary.failed) == (8, 1)
    assert (failure.job, failure.attempts) == (study.jobs()[3].id, 2)
    assert "its worker died" in failure.reason
    assert job_counts(count) == {failure.job: 2}
    assert sum(failure.job in line["suspects"] for line in journal_entries(out, "worker died")) == 2


def test_no_job_fails_if_all_workers_die(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "RESTARTS_WITHOUT_PROGRESS", 1)
    study: Any = FakeStudy(actions=dict.fromkeys(range(3), "kill"))
    wait_until(lambda: count_workers(machines) == 2, "a worker that died was not started anew")
    with pytest.raises(RepeatedWorkerDeaths, match="no job counts as failed"):
        compute(study, tmp_path, machines.address)
    assert not store.read_failures(tmp_path)


def test_running_jobs_finish_after_a_stop_request(tmp_path: Path, machines: Machines) -> None:
    wait_until(lambda: count_workers(machines) == 2, "a worker that died was not started anew")
    out, count = tmp_path / "out", tmp_path / "count"
    widths = [1e-3 * n for n in range(1, 200)]  # 5 s: on a busy machine the signal comes late
    study: Any = FakeStudy(widths, actions=dict.fromkeys(range(200), f"count {count}"), seconds=0.05)

    def interrupt() -> None:
        wait_until(lambda: job_counts(count).total() > 8)
        os.kill(os.getpid(), signal.SIGINT)

    with in_thread(interrupt), pytest.raises(Interrupted) as interruption:
        compute(study, out, machines.address)
    summary = interruption.value.summary
    assert summary.exit_code == 130
    baselines = {job.id for job in study.jobs() if job.is_baseline}
    assert 8 < summary.done < 200
    assert job_counts(count).keys() == store.read_holdings(out).sealed - baselines  # no started job is lost
    assert compute(study, out, machines.address).done == 200 - summary.done
    assert set(job_counts(count).values()) == {1}


@pytest.mark.parametrize("joins_late", [False, True])
def test_worker_with_another_installation_is_refused(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch, joins_late: bool
) -> None:
    installed = required_installation() | {"numpy": "1.0", "model version": "0"}
    monkeypatch.setattr(cluster, "required_installation", lambda: installed)
    if joins_late:  # it joined after the check of the others
        monkeypatch.setattr(cluster.Cluster, "wait_for_workers", lambda self: 2)
    message = rf"worker tcp://\S+: numpy {np.__version__} instead of 1.0, model version \d+ instead of 0"
    with pytest.raises(InstallationMismatch, match=message):
        compute(FakeStudy(), tmp_path, machines.address)
    assert not [*tmp_path.glob("units/??/*.h5")]


def test_worker_with_several_threads_is_refused(tmp_path: Path, machines: Machines) -> None:
    extra = machines.worker("--nthreads", "2", "--no-nanny")
    try:
        wait_until(lambda: count_workers(machines) == 3)
        with pytest.raises(InstallationMismatch, match=r"has 2 threads.*--nthreads 1 --nworkers 2"):
            compute(FakeStudy(), tmp_path, machines.address)
    finally:
        kill_all(extra)
        wait_until(lambda: count_workers(machines) == 2)


def test_run_resumes_after_the_loss_of_a_worker_and_the_scheduler(
    tmp_path: Path, machines: Machines, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_until(lambda: count_workers(machines) == 2)
    monkeypatch.setattr(logging.getLogger("distributed.client"), "propagate", True)
    for constant in ("UNIT_S", "MIN_UNIT_S"):
        monkeypatch.setattr(packing, constant, 0.1)  # two jobs are a unit
    out, count, local = tmp_path / "out", tmp_path / "count", tmp_path / "here"
    widths = [1e-3 * n for n in range(1, 80)]
    actions = dict.fromkeys(range(80), f"count {count}")
    study: Any = FakeStudy(widths, actions=actions, seconds=0.05)
    first_worker = machines.processes[1]

    def kill() -> None:
        wait_until(lambda: job_counts(count).total() > 10)
        kill_all(first_worker)
        done_count = job_counts(count).total()
        wait_until(lambda: job_counts(count).total() > done_count + 20)
        machines.kill_scheduler()

    with in_thread(kill), pytest.raises(handshake.SchedulerUnreachable, match="run the command again"):
        compute(study, out, machines.address)
    assert not caplog.records  # the message replaces the log
    wait_until(lambda: machines.processes[2].poll() is not None, "a worker stays when its scheduler has gone")
    before, sealed = job_counts(count), store.read_holdings(out).sealed
    suspects = {job for line in journal_entries(out, "worker died") for job in line["suspects"]}
    assert 5 < len(sealed) < 80
    machines.restart_scheduler()
    machines.worker()
    machines.worker()
    summary = compute(study, out, machines.address)
    assert (summary.resumed, summary.done, summary.failed) == (len(sealed), 80 - len(sealed), 0)
    repeated = {job for job, count in job_counts(count).items() if count > 1}
    assert (
        len(repeated) <= 2 * 2 * 2
    )  # two workers, each with the two jobs of a running unit and of one in transit
    assert repeated <= suspects | (set(before) - sealed)  # only jobs in progress
    assert all(job_counts(count)[job] == before[job] for job in sealed)
    run(study, local, jobs=1, progress=False, engine=ENGINE)
    pd.testing.assert_frame_equal(computed_values(out), computed_values(local), check_exact=True)
