"""Grid of axes for signals: a row per job, or per group of jobs, a column per channel; rollers share axes."""

import textwrap
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from bearingsim.config import dataset_names
from bearingsim.config.names import roller_of
from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import axis_label, finish, share_scales
from bearingsim.plots.caption import fixed_values, rounding_texts, sampling_texts
from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.overlay import overlaid_signals
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.style import COLOURS, COLUMN_IN, LINES, shades_of
from bearingsim.plots.ticks import NumberFormatter
from bearingsim.plots.units import Scale, choose_scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results
    from bearingsim.study import Figure

ROW_IN, LOW_ROW_IN = 1.7, 1.15  # heights of a row: usually, and if there are more than ``MANY_ROWS``
MANY_ROWS = 6
HEALTHY, HEALTHY_COLOUR = "healthy", "0.25"
COMPONENT_COLOURS = {"": COLOURS[0], "x": COLOURS[2], "y": COLOURS[3]}
CHARACTER_IN, GAP_IN = 0.07, 0.35  # inches: width of a character of a label, and distance of two rows
CAPTION_IN = 1.0  # height (inches) of caption and legend
WIDTH, HEALTHY_WIDTH = 1.1, 0.6  # points; the healthy curve is drawn on top, and thinner, so that both are visible
MEASURED_COLOURS = ("#B00000", "#7A5C00", "#5B2A86")
MIN_SHADED = 6  # number of ordered curves in one axes from which their colours are shades

CurvePoints = tuple[np.ndarray, np.ndarray]


class Display(NamedTuple):
    """Representation of signals: function that computes a curve (SI), and labels of the axes.

    curve: function of the id of the job with the defect, a job (that one or its healthy baseline), a channel and
    its signal; notes: texts for the caption, to which the computation of spectra adds; y_label: function of the
    channel's name; power: exponent of the channel's unit in that of the y axis; amplitude: True for amplitudes of
    sines (0-peak).
    """

    curve: Callable[[str, Job, str, Signal], CurvePoints]
    x_label: str
    notes: list[str]
    y_label: Callable[[str], str] = str
    power: int = 1
    amplitude: bool = False


class Row(NamedTuple):
    """Row of axes: title; jobs by the names of their curves; pairs of a job and its healthy baseline likewise."""

    title: str
    jobs: dict[str, str]
    baselines: dict[str, tuple[str, str]]


class Column(NamedTuple):
    """Column of axes: label and scale of the y axes, and the curves (SI) in each row."""

    label: str
    scale: Scale
    curves: list[list["DrawnCurve"]]


class Content(NamedTuple):
    """Content of a grid: titles of rows, columns, label of the x axes, jobs in each row, caption.

    is_below: True for a row that shows the healthy baselines of the row above.
    """

    titles: list[str]
    columns: list[Column]
    x_label: str
    jobs: list[list[Job]]
    is_below: list[bool]
    caption: list[str]


class Grid(NamedTuple):
    """Drawn grid: figure, rows of axes, the jobs in each; is_below: as in ``Content``."""

    canvas: Canvas
    axes: list[list["Axes"]]
    jobs: list[list[Job]]
    is_below: list[bool]

    def share_scales(self) -> None:
        """Share the y axes of jobs and their healthy baselines below, and those of rows with similar ranges."""
        for upper, lower, is_below in zip(self.axes, self.axes[1:], self.is_below[1:], strict=False):
            if is_below:
                share_scales([upper, lower], inf)
        share_scales(self.axes)


def compute_content(
    results: "Results", jobs: dict[str, Job], channels: Sequence[str], figure: "Figure", display: Display
) -> Content:
    """Compute curves of channels: a row per job, or per combination of the swept paths that are not in ``by``.

    Titles contain the swept values. Channels of one quantity of several rollers share a column. Raises PlotError
    for a path that is not swept, or a unit of another quantity.
    """
    rows = list(_rows(results, jobs, figure))
    baselines = sorted({baseline for row in rows for _, baseline in row.baselines.values()} - jobs.keys())
    records = jobs | recorded.load_jobs(results, baselines)
    columns = []
    for column in _columns(channels):
        drawn = [
            [
                *_curves_of_row(row, records, column, display),
                *_measured_curves(results, row, records, column, display),
            ]
            for row in rows
        ]
        scale = _scale(column[0], figure, display, drawn)
        label = axis_label(display.y_label(recorded.text_of(*column)), scale.unit_text(display.amplitude))
        columns.append(Column(label, scale, drawn))
    table = select.case_rows(results)
    swept = set().union(*(entry["swept"] for entry in results.plan["jobs"] if entry["job"] in jobs))
    fixed = fixed_values(results, table[table["job"].isin(jobs)], swept)
    leading = [[*row.jobs.values(), *(name for name, _ in row.baselines.values())] for row in rows]
    return Content(
        [row.title for row in rows],
        columns,
        display.x_label,
        [[records[name] for name in dict.fromkeys(names)] for names in leading],
        [not row.jobs for row in rows],
        [
            *rounding_texts(results, jobs, channels),
            *display.notes,
            *sampling_texts(jobs.values(), channels),
            *fixed,
        ],
    )


