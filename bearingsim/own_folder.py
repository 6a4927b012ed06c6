"""Folders that no other user can write to, so that compiled code in them is safe to run.

Every level of a path is checked, from the root down, because a user with write permission in a folder can rename
its entries. In a sticky folder such as /tmp other users cannot rename entries, but they can create an entry first;
each level must therefore belong to this user or to root. On Windows, which has no such modes, nothing is checked.
"""

import os
import stat
from functools import cache
from pathlib import Path

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
"""Mode bits of the write permission of the group and of other users."""


class UntrustedFolder(OSError):
    """A folder to which another user may have written; the message states the reason."""


def own_folder(base: Path, *names: str) -> Path:
    """Create the folder ``base``/names if it is missing, and check that no other user can write to it.

    names: one level or more. Returns the folder with links resolved. Missing levels are created with mode 0700.
    From every level of ``names`` except the last, the write permission of others is removed if the level belongs
    to this user; the last is only checked, because it may already contain files of others. Raises
    ``UntrustedFolder``, and OSError or RuntimeError if the path cannot be resolved or created.
    """
    path = base.joinpath(*names)
    _check_dangling_links(path)
    folder = path.resolve()
    levels = (folder, *folder.parents)
    for level in path.parents[: len(names) - 1]:
        _remove_write_permission(level)
    missing = [level for level in levels if not level.exists()]
    _check_path(missing[-1].parent if missing else folder.parent)
    for level in reversed(missing):
        level.mkdir(mode=0o700, exist_ok=True)
    _check_path(folder.parent)
    _check_level(folder, allow_sticky=False)
    return folder


def _is_trusted(owner: int) -> bool:
    return not hasattr(os, "getuid") or owner in (0, os.getuid())


def _check_dangling_links(path: Path) -> None:
    """Raise ``UntrustedFolder`` for a dangling link of another user; creating the folder would follow it."""
    for level in (path, *path.parents):
        if level.is_symlink() and not level.resolve().exists() and not _is_trusted(level.lstat().st_uid):
            raise UntrustedFolder(f"{level} is another user's link")


def _remove_write_permission(folder: Path) -> None:
    """Remove the write permission of other users from a folder of this user."""
    if hasattr(os, "getuid") and folder.is_dir() and not folder.is_symlink():
        status = folder.stat()
        if status.st_uid == os.getuid() and status.st_mode & OTHERS_WRITE:
            folder.chmod(stat.S_IMODE(status.st_mode) & ~OTHERS_WRITE)


def _check_path(folder: Path) -> None:
    """Raise ``UntrustedFolder`` if another user can redirect any level of a resolved path."""
    for level in (*reversed(folder.parents), folder):
        _check_level(level, allow_sticky=True)


def _check_level(level: Path, allow_sticky: bool) -> None:
    status = level.lstat()
    if not _is_trusted(status.st_uid):
        raise UntrustedFolder(f"{level} is owned by another user")
    if _others_write(status) and not (allow_sticky and status.st_mode & stat.S_ISVTX):
        raise UntrustedFolder(f"other users can write to {level}; `chmod go-w {level}` prevents this")


def _others_write(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):
        return False
    if status.st_mode & stat.S_IWOTH:
        return True
    return bool(status.st_mode & stat.S_IWGRP) and not _is_own_group(status.st_gid)


@cache
def _is_own_group(group: int) -> bool:
    """Return True for the private group of this user, which has the name of the user and no other members."""
    import grp
    import pwd

    try:
        user, group_entry = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    others = {entry.pw_name for entry in pwd.getpwall() if entry.pw_gid == group} | set(group_entry.gr_mem)
    return group_entry.gr_name == user.pw_name and user.pw_gid == group and others <= {user.pw_name}
