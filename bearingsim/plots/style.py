"""Style of figures: width of a journal page, colours for colour-blind readers, readable in greyscale."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

COLUMN_IN = 3.3  # inches, width of one column of axes
PAGE_IN = 6.8  # inches, largest width of a figure of a sweep, for a page of 180 mm
MAX_THINNED = 4  # largest number of curves of which each is thinner than the previous one
SEQUENCE_FROM = 7  # smallest number of ordered values whose colours are shades of a colour map

RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "savefig.dpi": 200,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9")  # Okabe and Ito
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "h")
FILLS = ("full", "none", "left", "top", "right", "bottom")  # of markers; the other half is white
LINES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)), (0, (3, 1, 1, 1, 1, 1)))


@contextmanager
def drawing(changes: Mapping[str, Any] = RC) -> Iterator[None]:
    """Apply ``changes`` to matplotlib's defaults instead of the user's matplotlibrc within the context."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(changes)  # type: ignore[arg-type]
        yield


def disable_invalid_math(canvas: Figure) -> None:
    """Disable math mode in texts whose `$` signs enclose no formula that matplotlib can parse."""
    parser = MathTextParser("path")
    for text in canvas.findobj(Text):
        if isinstance(text, Text) and "$" in text.get_text():
            try:
                parser.parse(text.get_text())
            except ValueError:
                text.set_parse_math(False)


class CurveStyle(NamedTuple):
    """Colour, marker and line of a curve, and the filled part of its markers (``FILLS``).

    ``rank``: the higher, the thinner the curve, so that curves drawn before it remain visible.
    """

    colour: Any
    marker: str
    line: Any
    fill: str = "full"
    rank: int = 0

    def keywords(self) -> dict[str, Any]:
        """Return the keyword arguments of matplotlib's Line2D."""
        hollow = {"markerfacecolor": "white"} if self.fill == "none" else {"fillstyle": self.fill}
        widths = {"linewidth": max(1.8 - 0.3 * self.rank, 1.1), "markersize": max(6.5 - self.rank, 4.0)}
        return {"color": self.colour, "marker": self.marker, "linestyle": self.line, **widths, **hollow}


def curve_styles(by_colour: int, by_line: int, ordered: bool) -> list[list[CurveStyle]]:
    """Return the styles of ``by_colour`` x ``by_line`` curves, distinguished by colour and marker, and by line.

    The filled part of the markers varies with the line style, for points that no line joins. If ``by_line`` is 1,
    line styles vary with the colour, except for shades. ``ordered``: ``SEQUENCE_FROM`` colours or more are shades.
    """
    shades = ordered and by_colour >= SEQUENCE_FROM
    colours = shades_of(by_colour) if shades else [COLOURS[i % len(COLOURS)] for i in range(by_colour)]
    return [
        [
            CurveStyle(
                colours[i], MARKERS[i % len(MARKERS)], LINES[line % len(LINES)], FILLS[j % len(FILLS)], rank
            )
            for j in range(by_line)
            for line, rank in [
                (j, j + 1)
                if by_line > 1
                else (0, 3)
                if shades
                else (i, min(i, 3) if by_colour <= MAX_THINNED else 3)
            ]
        ]
        for i in range(by_colour)
    ]


def shades_of(count: int) -> list[Any]:
    """Return ``count`` (2 or more) colours of a colour map, from dark to light."""
    scale = mpl.colormaps["viridis"]
    return [scale(0.86 * i / (count - 1)) for i in range(count)]
