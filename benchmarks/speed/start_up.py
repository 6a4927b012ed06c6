"""CPU time of commands that compute nothing: minimum over several processes, including imports.

    python -m benchmarks.speed.start_up --csv docs/data/start_up.csv

The study has 8 jobs of `ring` with series. `check` is timed with compiled code in the cache.
"""

import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from benchmarks.speed.report import Section, Target

STUDY = """\
study: start
bearing: nf308
speed: 1800 rpm
load: 150 N
model: ring
duration: 0.1 s
defect: {race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}
sweep: {load: {linspace: [100 N, 200 N, 4]}}
figures:
  - {y: velocity@BPFO-healthy, x: load}
"""
COMMANDS = {
    "bearingsim --help": ["--help"],
    "bearingsim show": ["show", "results"],
    "bearingsim plot, one figure": ["plot", "results"],
    "bearingsim plot --kind envelope, 3 jobs": ["plot", "results", "--kind", "envelope"],
    "bearingsim export": ["export", "results", "--features", "features.csv", "--force"],
    "bearingsim run, all done": ["run", "study.yaml", "--out", "results"],
    "bearingsim check": ["check", "study.yaml"],
}
MAX_CPU = {"bearingsim show": 0.5, "bearingsim plot, one figure": 1.5, "bearingsim check": 1.0}
"""Largest CPU time (s) of a command."""
ROUNDS = 5


def section(report: Section) -> None:
    """Time all commands."""
    seconds = start_ups()
    report.add_table(
        "Start-up, CPU s of a process", ["command", "CPU s"], [[name, cpu_s] for name, cpu_s in seconds.items()]
    )
    report.targets += [
        Target(f"CPU s of `{name}`", seconds[name], at_most=max_cpu) for name, max_cpu in MAX_CPU.items()
    ]


def start_ups() -> dict[str, float]:
    """Return the minimum CPU time (s) of each command; the commands alternate."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.yaml").write_text(STUDY)
        cpu_seconds(["run", "study.yaml", "--jobs", "1", "--out", "results"], folder)
        turns = [
            {name: cpu_seconds(arguments, folder) for name, arguments in COMMANDS.items()} for _ in range(ROUNDS)
        ]
    return {name: min(turn[name] for turn in turns) for name in COMMANDS}


def cpu_seconds(arguments: list[str], folder: str, environment: Mapping[str, str] | None = None) -> float:
    """Return the CPU time (s) of a command and its workers; environment: by default that of this process.

    Python keeps its bytecode, as an installed package does: without it, each command compiles 110 files again.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "bearingsim", *arguments]
    variables = {**(os.environ if environment is None else environment), "PYTHONDONTWRITEBYTECODE": ""}
    subprocess.run(command, cwd=folder, env=variables, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Write the table as CSV."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, required=True)
    path, seconds = parser.parse_args().csv, start_ups()
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["command", "cpu_s", "at_most_s"])
        table.writerows([name, f"{s:.2f}", MAX_CPU.get(name, "")] for name, s in seconds.items())


if __name__ == "__main__":
    main()
