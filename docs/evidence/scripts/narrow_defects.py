"""Error of `step: auto` over narrow defects at high speed, where the damping force jumps within a step.

    python docs/evidence/scripts/narrow_defects.py [--scenes 20]

Seeded random scenes of `rollers` for each method: 2000-12 000 rpm, 100-1000 N, full-length slots of 0.1-0.4 mm,
chi 20-100 s/m; `auto` against a sixteenth of the crossing's fiftieth. Prints the largest and the median relative
error (%) of the velocity line at BPFO, of its RMS and of the largest contact force.
"""

import argparse
from unittest import mock

import numpy as np

from bearingsim.config import Case
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.simulate import simulate

FEATURES = ("velocity@BPFO", "velocity.rms", "outer_force.max")


def scene(random: np.random.Generator, method: str) -> Case:
    """A random case."""
    speed, load = random.uniform(2000, 12000), random.uniform(100, 1000)
    chi, width = random.uniform(20, 100), 10 ** random.uniform(-4, -3.4)
    slot = {"shape": "rectangular", "length": 0.012, "width": width, "depth": 5e-5}
    settings = {"bearing": "nf308", "model": "rollers", "method": method, "duration": 0.03, "settle": 0.02}
    settings |= {"step_check": False}
    law = {"contact": {"damping": {"chi": chi}}}
    return Case.model_validate(settings | law | {"speed": speed * np.pi / 30, "load": load, "defect": slot})


def errors(case: Case) -> list[float]:
    """Relative errors (%) of the features."""
    found, limits = simulate(case).features, choice.limits(case)
    fine = min(time_grid.requested_step(case), limits.crossing / 50) / 16
    with mock.patch.object(time_grid, "requested_step", return_value=fine):
        exact = simulate(case).features
    return [100.0 * abs(found[name] / exact[name] - 1.0) for name in FEATURES]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=20)
    count = parser.parse_args().scenes
    random = np.random.default_rng(11)
    found: dict[str, list[list[float]]] = {"verlet": [], "rk4": []}
    for _ in range(count):
        for method, rows in found.items():
            rows.append(errors(scene(random, method)))
    print("method, largest and median error (%) of", ", ".join(FEATURES))
    for method, rows in found.items():
        table = np.array(rows)
        over = int((table.max(axis=1) > 2.0).sum())
        print(method, table.max(axis=0).round(2), np.median(table, axis=0).round(3), f"{over} of {count} over 2 %")


if __name__ == "__main__":
    main()
