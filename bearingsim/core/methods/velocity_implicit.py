"""Euler's method, implicit in the velocity only: one linear solve a step, positions after (first order).

    (I - h A_v)(v1 - v) = h f(t, q, v),   q1 = q + h v1

A comparison: real-time engines take it for its one evaluation. Heavy damping no longer limits the step, stiffness
does: q'' = -K q - C q' grows from h^2 K = 4 + 2 h C on. With heavy dashpots its forces are wrong all the same,
since f is taken where the dashpot was.
"""

from typing import NamedTuple

from bearingsim.core.layout import ACCELERATION, EVALUATED, POSITION, VELOCITY
from bearingsim.core.methods.adaptive import SLOPES
from bearingsim.core.methods.arrow import combine, factor, solve
from bearingsim.core.methods.interface import MethodKind, as_it_is, load_number, prepare, step
from bearingsim.core.models.interface import accelerations, linearise, width

CHANGE = SLOPES  # of the velocities


class VelocityImplicitEuler(NamedTuple):
    """h: step, s."""

    h: float


prepare.register(VelocityImplicitEuler)(as_it_is)


@step.register(VelocityImplicitEuler)
def _step(method, model, t, y):
    h, n = method.h, width(model)
    linearise(model, t, y)
    combine(model, 0.0, h, y)
    factor(model, y)
    for j in range(n):
        y[CHANGE + j] = h * y[ACCELERATION + j]
    solve(model, CHANGE, y)
    for j in range(n):
        y[VELOCITY + j] += y[CHANGE + j]
        y[POSITION + j] += h * y[VELOCITY + j]
    accelerations(model, t + h, y)
    y[EVALUATED] += 1.0


@load_number.register(VelocityImplicitEuler)
def _load_number(method, K, C):
    h = method.h
    return h * h * K / (4.0 + 2.0 * h * C)


KIND = MethodKind(
    VelocityImplicitEuler,
    evaluations=1,
    fraction=0.25,
    per_period=40,
    cusp=1 / 2,
    order=1,
    lag=0.0,
)
