"""Chart of speed against accuracy: a figure per scene, CPU time over numerical (left) and total error (right).

Rows of panels: defect line, RMS, largest force. Colours are models, paler for variants with fewer harmonics or
slices; marks are methods, and runs of one method are joined. Hollow marks are solvers of other packages. Failed
runs are listed on a line above the panels.
"""

from collections.abc import Sequence
from io import BytesIO
from math import hypot, log10
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
from bearingsim.plots.style import COLOURS, MARKERS, RC, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LOOK = RC | {"font.size": 8.0, "axes.labelsize": 8.0, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5}
SIZE_IN, DPI, SHADES = (7.08, 8.4), 150, 64  # 180 mm wide
SMALL_POINTS = 7.0  # size of the smallest texts
RAIL = 1.075  # height of the line of failed runs, over that of a panel
HEADS = {NUMERICAL: "numerical error (same model)", TOTAL: "total error (from the reference)"}
SIDES = {"line": "defect line", "rms": "RMS of the velocity", "force": "largest force"}
MIN_ERROR, MAX_ERROR, ROOM = 1e-4, 10.0, 0.1  # limits at which errors are clipped; smallest upper limit of an axis
APART = 0.3  # decades, minimum distance between labelled marks
PALER = 0.35  # fraction of white blended in, for each further variant of a model


def draw(rows: Sequence[Row], title: str, path: Path) -> Path:
    """Draw a scene's rows (``errors.with_errors``) into a PNG; return its path."""
    with drawing(LOOK):
        canvas = figure(rows, title)
        buffer = BytesIO()
        canvas.savefig(buffer, dpi=DPI)
    with Image.open(buffer) as image:  # few colours reduce the file to a third
        image.convert("RGB").quantize(SHADES).save(path, optimize=True)
    return path


def figure(rows: Sequence[Row], title: str) -> Canvas:
    """Draw cost against numerical and total error of a scene, a row of panels per quantity."""
    methods = list(dict.fromkeys(row["method"] for row in rows if row["role"] in (POINT, AUTOMATIC, PEER)))
    colours = _colours(rows)
    marks = {name: MARKERS[n % len(MARKERS)] for n, name in enumerate(filter(None, methods))} | {"": MARKERS[-1]}
    canvas = Canvas(figsize=SIZE_IN, layout="constrained")
    panels = canvas.subplots(len(QUANTITIES), 2, sharex=True, sharey=True, squeeze=False)
    for i, quantity in enumerate(QUANTITIES):
        for j, kind in enumerate((NUMERICAL, TOTAL)):
            _panel(panels[i][j], rows, kind, quantity, colours, marks)
        panels[i][0].set_ylabel(f"{SIDES[quantity]}\nCPU time for 1 s of signal (s)")
    for ax, kind in zip(panels[0], HEADS, strict=True):
        ax.set_title(HEADS[kind], fontsize=8.5, pad=24)
    _rail(panels[0][0], rows, colours)
    for ax in panels[-1]:
        ax.set_xlabel("relative error")
    canvas.suptitle(f"{title}\n{_verdicts(rows)}", x=0.01, ha="left", fontsize=9.5)
    handles = _legend(rows, colours, marks)
    canvas.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7.5, handlelength=2.0)
    return canvas


def _colours(rows: Sequence[Row]) -> dict[str, str]:
    """Assign a colour to each variant: one per model, the same in all scenes, paler for each further variant."""
    own, shades, seen = dict(zip(reversed(MODELS), COLOURS, strict=False)), dict[str, str](), list[str]()
    for variant, model in {row["variant"]: row["model"] for row in rows}.items():
        shades[variant] = _paler(own[model], 1.0 - (1.0 - PALER) ** seen.count(model))
        seen.append(model)
    return shades


def _paler(colour: str, part: float) -> str:
    """Blend a colour with white; ``part``: 0 to 1."""
    red, green, blue = (value + part * (1.0 - value) for value in to_rgb(colour))
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
            choice = f"undecided ({cheapest.unknown})" if cheapest.unknown else "none that was run"
        lines.append(f"line, RMS and force all within {percent(within)}: cheapest is {choice}")
    return "\n".join(lines)


