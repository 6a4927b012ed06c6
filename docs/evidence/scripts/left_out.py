"""What does a reference without slip leave out? Random scenes with a kinematic cage, and with all of them free.

    python docs/evidence/scripts/left_out.py [--seed 1] [--count 20] [--csv FILE]

The scenes of benchmarks/promise.py whose reference is `planar`. Each is computed three times by it: as the
reference is (nothing rubs, the cage turns at its kinematic speed), with a free cage and dry friction, and with a
free cage, lubricated traction and the drag of oil. Differences are printed with their standard error.
"""

import argparse
import csv
from math import hypot, isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.simulation import SimulationError, simulate
from bearingsim.study import load_study
from benchmarks.promise import KINDS, RMS_SCATTER_FACTOR, draw, kind_of

FREE: dict[str, dict[str, Any]] = {
    "dry friction": {"friction": "static-dynamic"},
    "oil": {"friction": "traction", "drag": {"oil_fraction": 0.1, "oil_viscosity": "0.05 Pa s"}},
}
USUAL = {"model": "planar", "settle": "0.5 s"}  # a cage takes a while to come to its slip
KINEMATIC = {"cage": {"motion": "kinematic"}, "friction": "none"}


def scenes(seed: int, count: int) -> list[dict[str, Any]]:
    """The first scenes in which nothing leans and no ring bends, without their accuracy."""
    found, number = [], 0
    while len(found) < count:
        one = draw(number, seed)
        if "rig" not in one and "offset" not in one["defect"]:
            found.append({name: value for name, value in one.items() if name != "accuracy"})
        number += 1
    return found


def case_of(scene: dict[str, Any], folder: Path) -> Case:
    """A scene as a case."""
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump(scene))
    return load_study(path).cases()[0]


def standard_error(feature: str, found: dict[str, float]) -> float:
    """That of a feature (SI), as far as the record tells."""
    scatter = found.get(f"{feature}-scatter", nan)
    if feature.endswith(".rms"):
        scatter = found[feature] * found["rms_scatter"] / RMS_SCATTER_FACTOR
    return scatter if isfinite(scatter) else 0.0


def rows_of(number: int, scene: dict[str, Any], folder: Path) -> list[dict[str, Any]]:
    """What each kind of free motion changes in a scene."""
    asked = [f"velocity@{FAULT_LINES[scene['defect']['race']]}", "velocity.rms", "outer_force.max"]
    without = simulate(case_of(scene | USUAL | KINEMATIC, folder)).features
    found = []
    for name, free in FREE.items():
        row: dict[str, Any] = {"scene": number, "race": scene["defect"]["race"], "free": name}
        row |= {what: scene[what] for what in ("load", "speed", "clearance")}
        try:
            with_it = simulate(case_of(scene | USUAL | free, folder)).features
        except SimulationError as error:
            found.append(row | {"refused": error.reason})
            continue
        row |= {"slip": with_it["cage.slip.mean"], "chaotic": with_it["chaotic"]}
        for feature in asked:
            kind, size = kind_of(feature), abs(without[feature])
            row[kind] = (with_it[feature] - without[feature]) / size
            row[f"{kind} error"] = hypot(*(standard_error(feature, one) / size for one in (without, with_it)))
        found.append(row)
    return found


def report(rows: list[dict[str, Any]]) -> None:
    """Print medians, largest, and how many are under 1 % or two standard errors."""
    for name in FREE:
        done = [row for row in rows if row["free"] == name and "line" in row]
        slips = [row["slip"] for row in done]
        print(f"{name}: {len(done)} scenes, the cage slips by {min(slips):.2g} to {max(slips):.2g}")
        for kind in KINDS:
            off = np.array([abs(row[kind]) for row in done])
            known = np.array([2.0 * row[f"{kind} error"] for row in done])
            small = int((off <= np.maximum(0.01, known)).sum())
            told = f"{small} of {len(done)} within 1 % or two standard errors"
            print(f"  {kind}: median {np.median(off):.2%}, largest {off.max():.2%}; {told}")


def main() -> None:
    """Compute, write the rows, report."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--count", type=int, default=20)
    asked.add_argument("--csv", type=Path, default=Path("results/left_out.csv"))
    given = asked.parse_args()
    given.csv.parent.mkdir(parents=True, exist_ok=True)
    rows = []
    for number, scene in enumerate(scenes(given.seed, given.count)):
        rows += rows_of(number, scene, given.csv.parent)
        print(*rows[-len(FREE) :], sep="\n", flush=True)
    names = list(dict.fromkeys(name for row in rows for name in row))
    with given.csv.open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    report(rows)


if __name__ == "__main__":
    main()
