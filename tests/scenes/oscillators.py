"""Models so small that they have known solutions, for the tests of methods; registered for these tests only.

Each is the radial coordinate ``RADIAL`` of one roller of 1 kg.
"""

from math import cos, exp, inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.models.interface import (
    accelerations,
    degrees_of_freedom,
    monitored,
    state_width,
    update_extremes,
)
from bearingsim.core.parameters import Bearing
from bearingsim.core.pits.jumps import next_jump

UNIT = Bearing(1, 1.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)


class Oscillator(NamedTuple):
    """q'' = -K q - C q' + P cos(w t)."""

    K: float
    C: float
    P: float = 0.0
    w: float = 0.0
    bearing: Bearing = UNIT


class Swing(NamedTuple):
    """q'' = -K (q - q^3/6) - C q' (1 + q'^2) + P cos t: smooth, and bent in all it depends on."""

    K: float
    C: float
    P: float
    bearing: Bearing = UNIT


class Bounce(NamedTuple):
    """q'' = -g + K <-q>^n: a roller on a floor that it may leave."""

    g: float
    K: float
    n: float
    bearing: Bearing = UNIT


class Switched(NamedTuple):
    """q'' = P (1 + q') up to the time ``at``, -P after it: a jump, of which ``next_jump`` tells."""

    P: float
    at: float
    bearing: Bearing = UNIT


class Unfinished(NamedTuple):
    """q'' = 1 up to the time ``end`` (s), and no number after it."""

    end: float
    bearing: Bearing = UNIT


for _model in (Oscillator, Swing, Bounce, Switched, Unfinished):
    state_width.register(_model)(lambda model: lay.FIRST_LANE + 8)
    monitored.register(_model)(lambda model: 1)
    degrees_of_freedom.register(_model)(lambda model: (1, 0))
    update_extremes.register(_model)(lambda model, y: None)
    if _model is not Switched:
        next_jump.register(_model)(lambda model, t, y: inf)
next_jump.register(Switched)(lambda model, t, y: model.at if t < model.at else inf)


@accelerations.register(Oscillator)
def _accelerations_oscillator(model, t, y):
    y[lay.RADIAL_A] = -model.K * y[lay.RADIAL] - model.C * y[lay.RADIAL_V] + model.P * cos(model.w * t)


@accelerations.register(Swing)
def _accelerations_swing(model, t, y):
    q, v = y[lay.RADIAL], y[lay.RADIAL_V]
    y[lay.RADIAL_A] = -model.K * (q - q * q * q / 6.0) - model.C * v * (1.0 + v * v) + model.P * cos(t)


@accelerations.register(Bounce)
def _accelerations_bounce(model, t, y):
    y[lay.RADIAL_A] = -model.g + model.K * max(-y[lay.RADIAL], 0.0) ** model.n


@accelerations.register(Switched)
def _accelerations_switched(model, t, y):
    y[lay.RADIAL_A] = model.P * (1.0 + y[lay.RADIAL_V]) if t < model.at else -model.P


@accelerations.register(Unfinished)
def _accelerations_unfinished(model, t, y):
    y[lay.RADIAL_A] = 1.0 if t < model.end else np.nan


@jit
def start(method, model, t, q, v, y):
    """Put the roller in its place, ready for the first step."""
    y[:] = 0.0
    y[lay.RADIAL], y[lay.RADIAL_V] = q, v
    accelerations(model, t, y)
    prepare(method, model, t, y)


@jit
def go(method, model, first, y, out):
    """Take len(out) steps from step number ``first``, recording place and speed after each: out (n, 2)."""
    for n in range(len(out)):
        step(method, model, (first + n) * method.h, y)
        out[n, 0], out[n, 1] = y[lay.RADIAL], y[lay.RADIAL_V]


def run(method: Any, model: Any, steps: int, q: float = 0.5, v: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Places and speeds (steps, 2) from (q, v) at t = 0, and the buffer."""
    y, out = lay.buffer(1, 1.0), np.empty((steps, 2))
    start(method, model, 0.0, q, v, y)
    go(method, model, 0, y, out)
    return out, y


def at_even_steps(parameters: type, model: Any, h: float, steps: int, q: float, v: float) -> np.ndarray:
    """The end state (2,) of any method, adaptive or not, in ``steps`` steps of ``h`` (s)."""
    if "longest" not in parameters._fields:  # type: ignore[attr-defined]
        return run(parameters(h), model, steps, q, v)[0][-1]
    y, out = lay.buffer(1, 1.0), np.empty((steps, 2))
    method = tolerant(parameters, h, h)
    start(method, model, 0.0, q, v, y)
    y[lay.H_NEXT] = h
    go(method, model, 0, y, out)
    assert y[lay.STEPS_TAKEN] == steps
    return out[-1]


def tolerant(parameters: Any, h: float, longest: float) -> Any:
    """An adaptive method that accepts any step, so that all are as long as allowed."""
    return parameters(h, 1e30, 1e30, 1e30, longest)


def tight(parameters: Any, h: float, tolerance: float, longest: float = 1.0) -> Any:
    """An adaptive method with one tolerance for all."""
    return parameters(h, tolerance, tolerance, tolerance, longest)


def counts(y: np.ndarray) -> dict[str, float]:
    """What a run took."""
    return {
        "taken": y[lay.STEPS_TAKEN],
        "refused": y[lay.STEPS_REJECTED],
        "evaluated": y[lay.EVALUATIONS],
        "failed": y[lay.FAILED],
    }


def swung(K: float, C: float, t: float, q: float, v: float) -> np.ndarray:
    """The free oscillator's exact state (2,) at ``t`` (s), underdamped."""
    w, c = sqrt(K - C * C / 4.0), C / 2.0
    e, co, si = exp(-c * t), cos(w * t), cos(w * t - pi / 2.0)
    return e * np.array([q * co + (v + c * q) / w * si, v * co - (K * q + c * v) / w * si])


def bounce_period(model: Bounce, v: float) -> float:
    """Period (s) of a roller thrown up from the floor with ``v`` (m/s), its contact linear (n = 1)."""
    w = sqrt(model.K)
    return 2.0 * v / model.g + 2.0 / w * (pi - np.arctan2(v * w, model.g))
