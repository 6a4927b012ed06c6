"""Measurement of the prices from which the cost of a case is estimated; written as a proposal only.

Prices are committed, so that `auto` makes the same choices on every machine
(``bearingsim/simulation/pricing.py``). The proposal is written beside the report; prices that cannot be measured
keep their values. It is copied by hand, and changes of the choices of `auto` are listed in the changelog.
"""

import csv
import time
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.contacts import count_powers
from bearingsim.catalogue import METHODS
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION, NoSamples, advance_and_sample, prepare_first_step
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import prepare
from bearingsim.core.models.interface import accelerations
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.pricing import COEFFICIENT_FILE
from bearingsim.simulation.run_setup import make_monitor
from benchmarks.speed.report import Prices, Section
from benchmarks.speed.scenes import case
from benchmarks.speed.study import SHORT, phases_of, run_study
from benchmarks.speed.timing import Task, cpu_time, measure_in_turns

MODELS = {
    "static": 100,
    "ring": 20_000,
    "rollers": 20_000,
    "planar": 10_000,
    "spatial": 1000,
}  # evaluations per turn
METHOD_NAMES = ("verlet", "dormand-prince", "dop853", "rodas", "backward-euler")
DURATION, INSTANTS = 0.02, (100, 1600)  # s, recorded of an adaptive method
GENERAL_DAMPING = {"law": "general", "coefficient": 100.0}
ROUNDS, JOBS = 9, 60
ROWS = np.array([*RING_MOTION, lay.Q_O, lay.Q_I])


@jit
def repeat_evaluations(model, t, y, count):
    """Compute the accelerations ``count`` times."""
    for _ in range(count):
        accelerations(model, t, y)


class Evaluations:
    """Repeated evaluation of a model in equilibrium."""

    def __init__(self, model: str, **fields: Any) -> None:
        model_case = case(model, **fields)
        self.model, self.count = assemble.model(model_case), MODELS[model]
        self.y, _ = assemble.start(model_case, self.model)

    def __call__(self) -> float:
        """Return the CPU time (s) of an evaluation, per slice if the model has slices."""
        cpu_s = cpu_time(repeat_evaluations, self.model, 0.0, self.y, self.count) / self.count
        return cpu_s / (assemble.slice_count(self.model) or 1)


class Steps:
    """Integration of a model by a method as in a run, with monitor and recording."""

    def __init__(self, method: str, model: str = "rollers", instants: int = INSTANTS[0], **fields: Any) -> None:
        model_case = case(model, method=method if model != "static" else None, **fields)
        grid = time_grid.make_grid(model_case)
        self.adaptive = assemble.is_adaptive(model_case)
        h = DURATION / instants if self.adaptive else grid.step
        self.count = instants if self.adaptive else max(1, round(DURATION / h))
        self.model, self.method = assemble.model(model_case), assemble.method(model_case, h)
        self.monitor = make_monitor(grid, choice.limits(model_case))._replace(max_evaluations=np.inf)
        self.y, _ = assemble.start(model_case, self.model)
        self.steps_taken = float(self.count)

    def __call__(self) -> float:
        """Return the CPU time (s) of the run."""
        y, out = self.y.copy(), np.empty((len(ROWS), self.count))
        if type(self.method) in prepare.types:
            prepare_first_step(self.method, self.model, 0.0, y)
        outcomes: list[tuple] = []
        arguments = self.method, self.model, self.monitor, 0, y, ROWS, out, NoSamples()
        cpu_s = cpu_time(lambda: outcomes.append(advance_and_sample(*arguments)))
        if outcomes[0][1] != SUCCESS:
            raise RuntimeError(f"{type(self.method).__name__} was stopped")
        if self.adaptive:
            self.steps_taken = float(y[lay.STEPS_TAKEN])
        return cpu_s


def section(report: Section) -> None:
    """Measure all prices that can be measured on this machine."""
    evaluations = {name: Evaluations(name) for name in MODELS if name != "static"}
    static, verlet = Steps("", "static"), Steps("verlet")
    plain, powered = (general_damping(m3) for m3 in (1.0, 1.5))
    adaptive = {
        name: [Steps(name, instants=n) for n in INSTANTS] for name in METHOD_NAMES if METHODS[name].adaptive
    }
    tasks: dict[str, Task] = {f"evaluation/{name}": task for name, task in evaluations.items()}
    tasks |= {"run/static": static, "run/verlet": verlet, "power/without": plain[0], "power/with": powered[0]}
    tasks["run/rodas planar"] = planar = Steps("rodas", "planar", cage={"motion": "kinematic"})
    tasks |= {
        f"run/{name}, {n}": task for name, pair in adaptive.items() for n, task in zip(INSTANTS, pair, strict=True)
    }
    measures = measure_in_turns(tasks, ROUNDS)
    report.measures |= measures
    seconds = {name: task.seconds for name, task in measures.items()}

    new: Prices = {("evaluation", name): seconds[f"evaluation/{name}"] for name in evaluations}
    new["evaluation", ""] = new["evaluation", "planar"]
    new["evaluation", "static"] = seconds["run/static"] / static.count
    unit = new["evaluation", "rollers"]
    new["step", "verlet"] = seconds["run/verlet"] / verlet.count / unit
    new["power", ""] = (seconds["power/with"] - seconds["power/without"]) / (powered[1] - plain[1])
    records = []
    for name, (short, long) in adaptive.items():
        short_s, long_s = (seconds[f"run/{name}, {n}"] for n in INSTANTS)
        records.append((long_s - short_s) / (long.count - short.count) / unit)
        new["step", name] = (short_s - records[-1] * short.count * unit) / short.steps_taken / unit
    new["record", ""] = float(np.median(records))
    recorded = new["record", ""] * new["evaluation", "planar"] * planar.count
    new["step", "rodas planar"] = (seconds["run/rodas planar"] - recorded) / planar.steps_taken
    new["step", "rodas planar"] /= new["evaluation", "planar"]
    new["job", ""] = job_overhead()
    report.prices |= new


def general_damping(m3: float) -> tuple[Task, int]:
    """Return a task that evaluates `rollers` with the damping exponent m3, and its number of power functions."""
    law = {"contact": {"damping": GENERAL_DAMPING | {"indentation_exponent": m3}}}
    return Evaluations("rollers", **law), count_powers(case("rollers", **law))


def job_overhead() -> float:
    """Return the CPU time (s) of a short job of a study outside its steps."""
    began = time.process_time()
    jobs = run_study("ring", SHORT, JOBS, workers=1)
    total = (time.process_time() - began) / jobs
    phases = phases_of(case("ring", duration=SHORT))
    return total - phases["steps"] - phases["proof"]


def proposal(new: Prices) -> list[dict[str, str]]:
    """Return the committed table with new values and their ratios to the old ones; others are unchanged.

    Values without a row are added at the end, for a maintainer to decide.
    """
    with COEFFICIENT_FILE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    unused = dict(new)
    for row in rows:
        value = unused.pop((row["what"], row["name"]), None)
        row["new/old"] = "not measured" if value is None else f"{value / float(row['value']):.2f}"
        if value is not None:
            row["value"] = f"{value:.2g}"
    for (what, name), value in unused.items():
        unit = next((row["unit"] for row in rows if row["what"] == what), "")
        rows.append(dict(zip(rows[0], (what, name, f"{value:.2g}", unit, "make bench", "new row"), strict=True)))
    return rows
