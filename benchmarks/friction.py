"""Accuracy and cost of studies with an `accuracy`, compared with a full model with friction.

    python -m benchmarks.friction [--light 60] [--loaded 20] [--seed N] [--csv docs/data/friction.csv] [--out DIR]

A scene is a study of one case without a friction setting. It requests 2 % for the defect line, the largest force
and, if it is light, the RMS, which friction changes even under load. The result is compared with `planar` with its
default cage and friction, for 1 s, or 3 s if that is chaotic. Light scenes have 15 to 300 N, loaded scenes 500 to
5000 N; loaded scenes count only if friction changes all features by less than 0.5 %. The accuracy is met if the
error is at most 2 % plus two combined standard errors. The CPU time of trials and job is divided by that of
`planar`; compilation is excluded. Each scene is also computed with `friction: none`, and compared with the
reference without friction. The default seed is derived from the commit. Scenes in OUT are not recomputed. Exit
code 1 if less than 95 % meet the accuracy, or the cost is too high.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bearingsim import selection
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.selection.candidates import make_reference, with_friction
from bearingsim.selection.choices import choice_key
from bearingsim.simulation import SimulationError, compile_solvers, run_trial, simulate
from bearingsim.simulation.record import Record
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study, case_id, load_study
from benchmarks.promise import standard_error
from benchmarks.rows import rounded, write_csv

ACCURACY, MAX_EFFECT = 0.02, 0.005
MIN_SHARE, LIGHT_COST, LOADED_COST = 0.95, 1.3, 0.5
LOADS = {"light": (15.0, 300.0), "loaded": (500.0, 5000.0)}
CHAOTIC_DURATION = 3.0  # s, duration of a chaotic motion
STANDARD_ERRORS = 2.0
MAX_DRAWS = 2  # largest number of loaded scenes drawn per scene that counts
KINDS = {"light": ("line", "rms", "force"), "loaded": ("line", "force")}


def seed_of_commit() -> int:
    """Return a number derived from the first digits of the commit."""
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout
    return int(commit[:6], 16)


def draw(kind: str, number: int, seed: int) -> dict[str, Any]:
    """Draw the fields of a scene's study."""
    rng = np.random.default_rng([seed, len(kind), number])
    load, rpm = (float(np.exp(rng.uniform(*np.log(limits)))) for limits in (LOADS[kind], (600.0, 6000.0)))
    width = float(rng.uniform(0.2, 1.5))
    race = str(rng.choice(["outer", "outer", "inner"]))
    defect = {
        "race": race,
        "shape": str(rng.choice(["rectangular", "triangular", "circular"])),
        "length": f"{float(rng.uniform(max(width, 2.0), 12.0)):.6g} mm",
        "width": f"{width:.6g} mm",
        "depth": f"{float(np.exp(rng.uniform(*np.log((5.0, 100.0))))):.6g} um",
        "angle": f"{float(rng.uniform(-20.0, 20.0)):.6g} deg",
    }
    names = {"line": f"velocity@{FAULT_LINES[race]}", "rms": "velocity.rms", "force": "outer_force.max"}
    return {
        "study": f"{kind}-{number}",
        "bearing": "nf308",
        "rig": {"ring": {"bends": False}},
        "speed": f"{rpm:.6g} rpm",
        "load": f"{load:.6g} N",
        "clearance": f"{float(rng.choice([0.0, rng.uniform(0.0, 15.0)])):.6g} um",
        "defect": defect,
        "duration": "1 s",
        "record": [],
        "accuracy": {"within": f"{ACCURACY:.0%}", "of": [names[kind_] for kind_ in KINDS[kind]]},
    }


