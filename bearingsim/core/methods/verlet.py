"""Velocity Verlet, second order, one evaluation per step; the damping force depends on a predicted velocity.

    q1 = q + h v + h^2 a/2,   a1 = f(q1, v + h a),   v1 = v + h (a + a1)/2

Source: Swope et al. 1982; with velocity-dependent forces, Allen and Tildesley ch. 3. On the oscillator q'' = -K q
- C q' the stability limit, with a root of -1, is h^2 K/4 + h C = 1 (docs/steps.md). With heavy damping this is
half the limit of symplectic Euler.

Touch-down: the damping force of a closing contact rises almost as a jump, as delta^(1/9) by Kraemer's law with
Palmgren's stiffness. Verlet applies the force at the end of a step over half of that step, wherever in it the
contact closes, so its impulse has an error of first order. A step in which a contact closes is therefore divided
in two, such that the contact closes at ``TOUCH_DOWN`` of one part, where the impulse of Verlet is exact. This
reduces the error to a seventh (tests/core/methods/test_touch_down.py); the rest is due to the following steps,
over which a force like delta^(1/9) is not smooth.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import inlined, jit
from bearingsim.core.methods.interface import MethodKind, prepare, stability_ratio, step
from bearingsim.core.models.by_roller import drift, evaluate, kick
from bearingsim.core.models.interface import state_width
from bearingsim.core.parameters import lanes

TOUCH_DOWN = 4 / 9
"""Fraction of a step h at which a contact closes such that Verlet's impulse of a force like delta^(1/9) is exact.

Over the remaining time t the impulse of the force F at the end of the step is 9/10 F t, and that of Verlet F h/2.
(For a force that jumps the fraction would be 1/2.)
"""
MAX_PARTS = 8  # into which a step with several touch-downs is divided

# velocity at half a step; velocity and acceleration at the start of a divided step, acceleration at its end
HALF_STEP_V, START_V, START_A, END_A = lay.states(lay.STAGE, "m/s, m/s, m/s^2, m/s^2", "verlet", "step")


class Verlet(NamedTuple):
    """Parameters. h: step, s."""

    h: float


@drift.register(Verlet)
def _drift(method, y, i):
    """Advance the position to the end of the step and the velocity to its prediction; store that at half a
    step."""
    h, v, a = method.h, y[lay.VELOCITY + i], y[lay.ACCELERATION + i]
    v_half = v + 0.5 * h * a
    y[HALF_STEP_V + i] = v_half
    y[lay.POSITION + i] += h * v_half
    y[lay.VELOCITY + i] = v + h * a


@kick.register(Verlet)
def _kick(method, y, i):
    """Correct the velocity at the end of the step with the new acceleration."""
    y[lay.VELOCITY + i] = y[HALF_STEP_V + i] + 0.5 * method.h * y[lay.ACCELERATION + i]


@inlined
def closes(delta, v, h):
    """Check if a contact with approach ``delta`` (m) and closing rate ``v`` (m/s) closes within ``h`` (s)."""
    return (delta <= 0.0) & (delta + h * v > 0.0)


@jit
def count_touch_downs(h, y, n):
    """Count the contacts that close within ``h`` (s).

    The loop is vectorised; few steps need ``first_touch_down``, which is not.
    """
    count = 0
    for j in range(n):
        count += 1 if closes(y[lay.DELTA_O + j], y[lay.V_O + j], h) else 0
        count += 1 if closes(y[lay.DELTA_I + j], y[lay.V_I + j], h) else 0
    return count


@jit
def first_touch_down(h, y, n):
    """Return the time (s) until the next contact closes, at most ``h`` (s)."""
    closing_time = h
    for j in range(n):
        for delta, v in ((lay.DELTA_O, lay.V_O), (lay.DELTA_I, lay.V_I)):
            if closes(y[delta + j], y[v + j], h):
                closing_time = min(closing_time, -y[delta + j] / y[v + j])
    return closing_time


@jit
def step_over_touch_downs(model, t, end, y):
    """Step from ``t`` to ``end`` (s) in parts in which contacts close at ``TOUCH_DOWN`` or not at all."""
    n = lanes(model.bearing)
    for _ in range(MAX_PARTS):
        h = end - t
        closing_time = first_touch_down(h, y, n)
        is_early = closing_time < TOUCH_DOWN * h
        part = closing_time / TOUCH_DOWN if is_early else (closing_time - TOUCH_DOWN * h) / (1.0 - TOUCH_DOWN)
        if closing_time >= h or part <= 0.0:
            break
        evaluate(model, Verlet(part), t + part, y)
        t += part
        if not is_early:
            break
    evaluate(model, Verlet(end - t), end, y)


@jit
def save_division_start(y, n):
    """Store velocity and acceleration at the start of a step that is to be divided."""
    for k in range(n):
        y[START_V + k], y[START_A + k] = y[lay.VELOCITY + k], y[lay.ACCELERATION + k]


@jit
def spread_acceleration(h, y, n):
    """Replace the acceleration at the end of a divided step of ``h`` (s), which is recorded, so that the recorded
    accelerations sum to the change of velocity.

    The replacement is the acceleration plus the error of the trapezoidal rule over the whole step.
    ``restore_acceleration`` undoes it before the next step.
    """
    for k in range(n):
        end_a = y[lay.ACCELERATION + k]
        y[END_A + k] = end_a
        y[lay.ACCELERATION + k] += (y[lay.VELOCITY + k] - y[START_V + k]) / h - 0.5 * (y[START_A + k] + end_a)
    y[lay.H_TAKEN] = h


@jit
def restore_acceleration(y, n):
    """Restore the acceleration at the end of a divided step."""
    for k in range(n):
        y[lay.ACCELERATION + k] = y[END_A + k]
    y[lay.H_TAKEN] = 0.0


@prepare.register(Verlet)
def _prepare(method, model, t, y):
    y[lay.H_TAKEN] = 0.0  # length of the last step if it was divided


@step.register(Verlet)
def _step(method, model, t, y):
    h, n = method.h, state_width(model)
    if y[lay.H_TAKEN] > 0.0:
        restore_acceleration(y, n)
    if count_touch_downs(h, y, lanes(model.bearing)) > 0:
        save_division_start(y, n)
        step_over_touch_downs(model, t, t + h, y)
        spread_acceleration(h, y, n)
    else:
        evaluate(model, method, t + h, y)


@stability_ratio.register(Verlet)
def _stability_ratio(method, K, C):
    return method.h * (0.25 * method.h * K + C)


KIND = MethodKind(Verlet, evaluations=1, fraction=0.5, per_period=40, cusp=1 / 2, order=2)
