"""Tables on the terminal; plain and of unlimited width in a pipe."""

import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from bearingsim.text.terminal import plain

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

PIPED_WIDTH = 1000  # characters in a line without a terminal
LONGEST_WORDS = 24  # characters; only longer texts are folded on a narrow terminal
GAP = 3  # characters between columns


def terminal_width() -> int | None:
    """Return the width of the terminal in letters; None if stdout is not a terminal."""
    from rich.console import Console

    return Console().width if sys.stdout.isatty() else None


def console(least: int = 0) -> "Console":
    """Return the console of stdout, at least ``least`` letters wide (NO_COLOR honoured)."""
    from rich.console import Console

    class Screen(Console):
        """Console that strips control characters from texts."""

        def render_str(self, text: str, **more: Any) -> "Text":
            return super().render_str(plain(text), **more)

    return Screen(width=max(terminal_width() or PIPED_WIDTH, least), highlight=False)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> None:
    """Print a table; the first ``words`` columns are text, the others numbers. Cells are never cropped."""
    from rich import box
    from rich.table import Table

    lines = list(rows)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for number, (head, least) in enumerate(zip(heads, least_widths(heads, lines, words), strict=True)):
        text = number < words
        table.add_column(head, justify="left" if text else "right", overflow="fold", min_width=least)
    for line in lines:
        table.add_row(*line)
    console(needed_width(heads, lines, words)).print(table, markup=False)


def needed_width(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> int:
    """Compute the width in letters of a table without cropped cells."""
    return sum(width + GAP for width in least_widths(heads, rows, words)) - GAP


def least_widths(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> list[int]:
    """Compute the least width of each column: its longest entry, at most LONGEST_WORDS for text."""
    longest = [max(map(len, "\n".join(column).split("\n"))) for column in zip(heads, *rows, strict=True)]
    return [min(length, LONGEST_WORDS) if i < words else length for i, length in enumerate(longest)]


def significant(value: float, digits: int = 3) -> str:
    """Format a number with a few significant digits, as an integer up to 1e6; `-` for nan or infinity."""
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    return f"{value:.{digits}g}" if abs(value) < 10**digits or abs(value) >= 1e6 else f"{value:.0f}"


def span(values: Iterable[float]) -> str:
    """Format a range as `0.31` or `0.31 .. 0.42`, `-` without a finite positive number."""
    finite = [value for value in values if math.isfinite(value) and value > 0.0]
    low, high = (significant(pick(finite, default=math.nan)) for pick in (min, max))
    return low if low == high else f"{low} .. {high}"
