"""Every command of the program in one process, each run by its entry point, in an environment that is given.

    python -m tests.scenes.every_command RECORD RESULTS DESIGN JOBS [FAULT]

RECORD: the file for the exit code of each command; RESULTS, DESIGN: results folders of a study and of a design;
JOBS: worker processes of `run`; FAULT: what the system refuses (``FAULTS``). Files go to the working folder.
The computations of `stability` and `bench` are left out: their tables and figures are made of rows that are given.
"""

import _multiprocessing  # type: ignore[import-not-found]
import errno
import json
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from tests.scenes.commands import STUDY

COMMANDS: dict[str, tuple[str, ...]] = {
    "new": ("new.yaml",),
    "check": ("small.yaml",),
    "run": ("small.yaml", "--quick", "--jobs", "JOBS", "--out", "ran"),
    "plot": ("RESULTS", "--out", "figures"),
    "show": ("RESULTS",),
    "sensitivity": ("DESIGN", "--of", "velocity@BPFO", "--out", "indices.png"),
    "export": ("RESULTS", "--features", "features.csv"),
    "merge": ("RESULTS", "--out", "merged"),
    "prune": ("RESULTS",),
    "freq": ("nf308",),
    "stability": ("--quick", "--out", "stability"),
    "bench": ("--scene", "healthy", "--quick", "--out", "bench"),
}
"""Words of each command, by its name."""
WRITING = {"new", "run", "plot", "sensitivity", "export", "merge", "stability", "bench"}


def refused_lock(number: int) -> type:
    """The lock of a system that refuses to make any, with this error, as where /dev/shm is broken."""

    class Lock(_multiprocessing.SemLock):
        def __new__(cls, *arguments: Any, **options: Any) -> "Lock":
            raise OSError(number, os.strerror(number))

    return Lock


def refuse_locks() -> None:
    """Let the system refuse every lock in shared memory, as where nothing is mounted at /dev/shm."""
    _multiprocessing.SemLock = refused_lock(errno.ENOENT)


def refuse_files() -> None:
    """Let the system refuse every new file in the working folder, as a disk without inodes does."""
    root, disk = Path.cwd(), os.statvfs

    def refuse(event: str, arguments: tuple[Any, ...]) -> None:
        if event not in ("open", "os.mkdir") or not isinstance(arguments[0], str | bytes | Path):
            return
        path = Path(os.fsdecode(arguments[0])).absolute()
        is_made = event == "os.mkdir" or bool(arguments[2] & os.O_CREAT)
        if is_made and root in path.parents and not path.exists():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    sys.addaudithook(refuse)
    os.statvfs = lambda path: SimpleNamespace(  # type: ignore[assignment, return-value]
        **{name: getattr(disk(path), name) for name in dir(disk(path)) if name.startswith("f_")} | {"f_favail": 0}
    )


FAULTS: dict[str, Callable[[], None]] = {
    "no /dev/shm": refuse_locks,
    "no inodes": refuse_files,
}


def leave_out_long_computations() -> None:
    """Replace the runs of `stability` and `bench` by rows that nobody computed."""
    from bearingsim.bench import measure, plan
    from bearingsim.stability import mapping
    from bearingsim.store import write_text
    from tests.scenes.bench_runs import FEW_RUNS, rows_of
    from tests.scenes.stability_map import table

    def compute(models: object, methods: object, grid: object, folder: Path, jobs: int) -> Path:
        folder.mkdir()
        write_text(folder / "stability.csv", table().head(6).to_csv(index=False))
        return folder / "stability.csv"

    measure.rows, measure.ready, mapping.compute = rows_of, lambda run: run.model, compute
    plan.plan_of = lambda case, quick: FEW_RUNS


def run(words: list[str]) -> dict[str, Any]:
    """Run a command as its entry point does; its exit code, and the traceback of an error that got out."""
    from bearingsim.cli import main

    sys.argv = ["bearingsim", *words]
    try:
        main()
    except SystemExit as end:
        return {"code": end.code or 0, "traceback": ""}
    except BaseException:
        return {"code": None, "traceback": traceback.format_exc()}
    return {"code": 0, "traceback": ""}


if __name__ == "__main__":
    record, results, design, jobs, *fault = sys.argv[1:]
    Path("small.yaml").write_text(STUDY)
    places = {"RESULTS": results, "DESIGN": design, "JOBS": jobs}
    done = {"help": run(["--help"])}
    leave_out_long_computations()
    for name in fault:
        FAULTS[name]()
    done |= {name: run([name, *(places.get(word, word) for word in words)]) for name, words in COMMANDS.items()}
    with open(record, "w", encoding="utf-8") as file:
        json.dump(done, file)
