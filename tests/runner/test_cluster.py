"""Studies computed by the workers of a dask scheduler, which are processes of this machine."""

import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import store
from bearingsim.runner import Interrupted, RepeatedWorkerDeaths, RunSummary, run
from bearingsim.runner.work import Outcome, Work
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy

pytest.importorskip("distributed", reason="needs the extra `cluster`")
from distributed import Client

from bearingsim.runner import cluster, delivery, handshake, packing, select
from bearingsim.runner.delivery import (
    Delivery,
    InstallationMismatch,
    Parcel,
    WorkerFailed,
    deliver,
    installation,
    required_installation,
    stop,
)

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
TIMEOUT_S = 60.0
LOGGING = {"DASK_DISTRIBUTED__LOGGING__DISTRIBUTED": "warning"}


class Machines:
    """Processes of a scheduler and its workers, with their files in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen]()
        self.scheduler = self._start(
            "scheduler", "--port", "0", "--host", "127.0.0.1", *self._file_options("first")
        )
        self.address = self._read_address("first")

    def _file_options(self, name: str) -> tuple[str, str]:
        return "--scheduler-file", str(self.folder / f"{name}.json")

    def _read_address(self, name: str) -> str:
        path = self.folder / f"{name}.json"
        wait_until(lambda: path.exists() and path.read_text().endswith("}"))
        return str(json.loads(path.read_text())["address"])

    def _start(self, *arguments: str, **environment: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
        variables = os.environ | LOGGING | environment
        with (self.folder / f"{arguments[0]}.log").open("a") as log:
            process = subprocess.Popen(
                command, cwd=self.folder, env=variables, stdout=log, stderr=log, start_new_session=True
            )
        self.processes.append(process)
        return process

    def worker(self, *options: str, **environment: str) -> subprocess.Popen:
        """Start a worker with a nanny, which restarts it when it dies."""
        names = ("--nthreads", "1", "--local-directory", str(self.folder / "scratch"))
        return self._start("worker", self.address, *names, *options, **environment)

    def kill_scheduler(self) -> None:
        """Kill the scheduler."""
        self.scheduler.kill()
        self.scheduler.wait()

    def restart_scheduler(self) -> None:
        """Start another scheduler at the same address."""
        port = self.address.rsplit(":", 1)[1]
        self.scheduler = self._start(
            "scheduler", "--port", port, "--host", "127.0.0.1", *self._file_options("second")
        )
        self._read_address("second")

    def end_all(self) -> None:
        """Kill all processes."""
        for process in reversed(self.processes):
            kill_all(process)


def kill_all(process: subprocess.Popen) -> None:
    """Send SIGKILL to a process and its children: a nanny and its worker."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def wait_until(done: Callable[[], Any], message: str = "") -> None:
    end = time.monotonic() + TIMEOUT_S
    while not done():
        assert time.monotonic() < end, message
        time.sleep(0.05)


def count_workers(machines: Machines) -> int:
    with Client(machines.address, set_as_default=False) as client:
        return len(client.nthreads())


@contextmanager
def in_thread(function: Callable[[], None]) -> Iterator[None]:
    """Run a function in another thread during the context."""
    thread = threading.Thread(target=function)
    thread.start()
    try:
        yield
    finally:
        thread.join()


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    """Start a scheduler and two workers."""
    machines = Machines(tmp_path_factory.mktemp("machines"))
    try:
        machines.worker()
        machines.worker()
        yield machines
    finally:
        machines.end_all()


