"""Spectra stacked over a swept parameter."""

import math
from collections.abc import Sequence
from dataclasses import replace
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

    from bearingsim.plots.recorded import Job
    from bearingsim.store import Results
    from bearingsim.study import Figure

SPACING = 0.5  # distance of the curves' zero lines, relative to the largest value, or to the range of levels
SPACING_DB = 5.0  # dB, of which the distance of the curves of levels is a multiple
ROW_IN, MIN_IN = 0.32, 2.2  # height per curve, and minimum height of axes
MIN_SPECTRA = 3  # minimum number of spectra
LINE_WIDTH = 0.9


def draw_waterfall(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the spectra of jobs above each other, ordered by the swept path `by`, in axes by the other paths.

    Raises PlotError without a swept path, or for fewer than ``MIN_SPECTRA`` spectra.
    """
    from bearingsim import signals

    units = results.plan["units"]
    table = select.case_rows(results).set_index("job").loc[list(jobs)].reset_index()
    select.check_paths(figure.by, units)
    varied = select.varied_paths(table, list(units))
    path = _stacked_path(figure, varied, table)
    others = [other for other in varied if other != path and not select.follows(other, [path], table)]
    groups = list(select.split_rows(table, others, units))
    records = recorded.load_jobs(results, jobs)
    channel = recorded.channels_for(records, figure.y)[0]
    limits = frequency_range(figure, records.values())
    spectra = {
        name: compute_spectrum(signals.spectrum, next(recorded.signals_of(job, channel)), limits, name, job)
        for name, job in records.items()
    }
    if max(len(rows) for _, rows in groups) < MIN_SPECTRA:
        raise PlotError(f"a waterfall needs {MIN_SPECTRA} spectra or more over `{path}`; use `--kind spectrum`")
    largest = max(float(np.max(amplitude)) for _, amplitude in spectra.values())
    scale = choose_scale(recorded.unit_of(channel), channel, largest, figure.view)
    axes_height = max(MIN_IN, ROW_IN * max(len(rows) for _, rows in groups))
    canvas = Canvas(figsize=(2 * COLUMN_IN, axes_height * len(groups) + 0.9), layout="constrained")
    axes = canvas.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    step = _distance([scale.to_axis(amplitude) for _, amplitude in spectra.values()], figure.view.db)
    marked: list[Job] = []
    for ax, (title, rows) in zip(axes, groups, strict=True):
        ordered = rows.sort_values(path) if select.is_numeric(select.distinct_values(rows, path)) else rows
        names = list(ordered["job"])
        floor = min(float(np.min(scale.to_axis(spectra[name][1]))) for name in names) if figure.view.db else 0.0
        for number, name in enumerate(names):
            frequency, amplitude = spectra[name]
            bottom = number * step
            curve = bottom + scale.to_axis(amplitude) - floor
            order = 2.0 + 2.0 * (len(names) - number) / len(names)
            ax.fill_between(frequency, bottom, curve, color="white", zorder=order, lw=0.0)
            ax.plot(frequency, curve, color=COLOURS[0], lw=LINE_WIDTH, zorder=order)
        ax.set_yticks([number * step for number in range(len(names))],
                      [labels.value_text(path, value, units) for value in ordered[path]])  # fmt: skip
        ax.set_ylabel(axis_label(labels.name_text(path), ""))
        ax.set_title(title, loc="left", fontsize=8, pad=11 if ax is axes[0] else 4)
        ax.set_xlim(*limits)
        selected = [records[name] for name in names]
        if share_lines(selected):
            mark_lines(ax, selected[0], named=not marked or not share_lines([marked[-1], selected[0]]))
            marked.append(selected[0])
    axes[-1].set_xlabel("Frequency (Hz)")
    text = recorded.text_of(channel)
    distance = f"{step:.4g} dB" if figure.view.db else f"{labels.number_text(step, 3)} {scale.unit}"
    caption = [f"amplitude spectrum of the {text[:1].lower()}{text[1:]}, 0-peak, {distance} between two lines"]
    fixed = fixed_values(results, table, {path, *others})
    tied = following_parameters(replace(figure, x="", by=(path,), panels=tuple(others)), table, units)
    texts = [*rounding_texts(results, records, [channel]), *sampling_texts(records.values(), [channel])]
    finish(canvas, figure.title, [*caption, *texts, *fixed, *tied])
    return [Sheet(["waterfall", channel, "over", path], canvas)]


def _distance(curves: Sequence[np.ndarray], are_levels: bool) -> float:
    """Return the distance of the zero lines of curves, in the unit of the axis.

    A curve of levels (dB) rises from the floor of all curves, not from zero.
    """
    largest = max(float(np.max(curve)) for curve in curves)
    if not are_levels:
        return SPACING * largest
    lowest = min(float(np.min(curve)) for curve in curves)
    return SPACING_DB * max(1.0, math.ceil(SPACING * (largest - lowest) / SPACING_DB))


def _stacked_path(figure: "Figure", varied: Sequence[str], rows: "pd.DataFrame") -> str:
    """Return the path over which spectra are stacked: `by`, else the numeric path with the most values."""
    if len(figure.by) > 1:
        raise PlotError("a waterfall is stacked over one swept path: give `by` once")
    if figure.by:
        return figure.by[0]
    numbers = [path for path in varied if select.is_numeric(select.distinct_values(rows, path))]
    if not numbers:
        raise PlotError("no swept number varies in these jobs; use `--kind spectrum`")
    return max(numbers, key=lambda path: len(select.distinct_values(rows, path)))
