"""How much CPU time a job may take: what computes it looks at the clock between its steps."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from time import thread_time
from typing import NamedTuple

__all__ = ["OutOfCpuTime", "at_most", "check"]


class OutOfCpuTime(Exception):
    """A job has taken more than it may: why, and what to do instead. No other method is tried for it."""

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice = reason, advice

    def __reduce__(self) -> tuple:
        return OutOfCpuTime, (self.reason, self.advice)


class _Bound(NamedTuple):
    """CPU time (s) of a thread from when to when."""

    began: float = 0.0
    end: float = inf


NONE = _Bound()
_bound: ContextVar[_Bound] = ContextVar("bound", default=NONE)


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """What is computed within this, in this thread, may take so much CPU time (s)."""
    began = thread_time()
    token = _bound.set(_Bound(began, began + seconds))
    try:
        yield
    finally:
        _bound.reset(token)


def check() -> None:
    """Raises OutOfCpuTime if the job in hand has taken more than it may."""
    began, end = _bound.get()
    if thread_time() > end:
        raise OutOfCpuTime(
            f"it took over {end - began:.4g} s of CPU time, and was stopped (`--max-cpu`)",
            "take a shorter `duration`, or a larger `--max-cpu` with `--retry-failed`",
        )
