"""Driver of all adaptive methods: step size control, stops at jumps, and states at recorded instants.

Steps run ahead of the recorded instants, whose states are computed by dense output, so recording does not affect
the steps. The complete state of a run is in the buffer, so a run in parts is identical to one in a single part.

Norm of a step's error e in positions (m) and velocities (m/s), angles multiplied by their lever arm:

    |e|^2 = sum (e_q/atol_q)^2 + sum (e_v/(atol_v + rtol |v|))^2,   accepted if |e| <= 1

It is a sum and not a mean, because the impact of one roller must not be averaged out by the others. Step size:
proportional-integral control (Gustafsson 1991; Hairer and Wanner, Solving ODEs II, sec. IV.2), which also avoids
step size oscillations of an explicit method at its stability limit. First step: Hairer, Norsett and Wanner,
Solving ODEs I, sec. II.4.

One step ends just before a jump (``defects/jumps.py``) and the next begins just after it, so no step contains a
jump. The gap is of the order of rounding errors of the time; explicit methods cross it by the trapezoidal rule.
"""

from collections.abc import Callable
from math import inf, isfinite, sqrt
from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.clock import is_over
from bearingsim.core.defects.jumps import JUMP_GAP, next_jump
from bearingsim.core.jit import generic, jit
from bearingsim.core.methods.interface import attempt, interpolate, no_limit, prepare, reach, stability_ratio, step
from bearingsim.core.models.differences import roller_arms, shared_arms
from bearingsim.core.models.extremes import may_peak_within, store_forces_at_end, update_forces_within
from bearingsim.core.models.interface import (
    accelerations,
    degrees_of_freedom,
    harmonics,
    state_width,
    update_extremes,
)
from bearingsim.core.outcomes import STEP_TOO_SMALL, SUCCESS, TOO_MANY_STEPS, TOO_SLOW
from bearingsim.core.parameters import lanes
from bearingsim.core.sums import sum_addends

ADAPTIVE = "adaptive tableau rodas backward-euler generalized-alpha"  # owners of the rows of every adaptive method
# states at the start and at the end of a step
START_Q, START_V, START_A, END_Q, END_V, END_A = lay.states(lay.STAGE, "m, m/s, m/s^2", ADAPTIVE, "step", count=2)
METHOD_STATES = lay.STAGE + 6 * lay.STATE  # 49 blocks, declared by each method
# length (m) per unit of each coordinate; 0 for entries that are not coordinates
(LENGTH_SCALE,) = lay.states(lay.STAGE + 55 * lay.STATE, "1", ADAPTIVE, "run")

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 5.0  # of the factor by which the step size changes
SMALL_ERROR = 1e-4  # error over tolerance; the controller uses this value for smaller errors
MIN_STEP = 1e-15  # s: minimum step, unless several rounding errors of the time are larger
TIME_ROUNDING = 8 * 2.0**-52  # relative rounding error of a time, with a margin
JUMP_STEP = 1e-13  # s: in steps shorter than this an L-stable method need not locate the jump
MAX_ATTEMPTS = 100_000  # attempted steps between two recorded instants
CLOCK_INTERVAL = 64  # attempted steps between readings of the clock
TIME_TOLERANCE = 1e-9  # part of the recording interval; a step's end closer to an instant is used for it


@generic
def estimate_order(method: Any) -> float:
    """Return the exponent of the step size in the method's error estimate."""


@generic
def failure_outcome(method: Any) -> int:
    """Return the outcome (``core/outcomes.py``) of a run whose steps fall below the minimum."""


@generic
def jump_weight(method: Any) -> float:
    """Return the weight, 0 to 1, of the forces just after a jump in the step across it.

    It is 0 for an implicit method, because with a stiff dashpot even JUMP_GAP can be too long a step for the
    velocity after a jump; the next step corrects this.
    """


@generic
def complete_dense_output(method: Any, model: Any, y: Any) -> None:
    """Evaluate the additional stages for the dense output of the last step, at most once and only if needed.

    It may overwrite the state's blocks, but not START and END, nor what the step needs of METHOD_STATES.
    """


def no_completion(method, model, y):
    """Do nothing, as ``complete_dense_output`` of methods whose dense output needs no evaluation."""


