"""Cost of jobs and studies: CPU time of the phases of a job, many short jobs, two workers, a long record."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from math import nan
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import bearingsim
from bearingsim.config import Case
from bearingsim.selection.candidates import candidate_case
from bearingsim.simulation import record, simulate, step_check
from benchmarks.speed.report import Section, Target
from benchmarks.speed.scenes import case
from benchmarks.speed.timing import Measure, cpu_time, measure_in_turns, yardstick

FIG16 = Path("studies/fig16_angle.yaml")
MODELS, CASES_PER_MODEL = ("static", "ring", "rollers", "planar"), 8  # for fig. 16
PHASES = ("steps", "proof", "features", "rest")
OUTSIDE_STEPS = 8e-3  # s, largest CPU time of a job outside its steps
SHORT, JOB_COUNTS, SHORT_JOB = "10 ms", (125, 1000, 400, 125), 15e-3  # record, jobs, largest CPU time (s) of each
SHARED_JOBS, TWO_WORKERS = 200, 1.9  # jobs, minimum speed-up by a second worker
DURATIONS = (0.5, 1.0, 2.0, 4.0)  # s, computed in full
LONG, LONG_CPU, LONG_MEMORY = 60.0, 1.5, 60e6  # s; largest CPU time relative to 1 s, largest additional memory (B)
ROUNDS, SHORT_ROUNDS, SINGLE_NOISE = 6, 40, 0.1  # of jobs; of jobs of 0.05 s; assumed noise of a single timing
STUDY = """\
study: benchmark
bearing: nf308
speed: 1800 rpm
load: 150 N
model: {model}
duration: {duration}
defect: {{race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}}
sweep:
  load: {{linspace: [100 N, 200 N, {jobs}]}}
figures:
  - {{y: velocity@BPFO-healthy, x: load}}
"""
PEAK = """\
import resource, sys
from bearingsim.simulation import simulate
from benchmarks.speed.scenes import case
simulate(case("rollers", duration=float(sys.argv[1]), record=[]))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def section(report: Section) -> None:
    """Measure all."""
    measure_phases(report)
    growth_in_time(report)
    long_record(report)
    many_jobs(report)
    two_workers(report)


# One job


@contextmanager
def stopwatch(module: Any, name: str, spent: dict[str, float]) -> Iterator[None]:
    """Add up the CPU time (s) of all calls of a function of a module in ``spent[name]``."""
    function = getattr(module, name)

    def timed(*args: Any, **kwargs: Any) -> Any:
        began = time.thread_time()
        try:
            return function(*args, **kwargs)
        finally:
            spent[name] += time.thread_time() - began

    with mock.patch.object(module, name, timed):
        yield


def phases_of(case_: Case) -> dict[str, float]:
    """Return the CPU time (s) of a job by phase."""
    spent = {"check_step": 0.0, "compute_features": 0.0}
    with stopwatch(step_check, "check_step", spent), stopwatch(record, "compute_features", spent):
        began = time.thread_time()
        result = simulate(case_)
        total = time.thread_time() - began
    steps = float(result.info["integrator_cpu_s"])
    rest = total - steps - sum(spent.values())
    return dict(zip(PHASES, (steps, spent["check_step"], spent["compute_features"], rest), strict=True))


def fig16_cases(model: str) -> list[Case]:
    """Return some cases of the study, evenly spaced, for a model."""
    study = bearingsim.load_study(FIG16)
    cases = study.cases()
    numbers = np.linspace(0, len(cases) - 1, CASES_PER_MODEL).round().astype(int).tolist()
    converted = (cases[n] if cases[n].model == model else candidate_case(study, n, model) for n in numbers)
    return [case_ for case_ in converted if case_ is not None]


def measure_phases(report: Section) -> None:
    """Report the CPU time of the phases of jobs of fig. 16."""
    cases = {model: fig16_cases(model) for model in MODELS}
    least = {model: np.full((CASES_PER_MODEL, len(PHASES)), np.inf) for model in MODELS}

    def measure_model(model: str) -> float:
        times = np.array([list(phases_of(case_).values()) for case_ in cases[model]])
        is_faster = times.sum(axis=1) < least[model].sum(axis=1)
        least[model][is_faster] = times[is_faster]
        return float(times.sum()) / CASES_PER_MODEL

    report.measures |= measure_in_turns(
        {f"job/{model}": partial(measure_model, model) for model in MODELS}, ROUNDS
    )
    rows = []
    for model, means in least.items():
        mean = means.mean(axis=0)
        rows.append([model, *(1e3 * mean), 1e3 * float(mean.sum())])
        outside = 1e3 * float(mean[2:].sum())
        name = f"{model}: ms of a job of fig. 16 outside its steps"
        report.targets.append(Target(name, outside, at_most=1e3 * OUTSIDE_STEPS))
    report.add_table("CPU ms of a job of fig. 16 (1 s)", ["model", *PHASES, "all"], rows)


def growth_in_time(report: Section) -> None:
    """Report the growth of the cost of a job with its duration, computed in full."""
    cases = [case("rollers", duration=duration, periodic=False, record=[]) for duration in DURATIONS]
    measures = measure_in_turns(
        {f"job/in full, {entry.duration:g} s": partial(cpu_time, simulate, entry) for entry in cases}, 2
    )
    report.measures |= measures
    report.add_growth(
        "a job computed in full", "seconds", DURATIONS, [entry.seconds for entry in measures.values()]
    )


