"""Interruption of a command by a signal, outside the work of a run (``runner.stopping``).

An exception raised by a handler is lost where it cannot propagate, as in a destructor or in the Rust code that
pydantic calls at import. The signal is recorded, too, so that a long wait can raise it again.
"""

from types import FrameType

from bearingsim.errors import Signalled

_received = 0  # number of the signal received by this process, 0 without one


def interrupt(number: int, frame: FrameType | None) -> None:
    """Raise Signalled: the handler of SIGINT, SIGTERM and SIGHUP."""
    global _received
    _received = number
    raise Signalled(number)


def raise_lost() -> None:
    """Raise Signalled again if a signal was received, and its exception was lost."""
    if _received:
        raise Signalled(_received)
