"""Common axes of the figures of features: frame, curves, marks, scales, texts."""

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from bearingsim.plots import labels, select
from bearingsim.plots.points import Points, curve_rows, order_of, points_of
from bearingsim.plots.style import COLUMN_IN, PAGE_IN, CurveStyle, curve_styles
from bearingsim.plots.ticks import set_linear_ticks, set_log_ticks
from bearingsim.store import is_uncertain
from bearingsim.study import Figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


ROW_IN = 2.7  # height (inches) of a row of panels
HEADROOM = 1.05  # minimum upper limit of an axis that begins at zero, relative to the largest value
LABEL_CHARACTERS = 34  # characters in a line of an axis label
CAPTION_LINES = 4  # lines of a caption that fit below any figure
CAPTION_LINE_IN = 0.13  # height (inches) of each further line of a caption
CHARACTER_IN = 0.066  # width (inches) of a character of the legend
HANDLE_IN, ENTRY_IN, LEGEND_GAP_IN = 0.6, 0.22, 0.1  # width of a line, height of an entry, space below the legend
TITLE_IN = 0.28  # height (inches) of the title
NONE_ABOVE_ZERO = "no value above zero"
"""Remark in logarithmic axes without a value to draw."""
STATUS_MARKS = {"failed": ("x", "#B00000", "failed"), "missing": ("|", "0.4", "not computed")}
CHAOTIC_RING: dict[str, Any] = {"ls": "", "marker": "o", "ms": 11.0, "mfc": "none", "mec": "0.45", "mew": 1.0}
"""Ring around a point of a chaotic response, whose value has statistical scatter."""
BAND_ALPHA = 0.18
HIDDEN_SHARE = 0.01
"""Level of the healthy bearing, relative to the largest value, below which the axis at zero hides its line."""
BASELINE_STYLE: dict[str, Any] = {"ls": (0, (4, 2)), "lw": 0.9, "zorder": 1.5, "gid": "healthy"}
"""Style of the level of the healthy bearing."""


@dataclass(frozen=True)
class Curve:
    """Curve of a panel: legend texts of its colour and of its line style, its style and its points."""

    colour_text: str
    line_text: str
    style: CurveStyle
    points: Points


def draw_panels(
    figure: Figure,
    rows: "pd.DataFrame",
    units: Mapping[str, str],
    caption: Sequence[str],
    panel: "Callable[[Axes, str, pd.DataFrame], None]",
    marks: Sequence[Line2D] = (),
) -> Canvas:
    """Draw a completed figure: a column of axes per y, a row per panel; ``panel`` draws in (axes, feature, rows).

    rows: the cases of the figure, SI; caption: their common parameters, wrapped below; marks: further entries of
    the legend.
    """
    parts = list(select.split_rows(rows, figure.panels, units))
    entries = [*legend_entries(figure, styles_of_curves(figure, rows, units), rows), *marks]
    width = min(COLUMN_IN, PAGE_IN / len(figure.y)) * len(figure.y) + 0.55
    layout = ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.06)
    canvas = Canvas(figsize=(width, len(parts) * ROW_IN + 0.55), layout=layout)
    axes = [list(axes_row) for axes_row in canvas.subplots(len(parts), len(figure.y), sharex=True, squeeze=False)]
    for row, (text, part) in enumerate(parts):
        for column, name in enumerate(figure.y):
            panel(axes[row][column], name, part)
            label_panel(axes[row][column], row * len(figure.y) + column, len(parts) * len(figure.y), text)
    refuse_without_values(figure, [ax.dataLim.minposy for axes_row in axes for ax in axes_row])
    share_scales(axes)
    for ax in axes[-1]:
        ax.set_xlabel(x_label(figure.x, rows, units))
    finish(canvas, figure.title, caption, entries)
    return canvas


