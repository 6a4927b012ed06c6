"""Signals over time."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bearingsim.plots import recorded
from bearingsim.plots.grid import Content, CurvePoints, Display, compute_content, draw_grid
from bearingsim.plots.overlay import signal_points
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.window import crop, origin_text, pass_period, window_of

if TYPE_CHECKING:
    from bearingsim.store import Results
    from bearingsim.study import Figure

SHOWN_PASSES = {"ring.": 8, "load_zone.": 8, "roller.": 26}
"""Ball passes shown by default, by channel; other channels are shown in full."""
CROSSING_COLOUR = "0.93"
MEASURED_AROUND = "measured signals at any phase, because the times of their impacts are not known"
SHOWN_IN_SECONDS = 0.5  # s; shorter time axes are in ms


def draw_series(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw channels over time, a row per job, with the healthy baseline."""
    content, records, channels = series_of(results, figure, jobs)
    crossing = _common_crossing(results, figure, records, channels)
    if crossing is not None:
        content.caption.append("grey: the contact is over the defect")
    panels = draw_grid(content, figure.title)
    if crossing is not None:
        for ax in (ax for row in panels.axes for ax in row):
            ax.axvspan(*crossing, color=CROSSING_COLOUR, lw=0.0, zorder=0.5)
    return [Sheet(file_words(figure, jobs), panels.canvas)]


def series_of(
    results: "Results", figure: "Figure", jobs: Sequence[str]
) -> tuple[Content, dict[str, Job], list[str]]:
    """Compute the curves of channels over time; also return the jobs and the channels.

    Raises PlotError for a channel that was not recorded, and in the cases of ``window_of``.
    """
    view = figure.view
    records = recorded.load_jobs(results, jobs)
    channels = recorded.channels_for(records, figure.y)
    unit, scale = _time_unit(figure, records, channels)

    def curve(name: str, job: Job, channel: str, signal: Signal) -> CurvePoints:
        window = window_of(results, name, records[name], channel, view, shown_time(records, channel))
        values = recorded.drawn_values(job, channel, recorded.filter_signal(job, signal, view))
        part = crop(signal._replace(values=values), window)
        return (part.time - window.origin) / scale, part.values

    since = origin_text(records.values()) if view.around else ""
    texts = _texts(figure, records, channels)
    if any(True for job in jobs for _ in signal_points(results, job)):
        texts.append(MEASURED_AROUND if view.around else "measured signals from their own start")
    display = Display(curve, f"Time{since} ({unit})", texts)
    return compute_content(results, records, channels, figure, display), records, channels


def _time_unit(figure: "Figure", records: Mapping[str, Job], channels: Sequence[str]) -> tuple[str, float]:
    """Choose the unit of the time axis, and its value in s."""
    view = figure.view
    lengths = [shown_time(records, channel) for channel in channels]
    if view.around:
        lengths = [pass_period(job) for job in records.values()]
    longest = max(lengths) if view.stop is None else view.stop - (view.start or 0.0)
    return ("s", 1.0) if (view.span or longest) >= SHOWN_IN_SECONDS else ("ms", 1e-3)


def _common_crossing(
    results: "Results", figure: "Figure", records: Mapping[str, Job], channels: Sequence[str]
) -> tuple[float, float] | None:
    """Return the ends of the time in which the contact is over the defect, in the unit of the axis.

    None if they differ between curves, or are unknown.
    """
    crossings = set(_crossings(results, figure, records, channels)) if figure.view.around else set()
    return crossings.pop() if len(crossings) == 1 else None


def _crossings(
    results: "Results", figure: "Figure", records: Mapping[str, Job], channels: Sequence[str]
) -> Iterator[tuple[float, float]]:
    """Yield, for each curve, the ends of the time in which the contact is over the defect."""
    _, scale = _time_unit(figure, records, channels)
    for name, job in records.items():
        for channel in channels:
            window = window_of(results, name, job, channel, figure.view, shown_time(records, channel))
            if window.crossing:
                low, high = (round((end - window.origin) / scale, 6) for end in window.crossing)
                yield low, high


def shown_time(records: Mapping[str, Job], channel: str) -> float:
    """Return the duration (s) to draw: ``SHOWN_PASSES`` of the slowest job, because jobs share the time axis."""
    passes = next((passes for start, passes in SHOWN_PASSES.items() if channel.startswith(start)), np.inf)
    return max(
        float(min((np.inf if recorded.has_ramp(job) else passes) * pass_period(job), job.parameters["duration"]))
        for job in records.values()
    )


def _texts(figure: "Figure", records: Mapping[str, Job], channels: Sequence[str]) -> list[str]:
    band = figure.view.band
    return [
        *([f"band {band[0] / 1e3:.4g} to {band[1] / 1e3:.4g} kHz"] if band else []),
        *recorded.drawing_texts(records.values(), channels),
        *(["mean subtracted"] if figure.view.zero_mean else []),
    ]
