"""Progress of a run: a bar with the remaining time on a terminal, one rewritten line in a notebook.

Elsewhere, as in a log file, a line every LINE_INTERVAL_S.
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from bearingsim.text.announcer import COMPILATION_REMARK, Announcer
from bearingsim.text.terminal import rewrite_line, say

LINE_INTERVAL_S = 10.0  # s between lines
SPEED_WINDOW_S = 3600.0  # averaging time of the speed in s; units of work may end minutes apart

Report = Callable[[int, int, float], None]
"""Callback with the numbers of newly done and failed jobs, and their estimated CPU time (s)."""


def progress(shown: bool | None, jobs: int, seconds: float) -> AbstractContextManager[Report]:
    """Show the progress of ``jobs`` jobs with ``seconds`` of estimated CPU time; shown: False to show nothing."""
    if shown is False or jobs == 0:
        return nullcontext(lambda done, failed, cost: None)
    if sys.stderr and sys.stderr.isatty():
        return _bar(jobs, seconds)
    if is_notebook():
        return _rewritten_line(jobs, seconds)
    return _lines(jobs, seconds, LINE_INTERVAL_S, lambda text: say(text, err=True))


def is_notebook() -> bool:
    """Check if stderr is the output of a notebook's cell, which returns to the start of a line at `\\r`."""
    return type(sys.stderr).__module__.partition(".")[0] == "ipykernel"


def compiling(patience: Announcer) -> Callable[[int, int, float], None]:
    """Return a callback that announces compilation ``number`` of ``count``, and its estimated duration (s)."""

    def announce(number: int, count: int, seconds: float) -> None:
        patience.begin(f"compiling {number} of {count}, about {duration(seconds)}: {COMPILATION_REMARK}")

    return announce


@contextmanager
def _bar(jobs: int, seconds: float) -> Iterator[Report]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("left"))
    done = failed = 0
    screen = Console(stderr=True)
    with Progress(*columns, TimeRemainingColumn(), console=screen, speed_estimate_period=SPEED_WINDOW_S) as bar:
        task = bar.add_task(_counts(0, 0, jobs), total=seconds)

        def report(new_done: int, new_failed: int, cost: float) -> None:
            nonlocal done, failed
            done, failed = done + new_done, failed + new_failed
            bar.update(task, advance=cost, description=_counts(done, failed, jobs))

        yield report


@contextmanager
def _rewritten_line(jobs: int, seconds: float) -> Iterator[Report]:
    with _lines(jobs, seconds, 0.0, rewrite_line) as report:
        try:
            yield report
        finally:
            say("", err=True)


@contextmanager
def _lines(jobs: int, seconds: float, interval: float, write: Callable[[str], None]) -> Iterator[Report]:
    started = last_line = time.monotonic()
    done = failed = 0
    computed = 0.0

    def report(new_done: int, new_failed: int, cost: float) -> None:
        nonlocal done, failed, computed, last_line
        done, failed, computed = done + new_done, failed + new_failed, computed + cost
        now = time.monotonic()
        if now - last_line >= interval:
            remaining = (now - started) * max(seconds - computed, 0.0) / max(computed, 1e-9)
            remaining_text = f", about {duration(remaining)} left" if done + failed < jobs else ""
            write(f"{_counts(done, failed, jobs)}{remaining_text}")
            last_line = now

    yield report


def _counts(done: int, failed: int, jobs: int) -> str:
    return f"{done + failed}/{jobs} jobs" + (f", {failed} failed" if failed else "")


def duration(seconds: float) -> str:
    """Format a time (s) as `0.4 s`, `12 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds < 99.5:
        return f"{seconds:.2g} s"
    minutes, remainder = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {remainder} s"
