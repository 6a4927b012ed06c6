"""Independent solutions with SciPy's integrators and the compiled models.

The state vector is x = (positions, velocities) of the moving coordinates, with derivatives from the compiled
accelerations. The solver has no information on defects or contact events, so it may step over a defect and report
success; for a reference its step is limited (``Tolerances.longest``). A solution that ends early is not used for a
reference.
"""

import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import integrate

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import LENGTH_SCALE, fill_length_scales
from bearingsim.core.methods.interface import Tolerances
from bearingsim.core.models.interface import accelerations, degrees_of_freedom
from bearingsim.stability.scene import TIMES
from bearingsim.stability.traces import STALL, TOO_SLOW, Trace

SCIPY = {"scipy-lsoda": "LSODA", "scipy-radau": "Radau", "scipy-bdf": "BDF", "scipy-dop853": "DOP853"}
"""SciPy's solver classes, by their names in the stability map."""


class CpuLimitExceeded(Exception):
    """Error of a solver that exceeds its limit of CPU time."""


def moving_coordinates(model: Any) -> np.ndarray:
    """Return the offsets (n,) of the integrated coordinates of a model, within a block of the state."""
    per_roller, shared = degrees_of_freedom(model)
    rollers = [i * lay.ROW + lay.FIRST_LANE + j for i in range(per_roller) for j in range(model.bearing.Z)]
    return np.array([lay.shared_cell(k) for k in range(shared)] + rollers)


