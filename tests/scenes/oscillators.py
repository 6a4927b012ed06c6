"""Models so small that they have known solutions, for the tests of methods; registered for these tests only.

Each is the radial coordinate ``RADIAL`` of one roller of 1 kg.
"""

from math import cos, exp, inf, nan, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.models.extremes import update_forces
from bearingsim.core.models.interface import (
    accelerations,
    degrees_of_freedom,
    linearise,
    monitored_bodies,
    state_width,
    update_extremes,
)
from bearingsim.core.parameters import Bearing

UNIT = Bearing(1, 1.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)


class Oscillator(NamedTuple):
    """q'' = -K (q - B q^3) - C v (1 + D v^2) + P cos(w t) - g + floor <-q>^n, with v = q', up to ``until`` (s).

    From then on q'' = ``after``. jump_time: s, returned by ``next_jump``. One type for all the scenes below: so
    each method is compiled once.
    """

    K: float
    C: float
    P: float = 0.0
    w: float = 0.0
    B: float = 0.0
    D: float = 0.0
    g: float = 0.0
    floor: float = 0.0
    n: float = 1.0
    until: float = inf
    after: float = 0.0
    jump_time: float = inf
    bearing: Bearing = UNIT


def pendulum(K: float, C: float, P: float) -> Oscillator:
    """q'' = -K (q - q^3/6) - C v (1 + v^2) + P cos t: smooth, and bent in all it depends on."""
    return Oscillator(K, C, P, w=1.0, B=1.0 / 6.0, D=1.0)


def bouncing_roller(g: float, K: float, n: float) -> Oscillator:
    """q'' = -g + K <-q>^n: a roller on a floor that it may leave."""
    return Oscillator(0.0, 0.0, g=g, floor=K, n=n)


def jump_at(P: float, at: float) -> Oscillator:
    """q'' = P (1 + v) up to the time ``at``, -P after it: a jump that ``next_jump`` announces."""
    return Oscillator(0.0, -P, g=-P, until=at, after=-P, jump_time=at)


def undefined_after(end: float) -> Oscillator:
    """q'' = 1 up to the time ``end`` (s), and no number after it."""
    return Oscillator(0.0, 0.0, g=-1.0, until=end, after=nan)


state_width.register(Oscillator)(lambda model: lay.FIRST_LANE + 8)
monitored_bodies.register(Oscillator)(lambda model: 1)
degrees_of_freedom.register(Oscillator)(lambda model: (1, 0))
update_extremes.register(Oscillator)(update_forces)
next_jump.register(Oscillator)(lambda model, t, y: model.jump_time if t < model.jump_time else inf)


@accelerations.register(Oscillator)
def _accelerations(model, t, y):
    q, v = y[lay.RADIAL], y[lay.RADIAL_V]
    spring_force = model.K * q if model.B == 0.0 else model.K * (q - model.B * q * q * q)
    damping_force = model.C * v if model.D == 0.0 else model.C * v * (1.0 + model.D * v * v)
    a = -spring_force - damping_force - model.g
    if model.P != 0.0:
        a += model.P * cos(model.w * t)
    if model.floor != 0.0:
        y[lay.Q_O] = model.floor * max(-q, 0.0) ** model.n
        a += y[lay.Q_O]
    y[lay.RADIAL_A] = a if t < model.until else model.after


@linearise.register(Oscillator)
def _linearise(model, t, y):
    """Fill the derivatives of the linear spring and damper, which is all that scenes of implicit methods have."""
    y[lay.diagonal_block(lay.POSITION_JACOBIAN, 0, 0)] = -model.K
    y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, 0, 0)] = -model.C


@jit
def start(method, model, t, q, v, y):
    """Set the roller's position, ready for the first step."""
    y[:] = 0.0
    y[lay.RADIAL], y[lay.RADIAL_V] = q, v
    accelerations(model, t, y)
    prepare(method, model, t, y)


@jit
def take_steps(method, model, start_step, y, out):
    """Take len(out) steps from step number ``first``, recording position and velocity after each: out (n, 2)."""
    for n in range(len(out)):
        step(method, model, (start_step + n) * method.h, y)
        out[n, 0], out[n, 1] = y[lay.RADIAL], y[lay.RADIAL_V]


def run(method: Any, model: Any, steps: int, q: float = 0.5, v: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (steps, 2) from (q, v) at t = 0, and the buffer."""
    y, out = lay.make_buffer(1, 1.0), np.empty((steps, 2))
    start(method, model, 0.0, q, v, y)
    take_steps(method, model, 0, y, out)
    return out, y


def at_even_steps(parameters: type, model: Any, h: float, steps: int, q: float, v: float) -> np.ndarray:
    """The end state (2,) of any method, adaptive or not, in ``steps`` steps of ``h`` (s)."""
    if "longest" not in parameters._fields:  # type: ignore[attr-defined]
        return run(parameters(h), model, steps, q, v)[0][-1]
    y, out = lay.make_buffer(1, 1.0), np.empty((steps, 2))
    method = without_error_control(parameters, h, h)
    start(method, model, 0.0, q, v, y)
    y[lay.H_NEXT] = h
    take_steps(method, model, 0, y, out)
    assert y[lay.STEPS_TAKEN] == steps
    return out[-1]


def without_error_control(parameters: Any, h: float, longest: float) -> Any:
    """An adaptive method that accepts any step, so that all are as long as allowed."""
    return parameters(h, 1e30, 1e30, 1e30, longest)


def with_tolerance(parameters: Any, h: float, tolerance: float, longest: float = 1.0) -> Any:
    """An adaptive method with one tolerance for all."""
    return parameters(h, tolerance, tolerance, tolerance, longest)


def counts(y: np.ndarray) -> dict[str, float]:
    """Counters of a run."""
    return {
        "taken": y[lay.STEPS_TAKEN],
        "refused": y[lay.STEPS_REJECTED],
        "evaluated": y[lay.EVALUATIONS],
        "failed": y[lay.FAILED],
    }


def exact_state(K: float, C: float, t: float, q: float, v: float) -> np.ndarray:
    """The free oscillator's exact state (2,) at ``t`` (s), underdamped."""
    w, c = sqrt(K - C * C / 4.0), C / 2.0
    decay, cosine, sine = exp(-c * t), cos(w * t), cos(w * t - pi / 2.0)
    return decay * np.array([q * cosine + (v + c * q) / w * sine, v * cosine - (K * q + c * v) / w * sine])


def bounce_force(model: Oscillator, v: float) -> float:
    """Largest contact force (N) of a roller that hits the floor with ``v`` (m/s), its contact linear (n = 1)."""
    return model.g + sqrt(model.g**2 + model.floor * v * v)


def bounce_period(model: Oscillator, v: float) -> float:
    """Period (s) of a roller thrown up from the floor with ``v`` (m/s), its contact linear (n = 1)."""
    w = sqrt(model.floor)
    return 2.0 * v / model.g + 2.0 / w * (pi - np.arctan2(v * w, model.g))
