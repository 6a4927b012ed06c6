"""Files of a results folder that are either whole or absent.

Everything is written under a ``.part`` name, fsynced and renamed, so a power cut or ``kill -9`` never leaves half
a file under a final name. Whoever writes a temporary file holds its lock, which ends with the process, wherever
that runs: so what was left behind can be told from what is being written.
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

__all__ = [
    "DiskFull",
    "LinkWithin",
    "check_room",
    "copy",
    "left_behind",
    "lock",
    "open_to_append",
    "refuse_links",
    "room",
    "sweep",
    "temporary",
    "what_is_full",
    "write_bytes",
    "write_text",
    "writer",
]

ADVICE = "make room, or take another folder by --out, and give the command again: what is stored stays"
PATIENCE_S = 5.0
"""How long a lock is waited for in silence."""
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)


class DiskFull(UserError):
    """There is no room for a file."""


class LinkWithin(UserError):
    """A part of a results folder lies elsewhere."""


def writer() -> str:
    """``host-pid`` of this process, as it stands in the names of its files."""
    host = "".join(c if c.isalnum() or c == "-" else "_" for c in socket.gethostname())
    return f"{host or 'host'}-{os.getpid()}"


@contextmanager
def room(path: Path) -> Iterator[None]:
    """Tell by name of a disk on which there is no room for ``path``. Raises DiskFull."""
    try:
        yield
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        raise DiskFull(f"{what_is_full(path, error.errno)}: {ADVICE}") from error


def what_is_full(path: Path, number: int) -> str:
    """Tell why there is no room for a file; number: of the system's error, one of NO_ROOM."""
    folder = _nearest(path.parent)
    if number == errno.EFBIG:
        return f"no file may grow so large (`ulimit -f`), and so {folder} takes no {path.name}"
    left = f"{shutil.disk_usage(folder).free / 1e3:.0f} kB are left"
    full = f"has no inodes left for more files, though {left}" if _inodes_are_out(folder) else f"is full ({left})"
    return f"the disk {_mount(folder)} {full}, and so {folder} takes no {path.name}"


def _inodes_are_out(folder: Path) -> bool:
    if not hasattr(os, "statvfs"):
        return False
    disk = os.statvfs(folder)
    return disk.f_files > 0 and disk.f_favail == 0  # some file systems count none


def _nearest(folder: Path) -> Path:
    """The folder, or the one above it that there is."""
    return next((one for one in (folder, *folder.absolute().parents) if one.is_dir()), folder)


def _mount(folder: Path) -> Path:
    whole = folder.resolve()
    return next(one for one in (whole, *whole.parents) if one.is_mount() or one == one.parent)


def check_room(root: Path, wanted: float) -> None:
    """Raises DiskFull if the disk of ``root`` has less room than ``wanted`` bytes."""
    left = shutil.disk_usage(root).free
    if left < wanted:
        sizes = f"{left / 1e6:.3g} MB are left of the {wanted / 1e6:.3g} MB that the results take at least"
        raise DiskFull(f"the disk {_mount(root)} has no room for {root}: {sizes}: {ADVICE}")


def write_bytes(path: Path, content: bytes | BinaryIO) -> None:
    """Write a file whole or not at all: under a temporary name, fsynced, renamed. Raises DiskFull, OSError.

    content: bytes, or an open file to be copied.
    """
    with room(path), temporary(path.parent, path.name, "part") as file:
        if isinstance(content, bytes):
            file.write(content)
        else:
            shutil.copyfileobj(content, file)
        file.flush()
        os.fsync(file.fileno())
        os.replace(file.name, path)
        if os.name == "posix":
            _fsync(path.parent)


def copy(path: Path, into: Path) -> None:
    """Copy a file whole or not at all. Raises Unreadable if it is a link or no file, DiskFull, OSError."""
    try:
        with open_regular(path) as file:
            write_bytes(into, file)
    except Unreadable as error:
        raise Unreadable(f"{path} cannot be copied: {error}") from None


@contextmanager
def temporary(folder: Path, name: str, end: str) -> Iterator[BinaryIO]:
    """A new file whose lock lives and dies with its writer; on leaving it is removed, unless it was renamed."""
    folder.mkdir(parents=True, exist_ok=True)
    file = _locked(folder, name, end)
    try:
        with file:
            yield file
    finally:
        Path(file.name).unlink(missing_ok=True)


def _locked(folder: Path, name: str, end: str) -> BinaryIO:
    while True:
        path = folder / f"{name}.{writer()}-{secrets.token_hex(4)}.{end}"
        file = path.open("xb")
        _take(file, wait=True)
        if path.exists():
            return file
        file.close()  # a sweep was quicker than the lock


def _take(file: BinaryIO, wait: bool) -> bool:
    """Lock a file; False if another holds it, or where there are no locks."""
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except (ImportError, OSError):
        return False
    return True


@contextmanager
def left_behind(path: Path) -> Iterator[bool]:
    """Whether the writer of a temporary file is known to be gone; nobody else finds so until this is left."""
    flags = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        file = os.fdopen(os.open(path, flags), "r+b", buffering=0)
    except OSError:  # it has just been removed, or is not ours to remove
        file = None
    if file is None:
        yield False
        return
    with file:
        yield _take(file, wait=False)


def _fsync(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def open_to_append(path: Path) -> TextIO:
    """A text file to add lines to; an OSError if a link stands for it."""
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
    return os.fdopen(os.open(path, flags, 0o666), "a", encoding="utf-8")


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all. Raises DiskFull, OSError."""
    write_bytes(path, text.encode())


@contextmanager
def lock(root: Path, wait: bool = True) -> Iterator[None]:
    """The lock that parents sharing a folder hold while they build the table or sweep; dies with its holder.

    On a disk that has no locks nothing is held. Whoever waits for long says for whom. Without ``wait`` raises
    filelock.Timeout if another holds it, and LinkWithin if a link stands for it.
    """
    _refuse_link(root / LOCK)
    held = FileLock(root / LOCK, timeout=PATIENCE_S if wait else 0)
    try:
        with room(root / LOCK):
            held.acquire()
    except Timeout:
        if not wait:
            raise
        advice = "end it if it is suspended or hangs"
        say(f"waiting for {_other_runs(root)}, which holds {held.lock_file}: {advice}", err=True)
        held.acquire(timeout=-1)  # the holder may be building a large table
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
    try:
        yield
    finally:
        held.release()


def _other_runs(root: Path) -> str:
    """The processes at work in a folder, as their start markers name them, but this one."""
    names = {path.name.split(".")[1].rpartition("-")[0] for path in root.glob("run.*.started")} - {writer()}
    return f"another run ({', '.join(sorted(names))})" if names else "another process"


def refuse_links(root: Path) -> None:
    """Raises LinkWithin where a link stands for one of the folders, or the lock: it leads out of the results."""
    for path in (path for name in (*FOLDERS, LOCK) for path in root.glob(name)):
        _refuse_link(path)


def _refuse_link(path: Path) -> None:
    if path.is_symlink():
        raise LinkWithin(
            f"{path} is a link, and leads out of the results folder: remove it, or put in its place what it"
            " stands for (`cp -rL`)"
        )


def sweep(root: Path) -> list[Path]:
    """Remove temporary files whose writers are gone; return what was removed."""
    removed = []
    with lock(root):
        for path in temporary_files(root):
            with left_behind(path) as left:
                if left:
                    path.unlink()
                    removed.append(path)
    return removed
