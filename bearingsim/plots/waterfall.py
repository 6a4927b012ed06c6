"""Spectra stacked over a swept parameter."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import axis_label, finish
from bearingsim.plots.caption import fixed_values, following_parameters, rounding_texts, sampling_texts
from bearingsim.plots.labels import PlotError
from bearingsim.plots.marks import mark_lines, share_lines
from bearingsim.plots.sheet import Sheet
from bearingsim.plots.spectra import compute_spectrum, frequency_range
from bearingsim.plots.style import COLOURS, COLUMN_IN
from bearingsim.plots.units import choose_scale

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.plots.recorded import Job
    from bearingsim.store import Results
    from bearingsim.study import Figure

SPACING = 0.5  # offset of adjacent curves, relative to the largest value, or to the range of a curve of levels
SPACING_DB = 25.0  # dB, minimum distance of the medians of adjacent curves of levels
ROW_IN, MIN_IN = 0.32, 2.2  # height per curve, and minimum height of axes
MIN_SPECTRA = 3  # minimum number of spectra
LINE_WIDTH = 0.9


def draw_waterfall(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the stacked spectra of jobs, ordered by the swept parameter `by`, in subplots by the other parameters.

    Raises PlotError without a swept parameter, or for fewer than ``MIN_SPECTRA`` spectra.
    """
    from bearingsim import signals

    units = results.plan["units"]
    table = select.case_rows(results).set_index("job").loc[list(jobs)].reset_index()
    select.check_paths(figure.by, units)
    varied = select.varied_paths(table, list(units))
    path = _stacked_path(figure, varied, table)
    others = [other for other in varied if other != path and not select.follows(other, [path], table)]
    groups = [(title, _sort(rows, path)) for title, rows in select.split_rows(table, others, units)]
    if max(len(rows) for _, rows in groups) < MIN_SPECTRA:
        raise PlotError(f"a waterfall needs {MIN_SPECTRA} spectra or more over `{path}`; use `--kind spectrum`")
    records = recorded.load_jobs(results, jobs)
    channel = recorded.channels_for(records, figure.y)[0]
    limits = frequency_range(figure, records.values())
    spectra = {
        name: compute_spectrum(signals.spectrum, next(recorded.signals_of(job, channel)), limits, name, job)
        for name, job in records.items()
    }
    largest = max(float(np.max(amplitude)) for _, amplitude in spectra.values())
    scale = choose_scale(recorded.unit_of(channel), channel, largest, figure.view)
    axes_height = max(MIN_IN, ROW_IN * max(len(rows) for _, rows in groups))
    canvas = Canvas(figsize=(2 * COLUMN_IN, axes_height * len(groups) + 0.9), layout="constrained")
    axes = canvas.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    curves = {name: (frequency, scale.to_axis(amplitude)) for name, (frequency, amplitude) in spectra.items()}
    baselines = {name: float(np.median(level)) if figure.view.db else 0.0 for name, (_, level) in curves.items()}
    step = SPACING * scale.factor * largest
    if figure.view.db:
        medians = [[baselines[name] for name in rows["job"]] for _, rows in groups]
        step = _offset_db(medians, max(float(np.ptp(level)) for _, level in curves.values()))
    marked: list[Job] = []
    for ax, (title, rows) in zip(axes, groups, strict=True):
        names = list(rows["job"])
        lowest = min(row * step + float(np.min(curves[name][1])) for row, name in enumerate(names))
        floor = lowest if figure.view.db else 0.0
        _draw_stack(ax, [curves[name] for name in names], step, floor)
        ax.set_yticks([row * step + baselines[name] - floor for row, name in enumerate(names)],
                      [labels.value_text(path, value, units) for value in rows[path]])  # fmt: skip
        ax.set_ylabel(axis_label(labels.name_text(path), ""))
        ax.set_title(title, loc="left", fontsize=8, pad=11 if ax is axes[0] else 4)
        ax.set_xlim(*limits)
        selected = [records[name] for name in names]
        if share_lines(selected):
            mark_lines(ax, selected[0], named=not marked or not share_lines([marked[-1], selected[0]]))
            marked.append(selected[0])
    axes[-1].set_xlabel("Frequency (Hz)")
    text = recorded.text_of(channel)
    offset = f"{step:.4g} dB" if figure.view.db else f"{labels.number_text(step, 3)} {scale.unit}"
    caption = [f"amplitude spectrum of the {text[:1].lower()}{text[1:]}, 0-peak, curves offset by {offset}"]
    fixed = fixed_values(results, table, {path, *others})
    tied = following_parameters(replace(figure, x="", by=(path,), panels=tuple(others)), table, units)
    texts = [*rounding_texts(results, records, [channel]), *sampling_texts(records.values(), [channel])]
    finish(canvas, figure.title, [*caption, *texts, *fixed, *tied])
    return [Sheet(["waterfall", channel, "over", path], canvas)]


def _sort(rows: "pd.DataFrame", path: str) -> "pd.DataFrame":
    """Sort the rows by a path with numbers; leave those of words in the order of the study."""
    return rows.sort_values(path) if select.is_numeric(select.distinct_values(rows, path)) else rows


def _offset_db(medians: Sequence[Sequence[float]], tallest: float) -> float:
    """Return the offset (whole dB) of adjacent curves: SPACING of the range of the tallest, or more.

    The median of each curve is SPACING_DB or more above that of the one below. medians: levels (dB) of the curves
    of each subplot, from below; tallest: largest range of a curve (dB).
    """
    drops = [below - above for levels in medians for below, above in pairwise(levels)]
    return float(ceil(round(max(SPACING * tallest, SPACING_DB + max([0.0, *drops])), 3)))


def _draw_stack(ax: "Axes", curves: Sequence[tuple[np.ndarray, np.ndarray]], step: float, floor: float) -> None:
    """Draw curves (x and y, (n,) each) from below, offset by ``step`` from -floor; each hides those behind its
    peaks."""
    for row, (frequency, level) in enumerate(curves):
        curve = row * step + level - floor
        order = 2.0 + 2.0 * (len(curves) - row) / len(curves)
        ax.fill_between(frequency, float(np.min(curve)), curve, color="white", zorder=order, lw=0.0)
        ax.plot(frequency, curve, color=COLOURS[0], lw=LINE_WIDTH, zorder=order)


def _stacked_path(figure: "Figure", varied: Sequence[str], rows: "pd.DataFrame") -> str:
    """Return the path over which spectra are stacked: `by`, else the one of numbers with the most values."""
    if len(figure.by) > 1:
        raise PlotError("a waterfall is stacked over one swept parameter: give `by` once")
    if figure.by:
        return figure.by[0]
    numeric = [path for path in varied if select.is_numeric(select.distinct_values(rows, path))]
    if not numeric:
        raise PlotError("no swept numeric parameter varies in these jobs; use `--kind spectrum`")
    return max(numeric, key=lambda path: len(select.distinct_values(rows, path)))
