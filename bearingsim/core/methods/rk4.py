"""The classical Runge-Kutta method, fourth order, four evaluations per step (Kutta 1901).

Its stability region reaches -2.785 on the real axis and 2.828 i on the imaginary axis; in between, at a damping
ratio of 0.54, its boundary is at a distance of only 2.615 from the origin. The stages are written out, because
with the table of ``tableau`` a step of `rollers` takes 10 to 33 % longer (docs/touch_down.md).
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import MethodKind, no_preparation, prepare, stability_ratio, step
from bearingsim.core.methods.limit import step_over_limit, tabulate_limits
from bearingsim.core.methods.tableau import cusp_fraction, make_runge_kutta
from bearingsim.core.models.interface import accelerations, state_width

TABLE = make_runge_kutta(np.diag([1 / 2, 1 / 2, 1.0], -1), np.array([1, 2, 2, 1]) / 6)
LIMITS = tabulate_limits(TABLE)
START_Q, START_V, SUM_Q, SUM_V = lay.states(lay.STAGE, "m, m/s, m/s, m/s^2", "rk4", "step")


class RungeKutta4(NamedTuple):
    """Parameters. h: step, s."""

    h: float


@jit
def save_start(y, n):
    """Save the state at the start of the step and clear the weighted sums of rates."""
    for j in range(n):
        y[START_Q + j] = y[lay.POSITION + j]
        y[START_V + j] = y[lay.VELOCITY + j]
        y[SUM_Q + j] = 0.0
        y[SUM_V + j] = 0.0


@jit
def add_stage(weight, dt, y, n):
    """Add the rates at a stage times their ``weight`` (s) to the sums, and set the state of the next stage.

    It is ``dt`` (s) from the start of the step along these rates.
    """
    for j in range(n):
        rate_q, rate_v = y[lay.VELOCITY + j], y[lay.ACCELERATION + j]
        y[SUM_Q + j] += weight * rate_q
        y[SUM_V + j] += weight * rate_v
        y[lay.POSITION + j] = y[START_Q + j] + dt * rate_q
        y[lay.VELOCITY + j] = y[START_V + j] + dt * rate_v


@jit
def finish_step(weight, y, n):
    """Add the rates at the last stage times their ``weight`` (s), and set the state at the end of the step."""
    for j in range(n):
        y[lay.POSITION + j], y[lay.VELOCITY + j] = (
            y[START_Q + j] + y[SUM_Q + j] + weight * y[lay.VELOCITY + j],
            y[START_V + j] + y[SUM_V + j] + weight * y[lay.ACCELERATION + j],
        )


@step.register(RungeKutta4)
def _step(method, model, t, y):
    h, n = method.h, state_width(model)
    save_start(y, n)
    add_stage(h / 6.0, h / 2.0, y, n)
    accelerations(model, t + h / 2.0, y)
    add_stage(h / 3.0, h / 2.0, y, n)
    accelerations(model, t + h / 2.0, y)
    add_stage(h / 3.0, h, y, n)
    accelerations(model, t + h, y)
    finish_step(h / 6.0, y, n)
    accelerations(model, t + h, y)


prepare.register(RungeKutta4)(no_preparation)


@stability_ratio.register(RungeKutta4)
def _stability_ratio(method, K, C):
    return step_over_limit(LIMITS, method.h, K, C)


KIND = MethodKind(RungeKutta4, evaluations=4, fraction=0.25, per_period=20, cusp=cusp_fraction(TABLE), order=4)
