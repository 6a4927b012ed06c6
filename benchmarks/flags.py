"""Test of the flag for chaotic results, which should mean a standard error above 0.5 %.

    python -m benchmarks.flags [--runs 60] [--planar 10] [--seed 1] [--csv docs/data/flags.csv]

Random runs are compared with four records ten times as long, computed as one and divided into parts as long as the
run. The scatter of the parts is the standard error of the run, with an uncertainty of 11 %. Parts are whole ball
passes, so that all begin at the same angle and cut impacts equally. A flag is `near` if the standard error is
within a factor of two of the limit. Runs in the file are not recomputed.
"""

import argparse
import random
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from bearingsim.config import Case
from bearingsim.simulation import SimulationError, simulate
from bearingsim.simulation.features import compute_statistics
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.record import Record
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.spectral_lines import amplitudes_by_pass, ball_pass_lines
from bearingsim.store import NOTABLE_ERROR, is_uncertain
from bearingsim.store.spread import BLOCK_ERRORS

DURATION_S, SETTLE_S, LENGTH_FACTOR, RECORDS = 0.5, 0.1, 10, 4
NEAR_FACTOR = 2.0
"""Factor around the limit within which the estimate from a run may be on either side."""
BEARINGS = ("6205", "nf308", "nu206")


class FlagResult(NamedTuple):
    """Flag of a feature of a run, and its relative standard errors as stated and from longer records."""

    run: int
    scene: str
    feature: str
    chaotic: bool
    flagged: bool
    stated: float
    standard_error: float
    verdict: str


def scene(rng: random.Random, model: str) -> dict[str, Any]:
    """Draw the fields of a case, including light damping, for which motions are chaotic."""
    width = rng.uniform(0.2, 2.0)
    return {
        "bearing": rng.choice(BEARINGS),
        "model": model,
        "speed": f"{rng.uniform(600, 3000):.0f} rpm",
        "load": f"{10.0 ** rng.uniform(1.5, 2.7):.0f} N",
        "clearance": f"{rng.uniform(0, 20):.1f} um",
        "contact": {"damping": {"law": "kraemer", "beta": f"{10.0 ** rng.uniform(-1.0, 1.0):.2f} us"}},
        "defect": {"shape": "rectangular", "length": "8 mm", "width": f"{width:.2f} mm", "depth": "0.05 mm"},
        "record": [],
    }


def case_of(fields: dict[str, Any]) -> Case:
    """Make the case of a run, with a duration of whole ball passes."""
    case = Case.model_validate(fields | {"duration": DURATION_S, "settle": SETTLE_S})
    rate = case.bearing.ball_pass_frequency(case.speed)
    return case.model_copy(update={"duration": round(DURATION_S * rate) / rate})


def check_flags(number: int, fields: dict[str, Any]) -> list[FlagResult]:
    """Compute a run and the longer records."""
    case = case_of(fields)
    run = simulate(case)
    table, errors = pd.DataFrame([run.features]), standard_errors(case, run)
    name = f"{fields['bearing']} {fields['model']} {fields['load']} {fields['speed']}"
    rows = []
    for feature, error in errors.items():
        flagged, stated = bool(is_uncertain(table, feature).iloc[0]), run.features[BLOCK_ERRORS[feature]]
        chaotic = run.features["chaotic"] == 1.0
        rows.append(FlagResult(number, name, feature, chaotic, flagged, stated, error, verdict(flagged, error)))
    return rows


def standard_errors(case: Case, run: Record) -> dict[str, float]:
    """Return relative standard errors of a run's features, from their scatter over parts of longer records."""
    if run.info["period_passes"] != 0:  # periodic
        return dict.fromkeys(BLOCK_ERRORS, 0.0)
    count = LENGTH_FACTOR * RECORDS
    changes = {"duration": count * case.duration, "method": run.info["method"], "step_check": False}
    setup = set_up(case.model_copy(update=changes), float(run.info["step_part"]))
    raw = integrate(setup)
    parts = [
        setup.case.model_copy(
            update={"duration": case.duration, "settle": setup.case.settle_s + n * case.duration}
        )
        for n in range(count)
    ]
    features = [
        ball_pass_lines(part, amplitudes_by_pass(part, setup.model, setup.grid, raw))
        | compute_statistics(part, setup.grid, raw)
        for part in parts
    ]
    table = pd.DataFrame(features)
    return {name: float(table[name].std() / table[name].mean()) for name in BLOCK_ERRORS}


def verdict(flagged: bool, error: float) -> str:
    """Return `right` or `wrong`, and whether the standard error is `near` the limit."""
    is_near = NOTABLE_ERROR / NEAR_FACTOR < error < NOTABLE_ERROR * NEAR_FACTOR
    return "near, " * is_near + ("right" if flagged == (error > NOTABLE_ERROR) else "wrong")


def main() -> None:
    """Compare all runs and write the table. Exit code 1 if a flag is wrong and not near the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=60)
    parser.add_argument("--planar", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, default=Path("docs/data/flags.csv"))
    options = parser.parse_args()
    rng = random.Random(options.seed)
    scenes = [scene(rng, "planar" if number < options.planar else "rollers") for number in range(options.runs)]
    table = pd.read_csv(options.csv) if options.csv.exists() else pd.DataFrame(columns=FlagResult._fields)
    for number, fields in enumerate(scenes):
        if number in set(table["run"]):
            continue
        try:
            rows = pd.DataFrame(check_flags(number, fields))
        except SimulationError as error:
            print(f"left out: {fields}: {error}", flush=True)
            continue
        print(rows.to_string(index=False, header=False), flush=True)
        table = pd.concat([table, rows], ignore_index=True) if len(table) else rows
        table.to_csv(options.csv, index=False, float_format="%.3g", lineterminator="\n")
    print(table.groupby(["feature", "chaotic", "flagged", "verdict"]).size().to_string())
    sys.exit(int((table["verdict"] == "wrong").any()))


if __name__ == "__main__":
    main()
