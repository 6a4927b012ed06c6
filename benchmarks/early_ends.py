"""Accuracy and cost of records that end early under an `accuracy`.

    python -m benchmarks.early_ends [--scenes 40] [--seed 5077] [--before d1394a6] [--csv docs/data/early_ends.csv]

The light scenes of ``benchmarks/friction.py``, 1 s long, request 2 % for the defect line and the RMS, without a
friction setting. The result, ended early or not, is compared with the same case in full; both features must be
within 2 %. The report also counts those within two combined standard errors of both records. The CPU time of
trials and job is divided by that of `planar` with its default cage and friction at an earlier commit, measured in
the same minute; compilation is excluded. Scenes in OUT are not recomputed. Exit code 1 if less than 95 % are
within 2 %, or the CPU time ratio exceeds 1/4.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from math import hypot, nan
from pathlib import Path
from typing import Any

from bearingsim.config.names import FAULT_LINES
from bearingsim.core.jit import compilation_callbacks
from bearingsim.simulation import SimulationError, simulate
from bearingsim.simulation.record import Record
from bearingsim.study import case_id
from benchmarks.friction import AutomaticRun, draw, study_of
from benchmarks.rows import rounded, write_csv

ACCURACY, MIN_SHARE, MAX_COST = 0.02, 0.95, 0.25
STANDARD_ERRORS = 2.0
UNREACHABLE = 1e-6
"""Value of `until` that is never reached, so that a record is analysed but not ended early."""

BASELINE_SCRIPT = """
import json, sys, tempfile, time
from pathlib import Path
from bearingsim import simulation
from bearingsim.study import load_study
compile_solvers = getattr(simulation, "compile_solvers", None) or simulation.warm  # its name at d1394a6
for line in sys.stdin:
    path = Path(tempfile.mkdtemp()) / "scene.yaml"
    path.write_text(line)
    [case] = load_study(path).cases()
    compile_solvers([case])
    began = time.process_time()
    try:
        simulation.simulate(case)
        print(time.process_time() - began, flush=True)
    except ValueError:
        print("nan", flush=True)
"""


def baseline_cpu(commit: str) -> Callable[[dict[str, Any]], float]:
    """Return a function that measures the CPU time (s) of a scene in `planar` with its defaults at a commit."""
    checkout = Path("results") / f"before-{commit}"
    if not checkout.exists():
        subprocess.run(
            ["git", "worktree", "add", "--detach", str(checkout), commit], check=True, capture_output=True
        )
    process = subprocess.Popen(
        [sys.executable, "-c", BASELINE_SCRIPT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(checkout.resolve())},
        cwd=checkout,
    )

    def measure(scene: dict[str, Any]) -> float:
        assert process.stdin is not None
        assert process.stdout is not None
        fields = {name: value for name, value in scene.items() if name not in ("accuracy", "record")}
        process.stdin.write(json.dumps(fields | {"model": "planar"}) + "\n")
        process.stdin.flush()
        return float(process.stdout.readline())

    return measure


def scene_of(number: int, seed: int) -> tuple[dict[str, Any], str]:
    """Return the fields of a scene's study, and the name of its line."""
    scene = draw("light", number, seed)
    line = f"velocity@{FAULT_LINES[scene['defect']['race']]}"
    return scene | {"accuracy": {"within": f"{ACCURACY:.0%}", "of": [line, "velocity.rms"]}}, line


