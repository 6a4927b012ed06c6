"""Drawn figure and the words of its file name."""

from collections.abc import Sequence
from hashlib import sha256
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from bearingsim.study import Figure

MAX_NAMED = 4  # largest number of jobs in the name of a file
ALL = "all"
"""Word for all selected jobs instead of their ids."""


class Sheet(NamedTuple):
    """Figure and the words of its file name."""

    words: list[str]
    canvas: "Canvas"


def file_words(figure: "Figure", jobs: Sequence[str]) -> list[str]:
    """List the words of the file name of a figure of signals: its kind, channels and jobs.

    Of many jobs, only the first are named; a digest of the others distinguishes the name from those of other jobs.
    """
    others = sha256(" ".join(jobs[MAX_NAMED:]).encode()).hexdigest()[:4]
    more = [f"and {len(jobs) - MAX_NAMED} more {others}"] if len(jobs) > MAX_NAMED else []
    return [figure.kind, *figure.y, *(job[:8] for job in jobs[:MAX_NAMED]), *more]
