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
from bearingsim.memory import PROGRAM_BYTES
from bearingsim.simulation import choice, compile_solvers, simulate, time_grid
from bearingsim.simulation.record import Record
from bearingsim.simulation.run_setup import SimulationError
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
    options = parser.parse_args()
    if options.job:
        print(json.dumps(measure_case(case_of(json.loads(options.job)))))
        return
    jobs = read_measurements(options.kept) if options.kept and options.kept.exists() else measure(options)
    estimated = [(fields, result, prices(case_of(fields), result)) for fields, result in jobs]
    speed_ratio = median(result["cpu_s"] / price["seconds"] for _, result, price in estimated[: len(REFERENCES)])
    print(f"this machine takes {speed_ratio:.2f} times the priced CPU time ({len(REFERENCES)} reference jobs)")
    rows = [row(*entry, speed_ratio) for entry in estimated[len(REFERENCES) :]]
    for entry in [FIELDS, *rows]:
        print(*(f"{value:>12.3g}" if isinstance(value, float) else f"{value:>15}" for value in entry))
    print_ratios(rows)
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([FIELDS, *rows])


Measurement = tuple[dict[str, Any], dict[str, Any]]
"""Fields of a job, and its measurements."""


def read_measurements(file: Path) -> list[Measurement]:
    """Read stored measurements."""
    return [tuple(json.loads(line)) for line in file.read_text(encoding="utf-8").splitlines()]


def measure(options: argparse.Namespace) -> list[Measurement]:
    """Measure the reference jobs and random jobs, each in a separate process."""
    rng, jobs = random.Random(options.seed), []
    full = {"periodic": False, "defect": SLOT, "load": 150.0, "speed": "1800 rpm", "step_check": False}
    references = [fields | full for fields in REFERENCES]
    for fields in chain(references, (draw_affordable(rng, options.most) for _ in range(options.jobs))):
        jobs.append((fields, measure_separately(fields)))
        if options.kept:
            with options.kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(jobs[-1]) + "\n")
    return jobs


def prices(case: Case, result: dict[str, Any]) -> dict[str, float]:
    """Return the estimated CPU time (s) and memory (bytes), given whether the response is periodic."""
    price = time_grid.estimate(case)
    if result["repeats"]:
        return {"seconds": price.cpu_seconds, "bytes": PROGRAM_BYTES + price.memory}
    return {"seconds": price.max_seconds, "bytes": PROGRAM_BYTES + price.max_memory}


def case_of(fields: dict[str, Any]) -> Case:
    """Make the case of drawn fields."""
    return Case.model_validate(FIXED | fields)


def draw_affordable(rng: random.Random, most: float) -> dict[str, Any]:
    """Draw a job that can run and takes less than ``most`` s."""
    while True:
        fields = draw(rng)
        try:
            if time_grid.estimate(case_of(fields)).max_seconds < most:
                return fields
        except ValueError:
            continue


def draw(rng: random.Random) -> dict[str, Any]:
    """Draw the fields of a job."""
    model = rng.choice([*MODELS])
    fields: dict[str, Any] = {
        "model": model,
        "duration": exp(rng.uniform(0.0, log(300.0))),
        "speed": f"{rng.uniform(300.0, 3000.0)} rpm",
        "load": rng.uniform(100.0, 1000.0),
        "sampling": rng.choice([5120.0, 10240.0, 20480.0, 51200.0]),
        "periodic": rng.random() < 0.5,
        "antialias": rng.random() < 0.8,
        "step_check": rng.random() < 0.3,
        "record": rng.choice([["ring.velocity"], [], ["ring.displacement", "ring.velocity", "ring.acceleration"]]),
    }
    if not MODELS[model].memoryless and not MODELS[model].own_method:
        fields["method"] = rng.choice(["auto", *METHODS])
    if rng.random() < 0.8:
        fields["defect"] = SLOT | {"race": rng.choice(["outer", "outer", "inner"])}
    if MODELS[model].slips:
        fields["cage"] = {"motion": rng.choice(["free", "kinematic"])}
        if rng.random() < 0.2:
            fields["ramp"] = {"to": "3600 rpm", "time": "0.5 s"}
    return fields


def measure_separately(fields: dict[str, Any]) -> dict[str, Any]:
    """Measure a job in a separate process."""
    command = [sys.executable, "-m", "benchmarks.price", "--job", json.dumps(fields)]
    process = subprocess.run(command, capture_output=True, text=True, check=True)
    result: dict[str, Any] = json.loads(process.stdout.splitlines()[-1])
    return result


def measure_case(case: Case) -> dict[str, Any]:
    """Measure CPU time (s) and memory (bytes) of a case; the result states whether it gave a record."""
    compile_solvers([case])
    for flags in ({}, {"periodic": False}):
        short = {"duration": 6.0 / case.bearing.ball_pass_frequency(case.speed), "settle": 0.0}
        _run(case.model_copy(update=short | flags))
    start_peak, began = _peak(), time.process_time()
    record = _run(case)
    result = {
        "cpu_s": time.process_time() - began,
        "bytes": PROGRAM_BYTES + _peak() - start_peak,
        "given": record is not None,
    }
    if record is None:
        return result | {"repeats": False, "method": "", "held": False}
    facts = {name: float(record.info[name]) for name in ("period_passes", "step_part", "integrator_cpu_s")}
    method, chosen = str(record.info["method"] or ""), choice.resolve(case).method or ""
    has_full_step = facts["step_part"] == 1.0 and method == chosen
    return result | facts | {"repeats": facts["period_passes"] > 0, "method": method, "held": has_full_step}


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


def row(fields: dict[str, Any], result: dict[str, Any], price: dict[str, float], speed_ratio: float) -> list[Any]:
    """Return a row of the table; failed jobs have no ratio of CPU times."""
    cpu = result["cpu_s"] / speed_ratio
    return [
        fields["model"],
        result["method"] or ("-" if result["given"] else "no record"),
        round(fields["duration"], 2),
        fields["sampling"],
        "yes" if result["repeats"] else "no",
        "yes" if result["held"] else "no",
        cpu,
        price["seconds"],
        cpu / price["seconds"] if result["given"] else float("nan"),
        result["bytes"] / 1e6,
        price["bytes"] / 1e6,
        result["bytes"] / price["bytes"],
    ]


def print_ratios(rows: list[list[Any]]) -> None:
    """Print how many ratios are within a factor of 2."""
    exact = [row_ for row_ in rows if row_[FIELDS.index("step_held")] == "yes"]
    for name, group in ("cpu_ratio", exact), ("memory_ratio", rows):
        ratios = [row_[FIELDS.index(name)] for row_ in group] or [float("nan")]
        within = sum(0.5 <= ratio <= 2.0 for ratio in ratios)
        print(f"{name}: {within} of {len(ratios)} within a factor of 2; {min(ratios):.2f} to {max(ratios):.2f}")
    print(f"{len(rows) - len(exact)} jobs were given another step or method than was priced, or no record")


if __name__ == "__main__":
    main()
