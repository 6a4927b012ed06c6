"""The driver of every adaptive method: chooses steps, ends them on jumps, and shows the recorded instants.

A method's steps run ahead of the recorded instants, which are found in them by its dense output; so what is
recorded changes no step. All that a run remembers lies in the buffer: a run in pieces equals the run in one.

Error: e of a step's positions and velocities, coordinate by coordinate in metres (angles by the arm they act at),

    |e|^2 = sum (e_q/atol_q)^2 + sum (e_v/(atol_v + rtol |v|))^2,   accepted if |e| <= 1

a sum and not a mean: one roller that hits is not averaged away by twelve that do not. Step: proportional-integral
control (Gustafsson 1991; Hairer and Wanner, Solving ODEs II, sec. IV.2), which also keeps an explicit method
quiet where stability limits it. First step: Hairer, Norsett and Wanner, Solving ODEs I, sec. II.4.

At a jump (``pits/jumps.py``) a step ends just before it, and the next begins just after it: no method looks
across. What lies between is less than rounding leaves of the time; explicit methods take it by the trapezoidal
rule.
"""

from collections.abc import Callable
from math import inf, isfinite, sqrt
from typing import Any

from bearingsim.core.jit import add, generic, jit
from bearingsim.core.layout import (
    ACCELERATION,
    DENSE,
    EVALUATED,
    FAILED,
    H_NEXT,
    H_TAKEN,
    LANES,
    LAST_ERROR,
    NEXT_STOP,
    POSITION,
    REFUSED,
    ROW,
    STAGE,
    STATE,
    T_END,
    T_START,
    TAKEN,
    VELOCITY,
    shared_cell,
)
from bearingsim.core.methods.interface import attempt, interpolate, load_number, no_limit, prepare, step
from bearingsim.core.models.interface import accelerations, freedoms, keep_extremes, width
from bearingsim.core.outcomes import FINE, STALLED, STEP_FLOOR
from bearingsim.core.pits.jumps import next_cusp

START_Q, START_V, START_A = (STAGE + n * STATE for n in range(3))  # the state a step begins from
END_Q, END_V, END_A = (STAGE + n * STATE for n in range(3, 6))  # and the one it has come to
SLOPES = STAGE + 6 * STATE  # 49 blocks of the method's own
LEVER = STAGE + 55 * STATE  # metres per unit of each coordinate; 0 of entries that are none

SAFETY, LEAST, MOST = 0.9, 0.2, 5.0  # by how much a step may change
SMALL_ERROR = 1e-4  # a smaller one tells the controller nothing
FLOOR = 1e-15  # s: steps below it, or below some roundings of the time, are none
ROUNDINGS = 8 * 2.0**-52
SUDDEN = 1e-13  # s: where in so short a step a force jumps is of no account to methods that damp what it leaves
HOP = 1e-12  # s: so far on either side of a jump a step ends, or begins
MOST_TRIES = 100_000  # steps between two recorded instants
ON_TIME = 1e-9  # part of the time between recorded instants: so near to one, a step's end is it


@generic
def estimate_order(method: Any) -> float:
    """The power of the step that the method's estimate of its error goes with."""


@generic
def dead_end(method: Any) -> int:
    """Why a run ends whose steps fall below the floor (``core/outcomes.py``)."""


@generic
def beyond(method: Any) -> float:
    """Weight, 0 to 1, of the forces just behind a jump when it is hopped over.

    An implicit method takes those before it alone: a dashpot may be so stiff that even HOP is too long a step for
    the velocity that a jump leaves, and the next step settles it.
    """


@generic
def complete(method: Any, model: Any, y: Any) -> None:
    """Evaluate what the dense output of the step just taken needs beyond it; once a step, and only if asked for.

    The state's blocks may be used, and are left as they fall; START, END, SLOPES are the step's.
    """


def nothing_more(method, model, y):
    """``complete`` of a method whose dense output needs no evaluation."""


def drive(
    parameters: type, order: float, more: Callable = nothing_more, end: int = STEP_FLOOR, across: float = 1.0
) -> None:
    """Make a method adaptive that has ``attempt`` and ``interpolate``; parameters: fields as of ``Tolerances``.

    order: power of the step that its estimate goes with; more: its ``complete``; end: its ``dead_end``; across:
    its ``beyond``.
    """
    prepare.register(parameters)(_prepare)
    step.register(parameters)(_step)
    load_number.register(parameters)(no_limit)  # it is held by its error
    estimate_order.register(parameters)(lambda method: order)
    complete.register(parameters)(more)
    dead_end.register(parameters)(lambda method: end)
    beyond.register(parameters)(lambda method: across)


# The state, in blocks


