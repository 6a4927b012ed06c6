"""Errors of the shared memory in which worker processes keep their locks."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from bearingsim.errors import UserError

WRONG = {
    errno.ENOSPC: "is full: make room there",
    errno.EROFS: "is read-only: make it writable",
    errno.EACCES: "is closed to this user: make it writable",
    errno.EPERM: "is closed to this user: make it writable",
    errno.ENOENT: "is missing: mount it",
    errno.ENOSYS: "is missing: mount it",
}
"""Causes by error number of ``sem_open``, which makes a file in /dev/shm for each lock."""


class NoSharedMemory(UserError):
    """Worker processes cannot be started for want of shared memory."""


@contextmanager
def in_shared_memory() -> Iterator[None]:
    """Turn errors of locks in shared memory into NoSharedMemory, which names the cause."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno not in WRONG:
            raise
        wrong = WRONG[error.errno]
        raise NoSharedMemory(f"worker processes need /dev/shm, which {wrong}, or use `--jobs 1`") from error
