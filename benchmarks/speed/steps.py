"""A step against its contact forces, and how it grows with rollers and slices.

The ceiling is the model's contact law in a bare loop: as many calls of ``normal_force`` as one evaluation makes,
and nothing else. A Verlet step is timed bare, too: no monitor, no recording.
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
from benchmarks.speed.timing import Task, clocked, measured

MOST = {"ring": 3.0, "rollers": 1.6, "planar": 6.0, "spatial": 5.0}
"""Models, and what a step of each may cost, over its contact forces."""
LONG = {"ring": 20_000, "rollers": 20_000, "planar": 10_000, "spatial": 1000}  # steps, or times all forces, a turn
ROLLERS, SLICES = (8, 16, 32, 64), (6, 12, 24, 48)
ROUNDS = 150  # of some milliseconds: neighbours come and go within a second


@generic
def contact_forces(model: Any, y: np.ndarray) -> None:
    """Every call of ``normal_force`` of one evaluation, over the approaches that the buffer holds."""


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
def repeat_forces(model, y, times):
    """The contact forces, so many times."""
    for _ in range(times):
        contact_forces(model, y)


@jit
def repeat_steps(method, model, y, start, times):
    """Steps from number ``start`` on."""
    for n in range(start, start + times):
        step(method, model, n * method.h, y)


class Bare:
    """A bearing that goes on, step by step, with every turn."""

    def __init__(self, model: str, rollers: int | None = None, **fields: Any) -> None:
        given = case(model, method="verlet", **fields)
        h = time_grid.grid(given).step
        self.model = assemble.with_friction_lag(assemble.model(given), h)
        if rollers is not None:  # only the arithmetic matters: they would not all fit
            self.model = self.model._replace(bearing=self.model.bearing._replace(Z=rollers))
        self.y, _ = assemble.start(given, self.model)
        self.method, self.taken, self.times = assemble.method(given, h), 0, LONG[model]

    def steps(self) -> float:
        """CPU time (s) of a step."""
        start, self.taken = self.taken, self.taken + self.times
        took = clocked(repeat_steps, self.method, self.model, self.y, start, self.times)
        if not np.isfinite(self.y[: lay.STATE]).all():
            raise RuntimeError("the motion is no longer finite")
        return took / self.times

    def forces(self) -> float:
        """CPU time (s) of all contact forces of a step."""
        return clocked(repeat_forces, self.model, self.y, self.times) / self.times

    @property
    def contacts(self) -> int:
        """Contacts whose force an evaluation asks for."""
        return (
            self.model.bearing.Z
            * (1 if isinstance(self.model, Ring) else 2)
            * (assemble.slices_of(self.model) or 1)
        )


def section(found: Section) -> None:
    """Time all models, and other numbers of rollers and slices, in one group: a neighbour stays for seconds."""
    bare = {name: Bare(name) for name in MOST}
    numbers = {Z: Bare("rollers", rollers=Z, clearance="-1 um", defects=[]) for Z in ROLLERS}
    cuts = [Bare("spatial", contact={"slices": n, "damping": DAMPING}) for n in SLICES]
    sliced = {assemble.slices_of(one.model): one for one in cuts}
    tasks: dict[str, Task] = {}
    for name, one in bare.items():
        tasks |= {f"step/{name}": one.steps, f"forces/{name}": one.forces}
    tasks |= {f"step/{Z} rollers": one.steps for Z, one in numbers.items()}
    tasks |= {f"step/{n} slices": one.steps for n, one in sliced.items()}
    found.measures |= measured(tasks, ROUNDS)
    over_forces(found, bare)
    for what, sizes in (("rollers", list(numbers)), ("slices", list(sliced))):
        found.grows("a step", what, sizes, [found.measures[f"step/{n} {what}"].seconds for n in sizes])


def over_forces(found: Section, bare: dict[str, Bare]) -> None:
    """Each model's step over its contact forces."""
    rows = []
    for name, one in bare.items():
        step_s, forces_s = (found.measures[f"{what}/{name}"].seconds for what in ("step", "forces"))
        ratio = step_s / forces_s
        rows.append([name, one.contacts, 1e9 * step_s, 1e9 * forces_s, 1e9 * forces_s / one.contacts, ratio])
        found.targets.append(Target(f"{name}: a Verlet step over its contact forces", ratio, at_most=MOST[name]))
    head = ["model", "contacts", "step, ns", "forces, ns", "ns a contact", "step/forces"]
    found.table("A Verlet step", head, rows)
