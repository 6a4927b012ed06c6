"""Accuracy of automatically chosen models in random scenes, compared with the requested one.

    python benchmarks/promise.py [--seed 1] [--count 120] [--jobs 2] [--out results/promise] [--again]

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
from bearingsim.selection.candidates import candidates, reference
from bearingsim.selection.choices import key
from bearingsim.selection.trials import Known, Trialled, first_trials, repeats, trials_of
from bearingsim.simulation import SimulationError, simulate, try_out
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study, StudyError, load_study

WITHIN = (0.05, 0.02, 0.01)
FOR_CPU = 0.05, True
GOALS = (*((within, False) for within in WITHIN), FOR_CPU)
"""Requested accuracies, and whether they are for the line alone."""
FINER, TOLERANCE, SLICES = 0.5, 1e-7, 48
COMPILING = 10.0  # s of CPU time, more than the compilation of a model takes
LONG, LONG_IN_SPACE, LONG_BENT = 10.0, 2.0, 4.0  # s, durations of a chaotic motion
STANDARD_ERRORS = 2.0
OF_RMS_SCATTER = 2.5
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
    bends = number % 6 == 5
    width = float(rng.uniform(0.2, 2.0))
    ball = number % 12 == 3
    length = float(rng.uniform(0.5, 3.0) if ball else rng.uniform(2.0, 12.0))
    rpm = float(np.exp(rng.uniform(np.log(1500.0 if race == "roller" else 300.0), np.log(6000.0))))
    offset = is_off_the_middle(number)
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
        "friction": "none",  # as in the converged solution; friction is tested by ``benchmarks/friction.py``
        "duration": f"{2.2 * 1800.0 / rpm if race == 'roller' else 1.0} s",  # 2BSF is close to BPFO
        "record": [],
        "accuracy": {"within": "5 %", "of": of},
        **({"rig": rig} if rig else {}),
    }


def is_off_the_middle(number: int) -> bool:
    """Check if the defect of a scene is offset from the roller's centre, so that rollers tilt."""
    return number % 6 == 4


def study_of(number: int, seed: int) -> Study:
    """Load a scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(draw(number, seed)))
        return load_study(path)


def asking(study: Study, within: float, lines_alone: bool = False) -> Study:
    """Return the study with another accuracy."""
    assert study.goal is not None
    of = tuple(name for name in study.goal.of if "@" in name or not lines_alone)
    return replace(study, goal=replace(study.goal, within=within, of=of))


def timed(case: Case) -> dict[str, Any]:
    """Compute features of a case, its CPU time, method and step."""
    began = time.process_time()
    found = simulate(case)
    told = {name: float(value) for name, value in found.features.items()}
    info = {name: float(found.info[name]) for name in ("step_s", "period_passes", "passes", "passes_computed")}
    return told | info | {"method": found.info["method"], "cpu_s": time.process_time() - began}


def truth(case: Case, usual: dict[str, Any]) -> dict[str, float]:
    """Compute the converged solution with a finer step, more slices, and a longer record if chaotic."""
    more: dict[str, Any] = {"step_check": False}
    if case.method is not None and METHODS[usual["method"]].adaptive:
        more |= {"method": usual["method"], "tolerance": TOLERANCE}
    elif case.method is not None:
        more["step"] = FINER * usual["step_s"]
    if case.model == "spatial":
        more["contact"] = case.contact.model_copy(update={"slices": SLICES})
    fine = case.model_copy(update=more)
    found = timed(fine)
    long = LONG_IN_SPACE if case.model == "spatial" else LONG if case.rig.ring is None else LONG_BENT
    if usual["chaotic"] == 1.0 and long > case.duration:
        found = timed(fine.model_copy(update={"duration": long})) | {"outer_force.max": found["outer_force.max"]}
    return found | {"chaotic": usual["chaotic"]}


def scene(number: int, seed: int, out: Path) -> dict[str, Any]:
    """Return trials and results of a scene by each chosen candidate, and the converged solution."""
    told: dict[str, Any] = {"number": number, "seed": seed}
    try:
        return told | computed(study_of(number, seed), f"{seed}-{number}", out)
    except (SimulationError, StudyError, ValueError) as error:
        return told | {"refused": str(error)[:300]}


def computed(study: Study, unit: str, out: Path) -> dict[str, Any]:
    """Compute the row of a scene."""
    own = study.cases()[0]
    case, others = reference(own), {name: found[0] for name, found in candidates(study, [0]).items()}
    simulation.warm([case, *others.values()])
    trial_s, known = all_trials(study, unit, out)
    usual = timed(case)
    told = {"trial_s": trial_s}
    taken = {replay(told, study, *goal, known).choice.candidate for goal in GOALS} - {REFERENCE}
    results = {REFERENCE: usual} | dict(results_of({name: others[name] for name in taken}))
    return {
        "reference": case.model,
        "repeats": usual["period_passes"] > 0.0,
        "race": case.defects[0].race,
        "shape": case.defects[0].shape,
        "offset": case.defects[0].offset != 0.0,
        "bends": case.rig.ring is not None,
        "clearance_um": 1e6 * case.clearance,
        "trial_s": trial_s,
        "results": results,
        "truth": truth(case, usual),
    }


def all_trials(study: Study, unit: str, out: Path) -> tuple[dict[str, float], Known]:
    """Run and store the trials of a scene's reference and candidates; return their CPU times (s) and results."""
    took: dict[str, float] = {}
    known: dict[str, Trial | None] = {}
    for one in first_trials(study, [0]):
        took[one.id], known[one.id] = tried(one)
    if not repeats(study, 0, known):
        for other in candidates(study, [0]).values():
            for one in trials_of(study, 0, other[0]):
                took[one.id], known[one.id] = tried(one)
    selection.write_trials(out, unit, known)
    return took, known


