"""Backward Euler, first order, L-stable, by Newton's method (``newton.py``); steps by an estimate of the error.

    v1 = v + h a1,   q1 = q + h v1,   a1 = f(t + h, q1, v1)

The error of a step is h/2 (v1 - v, a1 - a) to leading order. It is passed through (I - h J)^-1, J the derivative
of (v, f), as the method itself passes on what it is given: what is too fast to follow decays within the step, and
its jumps are no errors. Source: Shampine and Baca, Math. Comp. 43 (1984); Hairer and Wanner, Solving ODEs II,
sec. IV.8. So velocities need no tolerance as fine as that of a dashpot's force (load/c): 1e-3 of those that matter
will do.

It holds where others fail, with dashpots of 1e9 N s/m, and damps whatever it does not follow. Recorded instants
lie on the straight line between two ends, whose error is that of the step.
"""

from math import inf
from typing import NamedTuple

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, BY_POSITION, POSITION, STATE, VELOCITY
from bearingsim.core.methods.adaptive import (
    END_Q,
    END_V,
    START_A,
    START_Q,
    START_V,
    drive,
    error_norm,
    past_jumps,
)
from bearingsim.core.methods.arrow import multiply, solve
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.methods.newton import BASE_Q, BASE_V, FREE, OFFSET, SOUGHT, Equation, find
from bearingsim.core.models.interface import width
from bearingsim.core.outcomes import NEWTON_STALLED

ERROR_Q, ERROR_V = FREE, FREE + STATE


class BackwardEuler(NamedTuple):
    """See ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@jit
def pose(h, y, n):
    """The step's equation, and its guess: the acceleration stays."""
    for j in range(n):
        y[BASE_Q + j] = y[START_Q + j] + h * y[START_V + j]
        y[BASE_V + j] = y[START_V + j]
        y[OFFSET + j] = 0.0
        y[SOUGHT + j] = y[START_A + j]


@jit
def estimate(model, h, y, n):
    """(I - h J)^-1 h/2 (v1 - v, a1 - a) into ERROR_Q and ERROR_V; S is that of the step's end."""
    for j in range(n):
        y[ERROR_Q + j] = 0.5 * h * (y[VELOCITY + j] - y[START_V + j])
        y[ERROR_V + j] = 0.0
    multiply(model, BY_POSITION, ERROR_Q, ERROR_V, y)
    for j in range(n):
        y[ERROR_V + j] = 0.5 * h * (y[ACCELERATION + j] - y[START_A + j]) + h * y[ERROR_V + j]
    solve(model, ERROR_V, y)
    for j in range(n):
        y[ERROR_Q + j] += h * y[ERROR_V + j]


@attempt.register(BackwardEuler)
def _attempt(method, model, t, h, y):
    n = width(model)
    pose(h, y, n)
    if not find(method, model, Equation(t + h, h * h, h, 1.0), y, n):
        return inf
    for j in range(n):
        y[ACCELERATION + j] = y[SOUGHT + j]
    estimate(model, h, y, n)
    return past_jumps(error_norm(method, ERROR_Q, ERROR_V, y, n), h)


@interpolate.register(BackwardEuler)
def _interpolate(method, part, h, y, n):
    for j in range(n):
        y[POSITION + j] = y[START_Q + j] + part * (y[END_Q + j] - y[START_Q + j])
        y[VELOCITY + j] = y[START_V + j] + part * (y[END_V + j] - y[START_V + j])


drive(BackwardEuler, order=2.0, end=NEWTON_STALLED, across=0.0)

KIND = MethodKind(
    BackwardEuler,
    evaluations=3,
    fraction=1.0,
    per_period=1,
    cusp=1 / 2,
    order=1,
    lag=0.0,
)
