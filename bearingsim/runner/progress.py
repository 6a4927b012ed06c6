"""Progress of a run: a bar with the remaining time on a terminal, one rewritten line in a notebook.

On any other output, such as a log file, one line is printed every ``LINE_INTERVAL_S`` seconds, and one at the end.
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from bearingsim.text.announcer import COMPILATION_REMARK, Announcer
from bearingsim.text.terminal import rewrite_line, say

LINE_INTERVAL_S = 10.0  # s; interval between lines
AVERAGING_S = 3600.0  # s; averaging time of the speed, long because jobs may finish minutes apart

Report = Callable[[int, int, float], None]
"""Callback with the numbers of newly done and failed jobs, and their estimated CPU time (s)."""


def progress(shown: bool | None, jobs: int, seconds: float) -> AbstractContextManager[Report]:
    """Show the progress of a number of jobs; return a context whose value is called on each result.

    seconds: estimated CPU time (s) of all jobs; shown: False disables the display, None and True are equivalent.
    """
    if shown is False or jobs == 0:
        return nullcontext(lambda done, failed, cost: None)
    if sys.stderr and sys.stderr.isatty():
        return _bar(jobs, seconds)
    if is_notebook():
        return _rewritten_line(jobs, seconds)
    return _lines(jobs, seconds, LINE_INTERVAL_S, lambda text: say(text, err=True))


def is_notebook() -> bool:
    """Check if stderr is the output of a notebook cell, where `\\r` returns to the start of the line."""
    return type(sys.stderr).__module__.partition(".")[0] == "ipykernel"


def compilation_callback(announcements: Announcer) -> Callable[[int, int, float], None]:
    """Return a callback (number, count, seconds) that announces a compilation and its estimated duration (s)."""

    def announce(number: int, count: int, seconds: float) -> None:
        announcements.begin(
            f"compiling the solver, {number} of {count} (about {duration(seconds)}; {COMPILATION_REMARK})"
        )

    return announce


@contextmanager
def _bar(jobs: int, seconds: float) -> Iterator[Report]:
    """Show a bar with the elapsed and the remaining time."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("elapsed"),
        TimeElapsedColumn(),
        TextColumn("remaining"),
        TimeRemainingColumn(),
    )
    done = failed = 0
    console = Console(stderr=True)
    with Progress(*columns, console=console, speed_estimate_period=AVERAGING_S) as bar:
        task = bar.add_task(_counts(0, 0, jobs), total=seconds)

        def report(new_done: int, new_failed: int, cost: float) -> None:
            nonlocal done, failed
            done, failed = done + new_done, failed + new_failed
            bar.update(task, advance=cost, description=_counts(done, failed, jobs))

        yield report


@contextmanager
def _rewritten_line(jobs: int, seconds: float) -> Iterator[Report]:
    """Show one line that each report rewrites."""
    with _lines(jobs, seconds, 0.0, rewrite_line) as report:
        try:
            yield report
        finally:
            say("", err=True)


@contextmanager
def _lines(jobs: int, seconds: float, interval: float, write: Callable[[str], None]) -> Iterator[Report]:
    """Write a line on a report if ``interval`` (s) has passed since the last one, and on the last report.

    The remaining time is left out once the estimated CPU time is used up.
    """
    start_time = last_line = time.monotonic()
    done = failed = 0
    computed = 0.0

    def report(new_done: int, new_failed: int, cost: float) -> None:
        nonlocal done, failed, computed, last_line
        done, failed, computed = done + new_done, failed + new_failed, computed + cost
        now = time.monotonic()
        is_last, remaining_cpu = done + failed >= jobs, seconds - computed
        if is_last or now - last_line >= interval:
            text = _counts(done, failed, jobs)
            if not is_last and remaining_cpu > 1e-9 * seconds:  # less is a rounding error
                remaining = (now - start_time) * remaining_cpu / max(computed, 1e-9)
                text += f", about {duration(remaining)} left"
            write(text)
            last_line = now

    yield report


def _counts(done: int, failed: int, jobs: int) -> str:
    return f"{done + failed}/{jobs} jobs" + (f", {failed} failed" if failed else "")


def duration(seconds: float) -> str:
    """Format a time (s) as `0.4 s`, `12 s`, `3 min 20 s`, `2 h 5 min`; below 0.1 ms as `4e-05 s`."""
    if seconds < 99.5:
        return f"{seconds:.2g} s"
    minutes, remainder = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {remainder} s"
