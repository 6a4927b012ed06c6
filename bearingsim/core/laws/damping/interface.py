"""Functions of every damping law: the force, its derivatives, and their bounds.

    Q = max(0, Q_e(delta) + damping(delta, v))   where delta > 0, else 0

delta: approach (m), positive in contact; v: its total rate (m/s), positive while closing.

``derivatives`` are exact: methods solve with them. Where the force is clamped, or nothing touches, both are 0: at
a kink one of its two sides is taken, as Newton's method for semismooth equations may (Qi and Sun, Mathematical
Programming 58 (1993) 353). K can be negative: a dashpot that holds a contact back does so more the deeper it is.

The bounds are what the monitor over explicit steps takes for them: never negative, finite at rest and at
touch-down, and regardless of the clamp.
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
    """Return the stiffness or damping of two contacts in series; 0 where one of them is 0."""
    return outer * inner / max(outer + inner, 1e-300)
