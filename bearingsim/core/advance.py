"""Drive a model through time with a method, record what happens, and watch that it can be believed.

Time is counted in steps from the start, so a million steps add no rounding to it, and a run in chunks equals
the same run in one piece bit for bit.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    ACCELERATION,
    BURDEN,
    COS,
    EVALUATED,
    FAILED,
    FAILED_BODY,
    LANES,
    OVERRUN,
    OVERRUN_MAX,
    POSITION,
    SIN,
    VELOCITY,
    X_I,
    Y_I,
    Q,
    V,
    X,
    Y,
)
from bearingsim.core.methods.interface import load_number, prepare, step
from bearingsim.core.models.interface import begin, damping_per_mass, keep_extremes, stiffness_per_mass, watched
from bearingsim.core.outcomes import FINE, NOBODY, NOT_FINITE, OUTRUN, TOO_DEEP, TOO_LIVELY
from bearingsim.core.parameters import lanes
from bearingsim.core.pits.crossings import spot

RING = tuple(block + axis for block in (POSITION, VELOCITY, ACCELERATION) for axis in (X, Y))
"""Places in the buffer of what every recording begins with: the ring's displacement, velocity, acceleration."""


class Watch(NamedTuple):
    """What a run must keep to.

    stride: steps between looks; patience: seconds a body may be over the method's step limit; deepest: approach of
    a contact (m) and liveliest: energy of radial motion (J) that nothing in the case can bring about; most_work:
    evaluations of the model, by a method that counts them, after which its caller is to look.
    """

    stride: int
    patience: float
    deepest: float = np.inf
    liveliest: float = np.inf
    most_work: float = np.inf


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
def ready(method, model, t, y):
    """Make the buffer ready for a method's first step at time ``t`` (s); accelerations are in place."""
    y[FAILED_BODY] = NOBODY
    prepare(method, model, t, y)


@jit
def deepest_contact(bearing, y, n):
    """Largest approach (m) of a roller to an undamaged race, as the bodies stand, and the roller's number."""
    gap, deepest, body = bearing.gap, -1.0, 0
    u_x, u_y = y[POSITION + X], y[POSITION + Y]
    i_x, i_y = y[POSITION + X_I], y[POSITION + Y_I]
    for j in range(n):
        outer = y[Q + j] - (u_x * y[COS + j] + u_y * y[SIN + j]) - gap
        inner = i_x * y[COS + j] + i_y * y[SIN + j] - gap - y[Q + j]
        if max(outer, inner) > deepest:
            deepest, body = max(outer, inner), j
    return deepest, body


@jit
def radial_energy(bearing, y, n):
    """Kinetic energy (J) of the ring's motion and the rollers' radial one."""
    v2 = 0.0
    for j in range(n):
        v2 = add(v2, y[V + j] * y[V + j])
    w_x, w_y = y[VELOCITY + X], y[VELOCITY + Y]
    return 0.5 * (bearing.m_r * v2 + bearing.m_o * (w_x * w_x + w_y * w_y))


@jit
def outrun(method, model, watch, y):
    """The body that has been over the method's step limit for longer than allowed, or NOBODY."""
    elapsed, bodies = watch.stride * method.h, watched(model)
    for j in range(bodies):
        y[BURDEN + j] = load_number(method, stiffness_per_mass(model, y, j), damping_per_mass(model, y, j))
    found = NOBODY
    for j in range(bodies):
        over = 0.0 if y[BURDEN + j] <= 1.0 else y[OVERRUN + j] + elapsed
        y[OVERRUN + j] = over
        y[OVERRUN_MAX + j] = max(y[OVERRUN_MAX + j], over)
        if over > watch.patience and found == NOBODY:
            found = j
    return found


@jit
def look(method, model, watch, t, y):
    """Outcome and body at time ``t`` (s): is the state finite, and no more than the case can have made of it?"""
    n = lanes(model.bearing)
    slow = outrun(method, model, watch, y)
    energy = radial_energy(model.bearing, y, n)
    moving = energy
    for c in range(LANES):
        moving += y[POSITION + c] + y[VELOCITY + c]
    if not np.isfinite(moving):
        return NOT_FINITE, NOBODY
    if slow != NOBODY:
        return OUTRUN, slow
    deepest, body = deepest_contact(model.bearing, y, n)
    if deepest > watch.deepest:
        return TOO_DEEP, body
    if energy > watch.liveliest:
        return TOO_LIVELY, NOBODY
    spot(model, t, y)
    return FINE, NOBODY


@jit
def advance(method, model, watch, start, y, places, out):
    """Take ``out.shape[1]`` steps from step number ``start``, recording ``places`` of the buffer after each.

    places: (C,) integers; out: (C, n). Returns (steps taken, outcome, body): all steps and FINE, or the step at
    which the method gave up or the watch stopped the run; fewer steps and FINE once they were much work.
    """
    before = y[EVALUATED]
    for n in range(out.shape[1]):
        step(method, model, (start + n) * method.h, y)
        keep_extremes(model, y)
        record(y, places, n, out)
        if y[FAILED] != FINE:
            return n + 1, int(y[FAILED]), int(y[FAILED_BODY])
        if (start + n) % watch.stride == 0:
            outcome, body = look(method, model, watch, (start + n + 1) * method.h, y)
            if outcome != FINE:
                return n + 1, outcome, body
        if y[EVALUATED] - before > watch.most_work:
            return n + 1, FINE, NOBODY
    return out.shape[1], FINE, NOBODY
