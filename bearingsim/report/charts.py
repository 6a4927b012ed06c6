"""Charts: interactive figures as plain data, which the script of the page draws."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from bearingsim.plots.style import SEQUENCE_FROM

if TYPE_CHECKING:
    import numpy as np

DIGITS = 6
"""Significant digits of the numbers in a page."""
COLOURS = 7
"""Number of colours of curves in the style sheet, `curve0` and so on."""
SYMBOLS = ("circle", "rect", "triangle", "diamond", "pin", "arrow", "roundRect")
"""Symbols of simulated points, in ECharts."""
OPEN_SYMBOLS = {
    "emptyDiamond": "M14 1l5 5-5 5-5-5z",
    "emptyRect": "M9.5 1.5h9v9h-9z",
    "emptyTriangle": "M14 1l5 10h-10z",
}
"""Symbols of measured points, in ECharts, and their outlines (SVG path) in the legend."""
DASHES = ((), (6, 3), (2, 2), (6, 2, 1, 2), (3, 1, 1, 1, 1, 1))
"""Lengths (px) of strokes and gaps of the lines of curves."""


@dataclass(frozen=True)
class Axis:
    """Axis: label with unit, words of categories (none for numbers), logarithmic or not, or of a phase (deg)."""

    label: str
    words: list[str]
    log: bool = False
    phase: bool = False


@dataclass(frozen=True)
class Curve:
    """Curve: its name, a colour of the style sheet or of CSS, the lengths of its dashes, and its symbol.

    measured: points without a line, with open symbols.
    """

    name: str
    colour: str
    dash: tuple[int, ...]
    symbol: str
    measured: bool = False


@dataclass(frozen=True)
class Control:
    """Control of a chart: name of one parameter, or of several that vary together; a text per setting.

    start: index of the first setting shown; ordered: the settings are numbers.
    """

    name: str
    options: list[str]
    start: int
    ordered: bool


@dataclass(frozen=True)
class Panel:
    """Axes of one feature or channel: y axis, name, unit, and columns with a number per point.

    columns: `y`; `low`, `high`: band; `error`: error bound; `healthy`: level of the healthy bearing; `chaotic`.
    trends: of a design, for each x axis rows of x, quartile, median, quartile.
    """

    axis: Axis
    name: str
    unit: str
    columns: dict[str, list[Any]]
    trends: list[list[list[float | None]]]


@dataclass(frozen=True)
class Chart:
    """Interactive figure: axes, panels, curves, controls, and the points of all settings.

    axes: the x axis, or those that a design offers; kind: `line`, `points`, `signal` or `design`; combinations:
    computed settings, an index per control; x: columns of the points, one per axis; points: further columns,
    which are the indices of curves and combinations, ids and states of jobs, and the index of the curve whose
    colour a measured point has; shades: columns from 0 to 1 by which a design colours its points; marks:
    frequencies and names of spectral lines; names: explanations for the legend.
    """

    title: str
    kind: str
    axes: list[Axis]
    panels: list[Panel]
    curves: list[Curve]
    controls: list[Control]
    combinations: list[list[int]]
    x: list[list[float | None]]
    points: dict[str, list[Any]]
    caption: str
    names: dict[str, str]
    shades: list[list[float | None]]
    marks: list[tuple[float, str]]


def round_values(values: Iterable[float]) -> list[float | None]:
    """Round numbers to ``DIGITS``; None for NaN and infinity, which JSON does not have."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in values]


def round_positions(positions: "Sequence[float] | np.ndarray") -> list[float | None]:
    """Round ascending positions (n,) along a curve to a hundredth of their smallest step, or finer.

    Neighbours remain distinct at any distance from zero, such as samples 20 us apart after 20 s.
    """
    steps = [following - previous for previous, following in pairwise(positions) if following > previous]
    if not steps:
        return round_values(positions)
    decimals = 2 - math.floor(math.log10(min(steps)))
    return [round(float(position), decimals) for position in positions]


def style_curves(ranks: dict[str, tuple[int, int]], ordered: bool) -> list[Curve]:
    """Style curves as in a figure; ranks: those of the values of the first and of the other paths, by curve.

    ordered: many curves have colours of a scale that is legible on light and dark backgrounds.
    """
    count = 1 + max((rank for rank, _ in ranks.values()), default=0)
    shades = ordered and count >= SEQUENCE_FROM
    dashed = any(dash for _, dash in ranks.values())
    return [
        Curve(
            name,
            shade(rank / (count - 1)) if shades else f"curve{rank % COLOURS}",
            DASHES[(dash if dashed else 0 if shades else rank) % len(DASHES)],
            SYMBOLS[rank % len(SYMBOLS)],
        )
        for name, (rank, dash) in ranks.items()
    ]


def shade(share: float) -> str:
    """Return a colour of a scale from violet (0) to green (1), of medium lightness."""
    return f"hsl({270 - 150 * share:.0f}, 50%, 50%)"


def list_settings(counts: Sequence[int]) -> list[list[int]]:
    """List all combinations of the settings of controls that have these numbers of options."""
    combinations: list[list[int]] = [[]]
    for count in counts:
        combinations = [[*key, index] for key in combinations for index in range(count)]
    return combinations
