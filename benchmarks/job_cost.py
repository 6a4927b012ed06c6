"""CPU time of a job for a second of signal, by model: periodic, and computed in full.

    python -m benchmarks.job_cost [--csv docs/data/job_cost.csv]     or: make job-cost

NF308, 1800 rpm, 150 N, a slot of 0.8 mm x 50 um over the whole roller. Whole jobs with automatic method and step:
settling and step check included, compilation excluded. The cage is kinematic, so that every response is periodic;
`periodic: false` computes all of it. `spatial` in full records 0.3 s, whose cost is scaled.
"""

import argparse
from typing import Any

from bearingsim.config import Case
from bearingsim.simulation import simulate
from benchmarks.rows import write_csv

BASE: dict[str, Any] = {
    "bearing": "nf308",
    "speed": "1800 rpm",
    "load": "150 N",
    "defect": {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"},
}
KINEMATIC = {"friction": "none", "cage": {"motion": "kinematic"}}
MODELS: dict[str, dict[str, Any]] = {
    "impulse": {"excitation": "impulse-train"},
    "static": {},
    "ring": {},
    "rollers": {},
    "planar": KINEMATIC,
    "spatial": KINEMATIC,
}
"""Keys of the case of each model."""
SHORT = {("spatial", "in full"): 0.3}
"""Duration (s) of records other than 1 s."""


def cost(model: str, response: str) -> dict[str, Any]:
    """Return the row of a job; a short one is computed before, so that nothing is compiled."""
    duration = SHORT.get((model, response), 1.0)
    fields = BASE | {"model": model} | MODELS[model] | {"periodic": response == "periodic"}
    simulate(Case.model_validate(fields | {"duration": 0.05}))
    info = simulate(Case.model_validate(fields | {"duration": duration})).info
    return {
        "response": response,
        "model": model,
        "method": info["method"],
        "step_us": round(1e6 * float(info["step_s"]), 3),
        "cpu_s_per_s": round(float(info["cpu_s"]) / duration, 4),
    }


def main() -> None:
    """Measure all models; write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", default="docs/data/job_cost.csv")
    options = parser.parse_args()
    rows = [cost(m, r) for r in ("periodic", "in full") for m in MODELS if (m, r) != ("impulse", "periodic")]
    write_csv(rows, options.csv)


if __name__ == "__main__":
    main()
