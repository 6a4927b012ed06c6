"""Atomic writing of the files of a results folder.

Every file is written under a ``.part`` name, fsynced and renamed, so that a power failure or ``kill -9`` never
leaves an incomplete file under its final name. The writer locks its temporary file. The operating system releases
the lock when the process ends, so an unlocked temporary file is a leftover.
"""

import errno
import os
import secrets
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, TextIO

from filelock import FileLock, Timeout

from bearingsim.errors import NO_ROOM, UserError
from bearingsim.store.own_files import FOLDERS, LOCK, temporary_files
from bearingsim.store.regular import Unreadable, open_regular
from bearingsim.text.terminal import say

FULL_DISK_ADVICE = (
    "free some space or use another folder (--out), then run the command again; stored results are kept"
)
LOCK_REPORT_S = 5.0
"""Time in s after which waiting for a lock is reported."""
NO_LOCK_ERRORS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)
"""Error numbers of a file system that does not support locks."""


class DiskFull(UserError):
    """The disk has too little space for a file."""


class LinkInFolder(UserError):
    """An entry of a results folder is a link."""


def writer_name() -> str:
    """Return ``host-pid`` of this process, used in the names of its files."""
    host = "".join(c if c.isalnum() or c == "-" else "_" for c in socket.gethostname())
    return f"{host or 'host'}-{os.getpid()}"


@contextmanager
def full_disk_errors(path: Path) -> Iterator[None]:
    """Convert errors due to a full disk, when ``path`` is written, to DiskFull, which names the disk."""
    try:
        yield
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        raise DiskFull(f"{describe_full_disk(path, error.errno)}: {FULL_DISK_ADVICE}") from error


def describe_full_disk(path: Path, number: int) -> str:
    """Describe why a file does not fit on the disk; number: error number, one of NO_ROOM."""
    folder = _existing_folder(path.parent)
    if number == errno.EFBIG:
        return f"{path.name} in {folder} exceeds the file size limit (`ulimit -f`)"
    free_text = f"{shutil.disk_usage(folder).free / 1e3:.0f} kB are left"
    state = f"has no inodes left, although {free_text}" if _inodes_exhausted(folder) else f"is full ({free_text})"
    return f"the disk {_mount_point(folder)} {state}; {path.name} in {folder} cannot be written"


def _inodes_exhausted(folder: Path) -> bool:
    if not hasattr(os, "statvfs"):
        return False
    disk = os.statvfs(folder)
    return disk.f_files > 0 and disk.f_favail == 0  # some file systems report 0 inodes


def _existing_folder(folder: Path) -> Path:
    """Return the folder itself if it exists, or its nearest existing parent."""
    return next((path for path in (folder, *folder.absolute().parents) if path.is_dir()), folder)


def _mount_point(folder: Path) -> Path:
    resolved = folder.resolve()
    return next(path for path in (resolved, *resolved.parents) if path.is_mount() or path == path.parent)


def check_free_space(root: Path, required: float) -> None:
    """Raise DiskFull if the disk of ``root`` has less than ``required`` bytes of free space."""
    free = shutil.disk_usage(root).free
    if free < required:
        sizes = f"{free / 1e6:.3g} MB are left of at least {required / 1e6:.3g} MB"
        raise DiskFull(f"the disk {_mount_point(root)} is too full for {root}: {sizes}; {FULL_DISK_ADVICE}")


def write_bytes(path: Path, content: bytes | BinaryIO) -> None:
    """Write a file atomically: under a temporary name, fsynced, then renamed. Raises DiskFull, OSError.

    content: bytes, or an open file to copy.
    """
    with full_disk_errors(path), temporary(path.parent, path.name, "part") as file:
        if isinstance(content, bytes):
            file.write(content)
        else:
            shutil.copyfileobj(content, file)
        file.flush()
        os.fsync(file.fileno())
        os.replace(file.name, path)
        if os.name == "posix":
            _fsync(path.parent)


def copy(path: Path, target: Path) -> None:
    """Copy a file atomically. Raises Unreadable for a link or a special file, DiskFull, OSError."""
    try:
        with open_regular(path) as file:
            write_bytes(target, file)
    except Unreadable as error:
        raise Unreadable(f"{path} cannot be copied: {error}") from None


