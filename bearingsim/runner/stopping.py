"""Ending early: at a first Ctrl-C, SIGTERM or SIGHUP the jobs in hand end and are sealed; a second is at once.

So they do where the run itself has seen enough.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from bearingsim.errors import Signalled
from bearingsim.runner.shared_memory import in_shared_memory
from bearingsim.text.terminal import say

__all__ = ["asked", "ending", "flag_for_workers", "heed", "heeding", "ignoring", "take_flag"]

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_received = 0  # number of the signal, in the process that got it
_flag: Any = None  # the same for its workers
_enough = False  # whether this process has seen enough, of itself


def asked() -> bool:
    """Whether this process, or the one that it works for, has been asked to stop."""
    return _received != 0 or _enough or (_flag is not None and bool(_flag.is_set()))


def flag_for_workers() -> Any:
    """What workers learn it by: one for the life of this process, since another would need other workers.

    Raises NoSharedMemory.
    """
    global _flag
    if _flag is None:
        from joblib.externals.loky.backend.context import get_context

        with in_shared_memory():
            _flag = get_context("loky").Event()
    return _flag


def heed(flag: Any) -> None:
    """In a worker: from now on the flag tells it to stop."""
    global _flag
    _flag = flag


def take_flag(flag: Any) -> None:
    """In a worker: heed the flag, and no signal; these often go to all processes at once."""
    heed(flag)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def heeding() -> Iterator[None]:
    """Note the first signal, and raise Signalled at the end, when all that was in hand is done."""
    global _received
    if threading.current_thread() is not threading.main_thread():
        yield
        return
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
    """Gives what ends a run as a signal does, without one: until this is left nothing more is begun."""
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
    """Ignore signals while workers start: they inherit it, and leave interrupting to this process from birth."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _handling(signal.SIG_IGN):
        yield


@contextmanager
def _handling(handler: Any) -> Iterator[None]:
    """Another handler of what is not ignored already, as it is under nohup."""
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
    for each in SIGNALS:
        signal.signal(each, signal.SIG_DFL)
    say("stopping when the jobs in hand are done (once more: at once)", err=True)
