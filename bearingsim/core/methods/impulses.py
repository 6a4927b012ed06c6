"""Exact motion of the model ``impulse`` over a step, with each impulse at its own instant; no numerical
integration.

    x(t + h) = free motion over h from (x, v)  +  sum over impulses in (t, t + h] of free motion from (0, J/m)

The motion at the end of a step is exact for any step. The velocity jumps at an impulse, by about a thousand times
the amplitude of the spectral line at the fault frequency, and its samples would have a wrong mean. The recorded
velocity and acceleration are therefore differences of positions (``simulation/differentiation.py``), which sum to
the displacement. Aliasing changes the amplitude of a spectral line by at most (omega_0 h)^2/12, where omega_0^2 =
K/m.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import MethodKind, no_limit, stability_ratio, step
from bearingsim.core.models.impulse import free_motion


class Impulses(NamedTuple):
    """Parameters. h: time between samples, s."""

    h: float


@jit
def motion_with_impulses(m, K, C, times, J, start, end, x, v):
    """Return displacement (m) and velocity (m/s) of one mode at ``end`` (s).

    m, K, C: mass (kg), stiffness (N/m) and damping (N s/m) of the mode; times, J: instants (n,) s and strengths
    (n,) N s of all impulses, of which those in (start, end] act; x, v: displacement and velocity at ``start`` (s).
    """
    x, v = free_motion(m, K, C, end - start, x, v)
    begin, stop = np.searchsorted(times, start, side="right"), np.searchsorted(times, end, side="right")
    for k in range(begin, stop):
        x_k, v_k = free_motion(m, K, C, end - times[k], 0.0, J[k] / m)
        x += x_k
        v += v_k
    return x, v


@jit
def advance_mode(m, K, C, times, J, t, h, y, axis):
    """Advance one mode by a step of ``h`` (s) from ``t`` (s), a multiple of ``h``."""
    # intervals begin and end at multiples of h, so that rounding causes neither gap nor overlap
    n = np.rint(t / h)
    x, v = motion_with_impulses(
        m, K, C, times, J, n * h, (n + 1.0) * h, y[lay.POSITION + axis], y[lay.VELOCITY + axis]
    )
    y[lay.POSITION + axis], y[lay.VELOCITY + axis] = x, v
    y[lay.ACCELERATION + axis] = -(K * x + C * v) / m


@step.register(Impulses)
def _step(method, model, t, y):
    advance_mode(model.m, model.K_x, model.C_x, model.times, model.J_x, t, method.h, y, lay.X)
    advance_mode(model.m, model.K_y, model.C_y, model.times, model.J_y, t, method.h, y, lay.Y)


stability_ratio.register(Impulses)(no_limit)
KIND = MethodKind(Impulses, evaluations=1, fraction=1.0, per_period=30, cusp=1 / 2)
