"""Leapfrog: half a drift, a kick, half a drift."""

from typing import NamedTuple

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, POSITION, VELOCITY
from bearingsim.core.methods.interface import MethodKind, as_it_is, load_number, prepare, step
from bearingsim.core.models.interface import accelerations, width


class Leapfrog(NamedTuple):
    """h: step, s."""

    h: float


@jit
def drift(h, y, n):
    for j in range(n):
        y[POSITION + j] += h * y[VELOCITY + j]


@jit
def kick(h, y, n):
    for j in range(n):
        y[VELOCITY + j] += h * y[ACCELERATION + j]


prepare.register(Leapfrog)(as_it_is)


@step.register(Leapfrog)
def _step(method, model, t, y):
    n = width(model)
    drift(0.5 * method.h, y, n)
    accelerations(model, t + 0.5 * method.h, y)
    kick(method.h, y, n)
    drift(0.5 * method.h, y, n)
    accelerations(model, t + method.h, y)


@load_number.register(Leapfrog)
def _load_number(method, K, C):
    return method.h * (0.25 * method.h * K + 0.5 * C)


KIND = MethodKind(Leapfrog, evaluations=2, fraction=0.1, per_period=100, cusp=0.5)
