"""The functions every method has, chosen by the type of its parameters."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class MethodKind(NamedTuple):
    """Properties of a method; steps measured by benchmarks/step_fraction.py (docs/steps.md).

    parameters: its ``NamedTuple``; evaluations: of the model in a step; fraction: of the stability limit at
    impact, the most an automatic step takes; per_period: steps of an automatic run in a period of the contact,
    which light damping lets ring; cusp: the part of a step after which a force that jumps is still integrated
    without a first-order error (where the method's weights after it add up to the time after it); order: on smooth
    motion; lag: of friction, in steps: 1 where steep friction would limit the step, else 0 (``friction/lag.py``).
    What a case may ask of it stands in the catalogue; parameters of an adaptive one are those of ``Tolerances``.
    """

    parameters: type
    evaluations: int
    fraction: float
    per_period: int
    cusp: float
    order: int = 2
    lag: float = 1.0


class Tolerances(NamedTuple):
    """Parameters that every adaptive method has, in this order.

    h: time between two recorded instants, s; its own steps may be longer or shorter. rtol: of velocities (1);
    atol_q: of positions (m), angles by the arm they act at; atol_v: of velocities (m/s); longest: step, s.
    """

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@generic
def prepare(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Make the buffer ready for the first step, from time ``t`` (s); accelerations are in place."""


def no_preparation(method, model, t, y):
    """Skip ``prepare``, for methods that keep nothing but the state."""


@generic
def attempt(method: Any, model: Any, t: float, h: float, y: np.ndarray) -> float:
    """Make one step of ``h`` (s) of an adaptive method from the state that ``adaptive.py`` keeps at START.

    Leaves the new state, its accelerations included, in the state's blocks. Returns the estimate of its error over
    the tolerance (1: as large as allowed; not finite, or over 1: to be repeated shorter).
    """


@generic
def interpolate(method: Any, part: float, h: float, y: np.ndarray, n: int) -> None:
    """Set positions and velocities (``n`` entries) at ``part`` (0 to 1) of the last step of ``h`` (s)."""


@generic(inline="late")
def step(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Take the buffer ``y`` from time ``t`` to ``t + method.h`` (s), accelerations and contacts included."""


@generic
def reach(method: Any, model: Any, t: float, y: np.ndarray) -> None:
    """Take the buffer ``y`` to any time ``t`` (s) not before the last, where an adaptive method's steps let it.

    Its own steps do not depend on where it is looked at: they run ahead, and dense output shows the state.
    """


@generic
def stability_ratio(method: Any, K: float, C: float) -> float:
    """Return the step over the method's linear stability limit: above 1 errors grow.

    K: stiffness over mass (1/s^2), C: damping over mass (1/s) of one body.
    """


def no_limit(method, K, C):
    """Return 0, the ``stability_ratio`` of a method without a stability limit."""
    return 0.0