class FakeClient:
    """Substitute for a client; a test sets its workers and lost units, and reads the recorded calls."""

    status = "running"

    def __init__(self, workers: int = 1) -> None:
        self.workers, self.active_keys, self.answers = workers, set[Any](), list[dict[str, Any]]()
        self.calls, self.cancelled, self.futures = list[Any](), list[Any](), list[Any]()
        self.check_count = 0
        self.scheduler = SimpleNamespace(gather=None)

    def register_plugin(self, plugin: Any) -> None:
        """Ignore the plugin, because no worker dies."""

    def nthreads(self) -> dict[str, int]:
        self.check_count += 1
        assert self.check_count < 200, "it does not end"
        return dict.fromkeys(map(str, range(self.workers)), 1)

    def map(self, function: Any, parcels: list[Any], key: list[Any], **options: Any) -> list[Any]:
        futures = [FakeFuture(entry) for entry in key]
        self.futures += futures
        return futures

    def run(self, function: Any, *arguments: Any, on_error: str) -> dict[str, Any]:
        self.calls.append(function)
        return {}

    def processing(self) -> dict[str, Any]:
        return {"0": self.active_keys}

    def who_has(self, futures: list[Any]) -> dict[Any, list[str]]:
        return {}

    def cancel(self, futures: list[Any]) -> None:
        self.cancelled += futures

    def sync(self, function: Any, keys: list[Any]) -> dict[str, Any]:
        return self.answers.pop(0)


class FakeFuture:
    """Future of a fake client; a test sets its status."""

    def __init__(self, key: Any) -> None:
        self.key, self.status = key, "pending"

    def add_done_callback(self, function: Callable[[Any], None]) -> None:
        self.end = function

    def set_status(self, status: str) -> None:
        self.status = status
        self.end(self)


def make_cluster(client: Any) -> Any:
    return cluster.Cluster(client, "tcp://somewhere")


def make_works(study: Any, root: Path) -> list[Work]:
    """Make a unit for each job."""
    return [Work(root, (job,), (0.1,), ENGINE, {}) for job in study.jobs()]


def make_delivery(work: Work) -> Delivery:
    return Delivery(Outcome(work.unit, tuple(job.id for job in work.jobs), ()), {})


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
    with pytest.raises(RepeatedWorkerDeaths, match="no job is blamed"):
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
    assert job_counts(count).keys() == store.holdings(out).sealed - baselines  # no started job is lost
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


def test_worker_with_several_threads_that_joins_late_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = SimpleNamespace(address="tcp://late:1", state=SimpleNamespace(nthreads=2))
    monkeypatch.setattr(delivery, "get_worker", lambda: worker)
    with pytest.raises(InstallationMismatch, match=r"worker tcp://late:1 has 2 threads"):
        deliver(Parcel(b"", {}, "", {}))


def test_several_threads_in_this_process_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "4")
    with pytest.raises(InstallationMismatch, match=r"OPENBLAS_NUM_THREADS=4 is set.*unset it"):
        required_installation()


def test_worker_lost_during_a_request_is_omitted(monkeypatch: pytest.MonkeyPatch) -> None:
    client: Any = FakeClient()
    answers: dict[str, Any] = {"there": {"numpy": "1"}, "gone": OSError("closed")}
    monkeypatch.setattr(client, "run", lambda *arguments, on_error: answers)
    assert make_cluster(client)._run_on_all(installation) == {"there": {"numpy": "1"}}
    answers["broken"] = ImportError("numba")
    with pytest.raises(InstallationMismatch, match="worker broken cannot load bearingsim: numba"):
        make_cluster(client).wait_for_workers()


def test_stop_request_ends_a_run_without_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client = FakeClient(workers=0)
    monkeypatch.setattr(cluster, "stop_requested", lambda: bool(client.futures))
    assert not list(make_cluster(client)._compute(make_works(FakeStudy(), tmp_path), None))
    assert client.cancelled == client.futures
    assert len(client.futures) == 4


def test_stop_request_reaches_workers_that_join_later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client, works = FakeClient(), make_works(FakeStudy(), tmp_path)
    monkeypatch.setattr(cluster, "stop_requested", lambda: bool(client.futures))
    monkeypatch.setattr(cluster, "POLL_S", 0.01)
    monkeypatch.setattr(cluster, "WORKER_CHECK_S", 0.02)

    def run(function: Any, *arguments: Any, on_error: str) -> None:
        client.calls.append(function)
        client.active_keys = {client.futures[0].key}
        if len(client.calls) == 3:
            client.answers = [{"status": "OK", "data": {client.futures[0].key: make_delivery(works[0])}}]
            client.futures[0].set_status("finished")

    monkeypatch.setattr(client, "run", run)
    outcomes = list(make_cluster(client)._compute(works, None))
    assert outcomes == [make_delivery(works[0]).outcome]  # a unit in progress is awaited
    assert client.cancelled == client.futures[1:]
    assert client.calls == [stop] * 3


