"""Accuracy of automatically chosen models in random scenes, compared with the requested one.

    python -m benchmarks.promise [--seed 1] [--count 120] [--jobs 2] [--out results/promise] [--again]

A scene is a study of one case, which requests 5, 2 and 1 % for the defect line, the RMS and the largest outer
force. The cost of trials is reported for 5 % of the line. The converged solution is the reference model with half
its step or a tolerance of 1e-7, with 48 slices for `spatial`, and, if chaotic, 10 s long (`spatial` 2 s, flexible
ring 4 s; the largest force is that of a record of the original length). OUT/scenes.jsonl has a line per scene,
OUT/trials its trials. Scenes in the file are not recomputed; with `--again` only their trials are. OUT/promise.csv
has the results.
"""

import argparse
import csv
import json
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from joblib import Parallel, delayed

from bearingsim import selection, simulation
from bearingsim.catalogue import METHODS, REFERENCE
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.selection.candidates import list_candidates, make_reference
from bearingsim.selection.choices import choice_key
from bearingsim.selection.trials import TrialRequest, TrialResults, first_trials, is_decided, trials_of
from bearingsim.simulation import SimulationError, run_trial, simulate
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study, StudyError, load_study

ACCURACIES = (0.05, 0.02, 0.01)
COST_GOAL = 0.05, True
GOALS = (*((within, False) for within in ACCURACIES), COST_GOAL)
"""Requested accuracies, and whether they are for the line alone."""
STEP_FACTOR, TOLERANCE, SLICES = 0.5, 1e-7, 48
COMPILE_TIME = 10.0  # s of CPU time, more than the compilation of a model takes
LONG, LONG_SPATIAL, LONG_FLEXIBLE = 10.0, 2.0, 4.0  # s, durations of a chaotic motion
STANDARD_ERRORS = 2.0
RMS_SCATTER_FACTOR = 2.5
KINDS = {
    "line": lambda name: "@" in name,
    "rms": lambda name: name.endswith(".rms"),
    "force": lambda name: name.startswith("outer"),
}


def draw(number: int, seed: int) -> dict[str, Any]:
    """Draw the fields of a scene's study; every sixth has an offset defect, every sixth a flexible ring."""
    rng = np.random.default_rng([seed, number])
    race = str(rng.choice(["outer", "outer", "inner", "roller"]))
    shape = str(rng.choice(["rectangular", "triangular", "circular", "elliptical", "spall"]))
    is_flexible = number % 6 == 5
    width = float(rng.uniform(0.2, 2.0))
    ball = number % 12 == 3
    length = float(rng.uniform(0.5, 3.0) if ball else rng.uniform(2.0, 12.0))
    rpm = float(np.exp(rng.uniform(np.log(1500.0 if race == "roller" else 300.0), np.log(6000.0))))
    offset = is_offset(number)
    defect: dict[str, Any] = {"race": race, "shape": shape, "width": f"{width} mm", "length": f"{length} mm"}
    defect |= {"depth": f"{float(np.exp(rng.uniform(np.log(0.5), np.log(100.0))))} um"}
    if race == "outer":
        defect["angle"] = f"{float(rng.uniform(0.0, 60.0))} deg"
    if offset:
        defect |= {"length": "3 mm", "offset": f"{float(rng.uniform(1.0, 4.0))} mm"}
    rig: dict[str, Any] = {"ring": {"bends": True}} if is_flexible else {}
    features = [f"velocity@{FAULT_LINES[race]}", "velocity.rms", "outer_force.max"]
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
        "friction": "none",  # as in the converged solution; friction is tested by ``benchmarks/friction.py``
        "duration": f"{2.2 * 1800.0 / rpm if race == 'roller' else 1.0} s",  # 2BSF is close to BPFO
        "record": [],
        "accuracy": {"within": "5 %", "of": features},
        **({"rig": rig} if rig else {}),
    }


def is_offset(number: int) -> bool:
    """Check if the defect of a scene is offset from the roller's centre, so that rollers tilt."""
    return number % 6 == 4


