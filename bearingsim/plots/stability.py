"""Failure map of the methods: a row of panels per method, a column per stiffness.

Each cell is a run, and shows its class by colour and mark. All rows of ``stability.csv`` are drawn.
"""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from bearingsim.plots.style import RC, drawing

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

PLAIN = RC | {"axes.grid": False, "font.size": 8.0}
PAGE_IN = 7.08  # largest width (inches), 180 mm
MIN_IN = 5.6  # minimum width (inches), for the title and the legend
COLUMN_IN, NAMES_IN = 2.1, 1.0  # widths (inches) of a column of panels and of the names of methods
ROW_IN, HEAD_IN, FOOT_IN = 1.05, 1.1, 1.0  # heights (inches) of a row of panels, of title, and of legend
TICK_POINTS = 7.0  # font size of the smallest texts


class ClassStyle(NamedTuple):
    """Colour of a class, and the mark, with its colour ``ink``, that distinguishes the class in grey print."""

    colour: str
    mark: str = ""
    ink: str = "black"


CLASS_STYLES: dict[str, ClassStyle] = {
    "ok": ClassStyle("#0072B2"),
    "inaccurate": ClassStyle("#9BD0F0"),
    "chatter": ClassStyle("#E69F00", "$\\sim$"),
    "blow-up": ClassStyle("#D55E00", "x", "white"),
    "skipped": ClassStyle("#CC79A7", "o", "white"),
    "stalled": ClassStyle("#222222", "s", "white"),
    "refused": ClassStyle("#999999", "_"),
    "too slow": ClassStyle("#DDDDDD", "."),
    "within chaos": ClassStyle("#7FCDBB", "+"),
    "no reference": ClassStyle("#FFFFFF", "$?$"),
}
MEANING = {
    "ok": "ok (within 1 %)",
    "stalled": "stalled (cannot continue)",
    "too slow": "too slow",
    "skipped": "skipped a defect",
    "within chaos": "within chaos (path not unique)",
}


class Entry(NamedTuple):
    """Legend entry: artists drawn over each other, and their label."""

    handles: tuple[Any, ...]
    label: str


def draw_all(path: Path) -> list[Path]:
    """Draw a map per model and defect of a CSV file, in its folder; return the files."""
    import pandas as pd

    table = pd.read_csv(path)
    maps = table[["model", "pit"]].drop_duplicates().itertuples(index=False)
    return [
        file
        for model, defect in maps
        for file in draw(table, model, defect, path.parent / _file_stem(model, defect))
    ]


def _file_stem(model: str, defect: str) -> str:
    return f"stability-{model}-{defect.replace(' ', '-')}"


def draw(table: "pd.DataFrame", model: str, defect: str, path: Path) -> list[Path]:
    """Draw the map of one model and defect: methods with a step, then those with a tolerance; return the files."""
    map_rows = table[(table["model"] == model) & (table["pit"] == defect)]
    paths = []
    for axis, ending in (("step", "steps"), ("tolerance", "tolerances")):
        rows = map_rows[map_rows[axis].notna()]
        if len(rows):
            file = path.with_name(f"{path.name}-{ending}.png")
            with drawing(PLAIN):
                draw_figure(rows, axis, f"{model}, {defect}").savefig(file)
            paths.append(file)
    return paths


def draw_figure(rows: "pd.DataFrame", axis: str, title: str) -> Canvas:
    """Draw the map of ``rows`` over damping and the setting ``axis``, which is `step` or `tolerance`."""
    methods, stiffness = list(dict.fromkeys(rows["method"])), sorted(rows["k"].unique())
    named = dict(zip(rows["k"], rows["stiffness"].fillna(""), strict=True))
    damping = sorted({(m3, c) for m3, c in zip(rows["m3"], rows["c"], strict=True)})
    width = min(PAGE_IN, max(MIN_IN, COLUMN_IN * len(stiffness) + NAMES_IN))
    size = width, ROW_IN * len(methods) + HEAD_IN + FOOT_IN
    canvas = Canvas(figsize=size, layout="constrained")
    panels = canvas.subplots(len(methods), len(stiffness), sharex=True, sharey="row", squeeze=False)
    for i, method in enumerate(methods):
        settings = sorted(rows.loc[rows["method"] == method, axis].unique(), reverse=axis == "tolerance")
        for j, k in enumerate(stiffness):
            ax = panels[i][j]
            cells = rows[(rows["method"] == method) & (rows["k"] == k)]
            _panel(ax, cells, axis, damping, settings)
            if j == 0:
                name = method.replace("-", "-\n")
                ax.set_ylabel(name, rotation=0, ha="right", va="center", labelpad=4, fontsize=8.0)
            if i == 0:
                ax.set_title(_stiffness_text(named[k], k), fontsize=8.0, pad=16)
                _write_exponents(ax, damping)
            if i == len(methods) - 1:
                ax.set_xlabel("Damping (N s/mm$^{1+m_3}$)", fontsize=8.0)
    setting_text = "step (µs)" if axis == "step" else "relative tolerance"
    canvas.suptitle(f"{title}: outcome by {setting_text} and damping", x=0.01, ha="left", fontsize=10)
    entries = _legend(rows, axis == "step")
    canvas.legend(
        [entry.handles for entry in entries],
        [entry.label for entry in entries],
        loc="outside lower left",
        ncols=3,
        handlelength=1.6,
    )
    return canvas


