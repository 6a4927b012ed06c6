"""Time integration of a model with a method, recording, and monitoring of validity.

Time is counted in steps from the start, so rounding errors do not accumulate, and a run in chunks is bit-for-bit
identical to the same run in one piece.
"""

from math import floor
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.crossings import count_crossings
from bearingsim.core.jit import absent, generic, jit
from bearingsim.core.methods.interface import prepare, reach, stability_ratio, step
from bearingsim.core.models.interface import (
    begin,
    damping_per_mass,
    monitored_bodies,
    race_deflection_at,
    read_sensor,
    stiffness_per_mass,
    update_extremes,
)
from bearingsim.core.outcomes import NO_BODY, NOT_FINITE, STEP_LIMIT_EXCEEDED, SUCCESS, TOO_DEEP, TOO_MUCH_ENERGY
from bearingsim.core.parameters import lanes
from bearingsim.core.sums import sum_addends

RING_MOTION = tuple(
    block + axis for block in (lay.POSITION, lay.VELOCITY, lay.ACCELERATION) for axis in (lay.X, lay.Y)
)
"""Buffer cells at the start of every recording: the ring's displacement, velocity, acceleration."""


class Monitor(NamedTuple):
    """Limits of a run.

    stride: steps between checks; overrun_limit: time (s) that a body may exceed the method's step limit;
    approach_bound: approach of a contact (m), energy_bound: energy of radial motion (J), both above all values
    possible in the case; max_evaluations: evaluations of the model, for methods that count them, after which
    control returns to the caller.
    """

    stride: int
    overrun_limit: float
    approach_bound: float = np.inf
    energy_bound: float = np.inf
    max_evaluations: float = np.inf


@jit
def start_at_rest(model, t, y):
    """Run ``begin``, compiled as a whole, because its parts would be compiled one by one if Python called them.

    Returns the largest stiffness (1/s^2) and damping (1/s) over mass of a monitored body.
    """
    begin(model, t, y)
    K, C = 0.0, 0.0
    for j in range(monitored_bodies(model)):
        K = max(K, stiffness_per_mass(model, y, j))
        C = max(C, damping_per_mass(model, y, j))
    return K, C


@jit
def record(y, cells, n, out):
    """Write the values at ``cells`` of the buffer into column ``n`` of ``out`` (len(cells), steps)."""
    for c in range(len(cells)):
        out[c, n] = y[cells[c]]


@jit
def prepare_first_step(method, model, t, y):
    """Prepare the buffer for a method's first step at time ``t`` (s); accelerations are already set."""
    y[lay.FAILED_BODY] = NO_BODY
    prepare(method, model, t, y)


@jit
def first_lane_above(row, bound, y, n):
    """Return the first of ``n`` lanes of the buffer's ``row`` that is above ``bound`` or NaN; NO_BODY if none is.

    The lanes above are first counted, because a count is vectorised and a search is not, and usually there are
    none.
    """
    count = 0
    for j in range(n):
        count += 0 if y[row + j] <= bound else 1
    if count > 0:
        for j in range(n):
            if not y[row + j] <= bound:
                return j
    return NO_BODY


@jit
def fill_approaches(model, y, n):
    """Fill row APPROACH_NOW with the larger of each roller's two approaches (m) to undamaged races."""
    gap = model.bearing.gap
    u_x, u_y = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
    i_x, i_y = y[lay.POSITION + lay.X_I], y[lay.POSITION + lay.Y_I]
    for j in range(n):
        c, s, r = y[lay.COS + j], y[lay.SIN + j], y[lay.RADIAL + j]
        y[lay.APPROACH_NOW + j] = max(
            r - (u_x * c + u_y * s) - gap - race_deflection_at(model, y, j), i_x * c + i_y * s - gap - r
        )


@jit
def radial_energy(bearing, y, n):
    """Return the kinetic energy (J) of the ring's motion and the rollers' radial motion."""
    for j in range(n):
        y[lay.ADDENDS + j] = y[lay.RADIAL_V + j] * y[lay.RADIAL_V + j]
    v2 = sum_addends(y, n)
    w_x, w_y = y[lay.VELOCITY + lay.X], y[lay.VELOCITY + lay.Y]
    return 0.5 * (bearing.m_r * v2 + bearing.m_o * (w_x * w_x + w_y * w_y))