def draw_grid(panels: Content, title: str | None, marks: Sequence[Line2D] = ()) -> Grid:
    """Draw a grid of axes; marks: further entries of the legend."""
    rows, columns = len(panels.titles), len(panels.columns)
    height = LOW_ROW_IN if rows > MANY_ROWS else ROW_IN
    size = (max(2, columns) * COLUMN_IN, height * rows + (0.6 if rows > 1 else 1.0))
    canvas = Canvas(figsize=size, layout="constrained")
    axes = [list(line) for line in canvas.subplots(rows, columns, sharex="col", squeeze=False)]
    for number, column in enumerate(panels.columns):
        for line, curves in zip(axes, column.curves, strict=True):
            _panel(line[number], curves, column.scale)
        _name_axes([line[number] for line in axes], column.label, columns == 1, height)
        axes[-1][number].set_xlabel(panels.x_label)
    for line, text in zip(axes, panels.titles, strict=True):
        line[0].set_title(text, loc="left", fontsize=8, pad=11 if line is axes[0] else 4)
    finish(canvas, title, panels.caption, [*_legend_entries(ax for line in axes for ax in line), *marks])
    result = Grid(canvas, axes, panels.jobs, panels.is_below)
    result.share_scales()
    return result


# Rows


def _rows(results: "Results", jobs: Iterable[str], figure: "Figure") -> Iterator[Row]:
    """Group jobs into rows; a row for the healthy baselines follows if they are drawn below."""
    units = results.plan["units"]
    select.check_paths(figure.by, units)
    by = (*figure.by, *_tied_paths(results, figure.by))
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    layout = figure.view.healthy or ("off" if by else "beside")
    baseline_of = {} if layout == "off" else _baselines(results, jobs)
    groups: dict[str, dict[str, str]] = {}
    for name in jobs:
        others = {path: value for path, value in swept[name].items() if path not in by}
        title = labels.swept_text(others, units)
        group = groups.setdefault(title if by else f"{title} {name}", {})
        label = labels.swept_text({path: swept[name][path] for path in by if path in swept[name]}, units)
        group[label if label not in group else f"{label} ({name[:8]})"] = name
    for group in groups.values():
        leading = next(iter(group.values()))
        others = {path: value for path, value in swept[leading].items() if path not in by}
        title = labels.swept_text(others, units)
        baselines = {label: (name, baseline_of[name]) for label, name in group.items() if name in baseline_of}
        if len({baseline for _, baseline in baselines.values()}) == 1:
            baselines = {"": next(iter(baselines.values()))}
        if layout == "below" and baselines:
            yield Row(title, group, {})
            healthy_values = {path: value for path, value in others.items() if not path.startswith("defect")}
            yield Row(", ".join(filter(None, [HEALTHY, labels.swept_text(healthy_values, units)])), {}, baselines)
        else:
            yield Row(title, group, baselines)


def _tied_paths(results: "Results", by: Sequence[str]) -> list[str]:
    """List the paths with one value for each value of ``by``, as those of a `zip`; none for a path of a design.

    Each value of a design occurs once, so all paths would be tied to it.
    """
    if not by or set(by) & set(select.design_paths(results)):
        return []
    table = select.case_rows(results)
    others = select.varied_paths(table, [path for path in results.plan["units"] if path not in by])
    return [path for path in others if select.follows(path, by, table)]


def _baselines(results: "Results", jobs: Iterable[str]) -> dict[str, str]:
    """Map jobs to their healthy baselines, omitting baselines that are not done."""
    table = results.table().set_index("job")
    done = set(table.index[table["status"] == "done"])
    healthy = {entry["job"]: entry["healthy"] for entry in results.plan["jobs"]}
    return {job: baseline for job in jobs if (baseline := str(healthy.get(job))) in done}


def _columns(channels: Sequence[str]) -> Iterator[list[str]]:
    """Group channels into columns: the same quantity of different rollers together."""
    groups: dict[str, list[str]] = {}
    for channel in channels:
        roller = roller_of(channel)
        groups.setdefault(roller[1] if roller else f"of no roller: {channel}", []).append(channel)
    yield from groups.values()


# Curves


class DrawnCurve(NamedTuple):
    """Curve to draw: its name, colour, line style and points (SI).

    is_healthy: True for a healthy baseline; is_measured: True for a measured signal, drawn behind simulated ones.
    """

    name: str
    colour: object
    line: object
    is_healthy: bool
    points: CurvePoints
    is_measured: bool = False


