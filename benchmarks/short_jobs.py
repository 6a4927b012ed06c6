"""CPU time of a study of many short `ring` jobs, by part, and of single jobs outside their steps.

    python -m benchmarks.short_jobs [--loads 1000]

NF308, a slot of 0.8 mm x 50 um, 1800 rpm; records of 10 ms without series, at loads from 100 to 300 N. Each load
has a job with the slot and one without, and nine jobs try other damping. All run in this process. Single jobs have
a record of 1 s with its series; each has a load of its own, so that it shares no result with another job.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from bearingsim import runner
from bearingsim.config import Case
from bearingsim.simulation import simulate
from bearingsim.study import load_study
from bearingsim.study.jobs import case_id

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
STUDY = """\
study: short
bearing: nf308
model: ring
speed: 1800 rpm
load: 150 N
defect: {{shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}}
duration: 10 ms
settle: 10 ms
record: []
sweep: {{load: {{linspace: [100 N, 300 N, {loads}]}}}}
"""
SINGLE_JOBS = 20


def print_study(loads: int, folder: Path) -> None:
    """Print the parts of a run of the study; a run of three loads is made before, so that nothing is compiled."""
    for count in (3, loads):
        study_file, begin = folder / f"{count}.yaml", time.process_time()
        study_file.write_text(STUDY.format(loads=count))
        study = load_study(study_file)
        jobs = study.jobs()
        loaded = time.process_time()
        ids = {job.id for job in jobs}
        identified = time.process_time()
        summary = runner.run(study, folder / str(count), jobs=1, progress=False)
        total = time.process_time() - begin
    steps, jobs_s = summary.integrator_cpu_s, summary.cpu_s
    parts = {
        "study file, cases": loaded - begin,
        "step limits, method, id": identified - loaded,
        "steps": steps,
        "rest of the jobs, and their units": jobs_s - steps,
        "estimates, plan, table, statements": total - jobs_s - (identified - begin),
    }
    print(f"{len(ids)} jobs of 10 ms: {1e3 * total / len(ids):.2f} ms of CPU time each")
    for part, seconds in parts.items():
        print(f"  {part:36} {1e3 * seconds / len(ids):6.2f} ms")


def print_single_jobs(model: str) -> None:
    """Print the mean CPU time of jobs of 1 s, and the part outside their steps; the first two are left out."""
    fields = {"bearing": "nf308", "speed": "1800 rpm", "model": model, "defect": SLOT, "duration": 1.0}
    times = []
    for load in np.linspace(100.0, 300.0, SINGLE_JOBS + 2):
        case, begin = Case.model_validate(fields | {"load": float(load)}), time.process_time()
        case_id(case)
        steps = float(simulate(case).info["integrator_cpu_s"])
        times.append((time.process_time() - begin, steps))
    total, steps = 1e3 * np.mean(times[2:], axis=0)
    print(f"{model}, 1 s: {total:.1f} ms of CPU time a job, {total - steps:.1f} ms outside its steps")


def main() -> None:
    """Measure the study, then single jobs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loads", type=int, default=1000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print_study(options.loads, Path(folder))
    for model in ("ring", "rollers"):
        print_single_jobs(model)


if __name__ == "__main__":
    main()
