"""Claiming, resuming and clearing of a results folder."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.errors import ResultsError, UserError
from bearingsim.store import own_files
from bearingsim.store.checked_units import check_units
from bearingsim.store.files import full_disk_errors, lock, lock_leftover, refuse_link, temporary
from bearingsim.store.journal import Failure, load_failures, log
from bearingsim.store.marker import ForeignFolder, OtherStudy, claim, mark, owner
from bearingsim.store.results import open_results, results_folder
from bearingsim.store.sealed import mark_damaged
from bearingsim.store.table import OWN_FILE, STUDY_FILE, read_frame

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.study import Study

RESULTS = "results"
"""Kind in the marker of a results folder."""


class FolderInUse(UserError):
    """A results folder cannot be cleared while another run writes to it."""


@dataclass(frozen=True)
class Holdings:
    """Contents of a results folder.

    units: names of all units, including damaged ones; sealed: ids of the jobs in intact units; failures: by job
    id; rows: rows that are not in the table, by unit; damaged: paths of unreadable files, which have been renamed.
    """

    units: frozenset[str]
    sealed: set[str]
    failures: dict[str, Failure]
    rows: "dict[str, pd.DataFrame]"
    damaged: list[str]


def read_holdings(root: Path, verify: bool = False) -> Holdings:
    """Check all units and failures of a folder, and return its contents.

    Unreadable files are renamed to ``.damaged`` and recorded in the journal. verify: also read the units whose
    rows are in the table. Raises LinkInFolder if an unreadable file is a link, as in a folder of git-annex or DVC,
    because its target may be intact.
    """
    frame = read_frame(root, groups=())
    units = own_files.UNITS.find(root)
    checked = check_units(units, frame, {}, verify)
    failures, unreadable = load_failures(root)
    damaged = checked.damaged | unreadable
    for path in damaged:
        refuse_link(path)
    for path, reason in damaged.items():
        mark_damaged(path)
        log(root, "damaged", file=str(path.relative_to(root)), reason=reason)
    jobs = set() if frame is None else set(frame.index[frame["unit"].isin(checked.in_table)])
    jobs = jobs.union(*(rows.index for rows in checked.rows.values()))
    names = frozenset(path.stem for path in units)
    return Holdings(names, jobs, failures, checked.rows, [str(path.relative_to(root)) for path in damaged])


@contextmanager
def in_use(root: Path) -> Iterator[None]:
    """Mark a folder as in use by this run, so that it is not cleared; the mark ends with the process.

    Other runs may use the folder at the same time.
    """
    with ExitStack() as stack:
        with full_disk_errors(root / "run"), lock(root):  # ``discard`` checks for runs under the same lock
            stack.enter_context(temporary(root, "run", "started"))
        yield


def refuse_folder_in_use(root: Path) -> None:
    """Raise FolderInUse if another run uses a folder."""
    for path in own_files.temporary_files(root):
        with lock_leftover(path) as is_leftover:
            if not is_leftover and path.exists():
                advice = "wait for it, or use another folder (on a disk without locks, remove this file)"
                raise FolderInUse(f"another run is writing {path}: {advice}")


def claim_results(root: Path, study: str, quick: bool, fresh: bool = False) -> None:
    """Mark a folder as the results folder of a study; create it if it is missing.

    Raises ForeignFolder for a folder with files of the user, and OtherStudy for a folder of another kind or,
    unless ``fresh``, of another study. The folder is then left unchanged.
    """
    suggestion = _suggested_folder(root, study, quick)
    stored_study = _stored_study(root)
    if stored_study is None:
        claim(root, RESULTS, study, suggestion)
    elif stored_study != study and not fresh:
        raise OtherStudy(
            f"{root} contains results of the study `{stored_study}` ({_contents(root)}): use another folder,"
            f" such as --out {suggestion}, or delete them by `run --fresh`"
        )
    elif owner(root) is None:  # a folder of an earlier version; ``discard`` marks a folder of another study
        mark(root, RESULTS, stored_study)


def refuse_own_study_file(root: Path, study: "Study") -> None:
    """Raise ForeignFolder if ``study.yaml`` in the folder may be the user's study file of an earlier run.

    It would be overwritten unless it is also that of this run. The plan states whether it was read from there;
    the path that the user typed is not used, because it depends on the working folder.
    """
    copy = (root / STUDY_FILE).resolve()
    try:
        is_own_file = open_results(root).plan.get(OWN_FILE, False)
        state = "is the study file of an earlier run"
    except ResultsError:
        is_own_file = (root / "plan.json").is_file()
        state = "may be the study file of an earlier run (plan.json, which states it, is damaged)"
    if is_own_file and _is_overwritten(copy, study):
        suggestion = _suggested_folder(root, study.name, bool(study.quick))
        raise ForeignFolder(
            f"{copy} {state} and would be overwritten: use another folder, such as --out {suggestion},"
            " or move the file"
        )


def _is_overwritten(file: Path, study: "Study") -> bool:
    """Return True if a run of the study would replace a file by another text."""
    is_written = file.is_file() and Path(study.path).resolve() != file
    return is_written and file.read_bytes() != study.text.encode()


def _suggested_folder(root: Path, study: str, quick: bool) -> str:
    """Suggest a results folder other than ``root``."""
    default = "results/" + results_folder(study, quick, None).name
    return f"{default}-2" if root.resolve() == Path(default).resolve() else default


def _stored_study(root: Path) -> str | None:
    """Return the study of a results folder, from its marker or its plan; None for a folder without results."""
    kind, name = owner(root) or ("", "")
    if kind == RESULTS:
        return name
    try:
        return None if kind else str(open_results(root).plan["study"])
    except (ResultsError, OSError):
        return None


def _contents(root: Path) -> str:
    """Format the numbers of units and failures in a folder, as `12 units, 1 failure`."""
    counts = {"unit": len(own_files.UNITS.find(root)), "failure": len(own_files.FAILURES.find(root))}
    return ", ".join(f"{count} {kind}{'s' * (count != 1)}" for kind, count in counts.items())


DISCARDED = (  # files that ``discard`` removes
    own_files.UNITS,
    own_files.FAILURES,
    *own_files.DAMAGED,
    own_files.CHOICES,
    own_files.TRIALS,
    own_files.TABLES,
)


def discard(root: Path, study: str) -> str:
    """Remove all units, failures, choices, trials and the table of a folder, and assign it to ``study``.

    Journals, scans, figures and files of the user are kept. Returns a description if results of another study were
    removed, else "". Raises FolderInUse if another run uses the folder.
    """
    with lock(root):
        refuse_folder_in_use(root)
        stored_study, contents = _stored_study(root), _contents(root)
        own_files.remove(root, *DISCARDED)
        if stored_study == study:
            return ""
        mark(root, RESULTS, study)
        (root / "plan.json").unlink(missing_ok=True)
    return f"deleted in {root}: the results of the study `{stored_study}` ({contents})"