def study_of(number: int, seed: int) -> Study:
    """Load a scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(draw(number, seed)))
        return load_study(path)


def with_accuracy(study: Study, within: float, line_only: bool = False) -> Study:
    """Return the study with another accuracy."""
    assert study.goal is not None
    features = tuple(name for name in study.goal.of if "@" in name or not line_only)
    return replace(study, goal=replace(study.goal, within=within, of=features))


def timed(case: Case) -> dict[str, Any]:
    """Compute features of a case, its CPU time, method and step."""
    began = time.process_time()
    record = simulate(case)
    features = {name: float(value) for name, value in record.features.items()}
    info = {name: float(record.info[name]) for name in ("step_s", "period_passes", "passes", "passes_computed")}
    return features | info | {"method": record.info["method"], "cpu_s": time.process_time() - began}


def truth(case: Case, default: dict[str, Any]) -> dict[str, float]:
    """Compute the converged solution with a finer step, more slices, and a longer record if chaotic."""
    changes: dict[str, Any] = {"step_check": False}
    if case.method is not None and METHODS[default["method"]].adaptive:
        changes |= {"method": default["method"], "tolerance": TOLERANCE}
    elif case.method is not None:
        changes["step"] = STEP_FACTOR * default["step_s"]
    if case.model == "spatial":
        changes["contact"] = case.contact.model_copy(update={"slices": SLICES})
    fine = case.model_copy(update=changes)
    result = timed(fine)
    long = LONG_SPATIAL if case.model == "spatial" else LONG if case.rig.ring is None else LONG_FLEXIBLE
    if default["chaotic"] == 1.0 and long > case.duration:
        result = timed(fine.model_copy(update={"duration": long})) | {"outer_force.max": result["outer_force.max"]}
    return result | {"chaotic": default["chaotic"]}


def scene(number: int, seed: int, out: Path) -> dict[str, Any]:
    """Return trials and results of a scene by each chosen candidate, and the converged solution."""
    row: dict[str, Any] = {"number": number, "seed": seed}
    try:
        return row | compute_row(study_of(number, seed), f"{seed}-{number}", out)
    except (SimulationError, StudyError, ValueError) as error:
        return row | {"refused": str(error)[:300]}


def compute_row(study: Study, unit: str, out: Path) -> dict[str, Any]:
    """Compute the row of a scene."""
    original = study.cases()[0]
    case, cases = (
        make_reference(original),
        {name: variants[0] for name, variants in list_candidates(study, [0]).items()},
    )
    simulation.compile_solvers([case, *cases.values()])
    trial_s, trials = all_trials(study, unit, out)
    default = timed(case)
    trial_row = {"trial_s": trial_s}
    chosen = {replay(trial_row, study, *goal, trials).choice.candidate for goal in GOALS} - {REFERENCE}
    results = {REFERENCE: default} | dict(results_of({name: cases[name] for name in chosen}))
    return {
        "reference": case.model,
        "repeats": default["period_passes"] > 0.0,
        "race": case.defects[0].race,
        "shape": case.defects[0].shape,
        "offset": case.defects[0].offset != 0.0,
        "bends": case.rig.ring is not None,
        "clearance_um": 1e6 * case.clearance,
        "trial_s": trial_s,
        "results": results,
        "truth": truth(case, default),
    }


def all_trials(study: Study, unit: str, out: Path) -> tuple[dict[str, float], TrialResults]:
    """Run and store the trials of a scene's reference and candidates; return their CPU times (s) and results."""
    cpu_s: dict[str, float] = {}
    trials: dict[str, Trial | None] = {}
    for trial in first_trials(study, [0]):
        cpu_s[trial.id], trials[trial.id] = time_trial(trial)
    if not is_decided(study, 0, trials):
        for variants in list_candidates(study, [0]).values():
            for trial in trials_of(study, 0, variants[0]):
                cpu_s[trial.id], trials[trial.id] = time_trial(trial)
    selection.write_trials(out, unit, trials)
    return cpu_s, trials


def repeat_trials(row: dict[str, Any], out: Path) -> dict[str, Any]:
    """Return a scene with new trials."""
    if "results" not in row:
        return row
    study = study_of(row["number"], row["seed"])
    return row | {"trial_s": all_trials(study, f"{row['seed']}-{row['number']}", out)[0]}


def time_trial(trial: TrialRequest) -> tuple[float, Trial | None]:
    """Return CPU time (s) and result of a trial, run twice if short, to exclude compilation."""
    cpu_s, result = time_trial_once(trial)
    return (cpu_s, result) if cpu_s > COMPILE_TIME else time_trial_once(trial)


