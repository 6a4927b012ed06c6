"""Signals of a roller over its angle from the load line."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bearingsim.config.names import roller_of
from bearingsim.plots import recorded
from bearingsim.plots.grid import CurvePoints, Display, compute_content, draw_grid
from bearingsim.plots.labels import PlotError
from bearingsim.plots.marks import MARK_COLOURS
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.window import passage_of

if TYPE_CHECKING:
    from bearingsim.store import Results
    from bearingsim.study import Figure

TICK_DISTANCE = 90.0  # deg, distance of ticks; a smaller range of angles has matplotlib's ticks


def draw_roller(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw channels of a roller over its angle from the load line, or around a defect that it passes.

    Raises PlotError for another channel, or if the roller passes no defect.
    """
    records = recorded.load_jobs(results, jobs)
    channels = recorded.channels_for(records, figure.y, prefix="roller.")
    if not figure.y:
        names = [name for name in next(iter(records.values())).recorded if not recorded.is_of_slice(name)]
        number = (roller_of(channels[0]) or (1, ""))[0]
        channels = [name for name in names if (roller_of(name) or (0, ""))[0] == number]
    for name in channels:
        if roller_of(name) is None:
            raise PlotError(f"`{name}` is not a roller channel; use `--kind series`")
    low, high = (-180.0, 180.0) if figure.view.range is None else map(float, np.degrees(figure.view.range))
    if figure.view.around:
        low, high = _around_defect(results, records, channels[0], figure)

    def curve(name: str, job: Job, channel: str, signal: Signal) -> CurvePoints:
        values = recorded.drawn_values(job, channel, recorded.filter_signal(job, signal, figure.view))
        angle = np.degrees(recorded.roller_angle(job, (roller_of(channel) or (1, ""))[0]))
        angle = _wrap(angle, 0.5 * (low + high))
        return _in_range(angle, values, low, high, one_pass=bool(figure.view.around))

    if figure.view.healthy is None:
        figure = replace(figure, view=replace(figure.view, healthy="off"))
    texts = recorded.drawing_texts(records.values(), channels)
    display = Display(curve, "Angle of the roller (°)", texts)
    panels = draw_grid(compute_content(results, records, channels, figure, display), figure.title)
    for row, jobs_of_row in zip(panels.axes, panels.jobs, strict=True):
        for ax in row:
            if high - low > TICK_DISTANCE:
                ax.set_xticks(np.arange(np.ceil(low / TICK_DISTANCE), high / TICK_DISTANCE + 1e-9) * TICK_DISTANCE)
            ax.set_xlim(low, high)
            for job in jobs_of_row:
                for angle in outer_defects(job.parameters):
                    position = _wrap(np.degrees(angle), 0.5 * (low + high))
                    ax.axvline(position, color=MARK_COLOURS["outer"], lw=0.7, alpha=0.6, zorder=0.9)
    return [Sheet(file_words(figure, jobs), panels.canvas)]


def _wrap(angle: Any, centre: float) -> Any:
    """Return angles (deg) shifted by whole revolutions into the range ``centre`` - 180 to ``centre`` + 180."""
    return (angle - centre + 180.0) % 360.0 - 180.0 + centre


def _in_range(angle: np.ndarray, values: np.ndarray, low: float, high: float, one_pass: bool) -> CurvePoints:
    """Return angles (deg) and values within limits: of the first pass, or with a gap after each revolution."""
    indices = np.flatnonzero((angle >= low) & (angle <= high))
    if not len(indices):
        raise PlotError(f"no sample has an angle from {low:g} to {high:g}°; record longer or raise `sampling`")
    ends = np.flatnonzero((np.diff(indices) > 1) | (np.diff(angle[indices]) < 0.0)) + 1
    if one_pass and len(ends):
        indices, ends = indices[: ends[0]], ends[:0]
    return np.insert(angle[indices], ends, np.nan), np.insert(values[indices], ends, np.nan)


def _around_defect(
    results: "Results", records: Mapping[str, Job], channel: str, figure: "Figure"
) -> tuple[float, float]:
    """Return the angles (deg) of the roller from shortly before to after a stationary defect that it passes."""
    ranges = []
    for name, job in records.items():
        passage = passage_of(results, name, job, channel)
        if passage is None or passage.defect.race != "outer":
            raise PlotError(f"the roller of job {name} passes no defect of the outer race; use `range`")
        angles = recorded.roller_angle(job, 1)
        speed = float((angles[-1] - angles[0]) / (job.series.time[-1] - job.series.time[0]))
        defect_angle = _wrap(np.degrees(passage.defect.angle), 0.0)
        ranges.append([defect_angle + np.degrees(speed * (end - passage.time)) for end in passage.time_range])
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def outer_defects(parameters: Mapping[Any, Any]) -> list[float]:
    """List the angles (rad) of the stationary defects."""
    heads = [str(name).removesuffix(".race") for name in parameters if str(name).endswith(".race")]
    return [parameters[f"{head}.angle"] for head in heads if parameters[f"{head}.race"] == "outer"]
