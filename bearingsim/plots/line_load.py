"""Load along a roller: over time and place while it passes a pit, and its distribution at a few instants."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.config.names import LINE_LOADS, roller_of
from bearingsim.plots import labels, lines, recorded, select
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.passage import Passage, first_passage
from bearingsim.plots.pit_shape import Reals, ends_of_slices
from bearingsim.plots.recorded import Job
from bearingsim.plots.style import COLOURS, LINES
from bearingsim.plots.sweep import axis_label, finish

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.config import Case
    from bearingsim.store import Results

__all__ = ["LoadAlong", "draw_load", "instants"]

ROW_IN, LEAN_IN, PICTURE_IN, PROFILE_IN = 2.5, 1.3, 4.2, 2.6
SCALE = "YlOrRd"
UNLOADED = 0.02  # of the largest line load: what is less is drawn as none
WITHOUT_PIT = 8.0  # ball passes shown of a roller that passes none
FEW = 10.0  # samples over a pit, below which the caption tells how many
LABEL_LETTERS = 30
MIN_SAMPLES = 4
LEANS = {"tilt": COLOURS[0], "skew": COLOURS[1]}
ADVICE = "add `roller.outer_line_load` to `record`, with `model: spatial`"


class LoadAlong(NamedTuple):
    """What is drawn of a job: time (n,) in s, line load (slices, n) in N/m, ends of the slices (m), passage.

    leans: tilt and skew (n,) in rad of the same roller, as far as they were recorded.
    """

    channel: str
    time: Reals
    load: Reals
    ends: Reals
    passage: Passage | None
    leans: dict[str, Reals]


def draw_load(results: "Results", jobs: Sequence[str], y: Sequence[str] = (), span: float | None = None) -> Canvas:
    """Line load along a roller, a row per job and channel: a picture over time, and sections through it.

    Below it the roller's tilt and skew, where they were recorded. ``span``: so much time (s) around the roller's
    first passage over a pit. Raises PlotError for what was not recorded.
    """
    found = recorded.all_jobs(results, jobs)
    rows = [(job, one) for job, known in found.items() for one in _loads(results, job, known, y, span)]
    heights = [height for _, one in rows for height in (ROW_IN, *([LEAN_IN] if one.leans else []))]
    canvas = Canvas(figsize=(PICTURE_IN + PROFILE_IN + 2.4, sum(heights) + 0.8), layout="constrained")
    made = canvas.subplots(
        len(heights), 2, squeeze=False, width_ratios=[PICTURE_IN, PROFILE_IN], height_ratios=heights
    )
    axes = iter(made)
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    for job, one in rows:
        picture, profile = next(axes)
        _draw_row(picture, profile, one)
        picture.set_title(labels.described(swept[job], results.plan["units"]), loc="left", fontsize=8)
        if one.leans:
            below, beside = next(axes)
            _draw_leans(below, beside, picture, one)
    table = select.case_rows(results)
    said = fixed_values(results, table[table["job"].isin(jobs)], set().union(*swept.values()))
    finish(canvas, None, [*_notes(found, rows), *said])
    return canvas


def _notes(found: Mapping[str, Job], rows: Sequence[tuple[str, LoadAlong]]) -> list[str]:
    """What must be known of the passages: few samples over a pit, or none at all."""
    crossed = [(job, one.passage) for job, one in rows if one.passage is not None]
    counts = [passage.samples(found[job].known["sampling"]) for job, passage in crossed]
    few = [f"only {min(counts):.1f} samples over the pit"] if min(counts, default=FEW) < FEW else []
    missed = any(one.passage is None and lines.races(found[job].known) for job, one in rows)
    return [*few, *(["a roller passes no pit of a race within the record"] if missed else [])]


# What is drawn


def _loads(
    results: "Results", job: str, known: Job, asked: Sequence[str], span: float | None
) -> Iterator[LoadAlong]:
    """The line loads of a job that are asked for, or all that it has recorded."""
    case = recorded.case_of(results, job, known.known)
    ends = ends_of_slices(case)
    for channel in [_full(name) for name in asked] or _recorded(job, known):
        load = _rows(job, known, channel, len(ends) - 1)
        number, quantity = roller_of(channel) or (1, "")
        passage = first_passage(known, case, number, quantity.partition("_")[0])
        start, stop = _window(case, known, passage, span)
        time = known.series.time
        shown = (time >= start) & (time <= stop)
        if np.count_nonzero(shown) < MIN_SAMPLES:
            raise labels.PlotError(
                f"job {job} has {np.count_nonzero(shown)} samples in that time: raise `sampling`"
            )
        leans = {name: values[shown] for name, values in _leans(known, number)}
        yield LoadAlong(channel, time[shown], load[:, shown], ends, passage, leans)


def _leans(known: Job, number: int) -> Iterator[tuple[str, Reals]]:
    """Tilt and skew (rad) of a roller, if they were recorded."""
    for name in LEANS:
        channel = recorded.recorded_as(f"roller.{number}.{name}", known.recorded)
        if channel:
            yield name, np.asarray(known.series.channels[channel], np.float64)


def _full(name: str) -> str:
    """`roller.outer_line_load` is the first roller's."""
    return name.replace("roller.", "roller.1.", 1) if name in (f"roller.{kind}" for kind in LINE_LOADS) else name


def _recorded(job: str, known: Job) -> list[str]:
    """The line loads that a job has recorded, without the slices' numbers."""
    found = dict.fromkeys(name.rpartition(".")[0] for name in known.recorded if "_line_load." in name)
    if not found:
        raise labels.PlotError(f"job {job} has recorded no load along a roller: {ADVICE}")
    return list(found)


