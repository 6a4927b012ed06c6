"""The functions every model has, chosen by the type of its parameters."""

from typing import Any

import numpy as np

from bearingsim.core.jit import generic


@generic
def width(model: Any) -> int:
    """Entries of a row that the model's state takes (the ring's, then the lanes in use)."""


@generic
def accelerations(model: Any, t: float, y: np.ndarray) -> None:
    """Fill the acceleration and contact rows of ``y`` from its position and velocity rows at time ``t`` (s)."""


@generic
def begin(model: Any, t: float, y: np.ndarray) -> None:
    """Complete a buffer whose rollers and ring are at rest at time ``t`` (s): what a first step builds on."""


@generic
def rest(model: Any, t: float, y: np.ndarray) -> float:
    """Put the massless model at its equilibrium at time ``t`` (s); returns the residual force (N)."""


@generic
def stiffness_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Stiffness over mass (1/s^2) of watched body ``j`` as it stands now."""


@generic
def damping_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Damping over mass (1/s) of watched body ``j`` as it stands now."""


@generic
def watched(model: Any) -> int:
    """How many bodies have their step limit watched: the rollers (by lane), or the ring alone."""
