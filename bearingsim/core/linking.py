"""Compilation of functions used only by compiled callers, without machine code of their own.

numba prepares every function for calls from Python: it generates a wrapper and machine code for the function and
all its callees, again at each level. Most functions of the core are called only by others, into which their
code is linked. Here the wrapper and machine code are generated only when Python calls a function, not
when a caller is compiled. Results are bit-for-bit identical.

Gain: 11.8 s instead of 20.0 s of CPU time for the first run of `rollers` in an empty cache (x86-64 server, 2
cores; ``python -m benchmarks.compiler_gains``).

Signals are deferred while LLVM generates machine code (``defer_signals``).

This relies on internals of numba's compiler. If one is missing, ``OPTIONS`` is empty and ``compile_on_call``
does nothing, so functions are compiled in numba's standard way.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from bearingsim.garbage import rare_collections

try:
    from numba.core import compiler, sigutils
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler_lock import global_compiler_lock

    HAS_INTERNALS = True
except ImportError:  # another version of numba
    HAS_INTERNALS = False


SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that request a process to end."""


@contextmanager
def defer_signals() -> Iterator[None]:
    """Defer the handlers of ``SIGNALS`` to the end of the block.

    LLVM calls back into Python while it generates machine code. A signal received meanwhile would be handled in
    this callback, whose exceptions are ignored, so that a Ctrl-C or the machine code would be lost.
    """
    if threading.current_thread() is not threading.main_thread():  # only the main thread handles signals
        yield
        return
    received: list[int] = []
    handlers = {number: signal.getsignal(number) for number in SIGNALS}
    callable_handlers = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in callable_handlers:
        signal.signal(number, lambda number, frame: received.append(number))
    try:
        yield
    finally:
        for number, handler in callable_handlers.items():
            signal.signal(number, handler)
        for number in received:
            signal.raise_signal(number)


MAX_OPTIMISED = 1000
"""Number of instructions of a callee with its own callees, from which it is not optimised before it is linked.
With 500 a step of `planar` takes 14 % longer, with 0 one of `ring` with `rk4` 17 % (docs/evidence/speed.md)."""


def is_shorter_than(count: int, module: Any) -> bool:
    """Check if an LLVM module has fewer than ``count`` instructions, each a line of its text indented by two
    spaces; the few lines of a list of cases count as instructions."""
    return str(module).count("\n  ") < count


OPTIONS: dict[str, Any] = {}
"""Options of ``numba.njit`` for every function of the core."""

if HAS_INTERNALS:
    defer_while_finalizing = defer_signals()(JITCodeLibrary._finalize_specific)
    JITCodeLibrary._finalize_specific = defer_while_finalizing  # type: ignore[method-assign]

    class LinkedLibrary(JITCodeLibrary):
        """Code for linking into callers, without machine code of its own.

        Only short code is optimised before it is linked, so that LLVM vectorises the loops of a function before it
        inlines the function. Long code is optimised once, in the function that Python calls, which saves a quarter
        of the compile time of implicit methods.
        """

        def _optimize_final_module(self) -> None:
            if is_shorter_than(MAX_OPTIMISED, self._final_module):
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

    class Compiler(compiler.Compiler):
        """Compiler that generates machine code only for functions called from Python, and a ``LinkedLibrary`` for
        callees."""

        depth = 0  # depth of nested compilations; numba compiles in one thread at a time

        def compile_extra(self, function: Any) -> Any:
            """Compile ``function``."""
            is_callee = Compiler.depth > 0
            if is_callee:
                flags = self.state.flags
                flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
                self.state.library = LinkedLibrary(self.state.targetctx.codegen(), function.__qualname__)
            Compiler.depth += 1
            try:
                result = super().compile_extra(function)
            finally:
                Compiler.depth -= 1
            return self._register_for_callers(result) if is_callee else result

        def _register_for_callers(self, result: Any) -> Any:
            """Register code for its callers under an entry point, here a new builtin that is unequal to all
            others."""
            entry = object().__reduce_ex__
            self.state.targetctx.insert_user_function(entry, result.fndesc, [result.library])
            return result._replace(entry_point=entry)

    OPTIONS = {"pipeline_class": Compiler}


def is_outermost() -> bool:
    """Check that a function to be compiled is not a callee of one being compiled; False if unknown."""
    return HAS_INTERNALS and Compiler.depth == 0


def is_linked(result: Any) -> bool:
    """Check if a compiled function has no machine code of its own."""
    return HAS_INTERNALS and isinstance(result.library, LinkedLibrary)


def is_callee() -> bool:
    """Check that a function to be compiled is a callee of one being compiled; False if unknown."""
    return HAS_INTERNALS and Compiler.depth > 0


def compile_on_call(dispatcher: Any) -> Any:
    """Compile a function completely when Python calls it, and for linking when a caller is compiled.

    A caller never links the complete code of a function that Python called before. That code is optimised in
    another way and may fuse other products and additions, so results would depend on which functions were
    compiled, or loaded from the cache, before.
    """
    if not HAS_INTERNALS:
        return dispatcher
    add_overload, compile_for = dispatcher.add_overload, dispatcher.compile

    def add(result: Any) -> None:
        if is_linked(result):  # not visible to calls from Python
            dispatcher.overloads[tuple(result.signature.args)] = result
        else:
            add_overload(result)

    def compile_fully(signature: Any) -> Any:
        with global_compiler_lock:
            arguments, _ = sigutils.normalize_signature(signature)
            existing = dispatcher.overloads.get(tuple(arguments))
            if existing is not None and is_linked(existing) != is_callee():
                # calls from Python keep the code already compiled for them
                del dispatcher.overloads[tuple(arguments)]
            with rare_collections():
                return compile_for(signature)

    dispatcher.add_overload, dispatcher.compile = add, compile_fully
    return dispatcher
