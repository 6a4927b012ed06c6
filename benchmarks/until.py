"""Accuracy and savings of records that end early by `until`.

    python -m benchmarks.until [--scenes 40] [--seed 1] [--accuracy 0.005] [--jobs 2]

Random scenes of `rollers` that may be periodic (``benchmarks/repetition.py``), 2 s long, are drawn until enough of
them end early because line and RMS are accurate. Each is also computed in full. Printed are

within   number whose line and RMS are within three of their standard errors of those of the full record
late     number with more than twice the needed passes, that is those required by the scatter of the full record,
         but at least the minimum number of passes
saved    median fraction of ball passes not computed
"""

import argparse
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim.simulation import SimulationError, ending, simulate
from bearingsim.simulation.settling import resolve_settling
from benchmarks.repetition import draw

DURATION, MAX_SCENES = 2.0, 600
FEATURES = {"standard_error_line": "velocity@BPFO", "standard_error_rms": "velocity.rms"}


def compare_scene(number: int, seed: int, accuracy: float) -> dict[str, Any]:
    """Compute a scene with an early end, and in full."""
    case = draw("rollers", number, seed).model_copy(update={"duration": DURATION, "method": "auto"})
    try:
        short = simulate(case.model_copy(update={"until": accuracy}))
        computed, passes = int(short.info["passes_computed"]), int(short.info["passes"])
        if short.info["period_passes"] or computed == passes:
            return {"scene": number, "early": False}
        full = simulate(case.model_copy(update={"until": 1e-9, "method": short.info["method"]}))
    except SimulationError as error:
        return {"scene": number, "early": False, "failed": str(error)}
    errors = {
        error: abs(short.features[name] / full.features[name] - 1.0) / float(short.info[error])
        for error, name in FEATURES.items()
    }
    scatter = max(float(full.info[error]) for error in FEATURES)
    settle = resolve_settling(case).settle_s
    settling = int(settle * passes / (settle + case.duration))
    needed = settling + max(ending.min_passes(case), (passes - settling) * (scatter / accuracy) ** 2)
    return {
        "scene": number,
        "early": True,
        "off": errors,
        "computed": computed,
        "needed": needed,
        "passes": passes,
    }


def main() -> None:
    """Draw scenes until enough end early, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--accuracy", type=float, default=0.005)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    early_rows: list[dict[str, Any]] = []
    drawn = 0
    while len(early_rows) < options.scenes and drawn < MAX_SCENES:
        numbers = range(drawn, drawn + 8 * options.jobs)
        tasks = (delayed(compare_scene)(number, options.seed, options.accuracy) for number in numbers)
        rows = Parallel(n_jobs=options.jobs, batch_size=1)(tasks)
        early_rows += [row for row in rows if row["early"]]
        drawn += len(numbers)
    early_rows = early_rows[: options.scenes]
    worst = np.array([max(row["off"].values()) for row in early_rows])
    late = np.array([row["computed"] / row["needed"] for row in early_rows])
    saved = np.array([1.0 - row["computed"] / row["passes"] for row in early_rows])
    print(f"{drawn} drawn, {len(early_rows)} end early")
    print(f"within three standard errors: {np.sum(worst <= 3.0)} (largest {worst.max():.2f})")
    print(
        f"over twice the passes needed: {np.sum(late > 2.0)} (median {np.median(late):.2f}, most {late.max():.2f})"
    )
    print(f"saved: {np.median(saved):.0%}")
    for row, error in zip(early_rows, worst, strict=True):
        if error > 3.0 or row["computed"] > 2.0 * row["needed"]:
            print(row)


if __name__ == "__main__":
    main()
