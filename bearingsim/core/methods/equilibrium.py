"""Static equilibrium at every step, for models without inertia; no time integration.

Velocity and acceleration at t are differences of the positions at t - h, t and t + h. At a defect's cusp the true
velocity jumps, and samples of a jump have a wrong mean; differences of positions sum to the displacement, so the
amplitudes of lines are correct.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import MethodKind, no_limit, stability_ratio, step
from bearingsim.core.models.equilibrium import solve_equilibrium
from bearingsim.core.parts.bending import read_sensor


class Equilibrium(NamedTuple):
    """Parameters. h: time between equilibria, s."""

    h: float


@jit
def position_at(model, t, y):
    """Find the equilibrium at time ``t`` (s); return the ring's position and a flexible ring's displacement at the
    sensor (m)."""
    solve_equilibrium(model, t, y)
    read_sensor(model.bending, y)
    return y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y], y[lay.SENSOR]


@step.register(Equilibrium)
def _step(method, model, t, y):
    h = method.h
    x_0, y_0, w_0 = position_at(model, t, y)
    x_2, y_2, w_2 = position_at(model, t + 2.0 * h, y)
    x_1, y_1, w_1 = position_at(model, t + h, y)
    y[lay.VELOCITY + lay.X] = (x_2 - x_0) / (2.0 * h)
    y[lay.VELOCITY + lay.Y] = (y_2 - y_0) / (2.0 * h)
    y[lay.SENSOR_V] = (w_2 - w_0) / (2.0 * h)
    y[lay.ACCELERATION + lay.X] = (x_2 - 2.0 * x_1 + x_0) / (h * h)
    y[lay.ACCELERATION + lay.Y] = (y_2 - 2.0 * y_1 + y_0) / (h * h)
    y[lay.SENSOR_A] = (w_2 - 2.0 * w_1 + w_0) / (h * h)


stability_ratio.register(Equilibrium)(no_limit)
KIND = MethodKind(Equilibrium, evaluations=3, fraction=1.0, per_period=1, cusp=1 / 2)
