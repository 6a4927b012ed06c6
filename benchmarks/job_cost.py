"""CPU time of a job for a second of signal, by model: periodic, and computed in full.

    python -m benchmarks.job_cost --csv docs/data/job_cost.csv

NF308, 1800 rpm, 150 N, a slot of 0.8 mm x 50 um over the whole roller, `method` and `step` automatic, step check
included, compilation excluded. `planar` and `spatial` have a kinematic cage without friction where the response is
to be periodic, and a free cage with dry friction in full; the other models compute all passes by `periodic: false`.
"""

import argparse
import csv
from typing import Any

from bearingsim.config import Case
from bearingsim.simulation import simulate

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "defect": SLOT, "duration": "1 s"}
HELD: dict[str, Any] = {"friction": "none", "cage": {"motion": "kinematic"}}
JOBS: dict[str, dict[str, dict[str, Any]]] = {
    "periodic": {"static": {}, "ring": {}, "rollers": {}, "planar": HELD, "spatial": HELD},
    "in full": {
        "impulse": {"excitation": "impulse-train"},
        **{model: {"periodic": False} for model in ("static", "ring", "rollers")},
        "planar": {},
        "spatial": {},
    },
}
"""Fields of the jobs of each kind by model."""


def cost(kind: str, model: str, fields: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a job; a short one is computed before, so that nothing is compiled."""
    case = BASE | {"model": model} | fields
    simulate(Case.model_validate(case | {"duration": "0.1 s"}))
    info = simulate(Case.model_validate(case)).info
    step_us, cpu_s = round(1e6 * info["step_s"], 3), round(info["cpu_s"], 4)
    return {"response": kind, "model": model, "method": info["method"], "step_us": step_us, "cpu_s": cpu_s}


def main() -> None:
    """Measure all models; write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", required=True)
    options = parser.parse_args()
    rows = [cost(kind, model, fields) for kind, jobs in JOBS.items() for model, fields in jobs.items()]
    with open(options.csv, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