def register_adaptive(
    parameters: type,
    order: float,
    completion: Callable = no_completion,
    failure: int = STEP_TOO_SMALL,
    weight: float = 1.0,
) -> None:
    """Register a method that has ``attempt`` and ``interpolate`` as adaptive.

    parameters: type with the fields of ``Tolerances``; order: its ``estimate_order``; completion: its
    ``complete_dense_output``; failure: its ``failure_outcome``; weight: its ``jump_weight``.
    """
    prepare.register(parameters)(_prepare)
    step.register(parameters)(_step)
    reach.register(parameters)(_reach)
    stability_ratio.register(parameters)(no_limit)  # limited by its error
    estimate_order.register(parameters)(lambda method: order)
    complete_dense_output.register(parameters)(completion)
    failure_outcome.register(parameters)(lambda method: failure)
    jump_weight.register(parameters)(lambda method: weight)


# The state, in blocks


@jit
def save_state(y, block, n):
    """Copy the state, accelerations included, into the three blocks from ``block`` on."""
    for j in range(n):
        y[block + j] = y[lay.POSITION + j]
        y[block + lay.STATE + j] = y[lay.VELOCITY + j]
        y[block + 2 * lay.STATE + j] = y[lay.ACCELERATION + j]


@jit
def restore_state(y, block, n):
    """Copy the state from the three blocks from ``block`` on."""
    for j in range(n):
        y[lay.POSITION + j] = y[block + j]
        y[lay.VELOCITY + j] = y[block + lay.STATE + j]
        y[lay.ACCELERATION + j] = y[block + 2 * lay.STATE + j]


@jit
def start_from_end(y, n):
    """Copy END of the last step to START of the next."""
    for j in range(n):
        y[START_Q + j] = y[END_Q + j]
        y[START_V + j] = y[END_V + j]
        y[START_A + j] = y[END_A + j]


# Errors


@jit
def fill_length_scales(model, y):
    """Fill LENGTH_SCALE: 1 for lengths, the lever arm (m) for angles and axes."""
    b = model.bearing
    per_roller, shared = degrees_of_freedom(model)
    shared_scales, roller_scales = shared_arms(b), roller_arms(b)
    for j in range(lay.STATE):
        y[LENGTH_SCALE + j] = 0.0
    for k in range(shared):
        y[LENGTH_SCALE + lay.shared_cell(k)] = shared_scales[k]
    for i in range(per_roller):
        for j in range(b.Z):
            y[LENGTH_SCALE + lay.FIRST_LANE + i * lay.ROW + j] = roller_scales[i]
    for i in range(harmonics(model)):
        y[LENGTH_SCALE + lay.MODES_C + i] = y[LENGTH_SCALE + lay.MODES_S + i] = 1.0


@jit
def error_norm(method, error_q, error_v, y, n):
    """Return the norm, over the tolerance, of the errors of positions and velocities in blocks ``error_q``,
    ``error_v``.

    The tolerance of velocities is relative to the larger of the velocities at START and in the state's block.
    """
    per_atol_q = 1.0 / method.atol_q  # leaves one division per entry
    for j in range(n):
        lever = y[LENGTH_SCALE + j]
        v = lever * max(abs(y[START_V + j]), abs(y[lay.VELOCITY + j]))
        e_q = lever * y[error_q + j] * per_atol_q
        e_v = lever * y[error_v + j] / (method.atol_v + method.rtol * v)
        y[lay.ADDENDS + j] = e_q * e_q + e_v * e_v
    return sqrt(sum_addends(y, n))


@jit
def limit_jump_error(error, h):
    """Return the error of an L-stable method, limited to 1 in a step so short that only a jump of the force can
    cause a larger one.

    After the jump the force acts over the whole step instead of a part of it. The displacement in the step is a
    rounding error, and the dashpot compensates the error of the impulse faster than anything else moves, because
    its shortest relaxation time is 1e-11 s (1e9 N s/m on 10 g).
    """
    return 1.0 if h <= JUMP_STEP and isfinite(error) and error > 1.0 else error


@jit
def scaled_norm(method, q, v, y, n):
    """Return the norm, over the tolerance at START, of positions and velocities in the blocks ``q`` and ``v``."""
    for j in range(n):
        lever = y[LENGTH_SCALE + j]
        e_q = lever * y[q + j] / method.atol_q
        e_v = lever * y[v + j] / (method.atol_v + method.rtol * lever * abs(y[START_V + j]))
        y[lay.ADDENDS + j] = e_q * e_q + e_v * e_v
    return sqrt(sum_addends(y, n))


# Step size


