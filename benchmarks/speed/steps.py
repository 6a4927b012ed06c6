"""Cost of a step relative to its contact forces, and its growth with rollers and slices.

The lower bound is the contact law of the model in a plain loop, with as many calls of ``normal_force`` as an
evaluation. A Verlet step is timed without monitor and recording.
"""

from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.methods.interface import step
from bearingsim.core.models.planar import Planar
from bearingsim.core.models.ring import Ring
from bearingsim.core.models.rollers import Rollers
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.parameters import lanes
from bearingsim.simulation import time_grid
from benchmarks.speed.report import Section, Target
from benchmarks.speed.scenes import DAMPING, case
from benchmarks.speed.timing import Task, cpu_time, measure_in_turns

MAX_RATIOS = {"ring": 3.0, "rollers": 1.6, "planar": 6.0, "spatial": 5.0}
"""Largest cost of a step relative to its contact forces, by model."""
COUNTS = {
    "ring": 20_000,
    "rollers": 20_000,
    "planar": 10_000,
    "spatial": 1000,
}  # steps, or times all forces, a turn
ROLLERS, SLICES = (8, 16, 32, 64), (6, 12, 24, 48)
ROUNDS = 150  # of some milliseconds, because disturbances last for about a second


@generic
def contact_forces(model: Any, y: np.ndarray) -> None:
    """Call ``normal_force`` for all contacts of an evaluation, with the approaches in the buffer."""


@contact_forces.register(Ring)
def _forces_of_ring(model, y):
    for j in range(lanes(model.bearing)):
        y[lay.Q_O + j] = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])


def _forces_of_rollers(model, y):
    for j in range(lanes(model.bearing)):
        y[lay.Q_O + j] = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
        y[lay.Q_I + j] = normal_force(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])


contact_forces.register(Rollers)(_forces_of_rollers)
contact_forces.register(Planar)(_forces_of_rollers)


@contact_forces.register(Spatial)
def _forces_of_slices(model, y):
    for k in range(len(model.slices.table)):
        outer, inner = lay.slice_row(k, lay.APPROACH_O), lay.slice_row(k, lay.APPROACH_I)
        on_outer, on_inner = lay.slice_row(k, lay.LOAD_O), lay.slice_row(k, lay.LOAD_I)
        for j in range(lanes(model.bearing)):
            y[on_outer + j] = normal_force(model.outer, y[outer + j], y[lay.V_O + j])
            y[on_inner + j] = normal_force(model.inner, y[inner + j], y[lay.V_I + j])


@jit
def repeat_forces(model, y, count):
    """Compute the contact forces ``count`` times."""
    for _ in range(count):
        contact_forces(model, y)


@jit
def repeat_steps(method, model, y, start, count):
    """Make ``count`` steps from number ``start``."""
    for n in range(start, start + count):
        step(method, model, n * method.h, y)


class SteppedBearing:
    """Bearing whose motion is continued in every turn."""

    def __init__(self, model: str, rollers: int | None = None, **fields: Any) -> None:
        model_case = case(model, method="verlet", **fields)
        h = time_grid.make_grid(model_case).step
        self.model = assemble.with_friction_lag(assemble.model(model_case), h)
        if rollers is not None:  # for the arithmetic only: they would not all fit
            self.model = self.model._replace(bearing=self.model.bearing._replace(Z=rollers))
        self.y, _ = assemble.start(model_case, self.model)
        self.method, self.steps_taken, self.count = assemble.method(model_case, h), 0, COUNTS[model]

    def steps(self) -> float:
        """Return the CPU time (s) of a step."""
        start, self.steps_taken = self.steps_taken, self.steps_taken + self.count
        cpu_s = cpu_time(repeat_steps, self.method, self.model, self.y, start, self.count)
        if not np.isfinite(self.y[: lay.STATE]).all():
            raise RuntimeError("the motion is no longer finite")
        return cpu_s / self.count

    def forces(self) -> float:
        """Return the CPU time (s) of all contact forces of a step."""
        return cpu_time(repeat_forces, self.model, self.y, self.count) / self.count

    @property
    def contacts(self) -> int:
        """Number of contact forces of an evaluation."""
        return (
            self.model.bearing.Z
            * (1 if isinstance(self.model, Ring) else 2)
            * (assemble.slice_count(self.model) or 1)
        )


def section(report: Section) -> None:
    """Time all models, and other numbers of rollers and slices, in one group: disturbances last for seconds."""
    bearings = {name: SteppedBearing(name) for name in MAX_RATIOS}
    by_rollers = {Z: SteppedBearing("rollers", rollers=Z, clearance="-1 um", defects=[]) for Z in ROLLERS}
    slice_bearings = [SteppedBearing("spatial", contact={"slices": n, "damping": DAMPING}) for n in SLICES]
    by_slices = {assemble.slice_count(bearing.model): bearing for bearing in slice_bearings}
    tasks: dict[str, Task] = {}
    for name, bearing in bearings.items():
        tasks |= {f"step/{name}": bearing.steps, f"forces/{name}": bearing.forces}
    tasks |= {f"step/{Z} rollers": bearing.steps for Z, bearing in by_rollers.items()}
    tasks |= {f"step/{n} slices": bearing.steps for n, bearing in by_slices.items()}
    report.measures |= measure_in_turns(tasks, ROUNDS)
    compare_with_forces(report, bearings)
    for quantity, sizes in (("rollers", list(by_rollers)), ("slices", list(by_slices))):
        report.add_growth(
            "a step", quantity, sizes, [report.measures[f"step/{n} {quantity}"].seconds for n in sizes]
        )


def compare_with_forces(report: Section, bearings: dict[str, SteppedBearing]) -> None:
    """Report each model's step relative to its contact forces."""
    rows = []
    for name, bearing in bearings.items():
        step_s, forces_s = (report.measures[f"{quantity}/{name}"].seconds for quantity in ("step", "forces"))
        ratio = step_s / forces_s
        rows.append(
            [name, bearing.contacts, 1e9 * step_s, 1e9 * forces_s, 1e9 * forces_s / bearing.contacts, ratio]
        )
        report.targets.append(
            Target(f"{name}: a Verlet step over its contact forces", ratio, at_most=MAX_RATIOS[name])
        )
    columns = ["model", "contacts", "step, ns", "forces, ns", "ns a contact", "step/forces"]
    report.add_table("A Verlet step", columns, rows)
