"""SciPy's integrators on the compiled models: methods of other people to compare with, and to check against.

A model's state becomes a vector x = (positions, velocities) of what can move; its slopes are the compiled
accelerations. Nothing is told to the solver of pits or touch-down; what it takes for success is read, and a run
that ends early is no reference.
"""

import time
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, LANES, POSITION, ROW, VELOCITY, shared_cell
from bearingsim.core.models.interface import accelerations, freedoms

SCIPY = ("LSODA", "Radau", "BDF", "DOP853")


class OutOfTime(Exception):
    """A solver has used up the CPU time it was given."""


class Solution(NamedTuple):
    """x: (2 n, samples) at the times asked for, as far as the solver came; why it ended (empty: success)."""

    x: np.ndarray
    failure: str
    steps: int
    evaluations: int
    cpu: float


def moving(model: Any) -> np.ndarray:
    """Offsets (n,) within a block of the state of what the model's equations move."""
    own, shared = freedoms(model)
    rollers = [i * ROW + LANES + j for i in range(own) for j in range(model.bearing.Z)]
    return np.array([shared_cell(k) for k in range(shared)] + rollers)


def packed(y: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The vector (2 n,) of a buffer's state."""
    return np.concatenate([y[POSITION + places], y[VELOCITY + places]])


@jit
def unpack(x, places, y):
    """Put the vector ``x`` into the buffer's state."""
    n = len(places)
    for i in range(n):
        y[POSITION + places[i]] = x[i]
        y[VELOCITY + places[i]] = x[n + i]


@jit
def slopes(model, t, x, places, y, out):
    """dx/dt (2 n,) into ``out``."""
    n = len(places)
    unpack(x, places, y)
    accelerations(model, t, y)
    for i in range(n):
        out[i] = x[n + i]
        out[n + i] = y[ACCELERATION + places[i]]


class Slopes:
    """dx/dt as SciPy calls it; raises ``OutOfTime`` once ``limit`` (s of CPU) has gone."""

    def __init__(self, model: Any, y: np.ndarray, limit: float) -> None:
        self.model, self.y, self.places = model, y.copy(), moving(model)
        self.began, self.limit, self.calls = time.thread_time(), limit, 0

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        """dx/dt (2 n,)."""
        self.calls += 1
        if self.calls % 64 == 0 and self.cpu > self.limit:
            raise OutOfTime
        out = np.empty_like(x)
        slopes(self.model, t, x, self.places, self.y, out)
        return out

    @property
    def cpu(self) -> float:
        """CPU seconds since the beginning."""
        return time.thread_time() - self.began


def solve(
    solver: str,
    model: Any,
    y: np.ndarray,
    times: np.ndarray,
    rtol: float,
    atol: np.ndarray,
    longest: float = np.inf,
    limit: float = np.inf,
) -> Solution:
    """Run one of SciPy's solvers from the buffer's state at t = 0 through ``times`` (s, increasing).

    atol: (2 n,) as ``tolerances`` gives it; longest: step, s; limit: CPU seconds.
    """
    from scipy import integrate

    f = Slopes(model, y, limit)
    x_0 = packed(y, f.places)
    failure, steps, columns = "", 0, []
    try:
        one = getattr(integrate, solver)(f, 0.0, x_0, times[-1], rtol=rtol, atol=atol, max_step=longest)
        at = 0
        while one.status == "running" and not failure:
            failure = one.step() or ""
            steps += 1
            due = int(np.searchsorted(times, one.t, side="right"))
            if due > at and not failure:
                columns.append(one.dense_output()(times[at:due]))
                at = due
    except OutOfTime:
        failure = "out of time"
    except (ValueError, np.linalg.LinAlgError, FloatingPointError) as error:
        failure = str(error)  # a Jacobian with infinities in it
    x = np.concatenate(columns, axis=1) if columns else np.empty((len(x_0), 0))
    return Solution(x, failure, steps, f.calls, f.cpu)