@jit
def first_step(method, model, t, y, n):
    """Return the size (s) of the first step, estimated from the change of the accelerations over an Euler step."""
    norm_1 = scaled_norm(method, START_V, START_A, y, n)
    h = 1e-2 * scaled_norm(method, START_Q, START_V, y, n) / norm_1 if norm_1 > 0.0 else method.longest
    h = min(max(h, 1e-3 * method.longest), method.longest)
    for j in range(n):
        y[lay.POSITION + j] = y[START_Q + j] + h * y[START_V + j]
        y[lay.VELOCITY + j] = y[START_V + j] + h * y[START_A + j]
    accelerations(model, t + h, y)
    y[lay.EVALUATIONS] += 2.0
    for j in range(n):
        y[METHOD_STATES + j] = y[START_A + j] * h
        y[METHOD_STATES + lay.STATE + j] = y[lay.ACCELERATION + j] - y[START_A + j]
    restore_state(y, START_Q, n)
    accelerations(model, t, y)
    norm_2 = scaled_norm(method, METHOD_STATES, METHOD_STATES + lay.STATE, y, n) / h
    norm_max = max(norm_2, norm_1)
    return min(100.0 * h, (1e-2 / norm_max) ** (1.0 / estimate_order(method)) if norm_max > 0.0 else inf)


@jit
def shrink_factor(method, error):
    """Return the factor for the size of a rejected step, the minimum if the error is not finite."""
    return max(MIN_FACTOR, SAFETY * error ** (-1.0 / estimate_order(method))) if isfinite(error) else MIN_FACTOR


@jit
def growth_factor(method, error, last_error):
    """Return the factor for the size of the next step, from the errors of this and of the last step."""
    k = estimate_order(method)
    factor = SAFETY * max(error, SMALL_ERROR) ** (-0.7 / k) * last_error ** (0.4 / k)
    return min(MAX_FACTOR, max(MIN_FACTOR, factor))


@jit
def fit_to_stop(h, distance):
    """Return the step ``h`` (s), shortened to end at a stop ``distance`` (s) ahead or to leave at least its own
    size before it."""
    if h >= distance:
        return distance
    return 0.5 * distance if 2.0 * h > distance else h


# Steps


@jit
def cross_jump(method, model, y, n):
    """Step from just before a jump to just after it, without changing the stored size of the last step."""
    t, weight = y[lay.T_END] + 2.0 * JUMP_GAP, jump_weight(method)
    for j in range(n):
        y[lay.POSITION + j] = y[END_Q + j] + 2.0 * JUMP_GAP * y[END_V + j]
        y[lay.VELOCITY + j] = y[END_V + j] + 2.0 * JUMP_GAP * y[END_A + j]
    accelerations(model, t, y)
    for j in range(n):
        mean = y[END_A + j] + 0.5 * weight * (y[lay.ACCELERATION + j] - y[END_A + j])
        y[lay.VELOCITY + j] = y[END_V + j] + 2.0 * JUMP_GAP * mean
    accelerations(model, t, y)
    y[lay.EVALUATIONS] += 2.0
    y[lay.T_END] = t


@jit
def take_step(method, model, y, n):
    """Attempt steps from END until one is accepted or the minimum is reached; return the number of attempts."""
    t = y[lay.T_END]
    start_from_end(y, n)
    h_proposed = min(y[lay.H_NEXT], method.longest)
    h = fit_to_stop(h_proposed, y[lay.NEXT_STOP] - t - 0.5 * JUMP_GAP)
    h_min = max(MIN_STEP, TIME_ROUNDING * abs(t))
    error = attempt(method, model, t, h, y)
    attempts = 1
    while not error <= 1.0:
        y[lay.STEPS_REJECTED] += 1.0
        h *= shrink_factor(method, error)
        h_proposed = 0.0
        if h < h_min:
            y[lay.FAILED] = failure_outcome(method)
            return attempts
        error = attempt(method, model, t, h, y)
        attempts += 1
    factor = growth_factor(method, error, y[lay.LAST_ERROR])
    y[lay.H_NEXT] = max(h * (factor if attempts == 1 else min(factor, 1.0)), h_proposed if h < h_proposed else 0.0)
    y[lay.LAST_ERROR] = max(error, SMALL_ERROR)
    y[lay.T_START], y[lay.T_END], y[lay.H_TAKEN] = t, t + h, h
    y[lay.DENSE_READY] = 0.0
    y[lay.STEPS_TAKEN] += 1.0
    return attempts