def again(row: dict[str, Any], out: Path) -> dict[str, Any]:
    """Return a scene with new trials."""
    if "results" not in row:
        return row
    study = study_of(row["number"], row["seed"])
    return row | {"trial_s": all_trials(study, f"{row['seed']}-{row['number']}", out)[0]}


def tried(one: Trialled) -> tuple[float, Trial | None]:
    """Return CPU time (s) and result of a trial, run twice if short, to exclude compilation."""
    took, found = tried_once(one)
    return (took, found) if took > COMPILING else tried_once(one)


def tried_once(one: Trialled) -> tuple[float, Trial | None]:
    """Return CPU time (s) and result of a trial."""
    began, found = time.process_time(), None
    with suppress(SimulationError):
        found = try_out(one.case, one.asked, one.passes, one.turn)[0]
    return time.process_time() - began, found


def results_of(cases: dict[str, Case]) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield the results of all candidates that can be computed."""
    for name, case in cases.items():
        try:
            yield name, timed(case)
        except SimulationError:
            continue


def standard_error(feature: str, found: dict[str, float]) -> float:
    """Return the standard error (SI) of a feature of a chaotic motion as stated by its record; else 0."""
    if found["chaotic"] != 1.0:
        return 0.0
    scatter = found.get(f"{feature}-scatter", 0.0)
    if feature.endswith(".rms"):
        scatter = found[feature] * found.get("rms_scatter", 0.0) / OF_RMS_SCATTER
    return scatter if np.isfinite(scatter) else 0.0


def kept(feature: str, found: dict[str, float], right: dict[str, float], model: float) -> dict[str, float]:
    """Return the relative error of a feature, and the stated errors."""
    size = abs(right[feature]) or 1.0
    errors = [standard_error(feature, one) / size for one in (found, right)]
    step = found.get(f"step_error.{kind_of(feature)}", 0.0)
    off = abs(found[feature] - right[feature]) / size
    return {"off": off, "scatter": errors[0], "both": hypot(*errors), "model": model, "step": np.nan_to_num(step)}


def kind_of(feature: str) -> str:
    """Return the kind of a feature, `line`, `rms` or `force`."""
    return next(kind for kind, of in KINDS.items() if of(feature))


class Replayed(NamedTuple):
    """Automatic choice for a scene, and CPU time (s) of the trials needed for it."""

    row: dict[str, Any]
    choice: selection.Choice
    trials_s: float


def replay(row: dict[str, Any], study: Study, within: float, lines_alone: bool, known: Known) -> Replayed:
    """Repeat the choice for a scene from stored trials."""
    asked = asking(study, within, lines_alone)
    choosing, seen, spent = selection.Choosing(asked, [0]), dict[str, Trial | None](), 0.0
    while wanted := choosing.wanted(seen):
        for one in wanted:
            stored = trials_of(study, 0, one.case)[0].id  # id of the trial with all features
            seen[one.id] = known.get(stored)
            spent += row["trial_s"].get(stored, 0.0)
    return Replayed(row, choosing.decide(seen).choices[key(asked, study.cases()[0])], spent)


def report(rows: list[dict[str, Any]], known: Known) -> None:
    """Print how often the accuracy is met, all misses, and the cost."""
    done = [(row, study_of(row["number"], row["seed"])) for row in rows if "results" in row]
    print(f"{len(rows)} scenes, {len(rows) - len(done)} refused")
    for within in WITHIN:
        told = [replay(row, study, within, False, known) for row, study in done]
        below = sum(one.choice.candidate != REFERENCE for one in told)
        print(f"\nwithin {within:.0%}: {below} of {len(told)} below the reference")
        for kind in KINDS:
            print(f"  {kind}: {of_kind(kind, within, told)}")
    print(f"\nCPU time with trials over always the reference, {FOR_CPU[0]:.0%} of the line alone:")
    groups: dict[str, list[Replayed]] = {}
    for row, study in done:
        repeating = "repeats" if row["repeats"] else "does not repeat"
        name = f"{row['reference']}{', bends' * row['bends']}, {repeating}"
        groups.setdefault(name, []).append(replay(row, study, *FOR_CPU, known))
    for name, of in sorted(groups.items()):
        print(f"  {name}: {of_group(of)}")


def write_csv(path: Path, rows: list[dict[str, Any]], known: Known) -> None:
    """Write a row per scene, accuracy and feature: choice, relative error and stated errors."""
    about = ("seed", "number", "reference", "race", "shape", "offset", "bends", "clearance_um", "repeats")
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        kinds = ("within", "taken", "chaotic", "feature", "off", "model", "step", "scatter", "both")
        writer.writerow([*about, *kinds])
        for row in rows:
            if "results" not in row:
                continue
            study = study_of(row["number"], row["seed"])
            for within in WITHIN:
                choice = replay(row, study, within, False, known).choice
                for name in asked_of(row):
                    of = kept(name, row["results"][choice.candidate], row["truth"], choice.error.get(name, 0.0))
                    told = [f"{of[kind]:.3g}" for kind in kinds[4:]]
                    chaotic = int(row["truth"]["chaotic"] == 1.0)
                    writer.writerow(
                        [*(row[what] for what in about), within, choice.candidate, chaotic, name, *told]
                    )


def of_kind(kind: str, within: float, told: list[Replayed]) -> str:
    """Summarise how often a kind of feature met the accuracy, and print its misses."""
    held, longer, honest = 0, 0, 0
    for row, choice, _ in told:
        found, right = row["results"][choice.candidate], row["truth"]
        name = next(name for name in asked_of(row) if kind_of(name) == kind)
        of = kept(name, found, right, choice.error.get(name, 0.0))
        estimate = of["model"] + of["step"] + STANDARD_ERRORS * of["both"]
        longer += of["model"] + of["step"] + of["scatter"] > within
        honest += of["off"] <= 3.0 * estimate + 1e-4
        keeps = of["off"] <= within + STANDARD_ERRORS * of["both"]
        held += keeps
        if not keeps:
            about = ", ".join(f"{name} {100.0 * value:.2g} %" for name, value in of.items())
            chaotic = " chaotic" * (row["truth"]["chaotic"] == 1.0)
            print(f"   miss: scene {row['number']}{chaotic}, {choice.candidate}: {name} {about}")
    return f"kept {held}, asks for a longer record {longer}, truth <= 3 estimates {honest}, of {len(told)}"


def asked_of(row: dict[str, Any]) -> list[str]:
    """List the features with a requested accuracy."""
    return [f"velocity@{FAULT_LINES[row['race']]}", "velocity.rms", "outer_force.max"]


def of_group(of: list[Replayed]) -> str:
    """Summarise the CPU time of a group, and how often each candidate was chosen."""
    always = sum(one.row["results"][REFERENCE]["cpu_s"] for one in of)
    taken = sum(cost_of(one) for one in of)
    names = [one.choice.candidate for one in of]
    counts = ", ".join(f"{name} {names.count(name)}" for name in dict.fromkeys(names))
    return f"{len(of)} scenes, {taken / always:.2f} ({taken:.0f} of {always:.0f} s); {counts}"


def cost_of(one: Replayed) -> float:
    """Return the CPU time (s) of trials and choice of a scene; a periodic reference is its own trial."""
    own = float(one.row["results"][one.choice.candidate]["cpu_s"])
    return own if one.row["repeats"] else one.trials_s + own


def main() -> None:
    """Compute missing scenes, then report."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--count", type=int, default=120)
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--out", type=Path, default=Path("results/promise"))
    asked.add_argument("--again", action="store_true", help="make the trials of what is there again")
    given = asked.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    path = given.out / "scenes.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    if given.again:
        rows = Parallel(n_jobs=given.jobs, batch_size=1)(delayed(again)(row, given.out) for row in rows)
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    there = {row["number"] for row in rows if row["seed"] == given.seed}
    todo = sorted((n for n in range(given.count) if n not in there), key=is_off_the_middle)  # these take longest
    pool = Parallel(n_jobs=given.jobs, batch_size=1, return_as="generator_unordered")
    for row in pool(delayed(scene)(n, given.seed, given.out) for n in todo):
        rows.append(row)
        with path.open("a") as file:
            file.write(json.dumps(row) + "\n")
    rows = [row for row in rows if row["seed"] == given.seed]
    known = selection.read_trials(given.out)
    write_csv(given.out / "promise.csv", sorted(rows, key=lambda row: row["number"]), known)
    report(rows, known)


if __name__ == "__main__":
    main()