def finish(canvas: Canvas, title: str | None, caption: Sequence[str], entries: Sequence[Line2D] = ()) -> None:
    """Add the title and the legend above the axes, and the caption, wrapped to the figure's width, below.

    The height of the figure is increased for the legend and for a long caption.
    """
    if title:
        canvas.suptitle(title, x=0.01, ha="left", fontsize=10.0)
    width = int(canvas.get_size_inches()[0] / 0.053)
    unbroken = [item.replace(" ", labels.NO_BREAK) if len(item) < width else item for item in caption]
    text = textwrap.fill(", ".join(unbroken), width, break_long_words=False, break_on_hyphens=False)
    inches, height = canvas.get_size_inches()
    canvas.set_size_inches(inches, height + CAPTION_LINE_IN * max(0, text.count("\n") + 1 - CAPTION_LINES))
    canvas.supxlabel(text, x=0.01, ha="left", fontsize=7.0, color="0.35")
    if entries:
        _add_legend(canvas, entries, TITLE_IN if title else 0.0)


def _add_legend(canvas: Canvas, entries: Sequence[Line2D], offset: float) -> None:
    """Add a legend in as many columns as fit, ``offset`` (inches) below the upper edge; axes keep their height."""
    width, height = canvas.get_size_inches()
    widest = HANDLE_IN + CHARACTER_IN * max(len(str(entry.get_label())) for entry in entries)
    columns = min(len(entries), max(1, int(width / widest)))
    legend_height = ENTRY_IN * math.ceil(len(entries) / columns) + LEGEND_GAP_IN
    canvas.set_size_inches(width, height + legend_height)
    anchor = (0.0, 1.0 - offset / (height + legend_height))
    canvas.legend(handles=entries, loc="upper left", ncols=columns, bbox_to_anchor=anchor, borderaxespad=0.2)
    layout = canvas.get_layout_engine()
    if isinstance(layout, ConstrainedLayoutEngine):
        layout.set(rect=(0.0, 0.0, 1.0, height / (height + legend_height)))


def axis_label(text: str, unit: str) -> str:
    """Join name and unit into an axis label: `Defect length (mm)`."""
    return text[:1].upper() + text[1:] + (f" ({labels.format_unit(unit)})" if unit else "")


def x_label(path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> str:
    """Return the label of the x axis of a figure over ``path``."""
    return axis_label(labels.name_text(path), select.x_unit(path, rows, units))


def y_label(name: str, unit: str, characters: int = LABEL_CHARACTERS) -> str:
    """Return the label of a feature's axis, wrapped at ``characters`` per line."""
    return textwrap.fill(axis_label(labels.feature_text(name), unit), characters)


# Curves and their styles


def styles_of_curves(
    figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]
) -> dict[tuple[str, str], CurveStyle]:
    """Assign a style to each combination of the first `by` path and all others, the same in every panel.

    If the values on x are words, no lines join the points.
    """
    first_texts = [text for text, _ in select.split_rows(rows, figure.by[:1], units)]
    second_texts = list(dict.fromkeys(text for text, _ in select.split_rows(rows, figure.by[1:], units)))
    ordered = bool(figure.by) and select.is_numeric(select.distinct_values(rows, figure.by[0]))
    table = curve_styles(len(first_texts), len(second_texts), ordered)
    if figure.x in rows and not select.is_numeric(select.distinct_values(rows, figure.x)):
        table = [[style._replace(line="") for style in row] for row in table]
    return {(a, b): table[i][j] for i, a in enumerate(first_texts) for j, b in enumerate(second_texts)}


def curves_of(
    figure: Figure, name: str, part: "pd.DataFrame", rows: "pd.DataFrame", units: Mapping[str, str], factor: float
) -> list[Curve]:
    """List the curves of feature ``name`` in one panel, whose rows are ``part``; arguments as of ``points_of``."""
    styles, order = styles_of_curves(figure, rows, units), order_of(figure, rows)
    return [
        Curve(
            colour_text,
            line_text,
            styles[colour_text, line_text],
            points_of(figure, name, curve, rows, units, factor),
        )
        for colour_text, line_text, curve in curve_rows(figure, part, units, order)
    ]