@jit
def advance_once(method, model, y):
    """Make one accepted step, or cross a jump; return the number of attempted steps."""
    n, rollers = state_width(model), lanes(model.bearing)
    if y[lay.NEXT_STOP] - y[lay.T_END] <= JUMP_GAP:
        cross_jump(method, model, y, n)
        store_step_end(model, y, n)
        store_forces_at_end(y, rollers)
        return 1
    attempts = take_step(method, model, y, n)
    if y[lay.FAILED] == SUCCESS:
        store_step_end(model, y, n)
        store_forces_at_end(y, rollers)
        if may_peak_within(y, rollers):
            set_midpoint_state(model, y, n)
            update_forces_within(y, rollers)
    return attempts


@jit
def store_step_end(model, y, n):
    """Store the state at the end of a step or a crossed jump, and predict the next jump."""
    save_state(y, END_Q, n)
    update_extremes(model, y)
    y[lay.NEXT_STOP] = next_jump(model, y[lay.T_END], y)


@jit
def set_midpoint_state(model, y, n):
    """Set the state at the midpoint of the last step, contacts included, by Hermite's quintic polynomial.

    It interpolates positions, velocities and accelerations at both ends, with an error of sixth order in the step,
    so the method's dense output need not be completed.
    """
    h = y[lay.H_TAKEN]
    per_h = 1.0 / h
    for k in range(n):
        q_0, v_0, a_0 = y[START_Q + k], y[START_V + k], y[START_A + k]
        q_1, v_1, a_1 = y[END_Q + k], y[END_V + k], y[END_A + k]
        y[lay.POSITION + k] = 0.5 * (q_0 + q_1) + h * (5 / 32 * (v_0 - v_1) + h / 64.0 * (a_0 + a_1))
        y[lay.VELOCITY + k] = 15 / 8 * per_h * (q_1 - q_0) - 7 / 16 * (v_0 + v_1) + h / 32.0 * (a_1 - a_0)
    accelerations(model, y[lay.T_START] + 0.5 * h, y)
    y[lay.EVALUATIONS] += 1.0


@jit
def interpolate_state(method, model, fraction, y, n):
    """Set the state at ``fraction`` (0 to 1) of the last step, contacts included."""
    if y[lay.DENSE_READY] == 0.0:
        complete_dense_output(method, model, y)
        y[lay.DENSE_READY] = 1.0
    interpolate(method, fraction, y[lay.H_TAKEN], y, n)
    accelerations(model, y[lay.T_START] + fraction * y[lay.H_TAKEN], y)
    y[lay.EVALUATIONS] += 1.0


@jit
def set_recorded_state(method, model, t, y):
    """Set the state at a recorded instant ``t`` (s) within the last step, contacts included."""
    n = state_width(model)
    if y[lay.H_TAKEN] > 0.0 and abs(t - y[lay.T_END]) > TIME_TOLERANCE * method.h:
        interpolate_state(method, model, (t - y[lay.T_START]) / y[lay.H_TAKEN], y, n)
    else:
        restore_state(y, END_Q, n)
        accelerations(model, t, y)
        y[lay.EVALUATIONS] += 1.0


def _prepare(method, model, t, y):
    """Implement ``prepare`` for every adaptive method."""
    n = state_width(model)
    fill_length_scales(model, y)
    y[lay.T_START], y[lay.T_END], y[lay.H_TAKEN], y[lay.DENSE_READY], y[lay.LAST_ERROR] = t, t, 0.0, 0.0, 1.0
    y[lay.FAILED] = SUCCESS
    save_state(y, START_Q, n)
    store_forces_at_end(y, lanes(model.bearing))
    y[lay.H_NEXT] = min(first_step(method, model, t, y, n), method.longest)
    save_state(y, END_Q, n)
    y[lay.NEXT_STOP] = t  # an earlier run past t may have left a stop beyond the next jump
    y[lay.NEXT_STOP] = next_jump(model, t, y)


def _step(method, model, t, y):
    """Implement ``step`` for every adaptive method."""
    reach(method, model, t + method.h, y)


def _reach(method, model, t, y):
    """Implement ``reach`` for every adaptive method: step to the instant or past it, then use dense output."""
    attempts, next_reading = 0, CLOCK_INTERVAL
    while y[lay.FAILED] == SUCCESS and y[lay.T_END] < t - TIME_TOLERANCE * method.h:
        attempts += advance_once(method, model, y)
        if attempts > MAX_ATTEMPTS and y[lay.FAILED] == SUCCESS:
            y[lay.FAILED] = TOO_MANY_STEPS
        if attempts >= next_reading:
            next_reading = attempts + CLOCK_INTERVAL
            if is_over(y[lay.CPU_END]):
                y[lay.FAILED] = TOO_SLOW
    if y[lay.FAILED] == SUCCESS:
        set_recorded_state(method, model, t, y)
