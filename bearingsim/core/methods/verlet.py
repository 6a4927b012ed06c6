"""Velocity Verlet, second order, one evaluation a step; the damping force sees a predicted velocity.

    q1 = q + h v + h^2 a/2,   a1 = f(q1, v + h a),   v1 = v + h (a + a1)/2

Source: Swope et al. 1982; with velocity-dependent forces, Allen and Tildesley ch. 3. On the oscillator
q'' = -K q - C q' the root -1 is reached where h^2 K/4 + h C = 1 (docs/methods.md): with heavy damping
half the limit of symplectic Euler.
"""

from typing import NamedTuple

from bearingsim.core.jit import jit
from bearingsim.core.layout import ACCELERATION, POSITION, STAGE, VELOCITY
from bearingsim.core.methods.interface import MethodKind, as_it_is, load_number, prepare, step
from bearingsim.core.models.interface import accelerations, width


class Verlet(NamedTuple):
    """h: step, s."""

    h: float


@jit
def drift(h, y, n):
    """Positions to the end of the step, velocities to their prediction; half-kicked velocities are kept."""
    for j in range(n):
        kicked = y[VELOCITY + j] + 0.5 * h * y[ACCELERATION + j]
        y[STAGE + j] = kicked
        y[POSITION + j] += h * kicked
        y[VELOCITY + j] += h * y[ACCELERATION + j]


@jit
def kick(h, y, n):
    """The second half of the kick, with the new accelerations."""
    for j in range(n):
        y[VELOCITY + j] = y[STAGE + j] + 0.5 * h * y[ACCELERATION + j]


prepare.register(Verlet)(as_it_is)


@step.register(Verlet)
def _step(method, model, t, y):
    n = width(model)
    drift(method.h, y, n)
    accelerations(model, t + method.h, y)
    kick(method.h, y, n)


@load_number.register(Verlet)
def _load_number(method, K, C):
    return method.h * (0.25 * method.h * K + C)


KIND = MethodKind(Verlet, evaluations=1, fraction=0.5, per_period=40, cusp=1 / 2, order=2)
