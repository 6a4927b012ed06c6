"""Features against a swept parameter, the figures of a parametric study."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine

from bearingsim.plots import labels, overlay, select
from bearingsim.plots.axes import (
    BAND_ALPHA,
    BASELINE_STYLE,
    MODEL_MARK,
    NONE_ABOVE_ZERO,
    STATUS_MARKS,
    Curve,
    axis_label,
    curves_of,
    draw_panels,
    finish,
    is_logarithmic,
    label_panel,
    legend_entries,
    mark_chaotic,
    mark_jobs_without_result,
    models_of,
    refuse_without_values,
    set_x_axis,
    set_y_axis,
    styles_of_curves,
    write_note,
    y_label,
)
from bearingsim.plots.style import PAGE_IN
from bearingsim.plots.ticks import set_linear_ticks, set_log_ticks
from bearingsim.plots.units import ROUNDING_NOTE, choose_feature_scale
from bearingsim.store import all_zero
from bearingsim.study import Figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.store import MeasuredSet


BASELINE_COLOUR = "0.35"
BAR_POINTS = 4.0  # width of an uncertainty bar


def draw(data: overlay.FigureData, caption: Sequence[str], measured: Sequence["MeasuredSet"] = ()) -> Canvas:
    """Draw a completed figure, a line per combination of `by`, with measured points as open markers.

    caption: as of ``axes.draw_panels``.
    """
    figure, rows, units = data

    def panel(ax: "Axes", name: str, part: "pd.DataFrame") -> None:
        scale = choose_feature_scale(name, float(rows[name].abs().max()), figure.view)  # of all panels
        ax.set_ylabel(y_label(name, scale.unit))
        curves = curves_of(figure, name, part, rows, units, scale.factor)
        for curve in curves:
            points = curve.points
            ax.plot(*_break_phases(points.x, points.y, name), **curve.style.keywords())
            mark_spread(ax, curve, points.x)
            mark_errors(ax, curve, points.x, points.y)
            mark_models(ax, points.x, points.y, points.models, models_of(rows))
            mark_chaotic(ax, points.x, points.y, points.chaotic)
            mark_jobs_without_result(ax, points)
        if f"baseline {name}" in rows:
            mark_baselines(ax, curves)
        overlay.mark_measured(ax, data, name, part, curves, measured, scale.factor)
        set_x_axis(ax, figure, rows, units)
        set_y_axis(ax, name, figure)
        if all_zero(rows, name):
            write_note(ax, ROUNDING_NOTE)

    return draw_panels(figure, rows, units, caption, panel, overlay.measured_entries(data, measured))


def mark_baselines(ax: "Axes", curves: Sequence[Curve]) -> None:
    """Draw the level of the healthy bearing, dashed: one line if all curves share it, else in their colours."""
    shared = len({str((curve.points.x, curve.points.healthy)) for curve in curves}) == 1  # NaN equals NaN
    for curve in curves[:1] if shared else curves:
        colour = BASELINE_COLOUR if shared else curve.style.colour
        ax.plot(curve.points.x, curve.points.healthy, **BASELINE_STYLE, color=colour)


def mark_spread(ax: "Axes", curve: Curve, positions: Sequence[float], along: str = "y") -> None:
    """Draw the uncertainty of a feature ``along`` x or y: a band if a line joins all points, else bars."""
    points = curve.points
    has_range = [math.isfinite(value) for value in points.low]
    if all(has_range) and len(positions) > 1 and curve.style.line:
        ax.fill_between(positions, points.low, points.high, color=curve.style.colour, alpha=BAND_ALPHA, lw=0.0)
    elif any(has_range):
        bar_positions, lowest, highest = (
            [v for v, is_finite in zip(a, has_range, strict=True) if is_finite]
            for a in (positions, points.low, points.high)
        )
        bars = ax.vlines if along == "y" else ax.hlines
        bars(bar_positions, lowest, highest, color=curve.style.colour, lw=BAR_POINTS, alpha=2.0 * BAND_ALPHA)


def mark_errors(ax: "Axes", curve: Curve, x: Sequence[float], y: Sequence[float], along: str = "y") -> None:
    """Draw the error bounds of model, step and scatter as bars ``along`` an axis, if the study has an accuracy."""
    errors = curve.points.error
    bounded = [(a, b, error) for a, b, error in zip(x, y, errors, strict=True) if math.isfinite(a * b * error)]
    if bounded:
        bar_x, bar_y, lengths = zip(*bounded, strict=True)
        bars: dict[str, Any] = {f"{along}err": lengths, "ecolor": curve.style.colour}
        ax.errorbar(bar_x, bar_y, fmt="none", elinewidth=1.0, capsize=2.5, **bars)


def mark_models(
    ax: "Axes", x: Sequence[float], y: Sequence[float], models: Sequence[str], marks: Mapping[str, str]
) -> None:
    """Mark each point by its model if several were chosen."""
    for model, mark in marks.items() if len(marks) > 1 else ():
        points = zip(x, y, models, strict=True)
        chosen = [(a, b) for a, b, name in points if name == model and math.isfinite(a * b)]
        if chosen:
            ax.plot(*zip(*chosen, strict=True), zorder=5.0, **MODEL_MARK | {"marker": mark})


def _break_phases(x: Sequence[float], y: Sequence[float], name: str) -> tuple[list[float], list[float]]:
    """Return the points of a curve; phases are broken at the wrap from -180 to 180 deg."""
    points = [(x[0], y[0])]
    for point, previous in zip(zip(x[1:], y[1:], strict=True), y, strict=False):
        if name.endswith(".phase") and abs(point[1] - previous) > 180.0:
            points.append((math.nan, math.nan))
        points.append(point)
    return [a for a, _ in points], [b for _, b in points]


# Many named cases, one per line, with names on the left and a column of values per feature


MAX_NAMES, MAX_CHARACTERS = 6, 36  # largest numbers of names, and of their characters in total, below an axis
LINE_IN, LABEL_LINE_IN = 0.22, 0.15  # heights (inches) of a case, and of a line of an axis label
MIN_VALUES_IN, VALUES_IN = 1.25, 2.3  # limits of the width of a column of values
NAME_CHARACTER_IN = VALUE_CHARACTER_IN = 0.072  # inches, width of a character of a name, and of a value
CURVE_SPREAD = 0.5  # vertical spread of several curves, relative to the distance of names
LOG_MARGIN = 0.05  # additional margin before the first point, relative to the length of a log axis
NUMBER_MARGIN = 0.3  # margin for the number next to the last point, relative to the length of the axis


def has_many_names(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]) -> bool:
    """Check if the words on x are too many, or too long, to be written below an axis."""
    categories = select.distinct_values(rows, figure.x)
    characters = sum(len(labels.value_text(figure.x, value, units)) for value in categories)
    return not select.is_numeric(categories) and (len(categories) > MAX_NAMES or characters > MAX_CHARACTERS)


def draw_names(data: overlay.FigureData, caption: Sequence[str], measured: Sequence["MeasuredSet"] = ()) -> Canvas:
    """Draw a completed figure with the words of x on the vertical axis: a point per case, the first on top.

    A column of axes per y, a row per panel, a colour per combination of `by`; the points of a single curve
    are labelled with their values. Arguments as of ``draw``.
    """
    figure, rows, units = data
    names = select.distinct_values(rows, figure.x)
    panels = list(select.split_rows(rows, figure.panels, units))
    styles = styles_of_curves(figure, rows, units)
    entries = [*legend_entries(figure, styles, rows), *overlay.measured_entries(data, measured)]
    texts = [labels.value_text(figure.x, name, units) for name in names]
    names_in = NAME_CHARACTER_IN * max(map(len, texts))
    values_in = max(MIN_VALUES_IN, min(VALUES_IN, (PAGE_IN - names_in) / len(figure.y)))
    width = len(figure.y) * values_in + names_in + 0.4
    canvas = Canvas(figsize=(width, 1.0), layout=ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05))
    axes = canvas.subplots(len(panels), len(figure.y), sharex="col", sharey=True, squeeze=False)
    for row, (text, part) in enumerate(panels):
        for column, feature in enumerate(figure.y):
            ax = axes[row][column]
            _draw_values(ax, feature, data, part, measured)
            ax.set_xlabel(textwrap.fill(ax.get_xlabel(), int(values_in / VALUE_CHARACTER_IN)))
            label_panel(ax, row * len(figure.y) + column, len(panels) * len(figure.y), text)
    refuse_without_values(figure, [ax.dataLim.minposx for ax in axes.flat])
    for feature, stack in zip(figure.y, axes.T, strict=True):
        _set_value_axis(stack, feature, is_logarithmic(figure, feature))
    top_left = axes[0][0]
    top_left.set_yticks(range(len(names)), texts)
    top_left.set_ylim(len(names) - 0.5, -0.5)
    label_lines = 1 + max(ax.get_xlabel().count("\n") for ax in axes.flat)
    canvas.set_figheight(len(panels) * (LINE_IN * len(names) + LABEL_LINE_IN * label_lines + 0.6) + 0.3)
    finish(canvas, figure.title, caption, entries)
    return canvas


def _draw_values(
    ax: "Axes", name: str, data: overlay.FigureData, part: "pd.DataFrame", measured: Sequence["MeasuredSet"]
) -> None:
    """Draw the points of one feature, a row per category; part: rows of the panel."""
    figure, rows, units = data
    scale = choose_feature_scale(name, float(rows[name].abs().max()), figure.view)
    ax.set_xlabel(axis_label(labels.feature_text(name), scale.unit), fontsize=8.0)
    if all_zero(rows, name):
        write_note(ax, ROUNDING_NOTE)
    is_log = is_logarithmic(figure, name)
    curves = curves_of(figure, name, part, rows, units, scale.factor)
    for number, curve in enumerate(curves):
        shift = CURVE_SPREAD * ((number + 0.5) / len(curves) - 0.5) if len(curves) > 1 else 0.0
        values, heights = curve.points.y, [rank + shift for rank in curve.points.x]
        ax.plot(values, heights, **curve.style.keywords())
        mark_spread(ax, curve, heights, along="x")
        mark_errors(ax, curve, values, heights, along="x")
        mark_models(ax, values, heights, curve.points.models, models_of(rows))
        mark_chaotic(ax, values, heights, curve.points.chaotic)
        if len(curves) == 1:
            _write_numbers(ax, values, heights, is_log)
        _mark_jobs_without_result_left(ax, heights, curve.points.status)
    overlay.mark_measured(ax, data, name, part, curves, measured, scale.factor, upright=True)
    ax.grid(visible=False, axis="x")


def _write_numbers(ax: "Axes", points: Sequence[float], heights: Sequence[float], is_log: bool) -> None:
    """Write the value of each point to its right, or at the axis if a log axis cannot show it."""
    for value, height in zip(points, heights, strict=True):
        if value > 0.0 or (value == value and not is_log):
            ax.annotate(
                labels.number_text(value, 3),
                (value, height),
                (5, 0),
                textcoords="offset points",
                va="center",
                fontsize=7,
            )
        elif value == 0.0:
            ax.annotate("0", (0.0, height), (3, 0), xycoords=("axes fraction", "data"),
                        textcoords="offset points", va="center", fontsize=7)  # fmt: skip


def _mark_jobs_without_result_left(ax: "Axes", heights: Sequence[float], status: Sequence[str]) -> None:
    """Mark jobs without a result on the left axis."""
    for kind, (marker, colour, _) in STATUS_MARKS.items():
        where = [height for height, state in zip(heights, status, strict=True) if state == kind]
        if where:
            ax.plot([0.02] * len(where), where, marker, transform=ax.get_yaxis_transform(), color=colour,
                    markersize=6, markeredgewidth=1.5)  # fmt: skip


def _set_value_axis(stack: Sequence["Axes"], name: str, is_log: bool) -> None:
    """Set scale, limits and ticks of the value axis that panels share, with a margin for the number of the largest
    value."""
    ax = stack[0]
    if is_log:
        smallest = min(panel.dataLim.minposx for panel in stack)
        if not math.isfinite(smallest):
            ax.set_xlim(0.1, 1.0)  # else matplotlib warns
            ax.set_xscale("log")
            ax.xaxis.set_tick_params(which="both", bottom=False, labelbottom=False)
            write_note(ax, NONE_ABOVE_ZERO, 0.5)
            return
        ax.set_xscale("log", nonpositive="mask")
        set_log_ticks(ax.xaxis, smallest, max(panel.dataLim.x1 for panel in stack))
        low, high = ax.get_xlim()
        ax.set_xlim(low * (high / low) ** -LOG_MARGIN, high * (high / low) ** NUMBER_MARGIN)
    elif name.endswith(".phase"):
        ax.set_xlim(-190.0, 190.0)
        ax.set_xticks(range(-180, 181, 90))
    else:
        low, high = ax.get_xlim()
        low = low if min(panel.dataLim.x0 for panel in stack) < 0.0 else 0.0
        ax.set_xlim(low, high + NUMBER_MARGIN * (high - low))
        set_linear_ticks(ax.xaxis)
