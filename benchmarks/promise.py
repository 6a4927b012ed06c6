"""Is a promised accuracy kept? Random scenes, each with the model that the program chooses, against the truth.

    python benchmarks/promise.py [--seed 1] [--count 120] [--jobs 2] [--out results/promise] [--again]

A scene is a study of one case, which asks 5, 2 and 1 % of the fault's line, the RMS and the largest outer force.
What its trials cost is told for 5 % of the line. The truth is the reference with half of its step or a tolerance
of 1e-7, `spatial` with 48 slices, and where its motion is chaotic, 10 s long (`spatial` 2 s, a ring that bends 4
s; the largest force is that of a record as long as the other's). OUT/scenes.jsonl has a line for each scene,
OUT/trials its trials; one that is there is not computed again, or with `--again` only its trials are.
OUT/promise.csv has what came of each.
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
"""How close, and whether of the line alone."""
FINER, TOLERANCE, SLICES = 0.5, 1e-7, 48
COMPILING = 10.0  # s of CPU time in which all of a model is compiled
LONG, LONG_IN_SPACE, LONG_BENT = 10.0, 2.0, 4.0  # s of a chaotic motion
STANDARD_ERRORS = 2.0
OF_RMS_SCATTER = 2.5
KINDS = {
    "line": lambda name: "@" in name,
    "rms": lambda name: name.endswith(".rms"),
    "force": lambda name: name.startswith("outer"),
}


def draw(number: int, seed: int) -> dict[str, Any]:
    """A scene as a study's YAML: each sixth has a defect off the middle, each sixth a ring that bends."""
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
        "friction": "none",  # as the truth: with it ``benchmarks/friction.py`` judges
        "duration": f"{2.2 * 1800.0 / rpm if race == 'roller' else 1.0} s",  # 2BSF is close to BPFO
        "record": [],
        "accuracy": {"within": "5 %", "of": of},
        **({"rig": rig} if rig else {}),
    }


def is_off_the_middle(number: int) -> bool:
    """Whether a scene's defect lies off the roller's middle, so that its rollers tilt."""
    return number % 6 == 4


def study_of(number: int, seed: int) -> Study:
    """A scene as a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(yaml.safe_dump(draw(number, seed)))
        return load_study(path)


def asking(study: Study, within: float, lines_alone: bool = False) -> Study:
    """The study with another accuracy."""
    assert study.goal is not None
    of = tuple(name for name in study.goal.of if "@" in name or not lines_alone)
    return replace(study, goal=replace(study.goal, within=within, of=of))


def timed(case: Case) -> dict[str, Any]:
    """Features of a case, its CPU time, method and step."""
    began = time.process_time()
    found = simulate(case)
    told = {name: float(value) for name, value in found.features.items()}
    info = {name: float(found.info[name]) for name in ("step_s", "period_passes", "passes", "passes_computed")}
    return told | info | {"method": found.info["method"], "cpu_s": time.process_time() - began}


def truth(case: Case, usual: dict[str, Any]) -> dict[str, float]:
    """What is right: half the step, more slices, a longer record where the motion is chaotic."""
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
    """Trials and results of a scene by each candidate, and the truth."""
    told: dict[str, Any] = {"number": number, "seed": seed}
    try:
        return told | computed(study_of(number, seed), f"{seed}-{number}", out)
    except (SimulationError, StudyError, ValueError) as error:
        return told | {"refused": str(error)[:300]}


def computed(study: Study, unit: str, out: Path) -> dict[str, Any]:
    """All of a scene that can be."""
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
    """CPU s of the trials of a scene's reference and candidates, and what they found, which is stored."""
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
    """A scene with new trials."""
    if "results" not in row:
        return row
    study = study_of(row["number"], row["seed"])
    return row | {"trial_s": all_trials(study, f"{row['seed']}-{row['number']}", out)[0]}


def tried(one: Trialled) -> tuple[float, Trial | None]:
    """CPU s of a trial, compiling apart, and what it found: one so short that compiling counts is made twice."""
    took, found = tried_once(one)
    return (took, found) if took > COMPILING else tried_once(one)


