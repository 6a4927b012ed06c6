"""Running studies by the workers of a dask scheduler: the processes are real, and on this machine."""

import json
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
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import store
from bearingsim.runner import Interrupted, RunSummary, WorkersDie, run
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy

pytest.importorskip("distributed", reason="needs the extra `cluster`")
from distributed import Client

from bearingsim.runner import cluster
from bearingsim.runner.delivery import OtherInstallation, needed

SCANNED = """\
study: small
bearing: nf308
speed: 1800 rpm
load: 150 N
model: static
defect: {shape: scan, file: map.csv}
sweep: {load: [150 N, 300 N]}
duration: 30 ms
settle: 10 ms
"""
WAIT_S = 60.0
SPOKEN = {"DASK_DISTRIBUTED__LOGGING__DISTRIBUTED": "warning"}


class Machines:
    """A scheduler and its workers: processes of their own, in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.started = folder, list[subprocess.Popen]()
        self.scheduler = self._start("scheduler", "--port", "0", "--host", "127.0.0.1", *self._file("first"))
        self.address = self._address("first")

    def _file(self, name: str) -> tuple[str, str]:
        return "--scheduler-file", str(self.folder / f"{name}.json")

    def _address(self, name: str) -> str:
        path = self.folder / f"{name}.json"
        until(lambda: path.exists() and path.read_text().endswith("}"))
        return str(json.loads(path.read_text())["address"])

    def _start(self, *words: str, **environment: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
        whole = os.environ | SPOKEN | environment
        with (self.folder / f"{words[0]}.log").open("a") as log:
            process = subprocess.Popen(
                command, cwd=self.folder, env=whole, stdout=log, stderr=log, start_new_session=True
            )
        self.started.append(process)
        return process

    def worker(self, *options: str, **environment: str) -> subprocess.Popen:
        """One that was started apart, with a nanny, which starts it anew when it dies."""
        names = ("--nthreads", "1", "--local-directory", str(self.folder / "scratch"))
        return self._start("worker", self.address, *names, *options, **environment)

    def die(self) -> None:
        """End the scheduler at once."""
        self.scheduler.kill()
        self.scheduler.wait()

    def again(self) -> None:
        """Another scheduler, where the first was."""
        port = self.address.rsplit(":", 1)[1]
        self.scheduler = self._start("scheduler", "--port", port, "--host", "127.0.0.1", *self._file("second"))
        self._address("second")

    def end(self) -> None:
        """Whatever happens: nothing of it stays."""
        for process in reversed(self.started):
            kill_all(process)


def kill_all(process: subprocess.Popen) -> None:
    """SIGKILL a process, and what it started: the nanny and its worker."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def until(done: Callable[[], Any], what: str = "") -> None:
    end = time.monotonic() + WAIT_S
    while not done():
        assert time.monotonic() < end, what
        time.sleep(0.05)


def workers_at(machines: Machines) -> int:
    with Client(machines.address, set_as_default=False) as client:
        return len(client.nthreads())


@contextmanager
def meanwhile(deed: Callable[[], None]) -> Iterator[None]:
    """Something happens in another thread."""
    thread = threading.Thread(target=deed)
    thread.start()
    try:
        yield
    finally:
        thread.join()


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    """A scheduler and two workers."""
    found = Machines(tmp_path_factory.mktemp("machines"))
    try:
        found.worker()
        found.worker()
        yield found
    finally:
        found.end()


def compute(study: Any, out: Path, address: str) -> RunSummary:
    return run(study, out, jobs=1, progress=False, engine=ENGINE, scheduler=address)


def counted(file: Path) -> Counter[str]:
    return Counter(file.read_text().split()) if file.exists() else Counter()


def journal_of(out: Path, event: str) -> list[dict[str, Any]]:
    lines = [json.loads(line) for path in out.glob("journal-*.jsonl") for line in path.read_text().splitlines()]
    return [line for line in lines if line["event"] == event]


