"""Not an integrator: the balance found anew at every step, for models without inertia.

The velocity at t is the way between t - h/2 and t + h/2 over h. A pit's cusp makes the true velocity jump, and
samples of a jump give a wrong mean; differences of places add up to the way gone, so lines come out right.
"""

from typing import NamedTuple

from bearingsim.core.equilibrium import find_rest
from bearingsim.core.layout import ACCELERATION, POSITION, VELOCITY, X, Y
from bearingsim.core.methods.interface import MethodKind, load_number, step


class Equilibrium(NamedTuple):
    """h: time between balances, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    h, v_x, v_y = method.h, y[VELOCITY + X], y[VELOCITY + Y]
    find_rest(model, t + 0.5 * h, y)
    x_before, y_before = y[POSITION + X], y[POSITION + Y]
    find_rest(model, t + 1.5 * h, y)
    y[VELOCITY + X] = (y[POSITION + X] - x_before) / h
    y[VELOCITY + Y] = (y[POSITION + Y] - y_before) / h
    find_rest(model, t + h, y)
    y[ACCELERATION + X] = (y[VELOCITY + X] - v_x) / h
    y[ACCELERATION + Y] = (y[VELOCITY + Y] - v_y) / h


@load_number.register(Equilibrium)
def _load_number(method, K, C):
    return 0.0


KIND = MethodKind(Equilibrium, evaluations=3, fraction=1.0, per_period=1)
