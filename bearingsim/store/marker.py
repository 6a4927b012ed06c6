"""Whose folder it is: the program writes only into folders that it has marked as its own.

``bearingsim.json`` is the first file of a folder. A results folder of an earlier version has none: there a sound
``plan.json`` stands for it.
"""

import secrets
from collections.abc import Sequence
from pathlib import Path

from bearingsim.errors import UserError
from bearingsim.store.files import LinkWithin, lock
from bearingsim.store.own_files import strangers
from bearingsim.store.sealed import UNREADABLE, read_json, write_json
from bearingsim.text.terminal import is_line

__all__ = ["MARKER", "NotOurs", "OtherStudy", "claim", "mark", "owner"]

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
        kind, name = told["format"], told["name"]
        return (kind, name) if is_line(kind) and is_line(name) else None
    except UNREADABLE:
        return None


def claim(folder: Path, kind: str, name: str, instead: str) -> None:
    """Mark a folder, made if need be, as one of the program's: that of some ``kind`` of results of ``name``.

    instead: the folder that a message proposes. Raises NotOurs for one that holds files of others, OtherStudy for
    one that is marked as something else, LinkWithin for one with a link to a file. Nothing is written then.
    """
    names = _strangers(folder, instead)
    if _is_marked(folder, kind, name, instead):  # after: another run may just have marked it, and begun to write
        _refuse_links_to_files(folder)
        return
    _refuse(folder, names, instead)
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


def _strangers(folder: Path, instead: str) -> list[str]:
    """Names of the files in a folder, but such as a killed run leaves. Raises NotOurs for what is no folder."""
    if folder.exists() and not folder.is_dir():
        raise NotOurs(f"{folder} is a file: name a folder, such as --out {instead}")
    return strangers(folder) if folder.exists() else []


def _refuse_links_to_files(folder: Path) -> None:
    """Raises LinkWithin: a table that is written through a link would replace a file outside."""
    for path in sorted(folder.iterdir()):
        if path.is_symlink() and not path.is_dir():
            raise LinkWithin(f"{path} is a link, and would lead out of the folder: remove it")


def _refuse(folder: Path, names: Sequence[str], instead: str) -> None:
    """Raises NotOurs if there are files of the user in a folder."""
    if names:
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        raise NotOurs(
            f"{folder} holds files of your own ({', '.join(names[:NAMED])}{more}), and nothing is written beside"
            f" them: name a folder for the results, such as --out {instead}"
        )
