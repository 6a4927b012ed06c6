"""Resuming: what a results folder holds already, and clearing it."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.errors import UserError
from bearingsim.store import own_files
from bearingsim.store.files import left_behind, lock, room, temporary
from bearingsim.store.journal import Failure, judged_failures, log
from bearingsim.store.marker import NotOurs, OtherStudy, claim, mark, owner
from bearingsim.store.results import ResultsError, open_results, results_folder
from bearingsim.store.sealed import set_aside
from bearingsim.store.stock import judged
from bearingsim.store.table import STUDY, read_frame

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.study import Study

__all__ = [
    "FolderInUse",
    "Holdings",
    "claim_results",
    "discard",
    "holdings",
    "in_use",
    "refuse_use",
    "refuse_users_study",
]

RESULTS = "results"
"""What the marker of a results folder says that it is."""


class FolderInUse(UserError):
    """A results folder cannot be cleared while another run writes to it."""


@dataclass(frozen=True)
class Holdings:
    """What a folder holds: ids of jobs in sound units, failures by job, rows that are not in the table.

    units: names of all units that were judged; damaged: names of files that could not be read, and have been set
    aside.
    """

    units: frozenset[str]
    sealed: set[str]
    failures: dict[str, Failure]
    rows: "dict[str, pd.DataFrame]"
    damaged: list[str]


def holdings(root: Path, verify: bool = False) -> Holdings:
    """Judge all units and failures; what cannot be read is renamed to ``.damaged`` and noted in the journal.

    verify: read the units that the table knows, too.
    """
    known = read_frame(root, groups=())
    units = own_files.UNITS.of(root)
    stock = judged(units, known, {}, verify)
    failures, unreadable = judged_failures(root)
    damaged = stock.damaged | unreadable
    for path, reason in damaged.items():
        set_aside(path)
        log(root, "damaged", file=str(path.relative_to(root)), reason=reason)
    jobs = set() if known is None else set(known.index[known["unit"].isin(stock.known)])
    jobs = jobs.union(*(rows.index for rows in stock.read.values()))
    names = frozenset(path.stem for path in units)
    return Holdings(names, jobs, failures, stock.read, [str(path.relative_to(root)) for path in damaged])


@contextmanager
def in_use(root: Path) -> Iterator[None]:
    """Say that a run works in a folder, until it ends or dies. Others may, too; nothing is cleared meanwhile."""
    with ExitStack() as held:
        with room(root / "run"), lock(root):  # under which whoever clears the folder looks for runs, and clears
            held.enter_context(temporary(root, "run", "started"))
        yield


def refuse_use(root: Path) -> None:
    """Raises FolderInUse while another run works in a folder."""
    for path in own_files.temporary_files(root):
        with left_behind(path) as left:
            if not left and path.exists():
                advice = "wait for it, or choose another folder (on a disk without locks: remove this file)"
                raise FolderInUse(f"another run is writing {path}: {advice}")


def claim_results(root: Path, study: str, quick: bool, fresh: bool = False) -> None:
    """Mark a folder, made if need be, as that of a study's results.

    Raises NotOurs for a folder that holds files of the user, OtherStudy for that of another study (unless a fresh
    start is asked for) or of something else. Nothing is written then.
    """
    instead = _instead(root, study, quick)
    before = _study_in(root)
    if before is None:
        claim(root, RESULTS, study, instead)
    elif before != study and not fresh:
        raise OtherStudy(
            f"{root} holds results of the study `{before}` ({_held(root)}): name another folder, such as"
            f" --out {instead}, or throw them away by `run --fresh`"
        )
    elif owner(root) is None:  # of an earlier version; another study's stay so until they are thrown away
        mark(root, RESULTS, before)


def refuse_users_study(root: Path, study: "Study") -> None:
    """Raises NotOurs if ``study.yaml`` is a file of the user: the run before was of it, and this one is not."""
    copy = (root / STUDY).resolve()
    try:
        before = open_results(root).plan.get("file")
    except ResultsError:
        return
    if copy.is_file() and _is_of(before, copy) and not _is_of(study.path, copy):
        instead = _instead(root, study.name, bool(study.quick))
        raise NotOurs(
            f"{copy} is the study file of the run before, and would be replaced: name another folder, such as"
            f" --out {instead}, or move that file away"
        )


def _is_of(file: object, copy: Path) -> bool:
    """Whether a study was read from this file, by its path as it was typed."""
    return file is not None and Path(str(file)).resolve() == copy


def _instead(root: Path, study: str, quick: bool) -> str:
    """A folder to propose in place of ``root``."""
    usual = "results/" + results_folder(study, quick, None).name
    return f"{usual}-2" if root.resolve() == Path(usual).resolve() else usual


def _study_in(root: Path) -> str | None:
    """The study whose results a folder holds, by its marker or else by its plan; None if it holds none."""
    kind, name = owner(root) or ("", "")
    if kind == RESULTS:
        return name
    try:
        return None if kind else str(open_results(root).plan["study"])
    except (ResultsError, OSError):
        return None


def _held(root: Path) -> str:
    """`12 units, 1 failure`, of what a fresh start throws away."""
    counts = {"unit": len(own_files.UNITS.of(root)), "failure": len(own_files.FAILURES.of(root))}
    return ", ".join(f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items())


THROWN_AWAY = (
    own_files.UNITS,
    own_files.FAILURES,
    *own_files.DAMAGED,
    own_files.CHOICES,
    own_files.TRIALS,
    own_files.TABLES,
)


def discard(root: Path, study: str) -> str:
    """Throw away all units, failures, choices and the table of a folder, which is then that of ``study``.

    Journals, scans, figures and files of the user stay. Returns what is gone if it was another study's, in words.

    Raises FolderInUse while another run works in it.
    """
    with lock(root):
        refuse_use(root)
        before, held = _study_in(root), _held(root)
        own_files.remove(root, *THROWN_AWAY)
        if before == study:
            return ""
        mark(root, RESULTS, study)
        (root / "plan.json").unlink(missing_ok=True)
    return f"thrown away in {root}: the results of the study `{before}` ({held})"
