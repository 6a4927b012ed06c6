"""The shared memory in which worker processes keep their locks: what is wrong with it, by name."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from bearingsim.errors import UserError

__all__ = ["NoSharedMemory", "in_shared_memory"]

WRONG = {
    errno.ENOSPC: "is full: make room there",
    errno.EROFS: "is read-only: make it writable",
    errno.EACCES: "is closed to this user: make it writable",
    errno.EPERM: "is closed to this user: make it writable",
    errno.ENOENT: "is missing: mount it",
    errno.ENOSYS: "is missing: mount it",
}
"""Errors of ``sem_open``, by which each lock gets a file in /dev/shm."""


class NoSharedMemory(UserError):
    """Worker processes cannot be started for want of shared memory."""


@contextmanager
def in_shared_memory() -> Iterator[None]:
    """Name the shared memory where a lock cannot be made in it. Raises NoSharedMemory."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno not in WRONG:
            raise
        wrong = WRONG[error.errno]
        raise NoSharedMemory(f"worker processes need /dev/shm, which {wrong}, or use `--jobs 1`") from error
