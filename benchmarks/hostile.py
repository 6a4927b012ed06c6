"""Test of the command line with broken, invalid and malicious files.

    python -m benchmarks.hostile [--seed 1] [--mutants 1000] [--processes 60] [--out results/hostile]

Malformed files come from ``malformed.py``: alias bombs, deep nesting, numbers of 5000 digits, other encodings,
devices. Mutants are seeded mutations of the files in `studies/` and `configs/`. All files are given to `check`. A
refusal must have exit code 2 and the name of the file, without a traceback, within 2 s of CPU time. A random
sample is also given to `run`, `bench` and `show`, and to `check` in separate processes with system limits, for
which memory is limited too (300 MB). OUT/hostile.csv has a row per file, OUT/files the files. Valid files are
reported separately, because they are planned, which may compile.
"""

import argparse
import csv
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from typing import NamedTuple

from typer.testing import CliRunner

from benchmarks import altered_studies, malformed

MOST_CPU, MOST_MEMORY = 2.0, 300e6
"""Limits of CPU time (s) and memory (bytes) for a refused file."""
FUSE_CPU, FUSE_MEMORY = 60, 8 << 30
"""CPU time (s) and address space (bytes) at which the system ends a process."""
HOME = Path(__file__).resolve().parents[1]


class Ended(NamedTuple):
    """Result of a command: exit code, output, CPU time (s), memory (bytes; nan if not measured)."""

    code: int
    said: str
    cpu: float
    memory: float = float("nan")
    crash: str = ""


# Commands


class Endless(Exception):
    """Error of a command that exceeds the CPU limit."""


def stop(*_: object) -> None:
    """Raise ``Endless`` in the running command."""
    raise Endless(f"more than {FUSE_CPU} s")


def in_here(*words: str) -> Ended:
    """Run a command in this process."""
    from bearingsim.cli import app

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, FUSE_CPU)
    before = time.process_time()
    result = CliRunner().invoke(app, list(words))
    signal.setitimer(signal.ITIMER_PROF, 0)
    crash = "" if result.exception is None or isinstance(result.exception, SystemExit) else repr(result.exception)
    return Ended(result.exit_code, result.stdout + result.stderr, time.process_time() - before, crash=crash)


def alone(*words: str) -> Ended:
    """Run a command in a separate process, with resource limits of the system."""
    command = [sys.executable, "-m", "bearingsim", *words]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=limited, env=environment()
    ) as process:
        assert process.stdout is not None
        said = process.stdout.read().decode("utf-8", "replace")
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return Ended(process.returncode, said, used.ru_utime + used.ru_stime, 1024.0 * used.ru_maxrss)


def environment() -> dict[str, str]:
    """Return the environment of a process: this checkout, one BLAS thread."""
    return os.environ | {"PYTHONPATH": str(HOME), "OPENBLAS_NUM_THREADS": "1"}


def limited() -> None:
    """Set the resource limits of this process."""
    resource.setrlimit(resource.RLIMIT_CPU, (FUSE_CPU, FUSE_CPU))
    resource.setrlimit(resource.RLIMIT_AS, (FUSE_MEMORY, FUSE_MEMORY))


PLACED = re.compile(r"^.+\.ya?ml:\d+:\d+: ", re.MULTILINE)


class Limits(NamedTuple):
    """Limits of CPU time (s) and memory (bytes) for refusing a file."""

    cpu: float = MOST_CPU
    memory: float = MOST_MEMORY


def faults(ended: Ended, path: Path, limits: Limits = Limits()) -> list[str]:  # noqa: B008 (it is immutable)
    """List the faults of a command's end."""
    found = [ended.crash] if ended.crash else []
    found += ["a traceback"] if "Traceback" in ended.said else []
    if ended.code == 0:
        return found
    found += [f"exit code {ended.code}"] if ended.code != 2 else []
    found += ["no place"] if not PLACED.search(ended.said) and str(path) not in ended.said else []
    found += [f"{ended.cpu:.1f} s"] if ended.cpu > limits.cpu else []
    found += [f"{ended.memory / 1e6:.0f} MB"] if ended.memory > limits.memory else []
    found += [f"{len(ended.said)} letters"] if len(ended.said) > 100_000 else []
    return found


def main() -> int:
    """Write the table; return 1 if a file was not handled as required."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutants", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("results/hostile"))
    asked = parser.parse_args()
    shutil.rmtree(asked.out / "files", ignore_errors=True)
    folder = asked.out.resolve() / "files"
    folder.mkdir(parents=True)
    files = [("malformed", *one) for one in malformed.malformed(folder)]
    files += [("mutants", *one) for one in altered_studies.mutants(folder, asked.mutants, asked.seed)]
    random = Random(asked.seed)
    rows, misses = [], 0
    in_here("check", str(HOME / "studies" / "slip.yaml"))  # imports must not count for the first file

    def note(way: str, kind: str, name: str, path: Path, ended: Ended) -> None:
        nonlocal misses
        wrong = faults(ended, path)
        misses += bool(wrong)
        rows.append([way, kind, name, path.name, ended.code, f"{ended.cpu:.3f}", ended.memory, "; ".join(wrong)])
        if wrong:
            print(way, kind, name, path, *wrong, flush=True)

    refused = []
    for kind, name, path in files:
        ended = in_here("check", str(path))
        note("check", kind, name, path, ended)
        if ended.code:
            refused.append((kind, name, path))
    for command in ("run", "bench", "show"):
        for kind, name, path in random.sample(refused, min(asked.processes, len(refused))):
            note(command, kind, name, path, in_here(command, str(path)))
    for kind, name, path in random.sample(refused, min(asked.processes, len(refused))):
        note("process", kind, name, path, alone("check", str(path)))
    with (asked.out / "hostile.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["way", "kind", "name", "file", "code", "cpu_s", "memory", "wrong"])
        table.writerows(rows)
    for way in ("check", "run", "bench", "show", "process"):
        for kind in ("malformed", "mutants"):
            told(way, kind, [row for row in rows if row[:2] == [way, kind]])
    own = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"{misses} misses of {len(rows)}; this process, that typed them all, had {own / 1e6:.0f} MB at most")
    return int(misses > 0)


def told(way: str, kind: str, rows: list[list]) -> None:
    """Print a summary line."""
    for what in ("refused", "valid"):
        part = [row for row in rows if bool(row[4]) == (what == "refused")]
        if part:
            cpu = sorted(float(row[5]) for row in part)
            memory = max(row[6] for row in part) / 1e6
            wrong = sum(bool(row[7]) for row in part)
            print(
                f"{way:8} {kind:10} {what:8} {len(part):5} files, CPU time {cpu[len(cpu) // 2]:.3f} s (median),"
                f" {cpu[-1]:.2f} s (most), {memory:.0f} MB (most), {wrong} misses"
            )


if __name__ == "__main__":
    sys.exit(main())
