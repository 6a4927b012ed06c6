"""The prices by which the program estimates what a case costs, measured anew: a proposal, never put in place.

Prices are committed, so that `auto` chooses alike on every machine (``bearingsim/simulation/pricing.py``). What
this section finds is written beside the report; what it cannot measure keeps its old number. Whoever takes a
proposal over copies it by hand, and tells in the change log what `auto` chooses otherwise.
"""

import csv
import time
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.contacts import count_powers
from bearingsim.catalogue import METHODS
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION, advance, prepare_first_step
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import prepare
from bearingsim.core.models.interface import accelerations
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.pricing import TABLE
from bearingsim.simulation.run_setup import monitor_of
from benchmarks.speed.report import Prices, Section
from benchmarks.speed.scenes import case
from benchmarks.speed.study import SHORT, computed, phases_of
from benchmarks.speed.timing import Task, clocked, measured

MODELS = {
    "static": 100,
    "ring": 20_000,
    "rollers": 20_000,
    "planar": 10_000,
    "spatial": 1000,
}  # evaluations a turn
STEPPED = ("verlet", "dormand-prince", "dop853", "rodas", "backward-euler")
DURATION, INSTANTS = 0.02, (100, 1600)  # s, recorded of an adaptive method
POWERED = {"law": "general", "coefficient": 100.0}
ROUNDS, JOBS = 9, 60
PLACES = np.array([*RING_MOTION, lay.Q_O, lay.Q_I])


@jit
def repeat_evaluations(model, t, y, times):
    """The accelerations, so many times."""
    for _ in range(times):
        accelerations(model, t, y)


class Evaluations:
    """A model at rest, evaluated again and again."""

    def __init__(self, model: str, **fields: Any) -> None:
        given = case(model, **fields)
        self.model, self.times = assemble.model(given), MODELS[model]
        self.y, _ = assemble.start(given, self.model)

    def __call__(self) -> float:
        """CPU time (s) of one; of a slice, where there are any."""
        took = clocked(repeat_evaluations, self.model, 0.0, self.y, self.times) / self.times
        return took / (assemble.slices_of(self.model) or 1)


class Steps:
    """``rollers`` stepped by a method as a run does it: monitored and recorded."""

    def __init__(self, method: str, model: str = "rollers", instants: int = INSTANTS[0], **fields: Any) -> None:
        given = case(model, method=method if model != "static" else None, **fields)
        cut = time_grid.grid(given)
        self.adaptive = assemble.is_adaptive(given)
        h = DURATION / instants if self.adaptive else cut.step
        self.count = instants if self.adaptive else max(1, round(DURATION / h))
        self.model, self.method = assemble.model(given), assemble.method(given, h)
        self.monitor = monitor_of(cut, choice.limits(given))._replace(max_evaluations=np.inf)
        self.y, _ = assemble.start(given, self.model)
        self.own_steps = float(self.count)

    def __call__(self) -> float:
        """CPU time (s) of the run."""
        y, out = self.y.copy(), np.empty((len(PLACES), self.count))
        if type(self.method) in prepare.types:
            prepare_first_step(self.method, self.model, 0.0, y)
        ended: list[tuple] = []
        took = clocked(lambda: ended.append(advance(self.method, self.model, self.monitor, 0, y, PLACES, out)))
        if ended[0][1] != SUCCESS:
            raise RuntimeError(f"{type(self.method).__name__} was stopped")
        if self.adaptive:
            self.own_steps = float(y[lay.STEPS_TAKEN])
        return took


def section(found: Section) -> None:
    """Measure what has a row and can be measured here."""
    evaluated = {name: Evaluations(name) for name in MODELS if name != "static"}
    balance, verlet = Steps("", "static"), Steps("verlet")
    plain, powered = (general_damping(m3) for m3 in (1.0, 1.5))
    adaptive = {name: [Steps(name, instants=n) for n in INSTANTS] for name in STEPPED if METHODS[name].adaptive}
    tasks: dict[str, Task] = {f"evaluation/{name}": one for name, one in evaluated.items()}
    tasks |= {"run/static": balance, "run/verlet": verlet, "power/without": plain[0], "power/with": powered[0]}
    tasks["run/rodas planar"] = in_planar = Steps("rodas", "planar", cage={"motion": "kinematic"})
    tasks |= {
        f"run/{name}, {n}": one for name, both in adaptive.items() for n, one in zip(INSTANTS, both, strict=True)
    }
    took = measured(tasks, ROUNDS)
    found.measures |= took
    seconds = {name: one.seconds for name, one in took.items()}

    new: Prices = {("evaluation", name): seconds[f"evaluation/{name}"] for name in evaluated}
    new["evaluation", ""] = new["evaluation", "planar"]
    new["evaluation", "static"] = seconds["run/static"] / balance.count
    one = new["evaluation", "rollers"]
    new["step", "verlet"] = seconds["run/verlet"] / verlet.count / one
    new["power", ""] = (seconds["power/with"] - seconds["power/without"]) / (powered[1] - plain[1])
    records = []
    for name, (few, many) in adaptive.items():
        less, more = (seconds[f"run/{name}, {n}"] for n in INSTANTS)
        records.append((more - less) / (many.count - few.count) / one)
        new["step", name] = (less - records[-1] * few.count * one) / few.own_steps / one
    new["record", ""] = float(np.median(records))
    recorded = new["record", ""] * new["evaluation", "planar"] * in_planar.count
    new["step", "rodas planar"] = (seconds["run/rodas planar"] - recorded) / in_planar.own_steps
    new["step", "rodas planar"] /= new["evaluation", "planar"]
    new["job", ""] = job_overhead()
    found.prices |= new


def general_damping(m3: float) -> tuple[Task, int]:
    """`rollers` with a power m3 in its damping: the CPU time of an evaluation, and the library's powers in it."""
    law = {"contact": {"damping": POWERED | {"indentation_exponent": m3}}}
    return Evaluations("rollers", **law), count_powers(case("rollers", **law))


def job_overhead() -> float:
    """CPU time (s) of a short job of a study outside its steps."""
    began = time.process_time()
    jobs = computed("ring", SHORT, JOBS, workers=1)
    whole = (time.process_time() - began) / jobs
    spent = phases_of(case("ring", duration=SHORT))
    return whole - spent["steps"] - spent["proof"]


def proposal(new: Prices) -> list[dict[str, str]]:
    """The committed table with new numbers, each over the old one; what was not measured stays as it was.

    What has no row yet comes last: whether it gets one is for a person to decide.
    """
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    left = dict(new)
    for row in rows:
        value = left.pop((row["what"], row["name"]), None)
        row["new/old"] = "not measured" if value is None else f"{value / float(row['value']):.2f}"
        if value is not None:
            row["value"] = f"{value:.2g}"
    for (what, name), value in left.items():
        unit = next((row["unit"] for row in rows if row["what"] == what), "")
        rows.append(dict(zip(rows[0], (what, name, f"{value:.2g}", unit, "make bench", "new row"), strict=True)))
    return rows


def write(rows: list[dict[str, str]], path: Path) -> None:
    """Write a proposal as CSV."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
