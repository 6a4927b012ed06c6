"""Thresholds of the garbage collector for commands and for compilation, which need few collections."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

COMMAND_THRESHOLDS, COMPILATION_THRESHOLDS = (1_000_000, 20, 20), (50_000, 20, 20)
"""Arguments of ``gc.set_threshold``: new objects before a collection of generation 0, and collections of
generations 0 and 1 before one of the next generation.

Imported modules, compiled code and tables contain little garbage; collections take 7 % of the compilation time
and 10 % of the run time of a command that computes nothing. With the thresholds of commands, compilation needs
80 MB more memory. A job leaves six objects that only the collector frees.
"""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Raise the thresholds to those of compilation within the context, unless they are higher."""
    thresholds = gc.get_threshold()
    gc.set_threshold(*max(COMPILATION_THRESHOLDS, thresholds))
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