def study_of(scene: dict[str, Any]) -> Study:
    """Return a scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(scene))
        return load_study(path)


class AutomaticRun:
    """Study of one case with automatic model choice: choice, case and features.

    trials_s, job_s, cpu_s: CPU time (s) of the trials, of the job, of both.
    """

    def __init__(self, study: Study, records: dict[str, tuple[Record, float]]) -> None:
        """Compute the study. done: computed records with their CPU time (s), by the id of their case."""
        choosing, trials = selection.ModelSelector(study, [0]), dict[str, Trial | None]()
        self.trials_s = 0.0
        while pending := choosing.next_trials(trials):
            compile_solvers([trial.case for trial in pending])
            for trial in pending:
                began = time.process_time()
                try:
                    trials[trial.id], record = run_trial(
                        trial.case, trial.features, trial.passes, trial.revolution_time, *trial.reference_values
                    )
                except SimulationError:
                    trials[trial.id], record = None, None
                took = time.process_time() - began
                self.trials_s += took
                if record is not None:
                    records[case_id(trial.case)] = record, 0.0
        choices = choosing.decide(trials).choices
        self.choice = choices[choice_key(study, study.cases()[0])]
        [self.case] = selection.apply_choices(study, choices).cases()
        self.features, self.job_s = features_of(self.case, records)
        self.cpu_s = self.trials_s + self.job_s


def features_of(case: Case, records: dict[str, tuple[Record, float]]) -> tuple[dict[str, float], float]:
    """Return the features of a case, and its CPU time (s) in addition to trials."""
    if case_id(case) not in records:
        compile_solvers([case])
        began = time.process_time()
        records[case_id(case)] = simulate(case), time.process_time() - began
    record, took = records[case_id(case)]
    return dict(record.features), took


def compare_scene(kind: str, number: int, seed: int) -> dict[str, Any]:
    """Compute a scene in all ways, and compare."""
    scene = draw(kind, number, seed)
    study, frictionless_study = study_of(scene), study_of(scene | {"friction": "none"})
    case = with_friction(study.cases()[0])
    assert case is not None
    records: dict[str, tuple[Record, float]] = {}
    full, full_s = features_of(case, records)
    automatic = AutomaticRun(study, records)
    long = case.model_copy(update={"duration": CHAOTIC_DURATION})
    converged = features_of(long, records)[0] if full["chaotic"] == 1.0 else full
    frictionless = AutomaticRun(frictionless_study, records)
    frictionless_full = features_of(make_reference(frictionless_study.cases()[0]), records)[0]
    row: dict[str, Any] = {"kind": kind, "scene": number, "chaotic": full["chaotic"]}
    row |= {name: scene[name] for name in ("load", "speed")} | {"race": scene["defect"]["race"]}
    row |= {"taken": automatic.choice.candidate, "cpu_s": automatic.cpu_s, "always_s": full_s}
    row |= {"none_taken": frictionless.choice.candidate}
    assert study.goal is not None
    for quantity, name in zip(KINDS[kind], study.goal.of, strict=True):
        row[f"{quantity}_moved"] = abs(frictionless_full[name] / full[name] - 1.0)
        row |= _errors(quantity, name, automatic.features, converged) | _errors(
            f"none_{quantity}", name, frictionless.features, frictionless_full
        )
        row[f"{quantity}_said"] = automatic.choice.friction.get(name, 0.0)
    return row


def _errors(
    quantity: str, name: str, features: dict[str, float], reference_features: dict[str, float]
) -> dict[str, float]:
    """Return the relative error of a feature, and two combined standard errors, relative to the right value."""
    size = abs(reference_features[name]) or 1.0
    scatter = STANDARD_ERRORS * hypot(
        *(standard_error(name, source) / size for source in (features, reference_features))
    )
    return {
        f"{quantity}_off": abs(features[name] - reference_features[name]) / size,
        f"{quantity}_scatter": scatter,
    }


def is_accurate(row: dict[str, Any], prefix: str = "") -> bool:
    """Check if all features of a scene meet the accuracy."""
    return all(
        row[f"{prefix}{quantity}_off"] <= ACCURACY + row[f"{prefix}{quantity}_scatter"]
        for quantity in KINDS[row["kind"]]
    )


def rows_of(kind: str, count: int, seed: int, out: Path) -> list[dict[str, Any]]:
    """Return the first scenes that count, computing missing ones."""
    rows: list[dict[str, Any]] = []
    for number in range(count if kind == "light" else MAX_DRAWS * count):
        path = out / f"{seed}-{kind}-{number}.json"
        if not path.exists():
            try:
                result = compare_scene(kind, number, seed)
            except SimulationError as error:
                result = {"refused": str(error)[:200]}
            path.write_text(json.dumps(result))
        row = json.loads(path.read_text())
        if "refused" in row:
            print(f"left out: {kind} {number}: {row['refused']}", flush=True)
        elif kind == "light" or all(row[f"{quantity}_moved"] < MAX_EFFECT for quantity in KINDS[kind]):
            print(*(f"{name}={value}" for name, value in rounded(row, 3).items()), flush=True)
            rows.append(row)
        if len(rows) == count:
            break
    return rows


def report(kind: str, rows: list[dict[str, Any]], max_cost: float) -> bool:
    """Print how many scenes meet the accuracy, and their cost; return whether both meet the limits."""
    totals = [sum(row[name] for row in rows) for name in ("cpu_s", "always_s")]
    cost, accurate = totals[0] / totals[1], sum(map(is_accurate, rows))
    accurate_frictionless = sum(is_accurate(row, "none_") for row in rows)
    candidates = [row["taken"] for row in rows]
    counts = ", ".join(f"{name} {candidates.count(name)}" for name in dict.fromkeys(candidates))
    print(
        f"{kind}: {accurate} of {len(rows)} kept, {accurate_frictionless} with `friction: none`;"
        f" CPU time {cost:.2f} of planar's; {counts}"
    )
    for row in rows:
        if not is_accurate(row) or not is_accurate(row, "none_"):
            print("  miss:", *(f"{name}={value}" for name, value in rounded(row, 3).items()))
    return min(accurate, accurate_frictionless) >= MIN_SHARE * len(rows) and cost <= max_cost


def main() -> None:
    """Compute missing scenes, write the table, report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--light", type=int, default=60)
    parser.add_argument("--loaded", type=int, default=20)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--out", type=Path, default=Path("results/friction"))
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    seed = seed_of_commit() if options.seed is None else options.seed
    print(f"seed {seed}")
    groups = {
        kind: rows_of(kind, count, seed, options.out)
        for kind, count in (("light", options.light), ("loaded", options.loaded))
    }
    all_rows = [row for rows in groups.values() for row in rows]
    if options.csv:
        write_csv(all_rows, options.csv, dict.fromkeys(name for row in all_rows for name in row), digits=3)
    max_costs = {"light": LIGHT_COST, "loaded": LOADED_COST}
    passed = [report(kind, rows, max_costs[kind]) for kind, rows in groups.items() if rows]
    sys.exit(int(not all(passed)))


if __name__ == "__main__":
    main()
