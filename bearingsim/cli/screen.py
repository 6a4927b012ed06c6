"""Tables on the terminal, plain and as wide as they need to be when piped."""

import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["print_table", "significant"]

PIPED_WIDTH = 1000


def console() -> "Console":
    """The console of stdout (NO_COLOR honoured); wide where no terminal sets a width."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else PIPED_WIDTH, highlight=False)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> None:
    """Print a table; the first ``words`` columns are text, the others numbers."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for number, head in enumerate(heads):
        text = number < words
        table.add_column(head, justify="left" if text else "right", overflow="fold", no_wrap=not text)
    for row in rows:
        table.add_row(*row)
    console().print(table, markup=False)


def significant(value: float, digits: int = 3) -> str:
    """A number with a few significant digits and no exponent where one can do without; a dash for none."""
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    return f"{value:.{digits}g}" if abs(value) < 10**digits or abs(value) >= 1e6 else f"{value:.0f}"
