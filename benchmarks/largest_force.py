"""Coverage of the standard error of the largest force, for records of the same motion.

    python -m benchmarks.largest_force [--cases 10] [--seed 1] [--csv docs/data/largest_force.csv]

`planar` with a free cage, 15 to 600 N, housings as in `benchmarks/start.py`. Each scene is computed for 12 s and
divided into records of 0.5 s and of 1 s. Two records are covered if their largest forces differ by at most two
combined standard errors, or by 0.1 %. Exit code 1 if less than 95 % of the pairs of all scenes are covered.
"""

import random
import sys
from typing import Any, NamedTuple

import numpy as np

from bearingsim.config import Case
from bearingsim.simulation import choice
from bearingsim.simulation.comparison import PEAK_FORCE_COLUMN
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.start_error import PARTS, largest_force_error
from benchmarks import start
from benchmarks.campaign import table

DURATION_S, RECORDS_S = 12.0, (0.5, 1.0)
MIN_COVERED = 0.95


class Coverage(NamedTuple):
    """Result of a scene: cage revolutions per second; then for each record length (0.5 and 1 s) the relative
    standard deviation of the largest force, the median of the stated error, and the fraction of pairs covered.
    """

    scene: str
    turns: float
    scatter_short: float
    stated_short: float
    covered_short: float
    scatter_long: float
    stated_long: float
    covered_long: float


def scene(rng: random.Random) -> dict[str, Any]:
    """Draw the fields of a case."""
    load = f"{15.0 * 40.0 ** rng.random():.0f} N"
    return start.scene(rng) | {"model": "planar", "load": load, "duration": DURATION_S, "record": []}


def coverage(forces: np.ndarray, passes: int, rollers: int) -> tuple[float, float, float]:
    """Return scatter, stated error and covered fraction of pairs, for records of ``passes`` forces each."""
    records = forces[: len(forces) // passes * passes].reshape(-1, passes)
    quarter = passes // PARTS // rollers * rollers or passes // PARTS
    largest = records.max(axis=1) / records.max(axis=1).mean()
    stated = np.array([largest_force_error(record, rollers, quarter) for record in records])
    first, second = np.triu_indices(len(records), 1)
    bounds = np.maximum(start.MAX_ERROR, start.ERROR_MULTIPLE * np.hypot(stated[first], stated[second]))
    fraction = np.mean(np.abs(largest[first] - largest[second]) <= bounds)
    return float(largest.std(ddof=1)), float(np.median(stated)), float(fraction)


def compare_records(fields: dict[str, Any]) -> Coverage:
    """Compute a scene, and compare its records."""
    setup = set_up(choice.resolve(Case.model_validate(fields)))
    case, grid = setup.case, setup.grid
    forces = integrate(setup).peaks[int(case.settle_s * grid.rate) + 1 :, PEAK_FORCE_COLUMN]
    rollers = case.bearing.rollers
    short, long = (coverage(forces, int(duration * grid.rate), rollers) for duration in RECORDS_S)
    rig = fields["rig"]
    name = f"{fields['bearing']} {rig['ring_mass']} {fields['speed']} {fields['load']} {fields['clearance']}"
    return Coverage(name, grid.rate / rollers, *short, *long)


def main() -> None:
    """Measure all scenes and write the table. Exit code 1 if too few pairs are covered."""
    frame = table(__doc__, 10, scene, compare_records)
    shares = frame[["covered_short", "covered_long"]].mean()
    print(f"covered: {shares.iloc[0]:.1%} of pairs of 0.5 s, {shares.iloc[1]:.1%} of 1 s")
    sys.exit(int(shares.min() < MIN_COVERED))


if __name__ == "__main__":
    main()
