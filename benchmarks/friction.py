"""Accuracy and cost of studies with an `accuracy`, compared with a full model with friction.

    python -m benchmarks.friction [--light 60] [--loaded 20] [--seed N] [--csv docs/data/friction.csv] [--out DIR]

A scene is a study of one case without a friction setting. It requests 2 % for the defect line, the largest force
and, if it is light, the RMS, which friction changes even under load. The result is compared with the default
`planar` (free cage, dry friction), for 1 s, or 3 s if that is chaotic. Light scenes have 15 to 300 N, loaded
scenes 500 to 5000 N; loaded scenes count only if friction changes all features by less than 0.5 %. The accuracy is
met if the error is at most 2 % plus two standard errors. The CPU time of trials and job is divided by that of
`planar`; compilation is excluded. Each scene is also computed with `friction: none`, and compared with the
reference without friction. The default seed is derived from the commit. Scenes in OUT are not recomputed. Exit
code 1 if less than 95 % meet the accuracy, or the cost is too high.
"""

import argparse
import csv
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
from bearingsim.selection.candidates import reference, with_friction
from bearingsim.selection.choices import key
from bearingsim.simulation import SimulationError, simulate, try_out, warm
from bearingsim.simulation.simulate import Record
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study, case_id, load_study
from benchmarks.promise import standard_error

WITHIN, MOVED = 0.02, 0.005
SHARE, LIGHT_COST, LOADED_COST = 0.95, 1.3, 0.5
LOADS = {"light": (15.0, 300.0), "loaded": (500.0, 5000.0)}
LONG = 3.0  # s, duration of a chaotic motion
STANDARD_ERRORS = 2.0
MOST_LOADED = 2  # largest number of loaded scenes drawn per scene that counts
KINDS = {"light": ("line", "rms", "force"), "loaded": ("line", "force")}


def seed_of_commit() -> int:
    """Return a number derived from the first digits of the commit."""
    said = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout
    return int(said[:6], 16)


def draw(kind: str, number: int, seed: int) -> dict[str, Any]:
    """Draw the fields of a scene's study."""
    chance = np.random.default_rng([seed, len(kind), number])
    load, rpm = (float(np.exp(chance.uniform(*np.log(ends)))) for ends in (LOADS[kind], (600.0, 6000.0)))
    width = float(chance.uniform(0.2, 1.5))
    race = str(chance.choice(["outer", "outer", "inner"]))
    defect = {
        "race": race,
        "shape": str(chance.choice(["rectangular", "triangular", "circular"])),
        "length": f"{float(chance.uniform(max(width, 2.0), 12.0)):.6g} mm",
        "width": f"{width:.6g} mm",
        "depth": f"{float(np.exp(chance.uniform(*np.log((5.0, 100.0))))):.6g} um",
        "angle": f"{float(chance.uniform(-20.0, 20.0)):.6g} deg",
    }
    names = {"line": f"velocity@{FAULT_LINES[race]}", "rms": "velocity.rms", "force": "outer_force.max"}
    return {
        "study": f"{kind}-{number}",
        "bearing": "nf308",
        "rig": {"ring": {"bends": False}},
        "speed": f"{rpm:.6g} rpm",
        "load": f"{load:.6g} N",
        "clearance": f"{float(chance.choice([0.0, chance.uniform(0.0, 15.0)])):.6g} um",
        "defect": defect,
        "duration": "1 s",
        "record": [],
        "accuracy": {"within": f"{WITHIN:.0%}", "of": [names[what] for what in KINDS[kind]]},
    }