@jit
def body_over_step_limit(method, model, monitor, y):
    """Return the body that has been over the method's step limit for longer than allowed, or NO_BODY."""
    elapsed, bodies = monitor.stride * method.h, monitored_bodies(model)
    bodies = lanes(model.bearing) if bodies > 1 else bodies  # padded lanes have zero stiffness over mass
    for j in range(bodies):
        y[lay.STEP_RATIO + j] = stability_ratio(
            method, stiffness_per_mass(model, y, j), damping_per_mass(model, y, j)
        )
    for j in range(bodies):
        y[lay.OVERRUN + j] = 0.0 if y[lay.STEP_RATIO + j] <= 1.0 else y[lay.OVERRUN + j] + elapsed
        y[lay.OVERRUN_MAX + j] = max(y[lay.OVERRUN_MAX + j], y[lay.OVERRUN + j])
    return first_lane_above(lay.OVERRUN, monitor.overrun_limit, y, bodies)


@jit
def check_state(method, model, monitor, t, y):
    """Check the state at time ``t`` (s), and count the crossings of defects if it is valid.

    Returns the outcome and the body concerned (NO_BODY if none in particular).
    """
    n = lanes(model.bearing)
    unstable_body = body_over_step_limit(method, model, monitor, y)
    energy = radial_energy(model.bearing, y, n)
    state_sum = energy
    for c in range(lay.FIRST_LANE):
        state_sum += y[lay.POSITION + c] + y[lay.VELOCITY + c]
    if not np.isfinite(state_sum):
        return NOT_FINITE, NO_BODY
    if unstable_body != NO_BODY:
        return STEP_LIMIT_EXCEEDED, unstable_body
    fill_approaches(model, y, n)
    body = first_lane_above(lay.APPROACH_NOW, monitor.approach_bound, y, n)
    if body != NO_BODY:
        return TOO_DEEP, body
    if energy > monitor.energy_bound:
        return TOO_MUCH_ENERGY, NO_BODY
    count_crossings(model, t, y)
    return SUCCESS, NO_BODY


@absent
class NoSamples(NamedTuple):
    """No recording except after each step."""


class Samples(NamedTuple):
    """Instants at which the state is recorded by dense output, between the steps of an adaptive method.

    first: s, time of sample 0; rate: 1/s; out: (C, n) recorded values.
    """

    first: float
    rate: float
    out: np.ndarray


@generic(absent=None)
def take_samples(samples: Any, method: Any, model: Any, t: float, until: float, y: np.ndarray, cells: Any) -> None:
    """Record ``cells`` of the buffer at all instants after ``t`` and up to ``until`` (s)."""


@take_samples.register(Samples)
def _take_samples(samples, method, model, t, until, y, cells):
    start = max(0, floor((t - samples.first) * samples.rate) + 1)
    stop = min(samples.out.shape[1], floor((until - samples.first) * samples.rate) + 1)
    for k in range(start, stop):
        reach(method, model, samples.first + k / samples.rate, y)
        read_sensor(model, y)
        record(y, cells, k, samples.out)


@jit
def advance_and_sample(method, model, monitor, start, y, cells, out, samples):
    """Take ``out.shape[1]`` steps from step number ``start``, recording ``cells`` of the buffer after each.

    cells: (C,) integers; out: (C, n); samples: ``NoSamples`` or ``Samples``. Returns (steps taken, outcome, body):
    all steps and SUCCESS; the steps up to a failure of the method or a stop by the monitor; or fewer steps and
    SUCCESS after ``monitor.max_evaluations``.
    """
    start_evaluations = y[lay.EVALUATIONS]
    for n in range(out.shape[1]):
        take_samples(samples, method, model, (start + n) * method.h, (start + n + 1) * method.h, y, cells)
        step(method, model, (start + n) * method.h, y)
        update_extremes(model, y)
        read_sensor(model, y)
        record(y, cells, n, out)
        if y[lay.FAILED] != SUCCESS:
            return n + 1, int(y[lay.FAILED]), int(y[lay.FAILED_BODY])
        if (start + n) % monitor.stride == 0:
            outcome, body = check_state(method, model, monitor, (start + n + 1) * method.h, y)
            if outcome != SUCCESS:
                return n + 1, outcome, body
        if y[lay.EVALUATIONS] - start_evaluations > monitor.max_evaluations:
            return n + 1, SUCCESS, NO_BODY
    return out.shape[1], SUCCESS, NO_BODY
