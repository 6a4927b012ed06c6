"""What jobs and studies cost: where the CPU time of a job goes, many short jobs, two workers, a long record."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from math import nan
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import bearingsim
from bearingsim.config import Case
from bearingsim.selection.candidates import computed_by
from bearingsim.simulation import simulate, step_check
from benchmarks.speed.report import Section, Target
from benchmarks.speed.scenes import case
from benchmarks.speed.timing import Measure, clocked, measured, yardstick

FIG16 = Path("studies/fig16_angle.yaml")
MODELS, EACH = ("static", "ring", "rollers", "planar"), 8  # by which so many cases of fig. 16 are computed
PHASES = ("steps", "proof", "features", "rest")
OUTSIDE_STEPS = 8e-3  # s of CPU time a job may take outside its steps
SHORT, MANY, SHORT_JOB = "10 ms", (125, 1000, 400, 125), 15e-3  # record, jobs of a study, CPU s of each at most
SHARED, TWO_WORKERS = 200, 1.9  # jobs, and by how much two workers are to be faster
DURATIONS = (0.5, 1.0, 2.0, 4.0)  # s, computed in full
LONG, LONG_CPU, LONG_MEMORY = 60.0, 1.5, 60e6  # s; over the CPU time and the peak memory (B) of 1 s
ROUNDS, SHORT_ROUNDS, ONCE = 6, 40, 0.1  # of jobs; of those of 0.05 s; noise of what is timed once
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


def section(found: Section) -> None:
    """All of it."""
    phases(found)
    growth_in_time(found)
    long_record(found)
    many_jobs(found)
    two_workers(found)


# One job


@contextmanager
def stopwatch(module: Any, name: str, spent: dict[str, float]) -> Iterator[None]:
    """Add up in ``spent[name]`` the CPU time (s) of all calls of a module's function."""
    function = getattr(module, name)

    def timed(*given: Any, **named: Any) -> Any:
        began = time.thread_time()
        try:
            return function(*given, **named)
        finally:
            spent[name] += time.thread_time() - began

    with mock.patch.object(module, name, timed):
        yield


def phases_of(one: Case) -> dict[str, float]:
    """CPU time (s) of a job by what it went into."""
    spent = {"check_step": 0.0, "features": 0.0}
    code = import_module("bearingsim.simulation.simulate")  # of the package it is a function
    with stopwatch(step_check, "check_step", spent), stopwatch(code, "features", spent):
        began = time.thread_time()
        record = simulate(one)
        total = time.thread_time() - began
    steps = float(record.info["integrator_cpu_s"])
    rest = total - steps - sum(spent.values())
    return dict(zip(PHASES, (steps, spent["check_step"], spent["features"], rest), strict=True))


def fig16(model: str) -> list[Case]:
    """Return some of the study's cases, evenly spread, as a model computes them."""
    study = bearingsim.load_study(FIG16)
    cases = study.cases()
    numbers = np.linspace(0, len(cases) - 1, EACH).round().astype(int).tolist()
    others = (cases[n] if cases[n].model == model else computed_by(study, n, model) for n in numbers)
    return [one for one in others if one is not None]


def phases(found: Section) -> None:
    """Where the CPU time of jobs of fig. 16 goes."""
    cases = {model: fig16(model) for model in MODELS}
    least = {model: np.full((EACH, len(PHASES)), np.inf) for model in MODELS}

    def turn(model: str) -> float:
        now = np.array([list(phases_of(one).values()) for one in cases[model]])
        better = now.sum(axis=1) < least[model].sum(axis=1)
        least[model][better] = now[better]
        return float(now.sum()) / EACH

    found.measures |= measured({f"job/{model}": partial(turn, model) for model in MODELS}, ROUNDS)
    rows = []
    for model, times in least.items():
        mean = times.mean(axis=0)
        rows.append([model, *(1e3 * mean), 1e3 * float(mean.sum())])
        outside = 1e3 * float(mean[2:].sum())
        name = f"{model}: ms of a job of fig. 16 outside its steps"
        found.targets.append(Target(name, outside, at_most=1e3 * OUTSIDE_STEPS))
    found.table("CPU ms of a job of fig. 16 (1 s)", ["model", *PHASES, "all"], rows)


def growth_in_time(found: Section) -> None:
    """How a job grows with its record, computed in full."""
    cases = [case("rollers", duration=duration, periodic=False, record=[]) for duration in DURATIONS]
    took = measured({f"job/in full, {one.duration:g} s": partial(clocked, simulate, one) for one in cases}, 2)
    found.measures |= took
    found.grows("a job computed in full", "seconds", DURATIONS, [one.seconds for one in took.values()])


