"""Error of the automatic step with form: random cases, each repeated at half of its step.

    python docs/evidence/scripts/form_steps.py [--count 40] [--seed 1]

Bearing, speed (600 to 6000 rpm), load, clearance, a defect or none, and waviness of any surfaces with orders up to
500 are random. The change of the defect's line and of the RMS is compared with `step_error`.
"""

import argparse
from typing import Any

import numpy as np

from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.simulation.simulate import SimulationError, simulate

SIZES = {"nf308": 12e-3, "nu210": 11e-3, "6205": 0.8e-3}
LOADS = {"nf308": (150.0, 4000.0), "nu210": (500.0, 8000.0), "6205": (100.0, 2000.0)}


def draw(rng: np.random.Generator) -> dict[str, Any]:
    """Draw the fields of a case."""
    bearing = str(rng.choice([*SIZES]))
    low, high = LOADS[bearing]
    surfaces: dict[str, Any] = {"seed": int(rng.integers(1000))}
    names = [name for name in ("outer", "inner", "rollers") if rng.random() < 0.6] or ["outer"]
    for name in names:
        size = float(rng.uniform(0.05e-6, 0.4e-6)) * (0.3 if name == "rollers" else 1.0)
        surfaces[name] = {"spectrum": {"amplitude": size, "orders": [2, int(rng.integers(20, 500))]}}
    if rng.random() < 0.3:
        surfaces.setdefault("rollers", {})["diameter"] = {"scatter": float(rng.uniform(0.1e-6, 1e-6))}
    shape = "circular" if bearing == "6205" else "rectangular"
    race = str(rng.choice(["outer", "outer", "inner"]))
    defect = {"shape": shape, "length": SIZES[bearing], "width": 0.8e-3, "depth": 20e-6, "race": race}
    fields = {"bearing": bearing, "speed": float(rng.uniform(63.0, 630.0)), "surfaces": surfaces, "record": []}
    load = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    fields |= {"load": load, "clearance": float(rng.choice([0.0, 2e-6]))}
    fields |= {"model": "rollers", "method": "verlet", "duration": 0.4}
    return fields | ({"defect": defect} if rng.random() < 0.6 else {})


def main() -> None:
    """Print the share of cases within the bounds of their steps, and the others."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, within, compared, chaotic, failed = np.random.default_rng(options.seed), 0, 0, 0, 0
    for number in range(options.count):
        case = Case.model_validate(draw(rng))
        try:
            coarse = simulate(case)
            step = 0.5 * float(coarse.info["step_s"])
            fine = simulate(case.model_copy(update={"step": step, "step_check": False}))
        except SimulationError as error:
            failed += 1
            print(number, f"failed: {error}")
            continue
        line = f"velocity@{FAULT_LINES[case.defects[0].race] if case.defects else 'BPFO'}"
        changes = [abs(coarse.features[name] / fine.features[name] - 1.0) for name in (line, "velocity.rms")]
        bounds = [coarse.features["step_error.line"], coarse.features["step_error.rms"]]
        if coarse.features["chaotic"]:
            chaotic += 1
            continue
        compared += 1
        ok = all(change <= bound for change, bound in zip(changes, bounds, strict=True))
        within += ok
        if not ok:
            print(number, case.bearing.name, changes, bounds)
    print(f"{within} of {compared} cases within their step error; {chaotic} chaotic, {failed} failed")


if __name__ == "__main__":
    main()
