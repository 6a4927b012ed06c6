"""How many threads linear algebra takes.

One: with more, sums are rounded otherwise, and a run by one process would differ in its last digits from one by
several.
"""

import os

__all__ = ["NAMES", "several", "take_one"]

NAMES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Variables of the environment, read as NumPy is imported."""


def take_one() -> None:
    """One thread, before NumPy is imported; what the user has set stays."""
    for name in NAMES:
        os.environ.setdefault(name, "1")


def several() -> dict[str, str]:
    """The variables that say other than one, with what they say."""
    return {name: os.environ[name] for name in NAMES if os.environ.get(name, "1") != "1"}
