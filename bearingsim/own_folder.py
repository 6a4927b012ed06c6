"""Folders in which nobody else can put anything: what lies there may be run.

Every level of a path counts, from the root down: who may write in a folder can rename what lies in it. In a sticky
one, such as the temporary folder, others cannot rename what is not theirs, but they may make a name first; so each
level must belong to this user or to root. Windows is not looked at: its folders have no such modes.
"""

import os
import stat
from functools import cache
from pathlib import Path

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class Distrusted(OSError):
    """Why what lies in a folder may be another user's."""


def own_folder(base: Path, *names: str) -> Path:
    """The folder ``base``/names, links resolved: nobody else can put anything there, or change where it leads.

    What is missing of it is made for this user alone (0700). Of the ``names``, all but the last are closed to
    others if they are this user's; not the last, in which others may have put something. Raises ``Distrusted``,
    and OSError or RuntimeError if there is no such place.
    """
    named = base.joinpath(*names)
    _refuse_loose_links(named)
    folder = named.resolve()
    levels = (folder, *folder.parents)
    for level in named.parents[: len(names) - 1]:
        _close(level)
    missing = [level for level in levels if not level.exists()]
    _check(missing[-1].parent if missing else folder.parent)
    for level in reversed(missing):
        level.mkdir(mode=0o700, exist_ok=True)
    _check(folder.parent)
    _check_one(folder, sticky_will_do=False)
    return folder


def _is_trusted(owner: int) -> bool:
    return not hasattr(os, "getuid") or owner in (0, os.getuid())


def _refuse_loose_links(path: Path) -> None:
    """Raise ``Distrusted`` if a link leads nowhere that another has made: nothing is to be made there."""
    for level in (path, *path.parents):
        if level.is_symlink() and not level.resolve().exists() and not _is_trusted(level.lstat().st_uid):
            raise Distrusted(f"{level} is another user's link")


def _close(folder: Path) -> None:
    """Let nobody else write in a folder that is this user's."""
    if hasattr(os, "getuid") and folder.is_dir() and not folder.is_symlink():
        found = folder.stat()
        if found.st_uid == os.getuid() and found.st_mode & OTHERS_WRITE:
            folder.chmod(stat.S_IMODE(found.st_mode) & ~OTHERS_WRITE)


def _check(folder: Path) -> None:
    """Raise ``Distrusted`` if others can change what any level of a resolved path leads to."""
    for level in (*reversed(folder.parents), folder):
        _check_one(level, sticky_will_do=True)


def _check_one(level: Path, sticky_will_do: bool) -> None:
    found = level.lstat()
    if not _is_trusted(found.st_uid):
        raise Distrusted(f"{level} belongs to another user")
    if _others_write(found) and not (sticky_will_do and found.st_mode & stat.S_ISVTX):
        raise Distrusted(f"others can write in {level} (`chmod go-w` closes it)")


def _others_write(found: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):
        return False
    if found.st_mode & stat.S_IWOTH:
        return True
    return bool(found.st_mode & stat.S_IWGRP) and not _is_own_group(found.st_gid)


@cache
def _is_own_group(group: int) -> bool:
    """Whether a group is this user's private one: of that name, and nobody else in it."""
    import grp
    import pwd

    try:
        user, named = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    others = {one.pw_name for one in pwd.getpwall() if one.pw_gid == group} | set(named.gr_mem)
    return named.gr_name == user.pw_name and user.pw_gid == group and others <= {user.pw_name}
