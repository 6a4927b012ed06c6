"""CPU clock of a job, and the limit of its CPU time.

Python code checks the clock between time steps (``check``); long compiled loops check it themselves (``bounded``,
``core/clock.py``). Compilation is not charged to the job.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from time import thread_time
from typing import NamedTuple, TypeVar

Result = TypeVar("Result")


class OutOfCpuTime(Exception):
    """A job has reached its limit of CPU time, so no other method is tried; advice: the remedy."""

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice = reason, advice

    def __reduce__(self) -> tuple:
        return OutOfCpuTime, (self.reason, self.advice)


class _Bound(NamedTuple):
    """Limit of a job's CPU time (s), and the reading of the clock (s) at which it is reached."""

    seconds: float = inf
    end: float = inf


NO_LIMIT = _Bound()
MIN_END = 1e-9  # s; small, but not 0, which means no limit in compiled code
_bound: ContextVar[_Bound] = ContextVar("bound", default=NO_LIMIT)
_uncharged: ContextVar[float] = ContextVar("uncharged", default=0.0)


def now() -> float:
    """Return the CPU time (s) of this thread, minus the time not charged to the job."""
    return thread_time() - _uncharged.get()


def end() -> float:
    """Return the CPU time of this thread (s, by ``thread_time``) at which the job must end; inf without a limit.

    The value is never 0, which means no limit in compiled code.
    """
    return max(_bound.get().end + _uncharged.get(), MIN_END)


@contextmanager
def at_most(seconds: float, spent: float = 0.0) -> Iterator[None]:
    """Limit the CPU time (s) of this thread within the context; spent: part of it already used (s)."""
    token = _bound.set(_Bound(seconds, now() + seconds - spent))
    try:
        yield
    finally:
        _bound.reset(token)


@contextmanager
def uncharged() -> Iterator[None]:
    """Stop the clock within the context, for example during compilation."""
    start, previous = thread_time(), _uncharged.get()
    try:
        yield
    finally:
        _uncharged.set(previous + thread_time() - start)


def check() -> None:
    """Raise OutOfCpuTime if the job has reached its limit of CPU time."""
    seconds, limit = _bound.get()
    if now() > limit:
        raise OutOfCpuTime(
            f"the job exceeded its limit of {seconds:.4g} s of CPU time (`--max-cpu`)",
            "use a shorter `duration`, or a larger `--max-cpu` with `--retry-failed`",
        )


def bounded(call: Callable[[float], Result]) -> Result:
    """Call a compiled function with the CPU time of this thread (s) at which it must end; return its result.

    If the call compiled the function, it is repeated, because compilation may have used up the time. Raises
    OutOfCpuTime if the job has reached its limit.
    """
    while True:
        limit = end()
        result = call(limit)
        check()
        if end() == limit:
            return result
