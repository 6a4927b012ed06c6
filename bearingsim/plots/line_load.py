"""Load along a roller: over time and position as it passes a defect, and its distribution at a few instants."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.config.names import LINE_LOADS, roller_of
from bearingsim.plots import labels, lines, recorded, select
from bearingsim.plots.axes import axis_label, finish
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.passage import Passage, Reals, ends_of_slices, first_passage
from bearingsim.plots.recorded import Job
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.style import COLOURS, LINES
from bearingsim.plots.ticks import NumberFormatter

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.config import Case
    from bearingsim.store import Results
    from bearingsim.study import Figure

ROW_IN, TILT_IN = 2.5, 1.3  # heights of a row and of its tilts
MAP_IN, PROFILE_IN = 4.2, 2.6  # widths of the map and of the sections
COLOUR_MAP = "YlOrRd"
UNLOADED = 0.02  # line load, relative to the largest, below which a slice is drawn as unloaded
DEFAULT_PASSES = 8.0  # ball passes shown if the roller passes no defect
FEW_SAMPLES = 10.0  # samples over a defect, below which the caption states their number
LABEL_CHARACTERS = 30
MIN_SAMPLES = 4
TILTS = {"tilt": COLOURS[0], "skew": COLOURS[1]}
ADVICE = "add `roller.outer_line_load` to `record`, with `model: spatial`"


class LineLoad(NamedTuple):
    """Line load of a roller: time (n,) in s, load (slices, n) in N/m, ends of slices (m), passage over a defect.

    tilts: tilt and skew (n,) in rad of the roller, if they were recorded.
    """

    channel: str
    time: Reals
    load: Reals
    ends: Reals
    passage: Passage | None
    tilts: dict[str, Reals]


def draw_load(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the line load along a roller, a row per job and channel: a map over time, and sections through it.

    Recorded tilt and skew of the roller are drawn below. The span of the figure is around the roller's first
    passage over a defect. Raises PlotError for channels that were not recorded.
    """
    y, span = figure.y, figure.view.span
    records = recorded.load_jobs(results, jobs)
    rows = [(job, load) for job, record in records.items() for load in _read_loads(results, job, record, y, span)]
    heights = [height for _, load in rows for height in (ROW_IN, *([TILT_IN] if load.tilts else []))]
    canvas = Canvas(figsize=(MAP_IN + PROFILE_IN + 2.4, sum(heights) + 0.8), layout="constrained")
    panel_axes = canvas.subplots(
        len(heights), 2, squeeze=False, width_ratios=[MAP_IN, PROFILE_IN], height_ratios=heights
    )
    axes = iter(panel_axes)
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    for job, load in rows:
        map_axes, profile_axes = next(axes)
        _draw_row(map_axes, profile_axes, load)
        map_axes.set_title(labels.swept_text(swept[job], results.plan["units"]), loc="left", fontsize=8)
        if load.tilts:
            below, legend_axes = next(axes)
            _draw_tilts(below, legend_axes, map_axes, load)
    table = select.case_rows(results)
    fixed = fixed_values(results, table[table["job"].isin(jobs)], set().union(*swept.values()))
    finish(canvas, figure.title, [*_notes(records, rows), *fixed])
    return [Sheet(file_words(figure, jobs), canvas)]


def _notes(records: Mapping[str, Job], rows: Sequence[tuple[str, LineLoad]]) -> list[str]:
    """Report passages with few samples over a defect, or rollers that pass no defect."""
    crossed = [(job, load.passage) for job, load in rows if load.passage is not None]
    counts = [passage.samples(records[job].parameters["sampling"]) for job, passage in crossed]
    few = (
        [f"only {min(counts):.1f} samples over the defect"]
        if min(counts, default=FEW_SAMPLES) < FEW_SAMPLES
        else []
    )
    missed = any(load.passage is None and lines.races(records[job].parameters) for job, load in rows)
    return [*few, *(["no roller passes a race defect within the record"] if missed else [])]


# Data


