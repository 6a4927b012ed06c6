"""Not an integrator: the balance found anew at every step, for models without inertia."""

from typing import NamedTuple

from bearingsim.core.layout import ACCELERATION, POSITION, VELOCITY, X, Y
from bearingsim.core.methods.interface import load_number, step
from bearingsim.core.models.interface import rest


class Equilibrium(NamedTuple):
    """h: time between balances, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    v_x, v_y = y[VELOCITY + X], y[VELOCITY + Y]
    y[POSITION + X] += method.h * v_x  # a first guess
    y[POSITION + Y] += method.h * v_y
    rest(model, t + method.h, y)
    y[ACCELERATION + X] = (y[VELOCITY + X] - v_x) / method.h
    y[ACCELERATION + Y] = (y[VELOCITY + Y] - v_y) / method.h


@load_number.register(Equilibrium)
def _load_number(method, K, C):
    return 0.0
