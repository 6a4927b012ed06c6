"""Tables of pages, written from the measurements in ``docs/data``.

A page has a block ``<!-- table: NAME -->`` ... ``<!-- end of table -->``; `make docs-reference` writes the table
of that name between the two lines.
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

from docs.scripts import campaign_tables, cost_tables
from docs.scripts.navigation import DOCS

BLOCK = re.compile(r"(<!-- table: ([\w ]+) -->\n)(?:(?!<!-- end of table).*\n)*(<!-- end of table -->)")
TABLES: dict[str, Callable[[], str]] = {
    "models": cost_tables.models,
    "step cost": lambda: cost_tables.steps("ns_per_step", "ns per step"),
    "run cost": lambda: cost_tables.steps("cpu_s_per_simulated_s", "CPU s per second"),
    "law cost": cost_tables.laws,
    "lane cost": cost_tables.lanes,
    "arrow": cost_tables.arrow,
    "derivatives": cost_tables.derivatives,
    "start up": cost_tables.start_up,
    "step fractions": cost_tables.step_fractions,
    "random scenes": campaign_tables.random_scenes,
    "promise": campaign_tables.promise,
    "friction": campaign_tables.friction,
    "paper literal": campaign_tables.paper_literal,
    "left out": campaign_tables.left_out,
    "film": campaign_tables.film,
    "slip onset": campaign_tables.slip_onset,
    "double impulse": campaign_tables.double_impulse,
    "diagnosis": campaign_tables.diagnosis,
    "diagnosis thresholds": campaign_tables.diagnosis_thresholds,
}
"""Function that writes each table, by the name in its block."""


def pages() -> Iterator[Path]:
    """Yield the pages that have blocks."""
    yield from (page for page in sorted(DOCS.rglob("*.md")) if BLOCK.search(page.read_text(encoding="utf-8")))


def current(page: Path) -> str:
    """Return the text of a page with its tables written anew."""
    text = page.read_text(encoding="utf-8")
    return BLOCK.sub(lambda block: f"{block[1]}{TABLES[block[2]]()}\n{block[3]}", text)
