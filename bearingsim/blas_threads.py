"""Limit linear algebra to one thread.

Several threads sum in another order, so results of one process and of several would differ in the last digits.
"""

import os

NAMES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Environment variables with the number of threads; the BLAS libraries read them when NumPy is imported."""


def take_one() -> None:
    """Request one thread, unless the user has set the variables. Call it before NumPy is imported."""
    for name in NAMES:
        os.environ.setdefault(name, "1")


def several() -> dict[str, str]:
    """Return the variables that request another number of threads, with their values."""
    return {name: os.environ[name] for name in NAMES if os.environ.get(name, "1") != "1"}
