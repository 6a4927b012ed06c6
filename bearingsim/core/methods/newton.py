"""The equation of an implicit step, solved by a semismooth Newton method with the arrow (``core/arrow.py``):

    x = B + w f(t, q + alpha x, v + beta x),   S = I - w (beta A_v + alpha A_q),   S step = -(x - B - w f)

x: accelerations sought; the exact derivatives on the side that an iterate stands on. Source: Qi and Sun, A
nonsmooth version of Newton's method, Math. Programming 58 (1993).

The line search looks at g(s) = -<step, S^-1 r(x + s step)>/<step, step>: from 1 to 0 where r is linear. Full steps
are taken unless g shows that a kink was leapt (g < -1/2): a contact that closes. Then the root of g is bracketed
and halved; it is where the force of a steep contact sets in.

Where the force jumps, as a dashpot's does at touch-down, r can leap over zero: then no x solves the equation, the
bracket shrinks to nothing, and x is touch-down itself, where any part of the jump may balance it (Filippov's
solution). It is taken if some part balances r in every other direction too; else the step is too long for what
happens in it.
"""

from math import isfinite, sqrt
from typing import NamedTuple

from bearingsim.core.arrow import combine, factor, rollers_wide, solve
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
from bearingsim.core.methods.adaptive import LEVER, SLOPES, START_A, START_V
from bearingsim.core.models.interface import accelerations, freedoms, linearise

BASE_Q, BASE_V, OFFSET, SOUGHT, FROM, NEWTON, RESIDUAL, NATURAL, OTHER = (SLOPES + n * STATE for n in range(9))

MOST_ITERATIONS = 15
CLOSE = 1e-2  # of the tolerance: a Newton step so short is the last one, and is taken
LEAPT, ROOT = -0.5, 0.1  # of g: a kink was leapt; near enough to the root
HALVINGS = 60  # until a bracket is as narrow as rounding allows
ROUNDED = 1e-12  # of a position, and of what x moves: what rounding leaves uncertain, and some more
BALANCED = 0.1  # of the tolerance: what may be left at a jump


class Equation(NamedTuple):
    """t: s; alpha (s^2), beta (s): what positions and velocities take of x; weight: w."""

    t: float
    alpha: float
    beta: float
    weight: float


@jit
def product(tolerance, equation, one, other, y, n):
    """<a, b> of two blocks of accelerations: what they do to positions and velocities, over the tolerance."""
    alpha, beta = equation.alpha, equation.beta
    total = 0.0
    for j in range(n):
        lever = y[LEVER + j]
        far, fast = abs(y[POSITION + j]), max(abs(y[START_V + j]), abs(y[VELOCITY + j]))
        pushed = abs(y[SOUGHT + j])
        of_q = lever * alpha / (tolerance.atol_q + ROUNDED * lever * (far + alpha * pushed))
        of_v = lever * beta / (tolerance.atol_v + lever * (tolerance.rtol * fast + ROUNDED * beta * pushed))
        total = add(total, y[one + j] * y[other + j] * (of_q * of_q + of_v * of_v))
    return total


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
def divide(model, source, target, y, n):
    """``target`` = S^-1 ``source``."""
    for j in range(n):
        y[target + j] = y[source + j]
    solve(model, target, y)


@jit
def go(model, equation, part, y, n):
    """SOUGHT to FROM + ``part`` NEWTON, evaluated."""
    for j in range(n):
        y[SOUGHT + j] = y[FROM + j] + part * y[NEWTON + j]
    evaluate(model, equation, y, n)


@jit
def remaining(tolerance, model, equation, part, y, n):
    """g at ``part`` of the Newton step."""
    go(model, equation, part, y, n)
    divide(model, RESIDUAL, NATURAL, y, n)
    return -product(tolerance, equation, NEWTON, NATURAL, y, n) / product(
        tolerance, equation, NEWTON, NEWTON, y, n
    )


@jit
def search(tolerance, model, equation, y, n):
    """Go along the Newton step; (0, 0), or the two sides of a jump that was met."""
    left = remaining(tolerance, model, equation, 1.0, y, n)
    if not left < LEAPT:
        return 0.0, 0.0
    near, far = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        if middle in (near, far):
            break
        left = remaining(tolerance, model, equation, middle, y, n)
        if abs(left) <= ROOT:
            return 0.0, 0.0
        if left > 0.0:
            near = middle
        else:
            far = middle
    return near, far


@jit
def balance(tolerance, model, equation, near, far, y, n):
    """Whether a part of the jump between two places on the Newton step balances r; if so, SOUGHT is there.

    Of its sides that one is taken from which the contact is seen closed: where the step would lead that knows
    only the last accelerations.
    """
    beyond = 0.0
    for j in range(n):
        beyond = add(beyond, y[NEWTON + j] * (y[START_A + j] - y[FROM + j]) * y[LEVER + j] * y[LEVER + j])
    open_side, closed_side = (near, far) if beyond > 0.0 else (far, near)
    go(model, equation, open_side, y, n)
    for j in range(n):
        y[OTHER + j] = y[RESIDUAL + j]
    go(model, equation, closed_side, y, n)
    derive(model, equation, y)
    solve(model, OTHER, y)
    divide(model, RESIDUAL, NATURAL, y, n)
    for j in range(n):
        y[OTHER + j] -= y[NATURAL + j]
    jump = product(tolerance, equation, OTHER, OTHER, y, n)
    part = -product(tolerance, equation, NATURAL, OTHER, y, n) / max(jump, 1e-300)
    part = min(max(part, 0.0), 1.0)
    for j in range(n):
        y[NATURAL + j] += part * y[OTHER + j]
    return sqrt(product(tolerance, equation, NATURAL, NATURAL, y, n)) <= BALANCED


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
        divide(model, RESIDUAL, NEWTON, y, n)
        for j in range(n):
            y[NEWTON + j] = -y[NEWTON + j]
            y[FROM + j] = y[SOUGHT + j]
        length = sqrt(product(tolerance, equation, NEWTON, NEWTON, y, n))
        if not isfinite(length):
            break
        if length <= CLOSE:
            for j in range(n):
                y[SOUGHT + j] += y[NEWTON + j]
            place(equation, y, n)
            return True
        near, far = search(tolerance, model, equation, y, n)
        if far > 0.0:
            if balance(tolerance, model, equation, near, far, y, n):
                return True
            break
    blame(model, y)
    return False
