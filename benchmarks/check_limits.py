"""CPU time and memory of `check` for mutated studies, refused or valid, against limits.

    python -m benchmarks.check_limits [--count 300] [--seed N] [--csv docs/data/check_limits.csv]

The mutants are those of ``crossed_blocks.py``, by default seeded from the commit. A refused study is checked in a
separate process, within 2 s of CPU time and 300 MB. A valid study is checked in a fork of a process that has
imported all modules and checked other studies, within 1 s plus 1 ms per job, without the compilation of its code.
Memory is reported by the operating system, and is at least that of the process that started the command.
"""

import argparse
import csv
import re
import subprocess
import sys
from math import inf
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.crossed_blocks import write_crossed
from benchmarks.hostile import HOME, Ended, Limits, alone, faults, in_here

PLANNED = re.compile(r"^\S+: (\d+) jobs? \(", re.MULTILINE)
PER_STUDY, PER_JOB = 1.0, 1e-3
"""Limits of CPU time (s) for a valid study, and for each of its jobs."""


class Checked(NamedTuple):
    """Result of a mutant: exit code, jobs, CPU time and its limit (s), memory (MB), faults."""

    number: int
    change: str
    code: int
    jobs: int
    cpu_s: float
    limit_s: float
    memory_mb: float
    wrong: str


def warm(*words: str) -> Ended:
    """Run a command in a fork of this process."""
    context = get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_typed, args=(theirs, words))
    process.start()
    ended: Ended = ours.recv()
    process.join()
    return ended


def _typed(answer: Connection, words: tuple[str, ...]) -> None:
    answer.send(in_here(*words)._replace(memory=1024.0 * getrusage(RUSAGE_SELF).ru_maxrss))


def jobs_planned(ended: Ended) -> int:
    """Return the number of jobs planned by `check`, including refused jobs; 0 for a refused study."""
    planned = PLANNED.search(ended.said)
    return int(planned[1]) if planned else 0


def limits(jobs: int) -> Limits:
    """Return the limits of `check` for a study with some jobs; without jobs, those of a refused study."""
    return Limits(PER_STUDY + PER_JOB * jobs, inf) if jobs else Limits()


def checked(path: Path) -> Ended:
    """Check a study: in a warm process if it is valid, in a separate process if it is refused."""
    ended = warm("check", str(path))
    jobs = jobs_planned(ended)
    if not jobs and ended.code:
        return alone("check", str(path))
    if ended.cpu > limits(jobs).cpu:  # it may have included compilation
        return warm("check", str(path))
    return ended


def judged(number: int, change: str, path: Path, ended: Ended) -> Checked:
    """Return the row of a mutant."""
    jobs = jobs_planned(ended)
    most = limits(jobs)
    wrong = faults(ended, path, most)
    if ended.code == 0 and ended.cpu > most.cpu:
        wrong.append(f"{ended.cpu:.1f} s")
    cpu, memory = round(ended.cpu, 3), round(ended.memory / 1e6, 1)
    return Checked(number, change, ended.code, jobs, cpu, round(most.cpu, 3), memory, "; ".join(wrong))


def seed_of_commit() -> int:
    """Derive a seed from the commit."""
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=HOME, check=True, capture_output=True, text=True
    ).stdout
    return int(commit[:8], 16)


def main() -> int:
    """Write the table; return 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=seed_of_commit())
    parser.add_argument("--csv", type=Path, default=HOME / "docs" / "data" / "check_limits.csv")
    asked = parser.parse_args()
    for imports in ("slip", "sensitivity"):  # imports of all studies, and of designs
        in_here("check", str(HOME / "studies" / f"{imports}.yaml"))
    rows = []
    with TemporaryDirectory() as folder:
        for number, (change, path) in enumerate(write_crossed(Path(folder), asked.count, asked.seed)):
            row = judged(number, change, path, checked(path))
            rows.append(row)
            if row.wrong:
                print(*row, flush=True)
    with asked.csv.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow([*Checked._fields, "seed"])
        table.writerows([*row, asked.seed] for row in rows)
    for what, part in (
        ("refused", [row for row in rows if not row.jobs]),
        ("valid", [row for row in rows if row.jobs]),
    ):
        if part:
            most, memory = max(row.cpu_s / row.limit_s for row in part), max(row.memory_mb for row in part)
            print(f"{len(part)} {what}: at most {100 * most:.0f} % of the CPU time allowed, {memory:.0f} MB")
    return int(any(row.wrong for row in rows))


if __name__ == "__main__":
    sys.exit(main())