def tried_once(one: Trialled) -> tuple[float, Trial | None]:
    """CPU s of a trial, and what it found."""
    began, found = time.process_time(), None
    with suppress(SimulationError):
        found = try_out(one.case, one.asked, one.passes, one.turn)[0]
    return time.process_time() - began, found


def results_of(cases: dict[str, Case]) -> Iterator[tuple[str, dict[str, float]]]:
    """Of each candidate that can be computed."""
    for name, case in cases.items():
        try:
            yield name, timed(case)
        except SimulationError:
            continue


def standard_error(feature: str, found: dict[str, float]) -> float:
    """That of a feature of a chaotic motion (SI), as far as the record tells."""
    if found["chaotic"] != 1.0:
        return 0.0
    scatter = found.get(f"{feature}-scatter", 0.0)
    if feature.endswith(".rms"):
        scatter = found[feature] * found.get("rms_scatter", 0.0) / OF_RMS_SCATTER
    return scatter if np.isfinite(scatter) else 0.0


def kept(feature: str, found: dict[str, float], right: dict[str, float], model: float) -> dict[str, float]:
    """How far off a feature is, relative, and what was said of it."""
    size = abs(right[feature]) or 1.0
    errors = [standard_error(feature, one) / size for one in (found, right)]
    step = found.get(f"step_error.{kind_of(feature)}", 0.0)
    off = abs(found[feature] - right[feature]) / size
    return {"off": off, "scatter": errors[0], "both": hypot(*errors), "model": model, "step": np.nan_to_num(step)}


def kind_of(feature: str) -> str:
    """`line`, `rms` or `force`."""
    return next(kind for kind, of in KINDS.items() if of(feature))


class Replayed(NamedTuple):
    """What the program takes for a scene, and the CPU s of the trials that it wants for that."""

    row: dict[str, Any]
    choice: selection.Choice
    trials_s: float


def replay(row: dict[str, Any], study: Study, within: float, lines_alone: bool, known: Known) -> Replayed:
    """The choice for a scene, from trials that have been made."""
    asked = asking(study, within, lines_alone)
    choosing, seen, spent = selection.Choosing(asked, [0]), dict[str, Trial | None](), 0.0
    while wanted := choosing.wanted(seen):
        for one in wanted:
            stored = trials_of(study, 0, one.case)[0].id  # where all is asked
            seen[one.id] = known.get(stored)
            spent += row["trial_s"].get(stored, 0.0)
    return Replayed(row, choosing.decide(seen).choices[key(asked, study.cases()[0])], spent)


def report(rows: list[dict[str, Any]], known: Known) -> None:
    """Print how often what was promised is kept, every miss, and what it cost."""
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
    """A line for each scene, accuracy and feature: what was taken, how far off it is, what was said (shares)."""
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
    """How often a kind of feature was as close as promised; its misses are printed."""
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
    """The features that a scene asks an accuracy of."""
    return [f"velocity@{FAULT_LINES[row['race']]}", "velocity.rms", "outer_force.max"]


def of_group(of: list[Replayed]) -> str:
    """CPU time of a group, and which candidates were taken how often."""
    always = sum(one.row["results"][REFERENCE]["cpu_s"] for one in of)
    taken = sum(cost_of(one) for one in of)
    names = [one.choice.candidate for one in of]
    counts = ", ".join(f"{name} {names.count(name)}" for name in dict.fromkeys(names))
    return f"{len(of)} scenes, {taken / always:.2f} ({taken:.0f} of {always:.0f} s); {counts}"


def cost_of(one: Replayed) -> float:
    """CPU s of a scene's trials and of what was taken; a reference that repeats itself is its own trial."""
    own = float(one.row["results"][one.choice.candidate]["cpu_s"])
    return own if one.row["repeats"] else one.trials_s + own


def main() -> None:
    """Compute the scenes that are missing, then report."""
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
    todo = sorted((n for n in range(given.count) if n not in there), key=is_off_the_middle)  # they take longest
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
