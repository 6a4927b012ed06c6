"""Features against the parameters of a design: a point per job, with running median and quartiles.

All parameters of a design vary at once, so the points over one parameter scatter because of the others. The median
of neighbouring points shows the effect of the parameter itself; the band around it, that of the others.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import NDArray

from bearingsim.plots.axes import (
    BAND_ALPHA,
    ROW_IN,
    Curve,
    curves_of,
    draw_panels,
    finish,
    label_panel,
    legend_entries,
    mark_chaotic,
    mark_jobs_without_result,
    refuse_without_values,
    set_x_axis,
    set_y_axis,
    styles_of_curves,
    x_label,
    y_label,
)
from bearingsim.plots.points import positions
from bearingsim.plots.style import COLUMN_IN, PAGE_IN
from bearingsim.plots.units import choose_feature_scale
from bearingsim.study import Figure
from bearingsim.study.design import COUNT_NOUNS

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

MIN_POINTS = 24  # minimum number of points for medians
MAX_LEVELS = 12  # distinct values on x up to which each has its own median
MAX_GROUPS = 20  # largest number of groups of neighbouring points
MIN_LOG_RATIO = 5.0  # minimum ratio of the limits of a log axis
MAX_COLUMNS = 3  # largest number of panels in a row
POINT_STYLE: dict[str, Any] = {"linestyle": "", "markersize": 3.0, "alpha": 0.55, "markeredgewidth": 0.5}
TREND_TEXTS = ("line: running median", "band: quartiles")


class Trend(NamedTuple):
    """Groups of neighbouring points: their position on x, median, lower and upper quartile."""

    x: NDArray[np.float64]
    median: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def compute_trend(x: Sequence[float], y: Sequence[float]) -> Trend | None:
    """Compute medians and quartiles of groups of about sqrt(n) of n points, or of each level of x if x has few.

    Returns None for fewer than ``MIN_POINTS`` points, whose medians would be dominated by chance, or for one
    level.
    """
    finite = [(a, b) for a, b in zip(x, y, strict=True) if math.isfinite(a * b)]
    if len(finite) < MIN_POINTS:
        return None
    points = np.array(sorted(finite))
    levels = np.unique(points[:, 0])
    if len(levels) < 2:
        return None
    if len(levels) <= MAX_LEVELS:
        groups = [points[points[:, 0] == level] for level in levels]
    else:
        groups = np.array_split(points, min(MAX_GROUPS, math.isqrt(len(points))))
    centres = np.array([np.median(group[:, 0]) for group in groups])
    low, median, high = np.array([np.percentile(group[:, 1], (25, 50, 75)) for group in groups]).T
    return Trend(centres, median, low, high)


def trend_texts(
    figure: Figure, paths: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str]
) -> tuple[str, ...]:
    """Return ``TREND_TEXTS`` if a curve of a completed figure over one of some paths has medians."""
    drawn = [*figure.by, *figure.panels]
    curves = [part for _, part in rows.groupby(drawn, dropna=False)] if drawn else [rows]
    has_trend = any(
        compute_trend(positions(path, part, rows, units), list(part[name])) is not None
        for part in curves
        for name in figure.y
        for path in paths
    )
    return TREND_TEXTS if has_trend else ()


def describe_design(design: Mapping[str, Any]) -> str:
    """Describe a design in a caption: `sobol design of 64 points, seed 1`, and how many are drawn if not all."""
    drawn = f"{len(design['ids'])} of " * (len(design["ids"]) < design["n"])
    return f"{design['kind']} design of {drawn}{design['n']} {COUNT_NOUNS[design['kind']]}, seed {design['seed']}"


def draw(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str], caption: Sequence[str]) -> Canvas:
    """Draw a completed figure as a scatter plot; arguments as of ``axes.draw_panels``."""

    def panel(ax: "Axes", name: str, part: "pd.DataFrame") -> None:
        _panel(ax, name, figure, rows, part, units)

    return draw_panels(figure, rows, units, caption, panel)


def draw_paths(
    figure: Figure, paths: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str], caption: Sequence[str]
) -> Canvas:
    """Draw the only feature of a completed figure, a panel per path, on a common y axis."""
    [name] = figure.y
    entries = legend_entries(figure, styles_of_curves(figure, rows, units), rows)
    columns = min(MAX_COLUMNS, len(paths))
    n_rows = math.ceil(len(paths) / columns)
    width = columns * min(0.8 * COLUMN_IN, PAGE_IN / columns) + 0.55
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.06)
    canvas = Canvas(figsize=(width, n_rows * ROW_IN * 0.9 + 0.55), layout=layout)
    axes = list(canvas.subplots(n_rows, columns, sharey=True, squeeze=False).flat)
    for number, (ax, path) in enumerate(zip(axes, paths, strict=False)):
        log = (*figure.log, "x") if is_logarithmic(list(rows[path])) else figure.log
        _panel(ax, name, replace(figure, x=path, log=log), rows, rows, units)
        ax.set_xlabel(x_label(path, rows, units))
        label_panel(ax, number, len(paths), "")
        if number % columns:
            ax.set_ylabel("")
    refuse_without_values(figure, [ax.dataLim.minposy for ax in axes[: len(paths)]])
    for ax in axes[len(paths) :]:
        ax.remove()
    finish(canvas, figure.title, caption, entries)
    return canvas


def is_logarithmic(values: Sequence[float]) -> bool:
    """Check if values are spaced evenly in their logarithm.

    True if their range is wide and the median is closer to the geometric than to the arithmetic mean of the
    extremes.
    """
    low, high = min(values), max(values)
    if not 0.0 < low * MIN_LOG_RATIO <= high:
        return False
    return float(np.median(values)) < math.sqrt(math.sqrt(low * high) * (low + high) / 2.0)


def _panel(
    ax: "Axes", name: str, figure: Figure, rows: "pd.DataFrame", part: "pd.DataFrame", units: Mapping[str, str]
) -> None:
    """Draw the points of one feature over x; ``part``: those of all ``rows`` that belong to the panel."""
    scale = choose_feature_scale(name, float(rows[name].abs().max()), figure.view)
    ax.set_ylabel(y_label(name, scale.unit))
    for curve in curves_of(figure, name, part, rows, units, scale.factor):
        points = curve.points
        ax.plot(points.x, points.y, **curve.style.keywords() | POINT_STYLE)
        _draw_trend(ax, curve, compute_trend(points.x, points.y))
        mark_chaotic(ax, points.x, points.y, points.chaotic)
        mark_jobs_without_result(ax, points)
    set_x_axis(ax, figure, rows, units)
    set_y_axis(ax, name, figure)


def _draw_trend(ax: "Axes", curve: Curve, groups: Trend | None) -> None:
    if groups is not None:
        ax.fill_between(groups.x, groups.low, groups.high, color=curve.style.colour, alpha=BAND_ALPHA, lw=0.0)
        ax.plot(groups.x, groups.median, color=curve.style.colour, ls=curve.style.line, lw=1.8)
