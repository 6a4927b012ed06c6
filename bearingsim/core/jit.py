"""Compilation settings of the core.

The rest of the core uses four names:

``jit``      compiles a function (cached on disk).
``inlined``  compiles a function into its callers, for functions called in loops over rollers.
``generic``  declares a function with one implementation per parameter type; the choice is made when the caller is
             compiled, so other implementations cost nothing. Python calls dispatch like ``singledispatch``.
``absent``   declares a type for a missing feature (no drag, no flange), which needs no implementation of a generic
             that defines ``absent``. Any other type without an implementation raises an error that names it.

A product and an addition may be fused; every other operation keeps its IEEE meaning (full ``fastmath`` makes
``isfinite(nan)`` true). The compiler therefore reorders no sum: those over rollers have a fixed order that suits
vectors (``core/sums.py``, ``core/vectors.py``), so results do not depend on the width of the processor's vectors
(but on whether it has fused multiply-add).

The cache folder is named by a digest of the sources of the core and of the packages that extend it, because numba
checks only the file of the function itself and would load stale code after a change in a callee.
"""

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Literal, TypeVar

import numba
from filelock import FileLock
from numba.core import config, event
from numba.core.codegen import get_host_cpu_features
from numba.extending import overload

from bearingsim import cpu_time
from bearingsim.cache_folders import cache_folder
from bearingsim.catalogue import extension_sources
from bearingsim.core import linking, resolving

numba_config: Any = config  # its attributes are created at run time
resolving.cache_operator_signatures()

WIDE_VECTORS, PREFERS_NARROW = "+avx512vbmi2", "prefer-256-bit"
"""LLVM's names of two features: AVX-512 VBMI2, whose processors do not lower their clock for 512-bit vectors, and
the tuning flag that limits Intel processors to 256 bits."""


def with_wide_vectors(features: str) -> str:
    """Return LLVM's ``features`` without the preference for 256-bit vectors, if they include AVX-512 VBMI2.

    Results are bit-for-bit identical. A step takes 10 % less time in `planar`, 20 % less in `rollers` and
    `spatial` (docs/evidence/speed.md).
    """
    return f"{features},-{PREFERS_NARROW}" if WIDE_VECTORS in features.split(",") else features


if numba_config.CPU_FEATURES is None:  # numba reads it before its first compilation; a value of the user is kept
    numba_config.CPU_FEATURES = with_wide_vectors(get_host_cpu_features())

CORE = Path(__file__).parent
OPTIONS: Any = {"error_model": "numpy", "fastmath": {"contract"}, "_nrt": False, **linking.OPTIONS}
"""Options of ``numba.njit`` for every function of the core. With ``_nrt`` off no function allocates, so none
counts references to its array arguments, which would take up to half of a step. Callers allocate the arrays that a
function fills."""
GENERICS: list[Any] = []
"""All functions made by ``generic``, in the order of import."""


