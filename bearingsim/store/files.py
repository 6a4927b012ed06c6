"""Files of a results folder that are either whole or absent.

Everything is written under a ``.part`` name that carries the host and process of its writer, fsynced and
renamed, so a power cut or ``kill -9`` never leaves half a file under a final name.
"""

import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import BaseFileLock, FileLock

__all__ = ["lock", "sealing", "sweep", "temporary_files", "unit_files", "write_text", "writer", "writer_is_dead"]

LEFTOVER = (".part", ".started")
FOREIGN_AGE_S = 86400.0  # another host's process cannot be asked: longer than any job takes


def writer() -> str:
    """``host-pid`` of this process, as it stands in the names of its temporary files."""
    host = "".join(c if c.isalnum() or c == "-" else "_" for c in socket.gethostname())
    return f"{host or 'host'}-{os.getpid()}"


@contextmanager
def sealing(path: Path) -> Iterator[Path]:
    """Give a ``.part`` path to write; on leaving fsync it and rename it to ``path``, on an error remove it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.{writer()}.part")
    try:
        yield part
        _fsync(part)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    if os.name == "posix":
        _fsync(path.parent)


def _fsync(path: Path) -> None:
    flags = os.O_RDONLY if path.is_dir() else os.O_RDWR
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with sealing(path) as part:
        part.write_text(text, encoding="utf-8")


def lock(root: Path) -> BaseFileLock:
    """The lock that parents sharing a folder hold while they build the table or sweep; dies with its holder."""
    return FileLock(root / ".lock")


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
