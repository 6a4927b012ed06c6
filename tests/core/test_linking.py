"""What is compiled for a caller has no machine code of its own, until Python calls it."""

import signal
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core.codegen import JitEngine

from bearingsim.core.jit import generic, jit
from bearingsim.core.linking import HAS_INTERNALS, defer_signals, is_linked


class Scaled(NamedTuple):
    """A parameter type of this test's."""

    by: float


@generic
def scaled(parameters: Any, x: float) -> float:
    """Something that has an implementation."""


@scaled.register(Scaled)
def _scaled(parameters, x):
    return parameters.by * x


def functions() -> tuple[Any, Any]:
    """One that is called by the other, both not compiled yet, nor loaded from the cache."""

    @jit
    def inner(parameters, x):
        return scaled(parameters, x) + 1.0

    @jit
    def outer(parameters, x):
        total = 0.0
        for one in x:
            total += inner(parameters, one)
        return total

    for one in (inner, outer):
        one._cache.load_overload = lambda signature, context: None
    return inner, outer


def code(function: Any) -> Any:
    """What the function has been compiled to, of one signature."""
    (found,) = function.overloads.values()
    return found


def test_the_numba_of_the_lock_file_is_made_as_is_expected_of_it() -> None:
    """With another one nothing is linked only; then ``linking.py`` is to be looked at."""
    assert HAS_INTERNALS


def test_only_what_python_calls_is_made_ready() -> None:
    inner, outer = functions()
    assert outer(Scaled(2.0), np.array([1.0, 2.0])) == 8.0
    assert not is_linked(code(outer))
    assert is_linked(code(inner))


def test_a_linked_function_is_made_ready_once_python_calls_it() -> None:
    inner, outer = functions()
    outer(Scaled(2.0), np.array([1.0]))
    assert [inner(Scaled(3.0), x) for x in (1.0, 2.0)] == [4.0, 7.0]
    assert not is_linked(code(inner))
    assert outer(Scaled(2.0), np.array([3.0])) == 7.0
    _, again = functions()
    assert again(Scaled(2.0), np.array([3.0])) == 7.0


def test_what_is_ready_is_linked_as_it_is() -> None:
    inner, outer = functions()
    assert inner(Scaled(3.0), 1.0) == 4.0
    assert outer(Scaled(3.0), np.array([1.0, 1.0])) == 8.0
    assert not is_linked(code(inner))


def test_a_caller_is_compiled_for_other_types_too() -> None:
    inner, outer = functions()
    assert outer(Scaled(2.0), np.array([1.0])) == 3.0
    assert outer(Scaled(2.0), np.array([1, 2])) == 8.0
    assert inner(Scaled(2.0), 2) == 5.0


def test_threads_may_compile_at_once() -> None:
    """One calls what another is compiling for its own caller."""
    inner, outer = functions()
    with ThreadPoolExecutor(2) as threads:
        asked = [
            threads.submit(outer, Scaled(2.0), np.array([1.0])),
            threads.submit(inner, Scaled(2.0), 1.0),
        ]
        assert [one.result() for one in asked] == [3.0, 3.0]


def test_an_interrupt_waits_until_there_is_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be handled while LLVM calls back, and be lost there."""
    finalize, finalized = JitEngine.finalize_object, []

    def interrupted(engine: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        finalize(engine)
        finalized.append(engine)

    monkeypatch.setattr(JitEngine, "finalize_object", interrupted)
    _, outer = functions()
    with pytest.raises(KeyboardInterrupt):
        outer(Scaled(3.0), np.array([1.0]))
    assert finalized
    monkeypatch.undo()
    assert outer(Scaled(3.0), np.array([1.0, 2.0])) == 11.0


def test_signals_that_are_ignored_or_unhandled_stay_so() -> None:
    """And in another thread than the main one nothing is held."""
    handlers = []
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with defer_signals():
            handlers.append(signal.getsignal(signal.SIGTERM))
            signal.raise_signal(signal.SIGTERM)
        handlers.append(signal.getsignal(signal.SIGTERM))
    finally:
        signal.signal(signal.SIGTERM, before)
    assert handlers == [signal.SIG_IGN, signal.SIG_IGN]
    with ThreadPoolExecutor() as threads:
        threads.submit(defer_signals().__enter__).result()
