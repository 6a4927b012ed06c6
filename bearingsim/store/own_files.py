"""Names of the program's files in a results folder; all other files belong to the user.

Only files with these names are replaced, renamed or removed.
"""

import re
from pathlib import Path
from typing import NamedTuple

ID = "[0-9a-f]{16}"
"""Pattern of the id of a job or a unit, and of the digest of a scan."""


class OwnFiles(NamedTuple):
    """Files of one kind: glob pattern of their folder, and regular expression of their paths."""

    folder: str
    path: str

    def find(self, root: Path) -> list[Path]:
        """List the files of this kind in a results folder, sorted; folders with matching names are left out."""
        paths = sorted(root.glob(f"{self.folder}*"))
        return [path for path in paths if self._matches(path.relative_to(root)) and not path.is_dir()]

    def _matches(self, path: Path) -> bool:
        return re.fullmatch(self.path, path.as_posix()) is not None


UNIT_PATTERN = r"units/(?=(..)/\1)../" + ID
"""Regular expression of the path of a unit without its suffix; the folder is named after the first two digits."""
UNITS = OwnFiles("units/??/", rf"{UNIT_PATTERN}\.h5")
FAILURES = OwnFiles("failed/", rf"failed/{ID}\.json")
TRIALS = OwnFiles("trials/", rf"trials/{ID}\.json")
SCANS = OwnFiles("scans/", rf"scans/{ID}\.\w+")
CHOICES = OwnFiles("", r"choices\.json")
TABLES = OwnFiles("", r"study\.h5|results\.csv")
DAMAGED = (OwnFiles("units/??/", rf"{UNIT_PATTERN}\.damaged"), OwnFiles("failed/", rf"failed/{ID}\.damaged"))
FOLDERS = ("failed", "figures", "scans", "trials", "units", "units/??")
"""Glob patterns of the subfolders of a results folder; none may be a link."""

TOP_FILES = r"bearingsim\.json|plan\.json|study\.yaml|study\.h5|results\.csv|choices\.json"
TEMPORARY_NAME = re.compile(rf"(run|{TOP_FILES}|{ID}(\.\w+)?)\.[\w-]+-\d+-[0-9a-f]{{8}}\.(part|started)")
LOCK = ".lock"


def temporary_files(root: Path) -> list[Path]:
    """List the ``.part`` files and start markers of a results folder, also those of running processes."""
    folders = [root, *(path for name in FOLDERS for path in root.glob(name) if path.is_dir())]
    return [path for folder in folders for path in sorted(folder.iterdir()) if TEMPORARY_NAME.fullmatch(path.name)]


def foreign_entries(root: Path) -> list[str]:
    """List the entries of a folder, except temporary files and the lock of a run that was killed at its start."""
    return sorted(
        path.name for path in root.iterdir() if not (TEMPORARY_NAME.fullmatch(path.name) or _is_lock(path))
    )


def _is_lock(path: Path) -> bool:
    """Return True for the lock file, which is always empty because locking truncates it."""
    return path.name == LOCK and path.is_file() and not path.is_symlink() and path.stat().st_size == 0


def remove(root: Path, *kinds: OwnFiles) -> int:
    """Remove all files of some kinds and the folders that this leaves empty; return the number of files."""
    files = [path for kind in kinds for path in kind.find(root)]
    for path in files:
        path.unlink(missing_ok=True)
    for folder in sorted({path.parent for path in files} - {root}):
        _remove_empty(folder, root)
    return len(files)


def _remove_empty(folder: Path, root: Path) -> None:
    """Remove a folder and its parents within ``root`` if they are empty."""
    while folder != root and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