def _panel(ax: "Axes", rows: Sequence[Row], kind: str, quantity: str, colours: dict, marks: dict) -> None:
    column = f"{kind}.{quantity}"
    good = [row for row in rows if not row["failure"] and row[column] == row[column]]
    ax.set(xscale="log", yscale="log", ymargin=0.09)
    if kind == TOTAL:
        best = pareto_front([row for row in good if row["role"] in (POINT, AUTOMATIC)], f"{column}.counted")
        ax.step(
            [_shown(row[f"{column}.counted"]) for row in best], [row["cpu_per_s"] for row in best],
            where="pre", color="0.75", linewidth=4.0, zorder=1, solid_capstyle="round",
        )  # fmt: skip
        for row in _spread([row for row in best if row[column] < MAX_ERROR], column):
            _name(ax, row, _shown(row[column]))
        floor = max((row[f"{column}.floor"] for row in rows), default=0.0)
        if floor > MIN_ERROR:
            ax.axvspan(MIN_ERROR / 2.0, _shown(floor), color="0.94", zorder=0)
    for within in ACCURACIES:
        ax.axvline(within, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
        ax.text(
            within, 1.0, percent(within), transform=ax.get_xaxis_transform(),
            fontsize=SMALL_POINTS, color="0.35", ha="center", va="bottom",
        )  # fmt: skip
    for variant, colour in colours.items():
        for method, mark in marks.items():
            for role in (POINT, PEER):
                same_method = [
                    r for r in good if (r["variant"], r["method"], r["role"]) == (variant, method, role)
                ]
                _curve(ax, same_method, column, colour, mark, hollow=role == PEER)
    for row in good:
        if row["role"] == AUTOMATIC:
            _automatic(ax, row, [r for r in good if r["role"] == JOB], column, colours, marks)
    errors = [
        _shown(row[f"{same_method}.{name}"])
        for row in rows
        for same_method in HEADS
        for name in QUANTITIES
        if not row["failure"]
    ]
    ax.set_xlim(MIN_ERROR / 1.6, 2.0 * max(error for error in [*errors, ROOM] if error == error))
    ax.xaxis.set_major_locator(LogLocator(numticks=12))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _spread(rows: Sequence[Row], column: str) -> list[Row]:
    """Select rows with marks far enough apart to be labelled."""
    separate: list[Row] = []
    for row in rows:
        points = [(log10(_shown(other[column])), log10(other["cpu_per_s"])) for other in (row, *separate)]
        if all(hypot(points[0][0] - x, 1.5 * (points[0][1] - y)) > APART for x, y in points[1:]):
            separate.append(row)
    return separate


def _name(ax: "Axes", row: Row, x: float) -> None:
    """Label a mark with the step or tolerance of its run, on the side away from the frame."""
    side, offset = ("left", 6.0) if x < 2.0 * MIN_ERROR else ("right", -4.0)
    ax.annotate(
        label(row), (x, row["cpu_per_s"]), xytext=(offset, -3.0), textcoords="offset points",
        fontsize=SMALL_POINTS, color="0.25", ha=side, va="top", zorder=6,
    )  # fmt: skip


def _curve(ax: "Axes", rows: Sequence[Row], column: str, colour: str, mark: str, hollow: bool) -> None:
    """Draw the runs of a method, joined from the coarsest setting."""
    if rows:
        ax.plot(
            [_shown(row[column]) for row in rows], [row["cpu_per_s"] for row in rows],
            color=colour, marker=mark, markersize=4.5, linewidth=0.7, markeredgewidth=0.8,
            linestyle="--" if hollow else "-", markerfacecolor="white" if hollow else colour, zorder=3,
        )  # fmt: skip


def _automatic(ax: "Axes", row: Row, jobs: Sequence[Row], column: str, colours: dict, marks: dict) -> None:
    """Draw the automatic choice in full with a ring around it, and the corresponding job as a star."""
    colour, x, y = colours[row["variant"]], _shown(row[column]), row["cpu_per_s"]
    ax.plot(x, y, marker=marks[row["method"]], color=colour, markersize=4.5, zorder=4)
    ax.plot(x, y, marker="o", markersize=11.0, markerfacecolor="none", markeredgecolor=colour, mew=1.4, zorder=5)
    for job in jobs:
        if job["variant"] == row["variant"]:
            x_job, y_job = _shown(job[column]), job["cpu_per_s"]
            ax.plot([x, x_job], [y, y_job], color=colour, linewidth=0.8, linestyle=":", zorder=2)
            ax.plot(x_job, y_job, marker="*", color=colour, markersize=8.0, mec="black", mew=0.5, zorder=5)


def _shown(error: float) -> float:
    return min(max(error, MIN_ERROR), MAX_ERROR)


def _rail(ax: "Axes", rows: Sequence[Row], colours: dict) -> None:
    """List the failed runs above the panels, in the order of the rows."""
    failed = [row for row in rows if row["failure"]]
    if not failed:
        return
    ax.plot([0.0, 2.05], [RAIL, RAIL], transform=ax.transAxes, color="0.6", lw=0.8, clip_on=False, in_layout=False)
    names = [("failed", "0.3"), *((_failed(row), colours[row["variant"]]) for row in failed)]
    for n, (name, colour) in enumerate(names):
        ax.text(
            2.05 * n / len(names), RAIL + 0.02, name, transform=ax.transAxes,
            fontsize=SMALL_POINTS, va="bottom", color=colour, in_layout=False,
        )  # fmt: skip


def _failed(row: Row) -> str:
    return "any method" if row["role"] == JOB else f"{row['method']} {label(row)}".strip()


def _legend(rows: Sequence[Row], colours: dict, marks: dict) -> list[Any]:
    chaotic = {row["variant"] for row in rows if row["chaotic"] == 1.0}
    entries: list[Any] = [
        Line2D([], [], color=colour, linewidth=4.0, label=name + " (chaotic)" * (name in chaotic))
        for name, colour in colours.items()
    ]
    peers = {row["method"] for row in rows if row["role"] == PEER}
    for name, mark in marks.items():
        if name:
            fill = "white" if name in peers else "0.3"
            line: dict[str, Any] = {"linestyle": "--" if name in peers else "-", "linewidth": 0.7}
            entries.append(Line2D([], [], color="0.3", marker=mark, ms=4.5, mfc=fill, label=name, **line))
    instant = [row for row in rows if row["role"] == AUTOMATIC and not row["method"]]
    if instant:
        entries.append(
            Line2D([], [], color="0.3", marker=marks[""], ms=4.5, ls="none", label="static: no integrator")
        )
    ring: dict[str, Any] = {"marker": "o", "ms": 10.0, "mfc": "none", "mec": "0.2", "mew": 1.4}
    entries.append(Line2D([], [], color="0.3", ls="none", label="automatic choice, in full", **ring))
    star: dict[str, Any] = {"marker": "*", "ms": 8.0, "mfc": "0.6", "mec": "black", "mew": 0.5}
    entries.append(Line2D([], [], ls="none", label="automatic choice, as a job", **star))
    entries.append(Line2D([], [], color="0.75", linewidth=4.0, label="Pareto front, in full"))
    return entries
