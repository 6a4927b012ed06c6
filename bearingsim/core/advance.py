"""Drive a model through time with a method, record what happens, and watch the step limit live.

Time is counted in steps from the start, so a million steps add no rounding to it, and a run in chunks equals
the same run in one piece bit for bit.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    ACCELERATION,
    LANES,
    OVERRUN,
    OVERRUN_MAX,
    POSITION,
    VELOCITY,
    X,
    Y,
)
from bearingsim.core.methods.interface import load_number, step
from bearingsim.core.models.interface import begin, damping_per_mass, keep_extremes, stiffness_per_mass, watched
from bearingsim.core.outcomes import FINE, NOT_FINITE, OUTRUN

RING = tuple(block + axis for block in (POSITION, VELOCITY, ACCELERATION) for axis in (X, Y))
"""Places in the buffer of what every recording begins with: the ring's displacement, velocity, acceleration."""


class Watch(NamedTuple):
    """stride: steps between looks; patience: seconds a body may be over the method's step limit."""

    stride: int
    patience: float


@jit
def start_at_rest(model, t, y):
    """``begin``, compiled as a whole: from Python its parts compile one by one, each when first met.

    Returns the largest stiffness (1/s^2) and damping (1/s) over mass of a watched body.
    """
    begin(model, t, y)
    K, C = 0.0, 0.0
    for j in range(watched(model)):
        K = max(K, stiffness_per_mass(model, y, j))
        C = max(C, damping_per_mass(model, y, j))
    return K, C


@jit
def record(y, places, n, out):
    """Write the values at ``places`` of the buffer into column ``n`` of ``out`` (len(places), steps)."""
    for c in range(len(places)):
        out[c, n] = y[places[c]]


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
    moving = 0.0
    for c in range(LANES):
        moving += y[POSITION + c] + y[VELOCITY + c]
    if not np.isfinite(moving):
        return NOT_FINITE, -1
    for j in range(bodies):
        if y[OVERRUN + j] > watch.patience:
            return OUTRUN, j
    return FINE, -1


@jit
def advance(method, model, watch, start, y, places, out):
    """Take ``out.shape[1]`` steps from step number ``start``, recording ``places`` of the buffer after each.

    places: (C,) integers; out: (C, n). Returns (steps taken, outcome, body): all steps and FINE, or the step at
    which the watch stopped the run.
    """
    for n in range(out.shape[1]):
        step(method, model, (start + n) * method.h, y)
        keep_extremes(model, y)
        record(y, places, n, out)
        if (start + n) % watch.stride == 0:
            outcome, body = look(method, model, watch, y)
            if outcome != FINE:
                return n + 1, outcome, body
    return out.shape[1], FINE, -1
