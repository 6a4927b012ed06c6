"""Models so small that they have known solutions, for the tests of methods; registered for these tests only.

Each is one roller's radial coordinate ``Q``, or a few that do not feel each other.
"""

from math import cos, inf
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.advance import Watch, advance
from bearingsim.core.events import next_cusp
from bearingsim.core.layout import LANES, A, Q, V, buffer
from bearingsim.core.methods.interface import prepare
from bearingsim.core.models.interface import (
    accelerations,
    begin,
    damping_per_mass,
    freedoms,
    keep_extremes,
    linearise,
    stiffness_per_mass,
    watched,
    width,
)
from bearingsim.core.parameters import Bearing

UNIT = Bearing(1, 1.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
"""One roller of 1 kg."""


class Oscillator(NamedTuple):
    """q'' = -K q - C q' + P cos(w t)."""

    bearing: Bearing
    K: float
    C: float
    P: float = 0.0
    w: float = 0.0


class Pendulum(NamedTuple):
    """q'' = -sin-like smooth force with a damping that grows: -K (q - q^3/6) - C q' (1 + q'^2), pushed by P cos t."""

    bearing: Bearing
    K: float
    C: float
    P: float


class Bounce(NamedTuple):
    """q'' = -g + (K/m) <-q>^n - C q' over a floor at 0, felt from q < 0."""

    bearing: Bearing
    g: float
    K: float
    n: float
    C: float = 0.0


def one_of(model: Any, *functions: Any) -> None:
    """What all have in common."""


for _model in (Oscillator, Pendulum, Bounce):
    width.register(_model)(lambda model: LANES + 8)
    watched.register(_model)(lambda model: 1)
    freedoms.register(_model)(lambda model: (1, 0))
    keep_extremes.register(_model)(lambda model, y: None)
    next_cusp.register(_model)(lambda model, t, y: inf)


@accelerations.register(Oscillator)
def _accelerations_oscillator(model, t, y):
    y[A] = -model.K * y[Q] - model.C * y[V] + model.P * cos(model.w * t)


@accelerations.register(Pendulum)
def _accelerations_pendulum(model, t, y):
    q, v = y[Q], y[V]
    y[A] = -model.K * (q - q * q * q / 6.0) - model.C * v * (1.0 + v * v) + model.P * cos(t)


@accelerations.register(Bounce)
def _accelerations_bounce(model, t, y):
    pressed = max(-y[Q], 0.0)
    y[A] = -model.g + model.K * pressed**model.n - model.C * y[V]
