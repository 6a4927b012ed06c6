"""Tables on the terminal, plain and as wide as they need to be when piped."""

import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from bearingsim.text.terminal import plain

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

__all__ = ["print_table", "significant", "span"]

PIPED_WIDTH = 1000
LONGEST_WORDS = 24  # longer texts are folded where the terminal is narrow; shorter ones and numbers never are
GAP = 3  # letters between columns


def terminal_width() -> int | None:
    """Letters in a line of the terminal; None where stdout is none and nothing limits the width."""
    from rich.console import Console

    return Console().width if sys.stdout.isatty() else None


def console(least: int = 0) -> "Console":
    """The console of stdout (NO_COLOR honoured), at least so wide; wide where no terminal sets a width."""
    from rich.console import Console

    class Screen(Console):
        """A console that shows the control characters of no text."""

        def render_str(self, text: str, **more: Any) -> "Text":
            return super().render_str(plain(text), **more)

    return Screen(width=max(terminal_width() or PIPED_WIDTH, least), highlight=False)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> None:
    """Print a table; the first ``words`` columns are text, the others numbers. Nothing of it is ever cropped."""
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
    """Letters in a line of a table of which nothing is cropped."""
    return sum(width + GAP for width in least_widths(heads, rows, words)) - GAP


def least_widths(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> list[int]:
    """The least width of each column: its longest entry, or that of a text which may be folded."""
    longest = [max(map(len, "\n".join(column).split("\n"))) for column in zip(heads, *rows, strict=True)]
    return [min(length, LONGEST_WORDS) if i < words else length for i, length in enumerate(longest)]


def significant(value: float, digits: int = 3) -> str:
    """A number with a few significant digits and no exponent where one can do without; a dash for none."""
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    return f"{value:.{digits}g}" if abs(value) < 10**digits or abs(value) >= 1e6 else f"{value:.0f}"


def span(found: Iterable[float]) -> str:
    """`0.31` or `0.31 .. 0.42`; a dash where there is no number."""
    known = [value for value in found if math.isfinite(value) and value > 0.0]
    low, high = (significant(pick(known, default=math.nan)) for pick in (min, max))
    return low if low == high else f"{low} .. {high}"
