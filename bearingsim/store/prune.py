"""What a results folder holds and its plan no longer names: found, and removed when the user says so."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from filelock import Timeout

from bearingsim.store import own_files
from bearingsim.store.files import left_behind, lock
from bearingsim.store.folder import FolderInUse, refuse_use
from bearingsim.store.journal import log
from bearingsim.store.results import Results, open_results
from bearingsim.store.sealed import UNREADABLE, read_json
from bearingsim.store.table import build_table
from bearingsim.store.units import DamagedUnit, read_unit

__all__ = ["Superfluous", "prune", "superfluous"]


@dataclass(frozen=True)
class Superfluous:
    """Files to remove, with their bytes, by what they are in words; ``notes``: what stays, and why."""

    files: dict[str, dict[Path, int]]
    notes: tuple[str, ...]

    @property
    def paths(self) -> list[Path]:
        """All files."""
        return [path for sizes in self.files.values() for path in sizes]

    @property
    def bytes(self) -> int:
        """What all of them take."""
        return sum(sum(sizes.values()) for sizes in self.files.values())

    def __str__(self) -> str:
        lines = [f"{what}: {_counted(len(sizes), sum(sizes.values()))}" for what, sizes in self.files.items()]
        return "\n".join([*lines, *self.notes, _in_all(len(self.paths), self.bytes)])


def _in_all(files: int, size: int) -> str:
    return f"in all {_counted(files, size)}" if files else "nothing to remove"


def _counted(files: int, size: int) -> str:
    return f"{_files(files)}, {size} bytes"


def _files(count: int) -> str:
    return f"{count} file{'s' * (count != 1)}"


class _Unit(NamedTuple):
    """A unit that can be read: its jobs, those of them that are planned, and the digests of these ones' scans."""

    path: Path
    jobs: set[str]
    planned: set[str]
    scans: set[str]


def superfluous(root: Path) -> Superfluous:
    """What may be removed from a results folder; changes nothing. Raises ResultsError without a sound plan."""
    results = open_results(root)
    planned = set(results.planned)
    units, notes = list[_Unit](), list[str]()
    for path in own_files.UNITS.of(root):
        try:
            units.append(_unit(path, planned))
        except DamagedUnit as damage:
            notes.append(f"{path.parent}/{damage}: it stays (a run with --verify computes its jobs again)")
    scans = own_files.SCANS.of(root)
    done = set[str]().union(*(unit.planned for unit in units))
    if scans and done != planned:
        left = len(planned - done)
        which = f"{left} jobs that may need them are" if left > 1 else "1 job that may need them is"
        notes.append(f"scans stay ({_files(len(scans))}): {which} not done")
        scans = []
    named = set[str]().union(*(unit.scans for unit in units))
    temporary = own_files.temporary_files(root)
    found = {
        "units of jobs that the plan does not name": [unit.path for unit in units if not unit.planned],
        "failures of such jobs": [path for path in own_files.FAILURES.of(root) if path.stem not in planned],
        "damaged files that were set aside": [path for kind in own_files.DAMAGED for path in kind.of(root)],
        "trials that nothing reads": _trials(results),
        "scans of no job": [path for path in scans if path.stem not in named],
        "temporary files of processes that are gone": [path for path in temporary if _is_left(path)],
    }
    sizes = {what: {path: path.lstat().st_size for path in sorted(paths)} for what, paths in found.items()}
    return Superfluous({what: files for what, files in sizes.items() if files}, (*notes, *_whole(units)))


def _unit(path: Path, planned: set[str]) -> _Unit:
    columns = read_unit(path)
    jobs = list(columns["job"])
    digests = [
        column
        for name, column in columns.items()
        if name.startswith("parameters/defects.") and name.endswith(".digest")
    ]
    ours = [row for row, job in enumerate(jobs) if job in planned]
    return _Unit(path, set(jobs), {jobs[row] for row in ours}, {str(one[row]) for one in digests for row in ours})


def _whole(units: Iterable[_Unit]) -> Iterator[str]:
    """A line on units that hold more than what is planned, if there are any."""
    found = [unit for unit in units if unit.planned and unit.planned != unit.jobs]
    if found:
        stay = f"{len(found)} units stay" if len(found) > 1 else "1 unit stays"
        unnamed, jobs = sum(len(u.jobs - u.planned) for u in found), sum(len(u.jobs) for u in found)
        yield f"{stay} whole, though the plan names only {jobs - unnamed} of {jobs} jobs there: a unit is one file"


def _is_left(path: Path) -> bool:
    with left_behind(path) as left:
        return left


def _trials(results: Results) -> list[Path]:
    """Those of a study that names no accuracy any more, and those that cannot be read: these are made again."""
    return [
        path for path in own_files.TRIALS.of(results.path) if not (results.plan.get("accuracy") and _reads(path))
    ]


def _reads(path: Path) -> bool:
    try:
        read_json(path)
    except UNREADABLE:
        return False
    return True


def prune(root: Path) -> Superfluous:
    """Remove what ``superfluous`` finds, and make the table again; says what it was.

    Raises FolderInUse while a run works in the folder.
    """
    try:
        with lock(root, wait=False):
            refuse_use(root)
            found = superfluous(root)
            for path in found.paths:
                path.unlink(missing_ok=True)
    except Timeout:
        raise FolderInUse(f"another run holds {root / '.lock'}: wait for it") from None
    if found.paths:
        log(root, "pruned", files=len(found.paths), bytes=found.bytes)
        build_table(root)
    return found
