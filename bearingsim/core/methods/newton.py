"""Equation of an implicit step, solved by a semismooth Newton method with arrow matrices (``methods/arrow.py``):

    x = B + w f(t, q + alpha x, v + beta x),   S = I - w (beta A_v + alpha A_q),   S step = -(x - B - w f)

x: unknown accelerations (UNKNOWN); q, v: constant parts of the state (BASE_Q, BASE_V); B: OFFSET; w, alpha, beta:
see ``Equation``. At a kink the exact derivatives of one side are used. Source: Qi and Sun, A nonsmooth version of
Newton's method, Math. Programming 58 (1993).

Newton steps are not damped. When a contact closes the force has a kink, or with a dashpot a jump, across which the
iteration may oscillate; if it does not converge, the step is too long. (Neither a line search nor, at a jump,
using the fraction of the jump that satisfies the equation was an improvement: docs/evidence/methods.md.)
"""

from math import isfinite, sqrt
from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import LENGTH_SCALE, METHOD_STATES, START_V
from bearingsim.core.methods.arrow import assemble_system, factorise, roller_lanes, solve
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, linearise
from bearingsim.core.sums import sum_addends

BASE_Q, BASE_V, OFFSET, UNKNOWN, NEWTON_STEP, RESIDUAL = lay.states(
    METHOD_STATES, "m, m/s, m/s^2, m/s^2, m/s^2, m/s^2", "backward-euler generalized-alpha", "step"
)
FREE_BLOCKS = RESIDUAL + lay.STATE  # first block that an implicit method may declare for itself

MAX_ITERATIONS = 15
STEP_TOLERANCE = 1e-2  # norm of the Newton step, over the tolerance, below which the iteration has converged
ROUNDING = 1e-12  # relative rounding error of positions and of their changes, with a margin


class Equation(NamedTuple):
    """Equation of a step.

    t: time at which the forces are evaluated (s); alpha (s^2), beta (s): coefficients of x in positions and
    velocities; weight: w (1).
    """

    t: float
    alpha: float
    beta: float
    weight: float


@jit
def step_norm(tolerance, equation, y, n):
    """Return the norm, over the tolerance, of the changes of positions and velocities by the Newton step."""
    alpha, beta = equation.alpha, equation.beta
    for j in range(n):
        lever = y[LENGTH_SCALE + j]
        q, v = abs(y[lay.POSITION + j]), max(abs(y[START_V + j]), abs(y[lay.VELOCITY + j]))
        x = abs(y[UNKNOWN + j])
        scale_q = lever * alpha / (tolerance.atol_q + ROUNDING * lever * (q + alpha * x))
        scale_v = lever * beta / (tolerance.atol_v + lever * (tolerance.rtol * v + ROUNDING * beta * x))
        y[lay.ADDENDS + j] = y[NEWTON_STEP + j] * y[NEWTON_STEP + j] * (scale_q * scale_q + scale_v * scale_v)
    return sqrt(sum_addends(y, n))


@jit
def set_state(equation, y, n):
    """Set the state that belongs to UNKNOWN."""
    for j in range(n):
        y[lay.POSITION + j] = y[BASE_Q + j] + equation.alpha * y[UNKNOWN + j]
        y[lay.VELOCITY + j] = y[BASE_V + j] + equation.beta * y[UNKNOWN + j]


@jit
def evaluate_residual(model, equation, y, n):
    """Store the residual x - B - w f at UNKNOWN in RESIDUAL."""
    set_state(equation, y, n)
    accelerations(model, equation.t, y)
    y[lay.EVALUATIONS] += 1.0
    for j in range(n):
        y[RESIDUAL + j] = y[UNKNOWN + j] - y[OFFSET + j] - equation.weight * y[lay.ACCELERATION + j]


@jit
def factor_jacobian(model, equation, y):
    """Factor S at the state of the model's last evaluation."""
    linearise(model, equation.t, y)
    assemble_system(model, equation.weight * equation.alpha, equation.weight * equation.beta, y)
    factorise(model, y)
    y[lay.NEWTON_ITERATIONS] += 1.0


@jit
def store_worst_body(model, y):
    """Set FAILED_BODY to the roller with the largest component of the last Newton step;
    -1: ring or cage."""
    per_roller, _ = degrees_of_freedom(model)
    lanes = roller_lanes(model)
    worst, body = 0.0, -1
    for j in range(lay.FIRST_LANE):
        worst = max(worst, y[LENGTH_SCALE + j] * abs(y[NEWTON_STEP + j]))
    for i in range(per_roller):
        for j in range(lanes):
            step = y[LENGTH_SCALE + lay.FIRST_LANE + i * lay.ROW + j] * abs(
                y[NEWTON_STEP + lay.FIRST_LANE + i * lay.ROW + j]
            )
            if step > worst:
                worst, body = step, j
    y[lay.FAILED_BODY] = body


@jit
def solve_step(tolerance, model, equation, y, n):
    """Solve the equation from the initial guess in UNKNOWN; return True if the iteration has converged.

    tolerance: a ``Tolerances``. BASE_Q, BASE_V, OFFSET and START must be set. Stores x in UNKNOWN, its positions
    and velocities in the state, and the factors of S in SYSTEM. The contacts are those of the iterate before the
    last Newton step, which is below STEP_TOLERANCE.
    """
    evaluate_residual(model, equation, y, n)
    for _ in range(MAX_ITERATIONS):
        factor_jacobian(model, equation, y)
        for j in range(n):
            y[NEWTON_STEP + j] = -y[RESIDUAL + j]
        solve(model, NEWTON_STEP, y)
        norm = step_norm(tolerance, equation, y, n)
        if not isfinite(norm):
            break
        for j in range(n):
            y[UNKNOWN + j] += y[NEWTON_STEP + j]
        if norm <= STEP_TOLERANCE:
            set_state(equation, y, n)
            return True
        evaluate_residual(model, equation, y, n)
    store_worst_body(model, y)
    return False
