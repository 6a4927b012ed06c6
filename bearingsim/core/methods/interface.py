"""The functions every method has, chosen by the type of its parameters."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class MethodKind(NamedTuple):
    """What others must know of a method; steps measured by benchmarks/step_fraction.py (docs/methods.md).

    parameters: its ``NamedTuple``; evaluations: of the model in a step; fraction: of the stability limit at
    impact, the most an automatic step takes; per_period: steps of an automatic run in a period of the contact,
    which light damping lets ring; cusp: the part of a step after which a force that jumps is still integrated
    without a first-order error (where the method's weights after it add up to the time after it).
    """

    parameters: type
    evaluations: int
    fraction: float
    per_period: int
    cusp: float


@generic
def step(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Take the buffer ``y`` from time ``t`` to ``t + method.h`` (s), accelerations and contacts included."""


@generic
def load_number(method: Any, K: float, C: float) -> float:
    """How much of the method's linear stability limit a step takes up: above 1 it grows.

    K: stiffness over mass (1/s^2), C: damping over mass (1/s) of one body.
    """
