"""Overhead of a dask scheduler per unit of work, with empty units and two local workers.

    nice -n 10 python -m benchmarks.cluster [--units 100000] [--out FOLDER]

Each unit has one job with its own case, which returns 60 features immediately. As in a run, a worker writes them
to a file, whose bytes are returned and stored in the results folder. Time, CPU time and memory are printed.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil

from bearingsim import store
from bearingsim.runner.cluster import connect_cluster
from bearingsim.runner.work import Engine, Work
from bearingsim.study import Job, Study, load_study

STUDY = """\
study: many
bearing: nf308
rig: bvt5
speed: 1800 rpm
load: 150 N
model: rollers
defect: {race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}
"""
ENGINE = Engine("benchmarks.cluster:record", warm="benchmarks.cluster:skip_warm_up")
FEATURES = {f"feature.{n}": float(n) for n in range(60)}
REPORT_INTERVAL = 10_000


def skip_warm_up(cases: Any) -> None:
    """Skip compilation."""


def record(case: Any) -> Any:
    """Return a result without series."""
    return SimpleNamespace(time=[], series={}, features=FEATURES, info={"step_s": 1e-6, "model": "none"})


@dataclass(frozen=True)
class Usage:
    """Resources of a process: CPU time (s) and current memory (bytes)."""

    cpu: float
    memory: int

    @classmethod
    def read(cls, process: psutil.Process) -> "Usage":
        times = process.cpu_times()
        return cls(times.user + times.system, process.memory_info().rss)


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, psutil.Process]]:
    """Start a scheduler and two workers; yield its address and its process."""
    scheduler_file = folder / "scheduler.json"
    dask = (sys.executable, "-m", "dask")
    options = ("--no-dashboard", "--host", "127.0.0.1")
    commands: list[tuple[str, ...]] = [
        (*dask, "scheduler", *options, "--port", "0", "--scheduler-file", str(scheduler_file))
    ]
    worker_options = ("--nthreads", "1", "--local-directory", str(folder))
    commands += [(*dask, "worker", *options, *worker_options, "--scheduler-file", str(scheduler_file))] * 2
    with (folder / "log").open("w") as log:
        processes = [subprocess.Popen(command, stdout=log, stderr=log) for command in commands]
        try:
            while not (scheduler_file.exists() and scheduler_file.read_text().endswith("}")):
                time.sleep(0.1)
            (address,) = (word for word in scheduler_file.read_text().split('"') if word.startswith("tcp://"))
            yield address, psutil.Process(processes[0].pid)
        finally:
            for process in reversed(processes):
                process.terminate()
            for process in processes:
                process.wait()


def work_units(study: Study, root: Path, count: int) -> list[Work]:
    """Make units of one job, each with a different load."""
    case, provenance = study.cases()[0], store.provenance(study)
    cases = (case.model_copy(update={"load": 100.0 + 1e-3 * n}) for n in range(count))
    jobs = (Job(case, {"load": case.load}) for case in cases)
    return [Work(root, (job,), (1.0,), ENGINE, provenance) for job in jobs]


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--units", type=int, default=100_000)
    parser.add_argument("--out", type=Path, help="results folder (default: a passing one)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "study.yaml").write_text(STUDY)
        root = options.out or folder / "results"
        root.mkdir(parents=True, exist_ok=True)
        study = load_study(folder / "study.yaml", {}, False)
        with cluster(folder) as (address, scheduler):
            measure(work_units(study, root, options.units), address, scheduler)


def measure(units: list[Work], address: str, scheduler: psutil.Process) -> None:
    """Send the units, printing resources at intervals."""
    client = psutil.Process()
    print(f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} CPUs")
    print(f"{'units':>8} {'ms/unit':>8}   CPU ms/unit of client, scheduler;  MB of client, scheduler")
    with connect_cluster(address) as workers:
        workers.wait_for_workers()
        initial = {"client": Usage.read(client), "scheduler": Usage.read(scheduler)}
        began = time.perf_counter()
        for count, _ in enumerate(workers.outcomes(units), 1):
            if count % REPORT_INTERVAL == 0 or count == len(units):
                print_row(count, time.perf_counter() - began, initial, Usage.read(client), Usage.read(scheduler))
    print(f"load of the machine {os.getloadavg()[0]:.1f}")


def print_row(count: int, seconds: float, initial: Mapping[str, Usage], client: Usage, scheduler: Usage) -> None:
    cpu = [
        1e3 * (current.cpu - initial[name].cpu) / count
        for name, current in (("client", client), ("scheduler", scheduler))
    ]
    row = f"{count:8} {1e3 * seconds / count:8.2f} {cpu[0]:8.2f} {cpu[1]:8.2f}"
    print(f"{row} {client.memory / 1e6:8.0f} {scheduler.memory / 1e6:8.0f}", flush=True)


if __name__ == "__main__":
    main()
