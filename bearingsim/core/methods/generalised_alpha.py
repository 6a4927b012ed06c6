"""Generalised-alpha method, second order, unconditionally stable on linear problems, with adjustable
high-frequency damping.

    (1 - a_m) a1 + a_m a = f at (1 - a_f) times the end of the step plus a_f times its start
    v1 = v + h ((1 - gamma) a + gamma a1),   q1 = q + h v + h^2 ((1/2 - beta) a + beta a1)
    gamma = 1/2 - a_m + a_f,   beta = (1 - a_m + a_f)^2/4

Source: Chung and Hulbert, J. Appl. Mech. 60 (1993): a_m = (2 rho - 1)/(rho + 1), a_f = rho/(rho + 1), where rho is
the spectral radius at infinite frequency. Motion of high frequency thus decays only by the factor rho per step;
the error of a stiff dashpot in one step is multiplied by -rho in the next.

For comparison with multibody codes. The method's own a is stored separately from the state and differs from the
acceleration f, which is recorded.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import START_Q, START_V, fill_length_scales, restore_state, save_state
from bearingsim.core.methods.interface import MethodKind, Tolerances, no_limit, prepare, stability_ratio, step
from bearingsim.core.methods.newton import BASE_Q, BASE_V, FREE_BLOCKS, OFFSET, UNKNOWN, Equation, solve_step
from bearingsim.core.models.interface import accelerations, state_width
from bearingsim.core.outcomes import NEWTON_FAILED

RHO = 0.8  # spectral radius at infinite frequency
A_M, A_F = (2.0 * RHO - 1.0) / (RHO + 1.0), RHO / (RHO + 1.0)
"""Weights of the start of a step in accelerations and forces."""
GAMMA, BETA = 0.5 - A_M + A_F, 0.25 * (1.0 - A_M + A_F) ** 2
(METHOD_ACCELERATION,) = lay.states(FREE_BLOCKS, "m/s^2", "generalized-alpha", "step")  # the method's own


class GeneralisedAlpha(NamedTuple):
    """Parameters. h: step, s."""

    h: float


@jit
def newton_tolerances(h):
    """Return the tolerances of Newton's method: 1e-10 of the velocities, or the rounding errors of the
    smallest."""
    return Tolerances(h, 1e-10, 1e-15, 1e-12, h)


@jit
def make_equation(method, t, y, n):
    """Return the equation of the step for a1, with a as the initial guess."""
    h = method.h
    fraction, weight = 1.0 - A_F, 1.0 / (1.0 - A_M)
    for j in range(n):
        a = y[METHOD_ACCELERATION + j]
        y[BASE_V + j] = y[START_V + j] + fraction * h * (1.0 - GAMMA) * a
        y[BASE_Q + j] = y[START_Q + j] + fraction * h * (y[START_V + j] + h * (0.5 - BETA) * a)
        y[OFFSET + j] = -A_M * weight * a
        y[UNKNOWN + j] = a
    return Equation(t + fraction * h, fraction * h * h * BETA, fraction * h * GAMMA, weight)


@jit
def finish_step(method, y, n):
    """Set the state at the end of the step, and the method's acceleration a to a1."""
    h = method.h
    for j in range(n):
        a, a_1, v = y[METHOD_ACCELERATION + j], y[UNKNOWN + j], y[START_V + j]
        y[lay.VELOCITY + j] = v + h * ((1.0 - GAMMA) * a + GAMMA * a_1)
        y[lay.POSITION + j] = y[START_Q + j] + h * (v + h * ((0.5 - BETA) * a + BETA * a_1))
        y[METHOD_ACCELERATION + j] = a_1


def _prepare(method, model, t, y):
    fill_length_scales(model, y)
    for j in range(state_width(model)):
        y[METHOD_ACCELERATION + j] = y[lay.ACCELERATION + j]


def _step(method, model, t, y):
    if y[lay.FAILED] != 0.0:
        return
    n = state_width(model)
    save_state(y, START_Q, n)
    if not solve_step(newton_tolerances(method.h), model, make_equation(method, t, y, n), y, n):
        y[lay.FAILED] = NEWTON_FAILED
        restore_state(y, START_Q, n)
        return
    finish_step(method, y, n)
    accelerations(model, t + method.h, y)
    y[lay.EVALUATIONS] += 1.0


prepare.register(GeneralisedAlpha)(_prepare)
step.register(GeneralisedAlpha)(_step)
stability_ratio.register(GeneralisedAlpha)(no_limit)

# the force is evaluated at 1 - a_f of a step, the midpoint of a step that begins at 1/2 - a_f
KIND = MethodKind(GeneralisedAlpha, evaluations=4, fraction=1.0, per_period=20, cusp=0.5 - A_F, order=2, lag=0.0)
