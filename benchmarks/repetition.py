"""Test of periodicity detection: records completed from one period, compared with full integrations.

    python -m benchmarks.repetition [--seed 1] [--ring 40] [--rollers 40] [--planar 20] [--spatial 20] [--jobs 2]

Random scenes that may be periodic (healthy or with outer-race defects, kinematic cage) are integrated until they
are periodic, and over the full record of at least 60 ball passes. Printed for each model:

stopped   number of runs stopped early, among scenes whose full run is periodic (to 1e-8 over its last ten passes)
wrong     number of runs stopped early with an error of a feature above 1e-6, relative to the larger of the feature
          and 1/1000 of the RMS of its quantity (phases: in rad, only of lines above 1/1000 of the RMS)
passes    passes computed until the stop: median and maximum; median of the full run
worst     largest error of a feature, over all runs stopped early
"""

import argparse
from collections.abc import Iterator
from math import inf, pi
from typing import Any
from unittest import mock

import numpy as np
from joblib import Parallel, delayed

from bearingsim.config import Case
from bearingsim.simulation import SimulationError, integration, simulate
from bearingsim.simulation.repetition import Search

PASSES, LAST_PASSES = 60, 10
PERIODIC_DIFFERENCE, MAX_ERROR = 1e-8, 1e-6
ROUNDING = {"tilt.max": 1e-12}  # rad; smaller values count as zero


def draw(model: str, number: int, seed: int) -> Case:
    """Draw a scene of the model with a record of 60 ball passes."""
    rng = np.random.default_rng([seed, number, len(model)])

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    ball = model in ("ring", "rollers") and rng.random() < 0.15
    laws = [
        {"law": "kraemer", "beta": log_uniform(1e-6, 3e-5)},
        {"law": "hunt-crossley", "chi": log_uniform(2.0, 80.0)},
    ]

    def defect(low: float, high: float) -> dict[str, Any]:
        is_long = rng.random() < 0.5
        length = (3e-3 if ball else 12e-3) if is_long else (2e-3 if ball else 4e-3)
        shape = {"shape": str(rng.choice(["rectangular", "triangular", "circular"])), "length": length}
        shape |= {"width": 1e-3 * log_uniform(0.1, 3.0), "depth": 1e-6 * log_uniform(0.5, 50.0)}
        return shape | {"angle": float(rng.uniform(low, high)) * pi / 180.0}

    share = rng.random()  # 10 % healthy, 15 % with two defects
    defects = [defect(0.0, 60.0)] * (share > 0.1) + [defect(-60.0, 0.0)] * (share > 0.85)
    fields = {
        "bearing": "6205" if ball else "nf308",
        "model": model,
        "method": "verlet",
        "speed": log_uniform(300.0, 6000.0) * pi / 30.0,
        "load": log_uniform(10.0, 1000.0),
        "clearance": 1e-6 * float(rng.uniform(-5.0, 30.0)),
        "contact": {"damping": laws[int(rng.random() < 0.5)]},
        "defects": defects,
        "step_check": False,
        "record": [],
    } | ({"cage": {"motion": "kinematic"}} if model in ("planar", "spatial") else {})
    case = Case.model_validate(fields)
    return case.model_copy(update={"duration": (PASSES + 0.5) / case.bearing.ball_pass_frequency(case.speed)})


class RecordingSearch(Search):
    """Search that records differences between passes, and never stops a run."""

    last_differences: list[float]

    def add_pass(self, window: np.ndarray, y: np.ndarray, peaks: np.ndarray) -> tuple[int, float]:
        """Record the differences and return no period."""
        super().add_pass(window, y, peaks)
        self.last_differences = [max(d[-LAST_PASSES:]) for d in self.differences.values() if len(d) >= LAST_PASSES]
        return 0, 0.0


def full_record(case: Case) -> tuple[Any, float]:
    """Return the full record, and the difference between its last passes at the best period."""
    searches: list[RecordingSearch] = []

    def make_search(*arguments: Any) -> RecordingSearch:
        searches.append(RecordingSearch(*arguments))
        return searches[-1]

    with mock.patch.object(integration, "Search", make_search):
        record = simulate(case)
    return record, min(searches[-1].last_differences, default=inf)


def errors(features: dict[str, float], reference: dict[str, float]) -> Iterator[tuple[float, str]]:
    """Yield the error of each feature, as defined above."""
    for name, value in reference.items():
        if np.isnan(value) or name.endswith("-scatter"):
            continue
        rms = reference.get(f"{name.partition('@')[0].partition('.')[0]}.rms", 0.0)
        if name.endswith(".phase"):
            if reference[name.removesuffix(".phase")] > 1e-3 * rms:
                difference = features[name] - value
                yield abs((difference + pi) % (2.0 * pi) - pi), name
        elif max(abs(value), abs(features[name])) > ROUNDING.get(name, 0.0):
            yield abs(features[name] - value) / max(abs(value), 1e-3 * rms), name


def compare_scene(model: str, number: int, seed: int) -> dict[str, Any]:
    """Compute a scene with and without early stop."""
    case = draw(model, number, seed)
    try:
        short, (full, last_difference) = simulate(case), full_record(case)
    except SimulationError as error:
        return {"model": model, "scene": number, "failed": str(error)}
    worst, name = max(errors(short.features, full.features))
    computed, passes, period = (short.info[key] for key in ("passes_computed", "passes", "period_passes"))
    stopped = bool(period)
    return {
        "model": model,
        "scene": number,
        "failed": "",
        "computed": computed,
        "passes": passes,
        "period": period,
        "last": last_difference,
        "stopped": stopped,
        "periodic": last_difference <= PERIODIC_DIFFERENCE,
        "wrong": stopped and worst > MAX_ERROR,
        "worst": worst if stopped else 0.0,
        "name": name,
    }


def main() -> None:
    """Compute the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--each", action="store_true", help="print a line per scene")
    for model, count in (("ring", 40), ("rollers", 40), ("planar", 20), ("spatial", 20)):
        parser.add_argument(f"--{model}", type=int, default=count)
    options = parser.parse_args()
    scenes = [
        (model, number)
        for model in ("spatial", "planar", "rollers", "ring")
        for number in range(getattr(options, model))
    ]
    all_rows = Parallel(n_jobs=options.jobs, batch_size=1)(
        delayed(compare_scene)(*scene, options.seed) for scene in scenes
    )
    for model in ("ring", "rollers", "planar", "spatial"):
        rows = [row for row in all_rows if row["model"] == model and not row["failed"]]
        failed = sum(row["model"] == model for row in all_rows) - len(rows)
        stops = [row for row in rows if row["stopped"]]
        periodic = [row for row in rows if row["periodic"]]
        worst = max(stops, key=lambda row: row["worst"], default={"worst": 0.0, "name": "-", "scene": "-"})
        passes = sorted(row["computed"] for row in stops)
        print(
            f"{model:8} {len(rows)} scenes ({failed} failed): {len(periodic)} periodic,"
            f" {sum(row['stopped'] for row in periodic)} of them stopped; {len(stops)} stopped,"
            f" {sum(row['wrong'] for row in stops)} wrong; passes {np.median(passes or [0]):.0f}"
            f" (max {max(passes, default=0)}) of {np.median([row['passes'] for row in rows] or [0]):.0f};"
            f" worst {worst['worst']:.1e} ({worst['name']}, scene {worst['scene']})"
        )
    for row in all_rows:
        if row["failed"] or row["wrong"] or (row["periodic"] and not row["stopped"]) or options.each:
            print(row)


if __name__ == "__main__":
    main()
