"""Copies of the scans and roundness profiles of a study in its results folder.

With these copies the results folder does not depend on the original files.
"""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.store import regular
from bearingsim.store.files import copy, write_bytes
from bearingsim.store.own_files import ID, SCANS

if TYPE_CHECKING:
    from bearingsim.config import Case
    from bearingsim.config.sections.surfaces import Surfaces


def store_scans(root: Path, cases: Iterable["Case"]) -> None:
    """Copy the scans of some cases to ``scans/<digest>.<ext>``, unless intact copies exist.

    Raises ScanError if a scan is missing, or has changed since the study was read.
    """
    for digest, file in _list_scans(cases):
        copy_path = scan_path(root, digest, file)
        if not _is_intact(copy_path, digest):
            write_bytes(copy_path, _read_scan(Path(file), digest))


def read_scans(root: Path, cases: Iterable["Case"]) -> dict[str, bytes]:
    """Read the stored scans of some cases, by file name ``<digest>.<ext>``."""
    paths = (scan_path(root, digest, file) for digest, file in _list_scans(cases))
    return {path.name: path.read_bytes() for path in paths}


def with_short_paths(case: "Case") -> "Case":
    """Return a case with shortened paths of its scans, for a machine without the original files."""
    if not any(defect.file for defect in case.defects) and not (case.surfaces and case.surfaces.profiles):
        return case
    defects = tuple(
        defect if defect.file is None else defect.model_copy(update={"file": short_path(defect.file)})
        for defect in case.defects
    )
    return case.model_copy(update={"defects": defects, "surfaces": _with_short_profiles(case.surfaces)})


def _with_short_profiles(surfaces: "Surfaces | None") -> "Surfaces | None":
    if surfaces is None:
        return None
    races = {
        race: getattr(surfaces, race).model_copy(
            update={"roundness": profile.model_copy(update={"file": short_path(profile.file)})}
        )
        for race, profile in surfaces.profiles.items()
    }
    return surfaces.model_copy(update=races)


def _list_scans(cases: Iterable["Case"]) -> list[tuple[str, str]]:
    """List the digest and file of each scan and roundness profile of some cases, without duplicates."""
    files = set[tuple[str | None, str | None]]()
    for case in cases:
        files |= {(defect.digest, defect.file) for defect in case.defects}
        profiles = case.surfaces.profiles.values() if case.surfaces is not None else ()
        files |= {(profile.digest, profile.file) for profile in profiles}
    return sorted((digest, file) for digest, file in files if digest and file)


def check_scans(root: Path) -> list[Path]:
    """List the scans stored in a results folder. Raises ScanError if one has been changed."""
    from bearingsim.config.scan.file import ScanError

    scans = SCANS.find(root)
    for path in scans:
        if not _is_intact(path, path.stem):
            raise ScanError(f"`{path}` has been changed", "remove the file, and run the study again")
    return scans


def copy_scans(scans: Iterable[Path], root: Path) -> None:
    """Copy scans from another results folder, unless intact copies exist."""
    for path in scans:
        target = root / "scans" / path.name
        if not _is_intact(target, path.stem):
            copy(path, target)


def find_scan_copy(root: Path, digest: str, file: str) -> Path:
    """Return the path of the copy of a scan in a results folder. Raises ScanError without an intact copy."""
    from bearingsim.config.scan.file import ScanError

    copy_path = scan_path(root, digest, file)
    if not re.fullmatch(ID, digest) or not _is_intact(copy_path, digest):
        raise ScanError(f"its scan is not stored in {root / 'scans'}", "run the study again where the scan is")
    return copy_path


def scan_path(root: Path, digest: str, file: str) -> Path:
    """Return the path of the copy of a scan in a results folder, which need not exist."""
    return root / "scans" / f"{digest}{Path(file).suffix.lower()}"


def short_path(file: str) -> str:
    """Make an absolute path relative to the working folder, or reduce it to the file name outside that folder."""
    path = Path(file)
    if not path.is_absolute():
        return file
    return path.relative_to(Path.cwd()).as_posix() if path.is_relative_to(Path.cwd()) else path.name


def _is_intact(path: Path, digest: str) -> bool:
    try:
        return regular.digest(path).startswith(digest)
    except (OSError, regular.Unreadable):
        return False


def _read_scan(path: Path, digest: str) -> bytes:
    """Read an original scan. Raises ScanError if it is missing or does not match its digest."""
    from bearingsim.config.scan.file import ScanError, digest_of

    try:
        content = path.read_bytes()
    except OSError as error:
        raise ScanError(f"`{path}` cannot be read: {error.strerror}") from None
    if digest_of(content) != digest:
        raise ScanError(f"`{path}` has changed since the study was read", "run the study again")
    return content