def test_lost_unit_is_awaited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client, works = FakeClient(), make_works(FakeStudy([1e-3]), tmp_path)
    monkeypatch.setattr(cluster, "POLL_S", 0.01)
    monkeypatch.setattr(cluster, "WORKER_CHECK_S", 0.1)
    cluster_run = make_cluster(client)
    outcomes, counts = cluster_run._compute(works, None), Counter[str]()
    finished_futures = cluster_run._finished_futures

    def count_futures(submitted: Any) -> Any:
        if not counts["rounds"]:
            client.futures[0].set_status("finished")
            client.futures[1].set_status("lost")
        counts["rounds"] += 1
        futures = finished_futures(submitted)
        counts["looked at"] += len(futures)
        if counts["looked at"] == 6:
            client.futures[1].status = "finished"
        return futures

    monkeypatch.setattr(cluster_run, "_finished_futures", count_futures)
    keys = [(f"bearingsim-{cluster_run.run_id}", n) for n in range(2)]
    client.answers = [  # its worker dies before it is fetched
        {"status": "error", "keys": [keys[0]]},
        {"status": "OK", "data": {keys[0]: make_delivery(works[0])}},
        {"status": "OK", "data": {keys[1]: make_delivery(works[1])}},
    ]
    assert list(outcomes) == [make_delivery(work).outcome for work in works]
    assert counts["rounds"] < 100
    assert not client.answers


def test_delivery_of_unsent_jobs_is_refused(tmp_path: Path) -> None:
    client, works = FakeClient(), make_works(FakeStudy([1e-3]), tmp_path)
    cluster_run = make_cluster(client)
    submitted = cluster_run._submit(works)
    client.answers = [{"status": "OK", "data": {client.futures[0].key: make_delivery(works[1])}}]
    client.futures[0].set_status("finished")
    with pytest.raises(WorkerFailed, match="jobs that were not sent"):
        list(cluster_run._collect(submitted))


def test_wrong_address_is_reported_before_the_trials(study_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: Any) -> None:
        raise AssertionError("models are tried")

    monkeypatch.setattr(handshake, "CONNECTION_S", 0.5)
    monkeypatch.setattr(select, "_decide", fail)
    text = Path("small.yaml").read_text().partition("figures:")[0].replace("  model: [static, ring]\n", "")
    Path("wanted.yaml").write_text(f"{text}accuracy: {{within: 5 %, of: [velocity.rms]}}\n")
    arguments = ("run", "wanted.yaml", "--scheduler", "tcp://127.0.0.1:9")
    assert "no scheduler responds at tcp://127.0.0.1:9" in type_(*arguments, code=2)[1]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "http://127.0.0.1:9", "tcp://127.0.0.1", "nonsense"])
def test_no_client_is_created_without_a_scheduler(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    """A client would wait for half a minute and ignore Ctrl-C."""

    def fail(*arguments: Any, **options: Any) -> None:
        raise AssertionError("a client is made")

    monkeypatch.setattr(handshake, "_Client", fail)
    with pytest.raises(handshake.SchedulerUnreachable) as error, cluster.connect_cluster(address):
        pass
    reason = "no scheduler responds" if address == "tcp://127.0.0.1:9" else "cannot be used"
    assert reason in str(error.value)


def test_missing_scheduler_and_missing_package_are_reported(
    study_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handshake, "CONNECTION_S", 0.5)
    arguments = ("run", "small.yaml", "--scheduler", "tcp://127.0.0.1:9")
    assert "no scheduler responds at tcp://127.0.0.1:9" in type_(*arguments, code=2)[1]
    monkeypatch.delitem(sys.modules, "bearingsim.runner.cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'bearingsim[cluster]'" in type_(*arguments, code=2)[1]


def test_run_resumes_after_the_loss_of_a_worker_and_the_scheduler(
    tmp_path: Path, machines: Machines, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_until(lambda: count_workers(machines) == 2)
    monkeypatch.setattr(logging.getLogger("distributed.client"), "propagate", True)
    for constant in ("UNIT_S", "SHORTEST_UNIT_S"):
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
    before, sealed = job_counts(count), store.holdings(out).sealed
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
