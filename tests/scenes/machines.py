"""A dask scheduler and its workers as processes of this machine, with their files in a folder."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from distributed import Client

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
