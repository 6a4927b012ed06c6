"""Is a promised accuracy kept? Random scenes, each with the model that the program chooses, against the truth.

    python benchmarks/promise.py [--seed 1] [--count 120] [--jobs 2] [--out promise.jsonl] [--longer 4]

A scene is a study of one case that asks 5, 2 and 1 % of the fault's line, the RMS and the largest outer force. The
truth is the reference with half of its step, and where its motion is chaotic, so many times as long (`--longer`;
the largest force is that of a record as long as the other's). Lines of the file are scenes; one that
is there is not computed again.
"""

import argparse
import json
import tempfile
import time
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from joblib import Parallel, delayed

from bearingsim import selection, simulation
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.selection.choices import key
from bearingsim.selection.trials import every_candidate, reference
from bearingsim.simulation import SimulationError, simulate, try_out
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study, StudyError, load_study

WITHIN = (0.05, 0.02, 0.01)
FINER = 0.5
STANDARD_ERRORS = 2.0
OF_RMS_SCATTER = 2.5


def draw(number: int, seed: int) -> dict[str, Any]:
    """A scene as a study's YAML."""
    rng = np.random.default_rng([seed, number])
    race = str(rng.choice(["outer", "outer", "inner", "roller"]))
    shape = str(rng.choice(["rectangular", "triangular", "circular", "elliptical"]))
    bends = number % 6 == 5
    width = float(rng.uniform(0.2, 2.0))
    ball = number % 12 == 3
    length = float(rng.uniform(0.5, 3.0) if ball else rng.uniform(2.0, 12.0))
    rpm = float(np.exp(rng.uniform(np.log(1500.0 if race == "roller" else 300.0), np.log(6000.0))))
    offset = not bends and number % 6 == 4
    defect: dict[str, Any] = {"race": race, "shape": shape, "width": f"{width} mm", "length": f"{length} mm"}
    defect |= {"depth": f"{float(np.exp(rng.uniform(np.log(0.5), np.log(100.0))))} um"}
    if race == "outer":
        defect["angle"] = f"{float(rng.uniform(0.0, 60.0))} deg"
    if offset:
        defect |= {"length": "3 mm", "offset": f"{float(rng.uniform(1.0, 4.0))} mm"}
    rig: dict[str, Any] = {"ring": {"bends": True}} if bends else {}
    of = [f"velocity@{FAULT_LINES[race]}", "velocity.rms", "outer_force.max"]
    return {
        "study": f"scene-{number}",
        "bearing": "6205" if ball else "nf308",
        "speed": f"{rpm} rpm",
        "load": f"{float(np.exp(rng.uniform(np.log(15.0), np.log(1000.0))))} N",
        "clearance": f"{float(rng.choice([0.0, rng.uniform(0.0, 25.0)]))} um",
        "contact": {
            "damping": {"law": "kraemer", "beta": f"{float(np.exp(rng.uniform(np.log(0.5), np.log(25.0))))} us"}
        },
        "defect": defect,
        "duration": f"{2.2 * 1800.0 / rpm if race == 'roller' else 1.0} s",  # 2BSF is close to BPFO
        "record": [],
        "accuracy": {"within": "5 %", "of": of},
        **({"rig": rig} if rig else {}),
    }


