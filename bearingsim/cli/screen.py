"""Tables on the terminal; plain and of unlimited width in a pipe."""

import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from bearingsim.text.numbers import significant
from bearingsim.text.terminal import plain

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

PIPED_WIDTH = 1000  # characters in a line without a terminal
MAX_TEXT_WIDTH = 24  # characters; only longer texts are folded on a narrow terminal
COLUMN_GAP = 3  # characters between columns


def terminal_width() -> int | None:
    """Return the width of the terminal in characters; None if stdout is not a terminal."""
    from rich.console import Console

    return Console().width if sys.stdout.isatty() else None


def console(min_width: int = 0) -> "Console":
    """Return the console of stdout, at least ``min_width`` characters wide (NO_COLOR honoured)."""
    from rich.console import Console

    class Screen(Console):
        """Console that strips control characters from texts."""

        def render_str(self, text: str, **options: Any) -> "Text":
            return super().render_str(plain(text), **options)

    return Screen(width=max(terminal_width() or PIPED_WIDTH, min_width), highlight=False)


def print_table(headers: Sequence[str], rows: Iterable[Sequence[str]], text_columns: int = 1) -> None:
    """Print a table; the first ``text_columns`` columns are text, the others numbers. Cells are never cropped."""
    from rich import box
    from rich.table import Table

    cells = list(rows)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for index, (header, min_width) in enumerate(
        zip(headers, min_widths(headers, cells, text_columns), strict=True)
    ):
        is_text = index < text_columns
        table.add_column(header, justify="left" if is_text else "right", overflow="fold", min_width=min_width)
    for row in cells:
        table.add_row(*row)
    console(table_width(headers, cells, text_columns)).print(table, markup=False)


def table_width(headers: Sequence[str], rows: Iterable[Sequence[str]], text_columns: int = 1) -> int:
    """Compute the width in characters of a table without cropped cells."""
    return sum(width + COLUMN_GAP for width in min_widths(headers, rows, text_columns)) - COLUMN_GAP


def min_widths(headers: Sequence[str], rows: Iterable[Sequence[str]], text_columns: int = 1) -> list[int]:
    """Compute the minimum width of each column: its longest entry, at most MAX_TEXT_WIDTH for text."""
    longest = [max(map(len, "\n".join(column).split("\n"))) for column in zip(headers, *rows, strict=True)]
    return [
        min(length, MAX_TEXT_WIDTH) if index < text_columns else length for index, length in enumerate(longest)
    ]


def span(values: Iterable[float]) -> str:
    """Format a range as `0.31` or `0.31 .. 0.42`, `-` without a finite positive number."""
    finite = [value for value in values if math.isfinite(value) and value > 0.0]
    low, high = (significant(pick(finite, default=math.nan)) for pick in (min, max))
    return low if low == high else f"{low} .. {high}"
