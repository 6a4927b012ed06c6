"""Functions of every method, dispatched on the type of its parameters."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class MethodKind(NamedTuple):
    """Properties of a method.

    parameters: its ``NamedTuple``, that of an adaptive method with the fields of ``Tolerances``; evaluations: of
    the model per step; fraction: largest automatic step over the stability limit at impact; per_period: automatic
    steps per period of the contact vibration, which rings under light damping; cusp: fraction of a step at which a
    jump of the force causes no first-order error (where the method's later weights sum to the remaining time);
    order: on smooth motion; lag: of friction, in steps: 1 if steep friction would limit the step, else 0
    (``friction/lag.py``). ``fraction`` and ``per_period`` are measured by benchmarks/step_fraction.py
    (docs/steps.md).
    """

    parameters: type
    evaluations: int
    fraction: float
    per_period: int
    cusp: float
    order: int = 2
    lag: float = 1.0


class Tolerances(NamedTuple):
    """Parameters of every adaptive method, in this order.

    h: time between two recorded instants (s); the steps may be longer or shorter. rtol: relative tolerance of
    velocities (1); atol_q, atol_v: absolute tolerances of positions (m) and velocities (m/s), of angles multiplied
    by their lever arm; longest: largest step (s).
    """

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@generic
def prepare(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Prepare the buffer for the first step, from time ``t`` (s); accelerations are already set."""


def no_preparation(method, model, t, y):
    """Do nothing, as ``prepare`` of methods that store only the state."""


@generic
def attempt(method: Any, model: Any, t: float, h: float, y: np.ndarray) -> float:
    """Make one step of ``h`` (s) of an adaptive method from the state that ``adaptive.py`` stores at START.

    Stores the new state, including accelerations, in the state's blocks. Returns the error estimate over the
    tolerance; if it is above 1 or not finite, the step is repeated with a smaller h.
    """


@generic
def interpolate(method: Any, fraction: float, h: float, y: np.ndarray, n: int) -> None:
    """Set positions and velocities (``n`` entries) at ``fraction`` (0 to 1) of the last step of ``h`` (s)."""


@generic(inline="late")
def step(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Advance the buffer ``y`` from time ``t`` to ``t + method.h`` (s), including accelerations and contacts."""


@generic
def reach(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Advance the buffer ``y`` of an adaptive method to a time ``t`` (s) not before that of the last call.

    The method's steps do not depend on ``t``; they run ahead, and the state follows by dense output.
    """


@generic
def stability_ratio(method: Any, K: float, C: float) -> float:
    """Return the step over the method's linear stability limit; above 1 errors grow.

    K: stiffness over mass (1/s^2), C: damping over mass (1/s) of one body.
    """


def no_limit(method, K, C):
    """Return 0, the ``stability_ratio`` of a method without a stability limit."""
    return 0.0