def legend_entries(
    figure: Figure, styles: Mapping[tuple[str, str], CurveStyle], rows: "pd.DataFrame"
) -> list[Line2D]:
    """Make legend entries: first `by` path, other paths, healthy level, jobs without result, models, chaos."""
    first_texts = list(dict.fromkeys(colour_text for colour_text, _ in styles))
    second_texts = list(dict.fromkeys(line_text for _, line_text in styles))
    entries: list[Line2D] = []
    if len(first_texts) > 1:
        colour_entries = [(colour_text, styles[colour_text, second_texts[0]]) for colour_text in first_texts]
        entries += [
            _legend_entry(text, style._replace(line="") if len(second_texts) > 1 else style)
            for text, style in colour_entries
        ]
    if len(second_texts) > 1:
        entries += [
            _legend_entry(line_text, styles[first_texts[0], line_text]._replace(colour="0.25"))
            for line_text in second_texts
        ]
    if any(f"baseline {name}" in rows for name in figure.y):
        text = "healthy (about zero)" if is_baseline_hidden(figure, rows) else "healthy"
        entries.append(Line2D([], [], **BASELINE_STYLE, color="0.35", label=text))
    absent = [mark for status, mark in STATUS_MARKS.items() if (rows["status"] == status).any()]
    entries += [Line2D([], [], ls="", marker=m, color=colour, label=text) for m, colour, text in absent]
    marks = {model: MODEL_MARK | {"marker": mark} for model, mark in models_of(rows).items()}
    entries += [Line2D([], [], label=model, **mark) for model, mark in marks.items() if len(marks) > 1]
    drawn = [is_uncertain(rows, name).any() for name in figure.y if name in rows]
    return entries + [Line2D([], [], **CHAOTIC_RING, label="chaotic, uncertain")] * any(drawn)


def is_baseline_hidden(figure: Figure, rows: "pd.DataFrame") -> bool:
    """Check if the level of the healthy bearing lies on the axis at zero in all panels of a figure."""
    names = [name for name in figure.y if f"baseline {name}" in rows]
    return "y" not in figure.log and all(
        rows[f"baseline {name}"].abs().max() < HIDDEN_SHARE * rows[name].abs().max() for name in names
    )


def _legend_entry(text: str, style: CurveStyle) -> Line2D:
    return Line2D([], [], label=text, **style.keywords())


MODEL_MARKS = "osD^vP"
MODEL_MARK: dict[str, Any] = {"ls": "", "color": "0.1", "ms": 2.5, "mew": 0.0}


def models_of(rows: "pd.DataFrame") -> dict[str, str]:
    """Assign a mark to each model chosen for the rows; empty unless the study names an accuracy."""
    if "error.model" not in rows:
        return {}
    names = sorted({str(name) for name in rows["model"] if name})
    return {name: MODEL_MARKS[number % len(MODEL_MARKS)] for number, name in enumerate(names)}


def mark_chaotic(ax: "Axes", x: Sequence[float], y: Sequence[float], chaotic: Sequence[bool]) -> None:
    """Draw a ring around each point of a chaotic response, whose value has statistical scatter."""
    points = [
        (a, b) for a, b, is_chaotic in zip(x, y, chaotic, strict=True) if is_chaotic and math.isfinite(a * b)
    ]
    if points:
        ax.plot(*zip(*points, strict=True), **CHAOTIC_RING)


def mark_jobs_without_result(ax: "Axes", points: Points) -> None:
    """Mark jobs without a result on the x axis."""
    for kind, (marker, colour, _) in STATUS_MARKS.items():
        where = [position for position, state in zip(points.x, points.status, strict=True) if state == kind]
        if where:  # an empty unclipped line has no position, and breaks the layout
            marks: dict[str, Any] = {"color": colour, "markersize": 6, "markeredgewidth": 1.5, "clip_on": False}
            ax.plot(where, [0.025] * len(where), marker, transform=ax.get_xaxis_transform(), **marks)


def set_x_axis(ax: "Axes", figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]) -> None:
    """Set the ticks of the x axis: one per value if there are few; words are categories."""
    distinct = select.distinct_values(rows, figure.x)
    if not select.is_numeric(distinct):
        ax.set_xticks(range(len(distinct)), [labels.value_text(figure.x, value, units) for value in distinct])
        ax.margins(x=0.12)
    elif "x" in figure.log:
        if min(distinct) <= 0.0:
            zero = labels.value_text(figure.x, min(distinct), units)
            raise labels.PlotError(f"a logarithmic axis cannot show {labels.name_text(figure.x)} {zero}")
        ax.set_xscale("log")
        set_log_ticks(ax.xaxis, ax.dataLim.minposx, ax.dataLim.x1)
    else:
        unit, few = select.x_unit(figure.x, rows, units), distinct if len(distinct) <= 7 else []
        set_linear_ticks(ax.xaxis, [labels.to_unit(figure.x, value, unit) for value in few])


