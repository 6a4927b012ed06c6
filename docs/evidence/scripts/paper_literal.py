"""Is studies/paper_literal.yaml converged? Each exponent m3 with its method, refined by ten, or by two.

    python docs/evidence/scripts/paper_literal.py [--load 150] [--load 300] [--m3 0] [--seconds 60] [--step 0.01]
                                       [--jobs 2] [--csv FILE]

m3 = 0: the study's cases with tolerances of 1e-3, 1e-4, 1e-5, and recorded twice as often each time. m3 = 1, whose
motion is chaotic: 1e-3 to 1e-7 over 8 s. m3 = 2, which hardly loses energy: steps of 0.04 to 0.005 us over 40 s.
``--seconds``: other durations of what is chaotic. Only averages over many ball passes are numbers of such a
bearing. The standard error of the RMS is that of its square over 16 parts of the record.
"""

import argparse
import csv
import os
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim.config import Case
from bearingsim.simulation import choice
from bearingsim.simulation.limits import step_limits
from bearingsim.simulation.simulate import simulate
from bearingsim.study import load_study

STUDY = Path(__file__).parents[3] / "studies" / "paper_literal.yaml"
TOLERANCES = {0.0: (1e-3, 1e-4, 1e-5), 1.0: (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)}  # by m3
STEPS = (0.04e-6, 0.02e-6, 0.01e-6, 0.005e-6)
JUMPS, UNDAMPED = 0.0, 2.0  # the m3 that is recorded more often, too, and the one that is refined by steps
SECONDS = {1.0: 8.0, 2.0: 40.0}  # by m3, of what is chaotic
PARTS = 16


def m3_of(case: Case) -> float:
    """The exponent of its dashpot."""
    return float(case.contact.damping.model_dump()["indentation_exponent"])


def refined(case: Case, seconds: float | None, steps: list[float] | None) -> list[tuple[str, Case]]:
    """The case with each setting, and the setting's name."""
    m3 = m3_of(case)
    duration = (seconds or SECONDS[m3]) if m3 in SECONDS else case.duration
    fast = case.model_copy(update={"step_check": False, "duration": duration})
    if m3 == UNDAMPED:
        chosen = [1e-6 * step for step in steps] if steps else STEPS
        return [(f"{1e6 * step:g} us", fast.model_copy(update={"step": step})) for step in chosen]
    often = choice.automatic_step(case, step_limits(case))
    found = []
    for k, tolerance in enumerate(TOLERANCES[m3]):
        step = often / 2**k if m3 == JUMPS else often
        found.append((f"{tolerance:.0e}", fast.model_copy(update={"tolerance": tolerance, "step": step})))
    return found


def standard_error(velocity: np.ndarray) -> float:
    """Of the RMS of a record, relative: by the scatter of its square between ``PARTS`` parts."""
    squares = np.array([np.mean(part**2) for part in np.array_split(velocity, PARTS)])
    return float(0.5 * np.std(squares, ddof=1) / np.mean(squares) / sqrt(PARTS))


def row(setting: str, case: Case) -> dict[str, Any]:
    """What one run gives."""
    record = simulate(case)
    found = record.features
    return {
        "load_N": f"{case.load:g}",
        "m3": m3_of(case),
        "method": case.method,
        "setting": setting,
        "duration_s": f"{case.duration:g}",
        "bpfo_um_s": f"{1e6 * found['velocity@BPFO']:.6g}",
        "bpfo_standard_error": f"{found['velocity@BPFO-scatter'] / found['velocity@BPFO']:.2g}",
        "rms_um_s": f"{1e6 * found['velocity.rms']:.6g}",
        "rms_standard_error": f"{standard_error(record.velocity[:, 0]):.2g}",
        "largest_force_N": f"{found['outer_force.max']:.4g}",
        "cpu_s": f"{record.info['cpu_s']:.3g}",
    }


def main() -> None:
    """Print the rows as they come, in any order; write the table in order."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--load", type=float, action="append")
    parser.add_argument("--m3", type=float, action="append")
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--step", type=float, action="append", help="us, of m3 = 2: these alone")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv", default=os.devnull)
    options = parser.parse_args()
    cases = load_study(STUDY).cases()
    wanted = [
        case
        for case in cases
        if case.load in (options.load or [case.load]) and m3_of(case) in (options.m3 or [0.0, 1.0, 2.0])
    ]
    runs = [run for case in wanted for run in refined(case, options.seconds, options.step)]
    rows = []
    for found in Parallel(options.jobs, return_as="generator_unordered")(delayed(row)(*run) for run in runs):
        print(", ".join(f"{key} {value}" for key, value in found.items()), flush=True)
        rows.append(found)
    with open(options.csv, "w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(sorted(rows, key=lambda one: (one["load_N"], one["m3"])))


if __name__ == "__main__":
    main()
