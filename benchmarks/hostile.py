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

MAX_CPU, MAX_MEMORY = 2.0, 300e6
"""Limits of CPU time (s) and memory (bytes) for a refused file."""
FUSE_CPU, FUSE_MEMORY = 60, 8 << 30
"""CPU time (s) and address space (bytes) at which the system ends a process."""
HOME = Path(__file__).resolve().parents[1]


class CommandResult(NamedTuple):
    """Result of a command: exit code, output, CPU time (s), memory (bytes; nan if not measured)."""

    code: int
    output: str
    cpu: float
    memory: float = float("nan")
    crash: str = ""


# Commands


class CpuLimitExceeded(Exception):
    """Error of a command that exceeds the CPU limit."""


def raise_limit(*_: object) -> None:
    """Raise ``Endless`` in the running command."""
    raise CpuLimitExceeded(f"more than {FUSE_CPU} s")


def run_in_process(*words: str) -> CommandResult:
    """Run a command in this process."""
    from bearingsim.cli.app import app

    signal.signal(signal.SIGPROF, raise_limit)
    signal.setitimer(signal.ITIMER_PROF, FUSE_CPU)
    start = time.process_time()
    result = CliRunner().invoke(app, list(words))
    signal.setitimer(signal.ITIMER_PROF, 0)
    crash = "" if result.exception is None or isinstance(result.exception, SystemExit) else repr(result.exception)
    return CommandResult(result.exit_code, result.stdout + result.stderr, time.process_time() - start, crash=crash)


def run_separately(*words: str) -> CommandResult:
    """Run a command in a separate process, with resource limits of the system."""
    command = [sys.executable, "-m", "bearingsim", *words]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=set_limits, env=environment()
    ) as process:
        assert process.stdout is not None
        output = process.stdout.read().decode("utf-8", "replace")
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return CommandResult(process.returncode, output, usage.ru_utime + usage.ru_stime, 1024.0 * usage.ru_maxrss)


def environment() -> dict[str, str]:
    """Return the environment of a process: this checkout, one BLAS thread."""
    return os.environ | {"PYTHONPATH": str(HOME), "OPENBLAS_NUM_THREADS": "1"}


def set_limits() -> None:
    """Set the resource limits of this process."""
    resource.setrlimit(resource.RLIMIT_CPU, (FUSE_CPU, FUSE_CPU))
    resource.setrlimit(resource.RLIMIT_AS, (FUSE_MEMORY, FUSE_MEMORY))


POSITION = re.compile(r"^.+\.ya?ml:\d+:\d+: ", re.MULTILINE)


class Limits(NamedTuple):
    """Limits of CPU time (s) and memory (bytes) for refusing a file."""

    cpu: float = MAX_CPU
    memory: float = MAX_MEMORY


def faults(result: CommandResult, path: Path, limits: Limits = Limits()) -> list[str]:  # noqa: B008 (it is immutable)
    """List the faults of a command's end."""
    messages = [result.crash] if result.crash else []
    messages += ["a traceback"] if "Traceback" in result.output else []
    if result.code == 0:
        return messages
    messages += [f"exit code {result.code}"] if result.code != 2 else []
    messages += ["no place"] if not POSITION.search(result.output) and str(path) not in result.output else []
    messages += [f"{result.cpu:.1f} s"] if result.cpu > limits.cpu else []
    messages += [f"{result.memory / 1e6:.0f} MB"] if result.memory > limits.memory else []
    messages += [f"{len(result.output)} letters"] if len(result.output) > 100_000 else []
    return messages


def main() -> int:
    """Write the table; return 1 if a file was not handled as required."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutants", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("results/hostile"))
    options = parser.parse_args()
    shutil.rmtree(options.out / "files", ignore_errors=True)
    folder = options.out.resolve() / "files"
    folder.mkdir(parents=True)
    files = [("malformed", *entry) for entry in malformed.malformed(folder)]
    files += [("mutants", *entry) for entry in altered_studies.mutants(folder, options.mutants, options.seed)]
    random = Random(options.seed)
    rows, misses = [], 0
    run_in_process("check", str(HOME / "studies" / "slip.yaml"))  # imports must not count for the first file

    def note(mode: str, kind: str, name: str, path: Path, result: CommandResult) -> None:
        nonlocal misses
        violations = faults(result, path)
        misses += bool(violations)
        rows.append(
            [mode, kind, name, path.name, result.code, f"{result.cpu:.3f}", result.memory, "; ".join(violations)]
        )
        if violations:
            print(mode, kind, name, path, *violations, flush=True)

    refused = []
    for kind, name, path in files:
        result = run_in_process("check", str(path))
        note("check", kind, name, path, result)
        if result.code:
            refused.append((kind, name, path))
    for command in ("run", "bench", "show"):
        for kind, name, path in random.sample(refused, min(options.processes, len(refused))):
            note(command, kind, name, path, run_in_process(command, str(path)))
    for kind, name, path in random.sample(refused, min(options.processes, len(refused))):
        note("process", kind, name, path, run_separately("check", str(path)))
    with (options.out / "hostile.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["way", "kind", "name", "file", "code", "cpu_s", "memory", "wrong"])
        table.writerows(rows)
    for mode in ("check", "run", "bench", "show", "process"):
        for kind in ("malformed", "mutants"):
            print_summary(mode, kind, [row for row in rows if row[:2] == [mode, kind]])
    memory = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"{misses} misses of {len(rows)}; this process, that typed them all, had {memory / 1e6:.0f} MB at most")
    return int(misses > 0)


def print_summary(mode: str, kind: str, rows: list[list]) -> None:
    """Print a summary line."""
    for state in ("refused", "valid"):
        group = [row for row in rows if bool(row[4]) == (state == "refused")]
        if group:
            cpu = sorted(float(row[5]) for row in group)
            memory = max(row[6] for row in group) / 1e6
            misses = sum(bool(row[7]) for row in group)
            print(
                f"{mode:8} {kind:10} {state:8} {len(group):5} files, CPU time {cpu[len(cpu) // 2]:.3f} s (median),"
                f" {cpu[-1]:.2f} s (most), {memory:.0f} MB (most), {misses} misses"
            )


if __name__ == "__main__":
    sys.exit(main())
