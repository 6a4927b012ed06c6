"""Chart of speed against accuracy: a figure per scene, CPU time over numerical (left) and total (right) error.

The rows of panels are the amplitude at the defect frequency, the RMS, and the largest force. Each model has a
colour, paler for variants with other harmonics or slices. A dot is a run at one step or tolerance; a line joins
the runs of a method, in its line style. Hollow dots are solvers of other packages, with their names. Stars are
jobs with automatic method and step. Failed runs are listed above the panels.
"""

from collections.abc import Sequence
from io import BytesIO
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter
from PIL import Image

from bearingsim.bench.errors import NUMERICAL, TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import AUTOMATIC, JOB, PEER, POINT
from bearingsim.bench.verdict import ACCURACIES, label, method_text, pareto_front, percent, seconds, verdict
from bearingsim.catalogue import MODELS
from bearingsim.plots.style import COLOURS, RC, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE = RC | {"font.size": 8.0, "axes.labelsize": 8.0, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5}
SIZE_IN, DPI, PALETTE_SIZE = (7.08, 8.4), 150, 64  # 180 mm wide
SMALL_POINTS = 7.0  # font size of the smallest texts
FAILURES_HEIGHT = 1.075  # height of the line under the list of failed runs, relative to a panel
TITLES = {NUMERICAL: "numerical error (same model)", TOTAL: "total error (from the reference)"}
QUANTITY_LABELS = {"line": "defect line", "rms": "RMS of the velocity", "force": "largest force"}
MIN_ERROR, MAX_ERROR = 1e-4, 10.0  # limits to which errors are clipped
MIN_SHOWN_ERROR = 0.1  # half the smallest upper limit of the error axes
LINES = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))
"""Line styles of the methods, in their order."""
DOT: dict[str, Any] = {"marker": "o", "markersize": 3.5}
HOLLOW: dict[str, Any] = DOT | {"markerfacecolor": "white", "linewidth": 0.6, "linestyle": (0, (1, 3))}
STAR: dict[str, Any] = {"marker": "*", "markersize": 9.0, "markeredgecolor": "black", "markeredgewidth": 0.5}
FRONT: dict[str, Any] = {"color": "0.85", "linewidth": 5.0, "zorder": 1, "solid_capstyle": "round"}
WHITE_SHARE = 0.35  # share of white added to the colour for each further variant of a model


def draw(rows: Sequence[Row], title: str, path: Path) -> Path:
    """Draw a scene's rows (``errors.with_errors``) to a PNG file; return its path."""
    with drawing(STYLE):
        canvas = draw_figure(rows, title)
        buffer = BytesIO()
        canvas.savefig(buffer, dpi=DPI)
    with Image.open(buffer) as image:  # few colours reduce the file to a third
        image.convert("RGB").quantize(PALETTE_SIZE).save(path, optimize=True)
    return path


def draw_figure(rows: Sequence[Row], title: str) -> Canvas:
    """Draw cost against numerical and total error of a scene, a row of panels per quantity."""
    methods = dict.fromkeys(row["method"] for row in rows if row["role"] == POINT and row["method"])
    styles = {name: LINES[n % len(LINES)] for n, name in enumerate(methods)}
    colours = _colours(rows)
    canvas = Canvas(figsize=SIZE_IN, layout="constrained")
    panels = canvas.subplots(len(QUANTITIES), 2, sharex=True, sharey=True, squeeze=False)
    for i, quantity in enumerate(QUANTITIES):
        for j, kind in enumerate((NUMERICAL, TOTAL)):
            _panel(panels[i][j], rows, kind, quantity, colours, styles)
        panels[i][0].set_ylabel(f"{QUANTITY_LABELS[quantity]}\nCPU time for 1 s of signal (s)")
    for ax, kind in zip(panels[0], TITLES, strict=True):
        ax.set_title(TITLES[kind], fontsize=8.5, pad=24)
    _list_failures(panels[0][0], rows, colours)
    for ax in panels[-1]:
        ax.set_xlabel("relative error")
    canvas.suptitle(f"{title}\n{_verdicts(rows)}", x=0.01, ha="left", fontsize=9.5)
    handles = _legend(rows, colours, styles)
    canvas.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8.0, handlelength=2.6)
    return canvas


def _colours(rows: Sequence[Row]) -> dict[str, str]:
    """Assign a colour to each variant: that of its model in all scenes, paler for each further variant."""
    base_colours, shades, previous = (
        dict(zip(reversed(MODELS), COLOURS, strict=False)),
        dict[str, str](),
        list[str](),
    )
    for variant, model in {row["variant"]: row["model"] for row in rows}.items():
        shades[variant] = _lighten(base_colours[model], 1.0 - (1.0 - WHITE_SHARE) ** previous.count(model))
        previous.append(model)
    return shades


def _lighten(colour: str, white: float) -> str:
    """Blend a colour with white; ``white``: share of white, 0 to 1."""
    red, green, blue = (value + white * (1.0 - value) for value in to_rgb(colour))
    return to_hex((red, green, blue))


def _verdicts(rows: Sequence[Row]) -> str:
    """Format the verdicts, one per line."""
    lines = []
    for within in ACCURACIES:
        cheapest = verdict(rows, within)
        if cheapest.job is not None:
            choice = f"{cheapest.job['variant']} ({cheapest.job['method'] or 'no method'}, "
            choice += f"{seconds(cheapest.job['cpu_per_s'])} as a job)"
        elif cheapest.point is not None:
            choice = f"{cheapest.point['variant']} ({method_text(cheapest.point)})"
        else:
            choice = f"undecided ({cheapest.unknown})" if cheapest.unknown else "none of the runs"
        lines.append(f"line, RMS and force all within {percent(within)}: cheapest is {choice}")
    return "\n".join(lines)


