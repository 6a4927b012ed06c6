"""Results of a section of the benchmark, as text and as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from benchmarks.speed.timing import Measure, exponent

MAX_GROWTH = 1.05  # largest exponent of the cost over the amount of work


class Target(NamedTuple):
    """Bound of a number, above or below. ``doubt``: reason why the result may be meaningless."""

    name: str
    found: float
    at_most: float | None = None
    at_least: float | None = None
    doubt: str = ""

    @property
    def met(self) -> bool:
        """Check that the number is within its bounds."""
        low = self.at_least is None or self.found >= self.at_least
        return low and (self.at_most is None or self.found <= self.at_most)

    def __str__(self) -> str:
        bound = f"at most {self.at_most:.3g}" if self.at_most is not None else f"at least {self.at_least:.3g}"
        doubt = f"; {self.doubt}" if self.doubt else ""
        return f"{'met' if self.met else 'MISSED'}: {self.name}: {self.found:.3g} ({bound}{doubt})"


Prices = dict[tuple[str, str], float]
"""Values for rows of ``bearingsim/simulation/prices.csv``, by the columns `what` and `name`."""


class Curve(NamedTuple):
    """Work-precision curve: error against CPU time (s) per simulated second; ``ours`` or of a peer."""

    scene: str
    method: str
    ours: bool
    settings: list[float]
    errors: list[float]
    cpu_s: list[float]


@dataclass
class Section:
    """Results of a section.

    measures: for ``compare.py``; targets: bounds; curves: for the chart; tables: title, columns and rows; missing:
    packages that are not installed, with reasons; prices: proposed values.
    """

    measures: dict[str, Measure] = field(default_factory=dict)
    targets: list[Target] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    tables: list[tuple[str, list[str], list[list[Any]]]] = field(default_factory=list)
    missing: dict[str, str] = field(default_factory=dict)
    prices: Prices = field(default_factory=dict)

    def add_table(self, title: str, columns: list[str], rows: list[list[Any]]) -> None:
        """Add a table; numbers are printed with three digits."""
        self.tables.append((title, columns, rows))

    def add_growth(self, name: str, size: str, sizes: Sequence[float], costs: Sequence[float]) -> None:
        """Add a table and a target for the growth of the cost of ``name`` with ``size``."""
        power = exponent(sizes, costs)
        rows = [[n, 1e6 * cost] for n, cost in zip(sizes, costs, strict=True)]
        self.add_table(f"CPU time of {name} against {size}: exponent {power:.2f}", [size, "us"], rows)
        self.targets.append(Target(f"exponent of {name} in {size}", power, at_most=MAX_GROWTH))

    def lines(self) -> list[str]:
        """Return the report as Markdown."""
        out: list[str] = []
        for title, columns, rows in self.tables:
            out += [f"**{title}**", "", row_of(columns), row_of(["---"] * len(columns)), *map(row_of, rows), ""]
        out += [f"- {target}" for target in self.targets]
        out += [f"- {peer} is not here: {reason}" for peer, reason in self.missing.items()]
        return [*out, ""]

    def to_json(self) -> dict[str, Any]:
        """Return the content for a JSON file."""
        return {
            "measures": {name: entry._asdict() for name, entry in self.measures.items()},
            "targets": [entry._asdict() | {"met": entry.met} for entry in self.targets],
            "curves": [entry._asdict() for entry in self.curves],
            "tables": [{"title": title, "head": columns, "rows": rows} for title, columns, rows in self.tables],
            "missing": self.missing,
        }


def row_of(cells: Sequence[Any]) -> str:
    """Format a row of a Markdown table."""
    return "| " + " | ".join(f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in cells) + " |"
