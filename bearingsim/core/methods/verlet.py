"""Velocity Verlet, second order, one evaluation a step; the damping force depends on a predicted velocity.

    q1 = q + h v + h^2 a/2,   a1 = f(q1, v + h a),   v1 = v + h (a + a1)/2

Source: Swope et al. 1982; with velocity-dependent forces, Allen and Tildesley ch. 3. On the oscillator
q'' = -K q - C q' the root -1 is reached where h^2 K/4 + h C = 1 (docs/steps.md). With heavy damping this is half
the limit of symplectic Euler.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.methods.interface import MethodKind, no_preparation, prepare, stability_ratio, step
from bearingsim.core.models.by_roller import drift, evaluate, kick

(MIDDLE_V,) = lay.states(lay.STAGE, "m/s", "verlet", "step")  # velocity in the middle of a step


class Verlet(NamedTuple):
    """Parameters. h: step, s."""

    h: float


@drift.register(Verlet)
def _drift(method, y, i):
    """Advance the position to the step's end and the velocity to its prediction; store the velocity at
    mid-step."""
    h, v, a = method.h, y[lay.VELOCITY + i], y[lay.ACCELERATION + i]
    v_middle = v + 0.5 * h * a
    y[MIDDLE_V + i] = v_middle
    y[lay.POSITION + i] += h * v_middle
    y[lay.VELOCITY + i] = v + h * a


@kick.register(Verlet)
def _kick(method, y, i):
    """Complete the velocity step with the new acceleration."""
    y[lay.VELOCITY + i] = y[MIDDLE_V + i] + 0.5 * method.h * y[lay.ACCELERATION + i]


prepare.register(Verlet)(no_preparation)


@step.register(Verlet)
def _step(method, model, t, y):
    evaluate(model, method, t + method.h, y)


@stability_ratio.register(Verlet)
def _stability_ratio(method, K, C):
    return method.h * (0.25 * method.h * K + C)


KIND = MethodKind(Verlet, evaluations=1, fraction=0.5, per_period=40, cusp=1 / 2, order=2)