def _panel(ax: "Axes", rows: Sequence[Row], kind: str, quantity: str, colours: dict, styles: dict) -> None:
    column = f"{kind}.{quantity}"
    completed = [row for row in rows if not row["failure"] and row[column] == row[column]]
    ax.set(xscale="log", yscale="log", ymargin=0.09)
    if kind == TOTAL:
        best = pareto_front([row for row in completed if row["role"] in (POINT, AUTOMATIC)], f"{column}.counted")
        ax.step(
            [_clipped(row[f"{column}.counted"]) for row in best],
            [row["cpu_per_s"] for row in best],
            where="pre",
            **FRONT,
        )
        floor = max((row[f"{column}.floor"] for row in rows), default=0.0)
        if floor > MIN_ERROR:
            ax.axvspan(MIN_ERROR / 2.0, _clipped(floor), color="0.94", zorder=0)
    for within in ACCURACIES:
        ax.axvline(within, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
        ax.text(
            within, 1.0, percent(within), transform=ax.get_xaxis_transform(),
            fontsize=SMALL_POINTS, color="0.35", ha="center", va="bottom",
        )  # fmt: skip
    for variant, colour in colours.items():
        variant_rows = [row for row in completed if row["variant"] == variant]
        for method, style in styles.items():
            runs = [row for row in variant_rows if row["role"] == POINT and row["method"] == method]
            _draw_runs(
                ax, runs, column, DOT | {"color": colour, "linewidth": 0.9, "linestyle": style, "zorder": 3}
            )
        for method in dict.fromkeys(row["method"] for row in variant_rows if row["role"] == PEER):
            runs = [row for row in variant_rows if row["role"] == PEER and row["method"] == method]
            _draw_runs(ax, runs, column, HOLLOW | {"color": colour, "zorder": 2})
            if kind == NUMERICAL:
                _annotate(ax, runs[0], _clipped(runs[0][column]))
        _draw_runs(
            ax, [row for row in variant_rows if row["role"] == JOB], column, STAR | {"color": colour, "zorder": 5}
        )
    errors = [
        _clipped(row[f"{error_kind}.{name}"])
        for row in rows
        for error_kind in TITLES
        for name in QUANTITIES
        if not row["failure"]
    ]
    ax.set_xlim(MIN_ERROR / 1.6, 2.0 * max(error for error in [*errors, MIN_SHOWN_ERROR] if error == error))
    ax.xaxis.set_major_locator(LogLocator(numticks=12))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _annotate(ax: "Axes", row: Row, x: float) -> None:
    """Write the name of a solver of another package next to a run."""
    ax.annotate(
        row["method"].removeprefix("scipy-"), (x, row["cpu_per_s"]), xytext=(4.0, 0.0), textcoords="offset points",
        fontsize=SMALL_POINTS, color="0.25", va="center", zorder=6,
    )  # fmt: skip


def _draw_runs(ax: "Axes", rows: Sequence[Row], column: str, style: dict[str, Any]) -> None:
    """Draw runs as dots, joined in the order of the rows if the style has a line."""
    if rows:
        style = {"linestyle": "none"} | style
        ax.plot([_clipped(row[column]) for row in rows], [row["cpu_per_s"] for row in rows], **style)


def _clipped(error: float) -> float:
    return min(max(error, MIN_ERROR), MAX_ERROR)


def _list_failures(ax: "Axes", rows: Sequence[Row], colours: dict) -> None:
    """List the failed runs above the panels, in the order of the rows."""
    failed = [row for row in rows if row["failure"]]
    if not failed:
        return
    ax.plot(
        [0.0, 2.05], [FAILURES_HEIGHT] * 2, transform=ax.transAxes,
        color="0.6", lw=0.8, clip_on=False, in_layout=False,
    )  # fmt: skip
    names = [("failed", "0.3"), *((_failure_label(row), colours[row["variant"]]) for row in failed)]
    for n, (name, colour) in enumerate(names):
        ax.text(
            2.05 * n / len(names), FAILURES_HEIGHT + 0.02, name, transform=ax.transAxes,
            fontsize=SMALL_POINTS, va="bottom", color=colour, in_layout=False,
        )  # fmt: skip


def _failure_label(row: Row) -> str:
    return "any method" if row["role"] == JOB else f"{row['method']} {label(row)}".strip()


def _legend(rows: Sequence[Row], colours: dict, styles: dict) -> list[Any]:
    """Return the legend in three columns: colours of models, line styles of methods, markers of runs."""
    chaotic = {row["variant"] for row in rows if row["chaotic"] == 1.0}
    models = [
        Line2D([], [], color=colour, linewidth=4.0, label=name + " (chaotic)" * (name in chaotic))
        for name, colour in colours.items()
    ]
    methods = [Line2D([], [], color="0.3", linewidth=1.2, ls=style, label=name) for name, style in styles.items()]
    methods.append(Line2D([], [], label="cheapest full integration", **FRONT))
    has_peers = any(row["role"] == PEER for row in rows)
    runs = [
        Line2D([], [], color="0.3", ls="none", label="a step or tolerance, full integration", **DOT),
        *([Line2D([], [], color="0.3", label="a solver of another package", **HOLLOW)] if has_peers else []),
        Line2D([], [], color="0.6", ls="none", label="automatic choice, as a job", **STAR),
    ]
    filled = zip(*zip_longest(models, methods, runs, fillvalue=Line2D([], [], ls="none", label=" ")), strict=True)
    return [entry for column in filled for entry in column]
