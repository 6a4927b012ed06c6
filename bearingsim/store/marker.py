"""Whose folder it is: the program writes only into folders that it has marked as its own.

``bearingsim.json`` is the first file of a folder. A results folder of an earlier version has none: there a sound
``plan.json`` stands for it.
"""

import secrets
from pathlib import Path

from bearingsim.errors import UserError
from bearingsim.store.files import lock
from bearingsim.store.own_files import strangers
from bearingsim.store.sealed import UNREADABLE, read_json, write_json

__all__ = ["MARKER", "NotOurs", "OtherStudy", "claim", "owner", "refuse_strangers"]

MARKER = "bearingsim.json"
NAMED = 3
"""Files of the user that a message names."""


class NotOurs(UserError):
    """A folder that is not empty, and does not carry the program's marker."""


class OtherStudy(UserError):
    """A folder holds what belongs to another study, or is of another kind."""


def owner(folder: Path) -> tuple[str, str] | None:
    """Kind and name that the marker of a folder tells; None without a sound marker."""
    try:
        told = read_json(folder / MARKER)
        return str(told["format"]), str(told["name"])
    except UNREADABLE:
        return None


def claim(folder: Path, kind: str, name: str, instead: str) -> None:
    """Mark a folder, made if need be, as one of the program's: that of some ``kind`` of results of ``name``.

    instead: the folder that a message proposes. Raises NotOurs for one that holds files of others, OtherStudy for
    one that is marked as something else. Nothing is written then.
    """
    if _is_marked(folder, kind, name, instead):
        return
    refuse_strangers(folder, instead)
    folder.mkdir(parents=True, exist_ok=True)
    with lock(folder):
        if not _is_marked(folder, kind, name, instead):
            mark(folder, kind, name)


def mark(folder: Path, kind: str, name: str) -> None:
    """Write the marker, in place of any that is there."""
    write_json(folder / MARKER, {"format": kind, "name": name, "id": secrets.token_hex(8)})


def _is_marked(folder: Path, kind: str, name: str, instead: str) -> bool:
    """Whether a folder is marked as this. Raises OtherStudy if it is as something else."""
    marked = owner(folder)
    if marked is not None and marked != (kind, name):
        raise OtherStudy(
            f"{folder} holds {marked[0]} of `{marked[1]}`: name another folder, such as --out {instead}"
        )
    return marked is not None


def refuse_strangers(folder: Path, instead: str) -> None:
    """Raises NotOurs if there are files in a folder, but such as the program leaves when it is killed."""
    if folder.exists() and not folder.is_dir():
        raise NotOurs(f"{folder} is a file: name a folder, such as --out {instead}")
    names = strangers(folder) if folder.exists() else []
    if names:
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        raise NotOurs(
            f"{folder} holds files of your own ({', '.join(names[:NAMED])}{more}), and nothing is written beside"
            f" them: name a folder for the results, such as --out {instead}"
        )
