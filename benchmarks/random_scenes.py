"""Convergence of the default method and step in random scenes, which must converge or be refused.

    python benchmarks/random_scenes.py [--scenes 300] [--seed 5] [--jobs 2] [--csv FILE]

Scenes are drawn over wide ranges (``draw``): load, clearance, speed, stiffness, damping, defects, models. Each is
run with ``step_check: strict``, long enough to resolve the defect line (at least 0.15 s), with at most 20 s of CPU
time. A scene refused as chaotic and too short is run for 1.5 times the requested duration, if that is affordable.
Then it is run again with the chosen method, half the step and a tenth of the tolerance; line and RMS are compared.
Outcomes:

converged   the line changes by less than 1 % (a line under 1e-3 of the RMS: by less than 1e-5 of the RMS),
            and so does the RMS; for a motion reported as chaotic, the RMS alone
refused     before or during the run, with a reason; refusals only because of a short chaotic record are counted
else        any other outcome, of which there must be none; ``nothing to compare`` means that no line is available
"""

import argparse
import csv
import os
import sys
import time
from collections import Counter
from math import inf, isnan, nan, pi
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.core.geometry.kinematics import (
    ball_pass_frequency_inner,
    ball_pass_frequency_outer,
    ball_spin_frequency,
    fundamental_train_frequency,
)
from bearingsim.simulation import time_grid
from bearingsim.simulation.accuracy import QUIET_LINE
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.run_setup import TooChaotic
from bearingsim.simulation.simulate import Record, SimulationError, simulate

HELD = 0.01
RESOLVED = 2.1  # duration times spacing of lines, to separate them despite some slip
TWO = {"converged", "refused"}
LONGEST_JOB = 20.0  # s of estimated CPU time
LONGEST_CHAOS = 10.0  # the same, for a record extended because of its RMS
MARGIN = 1.5  # times the requested duration of a chaotic record (2.5 standard deviations become 3.1)
LONGER = 3  # attempts with a longer record
SHORTEST = 0.15  # s
PASSES = 4.0  # ball passes at the kinematic speed of the cage
STEEL = 8.06e4 * 12.0 ** (8.0 / 9.0)  # N/mm^(10/9): Palmgren's line contact of the NF308's rollers
LAWS = ("chi", "kraemer", "general")
SCENE = ["scene", "model", "load_N", "clearance_um", "speed_rpm", "law", "stiffness", "damping", "m3"]
DEFECT = ["race", "shape", "width_mm", "depth_um"]
FOUND = [
    "outcome",
    "method",
    "step_us",
    "part",
    "duration_s",
    "chaotic",
    "only_chaotic",
    "line",
    "rms",
    "said_line",
    "said_rms",
    "cpu_s",
    "reason",
]


