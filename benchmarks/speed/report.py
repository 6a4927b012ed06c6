"""What a section of the benchmark finds, as text and as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from benchmarks.speed.timing import Measure, exponent

MOST_GROWTH = 1.05  # what doubles the work may double the cost, and little more


class Target(NamedTuple):
    """A number that is to be at most, or at least, so much. ``doubt``: why it may say nothing here."""

    name: str
    found: float
    at_most: float | None = None
    at_least: float | None = None
    doubt: str = ""

    @property
    def met(self) -> bool:
        """Whether it is."""
        low = self.at_least is None or self.found >= self.at_least
        return low and (self.at_most is None or self.found <= self.at_most)

    def __str__(self) -> str:
        bound = f"at most {self.at_most:.3g}" if self.at_most is not None else f"at least {self.at_least:.3g}"
        doubt = f"; {self.doubt}" if self.doubt else ""
        return f"{'met' if self.met else 'MISSED'}: {self.name}: {self.found:.3g} ({bound}{doubt})"


Prices = dict[tuple[str, str], float]
"""Numbers for rows of ``bearingsim/simulation/prices.csv``, by what and name."""


class Curve(NamedTuple):
    """A work-precision curve: error against CPU seconds a simulated second; ours, or a peer's."""

    scene: str
    method: str
    ours: bool
    settings: list[float]
    errors: list[float]
    cpu_s: list[float]


@dataclass
class Section:
    """What a section finds.

    measures: what ``compare.py`` looks at; targets: what is to be reached; curves, bars: what the chart shows;
    missing: peers that are not here, and why; prices: what is proposed.
    """

    measures: dict[str, Measure] = field(default_factory=dict)
    targets: list[Target] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    tables: list[tuple[str, list[str], list[list[Any]]]] = field(default_factory=list)
    missing: dict[str, str] = field(default_factory=dict)
    prices: Prices = field(default_factory=dict)

    def table(self, title: str, head: list[str], rows: list[list[Any]]) -> None:
        """Add a table; numbers are told to three digits."""
        self.tables.append((title, head, rows))

    def grows(self, what: str, size: str, sizes: Sequence[float], costs: Sequence[float]) -> None:
        """Add how the cost of ``what`` grows with ``size``."""
        power = exponent(sizes, costs)
        rows = [[n, 1e6 * cost] for n, cost in zip(sizes, costs, strict=True)]
        self.table(f"CPU time of {what} against {size}: exponent {power:.2f}", [size, "us"], rows)
        self.targets.append(Target(f"exponent of {what} in {size}", power, at_most=MOST_GROWTH))

    def lines(self) -> list[str]:
        """The report, as Markdown."""
        out: list[str] = []
        for title, head, rows in self.tables:
            out += [f"**{title}**", "", row_of(head), row_of(["---"] * len(head)), *map(row_of, rows), ""]
        out += [f"- {target}" for target in self.targets]
        out += [f"- {peer} is not here: {why}" for peer, why in self.missing.items()]
        return [*out, ""]

    def as_json(self) -> dict[str, Any]:
        """What a file keeps of it."""
        return {
            "measures": {name: one._asdict() for name, one in self.measures.items()},
            "targets": [one._asdict() | {"met": one.met} for one in self.targets],
            "curves": [one._asdict() for one in self.curves],
            "tables": [{"title": title, "head": head, "rows": rows} for title, head, rows in self.tables],
            "missing": self.missing,
        }


def row_of(cells: Sequence[Any]) -> str:
    """A row of a Markdown table."""
    return "| " + " | ".join(f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in cells) + " |"