def source_digest() -> str:
    """Compute the first 12 hex digits of SHA-256 over numba's version, the core's sources, and those of
    extensions."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in (*sorted(CORE.rglob("*.py")), *extension_sources()):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:12]


def code_folder() -> Path | None:
    """Choose the cache of compiled code; None if no folder is usable.

    If it is not the user's cache, child processes use the same, and one line on stderr gives the reason.
    """
    folder, reason = cache_folder(source_digest())
    if folder is None:
        report(f"compiled code is not cached, so every process compiles again: {reason}")
    elif reason:
        report(f"compiled code is cached in {folder.parent}: {reason}")
        os.environ["BEARINGSIM_CACHE"] = str(folder.parent.parent)
    return folder


def report(message: str) -> None:
    """Print a line to stderr."""
    print(f"bearingsim: {message}", file=sys.stderr)


_CACHE = code_folder()
COMPILATION_WAIT_S = 120.0
"""Longest wait (s) for another process that compiles the same function; then both compile it."""
LOAD_ERRORS = (ImportError, AttributeError)  # a type from a module that is missing or has changed
SAVING_WAIT_S = 10.0
"""Longest wait (s) for another process that saves and may be suspended; then nothing is saved."""


@lru_cache(maxsize=1)
def saving_lock(process: int) -> Any:
    """Return the lock for saving to the cache, one per ``process`` id, because a fork must not inherit a lock."""
    return FileLock(_CACHE / "saving.lock", timeout=SAVING_WAIT_S) if _CACHE else nullcontext()


@contextmanager
def compilation_lock(function: Callable) -> Iterator[None]:
    """Let one process at a time compile a function; the others load its code from the cache."""
    if _CACHE is None or not linking.is_outermost():
        yield
        return
    name = f"{function.__module__}.{function.__qualname__}.compiling.lock"
    lock = FileLock(_CACHE / name, timeout=COMPILATION_WAIT_S)
    with suppress(OSError, NotImplementedError):  # no locks in this folder, or timeout
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def jit(function: Callable, **options: Any) -> Any:
    """Compile ``function`` on first call, or load it from the cache; options: further ones of ``numba.njit``."""
    cache_dir = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = str(_CACHE)  # read while the decorator runs, so other users of numba are unaffected
    try:
        return guard_cache(numba.njit(cache=_CACHE is not None, **(OPTIONS | options))(function))
    finally:
        numba_config.CACHE_DIR = cache_dir


def guard_cache(dispatcher: Any) -> Any:
    """Let one process at a time compile a function and save its code; recompile if the cache cannot be read.

    Compilation and loading are excluded from the job's CPU time.

    numba reads an index, chooses a file name and writes both. Two processes at once could give the code of two
    signatures the same name, and later load the wrong one. Reading the index requires importing every type for
    which the function was ever compiled, and types of extensions may no longer exist.
    """
    if not hasattr(dispatcher, "_cache"):  # plain Python, with NUMBA_DISABLE_JIT
        return dispatcher
    cache = linking.compile_on_call(dispatcher)._cache
    save, load, compile_for = cache.save_overload, cache.load_overload, dispatcher.compile

    def save_locked(signature: Any, code: Any) -> None:
        if linking.is_linked(code):
            return
        with (
            suppress(OSError, NotImplementedError, *LOAD_ERRORS),
            saving_lock(os.getpid()),
        ):  # without locks nothing is saved
            save(signature, code)

    def load_if_readable(signature: Any, context: Any) -> Any:
        if linking.is_callee():  # the cache holds complete code only
            return None
        with suppress(*LOAD_ERRORS):
            return load(signature, context)

    def compile_untimed(signature: Any) -> Any:
        with cpu_time.uncharged(), compilation_lock(dispatcher.py_func):
            return compile_for(signature)

    cache.save_overload, cache.load_overload = save_locked, load_if_readable
    dispatcher.compile = compile_untimed
    return dispatcher


@contextmanager
def compilation_callbacks(on_begin: Callable[[], None], on_end: Callable[[], None]) -> Iterator[None]:
    """Call ``on_begin`` before and ``on_end`` after each compilation that is not loaded from the cache."""
    depth = 0  # callees are compiled during the compilation of their caller

    class Compilation(event.Listener):
        def on_start(self, _: event.Event) -> None:
            nonlocal depth
            depth += 1
            if depth == 1:
                on_begin()

        def on_end(self, _: event.Event) -> None:
            nonlocal depth
            depth -= 1
            if depth == 0:
                on_end()

    with event.install_listener("numba:compile", Compilation()):
        yield


ABSENT: set[type] = set()  # types declared by ``absent``
NO_DEFAULT = object()  # stands for a default that a generic does not have
Parameters = TypeVar("Parameters", bound=type)


def absent(parameters: Parameters) -> Parameters:
    """Declare a type that represents a missing feature."""
    ABSENT.add(parameters)
    return parameters


def make_constant(value: Any, name: str) -> Callable:
    """Make an implementation of ``name`` that returns ``value`` for all arguments."""

    def implementation(*arguments: Any) -> Any:
        return value

    implementation.__qualname__ = f"{name}.constant"  # distinguishes compiled functions
    return implementation


def generic(
    declaration: Callable | None = None,
    *,
    absent: Any = NO_DEFAULT,
    otherwise: Any = NO_DEFAULT,
    inline: Literal["never", "late", "early"] = "never",
) -> Any:
    """Turn ``declaration`` into a function that is dispatched on the type of its first argument.

    The declaration's body is never run; it provides the name, the arguments and the docstring. Implementations are
    added with ``@name.register(ParameterType)`` where ``ParameterType`` is a ``NamedTuple`` class.

    absent, otherwise: a value or an implementation; the first for types declared ``absent``, the second for all
    that have no implementation of their own. Without them such a type raises TypeError; ``name.supports(type)``
    checks for it.

    inline: "late" puts the implementation's code into its caller (see ``inlined``), "early" its source, so that
    indices into the buffer (``core/layout.py``) are compile-time constants and numba omits the wraparound of
    negative indices.
    """
    if declaration is None:
        return partial(generic, absent=absent, otherwise=otherwise, inline=inline)
    name = declaration.__name__
    implementations: dict[type, Callable] = {}

    def lookup(kind: type) -> Any:
        default = absent if kind in ABSENT and absent is not NO_DEFAULT else otherwise
        return implementations.get(kind, default)

    def implementation(kind: type) -> Callable:
        entry = lookup(kind)
        if entry is NO_DEFAULT:
            raise TypeError(f"`{name}` is not registered for {kind.__name__}: @{name}.register({kind.__name__})")
        return entry if callable(entry) else make_constant(entry, name)

    def dispatch(*arguments: Any) -> Any:
        return implementation(type(arguments[0]))(*arguments)

    def choose(parameters: Any, *rest: Any) -> Callable:
        try:
            return implementation(getattr(parameters, "instance_class", type(parameters)))
        except TypeError as error:
            raise numba.TypingError(str(error)) from None

    def register(parameters: type) -> Callable:
        def decorator(implementation: Callable) -> Callable:
            implementations[parameters] = implementation
            return implementation

        return decorator

    for attribute in ("__name__", "__qualname__", "__doc__", "__module__"):
        setattr(dispatch, attribute, getattr(declaration, attribute))
    dispatch.register = register  # type: ignore[attr-defined]
    dispatch.types = implementations.keys()  # type: ignore[attr-defined]
    dispatch.supports = lambda kind: lookup(kind) is not NO_DEFAULT  # type: ignore[attr-defined]
    options, inlining = OPTIONS | {"forceinline": inline == "late"}, "always" if inline == "early" else "never"
    overload(dispatch, jit_options=options, strict=False, inline=inlining)(choose)  # type: ignore[arg-type]
    GENERICS.append(dispatch)
    return dispatch


inlined = partial(jit, forceinline=True)
"""``jit`` with forced inlining into callers, whatever the function's length, because a loop over rollers is
vectorised only without calls, and a call would pass the 60 numbers of a model."""
