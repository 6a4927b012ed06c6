"""Interruption of a command by a signal, except while jobs are run (``runner.stopping``).

An exception raised by a signal handler is lost if it cannot propagate, as in a destructor or in Rust code that
pydantic calls at import. The signal is therefore recorded, so that the exception can be raised again before a long
wait.
"""

from types import FrameType

from bearingsim.errors import Signalled

_received = 0  # number of the signal received by this process, or 0


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle SIGINT, SIGTERM and SIGHUP by raising Signalled."""
    global _received
    _received = number
    raise Signalled(number)


def raise_if_signalled() -> None:
    """Raise Signalled again if a signal was received but its exception was lost."""
    if _received:
        raise Signalled(_received)