def long_record(report: Section) -> None:
    """Report the cost of a long periodic record, relative to one of 1 s."""
    cases = [case("rollers", duration=duration, record=[]) for duration in (1.0, LONG)]
    tasks = {f"job/repeats, {entry.duration:g} s": partial(cpu_time, simulate, entry) for entry in cases}
    measures = measure_in_turns(tasks, SHORT_ROUNDS)
    report.measures |= measures
    short, long = (entry.seconds for entry in measures.values())
    peaks = [peak_memory(duration) for duration in (1.0, LONG)]
    columns = ["record, s", "CPU s", "peak memory, MB"]
    rows = [[1.0, short, peaks[0] / 1e6], [LONG, long, peaks[1] / 1e6]]
    report.add_table("`rollers`, a motion that repeats itself, `record: []`", columns, rows)
    report.targets.append(Target(f"CPU time of {LONG:g} s that repeat over that of 1 s", long / short, LONG_CPU))
    growth = (peaks[1] - peaks[0]) / 1e6
    name = f"peak memory of {LONG:g} s that repeat beyond that of 1 s, MB"
    report.targets.append(Target(name, growth, at_most=LONG_MEMORY / 1e6))


def peak_memory(duration: float) -> float:
    """Return the peak memory (B) of a process that computes a record of a duration."""
    process = subprocess.run(
        [sys.executable, "-c", PEAK, str(duration)], check=True, capture_output=True, text=True
    )
    return 1024.0 * float(process.stdout)


# Many jobs


def run_study(model: str, duration: str, jobs: int, workers: int) -> int:
    """Compute a new study; return its number of jobs, including healthy baselines."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(STUDY.format(model=model, duration=duration, jobs=jobs))
        study = bearingsim.load_study(path)
        results = bearingsim.run(study, Path(folder) / "results", jobs=workers, progress=False)
        if len(results.failures()):
            raise RuntimeError(f"{len(results.failures())} jobs failed")
        return len(study.jobs())


def many_jobs(report: Section) -> None:
    """Report the growth of the cost of a study with its jobs, in this process; the minimum per size counts."""
    run_study("ring", SHORT, 20, workers=1)
    least: dict[int, Measure] = {}
    for jobs in JOB_COUNTS:
        before, began = yardstick(), time.process_time()
        size = run_study("ring", SHORT, jobs, workers=1)
        cpu_s = time.process_time() - began
        if size not in least or cpu_s < least[size].seconds:
            least[size] = Measure(cpu_s, min(before, yardstick()), SINGLE_NOISE, JOB_COUNTS.count(jobs))
    report.measures |= {f"study/{size} jobs of ring, {SHORT}": measure for size, measure in least.items()}
    sizes = sorted(least)
    report.add_growth(
        f"a study of `ring`, {SHORT} each, baselines counted,", "jobs", sizes, [least[n].seconds for n in sizes]
    )
    per_job = 1e3 * least[sizes[-1]].seconds / sizes[-1]
    report.targets.append(
        Target(f"ms of each of {sizes[-1]} jobs of `ring`, {SHORT}", per_job, at_most=1e3 * SHORT_JOB)
    )


def two_workers(report: Section) -> None:
    """Report the wall time with one worker relative to two, and the load by other processes meanwhile."""
    walls, loads = [], []
    for workers in (1, 2):
        wall, load = wall_time(partial(run_study, "rollers", "1 s", SHARED_JOBS, workers))
        walls.append(wall)
        loads.append(load)
    rows = [[1, walls[0], loads[0]], [2, walls[1], loads[1]]]
    columns = ["workers", "wall s", "processors that others kept busy"]
    report.add_table(f"{SHARED_JOBS} jobs of `rollers`, 1 s each, and their baselines", columns, rows)
    max_load = max(loads)
    doubt = "" if max_load < 0.1 else f"others kept {max_load:.1f} processors busy, so it says nothing"
    name = f"wall time of {SHARED_JOBS} jobs by one worker over that by two"
    report.targets.append(Target(name, walls[0] / walls[1], at_least=TWO_WORKERS, doubt=doubt))


def wall_time(work: Callable) -> tuple[float, float]:
    """Return wall time (s), and the mean number of CPUs used by other processes (nan if unknown)."""
    other_time, began = machine_time() - own_time(), time.perf_counter()
    work()
    wall = time.perf_counter() - began
    return wall, max(0.0, machine_time() - own_time() - other_time) / wall


def machine_time() -> float:
    """Return the CPU time (s) of all processes since the machine started; nan if not reported."""
    if not Path("/proc/stat").exists():
        return nan
    counts = Path("/proc/stat").read_text().splitlines()[0].split()[1:]
    user, nice, system, _idle, _wait, irq, softirq = map(int, counts[:7])
    return (user + nice + system + irq + softirq) / os.sysconf("SC_CLK_TCK")


def own_time() -> float:
    """Return the CPU time (s) of this process and its children, ended or not."""
    fields: dict[int, list[int]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended
            fields[int(path.parent.name)] = [int(n) for n in path.read_text().rpartition(")")[2].split()[1:15]]
    pids = {os.getpid()}
    while children := {process for process, (parent, *_) in fields.items() if parent in pids} - pids:
        pids |= children
    ticks = sum(
        sum(fields[process][10:14]) for process in pids if process in fields
    )  # including children that have ended
    return ticks / os.sysconf("SC_CLK_TCK")