def set_y_axis(ax: "Axes", name: str, figure: Figure) -> None:
    """Set limits and ticks of a feature's y axis, from zero if no value is negative.

    A logarithmic axis shows only values above zero, and a remark if there are none.
    """
    if is_logarithmic(figure, name):
        if not math.isfinite(ax.dataLim.minposy):
            ax.set_ylim(0.1, 1.0)  # else matplotlib warns
            ax.set_yscale("log")
            ax.yaxis.set_tick_params(which="both", left=False, labelleft=False)
            write_note(ax, NONE_ABOVE_ZERO, 0.5)
            return
        ax.set_yscale("log", nonpositive="mask")
        set_log_ticks(ax.yaxis, ax.dataLim.minposy, ax.dataLim.y1)
    elif name.endswith(".phase"):
        ax.set_ylim(-190.0, 190.0)
        ax.set_yticks(range(-180, 181, 90))
    else:
        low, high = ax.dataLim.intervaly  # data limits, because the axis limits include margins
        if low >= 0.0:
            ax.set_ylim(0.0, max(ax.get_ylim()[1], HEADROOM * high))
        set_linear_ticks(ax.yaxis)


def is_logarithmic(figure: Figure, name: str) -> bool:
    """Check if the values of a feature are drawn on a logarithmic axis; phases never are."""
    return "y" in figure.log and not name.endswith(".phase")


def refuse_without_values(figure: Figure, smallest: Sequence[float]) -> None:
    """Raise PlotError if all axes of features are logarithmic, and none has a value above zero.

    smallest: smallest value above zero by axes, infinite without one.
    """
    if all(is_logarithmic(figure, name) for name in figure.y) and not any(map(math.isfinite, smallest)):
        names = ", ".join(f"`{name}`" for name in figure.y)
        raise labels.PlotError(f"no value of {names} is above zero, as a logarithmic axis needs")


def write_note(ax: "Axes", text: str, height: float = 0.95) -> None:
    """Write a remark in the axes; height: of its upper edge, relative to the axes."""
    ax.text(0.5, height, text, transform=ax.transAxes, ha="center", va="top", fontsize=7.0, color="0.35")


def label_panel(ax: "Axes", number: int, count: int, text: str) -> None:
    """Write `(a)` and the panel's text above its upper left corner."""
    letters = f"({_letters(number)})" if count > 1 else ""
    ax.set_title(" ".join(filter(None, [letters, text])), loc="left")


def _letters(number: int) -> str:
    """Return the letters of a panel, from 0: a to z, then aa, ab."""
    more, last = divmod(number, len(ascii_lowercase))
    return (_letters(more - 1) if more else "") + ascii_lowercase[last]


EDGE_MARGIN = 0.03  # minimum distance of a curve from the edge of its axes, relative to their height
MAX_SCALE_RATIO = 4.0  # ratio of y ranges above which panels keep their own axes


def share_scales(axes: Sequence[Sequence["Axes"]], max_ratio: float = MAX_SCALE_RATIO) -> None:
    """Share one y axis among the panels of a feature, unless the ratio of their ranges exceeds ``comparable``.

    Logarithmic axes without a value above zero keep their own.
    """
    for column in zip(*axes, strict=True):
        stack = [ax for ax in column if ax.get_yscale() == "linear" or math.isfinite(ax.dataLim.minposy)]
        if not stack:
            continue
        limits = [ax.get_ylim() for ax in stack]
        spans = [high - low for low, high in limits]
        if max(spans) <= max_ratio * min(spans):
            low, high = min(low for low, _ in limits), max(high for _, high in limits)
            if all(ax.get_yscale() == "linear" for ax in stack):
                low, high = _with_margins(stack, low, high)
            for ax in stack:
                ax.set_ylim(low, high)


def _with_margins(stack: Sequence["Axes"], low: float, high: float) -> tuple[float, float]:
    """Extend common limits so that no curve lies on an edge; keep a lower limit of zero or above a value."""
    smallest = min(float(ax.dataLim.y0) for ax in stack)
    largest = max(float(ax.dataLim.y1) for ax in stack)
    margin = EDGE_MARGIN * (high - low)
    is_kept = low == 0.0 or low >= smallest
    return low if is_kept else min(low, smallest - margin), max(high, largest + margin)
