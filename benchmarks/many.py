"""Cost of a study of many jobs without its computation: check, run of finished jobs, show, plot, disk space.

    python -m benchmarks.many [--jobs 100000] [--out results/many]

Only one job is computed; the others have its record and features with different noise. The series of a job take 3
kB. Each command runs in a separate process, whose CPU time and peak memory are printed.
"""

import argparse
import multiprocessing
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim import runner
from bearingsim.config import Case
from bearingsim.runner import Engine
from bearingsim.simulation import simulate
from bearingsim.simulation.record import Record
from bearingsim.study import load_study
from bearingsim.study.jobs import identity

ENGINE = Engine("benchmarks.many:noisy_copy", "benchmarks.many:free_estimate", "benchmarks.many:skip_warm_up")
STUDY = """\
study: many
bearing: nf308
model: static
speed: 1800 rpm
duration: 36 ms
record: [ring.velocity]
defect: {{race: outer, shape: rectangular, length: 12 mm}}
sweep:
  load: {{linspace: [150 N, 300 N, 10]}}
  defect.width: {{linspace: [0.2 mm, 2 mm, {widths}]}}
  defect.depth: {{linspace: [1 um, 50 um, 20]}}
  defect.angle: {{linspace: [0 deg, 60 deg, 10]}}
figures:
  - {{y: velocity.rms, x: defect.width, by: load, where: {{defect.angle: 0 deg, defect.depth: 50 um}}}}
"""
NOISE = 1e-6  # m/s


@cache
def base_record() -> Record:
    """Compute the record from which all others are made."""
    path = Path("results/many-one.yaml")
    path.parent.mkdir(exist_ok=True)
    path.write_text(STUDY.format(widths=2))
    return simulate(load_study(path).cases()[0])


def noisy_copy(case: Case) -> Record:
    """Return a copy of the record with noise that depends on the case."""
    noise = np.random.default_rng(int(identity(case), 16))
    series = {
        name: values + noise.normal(0.0, NOISE, values.shape) for name, values in base_record().series.items()
    }
    return replace(
        base_record(),
        series=series,
        features={name: value * noise.random() for name, value in base_record().features.items()},
    )


class FreeEstimate:
    """Cost estimate of a job that is not computed."""

    cpu_seconds, bytes, max_memory, max_seconds = 1e-3, 3000, 0.0, 1e-3


def free_estimate(case: Case) -> Any:
    """Return the cost estimate of a job that is not computed."""
    return FreeEstimate


def skip_warm_up(cases: list[Case], on_compile: Callable[..., Any] | None = None) -> None:
    """Skip compilation."""


def print_cost(*command: str) -> None:
    """Print CPU time and peak memory of a command."""
    with open(os.devnull) as devnull:
        began = time.perf_counter()
        child = subprocess.Popen(
            [sys.executable, "-m", "bearingsim", *command], stdin=devnull, stdout=subprocess.PIPE, text=True
        )
        assert child.stdout is not None
        output = child.stdout.read()
        _, status, usage = os.wait4(child.pid, 0)
    took = time.perf_counter() - began
    assert status == 0, f"bearingsim {' '.join(command)} ended with {status}:\n{output}"
    cpu = usage.ru_utime + usage.ru_stime
    print(f"{command[0]:6} {cpu:7.1f} s CPU, {took:6.1f} s, {usage.ru_maxrss / 1e3:6.0f} MB", flush=True)


def fill(study: Path, results: Path) -> None:
    """Make the results, and print their size."""
    summary = runner.run(load_study(study), results, jobs=1, progress=False, engine=ENGINE)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    print(f"made   {summary.done} jobs, {usage.ru_utime:.0f} s CPU, {usage.ru_maxrss / 1e3:.0f} MB")
    units = sum(path.stat().st_size for path in (results / "units").rglob("*.h5"))
    total = sum(path.stat().st_size for path in results.rglob("*") if path.is_file())
    print(
        f"disk   {units / summary.planned:.0f} bytes a job in units, {total / summary.planned:.0f} in all",
        flush=True,
    )


def main() -> None:
    """Make the results, then measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=100_000)
    parser.add_argument("--out", type=Path, default=Path("results/many"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    study = options.out / "many.yaml"
    study.write_text(STUDY.format(widths=max(2, ceil(options.jobs / 2000))))
    print_cost("check", str(study))
    results = options.out / "results"
    process = multiprocessing.get_context("spawn").Process(target=fill, args=(study, results))
    process.start()  # in a process, since a child's peak memory includes that of its parent
    process.join()
    for command in (["run", str(study), "--out"], ["show"], ["plot"]):
        print_cost(*command, str(results))


if __name__ == "__main__":
    main()