def long_record(found: Section) -> None:
    """A motion that repeats itself: a long record against one of 1 s."""
    cases = [case("rollers", duration=duration, record=[]) for duration in (1.0, LONG)]
    tasks = {f"job/repeats, {one.duration:g} s": partial(clocked, simulate, one) for one in cases}
    took = measured(tasks, SHORT_ROUNDS)
    found.measures |= took
    short, long = (one.seconds for one in took.values())
    peaks = [peak_memory(duration) for duration in (1.0, LONG)]
    head = ["record, s", "CPU s", "peak memory, MB"]
    rows = [[1.0, short, peaks[0] / 1e6], [LONG, long, peaks[1] / 1e6]]
    found.table("`rollers`, a motion that repeats itself, `record: []`", head, rows)
    found.targets.append(Target(f"CPU time of {LONG:g} s that repeat over that of 1 s", long / short, LONG_CPU))
    more = (peaks[1] - peaks[0]) / 1e6
    name = f"peak memory of {LONG:g} s that repeat beyond that of 1 s, MB"
    found.targets.append(Target(name, more, at_most=LONG_MEMORY / 1e6))


def peak_memory(duration: float) -> float:
    """The most memory (B) that a process has held which computes so long a record."""
    done = subprocess.run([sys.executable, "-c", PEAK, str(duration)], check=True, capture_output=True, text=True)
    return 1024.0 * float(done.stdout)


# Many jobs


def computed(model: str, duration: str, jobs: int, workers: int) -> int:
    """Compute a study anew; how many jobs it had, twins included."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "study.yaml"
        written.write_text(STUDY.format(model=model, duration=duration, jobs=jobs))
        study = bearingsim.load_study(written)
        results = bearingsim.run(study, Path(folder) / "results", jobs=workers, progress=False)
        if len(results.failures()):
            raise RuntimeError(f"{len(results.failures())} jobs failed")
        return len(study.jobs())


def many_jobs(found: Section) -> None:
    """How a study grows with its jobs, all in this process; each size's least counts."""
    computed("ring", SHORT, 20, workers=1)
    least: dict[int, Measure] = {}
    for jobs in MANY:
        before, began = yardstick(), time.process_time()
        size = computed("ring", SHORT, jobs, workers=1)
        took = time.process_time() - began
        if size not in least or took < least[size].seconds:
            least[size] = Measure(took, min(before, yardstick()), ONCE, MANY.count(jobs))
    found.measures |= {f"study/{size} jobs of ring, {SHORT}": one for size, one in least.items()}
    sizes = sorted(least)
    found.grows(
        f"a study of `ring`, {SHORT} each, twins counted,", "jobs", sizes, [least[n].seconds for n in sizes]
    )
    each = 1e3 * least[sizes[-1]].seconds / sizes[-1]
    found.targets.append(
        Target(f"ms of each of {sizes[-1]} jobs of `ring`, {SHORT}", each, at_most=1e3 * SHORT_JOB)
    )


def two_workers(found: Section) -> None:
    """Wall time of one worker over that of two, and what the rest of the machine did meanwhile."""
    walls, others = [], []
    for workers in (1, 2):
        wall, foreign = wall_time(partial(computed, "rollers", "1 s", SHARED, workers))
        walls.append(wall)
        others.append(foreign)
    rows = [[1, walls[0], others[0]], [2, walls[1], others[1]]]
    head = ["workers", "wall s", "processors that others kept busy"]
    found.table(f"{SHARED} jobs of `rollers`, 1 s each, and their twins", head, rows)
    busy = max(others)
    doubt = "" if busy < 0.1 else f"others kept {busy:.1f} processors busy, so it says nothing"
    name = f"wall time of {SHARED} jobs by one worker over that by two"
    found.targets.append(Target(name, walls[0] / walls[1], at_least=TWO_WORKERS, doubt=doubt))


def wall_time(work: Callable) -> tuple[float, float]:
    """Wall time (s) of some work, and how many processors others kept busy meanwhile (nan: not to be known)."""
    others, began = machine_time() - own_time(), time.perf_counter()
    work()
    wall = time.perf_counter() - began
    return wall, max(0.0, machine_time() - own_time() - others) / wall


def machine_time() -> float:
    """CPU time (s) of all that has run on this machine since it began; nan where it is not told."""
    if not Path("/proc/stat").exists():
        return nan
    counts = Path("/proc/stat").read_text().splitlines()[0].split()[1:]
    user, nice, system, _idle, _wait, irq, softirq = map(int, counts[:7])
    return (user + nice + system + irq + softirq) / os.sysconf("SC_CLK_TCK")


def own_time() -> float:
    """CPU time (s) of this process and all that it has started, whether they have ended or wait for more work."""
    fields: dict[int, list[int]] = {}
    for told in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has just ended
            fields[int(told.parent.name)] = [int(n) for n in told.read_text().rpartition(")")[2].split()[1:15]]
    ours = {os.getpid()}
    while more := {process for process, (parent, *_) in fields.items() if parent in ours} - ours:
        ours |= more
    ticks = sum(sum(fields[process][10:14]) for process in ours if process in fields)  # with those that have ended
    return ticks / os.sysconf("SC_CLK_TCK")
