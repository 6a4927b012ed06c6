"""Error against step, in fractions of the step limit of the method at impact.

    python -m benchmarks.step_fraction [--csv FILE]

Each scene is computed by each method with several fractions of ``Limits.at_impact``, and compared with RK4 at 1/20
of it: relative errors of the velocity line at BPFO, of the RMS, and of the largest contact force. The fractions
used for automatic steps, and the refusal near 1, are based on this table.
"""

import argparse
from itertools import chain
from unittest import mock

from bearingsim.config import Case
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.simulate import SimulationError, simulate
from benchmarks.rows import write_csv

FRACTIONS = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
FEATURES = ("velocity@BPFO", "velocity.rms", "outer_force.max")
BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "duration": "0.2 s", "settle": "30 ms"}
DEFECT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
SCENES: dict[str, dict] = {
    "healthy": {},
    "0.2 mm slot": {"defect": DEFECT | {"width": "0.2 mm"}},
    "0.8 mm slot": {"defect": DEFECT},
    "2 mm slot": {"defect": DEFECT | {"width": "2 mm"}},
    "0.8 mm slot, 300 N": {"defect": DEFECT, "load": "300 N"},
    "0.8 mm slot, 40 deg": {"defect": DEFECT | {"angle": "40 deg"}},
    "0.8 mm slot, 1 um deep": {"defect": DEFECT | {"depth": "1 um"}},
    "0.8 mm slot, 10 um clearance": {"defect": DEFECT, "clearance": "10 um"},
    "0.8 mm slot, 25 um clearance": {"defect": DEFECT, "clearance": "25 um"},
    "0.8 mm slot, 6000 rpm": {"defect": DEFECT, "speed": "6000 rpm"},
    "0.8 mm bowl": {"defect": DEFECT | {"shape": "circular"}},
    "0.8 mm groove, 5 um": {"defect": DEFECT | {"shape": "triangular", "depth": "5 um"}},
    "0.8 mm slot, chi 5 s/m": {"defect": DEFECT, "contact": {"damping": {"chi": "5 s/m"}}},
    "0.8 mm slot, chi 50 s/m": {"defect": DEFECT, "contact": {"damping": {"chi": "50 s/m"}}},
    "0.8 mm slot, beta 10 us": {"defect": DEFECT, "contact": {"damping": {"beta": "10 us"}}},
}


def features(case: Case, step: float) -> dict[str, float] | str:
    """Return the features at a step that may be too long, or the reason why the run stopped."""
    with mock.patch.object(time_grid, "requested_step", return_value=step):
        try:
            return simulate(case.model_copy(update={"step": step, "step_check": False})).features  # not halved
        except SimulationError as error:
            return error.reason


def compare(name: str, model: str) -> list[dict]:
    """Compute the rows of a scene."""
    settings = BASE | SCENES[name] | {"model": model}
    exact_case = Case.model_validate(settings | {"method": "rk4"})
    exact = features(exact_case, choice.limits(exact_case).at_impact / 20.0)
    if isinstance(exact, str):
        raise RuntimeError(f"{name}: the reference was stopped: {exact}")
    rows = []
    for method in ("verlet", "rk4"):
        case = Case.model_validate(settings | {"method": method})
        limit = choice.limits(case).at_impact
        for fraction in FRACTIONS:
            result = features(case, fraction * limit)
            row: dict = {"scene": name, "model": model, "method": method, "fraction": fraction}
            row["step_us"] = round(1e6 * fraction * limit, 3)
            if isinstance(result, str):
                row["stopped"] = result
            else:
                row |= {key: f"{abs(result[key] / exact[key] - 1.0):.1e}" for key in FEATURES}
            rows.append(row)
    return rows


def main() -> None:
    """Print the table, and write it to a file if requested."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv")
    parser.add_argument("--model", default="rollers")
    parser.add_argument("--scene", action="append", choices=list(SCENES))
    options = parser.parse_args()
    columns = ["scene", "model", "method", "fraction", "step_us", *FEATURES, "stopped"]
    scenes = chain.from_iterable(compare(name, options.model) for name in options.scene or SCENES)
    write_csv(scenes, options.csv, columns)


if __name__ == "__main__":
    main()
