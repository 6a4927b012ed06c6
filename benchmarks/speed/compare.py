"""Whether a run of the benchmark has lost speed beyond noise, against the committed baseline.

    python -m benchmarks.speed.compare [NEW [BASELINE]]

Seconds of two runs are not compared: clocks differ, and neighbours. Each measure stands over the yardstick of its
own run, and two such ratios are compared. A loss is one beyond what both runs vary by between their rounds, and
beyond LEAST. Exit status 1 if there is any.
"""

import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

RESULT, BASELINE = Path("results/bench/bench.json"), Path(__file__).with_name("baseline.json")
LEAST = 0.1  # a smaller change is none: so much a loop depends on where it comes to lie in memory
DOUBT = 2.0  # of the noise of both runs


class Change(NamedTuple):
    """A measure's cost over the baseline's (1), and how far from 1 it may lie by chance."""

    name: str
    ratio: float
    noise: float

    @property
    def lost(self) -> bool:
        """Whether it costs more, beyond noise."""
        return self.ratio > 1.0 + self.noise

    @property
    def won(self) -> bool:
        """Whether it costs less, beyond noise."""
        return self.ratio < 1.0 / (1.0 + self.noise)

    def __str__(self) -> str:
        word = "LOSS" if self.lost else "gain" if self.won else "same"
        return f"{word}  {self.name}: {self.ratio:.2f} of the baseline (noise {self.noise:.0%})"


def changes(new: dict[str, Any], old: dict[str, Any]) -> list[Change]:
    """Of all measures that both runs have, the worst first."""
    mine, theirs = measures(new), measures(old)
    found = [
        Change(name, cost(mine[name]) / cost(theirs[name]), noise(mine[name], theirs[name]))
        for name in mine
        if name in theirs
    ]
    return sorted(found, key=lambda change: -change.ratio)


def measures(run: dict[str, Any]) -> dict[str, Any]:
    """All that a run has measured."""
    return {name: one for part in run["sections"].values() for name, one in part["measures"].items()}


def cost(one: dict[str, float]) -> float:
    """A measure over its yardstick."""
    return one["seconds"] / one["yardstick"]


def noise(*both: dict[str, float]) -> float:
    """How far two runs may lie apart by chance."""
    return max(LEAST, DOUBT * sum(one["noise"] for one in both))


def gone(new: dict[str, Any], old: dict[str, Any]) -> list[str]:
    """Measures of the baseline that a section which was run no longer has."""
    run = {"sections": {name: part for name, part in old["sections"].items() if name in new["sections"]}}
    return sorted(set(measures(run)) - set(measures(new)))


def main(arguments: list[str]) -> int:
    """Print what has changed; 1 if speed was lost."""
    paths = [*map(Path, arguments), *(RESULT, BASELINE)[len(arguments) :]]
    new, old = (json.loads(path.read_text()) for path in paths)
    if new["machine"]["processor"] != old["machine"]["processor"]:
        print(
            f"The baseline is of another processor ({old['machine']['processor']}): small losses may be its own."
        )
    found = changes(new, old)
    for change in found:
        if change.lost or change.won:
            print(change)
    for name in gone(new, old):
        print(f"gone  {name}")
    lost = sum(change.lost for change in found)
    print(f"{len(found)} measures: {lost} lost, {sum(change.won for change in found)} won, the rest within noise")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
