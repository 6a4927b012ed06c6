"""Drive a model through time with a method, record what happens, and watch the step limit live.

Time is counted in steps from the start, so a million steps add no rounding to it, and a run in chunks equals
the same run in one piece bit for bit.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, OVERRUN, OVERRUN_MAX, POSITION, Q_I, Q_MAX, Q_O, VELOCITY, X, Y
from bearingsim.core.methods.interface import load_number, step
from bearingsim.core.models.interface import damping_per_mass, stiffness_per_mass, watched
from bearingsim.core.parameters import lanes

RECORDED = (  # rows of a recording; forces are the first roller's
    *("ring.displacement.x", "ring.displacement.y", "ring.velocity.x", "ring.velocity.y"),
    *("ring.acceleration.x", "ring.acceleration.y", "roller.outer_force", "roller.inner_force"),
)
CHANNELS = len(RECORDED)
FIRST_OUTER = RECORDED.index("roller.outer_force")


class Watch(NamedTuple):
    """stride: steps between looks; patience: seconds a body may be over the method's step limit."""

    stride: int
    patience: float


FINE, OUTRUN, NOT_FINITE = 0, 1, 2  # outcomes of a look


@jit
def record(y, n, out):
    """Write the state after a step into column ``n`` of ``out`` (CHANNELS, steps)."""
    out[0, n] = y[POSITION + X]
    out[1, n] = y[POSITION + Y]
    out[2, n] = y[VELOCITY + X]
    out[3, n] = y[VELOCITY + Y]
    out[4, n] = y[ACCELERATION + X]
    out[5, n] = y[ACCELERATION + Y]
    out[6, n] = y[Q_O]
    out[7, n] = y[Q_I]


@jit
def keep_largest_force(y, n):
    """Running maximum of each roller's outer contact force."""
    for j in range(n):
        y[Q_MAX + j] = max(y[Q_MAX + j], y[Q_O + j])


@jit
def look(method, model, watch, y):
    """Outcome and body: is the state finite, and has a body outrun the step limit for longer than allowed?"""
    elapsed = watch.stride * method.h
    bodies = watched(model)
    for j in range(bodies):
        load = load_number(method, stiffness_per_mass(model, y, j), damping_per_mass(model, y, j))
        over = 0.0 if load <= 1.0 else y[OVERRUN + j] + elapsed
        y[OVERRUN + j] = over
        y[OVERRUN_MAX + j] = max(y[OVERRUN_MAX + j], over)
    if not np.isfinite(y[POSITION + X] + y[POSITION + Y] + y[VELOCITY + X] + y[VELOCITY + Y]):
        return NOT_FINITE, -1
    for j in range(bodies):
        if y[OVERRUN + j] > watch.patience:
            return OUTRUN, j
    return FINE, -1


@jit
def advance(method, model, watch, start, y, out):
    """Take ``out.shape[1]`` steps from step number ``start``, recording after each into ``out`` (CHANNELS, n).

    Returns (steps taken, outcome, body): all steps and FINE, or the step at which the watch stopped the run.
    """
    used = lanes(model.bearing)
    for n in range(out.shape[1]):
        step(method, model, (start + n) * method.h, y)
        record(y, n, out)
        keep_largest_force(y, used)
        if (start + n) % watch.stride == 0:
            outcome, body = look(method, model, watch, y)
            if outcome != FINE:
                return n + 1, outcome, body
    return out.shape[1], FINE, -1
