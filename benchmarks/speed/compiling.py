"""What a first use compiles: CPU time of a process with an empty cache over that of a second one."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from typing import Any

from benchmarks.speed.report import Section, Target

MOST = {"static": None, "ring": None, "rollers": 7.0, "planar": 15.0, "spatial": 25.0}
"""Models, and the CPU seconds that a first run may take over a warm one."""
FIRST = """\
import sys, time
from bearingsim.simulation import simulate
from benchmarks.speed.scenes import case
simulate(case(sys.argv[1], duration="63 ms", record=[]))
print(time.process_time())
"""


def section(found: Section) -> None:
    """Each model twice, in an empty cache of its own."""
    rows: list[list[Any]] = []
    for model, most in MOST.items():
        with tempfile.TemporaryDirectory() as cache:
            first, warm = (process_time(model, {"BEARINGSIM_CACHE": cache}) for _ in range(2))
        rows.append([model, first, warm, first - warm])
        if most is not None:
            what = f"CPU s of a first run of {model} over a warm one"
            found.targets.append(Target(what, first - warm, at_most=most))
    found.table("Compiling, CPU s of a process", ["model", "first", "second", "compiling"], rows)
    found.prices |= {("compile", model): compiling for model, _, _, compiling in rows}


def process_time(model: str, environment: Mapping[str, str]) -> float:
    """CPU time (s) of a process that computes the scene once, its start included."""
    command = [sys.executable, "-c", FIRST, model]
    done = subprocess.run(command, env=os.environ | dict(environment), check=True, capture_output=True, text=True)
    return float(done.stdout)
