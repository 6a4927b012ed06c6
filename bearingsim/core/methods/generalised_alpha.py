"""Generalised-alpha, second order, stable at any step on linear motion, with chosen damping of what is too fast.

    (1 - a_m) a1 + a_m a = f at the weighted mean (1 - a_f) of the step's end and a_f of its start
    v1 = v + h ((1 - gamma) a + gamma a1),   q1 = q + h v + h^2 ((1/2 - beta) a + beta a1)
    gamma = 1/2 - a_m + a_f,   beta = (1 - a_m + a_f)^2/4

Source: Chung and Hulbert, J. Appl. Mech. 60 (1993): a_m = (2 rho - 1)/(rho + 1), a_f = rho/(rho + 1), rho the
factor per step of infinitely fast motion. Such motion is damped in part only: of what a dashpot holds in one step,
-rho is carried on to the next.

A comparison, as multibody codes have it: its a, kept beside the state, is not f of the state, which is recorded.
"""

from typing import NamedTuple

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, EVALUATED, FAILED, POSITION, VELOCITY
from bearingsim.core.methods.adaptive import START_Q, START_V, bring_back, fill_levers, keep
from bearingsim.core.methods.interface import MethodKind, Tolerances, load_number, no_limit, prepare, step
from bearingsim.core.methods.newton import BASE_Q, BASE_V, FREE, OFFSET, SOUGHT, Equation, find
from bearingsim.core.models.interface import accelerations, width
from bearingsim.core.outcomes import NEWTON_STALLED

RHO = 0.8  # per step, of infinitely fast motion
A_M, A_F = (2.0 * RHO - 1.0) / (RHO + 1.0), RHO / (RHO + 1.0)
"""The parts that the start of a step has in its balance."""
GAMMA, BETA = 0.5 - A_M + A_F, 0.25 * (1.0 - A_M + A_F) ** 2
KEPT = FREE  # a of the method


class GeneralisedAlpha(NamedTuple):
    """h: step, s."""

    h: float


@jit
def exactly(h):
    """To what Newton's method is driven: 1e-10 of the velocities, or rounding of the smallest ones."""
    return Tolerances(h, 1e-10, 1e-15, 1e-12, h)


@jit
def equation(method, t, y, n):
    """The step's equation for a1, its guess the last a."""
    h = method.h
    here, weight = 1.0 - A_F, 1.0 / (1.0 - A_M)
    for j in range(n):
        a = y[KEPT + j]
        y[BASE_V + j] = y[START_V + j] + here * h * (1.0 - GAMMA) * a
        y[BASE_Q + j] = y[START_Q + j] + here * h * (y[START_V + j] + h * (0.5 - BETA) * a)
        y[OFFSET + j] = -A_M * weight * a
        y[SOUGHT + j] = a
    return Equation(t + here * h, here * h * h * BETA, here * h * GAMMA, weight)


@jit
def finish(method, y, n):
    """The state at the step's end."""
    h = method.h
    for j in range(n):
        a, a_1, v = y[KEPT + j], y[SOUGHT + j], y[START_V + j]
        y[VELOCITY + j] = v + h * ((1.0 - GAMMA) * a + GAMMA * a_1)
        y[POSITION + j] = y[START_Q + j] + h * (v + h * ((0.5 - BETA) * a + BETA * a_1))
        y[KEPT + j] = a_1


def _prepare(method, model, t, y):
    fill_levers(model, y)
    for j in range(width(model)):
        y[KEPT + j] = y[ACCELERATION + j]


def _step(method, model, t, y):
    if y[FAILED] != 0.0:
        return
    n = width(model)
    keep(y, START_Q, n)
    if not find(exactly(method.h), model, equation(method, t, y, n), y, n):
        y[FAILED] = NEWTON_STALLED
        bring_back(y, START_Q, n)
        return
    finish(method, y, n)
    accelerations(model, t + method.h, y)
    y[EVALUATED] += 1.0


prepare.register(GeneralisedAlpha)(_prepare)
step.register(GeneralisedAlpha)(_step)
load_number.register(GeneralisedAlpha)(no_limit)

KIND = MethodKind(
    GeneralisedAlpha,
    evaluations=4,
    fraction=1.0,
    per_period=20,
    cusp=1 / 2,
    order=2,
    lag=0.0,
)
