"""Comparison of a benchmark run with the committed baseline.

    python -m benchmarks.speed.compare [NEW [BASELINE]]

CPU times are not compared directly, because clock rates and the load by other processes differ. Each measure is
divided by the yardstick of its own run, and these ratios are compared. A loss is an increase beyond the variation
between rounds of both runs, and beyond MIN_NOISE. Exit code 1 if there is any.
"""

import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

RESULT, BASELINE = Path("results/bench/bench.json"), Path(__file__).with_name("baseline.json")
MIN_NOISE = 0.1  # smaller changes are due to the alignment of loops in memory
NOISE_FACTOR = 2.0  # times the summed noise of both runs


class Change(NamedTuple):
    """Cost of a measure relative to the baseline, and the largest random difference of this ratio from 1."""

    name: str
    ratio: float
    noise: float

    @property
    def is_loss(self) -> bool:
        """Increase of the cost beyond noise."""
        return self.ratio > 1.0 + self.noise

    @property
    def is_gain(self) -> bool:
        """Decrease of the cost beyond noise."""
        return self.ratio < 1.0 / (1.0 + self.noise)

    def __str__(self) -> str:
        verdict = "LOSS" if self.is_loss else "gain" if self.is_gain else "same"
        return f"{verdict}  {self.name}: {self.ratio:.2f} of the baseline (noise {self.noise:.0%})"


def changes(new: dict[str, Any], old: dict[str, Any]) -> list[Change]:
    """List the changes of all measures of both runs, the largest first."""
    new_measures, old_measures = measures(new), measures(old)
    results = [
        Change(
            name,
            cost(new_measures[name]) / cost(old_measures[name]),
            noise(new_measures[name], old_measures[name]),
        )
        for name in new_measures
        if name in old_measures
    ]
    return sorted(results, key=lambda change: -change.ratio)


def measures(run: dict[str, Any]) -> dict[str, Any]:
    """Return all measures of a run."""
    return {name: measure for section in run["sections"].values() for name, measure in section["measures"].items()}


def cost(measure: dict[str, float]) -> float:
    """Divide a measure by its yardstick."""
    return measure["seconds"] / measure["yardstick"]


def noise(*pair: dict[str, float]) -> float:
    """Compute the largest relative difference of two measures by chance."""
    return max(MIN_NOISE, NOISE_FACTOR * sum(measure["noise"] for measure in pair))


def missing_measures(new: dict[str, Any], old: dict[str, Any]) -> list[str]:
    """List measures of the baseline that a section of the new run lacks."""
    comparable = {
        "sections": {name: section for name, section in old["sections"].items() if name in new["sections"]}
    }
    return sorted(set(measures(comparable)) - set(measures(new)))


def main(arguments: list[str]) -> int:
    """Print the changes; return 1 if there is a loss."""
    paths = [*map(Path, arguments), *(RESULT, BASELINE)[len(arguments) :]]
    new, old = (json.loads(path.read_text()) for path in paths)
    if new["machine"]["processor"] != old["machine"]["processor"]:
        print(
            f"The baseline is of another processor ({old['machine']['processor']}): small losses may be its own."
        )
    found_changes = changes(new, old)
    for change in found_changes:
        if change.is_loss or change.is_gain:
            print(change)
    for name in missing_measures(new, old):
        print(f"gone  {name}")
    losses = sum(change.is_loss for change in found_changes)
    gains = sum(change.is_gain for change in found_changes)
    print(f"{len(found_changes)} measures: {losses} lost, {gains} won, the rest within noise")
    return 1 if losses else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
