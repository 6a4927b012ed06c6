"""Features of many named cases, one under the other: names on the left, a column of values per feature."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine

from bearingsim.plots import labels, select
from bearingsim.plots.style import CurveStyle
from bearingsim.plots.sweep import (
    STATUS_MARKS,
    Curve,
    axis_label,
    curves_of,
    finish,
    legend_entries,
    legend_width,
    letter,
    mark_chaotic,
    styles_of_curves,
    ticks_between,
)
from bearingsim.study import Figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

MAX_UPRIGHT, MAX_LETTERS = 6, 36  # names, and letters of all of them, that find room below an axis
COLUMN_IN, LINE_IN, CHARACTER_IN = 2.3, 0.22, 0.072
LABEL_LETTERS = 30  # of an axis label, in a line
SPREAD = 0.5  # of the distance between names, over which several curves are spread
ROOM = 0.22  # of the axis' length, for the number beside the last point


def are_many(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]) -> bool:
    """Check if the words on x are too many, or too long, to be written below an axis."""
    categories = select.values(rows, figure.x)
    letters = sum(len(labels.value_text(figure.x, value, units)) for value in categories)
    return not select.is_numeric(categories) and (len(categories) > MAX_UPRIGHT or letters > MAX_LETTERS)


def draw(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str], caption: Sequence[str]) -> Canvas:
    """Draw a completed figure with words on x lying down: a point per case, first case on top.

    A column of axes per y, a row per panel, a colour per combination of `by`; a single curve's points carry their
    numbers. Arguments as of ``sweep.draw``.
    """
    names = select.values(rows, figure.x)
    panels = list(select.splits(rows, figure.panels, units))
    styles = styles_of_curves(figure, rows, units)
    entries = legend_entries(figure, styles, rows)
    longest = max(len(name) for name in names)
    width = (
        len(figure.y) * COLUMN_IN
        + CHARACTER_IN * longest
        + 0.4
        + (legend_width(entries) + 0.6 if entries else 0.0)
    )
    height = len(panels) * (LINE_IN * len(names) + 0.75) + 0.3
    canvas = Canvas(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05))
    axes = canvas.subplots(len(panels), len(figure.y), sharex="col", sharey=True, squeeze=False)
    order = {name: place for place, name in enumerate(names)}
    for row, (text, part) in enumerate(panels):
        for column, feature in enumerate(figure.y):
            ax = axes[row][column]
            _panel(ax, feature, figure, rows, curves_of(figure, part, units, styles, order), order)
            letter(ax, row * len(figure.y) + column, len(panels) * len(figure.y), text)
    corner = axes[0][0]
    corner.set_yticks(range(len(names)), [labels.value_text(figure.x, name, units) for name in names])
    corner.set_ylim(len(names) - 0.5, -0.5)
    if entries:
        canvas.legend(handles=entries, loc="outside right upper")
    finish(canvas, figure.title, caption)
    return canvas


def _panel(
    ax: "Axes", name: str, figure: Figure, rows: "pd.DataFrame", curves: list[Curve], order: Mapping[str, int]
) -> None:
    """Draw the points of one feature, a row per category."""
    unit, factor = labels.feature_axis(name, float(rows[name].abs().max()))
    ax.set_xlabel(textwrap.fill(axis_label(labels.feature_text(name), unit), LABEL_LETTERS), fontsize=8.0)
    is_log = "y" in figure.log and not name.endswith(".phase")
    for number, curve in enumerate(curves):
        aside = SPREAD * ((number + 0.5) / len(curves) - 0.5) if len(curves) > 1 else 0.0
        places = [order[value] + aside for value in curve.rows[figure.x]]
        points = list(curve.rows[name] * factor)
        look: CurveStyle = curve.look._replace(line="")
        ax.plot(points, places, **look.keywords())
        mark_chaotic(ax, points, places, curve.rows, name)
        if len(curves) == 1:
            _numbers(ax, points, places, is_log)
        _mark_lost(ax, places, list(curve.rows["status"]))
    _value_axis(ax, name, is_log)
    ax.grid(visible=False, axis="x")


def _numbers(ax: "Axes", points: Sequence[float], places: Sequence[float], is_log: bool) -> None:
    """Write its value right of each point, or at the axis if a log axis cannot show it."""
    for value, place in zip(points, places, strict=True):
        if value > 0.0 or (value == value and not is_log):
            ax.annotate(
                f"{value:.3g}", (value, place), (5, 0), textcoords="offset points", va="center", fontsize=7
            )
        elif value == 0.0:
            ax.annotate("0", (0.0, place), (3, 0), xycoords=("axes fraction", "data"),
                        textcoords="offset points", va="center", fontsize=7)  # fmt: skip


def _mark_lost(ax: "Axes", places: Sequence[float], status: Sequence[str]) -> None:
    """Mark jobs without a result on the left axis."""
    for kind, (marker, colour, _) in STATUS_MARKS.items():
        where = [place for place, state in zip(places, status, strict=True) if state == kind]
        if where:
            ax.plot([0.02] * len(where), where, marker, transform=ax.get_yaxis_transform(), color=colour,
                    markersize=6, markeredgewidth=1.5)  # fmt: skip


def _value_axis(ax: "Axes", name: str, is_log: bool) -> None:
    """Set scale, limits and ticks of the value axis, with room for the number of the largest value."""
    if is_log:
        ax.set_xscale("log", nonpositive="mask")
        ticks_between(ax.xaxis, ax.dataLim.minposx, ax.dataLim.x1)
        low, high = ax.get_xlim()
        ax.set_xlim(low, high * (high / low) ** ROOM)
    elif name.endswith(".phase"):
        ax.set_xlim(-190.0, 190.0)
        ax.set_xticks(range(-180, 181, 90))
    else:
        ax.set_xlim(0.0, ax.get_xlim()[1] * (1.0 + ROOM))
        ax.xaxis.set_major_formatter(lambda value, _: labels.number_text(value))