def numbers_of(out: Path) -> pd.DataFrame:
    """All that was computed and found of it, but what tells of time."""
    frame = store.job_frame(out)
    assert "features/velocity@BPFO" in frame
    return frame.drop(columns=["unit", "stamp", "reason", *(name for name in frame if str(name).endswith("_s"))])


def same_series(first: Path, second: Path, jobs: list[str]) -> bool:
    one, two = store.open_results(first), store.open_results(second)
    return all(
        np.array_equal(data, two.series(job).channels[name])
        for job in jobs
        for name, data in one.series(job).channels.items()
    )


def test_results_are_those_of_a_local_run(tmp_path: Path, machines: Machines) -> None:
    study: Any = FakeStudy([1e-3 * n for n in range(1, 30)], deeds={3: "raise"}, seconds=0.02)
    summary = compute(study, tmp_path / "there", machines.address)
    local = run(study, tmp_path / "here", jobs=1, progress=False, engine=ENGINE)
    assert (summary.done, summary.failed) == (local.done, local.failed) == (29, 1)
    assert summary.failures == local.failures
    pd.testing.assert_frame_equal(numbers_of(tmp_path / "there"), numbers_of(tmp_path / "here"), check_exact=True)
    done = [job.id for n, job in enumerate(study.jobs()) if n != 3]
    assert same_series(tmp_path / "there", tmp_path / "here", done)
    assert not [*(tmp_path / "there").rglob("*.part"), *(tmp_path / "there").rglob("*.started")]
    assert compute(study, tmp_path / "there", machines.address).resumed == 29


