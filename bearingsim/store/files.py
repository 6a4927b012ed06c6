"""Files of a results folder that are either whole or absent.

Everything is written under a ``.part`` name that carries the host and process of its writer, fsynced and
renamed, so a power cut or ``kill -9`` never leaves half a file under a final name.
"""

import errno
import os
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock

from bearingsim.errors import UserError

__all__ = [
    "DiskFull",
    "check_room",
    "lock",
    "room",
    "sweep",
    "temporary_files",
    "unit_files",
    "write_bytes",
    "write_text",
    "writer",
    "writer_is_dead",
]

LEFTOVER = (".part", ".started")
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
ADVICE = "make room, or take another folder by --out, and give the command again: what is stored stays"
FOREIGN_AGE_S = 86400.0  # another host's process cannot be asked: longer than any job takes


class DiskFull(UserError):
    """There is no room for a file."""


def writer() -> str:
    """``host-pid`` of this process, as it stands in the names of its temporary files."""
    host = "".join(c if c.isalnum() or c == "-" else "_" for c in socket.gethostname())
    return f"{host or 'host'}-{os.getpid()}"


@contextmanager
def room(path: Path) -> Iterator[None]:
    """Tell by name of a disk on which there is no room for ``path``. Raises DiskFull."""
    try:
        yield
    except OSError as error:
        if error.errno not in FULL:
            raise
        raise DiskFull(f"{_what_is_full(path, error.errno)}: {ADVICE}") from error


def _what_is_full(path: Path, number: int) -> str:
    folder = _nearest(path.parent)
    if number == errno.EFBIG:
        return f"no file may grow so large (`ulimit -f`), and so {folder} takes no {path.name}"
    left = f"{shutil.disk_usage(folder).free / 1e3:.0f} kB are left"
    return f"the disk {_mount(folder)} is full ({left}), and so {folder} takes no {path.name}"


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


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file whole or not at all: under a temporary name, fsynced, renamed. Raises DiskFull, OSError."""
    part = path.with_name(f"{path.name}.{writer()}.part")
    with room(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        if os.name == "posix":
            _fsync(path.parent)


def _fsync(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all. Raises DiskFull, OSError."""
    write_bytes(path, text.encode())


@contextmanager
def lock(root: Path) -> Iterator[None]:
    """The lock that parents sharing a folder hold while they build the table or sweep; dies with its holder."""
    with room(root / ".lock"), FileLock(root / ".lock"):
        yield


def unit_files(root: Path) -> list[Path]:
    """Sealed unit files of a results folder, sorted by name."""
    return sorted((root / "units").glob("??/*.h5"))


def sweep(root: Path) -> list[Path]:
    """Remove temporary files whose writers no longer run; return what was removed."""
    with lock(root):
        leftovers = [path for path in temporary_files(root) if writer_is_dead(path)]
        for path in leftovers:
            path.unlink(missing_ok=True)
    return leftovers


def temporary_files(root: Path) -> list[Path]:
    """``.part`` files and start markers of a results folder, of living and dead writers alike."""
    patterns = [
        f"{folder}*{end}" for folder in ("", "failed/", "scans/", "trials/", "units/??/") for end in LEFTOVER
    ]
    return [path for pattern in patterns for path in root.glob(pattern)]


def writer_is_dead(path: Path) -> bool:
    """True when the process named in a temporary file's name is known, or old enough, to be gone."""
    host, _, pid = path.name.rsplit(".", 2)[-2].rpartition("-")
    here, _, own = writer().rpartition("-")
    if host == here and pid != own and pid.isdigit() and _is_dead(int(pid)):
        return True
    try:
        return time.time() - path.stat().st_mtime > FOREIGN_AGE_S
    except FileNotFoundError:
        return True


def _is_dead(pid: int) -> bool:
    if os.name == "nt":  # there os.kill(pid, 0) is a Ctrl-C, not a question
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return _is_zombie(pid)


def _is_zombie(pid: int) -> bool:
    """Killed, but not yet waited for by whoever inherited it (Linux; elsewhere not known)."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] in "ZX"