def _rows(job: str, known: Job, channel: str, count: int) -> Reals:
    """The line load (N/m) of every slice (slices, n). Raises PlotError if some were not recorded."""
    names = [f"{channel}.{number}" for number in range(1, count + 1)]
    missing = sum(name not in known.series.channels for name in names)
    if count < 1 or missing == count:
        advice = ADVICE.replace("roller.outer_line_load", channel)
        raise labels.PlotError(f"job {job} has recorded no `{channel}`: {advice}")
    if missing:
        raise labels.PlotError(
            f"job {job} has recorded {count - missing} of {count} slices: add `{channel}`, which means all of them"
        )
    return np.stack([np.asarray(known.series.channels[name], np.float64) for name in names])


def _window(case: "Case", known: Job, passage: Passage | None, span: float | None) -> tuple[float, float]:
    """From when to when (s) is shown."""
    if passage is None:
        rate = case.bearing.ball_pass_frequency(case.speed)
        return 0.0, span or min(WITHOUT_PIT / rate, float(known.known["duration"]))
    start, stop = passage.window
    if span is None:
        return start, stop
    before = (passage.time - start) / (stop - start) * span
    return passage.time - before, passage.time - before + span


def instants(one: LoadAlong) -> dict[str, int]:
    """The samples whose distributions are drawn, by name.

    Over the pit: in the middle of when the slices over it carry least. The largest: of the roller's whole load
    from then on. Without a pit: the largest and the least load.
    """
    whole = _whole(one)
    if one.passage is None:
        return {"largest load": int(np.argmax(whole)), "least load": int(np.argmin(whole))}
    low, high = one.passage.pit.z
    middles = (one.ends[1:] + one.ends[:-1]) / 2.0
    inside = np.maximum(_share(one)[(middles > low) & (middles < high)].sum(axis=0), 0.0)
    least = np.flatnonzero(inside <= inside.min() + UNLOADED * inside.max())
    over = int(least[len(least) // 2])
    largest = over + int(np.argmax(whole[over:]))
    return {"before": 0, "over the pit": over, "largest after": largest, "after": len(one.time) - 1}


def _share(one: LoadAlong) -> Reals:
    """Force (N) of each slice."""
    return one.load * np.diff(one.ends)[:, np.newaxis]


def _whole(one: LoadAlong) -> Reals:
    """Force (N) of the whole roller."""
    return np.asarray(_share(one).sum(axis=0))


# Drawing


def _draw_row(picture: "Axes", profile: "Axes", one: LoadAlong) -> None:
    unit, factor = labels.readable("N/m", one.channel, float(one.load.max()))
    _draw_picture(picture, one, factor, axis_label(recorded.text_of(one.channel), unit))
    for number, (name, at) in enumerate(instants(one).items()):
        look = {"color": COLOURS[number % len(COLOURS)], "ls": LINES[number % len(LINES)], "lw": 1.4}
        profile.stairs(factor * one.load[:, at], 1e3 * one.ends, orientation="horizontal", baseline=None,
                       label=f"{name},\n{1e3 * one.time[at]:.3f} ms", **look)  # fmt: skip
        picture.axvline(1e3 * one.time[at], color=look["color"], lw=1.0, ls=look["ls"])
    profile.set_ylim(picture.get_ylim())
    profile.set_ylabel("z (mm)")
    profile.set_xlabel(f"Line load ({unit})")
    profile.set_xlim(left=0.0)
    profile.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize=7, borderaxespad=0.0)


def _draw_picture(ax: "Axes", one: LoadAlong, factor: float, label: str) -> None:
    """Line load over time and place; white where the roller is lifted; the pit's ends dotted."""
    step = one.time[1] - one.time[0]
    edges = 1e3 * np.append(one.time - step / 2.0, one.time[-1] + step / 2.0)
    seen = np.ma.masked_less(factor * one.load, UNLOADED * factor * float(one.load.max()))
    made = ax.pcolormesh(edges, 1e3 * one.ends, seen, cmap=SCALE, vmin=0.0, rasterized=True)
    for end in one.passage.pit.z if one.passage is not None else ():
        ax.axhline(1e3 * end, color="0.2", lw=0.8, ls=(0, (1, 2)))
    ax.grid(visible=False)
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel("Along the roller, z (mm)")
    assert ax.figure is not None
    bar = ax.figure.colorbar(made, ax=ax, pad=0.02)
    bar.set_label(textwrap.fill(label, LABEL_LETTERS), fontsize=8.0)
    bar.ax.yaxis.set_label_position("left")  # on its right there are the sections


def _draw_leans(ax: "Axes", beside: "Axes", picture: "Axes", one: LoadAlong) -> None:
    """Tilt and skew over the time of the picture above."""
    largest = max(float(np.max(np.abs(values))) for values in one.leans.values())
    unit, factor = labels.readable("rad", "tilt", largest)
    for name, values in one.leans.items():
        ax.plot(1e3 * one.time, factor * values, color=LEANS[name], lw=1.2, label=name)
    if factor * largest < 1.0:  # of the smallest unit: rounding
        ax.set_ylim(-1.0, 1.0)
    ax.set_xlim(picture.get_xlim())
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel(f"Tilt, skew ({unit})" if len(one.leans) > 1 else axis_label(next(iter(one.leans)), unit))
    ax.yaxis.set_major_formatter(lambda value, _: labels.number_text(value))
    beside.set_axis_off()
    beside.legend(*ax.get_legend_handles_labels(), loc="upper left", fontsize=7, borderaxespad=0.0)
