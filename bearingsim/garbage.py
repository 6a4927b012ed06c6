"""Thresholds of the garbage collector: rare collections in commands, and while code is compiled."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

COMMAND, COMPILING = (1_000_000, 20, 20), (50_000, 20, 20)
"""Objects, and younger collections, between two collections of the collector's three generations.

Imported modules, compiled code and tables contain little garbage; searching them for it takes 7 % of compiling and
10 % of a command that computes nothing. With the thresholds of commands, compiling takes 80 MB more memory. A job
leaves six objects that only the collector frees.
"""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Raise the thresholds to those of compiling, unless they are higher."""
    thresholds = gc.get_threshold()
    gc.set_threshold(*max(COMPILING, thresholds))
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
