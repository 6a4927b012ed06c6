"""Every command of the program in one process, each run by its entry point, in an environment that is given.

    python -m tests.scenes.every_command RECORD RESULTS DESIGN FAULT=JOBS...

RECORD: the file for the exit codes; RESULTS, DESIGN: results folders of a study and of a design; FAULT: what the
system refuses (``FAULTS``); JOBS: worker processes of `run` meanwhile. All commands run once for each FAULT, in a
folder of that name. `stability` and `bench` compute nothing: their tables and figures are made of given rows.
"""

import _multiprocessing  # type: ignore[import-not-found]
import errno
import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from tests.scenes.commands import STUDY, write_signal

COMMANDS: dict[str, tuple[str, ...]] = {
    "new": ("new.yaml",),
    "check": ("small.yaml",),
    "run": ("small.yaml", "--quick", "--jobs", "JOBS", "--out", "ran"),
    "plot": ("RESULTS", "--out", "figures"),
    "show": ("RESULTS",),
    "report": ("RESULTS", "--out", "report.html"),
    "sensitivity": ("DESIGN", "--of", "velocity@BPFO", "--out", "indices.png"),
    "export": ("RESULTS", "--features", "features.csv"),
    "merge": ("RESULTS", "--out", "merged"),
    "prune": ("RESULTS",),
    "warm": ("small.yaml",),
    "freq": ("nf308",),
    "stability": ("--quick", "--out", "stability"),
    "bench": ("--scene", "healthy", "--quick", "--out", "bench"),
    "analyze": ("signal.npz", "--bearing", "nf308", "--figure", "analyzed.png"),
    "compare": ("RESULTS", "signal.npz", "--job", "JOB", "--unit", "m/s", "--figure", "compared.png"),
}
"""Words of each command, by its name."""
WRITING = frozenset(
    {"new", "run", "plot", "report", "sensitivity", "export", "merge", "stability", "bench", "analyze", "compare"}
)


def refused_lock(number: int) -> type:
    """The lock of a system that refuses to make any, with this error, as where /dev/shm is broken."""

    class Lock(_multiprocessing.SemLock):
        def __new__(cls, *arguments: Any, **options: Any) -> "Lock":
            raise OSError(number, os.strerror(number))

    return Lock


@contextmanager
def no_locks() -> Iterator[None]:
    """Refuse every lock in shared memory, as where nothing is mounted at /dev/shm."""
    locks: Any = import_module("joblib.externals.loky.backend.synchronize")
    locks._SemLock, original = refused_lock(errno.ENOENT), locks._SemLock
    yield
    locks._SemLock = original


@contextmanager
def no_inodes() -> Iterator[None]:
    """Refuse every new file in the working folder, as a disk without inodes does."""
    root, statvfs, is_over = Path.cwd(), os.statvfs, []

    def refuse(event: str, arguments: tuple[Any, ...]) -> None:
        if is_over or event not in ("open", "os.mkdir") or not isinstance(arguments[0], str | bytes | Path):
            return
        path = Path(os.fsdecode(arguments[0])).absolute()
        is_creation = event == "os.mkdir" or bool(arguments[2] & os.O_CREAT)
        if is_creation and root in path.parents and not path.exists():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    def without_inodes(path: Any) -> Any:
        disk = statvfs(path)
        return SimpleNamespace(f_bavail=disk.f_bavail, f_bfree=disk.f_bfree, f_blocks=disk.f_blocks,
                               f_frsize=disk.f_frsize, f_files=disk.f_files, f_favail=0)  # fmt: skip

    sys.addaudithook(refuse)
    os.statvfs = without_inodes
    yield
    os.statvfs = statvfs
    is_over.append(True)


@contextmanager
def full_stdout() -> Iterator[None]:
    """Let stdout be a file on a full disk."""
    original, full = os.dup(1), os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, 1)
    yield
    os.dup2(original, 1)
    sys.stdout.flush()


FAULTS: dict[str, Callable[[], AbstractContextManager[None]]] = {
    "none": nullcontext,
    "no shared memory": no_locks,
    "no inodes": no_inodes,
    "full stdout": full_stdout,
}


def replace_long_computations() -> None:
    """Replace the runs of `stability` and `bench` by made-up rows."""
    from bearingsim.bench import measure, plan
    from bearingsim.stability import mapping
    from bearingsim.store import write_text
    from tests.scenes.bench_runs import FEW_RUNS, rows_of
    from tests.scenes.stability_map import table

    def compute(models: object, methods: object, grid: object, folder: Path, jobs: int) -> Path:
        folder.mkdir()
        write_text(folder / "stability.csv", table().head(6).to_csv(index=False))
        return folder / "stability.csv"

    measure.compute_rows, measure.compile_run, mapping.compute_map = rows_of, lambda run: run.model, compute
    plan.make_plan = lambda case, quick: FEW_RUNS


def run(words: list[str]) -> dict[str, Any]:
    """Run a command as its entry point does; its exit code, and the traceback of an error that got out."""
    from bearingsim.cli import main

    sys.argv = ["bearingsim", *words]
    try:
        main()
    except SystemExit as error:
        return {"code": error.code or 0, "traceback": ""}
    except BaseException:
        return {"code": None, "traceback": traceback.format_exc()}
    return {"code": 0, "traceback": ""}


def run_all(fault: str, arguments: dict[str, str]) -> dict[str, Any]:
    """Run every command in a folder of its own under a fault; what ``run`` says of each."""
    Path(fault).mkdir()
    os.chdir(fault)
    Path("small.yaml").write_text(STUDY)
    write_signal("signal.npz")
    with FAULTS[fault]():
        results = {"help": run(["--help"])}
        for name, words in COMMANDS.items():
            results[name] = run([name, *(arguments.get(word, word) for word in words)])
    os.chdir("..")
    return results


if __name__ == "__main__":
    record, results, design, *faults = sys.argv[1:]
    run(["--version"])  # before anything else is imported, as in a process of its own
    replace_long_computations()
    ends = {}
    for fault, jobs in (word.split("=") for word in faults):
        job = json.loads(Path(results, "plan.json").read_text())["jobs"][1]["job"]
        ends[fault] = run_all(fault, {"RESULTS": results, "DESIGN": design, "JOBS": jobs, "JOB": job})
    Path(record).write_text(json.dumps(ends), encoding="utf-8")