def _read_loads(
    results: "Results", job: str, record: Job, names: Sequence[str], span: float | None
) -> Iterator[LineLoad]:
    """Yield the requested line loads of a job, or all that it has recorded."""
    case = recorded.case_of(results, job, record.parameters)
    ends = ends_of_slices(case)
    for channel in [_full_name(name) for name in names] or _recorded_line_loads(job, record):
        load = _stack_slices(job, record, channel, len(ends) - 1)
        number, quantity = roller_of(channel) or (1, "")
        passage = first_passage(record, case, number, quantity.partition("_")[0])
        start, stop = _time_range(case, record, passage, span)
        time = record.series.time
        in_range = (time >= start) & (time <= stop)
        if np.count_nonzero(in_range) < MIN_SAMPLES:
            raise labels.PlotError(
                f"job {job} has {np.count_nonzero(in_range)} samples in that time; raise `sampling`"
            )
        tilts = {name: values[in_range] for name, values in _tilts(record, number)}
        yield LineLoad(channel, time[in_range], load[:, in_range], ends, passage, tilts)


def _tilts(record: Job, number: int) -> Iterator[tuple[str, Reals]]:
    """Yield tilt and skew (rad) of a roller, if they were recorded."""
    for name in TILTS:
        channel = recorded.recorded_as(f"roller.{number}.{name}", record.recorded)
        if channel:
            yield name, np.asarray(record.series.channels[channel], np.float64)


def _full_name(name: str) -> str:
    """Expand `roller.outer_line_load` to the name of the first roller's channel."""
    return name.replace("roller.", "roller.1.", 1) if name in (f"roller.{kind}" for kind in LINE_LOADS) else name


def _recorded_line_loads(job: str, record: Job) -> list[str]:
    """List the line loads that a job has recorded, without slice numbers. Raises PlotError if there are none."""
    channels = dict.fromkeys(name.rpartition(".")[0] for name in record.recorded if "_line_load." in name)
    if not channels:
        raise labels.PlotError(f"job {job} did not record a load along a roller: {ADVICE}")
    return list(channels)


def _stack_slices(job: str, record: Job, channel: str, count: int) -> Reals:
    """Stack the line load (N/m) of all slices, (slices, n). Raises PlotError if some were not recorded."""
    names = [f"{channel}.{number}" for number in range(1, count + 1)]
    missing = sum(name not in record.series.channels for name in names)
    if count < 1 or missing == count:
        advice = ADVICE.replace("roller.outer_line_load", channel)
        raise labels.PlotError(f"job {job} did not record `{channel}`: {advice}")
    if missing:
        raise labels.PlotError(
            f"job {job} has recorded {count - missing} of {count} slices; add `{channel}` to record all"
        )
    return np.stack([np.asarray(record.series.channels[name], np.float64) for name in names])


def _time_range(case: "Case", record: Job, passage: Passage | None, span: float | None) -> tuple[float, float]:
    """Return start and end (s) of the time shown."""
    if passage is None:
        rate = case.bearing.ball_pass_frequency(case.speed)
        return 0.0, span or min(DEFAULT_PASSES / rate, float(record.parameters["duration"]))
    start, stop = passage.time_range
    if span is None:
        return start, stop
    before = (passage.time - start) / (stop - start) * span
    return passage.time - before, passage.time - before + span


