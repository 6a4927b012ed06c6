"""Early end of a run: at the first Ctrl-C, SIGTERM or SIGHUP the running jobs finish and are sealed.

A second signal ends the process at once. A run that reaches its bounds ends like one that gets a first signal.
The event that passes a request on to workers needs shared memory; errors of that are worded here.
"""

import errno
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from bearingsim.errors import Signalled, UserError
from bearingsim.interruption import raise_lost
from bearingsim.text.terminal import say

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_received = 0  # number of the signal received by this process, 0 without one
_flag: Any = None  # event that passes the request to stop on to workers
_enough = False  # True after the run itself requested the end


def stop_requested() -> bool:
    """Return True after a request to stop, in this process or the parent of this worker."""
    return _received != 0 or _enough or (_flag is not None and bool(_flag.is_set()))


def flag_for_workers() -> Any:
    """Return the event that tells workers to stop, made once: another event would need new workers.

    Raises NoSharedMemory.
    """
    global _flag
    if _flag is None:
        from joblib.externals.loky.backend.context import get_context

        with in_shared_memory():
            _flag = get_context("loky").Event()
    return _flag


def heed(flag: Any) -> None:
    """Take the request to stop from this event from now on, in a worker."""
    global _flag
    _flag = flag


def take_flag(flag: Any) -> None:
    """Heed the event and ignore signals, in a worker: a terminal sends signals to all processes at once."""
    heed(flag)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def heeding() -> Iterator[None]:
    """Record the first signal, and raise Signalled at the end, after the running jobs have finished."""
    global _received
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    raise_lost()
    with _handling(_ask):
        try:
            yield
            if _received:
                raise Signalled(_received)
        finally:
            _received = 0
            if _flag is not None:
                _flag.clear()


@contextmanager
def ending() -> Iterator[Callable[[], None]]:
    """Yield a function that stops a run as a signal does; the request is withdrawn on leaving."""
    global _enough

    def end() -> None:
        global _enough
        _enough = True
        if _flag is not None:
            _flag.set()

    try:
        yield end
    finally:
        _enough = False
        if _flag is not None:
            _flag.clear()


@contextmanager
def ignoring() -> Iterator[None]:
    """Ignore signals while workers start: they inherit this, so that only this process handles interrupts."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _handling(signal.SIG_IGN):
        yield


@contextmanager
def _handling(handler: Any) -> Iterator[None]:
    """Set another handler for signals that are not ignored already (as under nohup)."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    heard = {number: old for number, old in before.items() if old not in (signal.SIG_IGN, None)}
    for number in heard:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, old in heard.items():
            signal.signal(number, old)


def _ask(number: int, frame: FrameType | None) -> None:
    global _received
    _received = number
    if _flag is not None:
        _flag.set()
    for other in SIGNALS:
        signal.signal(other, signal.SIG_DFL)
    say("finishing the running jobs (press again to stop at once)", err=True)


WRONG = {
    errno.ENOSPC: "is full: free some space",
    errno.EROFS: "is read-only: make it writable",
    errno.EACCES: "is not writable for this user: change its permissions",
    errno.EPERM: "is not writable for this user: change its permissions",
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
