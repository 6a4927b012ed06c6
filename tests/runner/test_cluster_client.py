"""A run and the answers of a scheduler, with a substitute for the client, without processes."""

import resource
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bearingsim import store
from bearingsim.runner.work import Outcome, Work
from bearingsim.store.marker import mark
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy

pytest.importorskip("distributed", reason="needs the extra `cluster`")

from bearingsim.runner import cluster, delivery, handshake, select
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


def test_scan_on_a_full_disk_of_a_worker_is_written_again(tmp_path: Path) -> None:
    """A part of it would fail the jobs of the next run, as a scan that has changed."""
    name, content = f"{'0' * 16}.csv", b"s [mm],z [mm],depth [um]\n" * 100
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises((OSError, store.DiskFull)), delivery._provide_scans({name: content}, tmp_path):
            pass
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    with delivery._provide_scans({name: content}, tmp_path):
        assert (tmp_path / "scans" / name).read_bytes() == content


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


def test_wrong_address_is_reported_before_results_are_deleted(
    study_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handshake, "CONNECTION_S", 0.5)
    unit = Path("results/small/units/01/0123456789abcdef.h5")
    unit.parent.mkdir(parents=True)
    unit.touch()
    mark(Path("results/small"), "results", "small")
    arguments = ("run", "small.yaml", "--fresh", "--scheduler", "tcp://127.0.0.1:9")
    assert "no scheduler responds at tcp://127.0.0.1:9" in type_(*arguments, code=2)[1]
    assert unit.is_file()


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