def instants(load: LineLoad) -> dict[str, int]:
    """Select the samples at which the distribution is drawn, by name.

    `over the defect`: the median sample among those with the smallest load on the part of the roller over the
    defect, which may be shorter than a slice. `largest after`: the largest total load from then on. Without a
    defect: the largest and the smallest total load.
    """
    total = _total_forces(load)
    if load.passage is None:
        return {"largest load": int(np.argmax(total)), "least load": int(np.argmin(total))}
    low, high = load.passage.defect.z
    lengths = np.maximum(np.minimum(load.ends[1:], high) - np.maximum(load.ends[:-1], low), 0.0)  # over the defect
    force = np.maximum(lengths @ load.load, 0.0)
    least = np.flatnonzero(force <= force.min() + UNLOADED * force.max())
    over_defect = int(least[len(least) // 2])
    largest = over_defect + int(np.argmax(total[over_defect:]))
    return {"before": 0, "over the defect": over_defect, "largest after": largest, "after": len(load.time) - 1}


def _slice_forces(load: LineLoad) -> Reals:
    """Compute the force (N) on each slice, (slices, n)."""
    return load.load * np.diff(load.ends)[:, np.newaxis]


def _total_forces(load: LineLoad) -> Reals:
    """Compute the total force (N) on the roller, (n,)."""
    return np.asarray(_slice_forces(load).sum(axis=0))


# Drawing


def _draw_row(map_axes: "Axes", profile_axes: "Axes", load: LineLoad) -> None:
    unit, factor = labels.choose_unit("N/m", load.channel, float(load.load.max()))
    _draw_map(map_axes, load, factor, axis_label(recorded.text_of(load.channel), unit))
    for number, (name, sample) in enumerate(instants(load).items()):
        line_style = {"color": COLOURS[number % len(COLOURS)], "ls": LINES[number % len(LINES)], "lw": 1.4}
        profile_axes.stairs(factor * load.load[:, sample], 1e3 * load.ends, orientation="horizontal",
                            baseline=None, label=f"{name},\n{1e3 * load.time[sample]:.3f} ms",
                            **line_style)  # fmt: skip
        map_axes.axvline(1e3 * load.time[sample], color=line_style["color"], lw=1.0, ls=line_style["ls"])
    profile_axes.set_ylim(map_axes.get_ylim())
    profile_axes.set_ylabel("z (mm)")
    profile_axes.set_xlabel(f"Line load ({unit})")
    profile_axes.set_xlim(left=0.0)
    profile_axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize=7, borderaxespad=0.0)


def _draw_map(ax: "Axes", load: LineLoad, factor: float, label: str) -> None:
    """Draw line load over time and position: white where it vanishes; the ends of the defect are dotted."""
    step = load.time[1] - load.time[0]
    edges = 1e3 * np.append(load.time - step / 2.0, load.time[-1] + step / 2.0)
    visible = np.ma.masked_less(factor * load.load, UNLOADED * factor * float(load.load.max()))
    mesh = ax.pcolormesh(edges, 1e3 * load.ends, visible, cmap=COLOUR_MAP, vmin=0.0, rasterized=True)
    for end in load.passage.defect.z if load.passage is not None else ():
        ax.axhline(1e3 * end, color="0.2", lw=0.8, ls=(0, (1, 2)))
    ax.grid(visible=False)
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel("Along the roller, z (mm)")
    assert ax.figure is not None
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.set_label(textwrap.fill(label, LABEL_CHARACTERS), fontsize=8.0)
    bar.ax.yaxis.set_label_position("left")  # the sections are on its right


def _draw_tilts(ax: "Axes", legend_axes: "Axes", map_axes: "Axes", load: LineLoad) -> None:
    """Draw tilt and skew over the time axis of the map above."""
    largest = max(float(np.max(np.abs(values))) for values in load.tilts.values())
    unit, factor = labels.choose_unit("rad", "tilt", largest)
    for name, values in load.tilts.items():
        ax.plot(1e3 * load.time, factor * values, color=TILTS[name], lw=1.2, label=name)
    if factor * largest < 1.0:  # less than one of the smallest unit is rounding
        ax.set_ylim(-1.0, 1.0)
    ax.set_xlim(map_axes.get_xlim())
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel(f"Tilt, skew ({unit})" if len(load.tilts) > 1 else axis_label(next(iter(load.tilts)), unit))
    ax.yaxis.set_major_formatter(NumberFormatter())
    legend_axes.set_axis_off()
    legend_axes.legend(*ax.get_legend_handles_labels(), loc="upper left", fontsize=7, borderaxespad=0.0)
