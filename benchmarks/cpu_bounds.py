"""Test of the CPU limit of a job in each of its phases.

    python -m benchmarks.cpu_bounds [--only NAME ...] [--csv docs/data/cpu_bounds.csv]

Extreme studies, each with its CPU time in a different phase of a job, are run twice by the command line in one
process under ``--max-cpu '5 s'``: the first run compiles, the second is measured. The CPU time of the command,
including start-up and table, must stay below 6 s per job.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from bearingsim import store

LIMIT_S, MAX_PER_JOB_S = 5.0, 6.0
"""CPU limit of a job, and largest measured CPU time per job (s)."""
COMMON_FIELDS = {"bearing": "nf308", "speed": "1800 rpm", "settle": "0 s"}
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
INNER = SLOT | {"race": "inner"}
LOADS = {"sweep": {"load": ["150 N", "165 N"]}}  # each load has a healthy case
EXTREMES: dict[str, dict[str, Any]] = {
    "light ring": {"model": "rollers", "duration": "0.1 s", "rig": {"ring_mass": "1e-6 kg"}, "defect": SLOT}
    | LOADS,
    "damping of a second": {
        "model": "rollers",
        "duration": "0.1 s",
        "contact": {"damping": {"law": "kraemer", "beta": "1 s"}},
        "defect": SLOT,
    }
    | LOADS,
    "load lost in rounding": {
        "model": "static",
        "duration": "0.1 s",
        "clearance": "-20 um",
        "defect": SLOT,
        "sweep": {"load": ["1e-3 N", "1.1e-3 N"]},
    },
    "slow turn": {"model": "rollers", "speed": "2 rpm", "duration": "6 s", "sampling": "100 Hz", "defect": INNER}
    | LOADS,
    "tight tolerance": {
        "model": "spatial",
        "method": "backward-euler",
        "tolerance": 1e-11,
        "duration": "0.02 s",
        "defect": SLOT,
    }
    | LOADS,
    "many slices": {
        "model": "spatial",
        "method": "rodas",
        "duration": "0.02 s",
        "contact": {"slices": 48},
        "defect": SLOT,
    }
    | LOADS,
    "many harmonics": {
        "model": "static",
        "duration": "0.05 s",
        "periodic": False,
        "rig": {"ring": {"harmonics": 60}, "load": {"by": "point"}},
        "defect": INNER,
    }
    | LOADS,
    "long record": {
        "model": "ring",
        "duration": "12 s",
        "sampling": "100 kHz",
        "periodic": False,
        "step_check": False,
        "record": ["ring.displacement", "ring.velocity", "ring.acceleration"],
        "defect": INNER,
    }
    | LOADS,
    "long filter": {
        "model": "ring",
        "duration": "2 s",
        "sampling": "2 Hz",
        "periodic": False,
        "step_check": False,
        "defect": INNER,
    }
    | LOADS,
}
"""Fields of each study, by name; most have an estimated cost below the limit, which they exceed."""
PHASES = {
    "check_step": "step check",
    "_record": "features and series",
    "solve_initial_equilibrium": "equilibrium",
    "_record_steps": "steps",
    "simulate": "other",
}
"""Phases of a job by a function in its traceback, in the order of the search."""


class StudyResult(NamedTuple):
    """Result of a study under a CPU limit: jobs and their outcome, CPU times, whether the limit was met.

    phase: phase in which jobs were stopped; priced_s: largest estimate of a job.
    """

    study: str
    jobs: int
    done: int
    stopped: int
    failed: int
    left_out: int
    phase: str
    priced_s: float
    cpu_s: float
    cpu_per_job_s: float
    compile_s: float
    held: bool


def study_of(name: str, folder: Path) -> Path:
    """Write an extreme study file."""
    path = folder / f"{name.replace(' ', '-')}.yaml"
    fields = {"study": path.stem, **COMMON_FIELDS, **EXTREMES[name]}
    path.write_text(json.dumps(fields, indent=1))
    return path


def measure(name: str) -> StudyResult:
    """Run an extreme study under the limit, after compilation."""
    with tempfile.TemporaryDirectory() as folder:
        study, out = study_of(name, Path(folder)), Path(folder) / "results"
        first = cpu_of_command(
            "run", str(study), "--jobs", "1", "--max-cpu", f"{LIMIT_S} s", "--out", f"{out}-first"
        )
        cpu = cpu_of_command("run", str(study), "--jobs", "1", "--max-cpu", f"{LIMIT_S} s", "--out", str(out))
        status = store.open_results(out).table()["status"].value_counts()
        failures = store.read_failures(out).values()
        jobs_planned = json.loads(output_of("check", str(study), "--json"))["jobs"]
    stopped = [failure for failure in failures if "--max-cpu" in failure.reason]
    jobs = int(status.sum())
    return StudyResult(
        study=name,
        jobs=jobs,
        done=int(status.get("done", 0)),
        stopped=len(stopped),
        failed=len(failures) - len(stopped),
        left_out=int(status.get("missing", 0)),
        phase=", ".join(sorted({phase(failure.traceback) for failure in stopped})),
        priced_s=max((job["estimate"]["cpu_seconds"] for job in jobs_planned), default=float("nan")),
        cpu_s=cpu,
        cpu_per_job_s=cpu / jobs,
        compile_s=max(0.0, first - cpu),
        held=cpu <= MAX_PER_JOB_S * jobs,
    )


def phase(traceback: str) -> str:
    """Return the phase of a job in which its traceback ends."""
    return next(name for function, name in PHASES.items() if f"in {function}\n" in traceback)


def cpu_of_command(*words: str) -> float:
    """Run a command; return the CPU time (s) of its processes."""
    start = _cpu_of_children()
    process = subprocess.run(
        [sys.executable, "-m", "bearingsim", *words], capture_output=True, text=True, check=False
    )
    if process.returncode not in (0, 1) or "Traceback" in process.stderr:
        raise RuntimeError(f"{' '.join(words)}: exit code {process.returncode}\n{process.stderr}")
    return _cpu_of_children() - start


def output_of(*words: str) -> str:
    """Run a command; return its output."""
    return subprocess.run(
        [sys.executable, "-m", "bearingsim", *words], capture_output=True, text=True, check=False
    ).stdout


def _cpu_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    """Run all or some studies; write the table. Exit code 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=EXTREMES, default=list(EXTREMES))
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args()
    rows = []
    for name in options.only:
        rows.append(measure(name))
        print(*(f"{key}={value}" for key, value in rows[-1]._asdict().items()), flush=True)
    table = pd.DataFrame(rows)
    if options.csv:
        table.to_csv(options.csv, index=False, float_format="%.2f", lineterminator="\n")
    sys.exit(int(not table["held"].all()))


if __name__ == "__main__":
    main()