def _panel(ax: "Axes", cells: "pd.DataFrame", axis: str, damping: list, settings: list[float]) -> None:
    column, row = {d: n for n, d in enumerate(damping)}, {s: n for n, s in enumerate(settings)}
    for cell in cells.to_dict("records"):
        x, y, cell_style = column[cell["m3"], cell["c"]], row[cell[axis]], CLASS_STYLES[cell["class"]]
        ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=cell_style.colour, edgecolor="white", lw=0.4))
        if cell_style.mark:
            ax.plot(x, y, marker=cell_style.mark, color=cell_style.ink, ms=2.6, mew=0.6, ls="none")
        if cell["measure"] == "RMS":
            ax.plot([x + 0.28, x + 0.46], [y - 0.42, y - 0.42], color="white", lw=1.0)
    if axis == "step":
        _draw_step_limits(ax, cells, column, settings)
    ax.set_xlim(-0.5, len(damping) - 0.5)
    ax.set_ylim(-0.5, len(settings) - 0.5)
    ax.set_xticks(range(len(damping)), [_compact(c) for _, c in damping], fontsize=TICK_POINTS)
    labelled = [n for n in range(len(settings)) if len(settings) < 7 or n % 3 == 0]
    labels = [f"{1e6 * settings[n]:g}" if axis == "step" else _compact(settings[n]) for n in labelled]
    ax.set_yticks(labelled, labels, fontsize=TICK_POINTS)
    ax.tick_params(length=1.5, pad=1.5)
    for n, (previous, following) in enumerate(pairwise(damping)):
        if previous[0] != following[0]:
            ax.axvline(n + 0.5, color="black", lw=0.8)


def _draw_step_limits(ax: "Axes", cells: "pd.DataFrame", column: dict, settings: list[float]) -> None:
    """Draw the theoretical step limit for each damping as a bar at its position among the steps."""
    logs = np.log(settings)
    for (m3, c), group in cells.groupby(["m3", "c"]):
        limit, x = float(group["step_limit"].iloc[0]), column[m3, c]
        if np.isfinite(limit):
            y = np.interp(np.log(limit), logs, np.arange(len(logs)), left=-0.42, right=len(logs) - 0.58)
            for colour, width in (("white", 3.0), ("black", 1.5)):
                ax.plot([x - 0.46, x + 0.46], [y, y], color=colour, lw=width, solid_capstyle="butt", zorder=5)


def _write_exponents(ax: "Axes", damping: list[tuple[float, float]]) -> None:
    """Write the exponent m3 above its columns."""
    for m3 in sorted({m3 for m3, _ in damping}):
        columns = [n for n, pair in enumerate(damping) if pair[0] == m3]
        ax.annotate(
            f"$m_3$ = {m3:g}", (np.mean(columns), 1.0), (0, 2), xycoords=("data", "axes fraction"),
            textcoords="offset points", ha="center", va="bottom", fontsize=TICK_POINTS,
        )  # fmt: skip


def _stiffness_text(name: str, k: float) -> str:
    return f"{name}{name and ': '}k = {_compact(k)} N/mm$^{{10/9}}$"


def _compact(value: float) -> str:
    """Format a number in few characters: `0.1`, `100`, `1e3`, `7.3e5`."""
    if 0.1 <= value < 1e3:
        return f"{value:g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def _legend(rows: "pd.DataFrame", limit: bool) -> list[Any]:
    """Make an entry for each class present, for the step limit if ``limit``, and for cells compared by RMS."""
    entries: list[Any] = []
    for name, cell_style in CLASS_STYLES.items():
        if (rows["class"] == name).any():
            patch = Line2D([], [], marker="s", ms=9, ls="none", mfc=cell_style.colour, mec="0.7")
            mark = Line2D([], [], marker=cell_style.mark or "None", ms=4, ls="none", color=cell_style.ink, mew=0.8)
            entries.append(Entry((patch, mark), MEANING.get(name, name)))
    if limit:
        line = Line2D([], [], color="black", lw=1.5)
        entries.append(Entry((line,), "limit by theory, at rest"))
    if (rows["measure"] == "RMS").any():
        back = Line2D([], [], marker="s", ms=9, ls="none", mfc="0.6", mec="0.7")
        entries.append(Entry((back, Line2D([], [], color="white", lw=1.2)), "white bar: chaotic, assessed by RMS"))
    return entries
