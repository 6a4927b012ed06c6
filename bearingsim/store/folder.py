"""Resuming: what a results folder holds already, and clearing it."""

import shutil
from pathlib import Path

from bearingsim.errors import UserError
from bearingsim.store.files import lock, temporary_files, unit_files, writer_is_dead
from bearingsim.store.journal import clear_failures, log
from bearingsim.store.trials import clear_choices
from bearingsim.store.units import DamagedUnit, check_unit

__all__ = ["FolderInUse", "discard", "sealed_jobs"]


class FolderInUse(UserError):
    """A results folder cannot be cleared while another run writes to it."""


def sealed_jobs(root: Path, checksums: bool = False) -> tuple[set[str], int]:
    """Ids of the jobs that lie in sound units, and the number of damaged units found.

    Units that do not open, or do not hold what they promise, are renamed to ``.damaged`` and noted in the
    journal; with ``checksums`` every byte of every unit is read.
    """
    jobs: set[str] = set()
    damaged = 0
    for path in unit_files(root):
        try:
            jobs.update(check_unit(path, checksums))
        except DamagedUnit as damage:
            path.replace(path.with_suffix(".damaged"))
            log(root, "unit damaged", unit=path.stem, reason=str(damage))
            damaged += 1
    return jobs, damaged


def discard(root: Path) -> None:
    """Throw away all units, failures, choices and the table of a folder.

    Journals, scans, figures and other files stay.

    Raises FolderInUse while another run is computing into it.
    """
    with lock(root):
        if any(not writer_is_dead(path) for path in temporary_files(root)):
            raise FolderInUse(f"another run is writing to {root}: wait for it, or choose another folder")
        shutil.rmtree(root / "units", ignore_errors=True)
        clear_failures(root)
        clear_choices(root)
        for name in ("study.h5", "results.csv"):
            (root / name).unlink(missing_ok=True)
