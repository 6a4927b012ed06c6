"""Removal of files of a results folder that its plan no longer needs."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from filelock import Timeout

from bearingsim.store import own_files
from bearingsim.store.files import lock, lock_leftover
from bearingsim.store.folder import FolderInUse, refuse_folder_in_use
from bearingsim.store.journal import log
from bearingsim.store.results import Results, open_results
from bearingsim.store.sealed import UNREADABLE, read_json
from bearingsim.store.table import build_table
from bearingsim.store.units import DamagedUnit, read_unit


@dataclass(frozen=True)
class RemovableFiles:
    """Files to remove, with their sizes in bytes, by kind; notes: files that are kept, with the reason."""

    files: dict[str, dict[Path, int]]
    notes: tuple[str, ...]

    @property
    def paths(self) -> list[Path]:
        """All files."""
        return [path for sizes in self.files.values() for path in sizes]

    @property
    def bytes(self) -> int:
        """Size of all files in bytes."""
        return sum(sum(sizes.values()) for sizes in self.files.values())

    def __str__(self) -> str:
        lines = [f"{kind}: {_size_text(len(sizes), sum(sizes.values()))}" for kind, sizes in self.files.items()]
        total = f"in all {_size_text(len(self.paths), self.bytes)}" if self.paths else "nothing to remove"
        return "\n".join([*lines, *self.notes, total])


def _size_text(files: int, size: int) -> str:
    return f"{_files(files)}, {size} bytes"


def _files(count: int) -> str:
    return f"{count} file{'s' * (count != 1)}"


class _Unit(NamedTuple):
    """Intact unit: path, ids of all jobs and of the planned ones, digests of the scans of the planned jobs."""

    path: Path
    jobs: set[str]
    planned: set[str]
    scans: set[str]


def find_removable(root: Path) -> RemovableFiles:
    """List the files that can be removed from a results folder, without removing them.

    Raises ResultsError without an intact plan.
    """
    results = open_results(root)
    planned = set(results.planned)
    units, notes = list[_Unit](), list[str]()
    for path in own_files.UNITS.find(root):
        try:
            units.append(_read_unit(path, planned))
        except DamagedUnit as damage:
            notes.append(f"{path.parent}/{damage}: kept (a run with --verify recomputes its jobs)")
    scans = own_files.SCANS.find(root)
    done = set[str]().union(*(unit.planned for unit in units))
    if scans and done != planned:
        remaining = len(planned - done)
        jobs = f"{remaining} jobs that may need them are" if remaining > 1 else "1 job that may need them is"
        notes.append(f"scans are kept ({_files(len(scans))}): {jobs} not done")
        scans = []
    used_scans = set[str]().union(*(unit.scans for unit in units))
    temporary = own_files.temporary_files(root)
    by_kind = {
        "units of jobs outside the plan": [unit.path for unit in units if not unit.planned],
        "failures of jobs outside the plan": [
            path for path in own_files.FAILURES.find(root) if path.stem not in planned
        ],
        "damaged files (.damaged)": [path for kind in own_files.DAMAGED for path in kind.find(root)],
        "unused trials": _find_unused_trials(results),
        "scans of no job": [path for path in scans if path.stem not in used_scans],
        "temporary files of ended processes": [path for path in temporary if _is_leftover(path)],
    }
    sizes = {kind: {path: path.lstat().st_size for path in sorted(paths)} for kind, paths in by_kind.items()}
    return RemovableFiles(
        {kind: files for kind, files in sizes.items() if files}, (*notes, *_mixed_unit_notes(units))
    )


def _read_unit(path: Path, planned: set[str]) -> _Unit:
    columns = read_unit(path)
    jobs = list(columns["job"])
    digests = [
        column
        for name, column in columns.items()
        if name.startswith(("parameters/defects.", "parameters/surfaces.")) and name.endswith(".digest")
    ]
    planned_rows = [row for row, job in enumerate(jobs) if job in planned]
    return _Unit(
        path,
        set(jobs),
        {jobs[row] for row in planned_rows},
        {str(column[row]) for column in digests for row in planned_rows},
    )


def _mixed_unit_notes(units: Iterable[_Unit]) -> Iterator[str]:
    """Yield a note on units with jobs both in the plan and outside it, if there are such units."""
    mixed = [unit for unit in units if unit.planned and unit.planned != unit.jobs]
    if mixed:
        kept_text = f"{len(mixed)} units are kept" if len(mixed) > 1 else "1 unit is kept"
        unplanned = sum(len(unit.jobs - unit.planned) for unit in mixed)
        jobs = sum(len(unit.jobs) for unit in mixed)
        yield f"{kept_text} whole, although the plan names only {jobs - unplanned} of {jobs} jobs there"


def _is_leftover(path: Path) -> bool:
    with lock_leftover(path) as is_leftover:
        return is_leftover


def _find_unused_trials(results: Results) -> list[Path]:
    """List the unreadable trials, or all trials if the study has no `accuracy`."""
    return [
        path
        for path in own_files.TRIALS.find(results.path)
        if not (results.plan.get("accuracy") and _is_readable(path))
    ]


def _is_readable(path: Path) -> bool:
    try:
        read_json(path)
    except UNREADABLE:
        return False
    return True


def prune(root: Path) -> RemovableFiles:
    """Remove the files listed by ``find_removable``, and rebuild the table; return the list.

    Raises FolderInUse if a run uses the folder.
    """
    try:
        with lock(root, wait=False):
            refuse_folder_in_use(root)
            removed = find_removable(root)
            for path in removed.paths:
                path.unlink(missing_ok=True)
    except Timeout:
        raise FolderInUse(f"another run has locked {root / '.lock'}: wait for it") from None
    if removed.paths:
        log(root, "pruned", files=len(removed.paths), bytes=removed.bytes)
        build_table(root)
    return removed
