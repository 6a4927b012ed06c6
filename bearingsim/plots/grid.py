"""Grid of axes: a row per job, a column per channel; rollers share axes."""

import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.config import dataset_names
from bearingsim.config.names import roller_of
from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import axis_label, finish, share_scales
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.style import COLOURS, COLUMN_IN

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results

ROW_IN, LOW_ROW_IN = 1.7, 1.15
MANY = 6  # number of jobs above which rows are lower
HEALTHY = "0.35"
PARTS = {"": COLOURS[0], "x": COLOURS[2], "y": COLOURS[3]}
LABEL_LETTERS, LETTER_IN = 26, 0.075
SQUARES = 3.0  # a squared quantity is shown in its larger unit from 0.1 on

Curve = tuple[np.ndarray, np.ndarray]


class View(NamedTuple):
    """Representation of signals: function that computes the curve (SI), axis labels, power of the channel's unit.

    baselines: whether the healthy baseline is drawn too, if a column has one curve.
    """

    curve: Callable[[Job, str, Signal], Curve]
    x_label: str
    y_label: Callable[[str], str]
    power: int = 1
    baselines: bool = True


def grid(
    results: "Results", jobs: dict[str, Job], channels: Sequence[str], view: View
) -> tuple[Canvas, list[list["Axes"]]]:
    """Draw a row of axes per job and a column per quantity, with the healthy baselines.

    Titles give the swept values. A quantity of several rollers shares one column.
    """
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    baseline_of = _baselines(results, jobs) if view.baselines else {}
    records = recorded.all_jobs(results, sorted(set(baseline_of.values())))
    columns = list(_columns(channels))
    height = LOW_ROW_IN if len(jobs) > MANY else ROW_IN
    size = (max(2, len(columns)) * COLUMN_IN, height * len(jobs) + (0.6 if len(jobs) > 1 else 1.0))
    canvas = Canvas(figsize=size, layout="constrained")
    made = canvas.subplots(len(jobs), len(columns), sharex="col", squeeze=False)
    axes = [list(row) for row in made]
    for column, together in enumerate(columns):
        drawn = {job: _curves(record, together, view) for job, record in jobs.items()}
        unit, factor = _unit(together[0], view, drawn)
        for row, (job, curves) in zip(axes, drawn.items(), strict=True):
            baseline = records.get(baseline_of.get(job, ""))
            has_baseline = baseline is not None and len(curves) == 1 and _has(baseline, together[0])
            _panel(
                row[column], curves, _curves(baseline, together, view) if baseline and has_baseline else {}, factor
            )
        label = axis_label(view.y_label(recorded.text_of(*together)), unit)
        _name_axes([row[column] for row in axes], label, len(columns) == 1)
        axes[-1][column].set_xlabel(view.x_label)
    for row, job in zip(axes, jobs, strict=True):
        title = labels.described(swept[job], results.plan["units"])
        row[0].set_title(title, loc="left", fontsize=8, pad=11 if row is axes[0] else 4)
    share_scales(axes)
    _legend(canvas, [ax for row in axes for ax in row])
    rows = select.case_rows(results)
    finish(canvas, None, fixed_values(results, rows[rows["job"].isin(jobs)], set().union(*swept.values())))
    return canvas, axes


def _columns(channels: Sequence[str]) -> Iterator[list[str]]:
    """Group channels into columns: the same quantity of different rollers together."""
    groups: dict[str, list[str]] = {}
    for channel in channels:
        roller = roller_of(channel)
        groups.setdefault(roller[1] if roller else f"of no roller: {channel}", []).append(channel)
    yield from groups.values()


def _curves(job: Job, channels: Sequence[str], view: View) -> dict[str, Curve]:
    """Compute the curve of each component, or of each roller."""
    return {
        signal.component if len(channels) == 1 else _whose(channel): view.curve(job, channel, signal)
        for channel in channels
        for signal in recorded.signals_of(job, channel)
    }


def _has(job: Job, channel: str) -> bool:
    """Check if a job has recorded a channel (a healthy baseline has no slices of its own)."""
    components = [name for whole in job.recorded for name in dataset_names(whole)]
    return recorded.recorded_as(channel, [*job.recorded, *components]) is not None


def _whose(channel: str) -> str:
    return f"roller {(roller_of(channel) or (1, ''))[0]}"


def _unit(channel: str, view: View, drawn: Mapping[str, Mapping[str, Curve]]) -> tuple[str, float]:
    """Choose the unit of a column and its factor from SI by the largest value."""
    largest = max(float(np.nanmax(np.abs(y))) for curves in drawn.values() for _, y in curves.values())
    alike = (SQUARES if view.power == 2 else 1.0) * largest ** (1.0 / view.power)
    unit, factor = labels.readable(recorded.unit_of(channel), channel, alike)
    return (labels.squared(unit) if view.power == 2 else unit), factor**view.power


def _panel(ax: "Axes", curves: Mapping[str, Curve], healthy: Mapping[str, Curve], factor: float) -> None:
    for number, (component, (x, y)) in enumerate(curves.items()):
        name = component or ("with defect" if healthy else None)
        colour = PARTS.get(component, COLOURS[number % len(COLOURS)])
        ax.plot(x, factor * y, color=colour, lw=0.9, label=name)
    for x, y in healthy.values():
        ax.plot(x, factor * y, color=HEALTHY, lw=0.9, label="healthy")
    ax.margins(x=0.0)
    ax.yaxis.set_major_formatter(lambda value, _: labels.number_text(value))


def _name_axes(column: Sequence["Axes"], label: str, only: bool) -> None:
    """Label the y axes of a column, with one common label if it is the only column."""
    if only and len(column) > 1:
        canvas = column[0].get_figure(root=True)
        assert canvas is not None
        letters = int(canvas.get_size_inches()[1] / LETTER_IN)
        canvas.supylabel(textwrap.fill(label, letters), fontsize=9.0)
        return
    for ax in column:
        ax.set_ylabel(textwrap.fill(label, LABEL_LETTERS), fontsize=8.0)


def _legend(canvas: Canvas, axes: Iterable["Axes"]) -> None:
    """Add a legend with one entry per name of a curve."""
    entries = {name: handle for ax in axes for handle, name in zip(*ax.get_legend_handles_labels(), strict=True)}
    if entries:
        canvas.legend(list(entries.values()), list(entries), loc="outside upper right", ncols=len(entries))


def _baselines(results: "Results", jobs: Iterable[str]) -> dict[str, str]:
    """Map jobs to their healthy baselines, omitting baselines that are not done."""
    table = results.table().set_index("job")
    done = set(table.index[table["status"] == "done"])
    healthy = {entry["job"]: entry["healthy"] for entry in results.plan["jobs"]}
    return {job: baseline for job in jobs if (baseline := str(healthy.get(job))) in done}