def study_of(scene: dict[str, Any]) -> Study:
    """The scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(scene))
        return load_study(path)


def timed(case: Case) -> dict[str, float]:
    """Features of a case, its CPU time and step."""
    began = time.process_time()
    found = simulate(case)
    told = {name: float(value) for name, value in found.features.items()}
    return told | {
        "cpu_s": time.process_time() - began,
        "step_s": float(found.info["step_s"]),
        "period": float(found.info["period_passes"]),
    }


def truth(case: Case, usual: dict[str, float], longer: float) -> dict[str, float]:
    """What is right: half the step, a longer record where the motion is chaotic."""
    step = {"step": FINER * usual["step_s"], "step_check": False} if case.method is not None else {}
    fine = case.model_copy(update=step)
    found = timed(fine)
    if usual["chaotic"] == 1.0 and longer > 1.0:
        long = timed(fine.model_copy(update={"duration": longer * case.duration}))
        found = long | {"outer_force.max": found["outer_force.max"]}
    return found | {"chaotic": usual["chaotic"]}


def standard_error(feature: str, found: dict[str, float]) -> float:
    """That of a feature of a chaotic motion (SI), as far as the record tells."""
    if feature.endswith(".rms"):
        return found[feature] * found.get("rms_scatter", 0.0) / OF_RMS_SCATTER if found["chaotic"] == 1.0 else 0.0
    scatter = found.get(f"{feature}-scatter", 0.0)
    return scatter if found["chaotic"] == 1.0 and np.isfinite(scatter) else 0.0


def scene(number: int, seed: int, longer: float) -> dict[str, Any]:
    """All of a scene: trials, choices, results, truth."""
    told: dict[str, Any] = {"number": number, "seed": seed}
    try:
        study = study_of(draw(number, seed))
        return told | _of_study(study, longer)
    except (SimulationError, StudyError, ValueError) as error:
        return told | {"refused": str(error)[:300]}


def _of_study(study: Study, longer: float) -> dict[str, Any]:
    case = reference(study.cases()[0])
    known: dict[str, Trial | None] = {}
    assert study.goal is not None
    simulation.warm([one.case for one in selection.first_trials(study, [0])])
    simulation.warm([found[0] for found in every_candidate(study, [0]).values() if found])
    began = time.process_time()
    for wanted in (selection.first_trials(study, [0]), None):
        for one in wanted if wanted is not None else selection.further_trials(study, [0], known):
            try:
                known[one.id] = try_out(one.case, one.asked, one.passes)[0]
            except SimulationError:
                known[one.id] = None
    tried_s = time.process_time() - began
    usual = timed(case)
    right = truth(case, usual, longer)
    told: dict[str, Any] = {"reference": case.model, "repeats": usual["period"] > 0.0, "tried_s": tried_s}
    told |= {"reference_s": usual["cpu_s"], "chaotic": usual["chaotic"], "race": case.defects[0].race}
    told |= {"bends": case.rig.ring is not None, "clearance_um": 1e6 * case.clearance, "choices": {}}
    results: dict[str, dict[str, float]] = {"reference": usual}
    for within in WITHIN:
        asked = replace(study, goal=replace(study.goal, within=within))
        choice = selection.decide(asked, [0], known).choices[key(asked, study.cases()[0])]
        if choice.candidate not in results:
            results[choice.candidate] = timed(
                selection.chosen(asked, {key(asked, study.cases()[0]): choice}).cases()[0]
            )
        found = results[choice.candidate]
        told["choices"][str(within)] = {
            "candidate": choice.candidate,
            "cpu_s": found["cpu_s"],
            "why": choice.why,
        } | {
            feature: _of_feature(feature, found, right, choice.error.get(feature, 0.0))
            for feature in study.goal.of
        }
    return told


def _of_feature(feature: str, found: dict[str, float], right: dict[str, float], model: float) -> dict[str, float]:
    """How far off a feature is, relative, and what was said of it."""
    size = abs(right[feature]) or 1.0
    errors = [standard_error(feature, one) / size for one in (found, right)]
    ending = "rms" if feature.endswith(".rms") else "force" if feature.startswith("outer") else "line"
    step = found.get(f"step_error.{ending}", 0.0)
    return {
        "off": abs(found[feature] - right[feature]) / size,
        "scatter": errors[0],
        "both": hypot(*errors),
        "model": model,
        "step": 0.0 if np.isnan(step) else step,
    }


def report(rows: list[dict[str, Any]]) -> None:
    """Print how often what was promised is kept, and every miss."""
    done = [row for row in rows if "choices" in row]
    print(f"{len(rows)} scenes, {len(rows) - len(done)} refused")
    for within in WITHIN:
        chosen = [(row, row["choices"][str(within)]) for row in done]
        below = sum(one["candidate"] != "reference" for _, one in chosen)
        print(f"\nwithin {within:.0%}: {below} of {len(chosen)} below the reference")
        for kind in ("line", "rms", "force"):
            kept, longer, honest = 0, 0, 0
            for row, one in chosen:
                name = next(f for f in one if isinstance(one[f], dict) and _kind(f) == kind)
                of = one[name]
                estimate = of["model"] + of["step"] + STANDARD_ERRORS * of["both"]
                asks = of["model"] + of["step"] + of["scatter"] > within
                keeps = of["off"] <= within + STANDARD_ERRORS * of["both"]
                kept, longer, honest = kept + keeps, longer + asks, honest + (of["off"] <= 3.0 * estimate + 1e-4)
                if not keeps:
                    print(
                        f"   miss: scene {row['number']} {one['candidate']} {name} {of} chaotic {row['chaotic']}"
                    )
            held = f"kept {kept}, asks for a longer record {longer}, truth <= 3 estimates {honest}"
            print(f"  {kind}: {held}, of {len(chosen)}")
        groups: dict[tuple, list[tuple[float, float]]] = {}
        for row, one in chosen:
            of = groups.setdefault((row["reference"], "repeats" if row["repeats"] else "does not"), [])
            cost = row["reference_s"] if row["repeats"] else row["tried_s"] + one["cpu_s"]
            of.append((cost, row["reference_s"]))
        for group, pairs in groups.items():
            taken, always = (sum(pair[n] for pair in pairs) for n in (0, 1))
            share = f"{taken / always:.2f} of the CPU of always the reference"
            print(f"  {' '.join(group)}: {len(pairs)} scenes, {share}")


def _kind(feature: str) -> str:
    return "rms" if feature.endswith(".rms") else "force" if feature.startswith("outer") else "line"


def main() -> None:
    """Compute the scenes that are missing, then report."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--count", type=int, default=120)
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--longer", type=float, default=4.0)
    asked.add_argument("--out", type=Path, default=Path("promise.jsonl"))
    given = asked.parse_args()
    rows = [json.loads(line) for line in given.out.read_text().splitlines()] if given.out.exists() else []
    there = {row["number"] for row in rows if row["seed"] == given.seed}
    todo = [n for n in range(given.count) if n not in there]
    pool = Parallel(n_jobs=given.jobs, batch_size=1, return_as="generator_unordered")
    for row in pool(delayed(scene)(n, given.seed, given.longer) for n in todo):
        rows.append(row)
        with given.out.open("a") as file:
            file.write(json.dumps(row) + "\n")
    report([row for row in rows if row["seed"] == given.seed and row["number"] < given.count])


if __name__ == "__main__":
    main()
