"""Euler's method, implicit only in the velocity: first order, one linear solution per step.

    (I - h A_v)(v1 - v) = h f(t, q, v),   q1 = q + h v1

For comparison; real-time physics engines use it because it needs only one evaluation. Heavy damping does not limit
the step, but stiffness does: on q'' = -K q - C q' it is unstable for h^2 K > 4 + 2 h C. With heavy dashpots its
forces are wrong, because f is evaluated at the start of the step.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.methods.adaptive import METHOD_STATES
from bearingsim.core.methods.arrow import assemble_system, factorise, solve
from bearingsim.core.methods.interface import MethodKind, no_preparation, prepare, stability_ratio, step
from bearingsim.core.models.interface import accelerations, linearise, state_width

VELOCITY_CHANGE = METHOD_STATES  # change of the velocities


class VelocityImplicitEuler(NamedTuple):
    """Parameters. h: step, s."""

    h: float


prepare.register(VelocityImplicitEuler)(no_preparation)


@step.register(VelocityImplicitEuler)
def _step(method, model, t, y):
    h, n = method.h, state_width(model)
    linearise(model, t, y)
    assemble_system(model, 0.0, h, y)
    factorise(model, y)
    for j in range(n):
        y[VELOCITY_CHANGE + j] = h * y[lay.ACCELERATION + j]
    solve(model, VELOCITY_CHANGE, y)
    for j in range(n):
        y[lay.VELOCITY + j] += y[VELOCITY_CHANGE + j]
        y[lay.POSITION + j] += h * y[lay.VELOCITY + j]
    accelerations(model, t + h, y)
    y[lay.EVALUATIONS] += 1.0


@stability_ratio.register(VelocityImplicitEuler)
def _stability_ratio(method, K, C):
    h = method.h
    return h * h * K / (4.0 + 2.0 * h * C)


# a force that jumps within a step acts from the next step on, as if it jumped at the
# end of the step; not 1, because rounding errors might put the jump into the next step
KIND = MethodKind(VelocityImplicitEuler, evaluations=1, fraction=0.25, per_period=40, cusp=0.99, order=1, lag=0.0)
