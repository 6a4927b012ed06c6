"""Solvers of other packages on the compiled equations, with the features of their solutions.

A solver gets a model, its static equilibrium and the instants at which an adaptive method records. Its states are
recorded, and features computed, as for own methods.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import LENGTH_SCALE
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, update_extremes
from bearingsim.core.sampling import DECIMATION_REACH
from bearingsim.simulation.features import features
from bearingsim.simulation.integration import MOTIONS, differentiate
from bearingsim.simulation.recording import Recording
from bearingsim.simulation.repetition import Repetition
from bearingsim.simulation.run_setup import Setup, set_up
from bearingsim.stability.references import SCIPY, StateRate, march, moving, packed, state_rate, unpack

MOST_CPU = 120.0  # s, limit of CPU time of a solver


class Equations(NamedTuple):
    """Problem for a solver: compiled model, its buffer in static equilibrium, instants (n,) in s, tolerances.

    tolerances: as for own methods (``core/methods/interface.py``: Tolerances); settled: s, beginning
    of the time in which the largest force is sought.
    """

    model: Any
    y: np.ndarray
    instants: np.ndarray
    tolerances: Any
    settled: float


class Solution(NamedTuple):
    """Result of a solver.

    states: (2 m, n) in SI, positions then velocities of the ``moving`` coordinates; cpu: s; force: largest outer
    force (N) at the ends of steps after settling, nan for a solver without access to steps.
    """

    states: np.ndarray
    cpu: float
    force: float = float("nan")


Solver = Callable[[Equations], Solution]
"""Function that solves a problem; raises ``GaveUp``."""


class GaveUp(Exception):
    """Error of a solver that ended early, with the reason."""


class Watched(StateRate):
    """Right-hand side dx/dt that also tracks the largest outer force (N) at the ends of steps after ``settled``
    (s).

    CPU time for the force is not counted.
    """

    def __init__(self, problem: Equations) -> None:
        super().__init__(problem.model, problem.y, MOST_CPU)
        self.settled, self.force, self.rate = problem.settled, 0.0, np.empty(2 * len(self.coordinates))

    def look(self, t: float, x: np.ndarray) -> None:
        """Update the largest force with the state at the end of a step."""
        if t < self.settled:
            return
        began = time.thread_time()
        state_rate(self.model, t, x, self.coordinates, self.y, self.rate)
        self.force = max(self.force, float(self.y[lay.Q_O : lay.Q_O + self.model.bearing.Z].max()))
        self.began += time.thread_time() - began


def scipy_solver(name: str) -> Solver:
    """Wrap one of SciPy's solvers, called as in its documentation."""

    def solve(problem: Equations) -> Solution:
        f = Watched(problem)
        lever = f.y[LENGTH_SCALE + f.coordinates]
        atol = np.concatenate([problem.tolerances.atol_q / lever, problem.tolerances.atol_v / lever])
        columns: list[np.ndarray] = []
        start = packed(problem.y, f.coordinates)
        failure, reason, _ = march(
            SCIPY[name], f, start, atol, problem.tolerances, columns, problem.instants, f.look
        )
        if failure:
            raise GaveUp(f"{failure}: {reason}")
        return Solution(np.concatenate(columns, axis=1), f.cpu, f.force)

    return solve


SOLVERS: dict[str, Solver] = {name: scipy_solver(name) for name in SCIPY}
"""Solvers by name; ``benchmarks/speed_accuracy.py`` adds those of other installed packages."""


def can_solve(case: Case) -> bool:
    """Check if other solvers can integrate the equations of a case, which they cannot for a flexible ring."""
    return case.rig.ring is None and assemble.kind(case).parameters in degrees_of_freedom.types


def solve(case: Case, solver: Solver, tolerance: float) -> tuple[dict[str, float], float, float]:
    """Solve a case; return its features, the CPU time (s) of the solver and the simulated time (s)."""
    named = next(m.name for m in METHODS.values() if m.adaptive and not m.implicit)
    options = {"method": named, "tolerance": tolerance, "step": "auto", "periodic": False, "step_check": False}
    setup = set_up(case.model_copy(update=options))
    y, _ = assemble.start(setup.case, setup.model)
    update_extremes(setup.model, y)
    count = setup.cut.passes * setup.cut.steps_per_pass
    problem = Equations(
        setup.model, y, setup.cut.step * np.arange(1, count + 1), setup.method, setup.case.settle_s
    )
    solution = solver(problem)
    values = _features(setup, y, solution.states) | {"outer_force.max": solution.force}
    return values, solution.cpu, setup.cut.passes / setup.cut.rate


@jit
def _observe(
    model: Any,
    times: np.ndarray,
    states: np.ndarray,
    begin: int,
    coordinates: np.ndarray,
    recorded: np.ndarray,
    state: np.ndarray,
    y: np.ndarray,
    out: np.ndarray,
) -> None:
    """Record the states (2 m, n) at ``times`` (s), from number ``begin`` on, into ``out`` (C, w)."""
    for n in range(out.shape[1]):
        for k in range(len(state)):
            state[k] = states[k, begin + n]
        unpack(state, coordinates, y)
        accelerations(model, times[begin + n], y)
        update_extremes(model, y)
        for c in range(len(recorded)):
            out[c, n] = y[recorded[c]]


def _features(setup: Setup, y: np.ndarray, states: np.ndarray) -> dict[str, float]:
    """Compute the features of a run from its states at the instants of the record."""
    cut, model = setup.cut, setup.model
    kept = Recording(setup.case, cut, model.bearing.Z, y)
    steps, tail = cut.steps_per_pass, 2 * DECIMATION_REACH * cut.decimation
    times = cut.step * np.arange(1, cut.passes * steps + 1)
    window = np.empty((len(kept.cells), tail + steps))
    window[:] = y[kept.cells][:, np.newaxis]
    places, state, states = moving(model), np.empty(len(states)), np.ascontiguousarray(states)
    recorded = np.empty((len(kept.cells), steps))
    for p in range(cut.passes):
        window[:, :tail] = window[:, steps:].copy()
        _observe(model, times, states, p * steps, places, kept.cells, state, y, recorded)
        window[:, tail:] = recorded
        differentiate(window, MOTIONS[0], tail, cut.step)
        kept.keep(p, window, y)
    raw = kept.raw(Repetition(cut.passes, 0, float("nan")), y)
    return features(setup.case, model, cut, raw)
