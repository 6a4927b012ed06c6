"""Running studies by the workers of a dask scheduler: the processes are real, and on this machine."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
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
from bearingsim.runner import cluster  # noqa: E402

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
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()


def until(done: Callable[[], Any], what: str = "") -> None:
    end = time.monotonic() + WAIT_S
    while not done():
        assert time.monotonic() < end, what
        time.sleep(0.05)


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
    frame = store.open_results(out).table()
    return frame[[name for name in frame if name.startswith(("features/", "parameters/"))]].sort_index()


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
