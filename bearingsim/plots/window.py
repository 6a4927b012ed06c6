"""Part of a record that a figure shows."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bearingsim.config.names import roller_of
from bearingsim.plots import lines, recorded
from bearingsim.plots.labels import PlotError
from bearingsim.plots.passage import Passage, passages
from bearingsim.plots.recorded import Job, Signal

if TYPE_CHECKING:
    from bearingsim.figure_kinds import View
    from bearingsim.store import Results

LEAD = 0.25  # fraction of the time axis before the impact
MIN_SAMPLES = 4


class Window(NamedTuple):
    """Part of a record from ``start`` to ``stop`` (s); ``origin`` (s) is zero on the time axis.

    crossing: times (s) at which the roller's contact enters and leaves the defect, of a window around an impact.
    """

    start: float
    stop: float
    origin: float = 0.0
    crossing: tuple[float, float] | None = None

    def contains(self, time: np.ndarray) -> np.ndarray:
        """Check which times (n,) in s lie in the window."""
        step = time[1] - time[0] if len(time) > 1 else 0.0
        return (time >= self.start - 1e-6 * step) & (time <= self.stop + 1e-6 * step)


def window_of(
    results: "Results", name: str, job: Job, channel: str, view: "View", default_span: float, passes: float = 1.0
) -> Window:
    """Return the part of a channel of a job to show.

    default_span: its default length (s); passes: its default length around an impact, in ball passes. Raises
    PlotError if it lies outside the record or contains too few samples.
    """
    time = job.series.time
    if view.around:
        span = view.span or passes * pass_period(job)
        origin, crossing = impact_time(results, name, job, channel, span)
        window = Window(origin - LEAD * span, origin + (1.0 - LEAD) * span, origin, crossing)
    else:
        start = view.start or 0.0
        stop = view.stop if view.stop is not None else start + (view.span or default_span)
        window = Window(start, stop)
    count = np.count_nonzero(window.contains(time))
    is_cut = (view.stop or view.span) and window.stop > time[-1] + 2.0 / float(job.parameters["sampling"])
    if count < MIN_SAMPLES or is_cut:
        raise PlotError(
            f"job {name} has {count} samples from {window.start:.6g} to {window.stop:.6g} s; its record lasts "
            f"from {time[0]:.6g} to {time[-1]:.6g} s, at {job.parameters['sampling']:g} Hz"
        )
    return window


def crop(signal: Signal, window: Window) -> Signal:
    """Return the part of a signal in a window. Raises PlotError if a measured one has too few samples in it."""
    in_window = window.contains(signal.time)
    count = np.count_nonzero(in_window)
    if signal.source and count < MIN_SAMPLES:
        raise PlotError(
            f"{signal.source} has {count} samples from {window.start:.6g} to {window.stop:.6g} s; it lasts "
            f"{signal.time[-1]:.6g} s"
        )
    return signal._replace(time=signal.time[in_window], values=signal.values[in_window])


def pass_period(job: Job) -> float:
    """Compute the period (s) of the ball passes over a point of the outer race, without slip."""
    return 1.0 / lines.frequency(lines.FAMILIES["outer"].fundamental, job.parameters)


def origin_text(jobs: Iterable[Job]) -> str:
    """Describe the origin of the time axis of a window around an impact, which ``impact_time`` returns."""
    names = ("the largest deviation" if is_on_rollers(job) else "the centre of the defect" for job in jobs)
    return f" from {' or '.join(dict.fromkeys(names))}"


def is_on_rollers(job: Job) -> bool:
    """Check if all defects of a job are on rollers, so that no passage can be found."""
    return lines.races(job.parameters) == ["roller"]


def impact_time(
    results: "Results", name: str, job: Job, channel: str, span: float
) -> tuple[float, tuple[float, float] | None]:
    """Return the time (s) at which a roller passes the centre of a race defect, and those of entry and exit.

    The passage is that of ``passage_of``; span: duration (s) shown. If all defects are on rollers, whose angles
    are not recorded, return the time at which the channel deviates most from its mean, and None. Raises PlotError
    for a healthy bearing, or if no roller passes.
    """
    if not lines.races(job.parameters):
        raise PlotError(f"job {name} has no defect, so there is no impact; use `from` and `span`")
    if is_on_rollers(job):
        signal = next(recorded.signals_of(job, channel))
        return float(signal.time[np.argmax(np.abs(signal.values - signal.values.mean()))]), None
    passage = passage_of(results, name, job, channel, span)
    if passage is None:
        raise PlotError(f"no roller passes the defect of job {name} completely within its record")
    return passage.time, passage.crossing


def passage_of(results: "Results", name: str, job: Job, channel: str, span: float = 0.0) -> Passage | None:
    """Return a complete passage over a race defect, of the channel's roller or else of any roller.

    Over a defect of the outer race, the first passage. A defect of the inner race rotates through the load zone:
    of its passages with ``span`` (s) in the record, the one nearest the direction of the load, where the contact
    load is largest. None without a passage.
    """
    case = recorded.case_of(results, name, job.parameters)
    roller = roller_of(channel)
    numbers = [roller[0]] if roller else range(1, case.bearing.rollers + 1)
    race = roller[1].partition("_")[0] if roller else ""
    direction = np.arctan2(case.load_across, case.load)
    beginning, end = job.series.time[0] + LEAD * span, job.series.time[-1] - (1.0 - LEAD) * span

    def rank(passage: Passage) -> tuple[bool, float, float]:
        if passage.defect.race == "outer":
            return False, 0.0, passage.time
        is_cut = not beginning <= passage.time <= end
        return is_cut, 1.0 - float(np.cos(passage.angle - direction)), passage.time

    candidates = (passage for number in numbers for passage in passages(job, case, number, race))
    return min(candidates, key=rank, default=None)
