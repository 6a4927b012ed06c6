"""The scans of a study, kept with its results: these can be drawn where, and after, the files are gone."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.store import regular
from bearingsim.store.files import copy, write_bytes
from bearingsim.store.own_files import ID, SCANS

if TYPE_CHECKING:
    from bearingsim.config import Case

__all__ = [
    "copy_scans",
    "held_scans",
    "keep_scans",
    "kept_scan",
    "kept_scans",
    "own_scan",
    "short_path",
    "with_short_paths",
]


def keep_scans(root: Path, cases: Iterable["Case"]) -> None:
    """Copy the scans of some cases to ``scans/<digest>.<ext>``, unless they are there.

    Raises ScanError if one is gone, or is no longer what its case was made from.
    """
    for digest, file in _scans(cases):
        kept = kept_scan(root, digest, file)
        if not _holds(kept, digest):
            write_bytes(kept, _content(Path(file), digest))


def kept_scans(root: Path, cases: Iterable["Case"]) -> dict[str, bytes]:
    """The copies of the scans of some cases, by their names ``<digest>.<ext>``."""
    copies = (kept_scan(root, digest, file) for digest, file in _scans(cases))
    return {copy.name: copy.read_bytes() for copy in copies}


def with_short_paths(case: "Case") -> "Case":
    """The case with its scans' files named as results name them, for a machine where they are not."""
    if all(d.file is None for d in case.defects):
        return case
    named = tuple(d if d.file is None else d.model_copy(update={"file": short_path(d.file)}) for d in case.defects)
    return case.model_copy(update={"defects": named})


def _scans(cases: Iterable["Case"]) -> list[tuple[str, str]]:
    """Digest and file of each scan that some cases have."""
    return sorted({(d.digest, d.file) for case in cases for d in case.defects if d.file and d.digest})


def held_scans(root: Path) -> list[Path]:
    """The scans that a results folder keeps. Raises ScanError for one that is not what its name says."""
    from bearingsim.config.scan.file import ScanError

    found = SCANS.of(root)
    for path in found:
        if not _holds(path, path.stem):
            raise ScanError(f"`{path}` is not as it was written", "remove it, and run the study there again")
    return found


def copy_scans(scans: Iterable[Path], root: Path) -> None:
    """Copy scans that another results folder keeps, unless they are there."""
    for path in scans:
        kept = root / "scans" / path.name
        if not _holds(kept, path.stem):
            copy(path, kept)


def own_scan(root: Path, digest: str, file: str) -> Path:
    """Find the copy of a scan in a results folder. Raises ScanError without one that is as it was written."""
    from bearingsim.config.scan.file import ScanError

    kept = kept_scan(root, digest, file)
    if not re.fullmatch(ID, digest) or not _holds(kept, digest):
        raise ScanError(f"its scan is not kept in {root / 'scans'}", "run the study again where the scan is")
    return kept


def kept_scan(root: Path, digest: str, file: str) -> Path:
    """Where the copy of a scan lies in a results folder."""
    return root / "scans" / f"{digest}{Path(file).suffix.lower()}"


def short_path(file: str) -> str:
    """A path as it may be shown to others: from the working folder, or else without its folders."""
    path = Path(file)
    if not path.is_absolute():
        return file
    return path.relative_to(Path.cwd()).as_posix() if path.is_relative_to(Path.cwd()) else path.name


def _holds(path: Path, digest: str) -> bool:
    try:
        return regular.digest(path).startswith(digest)
    except (OSError, regular.Unreadable):
        return False


def _content(path: Path, digest: str) -> bytes:
    from bearingsim.config.scan.file import ScanError, digest_of

    try:
        content = path.read_bytes()
    except OSError as error:
        raise ScanError(f"`{path}` cannot be read: {error.strerror}") from None
    if digest_of(content) != digest:
        raise ScanError(f"`{path}` has changed since the study was read", "run it again")
    return content