def test_real_numbers_and_scans_travel(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where no worker is
    s, z = np.meshgrid(np.linspace(-0.5, 0.5, 11), np.linspace(-6.0, 6.0, 7))
    points = np.stack([s, z, np.where(np.abs(s) < 0.4, 50.0, 0.0)], axis=-1).reshape(-1, 3)
    np.savetxt("map.csv", points, delimiter=",", header="s [mm],z [mm],depth [um]", comments="")
    Path("small.yaml").write_text(SCANNED)
    type_("run", "small.yaml", "--jobs", "1", "--out", "here")
    said, _ = type_("run", "small.yaml", "--scheduler", machines.address, "--out", "there")
    assert "4 done of 4 jobs" in said
    here, there = numbers_of(Path("here")), numbers_of(Path("there"))
    pd.testing.assert_frame_equal(there, here, check_exact=True)
    assert same_series(Path("there"), Path("here"), list(here.index))


def test_a_job_that_kills_its_worker_fails_alone(tmp_path: Path, machines: Machines) -> None:
    out, count = tmp_path / "out", tmp_path / "count"
    study: Any = FakeStudy([1e-3 * n for n in range(1, 9)], deeds={3: f"kill {count}"}, seconds=0.05)
    summary = compute(study, out, machines.address)
    (failure,) = store.read_failures(out).values()
    assert (summary.done, summary.failed) == (8, 1)
    assert (failure.job, failure.attempts) == (study.jobs()[3].id, 2)
    assert "its worker died" in failure.reason
    assert counted(count) == {failure.job: 2}
    assert sum(failure.job in line["suspects"] for line in journal_of(out, "worker died")) == 2


def test_where_all_die_no_job_is_blamed(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "RESTARTS_WITHOUT_PROGRESS", 1)
    study: Any = FakeStudy(deeds=dict.fromkeys(range(3), "kill"))
    until(lambda: workers_at(machines) == 2, "a worker that died was not started anew")
    with pytest.raises(WorkersDie, match="no job is blamed"):
        compute(study, tmp_path, machines.address)
    assert not store.read_failures(tmp_path)


def test_stopping_lets_jobs_in_hand_end(tmp_path: Path, machines: Machines) -> None:
    until(lambda: workers_at(machines) == 2, "a worker that died was not started anew")
    out, count = tmp_path / "out", tmp_path / "count"
    widths = [1e-3 * n for n in range(1, 60)]
    study: Any = FakeStudy(widths, deeds=dict.fromkeys(range(60), f"count {count}"), seconds=0.05)

    def interrupt() -> None:
        until(lambda: counted(count).total() > 8)
        os.kill(os.getpid(), signal.SIGINT)

    with meanwhile(interrupt), pytest.raises(Interrupted) as stopped:
        compute(study, out, machines.address)
    summary = stopped.value.summary
    assert summary.exit_code == 130
    twin = {job.id for job in study.jobs() if job.is_baseline}
    assert 8 < summary.done < 30
    assert counted(count).keys() == store.holdings(out).sealed - twin  # nothing that was begun is lost
    assert compute(study, out, machines.address).done == 60 - summary.done
    assert set(counted(count).values()) == {1}


@pytest.mark.parametrize("late", [False, True])
def test_another_installation_is_refused(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch, late: bool
) -> None:
    ours = needed() | {"numpy": "1.0", "model version": "0"}
    monkeypatch.setattr(cluster, "needed", lambda: ours)
    if late:  # it came when the others had been asked
        monkeypatch.setattr(cluster.Cluster, "assembled", lambda self: 2)
    told = rf"worker tcp://\S+: numpy {np.__version__} in place of 1.0, model version \d+ in place of 0"
    with pytest.raises(OtherInstallation, match=told):
        compute(FakeStudy(), tmp_path, machines.address)
    assert not [*tmp_path.glob("units/??/*.h5")]


def test_a_worker_of_several_threads_is_refused(tmp_path: Path, machines: Machines) -> None:
    extra = machines.worker("--nthreads", "2", "--no-nanny")
    try:
        until(lambda: workers_at(machines) == 3)
        with pytest.raises(OtherInstallation, match=r"has 2 threads.*--nthreads 1 --nworkers 2"):
            compute(FakeStudy(), tmp_path, machines.address)
    finally:
        kill_all(extra)
        until(lambda: workers_at(machines) == 2)


def test_nobody_there_and_nothing_installed(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "JOINING_S", 0.5)
    words = ("run", "small.yaml", "--scheduler", "tcp://127.0.0.1:9")
    assert "no scheduler answers at tcp://127.0.0.1:9" in type_(*words, code=2)[1]
    monkeypatch.delitem(sys.modules, "bearingsim.runner.cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'bearingsim[cluster]'" in type_(*words, code=2)[1]


def test_a_worker_dies_and_then_the_scheduler(tmp_path: Path, machines: Machines) -> None:
    until(lambda: workers_at(machines) == 2)
    out, count, here = tmp_path / "out", tmp_path / "count", tmp_path / "here"
    widths = [1e-3 * n for n in range(1, 80)]
    deeds = dict.fromkeys(range(80), f"count {count}")
    study: Any = FakeStudy(widths, deeds=deeds, seconds=0.05)
    first = machines.started[1]

    def disaster() -> None:
        until(lambda: counted(count).total() > 10)
        kill_all(first)
        seen = counted(count).total()
        until(lambda: counted(count).total() > seen + 20)
        machines.die()

    with meanwhile(disaster), pytest.raises(cluster.SchedulerGone, match="give the command again"):
        compute(study, out, machines.address)
    until(lambda: machines.started[2].poll() is not None, "a worker stays when its scheduler has gone")
    before, sealed = counted(count), store.holdings(out).sealed
    suspects = {job for line in journal_of(out, "worker died") for job in line["suspects"]}
    assert 5 < len(sealed) < 80
    machines.again()
    machines.worker()
    machines.worker()
    summary = compute(study, out, machines.address)
    assert (summary.resumed, summary.done, summary.failed) == (len(sealed), 80 - len(sealed), 0)
    twice = {job for job, times in counted(count).items() if times > 1}
    assert twice <= suspects | (set(before) - sealed)  # what was under way, and no more
    assert all(counted(count)[job] == before[job] for job in sealed)
    run(study, here, jobs=1, progress=False, engine=ENGINE)
    pd.testing.assert_frame_equal(numbers_of(out), numbers_of(here), check_exact=True)
