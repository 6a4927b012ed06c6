"""Rare garbage collections, while modules are imported, code is compiled or results are read."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

THRESHOLDS = 50_000, 20, 20
"""Objects, and younger collections, between two collections of the collector's three generations."""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Raise the thresholds of the garbage collector.

    Imported modules, compiled code and tables contain little garbage; searching them for it takes 7 % of compiling
    and 15 % of a command that reads results. Not for jobs, whose arrays are to be freed at once.
    """
    thresholds = gc.get_threshold()
    gc.set_threshold(*THRESHOLDS)
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