def pack(y: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return positions, then velocities, of ``coordinates`` (n,) in the buffer ``y`` as a vector (2 n,)."""
    return np.concatenate([y[lay.POSITION + coordinates], y[lay.VELOCITY + coordinates]])


@jit
def unpack(x: np.ndarray, coordinates: np.ndarray, y: np.ndarray) -> None:
    """Copy the vector ``x`` (2 n,) of ``pack`` into the state of the buffer ``y``."""
    n = len(coordinates)
    for i in range(n):
        y[lay.POSITION + coordinates[i]] = x[i]
        y[lay.VELOCITY + coordinates[i]] = x[n + i]


@jit
def state_rate(
    model: Any, t: float, x: np.ndarray, coordinates: np.ndarray, y: np.ndarray, out: np.ndarray
) -> None:
    """Compute dx/dt (2 n,) of the state ``x`` at time ``t`` (s) into ``out``; y: work buffer, overwritten."""
    n = len(coordinates)
    unpack(x, coordinates, y)
    accelerations(model, t, y)
    for i in range(n):
        out[i] = x[n + i]
        out[n + i] = y[lay.ACCELERATION + coordinates[i]]


class StateRate:
    """Right-hand side dx/dt for SciPy; raises ``CpuLimitExceeded`` after ``limit`` (s of CPU time)."""

    def __init__(self, model: Any, y: np.ndarray, cpu_limit: float) -> None:
        self.model, self.y, self.coordinates = model, y.copy(), moving_coordinates(model)
        fill_length_scales(model, self.y)
        x = np.zeros(2 * len(self.coordinates))
        # compile (or load from the cache) before timing
        state_rate(model, 0.0, x, self.coordinates, self.y.copy(), np.empty_like(x))
        self.start_time, self.limit, self.calls = time.thread_time(), cpu_limit, 0

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        """Compute dx/dt (2 n,)."""
        self.calls += 1
        if self.calls % 64 == 0 and self.cpu > self.limit:
            raise CpuLimitExceeded
        out = np.empty_like(x)
        state_rate(self.model, t, x, self.coordinates, self.y, out)
        return out

    @property
    def cpu(self) -> float:
        """CPU time (s) since the start."""
        return time.thread_time() - self.start_time


def solve(name: str, model: Any, y: np.ndarray, tolerances: Tolerances, cpu_limit: float) -> Trace:
    """Integrate a scene with a solver of ``SCIPY``, from the state in the buffer ``y`` at t = 0 to the last of
    ``TIMES``, in at most ``cpu_limit`` s of CPU time.

    tolerances: those of this package's methods, but rtol also applies to positions, and SciPy's norm of the error
    (except in LSODA) is an RMS over the 2 n components instead of the root of their sum of squares, so it accepts
    errors larger by sqrt(2 n). The trace has the velocity of the ring and the loaded contacts at ``TIMES``.
    """
    right_hand_side = StateRate(model, y, cpu_limit)
    length_scales = right_hand_side.y[LENGTH_SCALE + right_hand_side.coordinates]
    atol = np.concatenate([tolerances.atol_q / length_scales, tolerances.atol_v / length_scales])
    columns: list[np.ndarray] = []
    with np.errstate(all="ignore"), warnings.catch_warnings():  # failures are reported in the returned trace
        warnings.simplefilter("ignore")
        failure, reason, steps = march(
            SCIPY[name], right_hand_side, pack(y, right_hand_side.coordinates), atol, tolerances, columns, TIMES
        )
    cpu, calls = right_hand_side.cpu, right_hand_side.calls
    states = np.concatenate(columns, axis=1) if columns else np.empty((2 * len(length_scales), 0))
    velocity = states[len(length_scales) : len(length_scales) + 2]
    return Trace(
        stride=1,
        velocity=velocity,
        contacts=loaded_contacts(right_hand_side, states),
        failure=failure,
        reason=reason,
        steps=steps,
        evaluations=calls,
        cpu=cpu,
    )


def march(
    class_name: str,
    right_hand_side: StateRate,
    x_0: np.ndarray,
    atol: np.ndarray,
    tolerances: Tolerances,
    columns: list[np.ndarray],
    times: np.ndarray,
    on_step: Callable[[integrate.OdeSolver], None] = lambda solver: None,
) -> tuple[str, str, int]:
    """Step to the last of ``times`` (s); append the states (2 n, k) at the k times in each step to ``columns``.

    class_name: of a solver in ``scipy.integrate``; x_0, atol: (2 n,); on_step: called with the solver after each
    step. Returns failure and reason ("" on success), and the number of steps. Non-finite states count as stalled.
    """
    steps, stop = 0, 0
    try:
        solver = getattr(integrate, class_name)(
            right_hand_side, 0.0, x_0, times[-1], rtol=tolerances.rtol, atol=atol, max_step=tolerances.longest
        )
        while solver.status == "running":
            reason = solver.step()
            steps += 1
            if reason:
                return STALL, str(reason), steps
            if not np.isfinite(solver.y).all():  # LSODA goes on to the end and reports success
                return STALL, "not finite", steps
            on_step(solver)
            start, stop = stop, int(np.searchsorted(times, solver.t, side="right"))
            if stop > start:
                columns.append(solver.dense_output()(times[start:stop]))
    except CpuLimitExceeded:
        return TOO_SLOW, f"not finished after {right_hand_side.limit:g} s of CPU time", steps
    except (ValueError, np.linalg.LinAlgError, FloatingPointError) as error:
        return STALL, str(error), steps  # mostly infinities in the Jacobian
    return "", "", steps


def loaded_contacts(right_hand_side: StateRate, states: np.ndarray) -> np.ndarray:
    """Evaluate the model at the samples of a solution; return whether each roller is loaded at the outer race.

    The result has the shape (Z, samples). states: (2 n, samples) at ``TIMES``. The buffer of ``right_hand_side``
    is overwritten.
    """
    loaded = np.empty((right_hand_side.model.bearing.Z, states.shape[1]), dtype=bool)
    rates = np.empty(len(states))
    for sample in range(states.shape[1]):
        state_rate(
            right_hand_side.model,
            TIMES[sample],
            states[:, sample].copy(),
            right_hand_side.coordinates,
            right_hand_side.y,
            rates,
        )
        loaded[:, sample] = right_hand_side.y[lay.Q_O : lay.Q_O + len(loaded)] > 0.0
    return loaded
