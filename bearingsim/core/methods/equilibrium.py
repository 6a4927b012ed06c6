"""Not an integrator: the balance found anew at every step, for models without inertia."""

from typing import NamedTuple

from bearingsim.core.layout import A, V, X, Y
from bearingsim.core.methods.interface import load_number, step
from bearingsim.core.models.interface import rest


class Equilibrium(NamedTuple):
    """h: time between balances, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    v_x, v_y = y[V + X], y[V + Y]
    rest(model, t + method.h, y)
    y[A + X] = (y[V + X] - v_x) / method.h
    y[A + Y] = (y[V + Y] - v_y) / method.h


@load_number.register(Equilibrium)
def _load_number(method, K, C):
    return 0.0