def draw(number: int, seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Draw a scene; return its description and the fields of its case."""
    rng = np.random.default_rng([seed, number])

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    model = str(rng.choice(["rollers", "ring", "planar"], p=[0.75, 0.15, 0.1]))
    law = str(rng.choice(LAWS, p=[0.5, 0.2, 0.3])) if model == "rollers" else "chi"
    told: dict[str, Any] = {"scene": number, "model": model, "law": law}
    told |= {"load_N": log(5.0, 3000.0), "clearance_um": float(rng.uniform(-10.0, 60.0))}
    told |= {"speed_rpm": log(60.0, 12000.0), "stiffness": log(0.1, 100.0)}
    damping: dict[str, Any]
    if law == "chi":
        told["damping"] = log(0.3, 200.0)
        damping = {"law": "hunt-crossley", "chi": told["damping"]}
    elif law == "kraemer":
        told["damping"] = log(1e-6, 3e-5)
        damping = {"law": "kraemer", "beta": told["damping"]}
    else:
        told |= {"damping": log(0.1, 1e6), "m3": int(rng.integers(0, 3))}
        damping = {"law": "general", "coefficient": told["damping"], "indentation_exponent": float(told["m3"])}
    stiffness = {"law": "constant", "coefficient": STEEL * told["stiffness"], "exponent": 10.0 / 9.0}
    race = str(rng.choice(["none", "outer", "inner", "roller"], p=[0.1, 0.5, 0.2, 0.2]))
    told |= {"race": race, "shape": str(rng.choice(["rectangular", "triangular", "circular"], p=[0.6, 0.2, 0.2]))}
    told |= {"width_mm": log(0.1, 4.0), "depth_um": log(0.1, 1000.0)}
    defect = {"race": race, "shape": told["shape"], "length": 12e-3}
    defect |= {"width": 1e-3 * told["width_mm"], "depth": 1e-6 * told["depth_um"]}
    fields = {
        "bearing": "nf308",
        "model": model,
        "load": told["load_N"],
        "clearance": 1e-6 * told["clearance_um"],
        "speed": told["speed_rpm"] * pi / 30.0,
        "contact": {"stiffness": stiffness, "damping": damping},
        "defects": [] if race == "none" else [defect],
    }
    return told, fields


def case_of(fields: dict[str, Any]) -> Case:
    """Make a case long enough for three ball passes with cage slip, and for resolving the defect line."""
    case = Case.model_validate(fields | {"duration": 1.0, "step_check": "strict"})
    rate = case.bearing.ball_pass_frequency(case.speed)
    apart = min((spacing(case, name) for name in fault_lines(case) if name != "BPFO"), default=inf)
    return case.model_copy(update={"duration": max(SHORTEST, PASSES / rate, RESOLVED / apart)})


def spacing(case: Case, name: str) -> float:
    """Compute the distance (Hz) of a line from the next line, or from zero, at kinematic speeds."""
    bearing, shaft = case.bearing, case.speed / (2.0 * pi)
    sizes = case.speed, bearing.roller_diameter, bearing.pitch_diameter
    units = (
        ball_pass_frequency_outer(*sizes, bearing.rollers),
        ball_pass_frequency_inner(*sizes, bearing.rollers),
        ball_spin_frequency(*sizes),
        fundamental_train_frequency(*sizes),
        shaft,
    )
    at = {line: float(np.dot(multiples, units)) for line, multiples in LINES.items()}
    return min(at[name], *(abs(at[name] - other) for line, other in at.items() if line != name))


def finer(case: Case, found: Record) -> Case:
    """Return the case with the chosen method, half the step and a tenth of the tolerance."""
    info = found.info
    update: dict[str, Any] = {"method": info["method"], "step": 0.5 * float(info["step_s"]), "step_check": False}
    if np.isfinite(float(info["tolerance"])):
        update["tolerance"] = 0.1 * float(info["tolerance"])
    return case.model_copy(update=update)


def changes(case: Case, found: Record, other: Record) -> tuple[float, float]:
    """Return the relative changes of the defect line (largest of several, or nan) and of the RMS."""
    rms = other.features["velocity.rms"] or 1.0
    names = [f"velocity@{name}" for name in fault_lines(case)]
    pairs = [(found.features[name], other.features[name]) for name in names]
    known = [abs(a - b) / max(b, QUIET_LINE * rms) for a, b in pairs if np.isfinite(a) and np.isfinite(b)]
    return max(known, default=nan), abs(found.features["velocity.rms"] / rms - 1.0)


def judge(number: int, seed: int) -> dict[str, Any]:
    """Return the row of a scene."""
    time_grid.MAX_CPU = LONGEST_JOB
    told, fields = draw(number, seed)
    case = case_of(fields)
    began = time.process_time()
    try:
        case, found = computed(case)
    except SimulationError as error:
        told |= {"outcome": "refused", "reason": str(error), "cpu_s": time.process_time() - began}
        return told | {"only_chaotic": int(isinstance(error, TooChaotic))}
    info, features = found.info, found.features
    told |= {"method": info["method"], "step_us": 1e6 * float(info["step_s"]), "part": info["step_part"]}
    told["duration_s"] = case.duration
    told |= {"chaotic": int(features["chaotic"]), "cpu_s": time.process_time() - began}
    told |= {"said_line": features["step_error.line"], "said_rms": features["step_error.rms"]}
    try:
        time_grid.MAX_CPU = inf
        line, rms = changes(case, found, simulate(finer(case, found)))
    except SimulationError as error:
        return told | {"outcome": "finer run failed", "reason": str(error)}
    return told | {"line": line, "rms": rms, "outcome": outcome(bool(told["chaotic"]), line, rms)}


def computed(case: Case) -> tuple[Case, Record]:
    """Compute a case; a chaotic one for as long as requested, if affordable. Return case and record."""
    for _ in range(LONGER):
        try:
            return case, simulate(case)
        except TooChaotic as error:
            longer = MARGIN * error.duration
            if longer / case.duration * time_grid.estimate(case).cpu_seconds > LONGEST_CHAOS:
                raise
            case = case.model_copy(update={"duration": longer})
    return case, simulate(case)


def outcome(chaotic: bool, line: float, rms: float) -> str:
    """Classify the changes due to half the step."""
    if isnan(rms) or (isnan(line) and not chaotic):
        return "nothing to compare"
    return "converged" if (rms if chaotic else max(line, rms)) < HELD else "changed"


def main() -> None:
    """Run all scenes; print counts and all scenes neither converged nor refused; write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv")
    options = parser.parse_args()
    numbers = range(options.first, options.first + options.scenes)
    counts: Counter[str] = Counter()
    only_chaotic = 0
    with open(options.csv or os.devnull, "w", newline="") as target:
        table = csv.DictWriter(target, SCENE + DEFECT + FOUND, lineterminator="\n")
        table.writeheader()
        pool = Parallel(options.jobs, return_as="generator_unordered")
        for row in pool(delayed(judge)(n, options.seed) for n in numbers):
            counts[row["outcome"]] += 1
            only_chaotic += row.get("only_chaotic", 0)
            told = {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
            table.writerow(told)
            target.flush()
            if row["outcome"] not in TWO:
                print(", ".join(f"{key} {value}" for key, value in told.items()), flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())))
    print(f"refused only because chaotic and too short for their RMS: {only_chaotic}")
    sys.exit(not set(counts) <= TWO)


if __name__ == "__main__":
    main()