@jit
def keep(y, block, n):
    """The state, accelerations included, into the three blocks from ``block`` on."""
    for j in range(n):
        y[block + j] = y[POSITION + j]
        y[block + STATE + j] = y[VELOCITY + j]
        y[block + 2 * STATE + j] = y[ACCELERATION + j]


@jit
def bring_back(y, block, n):
    """The state from the three blocks from ``block`` on."""
    for j in range(n):
        y[POSITION + j] = y[block + j]
        y[VELOCITY + j] = y[block + STATE + j]
        y[ACCELERATION + j] = y[block + 2 * STATE + j]


@jit
def begin_where_it_ended(y, n):
    """START of the next step from END of the last."""
    for j in range(n):
        y[START_Q + j] = y[END_Q + j]
        y[START_V + j] = y[END_V + j]
        y[START_A + j] = y[END_A + j]


# Errors


@jit
def fill_levers(model, y):
    """LEVER: 1 of lengths; of angles and axes the radius at which they are felt."""
    b = model.bearing
    own, shared = freedoms(model)
    middle = 0.5 * (b.R_o + b.R_i)
    of_shared = (
        1.0,
        1.0,
        b.R_o,
        middle,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        b.R_o,
        middle,
        b.R_i,
        b.R_o,
        middle,
        b.R_i,
    )
    of_roller = (1.0, middle, b.R_w, 1.0, b.R_w, b.R_w)
    for j in range(STATE):
        y[LEVER + j] = 0.0
    for k in range(shared):
        y[LEVER + shared_cell(k)] = of_shared[k]
    for i in range(own):
        for j in range(b.Z):
            y[LEVER + LANES + i * ROW + j] = of_roller[i]


@jit
def error_norm(method, error_q, error_v, y, n):
    """Errors of positions and velocities, in the blocks at ``error_q`` and ``error_v``, over the tolerance.

    Velocities are measured by the larger of those at START and in the state's block.
    """
    total = 0.0
    for j in range(n):
        lever = y[LEVER + j]
        v = lever * max(abs(y[START_V + j]), abs(y[VELOCITY + j]))
        e_q = lever * y[error_q + j] / method.atol_q
        e_v = lever * y[error_v + j] / (method.atol_v + method.rtol * v)
        total = add(total, e_q * e_q + e_v * e_v)
    return sqrt(total)


@jit
def past_jumps(error, h):
    """The error of an L-stable method, at most 1 in a step so short that only a jump of a force can be in its way.

    The force is then felt over all of the step and not over a part of it. Nothing moves by more than rounding
    meanwhile, and the impulse that it is out by is made good by the same dashpot before anything else moves: no
    dashpot relaxes within 1e-12 s (1e-11 s: 1e9 N s/m on 10 g).
    """
    return 1.0 if h <= SUDDEN and isfinite(error) and error > 1.0 else error


@jit
def size(method, q, v, y, n):
    """The same measure of any position and velocity, in the blocks at ``q`` and ``v``; velocities by START's."""
    total = 0.0
    for j in range(n):
        lever = y[LEVER + j]
        e_q = lever * y[q + j] / method.atol_q
        e_v = lever * y[v + j] / (method.atol_v + method.rtol * lever * abs(y[START_V + j]))
        total = add(total, e_q * e_q + e_v * e_v)
    return sqrt(total)


# Lengths of steps


@jit
def first_step(method, model, t, y, n):
    """Length (s) of the first step from the state at START: an Euler step's worth of what changes."""
    moving = size(method, START_V, START_A, y, n)
    h = 1e-2 * size(method, START_Q, START_V, y, n) / moving if moving > 0.0 else method.longest
    h = min(max(h, 1e-3 * method.longest), method.longest)
    for j in range(n):
        y[POSITION + j] = y[START_Q + j] + h * y[START_V + j]
        y[VELOCITY + j] = y[START_V + j] + h * y[START_A + j]
    accelerations(model, t + h, y)
    y[EVALUATED] += 2.0
    for j in range(n):
        y[SLOPES + j] = y[START_A + j] * h
        y[SLOPES + STATE + j] = y[ACCELERATION + j] - y[START_A + j]
    bring_back(y, START_Q, n)
    accelerations(model, t, y)
    bent = size(method, SLOPES, SLOPES + STATE, y, n) / h
    steepest = max(bent, moving)
    return min(100.0 * h, (1e-2 / steepest) ** (1.0 / estimate_order(method)) if steepest > 0.0 else inf)


@jit
def shrunk(method, error):
    """Factor for a refused step's length; a state that is not finite says nothing of how far it was too long."""
    return max(LEAST, SAFETY * error ** (-1.0 / estimate_order(method))) if isfinite(error) else LEAST


