"""Drive a model through time with a method, record what happens, and watch the step limit live.

Time is counted in steps from the start, so a million steps add no rounding to it, and a run in chunks equals
the same run in one piece bit for bit.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.layout import LANES, OVERRUN, OVERRUN_MAX, Q_I, Q_MAX, Q_O, A, Q, V, X, Y
from bearingsim.core.methods.interface import load_number, step
from bearingsim.core.models.interface import damping_per_mass, stiffness_per_mass, watched

CHANNELS = 8  # rows of a recording: x, y, x', y', x'', y'', and the first roller's outer and inner force
FIRST_OUTER, FIRST_INNER = 6, 7


class Watch(NamedTuple):
    """stride: steps between looks; patience: seconds a body may be over the method's step limit."""

    stride: int
    patience: float


FINE, OUTRUN, NOT_FINITE = 0, 1, 2  # outcomes of a look


@jit
def record(y, n, out):
    """Write the state after a step into column ``n`` of ``out`` (CHANNELS, steps)."""
    out[0, n] = y[Q + X]
    out[1, n] = y[Q + Y]
    out[2, n] = y[V + X]
    out[3, n] = y[V + Y]
    out[4, n] = y[A + X]
    out[5, n] = y[A + Y]
    out[6, n] = y[Q_O + LANES]
    out[7, n] = y[Q_I + LANES]


@jit
def keep_largest_force(y, end):
    """Running maximum of each roller's outer contact force."""
    for j in range(LANES, end):
        y[Q_MAX + j] = max(y[Q_MAX + j], y[Q_O + j])


@jit
def look(method, model, watch, y):
    """Outcome and body: is the state finite, and has a body outrun the step limit for longer than allowed?"""
    first, end = watched(model)
    if not np.isfinite(y[Q + X] + y[Q + Y] + y[V + X] + y[V + Y]):
        return NOT_FINITE, X
    for j in range(first, end):
        load = load_number(method, stiffness_per_mass(model, y, j), damping_per_mass(model, y, j))
        if not np.isfinite(load):
            return NOT_FINITE, j
        if load > 1.0:
            y[OVERRUN + j] += watch.stride * method.h
            y[OVERRUN_MAX + j] = max(y[OVERRUN_MAX + j], y[OVERRUN + j])
            if y[OVERRUN + j] > watch.patience:
                return OUTRUN, j
        else:
            y[OVERRUN + j] = 0.0
    return FINE, -1


@jit
def advance(method, model, watch, start, y, out):
    """Take ``out.shape[1]`` steps from step number ``start``, recording after each into ``out`` (CHANNELS, n).

    Returns (steps taken, outcome, body): all steps and FINE, or the step at which the watch stopped the run.
    """
    lanes = LANES + model.bearing.Z
    for n in range(out.shape[1]):
        step(method, model, (start + n) * method.h, y)
        record(y, n, out)
        keep_largest_force(y, lanes)
        if (start + n) % watch.stride == 0:
            outcome, body = look(method, model, watch, y)
            if outcome != FINE:
                return n + 1, outcome, body
    return out.shape[1], FINE, -1
