"""Resuming: what a results folder holds already, and clearing it."""

import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.errors import UserError
from bearingsim.store.files import left_behind, lock, room, temporary, temporary_files, unit_files
from bearingsim.store.journal import Failure, clear_failures, judged_failures, log
from bearingsim.store.sealed import set_aside
from bearingsim.store.stock import judged
from bearingsim.store.table import read_frame
from bearingsim.store.trials import clear_choices

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["FolderInUse", "Holdings", "discard", "holdings", "in_use", "refuse_use"]


class FolderInUse(UserError):
    """A results folder cannot be cleared while another run writes to it."""


@dataclass(frozen=True)
class Holdings:
    """What a folder holds: ids of jobs in sound units, failures by job, rows that are not in the table.

    damaged: names of files that could not be read, and have been set aside.
    """

    sealed: set[str]
    failures: dict[str, Failure]
    rows: "dict[str, pd.DataFrame]"
    damaged: list[str]


def holdings(root: Path, verify: bool = False) -> Holdings:
    """Judge all units and failures; what cannot be read is renamed to ``.damaged`` and noted in the journal.

    verify: read the units that the table knows, too.
    """
    known = read_frame(root, groups=())
    stock = judged(unit_files(root), known, {}, verify)
    failures, unreadable = judged_failures(root)
    damaged = stock.damaged | unreadable
    for path, reason in damaged.items():
        set_aside(path)
        log(root, "damaged", file=str(path.relative_to(root)), reason=reason)
    jobs = set() if known is None else set(known.index[known["unit"].isin(stock.known)])
    jobs = jobs.union(*(rows.index for rows in stock.read.values()))
    return Holdings(jobs, failures, stock.read, [str(path.relative_to(root)) for path in damaged])


@contextmanager
def in_use(root: Path) -> Iterator[None]:
    """Say that a run works in a folder, until it ends or dies. Others may, too; nothing is cleared meanwhile."""
    with ExitStack() as held:
        with room(root / "run"), lock(root):  # under which whoever clears the folder looks for runs, and clears
            held.enter_context(temporary(root, "run", "started"))
        yield


def refuse_use(root: Path) -> None:
    """Raises FolderInUse while another run works in a folder."""
    for path in temporary_files(root):
        with left_behind(path) as left:
            if not left and path.exists():
                advice = "wait for it, or choose another folder (on a disk without locks: remove this file)"
                raise FolderInUse(f"another run is writing {path}: {advice}")


def discard(root: Path) -> None:
    """Throw away all units, failures, choices and the table of a folder.

    Journals, scans, figures and other files stay.

    Raises FolderInUse while another run works in it.
    """
    with lock(root):
        refuse_use(root)
        shutil.rmtree(root / "units", ignore_errors=True)
        clear_failures(root)
        clear_choices(root)
        for name in ("study.h5", "results.csv"):
            (root / name).unlink(missing_ok=True)