@contextmanager
def temporary(folder: Path, name: str, suffix: str) -> Iterator[BinaryIO]:
    """Create a temporary file, locked until its writer ends; remove it on exit unless it was renamed."""
    folder.mkdir(parents=True, exist_ok=True)
    file = _create_locked(folder, name, suffix)
    try:
        with file:
            yield file
    finally:
        Path(file.name).unlink(missing_ok=True)


def _create_locked(folder: Path, name: str, suffix: str) -> BinaryIO:
    while True:
        path = folder / f"{name}.{writer_name()}-{secrets.token_hex(4)}.{suffix}"
        try:
            file = path.open("xb")
        except OSError as error:
            error.filename = str(folder / name)  # the message must not contain the temporary name
            raise
        _lock_file(file, wait=True)
        if path.exists():
            return file
        file.close()  # ``remove_leftovers`` of another process removed it before it was locked


def _lock_file(file: BinaryIO, wait: bool) -> bool:
    """Lock a file; return False if another process has locked it, or the file system does not support locks."""
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except (ImportError, OSError):
        return False
    return True


@contextmanager
def lock_leftover(path: Path) -> Iterator[bool]:
    """Lock a temporary file within the context; yield True if its writer has ended, so that it can be locked."""
    flags = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        file = os.fdopen(os.open(path, flags), "r+b", buffering=0)
    except OSError:  # it has just been removed, or is owned by another user
        file = None
    if file is None:
        yield False
        return
    with file:
        yield _lock_file(file, wait=False)


def _fsync(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def open_to_append(path: Path) -> TextIO:
    """Open a text file to append lines; bytes that are not UTF-8 become `?`. Raises OSError if it is a link."""
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
    return os.fdopen(os.open(path, flags, 0o666), "a", encoding="utf-8", errors="replace")


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically. Raises DiskFull, OSError."""
    write_bytes(path, text.encode())


@contextmanager
def lock(root: Path, wait: bool = True) -> Iterator[None]:
    """Lock a folder, as required to build its table and to remove temporary files.

    The lock is released when its process ends; a file system without locks is not locked. A long wait is reported
    with the processes that run in the folder. Raises filelock.Timeout if another process has the lock and ``wait``
    is False, and LinkInFolder if the lock file is a link.
    """
    refuse_link(root / LOCK)
    folder_lock = FileLock(root / LOCK, timeout=LOCK_REPORT_S if wait else 0)
    try:
        with full_disk_errors(root / LOCK):
            folder_lock.acquire()
    except Timeout:
        if not wait:
            raise
        advice = "end it if it is suspended or hangs"
        say(f"waiting for {_other_runs(root)}, which has locked {folder_lock.lock_file}: {advice}", err=True)
        folder_lock.acquire(timeout=-1)  # without a limit, because building a large table takes long
    except OSError as error:
        if error.errno not in NO_LOCK_ERRORS:
            raise
    try:
        yield
    finally:
        folder_lock.release()


def _other_runs(root: Path) -> str:
    """Name the other processes that run in a folder, from their start markers."""
    names = {path.name.split(".")[1].rpartition("-")[0] for path in root.glob("run.*.started")} - {writer_name()}
    return f"another run ({', '.join(sorted(names))})" if names else "another process"


def is_writable(root: Path) -> bool:
    """Check if this user may write to a results folder and its lock file, if these exist."""
    return all(os.access(path, os.W_OK) for path in (root, root / LOCK) if path.exists())


def refuse_links(root: Path) -> None:
    """Raise LinkInFolder if a subfolder or the lock file is a link: it may point outside the results folder."""
    for path in (path for name in (*FOLDERS, LOCK) for path in root.glob(name)):
        refuse_link(path)


def refuse_link(path: Path) -> None:
    """Raise LinkInFolder if an entry of a results folder is a link."""
    if path.is_symlink():
        raise LinkInFolder(
            f"{path} is a link out of the results folder: remove it, or replace it by a copy of its target"
            " (`cp -rL`)"
        )


def remove_leftovers(root: Path) -> list[Path]:
    """Remove temporary files whose writers have ended; return their paths."""
    removed = []
    with lock(root):
        for path in temporary_files(root):
            with lock_leftover(path) as is_leftover:
                if is_leftover:
                    path.unlink(missing_ok=True)  # it may be missing: a writer unlocks its file, then removes it
                    removed.append(path)
    return removed
