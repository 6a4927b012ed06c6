"""One coordinate that can be stiff, limp, pushed, or over a floor: for the tests of implicit methods."""

from math import cos, inf, sin
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.general import General, Power
from bearingsim.core.laws.damping.interface import derivatives, normal_force
from bearingsim.core.laws.stiffness.power_laws import PowerLaw
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.models.interface import (
    accelerations,
    degrees_of_freedom,
    linearise,
    state_width,
    update_extremes,
)
from bearingsim.core.parameters import Bearing

UNIT = Bearing(1, 1.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
"""One roller of 1 kg."""


def dashpot(stiffness: PowerLaw, c: float, m3: float) -> General:
    """A contact with a dashpot, of one type for every m3: compiled once."""
    return General(stiffness, c, Power(1.0), Power(m3))


NO_FLOOR = dashpot(PowerLaw(0.0, 1.0), 0.0, 0.0)
"""A floor that is not felt."""


class Scene(NamedTuple):
    """q'' = p'' - K (q - p) - C (q' - p') + mu (1 - q^2) q' - g + floor(-q, -q') with p = P sin(1 + w t), per kg.

    With K, C and P the forced motion of Prothero and Robinson, in second order: it stays on q = p. With mu and
    K = 1 van der Pol's oscillator. fault: part by which its derivatives are wrong.
    """

    floor: Any = NO_FLOOR
    K: float = 0.0
    C: float = 0.0
    P: float = 0.0
    w: float = 1.0
    mu: float = 0.0
    g: float = 0.0
    fault: float = 0.0
    bearing: Bearing = UNIT


state_width.register(Scene)(lambda model: lay.FIRST_LANE + 8)
degrees_of_freedom.register(Scene)(lambda model: (1, 0))
update_extremes.register(Scene)(lambda model, y: None)
next_jump.register(Scene)(lambda model, t, y: inf)


@accelerations.register(Scene)
def _accelerations(model, t, y):
    q, v, P, w = y[lay.RADIAL], y[lay.RADIAL_V], model.P, model.w
    angle = 1.0 + w * t
    p, p_v, p_a = P * sin(angle), P * w * cos(angle), -P * w * w * sin(angle)
    y[lay.RADIAL_A] = p_a - model.K * (q - p) - model.C * (v - p_v) + model.mu * (1.0 - q * q) * v - model.g
    y[lay.RADIAL_A] += normal_force(model.floor, -q, -v)


@linearise.register(Scene)
def _linearise(model, t, y):
    q, v = y[lay.RADIAL], y[lay.RADIAL_V]
    K, C = derivatives(model.floor, -q, -v)
    factor = 1.0 + model.fault
    y[lay.diagonal_block(lay.POSITION_JACOBIAN, 0, 0)] = factor * (-model.K - 2.0 * model.mu * q * v - K)
    y[lay.diagonal_block(lay.VELOCITY_JACOBIAN, 0, 0)] = factor * (-model.C + model.mu * (1.0 - q * q) - C)


@jit
def integrate(method, model, y, path):
    """Make ready what a method needs at t = 0, and take steps; q, v and a after each into ``path`` (n, 3)."""
    accelerations(model, 0.0, y)
    prepare(method, model, 0.0, y)
    for n in range(len(path)):
        step(method, model, n * method.h, y)
        path[n, 0], path[n, 1], path[n, 2] = y[lay.RADIAL], y[lay.RADIAL_V], y[lay.RADIAL_A]


class Run(NamedTuple):
    """path: (n, 3) q, v, a at the recorded instants; counts; y: the buffer as it was left."""

    path: np.ndarray
    taken: int
    refused: int
    evaluated: int
    iterated: int
    failed: int
    y: np.ndarray


def run(model: Scene, method: Any, span: float, q: float, v: float) -> Run:
    """The scene from (q, v) over ``span`` (s) with a method whose ``h`` is the recorded step."""
    y = lay.make_buffer(1, 1.0)
    y[lay.RADIAL], y[lay.RADIAL_V] = q, v
    path = np.empty((round(span / method.h), 3))
    integrate(method, model, y, path)
    cells = [lay.STEPS_TAKEN, lay.STEPS_REJECTED, lay.EVALUATIONS, lay.NEWTON_ITERATIONS, lay.FAILED]
    taken, rejected, evaluated, iterated, failed = y[cells].astype(int)
    return Run(path, taken, rejected, evaluated, iterated, failed, y)


def exact_state(model: Scene, t: float) -> tuple[float, float]:
    """p and p' at ``t``."""
    return model.P * sin(1.0 + model.w * t), model.P * model.w * cos(1.0 + model.w * t)
