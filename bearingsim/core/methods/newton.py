"""The equation of an implicit step, solved by a semismooth Newton method with the arrow (``methods/arrow.py``):

    x = B + w f(t, q + alpha x, v + beta x),   S = I - w (beta A_v + alpha A_q),   S step = -(x - B - w f)

x: accelerations sought; the exact derivatives on the side that an iterate stands on. Source: Qi and Sun, A
nonsmooth version of Newton's method, Math. Programming 58 (1993).

Full steps. Where a contact closes the force has a kink, where a dashpot meets it a jump, over which an iterate may
leap to and fro; then no solution is found and the step was too long for what happens in it. (A line search, and at
a jump that part of it which balances the rest, brought nothing: docs/methods.md.)
"""

from math import isfinite, sqrt
from typing import NamedTuple

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    ACCELERATION,
    EVALUATED,
    FAILED_BODY,
    ITERATED,
    LANES,
    POSITION,
    ROW,
    STATE,
    VELOCITY,
)
from bearingsim.core.methods.adaptive import LEVER, SLOPES, START_V
from bearingsim.core.methods.arrow import combine, factor, rollers_wide, solve
from bearingsim.core.models.interface import accelerations, freedoms, linearise

BASE_Q, BASE_V, OFFSET, SOUGHT, NEWTON, RESIDUAL, FREE = (SLOPES + n * STATE for n in range(7))
# from FREE on a method may keep its own

MOST_ITERATIONS = 15
CLOSE = 1e-2  # of the tolerance: a Newton step so short is the last one, and is taken
ROUNDED = 1e-12  # of a position, and of what x moves: what rounding leaves uncertain, and some more


class Equation(NamedTuple):
    """t: s; alpha (s^2), beta (s): what positions and velocities take of x; weight: w."""

    t: float
    alpha: float
    beta: float
    weight: float


@jit
def length(tolerance, equation, y, n):
    """How long the Newton step is: what it does to positions and velocities, over the tolerance."""
    alpha, beta = equation.alpha, equation.beta
    total = 0.0
    for j in range(n):
        lever = y[LEVER + j]
        far, fast = abs(y[POSITION + j]), max(abs(y[START_V + j]), abs(y[VELOCITY + j]))
        pushed = abs(y[SOUGHT + j])
        of_q = lever * alpha / (tolerance.atol_q + ROUNDED * lever * (far + alpha * pushed))
        of_v = lever * beta / (tolerance.atol_v + lever * (tolerance.rtol * fast + ROUNDED * beta * pushed))
        total = add(total, y[NEWTON + j] * y[NEWTON + j] * (of_q * of_q + of_v * of_v))
    return sqrt(total)


@jit
def place(equation, y, n):
    """The state that belongs to SOUGHT."""
    for j in range(n):
        y[POSITION + j] = y[BASE_Q + j] + equation.alpha * y[SOUGHT + j]
        y[VELOCITY + j] = y[BASE_V + j] + equation.beta * y[SOUGHT + j]


@jit
def evaluate(model, equation, y, n):
    """RESIDUAL r = x - B - w f at SOUGHT."""
    place(equation, y, n)
    accelerations(model, equation.t, y)
    y[EVALUATED] += 1.0
    for j in range(n):
        y[RESIDUAL + j] = y[SOUGHT + j] - y[OFFSET + j] - equation.weight * y[ACCELERATION + j]


@jit
def derive(model, equation, y):
    """Factor S where the model was evaluated last."""
    linearise(model, equation.t, y)
    combine(model, equation.weight * equation.alpha, equation.weight * equation.beta, y)
    factor(model, y)
    y[ITERATED] += 1.0


@jit
def blame(model, y):
    """FAILED_BODY: the roller of the largest step that Newton's method still asks for; -1: ring or cage."""
    own, _ = freedoms(model)
    lanes = rollers_wide(model)
    worst, body = 0.0, -1
    for j in range(LANES):
        worst = max(worst, y[LEVER + j] * abs(y[NEWTON + j]))
    for i in range(own):
        for j in range(lanes):
            asked = y[LEVER + LANES + i * ROW + j] * abs(y[NEWTON + LANES + i * ROW + j])
            if asked > worst:
                worst, body = asked, j
    y[FAILED_BODY] = body


@jit
def find(tolerance, model, equation, y, n):
    """Solve from the guess in SOUGHT; whether that was done.

    tolerance: a ``Tolerances``. BASE_Q, BASE_V, OFFSET and START are in place. Leaves x in SOUGHT, positions and
    velocities that belong to it, S factored; contacts are those of the last iterate, within CLOSE.
    """
    evaluate(model, equation, y, n)
    for _ in range(MOST_ITERATIONS):
        derive(model, equation, y)
        for j in range(n):
            y[NEWTON + j] = -y[RESIDUAL + j]
        solve(model, NEWTON, y)
        left = length(tolerance, equation, y, n)
        if not isfinite(left):
            break
        for j in range(n):
            y[SOUGHT + j] += y[NEWTON + j]
        if left <= CLOSE:
            place(equation, y, n)
            return True
        evaluate(model, equation, y, n)
    blame(model, y)
    return False
