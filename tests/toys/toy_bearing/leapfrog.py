"""Leapfrog: half a drift, a kick, half a drift."""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import MethodKind, no_preparation, prepare, stability_ratio, step
from bearingsim.core.models.interface import accelerations, state_width


class Leapfrog(NamedTuple):
    """h: step, s."""

    h: float


@jit
def drift(h, y, n):
    for j in range(n):
        y[lay.POSITION + j] += h * y[lay.VELOCITY + j]


@jit
def kick(h, y, n):
    for j in range(n):
        y[lay.VELOCITY + j] += h * y[lay.ACCELERATION + j]


prepare.register(Leapfrog)(no_preparation)


@step.register(Leapfrog)
def _step(method, model, t, y):
    n = state_width(model)
    drift(0.5 * method.h, y, n)
    accelerations(model, t + 0.5 * method.h, y)
    kick(method.h, y, n)
    drift(0.5 * method.h, y, n)
    accelerations(model, t + method.h, y)


@stability_ratio.register(Leapfrog)
def _stability_ratio(method, K, C):
    return method.h * (0.25 * method.h * K + 0.5 * C)


KIND = MethodKind(Leapfrog, evaluations=2, fraction=0.1, per_period=100, cusp=0.5)
