"""Not an integrator: the exact motion of ``impulse`` over a step, with every impulse at its own instant.

    x(t + h) = free motion over h from (x, v)  +  sum over impulses in (t, t + h] of free motion from (0, J/m)

What is recorded as velocity and acceleration at t are differences of the positions at t - h, t and t + h, as
``Equilibrium`` has it: an impulse makes the true velocity jump, by some thousand times what is left of it in a
line at the fault frequency, and samples of a jump have a wrong mean. Differences of positions sum to the
displacement. The positions themselves are exact at any step. A line read from their samples is off by (omega_0
h)^2/12 of it at most, which is aliasing (omega_0^2 = K/m).
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import MethodKind, no_limit, stability_ratio, step
from bearingsim.core.models.impulse import free_motion

(SPEED,) = lay.states(lay.STAGE, "m/s", "impulses", "step")  # true velocity, from the ring's x on


class Impulses(NamedTuple):
    """h: time between samples, s."""

    h: float


@jit
def motion_with_impulses(m, K, C, times, J, start, end, x, v):
    """Return displacement (m) and velocity (m/s) of one mode at ``end`` (s), from those at ``start`` and all
    impulses.

    An impulse belongs to the span that its instant ends or lies in: (start, end].
    """
    x, v = free_motion(m, K, C, end - start, x, v)
    begin, end_of_step = np.searchsorted(times, start, side="right"), np.searchsorted(times, end, side="right")
    for k in range(begin, end_of_step):
        more_x, more_v = free_motion(m, K, C, end - times[k], 0.0, J[k] / m)
        x += more_x
        v += more_v
    return x, v


@jit
def step_along(m, K, C, times, J, t, h, y, axis):
    """Step one mode from ``t`` (s) by a whole number of steps."""
    n = np.rint(t / h)  # all spans begin and end at n h, so that none overlaps the next by a rounding
    x_0, v_0 = y[lay.POSITION + axis], y[SPEED + axis]
    x_1, v_1 = motion_with_impulses(m, K, C, times, J, n * h, (n + 1.0) * h, x_0, v_0)
    x_2, _ = motion_with_impulses(m, K, C, times, J, (n + 1.0) * h, (n + 2.0) * h, x_1, v_1)
    y[lay.POSITION + axis], y[SPEED + axis] = x_1, v_1
    y[lay.VELOCITY + axis] = (x_2 - x_0) / (2.0 * h)
    y[lay.ACCELERATION + axis] = (x_2 - 2.0 * x_1 + x_0) / (h * h)


@step.register(Impulses)
def _step(method, model, t, y):
    step_along(model.m, model.K_x, model.C_x, model.times, model.J_x, t, method.h, y, lay.X)
    step_along(model.m, model.K_y, model.C_y, model.times, model.J_y, t, method.h, y, lay.Y)


stability_ratio.register(Impulses)(no_limit)
KIND = MethodKind(Impulses, evaluations=1, fraction=1.0, per_period=30, cusp=1 / 2)
