"""Accuracy and savings of records that end early by `until`.

    python benchmarks/until.py [--scenes 40] [--seed 1] [--accuracy 0.005] [--jobs 2]

Random scenes of `rollers` that may be periodic (``benchmarks/repetition.py``), 2 s long, are drawn until enough of
them end early because line and RMS are accurate. Each is also computed in full. Printed are

within   number whose line and RMS are within three stated standard errors of those of the full record
late     number with more than twice the needed passes, that is those required by the scatter of the full record,
         but at least the minimum number of passes
saved    median fraction of ball passes not computed
"""

import argparse
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bearingsim.simulation import SimulationError, ending, simulate
from bearingsim.simulation.settling import settled
from benchmarks.repetition import draw

DURATION, MOST = 2.0, 600
ERRORS = {"standard_error_line": "velocity@BPFO", "standard_error_rms": "velocity.rms"}


def tried(number: int, seed: int, wanted: float) -> dict[str, Any]:
    """Compute a scene with an early end, and in full."""
    case = draw("rollers", number, seed).model_copy(update={"duration": DURATION, "method": "auto"})
    try:
        short = simulate(case.model_copy(update={"until": wanted}))
        computed, passes = int(short.info["passes_computed"]), int(short.info["passes"])
        if short.info["period_passes"] or computed == passes:
            return {"scene": number, "early": False}
        whole = simulate(case.model_copy(update={"until": 1e-9, "method": short.info["method"]}))
    except SimulationError as error:
        return {"scene": number, "early": False, "failed": str(error)}
    off = {
        error: abs(short.features[name] / whole.features[name] - 1.0) / float(short.info[error])
        for error, name in ERRORS.items()
    }
    scatter = max(float(whole.info[error]) for error in ERRORS)
    settle = settled(case).settle_s
    begun = int(settle * passes / (settle + case.duration))
    needed = begun + max(ending.fewest(case), (passes - begun) * (scatter / wanted) ** 2)
    return {"scene": number, "early": True, "off": off, "computed": computed, "needed": needed, "passes": passes}


def main() -> None:
    """Draw scenes until enough end early, and print the table."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--scenes", type=int, default=40)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--accuracy", type=float, default=0.005)
    asked.add_argument("--jobs", type=int, default=2)
    given = asked.parse_args()
    found: list[dict[str, Any]] = []
    drawn = 0
    while len(found) < given.scenes and drawn < MOST:
        some = range(drawn, drawn + 8 * given.jobs)
        each = (delayed(tried)(n, given.seed, given.accuracy) for n in some)
        rows = Parallel(n_jobs=given.jobs, batch_size=1)(each)
        found += [row for row in rows if row["early"]]
        drawn += len(some)
    found = found[: given.scenes]
    worst = np.array([max(row["off"].values()) for row in found])
    late = np.array([row["computed"] / row["needed"] for row in found])
    saved = np.array([1.0 - row["computed"] / row["passes"] for row in found])
    print(f"{drawn} drawn, {len(found)} end early")
    print(f"within three standard errors: {np.sum(worst <= 3.0)} (largest {worst.max():.2f})")
    print(
        f"over twice the passes needed: {np.sum(late > 2.0)} (median {np.median(late):.2f}, most {late.max():.2f})"
    )
    print(f"saved: {np.median(saved):.0%}")
    for row, off in zip(found, worst, strict=True):
        if off > 3.0 or row["computed"] > 2.0 * row["needed"]:
            print(row)


if __name__ == "__main__":
    main()
