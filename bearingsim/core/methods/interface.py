"""The functions every method has, chosen by the type of its parameters."""

from typing import Any

import numpy as np

from bearingsim.core.jit import generic


@generic
def step(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Take the buffer ``y`` from time ``t`` to ``t + method.h`` (s), accelerations and contacts included."""


@generic
def load_number(method: Any, K: float, C: float) -> float:
    """How much of the method's linear stability limit a step takes up: above 1 it grows.

    K: stiffness over mass (1/s^2), C: damping over mass (1/s) of one body.
    """
