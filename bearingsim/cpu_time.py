"""The CPU clock of a job: how much CPU time a job may take, and how much of it is left.

Everything that computes a job reads this clock: Python between its steps (``check``), and compiled loops that may
run long (``bounded``, ``core/clock.py``). Compiling is not charged to the job.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from time import thread_time
from typing import NamedTuple, TypeVar

__all__ = ["OutOfCpuTime", "at_most", "bounded", "check", "end", "now", "uncharged"]

T = TypeVar("T")


class OutOfCpuTime(Exception):
    """A job has taken more than it may: why, and what to do instead. No other method is tried for it."""

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice = reason, advice

    def __reduce__(self) -> tuple:
        return OutOfCpuTime, (self.reason, self.advice)


class _Bound(NamedTuple):
    """CPU time (s) that a job may take in all, and the reading of the clock at which it ends."""

    seconds: float = inf
    end: float = inf


UNBOUNDED = _Bound()
LEAST_END = 1e-9  # s
_bound: ContextVar[_Bound] = ContextVar("bound", default=UNBOUNDED)
_uncharged: ContextVar[float] = ContextVar("uncharged", default=0.0)


def now() -> float:
    """Read the clock: CPU time (s) of this thread, without what is not charged."""
    return thread_time() - _uncharged.get()


def end() -> float:
    """Return this thread's CPU time (s), as of ``thread_time``, at which the job ends; inf without a bound.

    Always above 0, which stands for no end in a buffer.
    """
    return max(_bound.get().end + _uncharged.get(), LEAST_END)


@contextmanager
def at_most(seconds: float, spent: float = 0.0) -> Iterator[None]:
    """Bound the CPU time (s) of what this thread computes within; ``spent``: how much is gone already."""
    token = _bound.set(_Bound(seconds, now() + seconds - spent))
    try:
        yield
    finally:
        _bound.reset(token)


@contextmanager
def uncharged() -> Iterator[None]:
    """Stop the clock: what this thread does within, such as compiling, is not charged to the job."""
    began, before = thread_time(), _uncharged.get()
    try:
        yield
    finally:
        _uncharged.set(before + thread_time() - began)


def check() -> None:
    """Raise OutOfCpuTime if the job has taken more CPU time than it may."""
    seconds, last = _bound.get()
    if now() > last:
        raise OutOfCpuTime(
            f"it took over {seconds:.4g} s of CPU time, and was stopped (`--max-cpu`)",
            "take a shorter `duration`, or a larger `--max-cpu` with `--retry-failed`",
        )


def bounded(call: Callable[[float], T]) -> T:
    """Call a compiled function that ends at a CPU time of this thread (s), which it is given; return its result.

    If it was compiled by the call, it is called once more: its time may have gone into compiling. Raises
    OutOfCpuTime if the job's is over.
    """
    while True:
        last = end()
        result = call(last)
        check()
        if end() == last:
            return result
