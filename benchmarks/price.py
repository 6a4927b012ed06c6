"""Measured CPU time and memory of jobs, compared with their estimates.

    python -m benchmarks.price [--jobs 40] [--seed 1] [--most 60] [--csv FILE] [--kept FILE]

Jobs are drawn over all models and methods, records of 1 to 300 s, and everything else that affects the estimate
(``draw``); jobs that may take over ``most`` s are redrawn. Each runs in a separate process, where a short run
compiles; then its CPU time and peak memory are measured. Estimates are made for one machine, so CPU times are
divided by the median ratio of measured to estimated time of some reference jobs. Measurements are stored in the
file ``--kept`` (JSON lines); if it exists, they are compared with new estimates instead of being repeated.
"""

import argparse
import csv
import json
import random
import resource
import subprocess
import sys
import tempfile
import time
from itertools import chain
from math import exp, log
from pathlib import Path
from statistics import median
from types import SimpleNamespace
from typing import Any

from bearingsim.catalogue import METHODS, MODELS
from bearingsim.config import Case
from bearingsim.memory import PROGRAM
from bearingsim.simulation import choice, simulate, time_grid, warm
from bearingsim.simulation.run_setup import SimulationError
from bearingsim.simulation.simulate import Record
from bearingsim.store import write_units

FIELDS = ["model", "method", "duration_s", "sampling_Hz", "repeats", "step_held", "cpu_s", "priced_s", "cpu_ratio"]
FIELDS += ["memory_MB", "priced_MB", "memory_ratio"]
FIXED = {"bearing": "nf308", "settle": "0.05 s"}
REFERENCES: list[dict[str, Any]] = [
    {"model": "ring", "duration": 5.0},
    {"model": "rollers", "duration": 1.0},
    {"model": "planar", "duration": 0.5},
    {"model": "spatial", "duration": 0.05},
    {"model": "static", "duration": 0.5},
    {"model": "planar", "duration": 0.3, "method": "rodas"},
]
"""Jobs that measure the speed of the machine; their motion is computed in full."""
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}


