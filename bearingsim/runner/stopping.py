"""Early end of a run: at the first Ctrl-C, SIGTERM or SIGHUP the running jobs finish and are stored.

A second signal ends the process at once. A run that reaches its limit of failures stops as after a first signal.
The event that passes the request to workers needs shared memory; if there is none, NoSharedMemory is raised.
"""

import errno
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from bearingsim.errors import Signalled, UserError
from bearingsim.interruption import raise_if_signalled
from bearingsim.text.terminal import say

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_received = 0  # number of the signal received by this process, or 0
_flag: Any = None  # event that passes a stop request to workers
_internal_stop = False  # True after the run itself has requested a stop


def stop_requested() -> bool:
    """Return True after a stop request, in this process or in the parent of this worker."""
    return _received != 0 or _internal_stop or (_flag is not None and bool(_flag.is_set()))


def flag_for_workers() -> Any:
    """Return the event that requests workers to stop. Raises NoSharedMemory.

    The event is created only once, because a new one would require new workers.
    """
    global _flag
    if _flag is None:
        from joblib.externals.loky.backend.context import get_context

        with check_shared_memory():
            _flag = get_context("loky").Event()
    return _flag


def set_stop_flag(flag: Any) -> None:
    """Use this event as the stop request in a worker."""
    global _flag
    _flag = flag


def init_worker(flag: Any) -> None:
    """Use an event as the stop request in a worker, and ignore signals.

    A terminal sends signals to all processes, but only the parent is to handle them.
    """
    set_stop_flag(flag)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def defer_signals() -> Iterator[None]:
    """Record the first signal, and raise Signalled on exit, after the running jobs have finished."""
    global _received
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    raise_if_signalled()
    with _set_handlers(_request_stop):
        try:
            yield
            if _received:
                raise Signalled(_received)
        finally:
            _received = 0
            if _flag is not None:
                _flag.clear()


@contextmanager
def stop_switch() -> Iterator[Callable[[], None]]:
    """Yield a function that requests a stop as a signal does; the request is reset on exit."""
    global _internal_stop

    def stop() -> None:
        global _internal_stop
        _internal_stop = True
        if _flag is not None:
            _flag.set()

    try:
        yield stop
    finally:
        _internal_stop = False
        if _flag is not None:
            _flag.clear()


@contextmanager
def ignore_signals() -> Iterator[None]:
    """Ignore signals while workers start, which inherit this, so that only this process handles interrupts."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _set_handlers(signal.SIG_IGN):
        yield


@contextmanager
def _set_handlers(handler: Any) -> Iterator[None]:
    """Set a handler within the context for all signals that are not already ignored (as under nohup)."""
    previous = {number: signal.getsignal(number) for number in SIGNALS}
    handled = {
        number: earlier_handler
        for number, earlier_handler in previous.items()
        if earlier_handler not in (signal.SIG_IGN, None)
    }
    for number in handled:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, earlier_handler in handled.items():
            signal.signal(number, earlier_handler)


def _request_stop(number: int, frame: FrameType | None) -> None:
    global _received
    _received = number
    if _flag is not None:
        _flag.set()
    for other in SIGNALS:
        if signal.getsignal(other) is _request_stop:  # signals that were ignored before stay ignored
            signal.signal(other, signal.SIG_DFL)
    say("finishing the running jobs (press again to stop at once)", err=True)


SEM_OPEN_CAUSES = {
    errno.ENOSPC: "is full: free some space",
    errno.EROFS: "is read-only: make it writable",
    errno.EACCES: "is not writable for this user: change its permissions",
    errno.EPERM: "is not writable for this user: change its permissions",
    errno.ENOENT: "is missing: mount it",
    errno.ENOSYS: "is missing: mount it",
}
"""Cause and remedy by error number of ``sem_open``, which creates a file in /dev/shm for each lock."""


class NoSharedMemory(UserError):
    """Worker processes cannot be started because shared memory is not available."""


@contextmanager
def check_shared_memory() -> Iterator[None]:
    """Convert errors of locks in shared memory to NoSharedMemory, which states the cause."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno not in SEM_OPEN_CAUSES:
            raise
        cause = SEM_OPEN_CAUSES[error.errno]
        raise NoSharedMemory(f"worker processes need /dev/shm, which {cause}, or use `--jobs 1`") from error
