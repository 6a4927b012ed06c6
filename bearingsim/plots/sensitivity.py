"""Sensitivity of a feature: Sobol' indices as bars, Morris effects as points, with confidence intervals."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine

from bearingsim.plots import labels
from bearingsim.plots.axes import finish
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.style import COLOURS, MARKERS, drawing
from bearingsim.sensitivity import LEVEL, Blocks, Effects, Estimate, Indices

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results

FeatureAnalysis = tuple[Blocks, Indices | Effects]
"""Values of a feature by blocks, and their analysis."""
COLUMN_IN, BAR_IN, NAMES_IN, POINTS_IN = 2.9, 0.42, 1.3, 2.9
"""Sizes (inches): width of a panel, height of a pair of bars, width of the names, height of a panel of points."""
BAR_THICKNESS = 0.38
"""Thickness of a bar, relative to the spacing of the parameters."""
LABEL_CHARACTERS = 36  # limit of the characters in a line of a panel's title
BARS = (
    ("first", "first index (parameter alone)", "#9BD0F0"),
    ("total", "total index (with interactions)", COLOURS[0]),
)
WHISKER: dict[str, Any] = {"ecolor": "0.15", "elinewidth": 1.0, "capsize": 2.0}


def draw(results: "Results", analyses: Sequence[FeatureAnalysis], path: Path) -> Path:
    """Write the figure in the format given by the suffix of ``path``; return the file."""
    from bearingsim.plots.plot import write_figure

    with drawing():
        return write_figure(draw_figure(results, analyses), path, results)


def draw_figure(results: "Results", analyses: Sequence[FeatureAnalysis]) -> Canvas:
    """Draw a panel per feature; all features are from the same design."""
    blocks, indices = analyses[0]
    design, units = results.plan["design"], results.plan["units"]
    names = [label_of(path, ends, units) for path, ends in zip(blocks.paths, design["ranges"], strict=True)]
    has_bars = isinstance(indices, Indices)
    width = len(analyses) * COLUMN_IN + NAMES_IN
    height = (len(names) * BAR_IN if has_bars else POINTS_IN) + 1.3
    canvas = Canvas(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06))
    axes = canvas.subplots(1, len(analyses), sharey=has_bars, squeeze=False)[0]
    ranks = _ranks(indices) if isinstance(indices, Indices) else []
    for ax, (blocks, analysis) in zip(axes, analyses, strict=True):
        if isinstance(analysis, Indices):
            _draw_bars(ax, analysis, ranks, names)
            ax.set_title(textwrap.fill(labels.feature_text(blocks.feature), LABEL_CHARACTERS), loc="left")
        else:
            _draw_points(ax, blocks, analysis, names)
    handles, texts = axes[0].get_legend_handles_labels()
    options: dict[str, Any] = (
        {"loc": "outside upper center", "ncols": 2} if has_bars else {"loc": "outside right upper"}
    )
    canvas.legend(handles, texts, **options)
    table = results.table()[["job"]]
    rows = table[table["job"].isin(design["ids"])]
    finish(canvas, None, [*fixed_values(results, rows, set(blocks.paths)), *_notes(analyses)])
    return canvas


def label_of(path: str, limits: Sequence[float], units: Mapping[str, str]) -> str:
    """Format a parameter and its range (SI) in the study's unit, on two lines."""
    unit = labels.unit_of(path, units)
    smallest, largest = (labels.number_text(labels.to_unit(path, end, unit)) for end in limits)
    name = labels.name_text(path)
    return f"{name[:1].upper()}{name[1:]}\n{smallest} to {labels.with_unit(largest, unit)}".rstrip()


def _ranks(indices: Indices) -> list[int]:
    """Rank the parameters by total index, 0 at the top."""
    return [int(rank) for rank in np.argsort(np.argsort(-indices.total.value, kind="stable"))]


def _draw_bars(ax: "Axes", indices: Indices, ranks: Sequence[int], names: Sequence[str]) -> None:
    for number, (name, text, colour) in enumerate(BARS):
        estimate: Estimate = getattr(indices, name)
        where = [rank + (number - 0.5) * BAR_THICKNESS for rank in ranks]
        options: dict[str, Any] = {"xerr": _whiskers(estimate), "error_kw": WHISKER}
        ax.barh(where, estimate.value, BAR_THICKNESS, color=colour, label=text, **options)
    ax.set_yticks(ranks, names)
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.axvline(0.0, color="0.3", linewidth=0.8)
    ax.set_xlim(min(-0.05, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
    ax.set_xlabel("Share of the variance")
    ax.grid(visible=False, axis="y")


def _draw_points(ax: "Axes", blocks: Blocks, effects: Effects, names: Sequence[str]) -> None:
    unit, factor = labels.feature_axis(blocks.feature, float(effects.mu_star.high.max()))
    in_unit = f" ({unit})" if unit else ""
    mu_star, sigma = (
        Estimate(*(factor * ends for ends in estimate)) for estimate in (effects.mu_star, effects.sigma)
    )
    for number, name in enumerate(names):
        colour, mark = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
        options: dict[str, Any] = WHISKER | {"ecolor": colour, "color": colour, "marker": mark, "clip_on": False}
        x_error, y_error = (_whiskers(estimate)[:, [number]] for estimate in (mu_star, sigma))
        options |= {"xerr": x_error, "yerr": y_error, "linestyle": "", "label": name}
        ax.errorbar(mu_star.value[number], sigma.value[number], **options)
    limit = 1.05 * float(max(mu_star.high.max(), sigma.high.max()))
    ax.plot([0.0, limit], [0.0, limit], color="0.6", linewidth=0.8, linestyle="--")
    ax.annotate("sigma = mu*", (0.93 * limit, 0.95 * limit), fontsize=7.0, color="0.4", ha="right")
    ax.set_xlim(0.0, limit)
    ax.set_ylim(0.0, limit)
    ax.set_xlabel(f"mu*, over the whole range{in_unit}")
    ax.set_ylabel(f"sigma{in_unit}")
    ax.set_title(textwrap.fill(labels.feature_text(blocks.feature), LABEL_CHARACTERS), loc="left")


def _whiskers(estimate: Estimate) -> np.ndarray:
    """Return lower and upper error lengths (2, d) for matplotlib, without negative rounding errors."""
    return np.maximum([estimate.value - estimate.low, estimate.high - estimate.value], 0.0)


def _notes(analyses: Sequence[FeatureAnalysis]) -> list[str]:
    """Return caption texts: the number of blocks, and the meaning of the whiskers."""
    counts = dict.fromkeys(f"{len(blocks.values)} of {blocks.planned} blocks" for blocks, _ in analyses)
    return [f"{' and '.join(counts)} ({analyses[0][0].kind})", f"whiskers: {100 * LEVEL:.0f} % by bootstrap"]
