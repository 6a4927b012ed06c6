"""Step error of runs, compared with the stated step error.

    python -m benchmarks.step_error [--scenes 40] [--seed 1] [--jobs 2] [--each]

Random scenes of `ring`, `rollers` and `planar` (``draw``) are run by default, and again with an eighth of the step
(for an adaptive method, a thousandth of the tolerance). Printed for line, RMS and largest force:

within    number of non-chaotic scenes whose change is at most `step_error.line`, `.rms`, `.force`
ratio     change over stated error: median, 95 % quantile, largest
change    largest change

and the number of scenes with all three within. For chaotic scenes only the RMS is compared, with the stated error
plus `rms_scatter`. The factors of ``simulation/step_check.py`` were calibrated with seed 11, and tested with
others.
"""

import argparse
from math import pi
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim.config import Case
from bearingsim.simulation import SimulationError, choice, simulate
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.record import Record, Usage
from bearingsim.simulation.simulate import _attempt_simulation

QUANTITIES = ("line", "rms", "force")
STEP_FACTOR = 1 / 8
SHORTEST, LONGEST, PASSES = 0.1, 0.5, 12.0  # limits of a record in s, and its number of ball passes


def draw(number: int, seed: int) -> Case:
    """Draw a scene: model, bearing, load, clearance, speed, damping, and mostly a defect of any race."""
    rng = np.random.default_rng([seed, number])

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    model = str(rng.choice(["rollers", "ring", "planar"], p=[0.5, 0.25, 0.25]))
    ball = model != "planar" and rng.random() < 0.15
    laws = [None, {"law": "kraemer", "beta": log(1e-6, 3e-5)}, {"law": "hunt-crossley", "chi": log(10.0, 80.0)}]
    law = laws[int(rng.choice(3, p=[0.4, 0.3, 0.3]))]
    race = str(rng.choice(["outer", "inner", "roller"], p=[0.6, 0.3, 0.1]))
    length = 2e-3 if ball else 12e-3 if rng.random() < 0.5 else 4e-3
    defect: dict[str, Any] = {
        "shape": str(rng.choice(["rectangular", "triangular", "circular"])),
        "length": length,
    }
    defect |= {"width": 1e-3 * log(0.15, 3.0), "depth": 1e-6 * log(1.0, 50.0), "race": race}
    defect |= {"roller": 1} if race == "roller" else {"angle": float(rng.uniform(0.0, 60.0)) * pi / 180.0}
    fields: dict[str, Any] = {
        "bearing": "6205" if ball else "nf308",
        "model": model,
        "speed": log(300.0, 6000.0) * pi / 30.0,
        "load": log(30.0, 2000.0),
        "clearance": 1e-6 * float(rng.uniform(-5.0, 20.0)),
        "defects": [defect] if rng.random() > 0.1 else [],
        "record": [],
        "duration": SHORTEST,
    }
    fields |= {"contact": {"damping": law}} if law else {}
    fields |= {"cage": {"motion": "kinematic"}} if model == "planar" and rng.random() < 0.5 else {}
    case = Case.model_validate(fields)
    rate = case.bearing.ball_pass_frequency(case.speed)
    return case.model_copy(update={"duration": max(SHORTEST, min(LONGEST, PASSES / rate))})


def values(record: Record, case: Case) -> np.ndarray:
    """Return the line (largest of several), RMS and largest force."""
    features = record.features
    line = max(features[f"velocity@{name}"] for name in fault_lines(case))
    return np.array([line, features["velocity.rms"], features["outer_force.max"]])


def compare_steps(number: int, seed: int) -> dict[str, Any]:
    """Compute a scene by default and with a finer step."""
    case = draw(number, seed)
    row: dict[str, Any] = {"scene": number, "model": case.model, "race": [defect.race for defect in case.defects]}
    try:
        record = simulate(case)
        method, step_part = str(record.info["method"]), STEP_FACTOR * float(record.info["step_part"])
        unchecked = choice.with_method(case.model_copy(update={"step_check": False}), method)
        finer = _attempt_simulation(choice.Attempt(unchecked, step_part), Usage.now())
    except SimulationError as error:
        return row | {"failed": str(error)}
    reference = values(finer, case)
    change = np.abs(values(record, case) - reference) / np.where(reference == 0.0, 1.0, reference)
    stated = [record.features[f"step_error.{name}"] for name in QUANTITIES]
    if record.features["chaotic"]:
        change[[0, 2]], stated = 0.0, [0.0, stated[1] + record.features["rms_scatter"], 0.0]
    change = np.where(np.isnan(change), 0.0, change)
    return row | {
        "failed": "",
        "method": method,
        "chaotic": record.features["chaotic"],
        "said": stated,
        "change": change,
    }


def main() -> None:
    """Compute the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--each", action="store_true", help="a line for each scene")
    options = parser.parse_args()
    rows = Parallel(n_jobs=options.jobs, batch_size=1)(
        delayed(compare_steps)(number, options.seed) for number in range(options.scenes)
    )
    done = [row for row in rows if not row["failed"]]
    stated, change = (np.array([row[name] for row in done]) for name in ("said", "change"))
    ratio = change / stated
    regular = np.array([not row["chaotic"] for row in done])
    print(f"{len(rows)} scenes, {len(rows) - len(done)} failed, {np.sum(~regular)} chaotic")
    for k, name in enumerate(QUANTITIES):
        ratios = ratio[regular, k]
        print(
            f"{name:6} within {np.sum(ratios <= 1.0)} of {len(ratios)}; ratio {np.median(ratios):.2f},"
            f" {np.percentile(ratios, 95):.2f}, {ratios.max():.2f}; change at most {change[regular, k].max():.2g}"
        )
    within = np.all(ratio <= 1.0, axis=1)
    print(f"all within: {within.sum()} of {len(done)}")
    for row, is_within in zip(done, within, strict=True):
        if options.each or not is_within:
            numbers = {key: [f"{x:.1e}" for x in row[key]] for key in ("said", "change")}
            print({**row, **numbers})
    for row in rows:
        if row["failed"]:
            print(row)


if __name__ == "__main__":
    main()
