"""Limit of one thread for linear algebra.

The order of summation depends on the number of threads, so results would not be reproducible to the last digit.
"""

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Environment variables with the number of threads; the BLAS libraries read them when NumPy is imported."""


def limit_to_one() -> None:
    """Request one thread, unless the user has set the variables; call before NumPy is imported."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


def changed_variables() -> dict[str, str]:
    """Return the variables that are set to a value other than 1, with their values."""
    return {name: os.environ[name] for name in VARIABLES if os.environ.get(name, "1") != "1"}
