"""Not an integrator: the balance found anew at every step, for models without inertia.

Velocity and acceleration at t are differences of the places at t - h, t and t + h. A pit's cusp makes the true
velocity jump, and samples of a jump have a wrong mean; differences of places add up to the way gone, so lines come
out right.
"""

from typing import NamedTuple

from bearingsim.core.layout import ACCELERATION, POSITION, VELOCITY, X, Y
from bearingsim.core.methods.interface import MethodKind, load_number, no_limit, step
from bearingsim.core.models.equilibrium import find_rest


class Equilibrium(NamedTuple):
    """h: time between balances, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    h = method.h
    find_rest(model, t, y)
    x_0, y_0 = y[POSITION + X], y[POSITION + Y]
    find_rest(model, t + 2.0 * h, y)
    x_2, y_2 = y[POSITION + X], y[POSITION + Y]
    find_rest(model, t + h, y)
    x_1, y_1 = y[POSITION + X], y[POSITION + Y]
    y[VELOCITY + X] = (x_2 - x_0) / (2.0 * h)
    y[VELOCITY + Y] = (y_2 - y_0) / (2.0 * h)
    y[ACCELERATION + X] = (x_2 - 2.0 * x_1 + x_0) / (h * h)
    y[ACCELERATION + Y] = (y_2 - 2.0 * y_1 + y_0) / (h * h)


load_number.register(Equilibrium)(no_limit)
KIND = MethodKind(Equilibrium, evaluations=3, fraction=1.0, per_period=1, cusp=1 / 2)
