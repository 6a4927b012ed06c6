"""Compilation without machine code for functions that only compiled callers use.

numba makes every function ready to be called from Python: it wraps it, and generates machine code of it and of all
that it calls, again at each level. But most functions of the core are called by others only, into which their
optimised code is linked. So a function is made ready when Python calls it, and not when a caller is compiled.
Results are the same, bit for bit.

Gain: 11.8 s in place of 20.0 s of CPU time for the first run of `rollers` in an empty cache (x86-64 server, 2
cores; ``python -m benchmarks.compiler_gains``).

And signals wait while LLVM makes machine code (``signals_held``).

This reaches into numba's compiler, more than it promises to keep. If a part is not there, ``OPTIONS`` is empty and
``ready_when_called`` does nothing: functions are then compiled as numba does it.
"""

import gc
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

try:
    from numba.core import compiler, sigutils
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler_lock import global_compiler_lock

    FOUND = True
except ImportError:  # another numba
    FOUND = False


SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that ask a process to end."""


@contextmanager
def signals_held() -> Iterator[None]:
    """Run the handlers of ``SIGNALS`` at the end.

    LLVM calls back into Python as it makes machine code. A signal that came meanwhile is handled in that callback,
    whose exceptions are dropped: a Ctrl-C was lost, or the machine code.
    """
    if threading.current_thread() is not threading.main_thread():  # which alone handles signals
        yield
        return
    arrived: list[int] = []
    handlers = {number: signal.getsignal(number) for number in SIGNALS}
    held = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in held:
        signal.signal(number, lambda number, frame: arrived.append(number))
    try:
        yield
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
        for number in arrived:
            signal.raise_signal(number)


OPTIONS: dict[str, Any] = {}
"""Of every function of the core, for ``numba.njit``."""

if FOUND:
    JITCodeLibrary._finalize_specific = signals_held()(JITCodeLibrary._finalize_specific)  # type: ignore[method-assign]

    class LinkedLibrary(JITCodeLibrary):
        """Optimised code for linking into callers, without machine code of its own."""

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

    class Compiler(compiler.Compiler):
        """Compiler that gives machine code to functions called from Python only, and a ``LinkedLibrary`` to
        their callees."""

        depth = 0  # of compilations in each other; numba compiles in one thread at a time

        def compile_extra(self, function: Any) -> Any:
            """Compile ``function``."""
            linked = Compiler.depth > 0
            if linked:
                flags = self.state.flags
                flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
                self.state.library = LinkedLibrary(self.state.targetctx.codegen(), function.__qualname__)
            Compiler.depth += 1
            try:
                compiled = super().compile_extra(function)
            finally:
                Compiler.depth -= 1
            return self._known_to_callers(compiled) if linked else compiled

        def _known_to_callers(self, compiled: Any) -> Any:
            """Enter code into the table of its callers, who look it up by its entry point: any builtin that
            equals no other."""
            entry = object().__reduce_ex__
            self.state.targetctx.insert_user_function(entry, compiled.fndesc, [compiled.library])
            return compiled._replace(entry_point=entry)

    OPTIONS = {"pipeline_class": Compiler}


def is_outermost() -> bool:
    """Check if a function compiled now is no callee of one that is being compiled; False if that is unknown."""
    return FOUND and Compiler.depth == 0


@contextmanager
def rare_collections() -> Iterator[None]:
    """Raise the thresholds of the garbage collector while compiling: collection takes 7 % of the time, with
    little garbage."""
    before = gc.get_threshold()
    gc.set_threshold(50_000, 20, 20)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def is_linked(compiled: Any) -> bool:
    """Check if a compiled function has no machine code of its own."""
    return FOUND and isinstance(compiled.library, LinkedLibrary)


def ready_when_called(dispatcher: Any) -> Any:
    """Compile a function completely once Python calls it, if so far it was compiled for callers only."""
    if not FOUND:
        return dispatcher
    add_overload, compile_for = dispatcher.add_overload, dispatcher.compile

    def add(compiled: Any) -> None:
        if is_linked(compiled):  # not to where Python looks
            dispatcher.overloads[tuple(compiled.signature.args)] = compiled
        else:
            add_overload(compiled)

    def compile_whole(signature: Any) -> Any:
        with global_compiler_lock:
            arguments, _ = sigutils.normalize_signature(signature)
            stored = dispatcher.overloads.get(tuple(arguments))
            if stored is not None and is_linked(stored) and Compiler.depth == 0:
                del dispatcher.overloads[tuple(arguments)]
            with rare_collections():
                return compile_for(signature)

    dispatcher.add_overload, dispatcher.compile = add, compile_whole
    return dispatcher