def time_trial_once(trial: TrialRequest) -> tuple[float, Trial | None]:
    """Return CPU time (s) and result of a trial."""
    began, result = time.process_time(), None
    with suppress(SimulationError):
        result = run_trial(trial.case, trial.features, trial.passes, trial.revolution_time)[0]
    return time.process_time() - began, result


def results_of(cases: dict[str, Case]) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield the results of all candidates that can be computed."""
    for name, case in cases.items():
        try:
            yield name, timed(case)
        except SimulationError:
            continue


def standard_error(feature: str, features: dict[str, float]) -> float:
    """Return the standard error (SI) of a feature of a chaotic motion as stated by its record; else 0."""
    if features["chaotic"] != 1.0:
        return 0.0
    scatter = features.get(f"{feature}-scatter", 0.0)
    if feature.endswith(".rms"):
        scatter = features[feature] * features.get("rms_scatter", 0.0) / RMS_SCATTER_FACTOR
    return scatter if np.isfinite(scatter) else 0.0


def feature_errors(
    feature: str, features: dict[str, float], converged: dict[str, float], model: float
) -> dict[str, float]:
    """Return the relative error of a feature, and the stated errors."""
    size = abs(converged[feature]) or 1.0
    errors = [standard_error(feature, source) / size for source in (features, converged)]
    step = features.get(f"step_error.{kind_of(feature)}", 0.0)
    error = abs(features[feature] - converged[feature]) / size
    return {
        "off": error,
        "scatter": errors[0],
        "both": hypot(*errors),
        "model": model,
        "step": np.nan_to_num(step),
    }


def kind_of(feature: str) -> str:
    """Return the kind of a feature, `line`, `rms` or `force`."""
    return next(kind for kind, matches in KINDS.items() if matches(feature))


class Replay(NamedTuple):
    """Automatic choice for a scene, and CPU time (s) of the trials needed for it."""

    row: dict[str, Any]
    choice: selection.Choice
    trials_s: float


def replay(row: dict[str, Any], study: Study, within: float, line_only: bool, stored: TrialResults) -> Replay:
    """Repeat the choice for a scene from stored trials."""
    goal_study = with_accuracy(study, within, line_only)
    choosing, trials, cpu_s = selection.ModelSelector(goal_study, [0]), dict[str, Trial | None](), 0.0
    while pending := choosing.next_trials(trials):
        for trial in pending:
            trial_id = trials_of(study, 0, trial.case)[0].id  # id of the trial with all features
            trials[trial.id] = stored.get(trial_id)
            cpu_s += row["trial_s"].get(trial_id, 0.0)
    return Replay(row, choosing.decide(trials).choices[choice_key(goal_study, study.cases()[0])], cpu_s)


def report(rows: list[dict[str, Any]], trials: TrialResults) -> None:
    """Print how often the accuracy is met, all misses, and the cost."""
    studies = [(row, study_of(row["number"], row["seed"])) for row in rows if "results" in row]
    print(f"{len(rows)} scenes, {len(rows) - len(studies)} refused")
    for within in ACCURACIES:
        replays = [replay(row, study, within, False, trials) for row, study in studies]
        below = sum(entry.choice.candidate != REFERENCE for entry in replays)
        print(f"\nwithin {within:.0%}: {below} of {len(replays)} below the reference")
        for kind in KINDS:
            print(f"  {kind}: {summarise_kind(kind, within, replays)}")
    print(f"\nCPU time with trials over always the reference, {COST_GOAL[0]:.0%} of the line alone:")
    groups: dict[str, list[Replay]] = {}
    for row, study in studies:
        periodicity = "repeats" if row["repeats"] else "does not repeat"
        name = f"{row['reference']}{', bends' * row['bends']}, {periodicity}"
        groups.setdefault(name, []).append(replay(row, study, *COST_GOAL, trials))
    for name, group in sorted(groups.items()):
        print(f"  {name}: {summarise_group(group)}")


def write_csv(path: Path, rows: list[dict[str, Any]], trials: TrialResults) -> None:
    """Write a row per scene, accuracy and feature: choice, relative error and stated errors."""
    labels = ("seed", "number", "reference", "race", "shape", "offset", "bends", "clearance_um", "repeats")
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        columns = ("within", "taken", "chaotic", "feature", "off", "model", "step", "scatter", "both")
        writer.writerow([*labels, *columns])
        for row in rows:
            if "results" not in row:
                continue
            study = study_of(row["number"], row["seed"])
            for within in ACCURACIES:
                choice = replay(row, study, within, False, trials).choice
                for name in requested_features(row):
                    errors = feature_errors(
                        name, row["results"][choice.candidate], row["truth"], choice.error.get(name, 0.0)
                    )
                    values = [f"{errors[column]:.3g}" for column in columns[4:]]
                    chaotic = int(row["truth"]["chaotic"] == 1.0)
                    writer.writerow(
                        [*(row[label] for label in labels), within, choice.candidate, chaotic, name, *values]
                    )


def summarise_kind(kind: str, within: float, replays: list[Replay]) -> str:
    """Summarise how often a kind of feature met the accuracy, and print its misses."""
    accurate, too_short, covered = 0, 0, 0
    for row, choice, _ in replays:
        features, converged = row["results"][choice.candidate], row["truth"]
        name = next(name for name in requested_features(row) if kind_of(name) == kind)
        errors = feature_errors(name, features, converged, choice.error.get(name, 0.0))
        estimate = errors["model"] + errors["step"] + STANDARD_ERRORS * errors["both"]
        too_short += errors["model"] + errors["step"] + errors["scatter"] > within
        covered += errors["off"] <= 3.0 * estimate + 1e-4
        is_accurate = errors["off"] <= within + STANDARD_ERRORS * errors["both"]
        accurate += is_accurate
        if not is_accurate:
            values = ", ".join(f"{name} {100.0 * value:.2g} %" for name, value in errors.items())
            chaotic = " chaotic" * (row["truth"]["chaotic"] == 1.0)
            print(f"   miss: scene {row['number']}{chaotic}, {choice.candidate}: {name} {values}")
    return (
        f"kept {accurate}, asks for a longer record {too_short}, truth <= 3 estimates {covered}, of {len(replays)}"
    )


def requested_features(row: dict[str, Any]) -> list[str]:
    """List the features with a requested accuracy."""
    return [f"velocity@{FAULT_LINES[row['race']]}", "velocity.rms", "outer_force.max"]


def summarise_group(group: list[Replay]) -> str:
    """Summarise the CPU time of a group, and how often each candidate was chosen."""
    reference_s = sum(entry.row["results"][REFERENCE]["cpu_s"] for entry in group)
    chosen_s = sum(cost_of(entry) for entry in group)
    names = [entry.choice.candidate for entry in group]
    counts = ", ".join(f"{name} {names.count(name)}" for name in dict.fromkeys(names))
    return f"{len(group)} scenes, {chosen_s / reference_s:.2f} ({chosen_s:.0f} of {reference_s:.0f} s); {counts}"


def cost_of(entry: Replay) -> float:
    """Return the CPU time (s) of trials and choice of a scene; a periodic reference is its own trial."""
    result_s = float(entry.row["results"][entry.choice.candidate]["cpu_s"])
    return result_s if entry.row["repeats"] else entry.trials_s + result_s


def main() -> None:
    """Compute missing scenes, then report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("results/promise"))
    parser.add_argument("--again", action="store_true", help="make the trials of what is there again")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / "scenes.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    if options.again:
        rows = Parallel(n_jobs=options.jobs, batch_size=1)(
            delayed(repeat_trials)(row, options.out) for row in rows
        )
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    computed = {row["number"] for row in rows if row["seed"] == options.seed}
    missing = sorted(
        (number for number in range(options.count) if number not in computed), key=is_offset
    )  # these take longest
    pool = Parallel(n_jobs=options.jobs, batch_size=1, return_as="generator_unordered")
    for row in pool(delayed(scene)(number, options.seed, options.out) for number in missing):
        rows.append(row)
        with path.open("a") as file:
            file.write(json.dumps(row) + "\n")
    rows = [row for row in rows if row["seed"] == options.seed]
    trials = selection.read_trials(options.out)
    write_csv(options.out / "promise.csv", sorted(rows, key=lambda row: row["number"]), trials)
    report(rows, trials)


if __name__ == "__main__":
    main()
