"""Is a result flagged as one draw of many where, and only where, it is not known to 0.5 %?

    python -m benchmarks.flags [--runs 60] [--planar 10] [--seed 1] [--csv docs/data/flags.csv]

Runs drawn by chance are judged by four records ten times as long, which begin one after the other: their scatter,
times the root of ten, is the standard error of the run. It is itself known to a factor of two; runs so near to the
limit are counted apart.
"""

import argparse
import random
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from bearingsim.config import Case
from bearingsim.simulation import SimulationError, simulate
from bearingsim.store import NOTABLE, is_one_draw

FEATURES = ("velocity@BPFO", "velocity.rms")
DURATION_S, SETTLE_S, LONGER, RECORDS = 0.5, 0.1, 10, 4
UNSURE = 2.0
"""Factor by which the scatter of four records may be off."""
BEARINGS = ("6205", "nf308", "nu206")


class Judged(NamedTuple):
    """Of a run: whether it is chaotic, and flagged; its standard error by longer records (relative)."""

    scene: str
    feature: str
    chaotic: bool
    flagged: bool
    standard_error: float
    right: str


def scene(chance: random.Random, model: str) -> dict[str, Any]:
    """Draw the fields of a case: of light damping, too, under which motions are chaotic."""
    width = chance.uniform(0.2, 2.0)
    return {
        "bearing": chance.choice(BEARINGS),
        "model": model,
        "speed": f"{chance.uniform(600, 3000):.0f} rpm",
        "load": f"{10.0 ** chance.uniform(1.5, 2.7):.0f} N",
        "clearance": f"{chance.uniform(0, 20):.1f} um",
        "contact": {"damping": {"law": "kraemer", "beta": f"{10.0 ** chance.uniform(-1.0, 1.0):.2f} us"}},
        "defect": {"shape": "rectangular", "length": "8 mm", "width": f"{width:.2f} mm", "depth": "0.05 mm"},
        "record": [],
    }


def judged(fields: dict[str, Any]) -> list[Judged]:
    """Compute a run and the longer ones."""
    run = simulate(Case.model_validate(fields | {"duration": DURATION_S, "settle": SETTLE_S}))
    table = pd.DataFrame([run.features])
    flagged = {name: bool(is_one_draw(table, name).iloc[0]) for name in FEATURES}
    longer = []
    if run.info["period_passes"] == 0:
        length = LONGER * DURATION_S
        for n in range(RECORDS):
            begins = {"duration": length, "settle": SETTLE_S + n * length, "step_check": False}
            longer.append(simulate(Case.model_validate(fields | begins)).features)
    chaotic, name = run.features["chaotic"] == 1.0, f"{fields['bearing']} {fields['model']} {fields['load']}"
    return [
        Judged(name, feature, chaotic, flagged[feature], error, verdict(flagged[feature], error))
        for feature in FEATURES
        for error in [standard_error([one[feature] for one in longer])]
    ]


def standard_error(values: list[float]) -> float:
    """That of the run (relative), by the longer records; 0 of a motion that repeats itself."""
    if not values:
        return 0.0
    return float(np.sqrt(LONGER) * np.std(values, ddof=1) / abs(np.mean(values)))


def verdict(flagged: bool, error: float) -> str:
    """`right`, `wrong`, or `near` where four records do not tell."""
    if flagged == (error > NOTABLE):
        return "right"
    return "near" if NOTABLE / UNSURE < error < NOTABLE * UNSURE else "wrong"


def main() -> None:
    """Judge all runs, and write the table. Exit code 1 if a flag is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=60)
    parser.add_argument("--planar", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path)
    asked = parser.parse_args()
    chance, rows = random.Random(asked.seed), list[Judged]()
    for n in range(asked.runs):
        fields = scene(chance, "planar" if n < asked.planar else "rollers")
        try:
            rows += judged(fields)
        except SimulationError as error:
            print(f"left out: {fields}: {error}", flush=True)
            continue
        for row in rows[-len(FEATURES) :]:
            print(*(f"{key}={value}" for key, value in row._asdict().items()), flush=True)
    table = pd.DataFrame(rows)
    if asked.csv:
        table.to_csv(asked.csv, index=False, float_format="%.3g", lineterminator="\n")
    print(table.groupby(["feature", "right"]).size().to_string())
    sys.exit(int((table["right"] == "wrong").any()))


if __name__ == "__main__":
    main()
