"""Compile time of each model: CPU time of a process with an empty cache minus that of a second one."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from typing import Any

from benchmarks.speed.report import Section, Target

MAX_CPU = {"static": None, "ring": None, "rollers": 7.0, "planar": 15.0, "spatial": 25.0}
"""Largest CPU time (s) of a first run beyond that of a second one, by model."""
SCRIPT = """\
import sys, time
from bearingsim.simulation import simulate
from benchmarks.speed.scenes import case
simulate(case(sys.argv[1], duration="63 ms", record=[]))
print(time.process_time())
"""


def section(report: Section) -> None:
    """Run each model twice with its own cache, which is empty at first."""
    rows: list[list[Any]] = []
    for model, max_cpu in MAX_CPU.items():
        with tempfile.TemporaryDirectory() as cache:
            first, second = (process_time(model, {"BEARINGSIM_CACHE": cache}) for _ in range(2))
        rows.append([model, first, second, first - second])
        if max_cpu is not None:
            title = f"CPU s of a first run of {model} over a warm one"
            report.targets.append(Target(title, first - second, at_most=max_cpu))
    report.add_table("Compiling, CPU s of a process", ["model", "first", "second", "compiling"], rows)
    report.prices |= {("compile", model): compiling for model, _, _, compiling in rows}


def process_time(model: str, environment: Mapping[str, str]) -> float:
    """Return the CPU time (s) of a process that computes the scene once, including start-up."""
    command = [sys.executable, "-c", SCRIPT, model]
    process = subprocess.run(
        command, env=os.environ | dict(environment), check=True, capture_output=True, text=True
    )
    return float(process.stdout)
