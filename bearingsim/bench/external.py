"""Solvers of other packages on the compiled equations, with the features of their solutions.

A solver gets a model, its static equilibrium and the instants at which an adaptive method records. Its states are
recorded, and features computed, as for the program's methods.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import OdeSolver

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import LENGTH_SCALE
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, update_extremes
from bearingsim.core.sampling import DECIMATION_HALF_LENGTH
from bearingsim.simulation.differentiation import MOTION_ROWS, differentiate
from bearingsim.simulation.features import compute_features
from bearingsim.simulation.recording import Recording
from bearingsim.simulation.repetition import Repetition
from bearingsim.simulation.run_setup import Setup, set_up
from bearingsim.simulation.spectral_lines import amplitudes_by_pass
from bearingsim.stability.references import SCIPY, StateRate, march, moving_coordinates, pack, state_rate, unpack

MAX_CPU = 120.0  # s, limit of the CPU time of a solver
POINTS_PER_STEP = 4  # evaluations of the force, on the solver's interpolant; step ends alone miss peaks by 0.6 %


class Equations(NamedTuple):
    """Problem for a solver: compiled model, its buffer in static equilibrium, instants (n,) in s, tolerances.

    tolerances: as for the program's methods (``core/methods/interface.py``: Tolerances); settled: s, beginning
    of the time for the largest force.
    """

    model: Any
    y: np.ndarray
    instants: np.ndarray
    tolerances: Any
    settled: float


class Solution(NamedTuple):
    """Result of a solver.

    states: (2 m, n) in SI, positions then velocities of the ``moving_coordinates``; cpu: s; force: largest outer
    force (N) within the steps after settling, nan for a solver without access to steps.
    """

    states: np.ndarray
    cpu: float
    force: float = float("nan")


Solver = Callable[[Equations], Solution]
"""Function that solves a problem; raises ``SolverStopped``."""


class SolverStopped(Exception):
    """Error for a solver that ended early, with the reason."""


class ForceTracker(StateRate):
    """Right-hand side dx/dt that also tracks the largest outer force (N) after ``settled`` (s).

    CPU time for the force is not counted.
    """

    def __init__(self, problem: Equations) -> None:
        super().__init__(problem.model, problem.y, MAX_CPU)
        self.settled, self.force, self.rate = problem.settled, 0.0, np.empty(2 * len(self.coordinates))

    def update_force(self, solver: OdeSolver) -> None:
        """Update the largest force with the last step of a solver."""
        if solver.t < self.settled:
            return
        start = time.thread_time()
        state_at = solver.dense_output()
        for t in np.linspace(max(solver.t_old, self.settled), solver.t, POINTS_PER_STEP + 1)[1:]:
            state_rate(self.model, t, state_at(t), self.coordinates, self.y, self.rate)
            self.force = max(self.force, float(self.y[lay.Q_O : lay.Q_O + self.model.bearing.Z].max()))
        self.start_time += time.thread_time() - start


def scipy_solver(name: str) -> Solver:
    """Wrap one of SciPy's solvers, called as in its documentation."""

    def solve(problem: Equations) -> Solution:
        right_hand_side = ForceTracker(problem)
        length_scales = right_hand_side.y[LENGTH_SCALE + right_hand_side.coordinates]
        atol = np.concatenate(
            [problem.tolerances.atol_q / length_scales, problem.tolerances.atol_v / length_scales]
        )
        columns: list[np.ndarray] = []
        start = pack(problem.y, right_hand_side.coordinates)
        failure, reason, _ = march(
            SCIPY[name],
            right_hand_side,
            start,
            atol,
            problem.tolerances,
            columns,
            problem.instants,
            right_hand_side.update_force,
        )
        if failure:
            raise SolverStopped(f"{failure}: {reason}")
        return Solution(np.concatenate(columns, axis=1), right_hand_side.cpu, right_hand_side.force)

    return solve


SOLVERS: dict[str, Solver] = {name: scipy_solver(name) for name in SCIPY}
"""Solvers by name; ``benchmarks/speed_accuracy.py`` adds those of other installed packages."""


def can_solve(case: Case) -> bool:
    """Check if other solvers can integrate the equations of a case, which they cannot for a flexible ring."""
    return case.rig.ring is None and assemble.model_kind(case).parameters in degrees_of_freedom.types


def solve(case: Case, solver: Solver, tolerance: float) -> tuple[dict[str, float], float, float]:
    """Solve a case; return its features, the CPU time (s) of the solver and the simulated time (s)."""
    method = next(m.name for m in METHODS.values() if m.adaptive and not m.implicit)
    options = {"method": method, "tolerance": tolerance, "step": "auto", "periodic": False, "step_check": False}
    setup = set_up(case.model_copy(update=options))
    y, _ = assemble.start(setup.case, setup.model)
    update_extremes(setup.model, y)
    count = setup.grid.passes * setup.grid.steps_per_pass
    problem = Equations(
        setup.model, y, setup.grid.step * np.arange(1, count + 1), setup.method, setup.case.settle_s
    )
    solution = solver(problem)
    values = _features(setup, y, solution.states) | {"outer_force.max": solution.force}
    return values, solution.cpu, setup.grid.passes / setup.grid.rate


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
    grid, model = setup.grid, setup.model
    recording = Recording(setup.case, grid, model.bearing.Z, y)
    steps, tail = grid.steps_per_pass, 2 * DECIMATION_HALF_LENGTH * grid.decimation
    times = grid.step * np.arange(1, grid.passes * steps + 1)
    window = np.empty((len(recording.cells), tail + steps))
    window[:] = y[recording.cells][:, np.newaxis]
    coordinates, state, states = moving_coordinates(model), np.empty(len(states)), np.ascontiguousarray(states)
    recorded = np.empty((len(recording.cells), steps))
    for p in range(grid.passes):
        window[:, :tail] = window[:, steps:].copy()
        _observe(model, times, states, p * steps, coordinates, recording.cells, state, y, recorded)
        window[:, tail:] = recorded
        differentiate(window, MOTION_ROWS[0], tail, grid.step)
        recording.add_pass(p, window, y)
    raw = recording.raw_record(Repetition(grid.passes, 0, float("nan")), y)
    return compute_features(setup.case, model, grid, raw, amplitudes_by_pass(setup.case, model, grid, raw))