def study_of(scene: dict[str, Any]) -> Study:
    """Return a scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(scene))
        return load_study(path)


class Asked:
    """Study of one case with automatic model choice: choice, case and features.

    trials_s, job_s, cpu_s: CPU time (s) of the trials, of the job, of both.
    """

    def __init__(self, study: Study, done: dict[str, tuple[Record, float]]) -> None:
        """Compute the study. done: computed records with their CPU time (s), by the id of their case."""
        choosing, known = selection.Choosing(study, [0]), dict[str, Trial | None]()
        self.trials_s = 0.0
        while wanted := choosing.wanted(known):
            warm([one.case for one in wanted])
            for one in wanted:
                began = time.process_time()
                try:
                    known[one.id], record = try_out(one.case, one.asked, one.passes, one.turn, *one.against)
                except SimulationError:
                    known[one.id], record = None, None
                took = time.process_time() - began
                self.trials_s += took
                if record is not None:
                    done[case_id(one.case)] = record, 0.0
        choices = choosing.decide(known).choices
        self.choice = choices[key(study, study.cases()[0])]
        [self.case] = selection.chosen(study, choices).cases()
        self.features, self.job_s = computed(self.case, done)
        self.cpu_s = self.trials_s + self.job_s


def computed(case: Case, done: dict[str, tuple[Record, float]]) -> tuple[dict[str, float], float]:
    """Return the features of a case, and its CPU time (s) in addition to trials."""
    if case_id(case) not in done:
        warm([case])
        began = time.process_time()
        done[case_id(case)] = simulate(case), time.process_time() - began
    record, took = done[case_id(case)]
    return dict(record.features), took


def measured(kind: str, number: int, seed: int) -> dict[str, Any]:
    """Compute a scene in all ways, and compare."""
    scene = draw(kind, number, seed)
    open_study, none = study_of(scene), study_of(scene | {"friction": "none"})
    case = with_friction(open_study.cases()[0])
    assert case is not None
    done: dict[str, tuple[Record, float]] = {}
    always, always_s = computed(case, done)
    asked = Asked(open_study, done)
    long = case.model_copy(update={"duration": LONG})
    truth = computed(long, done)[0] if always["chaotic"] == 1.0 else always
    without = Asked(none, done)
    plain = computed(reference(none.cases()[0]), done)[0]
    row: dict[str, Any] = {"kind": kind, "scene": number, "chaotic": always["chaotic"]}
    row |= {name: scene[name] for name in ("load", "speed")} | {"race": scene["defect"]["race"]}
    row |= {"taken": asked.choice.candidate, "cpu_s": asked.cpu_s, "always_s": always_s}
    row |= {"none_taken": without.choice.candidate}
    assert open_study.goal is not None
    for what, name in zip(KINDS[kind], open_study.goal.of, strict=True):
        row[f"{what}_moved"] = abs(plain[name] / always[name] - 1.0)
        row |= _off(what, name, asked.features, truth) | _off(f"none_{what}", name, without.features, plain)
        row[f"{what}_said"] = asked.choice.friction.get(name, 0.0)
    return row


def _off(what: str, name: str, own: dict[str, float], right: dict[str, float]) -> dict[str, float]:
    """Return the relative error of a feature, and two combined standard errors, relative to the right value."""
    size = abs(right[name]) or 1.0
    beside = STANDARD_ERRORS * hypot(*(standard_error(name, one) / size for one in (own, right)))
    return {f"{what}_off": abs(own[name] - right[name]) / size, f"{what}_scatter": beside}


def kept(row: dict[str, Any], of: str = "") -> bool:
    """Check if all features of a scene meet the accuracy."""
    return all(row[f"{of}{what}_off"] <= WITHIN + row[f"{of}{what}_scatter"] for what in KINDS[row["kind"]])


def rows_of(kind: str, count: int, seed: int, out: Path) -> list[dict[str, Any]]:
    """Return the first scenes that count, computing missing ones."""
    rows: list[dict[str, Any]] = []
    for number in range(count if kind == "light" else MOST_LOADED * count):
        path = out / f"{seed}-{kind}-{number}.json"
        if not path.exists():
            try:
                found = measured(kind, number, seed)
            except SimulationError as error:
                found = {"refused": str(error)[:200]}
            path.write_text(json.dumps(found))
        row = json.loads(path.read_text())
        if "refused" in row:
            print(f"left out: {kind} {number}: {row['refused']}", flush=True)
        elif kind == "light" or all(row[f"{what}_moved"] < MOVED for what in KINDS[kind]):
            print(*(f"{name}={_short(value)}" for name, value in row.items()), flush=True)
            rows.append(row)
        if len(rows) == count:
            break
    return rows


def report(kind: str, rows: list[dict[str, Any]], most: float) -> bool:
    """Print how many scenes meet the accuracy, and their cost; return whether both meet the limits."""
    whole = [sum(row[name] for row in rows) for name in ("cpu_s", "always_s")]
    cost, held, plain = whole[0] / whole[1], sum(map(kept, rows)), sum(kept(row, "none_") for row in rows)
    taken = [row["taken"] for row in rows]
    counts = ", ".join(f"{name} {taken.count(name)}" for name in dict.fromkeys(taken))
    print(
        f"{kind}: {held} of {len(rows)} kept, {plain} with `friction: none`;"
        f" CPU time {cost:.2f} of planar's; {counts}"
    )
    for row in rows:
        if not kept(row) or not kept(row, "none_"):
            print("  miss:", *(f"{name}={_short(value)}" for name, value in row.items()))
    return min(held, plain) >= SHARE * len(rows) and cost <= most


def _short(value: Any) -> Any:
    return f"{value:.3g}" if isinstance(value, float) else value


def main() -> None:
    """Compute missing scenes, write the table, report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--light", type=int, default=60)
    parser.add_argument("--loaded", type=int, default=20)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--out", type=Path, default=Path("results/friction"))
    parser.add_argument("--csv", type=Path)
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    seed = seed_of_commit() if asked.seed is None else asked.seed
    print(f"seed {seed}")
    groups = {
        kind: rows_of(kind, count, seed, asked.out)
        for kind, count in (("light", asked.light), ("loaded", asked.loaded))
    }
    every = [row for rows in groups.values() for row in rows]
    if asked.csv:
        with asked.csv.open("w", newline="") as file:
            names = dict.fromkeys(name for row in every for name in row)
            writer = csv.DictWriter(file, names, lineterminator="\n")
            writer.writeheader()
            writer.writerows({name: _short(value) for name, value in row.items()} for row in every)
    most = {"light": LIGHT_COST, "loaded": LOADED_COST}
    enough = [report(kind, rows, most[kind]) for kind, rows in groups.items() if rows]
    sys.exit(int(not all(enough)))


if __name__ == "__main__":
    main()
