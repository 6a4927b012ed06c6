"""Functions compiled for a caller have no machine code of their own until Python calls them."""

import signal
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
import pytest
from llvmlite.binding import parse_assembly  # type: ignore[import-untyped]
from numba import typeof
from numba.core.codegen import JitEngine

from bearingsim.core.jit import generic, jit
from bearingsim.core.linking import HAS_INTERNALS, Compiler, defer_signals, is_linked, is_shorter_than
from bearingsim.core.parameters import lanes
from tests.scenes.oscillators import UNIT


class Scaled(NamedTuple):
    """Parameter type of this test."""

    by: float


@generic
def scaled(parameters: Any, x: float) -> float:
    """Scale a number."""


@scaled.register(Scaled)
def _scaled(parameters, x):
    return parameters.by * x


def functions() -> tuple[Any, Any]:
    """Return a callee and its caller, neither compiled nor cached."""

    @jit
    def inner(parameters, x):
        return scaled(parameters, x) + 1.0

    @jit
    def outer(parameters, x):
        total = 0.0
        for value in x:
            total += inner(parameters, value)
        return total

    for value in (inner, outer):
        value._cache.load_overload = lambda signature, context: None
    return inner, outer


def code(function: Any) -> Any:
    """Return the code of a function with one compiled signature."""
    (result,) = function.overloads.values()
    return result


def test_locked_numba_has_the_required_internals() -> None:
    """With another numba linking is off; ``linking.py`` must then be adapted."""
    assert HAS_INTERNALS


def test_callee_has_no_machine_code() -> None:
    inner, outer = functions()
    assert outer(Scaled(2.0), np.array([1.0, 2.0])) == 8.0
    assert not is_linked(code(outer))
    assert is_linked(code(inner))


def test_linked_function_is_compiled_when_python_calls_it() -> None:
    inner, outer = functions()
    outer(Scaled(2.0), np.array([1.0]))
    assert [inner(Scaled(3.0), x) for x in (1.0, 2.0)] == [4.0, 7.0]
    assert not is_linked(code(inner))
    assert outer(Scaled(2.0), np.array([3.0])) == 7.0
    _, again = functions()
    assert again(Scaled(2.0), np.array([3.0])) == 7.0


def test_a_caller_does_not_link_the_code_that_python_called() -> None:
    """Its code would otherwise depend on what was compiled before."""
    inner, outer = functions()
    assert inner(Scaled(3.0), 1.0) == 4.0
    assert not is_linked(code(inner))
    assert outer(Scaled(3.0), np.array([1.0, 1.0])) == 8.0
    assert is_linked(code(inner))
    assert inner(Scaled(3.0), 2.0) == 7.0
    assert is_linked(code(inner))  # Python still calls the complete code


def test_callees_are_not_loaded_from_the_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    lanes(UNIT)  # compiled and saved
    signature = (typeof(UNIT),)
    assert lanes._cache.load_overload(signature, lanes.targetctx) is not None
    monkeypatch.setattr(Compiler, "depth", 1)
    assert lanes._cache.load_overload(signature, lanes.targetctx) is None


def test_a_caller_is_compiled_for_other_types_too() -> None:
    inner, outer = functions()
    assert outer(Scaled(2.0), np.array([1.0])) == 3.0
    assert outer(Scaled(2.0), np.array([1, 2])) == 8.0
    assert inner(Scaled(2.0), 2) == 5.0


def test_threads_may_compile_at_once() -> None:
    """One thread calls a function that another thread is compiling for its caller."""
    inner, outer = functions()
    with ThreadPoolExecutor(2) as threads:
        futures = [threads.submit(outer, Scaled(2.0), np.array([1.0])), threads.submit(inner, Scaled(2.0), 1.0)]
        assert [future.result() for future in futures] == [3.0, 3.0]


def test_interrupt_is_deferred_until_code_generation_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt handled during a callback of LLVM would be lost."""
    finalize, finalized = JitEngine.finalize_object, []

    def interrupt(engine: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        finalize(engine)
        finalized.append(engine)

    monkeypatch.setattr(JitEngine, "finalize_object", interrupt)
    _, outer = functions()
    with pytest.raises(KeyboardInterrupt):
        outer(Scaled(3.0), np.array([1.0]))
    assert finalized
    monkeypatch.undo()
    assert outer(Scaled(3.0), np.array([1.0, 2.0])) == 11.0


def test_ignored_signals_stay_ignored() -> None:
    """Threads other than the main thread defer no signals."""
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


def test_instructions_of_all_functions_of_a_module_count() -> None:
    function = "define i64 @{}(i64 %x) {{ %y = add i64 %x, 1\n ret i64 %y }}\n"
    module = parse_assembly("".join(map(function.format, ("f", "g"))))
    assert [is_shorter_than(count, module) for count in (4, 5)] == [False, True]
