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
from benchmarks.hostile import HOME, CommandResult, Limits, faults, run_in_process, run_separately

JOB_COUNT = re.compile(r"^\S+: (\d+) jobs? \(", re.MULTILINE)
STUDY_CPU, JOB_CPU = 1.0, 1e-3
"""Limits of CPU time (s) for a valid study, and for each of its jobs."""


class MutantResult(NamedTuple):
    """Result of a mutant: exit code, jobs, CPU time and its limit (s), memory (MB), faults."""

    number: int
    change: str
    code: int
    jobs: int
    cpu_s: float
    limit_s: float
    memory_mb: float
    wrong: str


def run_in_fork(*words: str) -> CommandResult:
    """Run a command in a fork of this process."""
    context = get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send_result, args=(sender, words))
    process.start()
    result: CommandResult = receiver.recv()
    process.join()
    return result


def _send_result(sender: Connection, words: tuple[str, ...]) -> None:
    sender.send(run_in_process(*words)._replace(memory=1024.0 * getrusage(RUSAGE_SELF).ru_maxrss))


def jobs_planned(result: CommandResult) -> int:
    """Return the number of jobs planned by `check`, including refused jobs; 0 for a refused study."""
    match = JOB_COUNT.search(result.output)
    return int(match[1]) if match else 0


def limits(jobs: int) -> Limits:
    """Return the limits of `check` for a study with some jobs; without jobs, those of a refused study."""
    return Limits(STUDY_CPU + JOB_CPU * jobs, inf) if jobs else Limits()


def check(path: Path) -> CommandResult:
    """Check a study: in a warm process if it is valid, in a separate process if it is refused."""
    result = run_in_fork("check", str(path))
    jobs = jobs_planned(result)
    if not jobs and result.code:
        return run_separately("check", str(path))
    if result.cpu > limits(jobs).cpu:  # it may have included compilation
        return run_in_fork("check", str(path))
    return result


def row_of(number: int, change: str, path: Path, result: CommandResult) -> MutantResult:
    """Return the row of a mutant."""
    jobs = jobs_planned(result)
    limit = limits(jobs)
    violations = faults(result, path, limit)
    if result.code == 0 and result.cpu > limit.cpu:
        violations.append(f"{result.cpu:.1f} s")
    cpu, memory = round(result.cpu, 3), round(result.memory / 1e6, 1)
    return MutantResult(number, change, result.code, jobs, cpu, round(limit.cpu, 3), memory, "; ".join(violations))


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
    options = parser.parse_args()
    for name in ("slip", "sensitivity"):  # imports of all studies, and of designs
        run_in_process("check", str(HOME / "studies" / f"{name}.yaml"))
    rows = []
    with TemporaryDirectory() as folder:
        for number, (change, path) in enumerate(write_crossed(Path(folder), options.count, options.seed)):
            row = row_of(number, change, path, check(path))
            rows.append(row)
            if row.wrong:
                print(*row, flush=True)
    with options.csv.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow([*MutantResult._fields, "seed"])
        table.writerows([*row, options.seed] for row in rows)
    for outcome, group in (
        ("refused", [row for row in rows if not row.jobs]),
        ("valid", [row for row in rows if row.jobs]),
    ):
        if group:
            largest, memory = max(row.cpu_s / row.limit_s for row in group), max(row.memory_mb for row in group)
            print(
                f"{len(group)} {outcome}: at most {100 * largest:.0f} % of the CPU time allowed, {memory:.0f} MB"
            )
    return int(any(row.wrong for row in rows))


if __name__ == "__main__":
    sys.exit(main())
