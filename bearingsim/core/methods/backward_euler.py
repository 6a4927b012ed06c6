"""Backward Euler, first order, L-stable, solved by Newton's method (``newton.py``), with adaptive steps.

    v1 = v + h a1,   q1 = q + h v1,   a1 = f(t + h, q1, v1)

The error of a step is h/2 (v1 - v, a1 - a) to leading order. The estimate is this error multiplied by (I - h
J)^-1, where J is the Jacobian of (v, f). This filter is that of the method itself: motion too fast to be resolved
decays within the step, and its jumps do not increase the estimate. Therefore the tolerance of velocities need not
resolve load/c, the velocity of a dashpot c that supports the load; 1e-3 of the velocities of interest is
sufficient. Source: Shampine and Baca, Math. Comp. 43 (1984); Hairer and Wanner, Solving ODEs II, sec. IV.8. The
method also works with dashpots of 1e9 N s/m, where others fail, and damps all motion that it does not resolve.
Recorded states are interpolated linearly between the ends of a step, with an error of second order in the step, as
that of the step itself.
"""

from math import inf
from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import (
    END_Q,
    END_V,
    START_A,
    START_Q,
    START_V,
    error_norm,
    limit_jump_error,
    register_adaptive,
)
from bearingsim.core.methods.arrow import multiply, solve
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.methods.newton import BASE_Q, BASE_V, FREE_BLOCKS, OFFSET, UNKNOWN, Equation, solve_step
from bearingsim.core.models.interface import state_width
from bearingsim.core.outcomes import NEWTON_FAILED

ERROR_Q, ERROR_V = lay.states(FREE_BLOCKS, "m, m/s", "backward-euler", "step")


class BackwardEuler(NamedTuple):
    """Parameters, as in ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@jit
def set_equation(h, y, n):
    """Set the equation of the step (``newton.Equation``), with the acceleration at its start as the initial
    guess."""
    for j in range(n):
        y[BASE_Q + j] = y[START_Q + j] + h * y[START_V + j]
        y[BASE_V + j] = y[START_V + j]
        y[OFFSET + j] = 0.0
        y[UNKNOWN + j] = y[START_A + j]


@jit
def estimate_error(model, h, y, n):
    """Store (I - h J)^-1 h/2 (v1 - v, a1 - a) in ERROR_Q and ERROR_V, with the factored S of
    ``newton.solve_step``."""
    for j in range(n):
        y[ERROR_Q + j] = 0.5 * h * (y[lay.VELOCITY + j] - y[START_V + j])
        y[ERROR_V + j] = 0.0
    multiply(model, lay.POSITION_JACOBIAN, ERROR_Q, ERROR_V, y)
    for j in range(n):
        y[ERROR_V + j] = 0.5 * h * (y[lay.ACCELERATION + j] - y[START_A + j]) + h * y[ERROR_V + j]
    solve(model, ERROR_V, y)
    for j in range(n):
        y[ERROR_Q + j] += h * y[ERROR_V + j]


@attempt.register(BackwardEuler)
def _attempt(method, model, t, h, y):
    n = state_width(model)
    set_equation(h, y, n)
    if not solve_step(method, model, Equation(t + h, h * h, h, 1.0), y, n):
        return inf
    for j in range(n):
        y[lay.ACCELERATION + j] = y[UNKNOWN + j]
    estimate_error(model, h, y, n)
    return limit_jump_error(error_norm(method, ERROR_Q, ERROR_V, y, n), h)


@interpolate.register(BackwardEuler)
def _interpolate(method, fraction, h, y, n):
    for j in range(n):
        y[lay.POSITION + j] = y[START_Q + j] + fraction * (y[END_Q + j] - y[START_Q + j])
        y[lay.VELOCITY + j] = y[START_V + j] + fraction * (y[END_V + j] - y[START_V + j])


register_adaptive(BackwardEuler, order=2.0, failure=NEWTON_FAILED, weight=0.0)

KIND = MethodKind(BackwardEuler, evaluations=3, fraction=1.0, per_period=1, cusp=1 / 2, order=1, lag=0.0)