def main() -> None:
    """Draw, measure, print; or measure one job."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--most", type=float, default=60.0)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--job", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.job:
        print(json.dumps(measured(case_of(json.loads(asked.job)))))
        return
    jobs = kept(asked.kept) if asked.kept and asked.kept.exists() else measure(asked)
    priced = [(drawn, found, prices(case_of(drawn), found)) for drawn, found in jobs]
    machine = median(found["cpu_s"] / price["seconds"] for _, found, price in priced[: len(REFERENCES)])
    print(f"this machine takes {machine:.2f} times the priced CPU time ({len(REFERENCES)} reference jobs)")
    rows = [row(*one, machine) for one in priced[len(REFERENCES) :]]
    for one in [FIELDS, *rows]:
        print(*(f"{value:>12.3g}" if isinstance(value, float) else f"{value:>15}" for value in one))
    told(rows)
    if asked.csv:
        with asked.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([FIELDS, *rows])


Measured = tuple[dict[str, Any], dict[str, Any]]
"""Fields of a job, and its measurements."""


def kept(file: Path) -> list[Measured]:
    """Read stored measurements."""
    return [tuple(json.loads(line)) for line in file.read_text(encoding="utf-8").splitlines()]


def measure(asked: argparse.Namespace) -> list[Measured]:
    """Measure the reference jobs and random jobs, each in a separate process."""
    chance, found = random.Random(asked.seed), []
    full = {"periodic": False, "defect": SLOT, "load": 150.0, "speed": "1800 rpm", "step_check": False}
    drawn = [one | full for one in REFERENCES]
    for one in chain(drawn, (affordable(chance, asked.most) for _ in range(asked.jobs))):
        found.append((one, apart(one)))
        if asked.kept:
            with asked.kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(found[-1]) + "\n")
    return found


def prices(case: Case, found: dict[str, Any]) -> dict[str, float]:
    """Return the estimated CPU time (s) and memory (bytes), given whether the response is periodic."""
    price = time_grid.estimate(case)
    if found["repeats"]:
        return {"seconds": price.cpu_seconds, "bytes": PROGRAM + price.memory}
    return {"seconds": price.most_seconds, "bytes": PROGRAM + price.most_memory}


def case_of(drawn: dict[str, Any]) -> Case:
    """Make the case of drawn fields."""
    return Case.model_validate(FIXED | drawn)


def affordable(chance: random.Random, most: float) -> dict[str, Any]:
    """Draw a job that can run and takes less than ``most`` s."""
    while True:
        drawn = draw(chance)
        try:
            if time_grid.estimate(case_of(drawn)).most_seconds < most:
                return drawn
        except ValueError:
            continue


def draw(chance: random.Random) -> dict[str, Any]:
    """Draw the fields of a job."""
    model = chance.choice([*MODELS])
    drawn: dict[str, Any] = {
        "model": model,
        "duration": exp(chance.uniform(0.0, log(300.0))),
        "speed": f"{chance.uniform(300.0, 3000.0)} rpm",
        "load": chance.uniform(100.0, 1000.0),
        "sampling": chance.choice([5120.0, 10240.0, 20480.0, 51200.0]),
        "periodic": chance.random() < 0.5,
        "antialias": chance.random() < 0.8,
        "step_check": chance.random() < 0.3,
        "record": chance.choice(
            [["ring.velocity"], [], ["ring.displacement", "ring.velocity", "ring.acceleration"]]
        ),
    }
    if not MODELS[model].memoryless and not MODELS[model].own_method:
        drawn["method"] = chance.choice(["auto", *METHODS])
    if chance.random() < 0.8:
        drawn["defect"] = SLOT | {"race": chance.choice(["outer", "outer", "inner"])}
    if MODELS[model].slips:
        drawn["cage"] = {"motion": chance.choice(["free", "kinematic"])}
        if chance.random() < 0.2:
            drawn["ramp"] = {"to": "3600 rpm", "time": "0.5 s"}
    return drawn


def apart(drawn: dict[str, Any]) -> dict[str, Any]:
    """Measure a job in a separate process."""
    command = [sys.executable, "-m", "benchmarks.price", "--job", json.dumps(drawn)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def measured(case: Case) -> dict[str, Any]:
    """Measure CPU time (s) and memory (bytes) of a case; the result states whether it gave a record."""
    warm([case])
    for flags in ({}, {"periodic": False}):
        moment = {"duration": 6.0 / case.bearing.ball_pass_frequency(case.speed), "settle": 0.0}
        _run(case.model_copy(update=moment | flags))
    before, began = _peak(), time.process_time()
    record = _run(case)
    found = {
        "cpu_s": time.process_time() - began,
        "bytes": PROGRAM + _peak() - before,
        "given": record is not None,
    }
    if record is None:
        return found | {"repeats": False, "method": "", "held": False}
    told = {name: float(record.info[name]) for name in ("period_passes", "step_part", "integrator_cpu_s")}
    method, first = str(record.info["method"] or ""), choice.resolved(case).method or ""
    held = told["step_part"] == 1.0 and method == first
    return found | told | {"repeats": told["period_passes"] > 0, "method": method, "held": held}


def _run(case: Case) -> Record | None:
    """Compute and store a case; return None if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            record = simulate(case)
        except SimulationError:
            return None
        job: Any = SimpleNamespace(id="job", case=case)
        write_units(Path(folder), [(job, record)], {})
        return record


def _peak() -> float:
    """Return the peak memory (bytes) of this process."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def row(drawn: dict[str, Any], found: dict[str, Any], price: dict[str, float], machine: float) -> list[Any]:
    """Return a row of the table; failed jobs have no ratio of CPU times."""
    cpu = found["cpu_s"] / machine
    return [
        drawn["model"],
        found["method"] or ("-" if found["given"] else "no record"),
        round(drawn["duration"], 2),
        drawn["sampling"],
        "yes" if found["repeats"] else "no",
        "yes" if found["held"] else "no",
        cpu,
        price["seconds"],
        cpu / price["seconds"] if found["given"] else float("nan"),
        found["bytes"] / 1e6,
        price["bytes"] / 1e6,
        found["bytes"] / price["bytes"],
    ]


def told(rows: list[list[Any]]) -> None:
    """Print how many ratios are within a factor of 2."""
    sure = [one for one in rows if one[FIELDS.index("step_held")] == "yes"]
    for name, of in ("cpu_ratio", sure), ("memory_ratio", rows):
        ratios = [one[FIELDS.index(name)] for one in of] or [float("nan")]
        within = sum(0.5 <= ratio <= 2.0 for ratio in ratios)
        print(f"{name}: {within} of {len(ratios)} within a factor of 2; {min(ratios):.2f} to {max(ratios):.2f}")
    print(f"{len(rows) - len(sure)} jobs were given another step or method than was priced, or no record")


if __name__ == "__main__":
    main()
