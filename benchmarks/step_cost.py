"""Cost of an integrator step, for each model and method, healthy and with defects.

    python -m benchmarks.step_cost [--csv FILE] [--steps N] [--rounds N] [--only WORD]

NF308, 1800 rpm, 150 N. All variants are compiled first. Then they run in turn, N steps per round with the monitor
of `simulate`, and the fastest round of each is reported, so that disturbances of the machine affect all variants
equally. The second block is `rollers` with other numbers of rollers, which shows the cost of padding, the third
block other contact laws. ``--only`` selects the variants whose scene begins with a word. Columns: ns per step;
step chosen by `auto` (us); resulting CPU time (s) per simulated second.
"""

import argparse
import time
from collections.abc import Iterator
from itertools import chain, product
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION, NoSamples, advance_and_sample
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.run_setup import make_monitor
from benchmarks.rows import write_csv

BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"}
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BOWL = SLOT | {"shape": "circular", "length": "9 mm"}
SCENES: dict[str, dict] = {"healthy": {}, "0.8 mm slot": {"defect": SLOT}, "9 mm bowl": {"defect": BOWL}}
SCENES |= {f"0.8 mm slot, {race}": {"defect": SLOT | {"race": race}} for race in ("inner", "roller")}
INTEGRATED = tuple((model, method) for model in ("ring", "rollers", "planar") for method in ("verlet", "rk4"))
PAIRS = (("static", None), *INTEGRATED, ("spatial", "verlet"))
ROLLERS = (8, 13, 16, 24, 32)
GENERAL = {"law": "general", "coefficient": 100.0}
LAWS: dict[str, dict] = {"chi": {"damping": {"law": "hunt-crossley", "chi": 50.0}}}
LAWS |= {"kraemer": {"damping": {"law": "kraemer", "beta": 1e-5}}}
LAWS |= {f"m3 = {m3:g}": {"damping": GENERAL | {"indentation_exponent": m3}} for m3 in (0.0, 1.0, 1.5, 2.0)}
LAWS |= {"m1 = 1.2": {"stiffness": {"law": "constant", "coefficient": 1e6, "exponent": 1.2}}}
LAWS |= {"m1 = 1.2, m3 = 1.5": LAWS["m1 = 1.2"] | LAWS["m3 = 1.5"]}
RELATIVE_COST = {"static": 50, "spatial": 20}  # cost of a step relative to other models, approximately


def variant(labels: dict[str, Any], case: Case, model: Any) -> dict[str, Any]:
    """Prepare a variant for timing: labels for the table, method, model, static equilibrium."""
    grid = time_grid.make_grid(case)
    model = assemble.with_friction_lag(model, grid.step)
    y, _ = assemble.start(case, model)
    row = labels | {"auto_step_us": round(1e6 * grid.step, 3)}
    monitor, method = make_monitor(grid, choice.limits(case)), assemble.method(case, grid.step)
    return {"row": row, "method": method, "model": model, "monitor": monitor, "y": y, "step": 0}


def models_and_methods() -> Iterator[dict[str, Any]]:
    """Yield all models with all methods, in each scene."""
    for scene, defect in SCENES.items():
        for model, method in PAIRS:
            case = Case.model_validate(BASE | defect | {"model": model} | ({"method": method} if method else {}))
            labels = {"scene": scene, "model": model, "method": method or "", "rollers": case.bearing.rollers}
            yield variant(labels, case, assemble.model(case))


def roller_counts() -> Iterator[dict[str, Any]]:
    """Yield `rollers` with other numbers of rollers, not all of which would fit geometrically."""
    case = Case.model_validate(BASE | {"clearance": "-1 um", "method": "verlet"})
    for Z in ROLLERS:
        model = assemble.model(case)
        model = model._replace(bearing=model.bearing._replace(Z=Z))
        yield variant({"scene": "lanes", "model": "rollers", "method": "verlet", "rollers": Z}, case, model)


def contact_laws() -> Iterator[dict[str, Any]]:
    """Yield `rollers` and `planar` with each contact law, some of which prevent vectorisation."""
    for (name, law), model in product(LAWS.items(), ("rollers", "planar")):
        case = Case.model_validate(BASE | {"model": model, "method": "verlet", "contact": law})
        labels = {"scene": f"law {name}", "model": model, "method": "verlet", "rollers": case.bearing.rollers}
        yield variant(labels, case, assemble.model(case))


def run(entry: dict[str, Any], steps: int) -> float:
    """Return the CPU time (ns) per step of a round; simulated time continues from round to round."""
    count = max(1, steps // RELATIVE_COST.get(entry["row"]["model"], 1))
    rows = np.array([*RING_MOTION, lay.Q_O, lay.Q_I])
    out = np.empty((len(rows), count))
    start = time.thread_time_ns()
    _, outcome, _ = advance_and_sample(
        entry["method"], entry["model"], entry["monitor"], entry["step"], entry["y"], rows, out, NoSamples()
    )
    elapsed = time.thread_time_ns() - start
    if outcome != SUCCESS:
        raise RuntimeError(f"{entry['row']}: the run was stopped")
    entry["step"] += count
    return elapsed / count


def main() -> None:
    """Time all variants in turn; print the table, or write it to a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv")
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    all_variants = chain(models_and_methods(), roller_counts(), contact_laws())
    variants = [entry for entry in all_variants if entry["row"]["scene"].startswith(options.only)]
    for entry in variants:
        run(entry, options.steps)
    times = [[run(entry, options.steps) for entry in variants] for _ in range(options.rounds)]
    best = np.min(times, axis=0)
    costs = [
        entry["row"]
        | {"ns_per_step": round(ns, 1), "cpu_s_per_simulated_s": round(1e-9 * ns / entry["method"].h, 4)}
        for entry, ns in zip(variants, best.tolist(), strict=True)
    ]
    write_csv((entry["row"] | cost for entry, cost in zip(variants, costs, strict=True)), options.csv)


if __name__ == "__main__":
    main()