def compare_scene(number: int, seed: int, baseline: Callable[[dict[str, Any]], float]) -> dict[str, Any]:
    """Compute a scene as in a run with an accuracy, then in full, and compare."""
    scene, line = scene_of(number, seed)
    automatic, early = _without_compilation(scene)
    full = simulate(automatic.case.model_copy(update={"until": UNREACHABLE}))
    info = early.info
    row: dict[str, Any] = {"scene": number, "load": scene["load"], "speed": scene["speed"]}
    row |= {"race": scene["defect"]["race"], "taken": automatic.choice.candidate}
    row |= {"passes": info["passes_computed"], "of": info["passes"], "period": info["period_passes"]}
    row |= {"chaotic": early.features["chaotic"], "trials_s": automatic.trials_s, "job_s": automatic.job_s}
    row |= {"before_s": baseline(scene)}
    for kind, name in (("line", line), ("rms", "velocity.rms")):
        key = f"standard_error_{kind}"
        row[f"{kind}_off"] = abs(early.features[name] / full.features[name] - 1.0)
        row[f"{kind}_stated"] = info[key]
        row[f"{kind}_beside"] = STANDARD_ERRORS * hypot(float(info[key]), float(full.info[key]))
    return row


def _without_compilation(scene: dict[str, Any]) -> tuple[AutomaticRun, Record]:
    """Return the run of a scene and the record of its job, computed again if code was compiled for them."""
    compiled: list[None] = []
    with compilation_callbacks(lambda: compiled.append(None), lambda: None):
        for _ in range(2):
            records: dict[str, tuple[Record, float]] = {}
            compiled.clear()
            automatic = AutomaticRun(study_of(scene), records)
            if not compiled:
                break
    return automatic, records[case_id(automatic.case)][0]


def rows_of(count: int, seed: int, commit: str, out: Path, seconds: float) -> list[dict[str, Any]]:
    """Return the scenes, computing missing ones until ``seconds`` of CPU time are used."""
    rows: list[dict[str, Any]] = []
    measure = baseline_cpu(commit)
    for number in range(count):
        path = out / f"{seed}-{number}.json"
        if not path.exists():
            if time.process_time() > seconds:
                break
            try:
                row = compare_scene(number, seed, measure)
            except SimulationError as error:
                row = {"scene": number, "refused": str(error)[:200]}
            path.write_text(json.dumps(row))
        row = json.loads(path.read_text())
        print(*(f"{name}={value}" for name, value in rounded(row, 3).items()), flush=True)
        rows += [row] if "refused" not in row else []
    return rows


def report(rows: list[dict[str, Any]]) -> bool:
    """Print accuracy, coverage and cost of the scenes; return whether they meet the limits."""
    kinds = ("line", "rms")
    ended = [row for row in rows if not row["period"] and row["passes"] < row["of"]]
    accurate = sum(all(row[f"{kind}_off"] <= ACCURACY for kind in kinds) for row in rows)
    covered = {kind: sum(row[f"{kind}_off"] <= row[f"{kind}_beside"] for row in ended) for kind in kinds}
    chaotic = sum(row["chaotic"] == 1.0 for row in ended)
    print(f"{accurate} of {len(rows)} within {ACCURACY:.0%}; {len(ended)} ended early, {chaotic} of them chaotic")
    print(f"within {STANDARD_ERRORS:g} standard errors, of those: line {covered['line']}, RMS {covered['rms']}")
    print(f"CPU time over that before: {cost(rows):.2f}, of those that ended early {cost(ended):.2f}")
    return accurate >= MIN_SHARE * len(rows) and cost(rows) <= MAX_COST


def cost(rows: list[dict[str, Any]]) -> float:
    """Return the CPU time of trials and jobs relative to that before; NaN without scenes."""
    baseline_s = sum(row["before_s"] for row in rows)
    return sum(row["trials_s"] + row["job_s"] for row in rows) / baseline_s if rows else nan


def main() -> None:
    """Compute missing scenes, write the table, report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=5077)
    parser.add_argument("--before", default="d1394a6")
    parser.add_argument("--out", type=Path, default=Path("results/early-ends"))
    parser.add_argument("--seconds", type=float, default=150.0, help="CPU time after which no scene is begun")
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = rows_of(options.scenes, options.seed, options.before, options.out, options.seconds)
    if options.csv:
        write_csv(rows, options.csv, digits=3)
    sys.exit(int(not report(rows)))


if __name__ == "__main__":
    main()
