"""Marker file of a folder: the program writes only into folders that it has marked as its own.

``bearingsim.json`` is the first file written to a folder. Results folders of earlier versions are recognised by an
intact ``plan.json`` instead.
"""

import secrets
from collections.abc import Sequence
from pathlib import Path

from bearingsim.errors import UserError
from bearingsim.store.files import LinkInFolder, lock
from bearingsim.store.own_files import foreign_entries
from bearingsim.store.sealed import UNREADABLE, read_json, write_json
from bearingsim.text.terminal import is_line

MARKER_FILE = "bearingsim.json"
MAX_NAMED_FILES = 3
"""Largest number of the user's files that a message names."""


class ForeignFolder(UserError):
    """A folder is not empty and has no marker of the program."""


class OtherStudy(UserError):
    """A folder belongs to another study, or is of another kind."""


def owner(folder: Path) -> tuple[str, str] | None:
    """Read kind and name from the marker of a folder; None without an intact marker."""
    try:
        entries = read_json(folder / MARKER_FILE)
        kind, name = entries["format"], entries["name"]
        return (kind, name) if is_line(kind) and is_line(name) else None
    except UNREADABLE:
        return None


def claim(folder: Path, kind: str, name: str, suggestion: str) -> None:
    """Mark a folder with the ``kind`` of its results and the ``name`` of the study; create it if it is missing.

    suggestion: folder suggested in error messages. Raises ForeignFolder for a folder with other files, OtherStudy
    for a folder with another marker, LinkInFolder for a folder with a link to a file. Nothing is written then.
    """
    names = _foreign_files(folder, suggestion)
    # The files are listed before the marker is read: those of a run that marks the folder in between are no reason
    # to refuse it.
    if _is_marked(folder, kind, name, suggestion):
        _refuse_links_to_files(folder)
        return
    _refuse_foreign_files(folder, names, suggestion)
    folder.mkdir(parents=True, exist_ok=True)
    with lock(folder):
        if not _is_marked(folder, kind, name, suggestion):
            mark(folder, kind, name)


def mark(folder: Path, kind: str, name: str) -> None:
    """Write the marker, replacing any earlier one."""
    write_json(folder / MARKER_FILE, {"format": kind, "name": name, "id": secrets.token_hex(8)})


def _is_marked(folder: Path, kind: str, name: str, suggestion: str) -> bool:
    """Return True if a folder is marked with this kind and name. Raises OtherStudy for another marker."""
    current = owner(folder)
    if current is not None and current != (kind, name):
        raise OtherStudy(
            f"{folder} contains {current[0]} of `{current[1]}`: use another folder, such as --out {suggestion}"
        )
    return current is not None


def _foreign_files(folder: Path, suggestion: str) -> list[str]:
    """List the entries of a folder, except those of a killed run. Raises ForeignFolder if ``folder`` is a file."""
    if folder.exists() and not folder.is_dir():
        raise ForeignFolder(f"{folder} is a file: use a folder, such as --out {suggestion}")
    return foreign_entries(folder) if folder.exists() else []


def _refuse_links_to_files(folder: Path) -> None:
    """Raise LinkInFolder if an entry of a folder is a link to a file, or a dangling link."""
    for path in sorted(folder.iterdir()):
        if path.is_symlink() and not path.is_dir():
            raise LinkInFolder(f"{path} is a link out of the folder: remove it")


def _refuse_foreign_files(folder: Path, names: Sequence[str], suggestion: str) -> None:
    """Raise ForeignFolder if a folder contains files of the user; names: their names, if there are any."""
    if names:
        more = f" and {len(names) - MAX_NAMED_FILES} more" if len(names) > MAX_NAMED_FILES else ""
        raise ForeignFolder(
            f"{folder} contains files of your own ({', '.join(names[:MAX_NAMED_FILES])}{more}):"
            f" use a separate folder for the results, such as --out {suggestion}"
        )