@jit
def grown(method, error, before):
    """Factor for the next step's length, from the error of this one and of the one ``before``."""
    k = estimate_order(method)
    return min(MOST, max(LEAST, SAFETY * max(error, SMALL_ERROR) ** (-0.7 / k) * before ** (0.4 / k)))


@jit
def fitted(h, left):
    """A step of about ``h`` (s) that ends on a stop ``left`` (s) ahead, or leaves at least as much as it takes."""
    if h >= left:
        return left
    return 0.5 * left if 2.0 * h > left else h


# Steps


@jit
def hop(method, model, y, n):
    """From just before a jump to just after it; the step taken last keeps its length."""
    t, weight = y[T_END] + 2.0 * HOP, beyond(method)
    for j in range(n):
        y[POSITION + j] = y[END_Q + j] + 2.0 * HOP * y[END_V + j]
        y[VELOCITY + j] = y[END_V + j] + 2.0 * HOP * y[END_A + j]
    accelerations(model, t, y)
    for j in range(n):
        mean = y[END_A + j] + 0.5 * weight * (y[ACCELERATION + j] - y[END_A + j])
        y[VELOCITY + j] = y[END_V + j] + 2.0 * HOP * mean
    accelerations(model, t, y)
    y[EVALUATED] += 2.0
    y[T_END] = t


@jit
def stride(method, model, y, n):
    """Attempt steps from END until one is accepted, or the floor is reached; returns the attempts."""
    t = y[T_END]
    begin_where_it_ended(y, n)
    wanted = min(y[H_NEXT], method.longest)
    h = fitted(wanted, y[NEXT_STOP] - t - 0.5 * HOP)
    floor = max(FLOOR, ROUNDINGS * abs(t))
    error = attempt(method, model, t, h, y)
    tries = 1
    while not error <= 1.0:
        y[REFUSED] += 1.0
        h *= shrunk(method, error)
        wanted = 0.0
        if h < floor:
            y[FAILED] = dead_end(method)
            return tries
        error = attempt(method, model, t, h, y)
        tries += 1
    factor = grown(method, error, y[LAST_ERROR])
    y[H_NEXT] = max(h * (factor if tries == 1 else min(factor, 1.0)), wanted if h < wanted else 0.0)
    y[LAST_ERROR] = max(error, SMALL_ERROR)
    y[T_START], y[T_END], y[H_TAKEN] = t, t + h, h
    y[DENSE] = 0.0
    y[TAKEN] += 1.0
    return tries


@jit
def go_on(method, model, y):
    """One accepted step, or the hop over a jump; returns the attempts made."""
    n = width(model)
    tries = 1
    if y[NEXT_STOP] - y[T_END] <= HOP:
        hop(method, model, y, n)
    else:
        tries = stride(method, model, y, n)
        if y[FAILED] != FINE:
            return tries
    keep(y, END_Q, n)
    keep_extremes(model, y)
    y[NEXT_STOP] = next_cusp(model, y[T_END], y)
    return tries


@jit
def show(method, model, t, y):
    """The state at a recorded instant ``t`` (s) within the step taken last, contacts included."""
    n = width(model)
    part = (t - y[T_START]) / y[H_TAKEN] if y[H_TAKEN] > 0.0 else 1.0
    if abs(t - y[T_END]) <= ON_TIME * method.h:
        bring_back(y, END_Q, n)
    else:
        if y[DENSE] == 0.0:
            complete(method, model, y)
            y[DENSE] = 1.0
        interpolate(method, part, y[H_TAKEN], y, n)
    accelerations(model, t, y)
    y[EVALUATED] += 1.0


def _prepare(method, model, t, y):
    """``prepare`` of every adaptive method."""
    n = width(model)
    fill_levers(model, y)
    y[T_START], y[T_END], y[H_TAKEN], y[DENSE], y[LAST_ERROR] = t, t, 0.0, 0.0, 1.0
    y[FAILED] = FINE
    keep(y, START_Q, n)
    y[H_NEXT] = min(first_step(method, model, t, y, n), method.longest)
    keep(y, END_Q, n)
    y[NEXT_STOP] = next_cusp(model, t, y)


def _step(method, model, t, y):
    """``step`` of every adaptive method: up to the recorded instant or past it, then back by dense output."""
    until = t + method.h
    tries = 0
    while y[FAILED] == FINE and y[T_END] < until - ON_TIME * method.h:
        tries += go_on(method, model, y)
        if tries > MOST_TRIES and y[FAILED] == FINE:
            y[FAILED] = STALLED
    if y[FAILED] == FINE:
        show(method, model, until, y)