def _curves_of_row(
    row: Row, records: Mapping[str, Job], channels: Sequence[str], display: Display
) -> list[DrawnCurve]:
    """Compute the curves in one axes, with those of the healthy baselines last."""
    drawn: list[DrawnCurve] = []
    several = len(row.jobs) > 1 or any(row.jobs)
    colours = _colours(len(row.jobs))
    for number, (label, name) in enumerate(row.jobs.items()):
        for component, points in _curves(name, records[name], channels, display).items():
            text = ", ".join(filter(None, [label, component]))
            colour = (
                colours[number]
                if several
                else COMPONENT_COLOURS.get(component, COLOURS[len(drawn) % len(COLOURS)])
            )
            dashes = LINES[:2] if len(row.jobs) >= MIN_SHADED else LINES
            line = dashes[len(drawn) % len(dashes)]
            drawn.append(DrawnCurve(text, colour, line, False, points))
    if len(drawn) > 1 and not several:  # the curves of components or rollers would hide those of the baseline
        return drawn
    for label, (name, baseline) in row.baselines.items():
        if _has_recorded(records[baseline], channels[0]):
            for component, points in _curves(name, records[baseline], channels, display).items():
                text = ", ".join(filter(None, [HEALTHY, label, component]))
                drawn.append(DrawnCurve(text, HEALTHY_COLOUR, "-", True, points))
    return drawn


def _measured_curves(
    results: "Results", row: Row, records: Mapping[str, Job], channels: Sequence[str], display: Display
) -> Iterator[DrawnCurve]:
    """Yield the curves of measured signals at the parameters of the jobs in a row.

    Warns of signals that do not cover the time or the band that the figure shows.
    """
    names = set[str]()
    for name in row.jobs.values():
        for legend, signal in overlaid_signals(results, name, channels[0]):
            if legend in names:
                continue
            cycle, number = divmod(len(names), len(MEASURED_COLOURS))
            names.add(legend)
            try:
                points = display.curve(name, records[name], channels[0], signal)
            except PlotError as error:
                warnings.warn(f"measured signal skipped: {error}", PlotWarning, stacklevel=2)
                continue
            colour, line = MEASURED_COLOURS[number], LINES[cycle % len(LINES)]
            yield DrawnCurve(legend, colour, line, False, points, is_measured=True)


def _colours(count: int) -> list[object]:
    return shades_of(count) if count >= MIN_SHADED else list(COLOURS[:count])


def _curves(name: str, job: Job, channels: Sequence[str], display: Display) -> dict[str, CurvePoints]:
    """Compute the curve of each component, or of each roller."""
    return {
        signal.component if len(channels) == 1 else _roller_text(channel): display.curve(
            name, job, channel, signal
        )
        for channel in channels
        for signal in recorded.signals_of(job, channel)
    }


def _has_recorded(job: Job, channel: str) -> bool:
    """Check if a job has recorded a channel; a healthy baseline records no single slices."""
    components = [name for channel in job.recorded for name in dataset_names(channel)]
    return recorded.recorded_as(channel, [*job.recorded, *components]) is not None


def _roller_text(channel: str) -> str:
    return f"roller {(roller_of(channel) or (1, ''))[0]}"


def _scale(channel: str, figure: "Figure", display: Display, rows: Sequence[Sequence[DrawnCurve]]) -> Scale:
    """Choose the unit of a column by the largest value."""
    largest = max((float(np.nanmax(np.abs(curve.points[1]))) for curves in rows for curve in curves), default=0.0)
    return choose_scale(recorded.unit_of(channel), channel, largest, figure.view, display.power)


# Drawing


def legend_names(curves: Sequence[DrawnCurve]) -> list[str]:
    """Return the names of curves in one axes; empty for the only one."""
    has_both = len({curve.is_healthy for curve in curves}) == 2 or any(curve.is_measured for curve in curves)
    named_by_title = "" if has_both else HEALTHY  # of a row of healthy bearings
    return [
        curve.name.removeprefix(named_by_title).removeprefix(", ")
        if curve.is_healthy
        else curve.name or ("with defect" if has_both else "")
        for curve in curves
    ]


def _panel(ax: "Axes", curves: Sequence[DrawnCurve], scale: Scale) -> None:
    for curve, name in zip(curves, legend_names(curves), strict=True):
        x, y = curve.points
        width, order = (HEALTHY_WIDTH, 2.5) if curve.is_healthy else (WIDTH, 1.8 if curve.is_measured else 2.0)
        ax.plot(x, scale.to_axis(y), color=curve.colour, ls=curve.line, lw=width, zorder=order, label=name or None)
    ax.margins(x=0.0)
    ax.yaxis.set_major_formatter(NumberFormatter())


def _name_axes(column: Sequence["Axes"], label: str, only: bool, height: float) -> None:
    """Label the y axes of a column, with one common label if it is the only column; height: of a row (inches)."""
    if only and len(column) > 1:
        canvas = column[0].get_figure(root=True)
        assert canvas is not None
        characters = int((canvas.get_size_inches()[1] - CAPTION_IN) / CHARACTER_IN)
        canvas.supylabel(textwrap.fill(label, characters), fontsize=9.0)
        return
    length = height - (GAP_IN if len(column) > 1 else 0.0)
    text = textwrap.fill(label, int(length / CHARACTER_IN), break_long_words=False)
    for ax in column:
        ax.set_ylabel(text, fontsize=8.0)


def _legend_entries(axes: Iterable["Axes"]) -> list[Line2D]:
    """Return one line for each name in the legend."""
    curves = {str(line.get_label()): line for ax in axes for line in ax.lines}
    return [line for name, line in curves.items() if not name.startswith("_")]
