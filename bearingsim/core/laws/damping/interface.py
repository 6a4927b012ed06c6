"""Functions of every damping law: the normal force, its derivatives, and bounds of them.

    Q = max(0, Q_e(delta) + damping(delta, v))   where delta > 0, else 0

delta: approach (m), positive in contact; v: its total rate (m/s), positive while closing.

``derivatives`` are exact, for the solution of implicit steps. Both are 0 without contact and where the force is
limited to 0; at a kink those of one side are used, as Newton's method for semismooth equations allows (Qi and Sun,
Mathematical Programming 58 (1993) 353). K can be negative, because a dashpot's resistance to opening increases
with the approach.

The bounds are for the monitor of explicit steps. They are non-negative, finite at rest and at touch-down, and
ignore the limit of the force.
"""

from typing import Any

from bearingsim.core.jit import generic, jit


@generic
def normal_force(contact: Any, delta: float, v: float) -> float:
    """Return the contact force (N, never pulling) at approach ``delta`` (m, any sign) and closing rate ``v``
    (m/s).

    Equation (C1) of docs/contact.md, (M3) of docs/model.md.
    """


@generic
def derivatives(contact: Any, delta: float, v: float) -> tuple[float, float]:
    """Return K = dQ/d(delta) (N/m) and C = dQ/dv (N s/m) at approach ``delta`` (m, any sign) and rate ``v``
    (m/s)."""


@generic
def stiffness_bound(contact: Any, delta: float, v: float) -> float:
    """Bound the derivative of the force with respect to the approach (N/m), at ``delta`` >= 0 and ``v``."""


@generic
def damping_bound(contact: Any, delta: float, v: float) -> float:
    """Bound the derivative of the force with respect to the closing rate (N s/m), at ``delta`` >= 0 and ``v``."""


@jit
def in_series(outer: float, inner: float) -> float:
    """Return the stiffness or damping of two contacts in series; 0 if one of them is 0."""
    return outer * inner / max(outer + inner, 1e-300)
