"""Functions of every elastic law: the force Q_e(delta), for example k delta^m1, and its derivatives.

delta: approach (m), positive in contact. All laws except ``PowerLaw``, which uses ``pow``, allow the compiler to
vectorise loops over rollers.
"""

from typing import Any

import numpy as np

from bearingsim.core.jit import generic, jit

MIN_APPROACH = 1e-12  # m: minimum approach for evaluating a derivative that is infinite at touch-down


@generic
def elastic(law: Any, delta: float) -> float:
    """Return the elastic force (N) at approach ``delta`` >= 0 (m)."""


@generic
def tangent(law: Any, delta: float) -> float:
    """Return the derivative of the elastic force (N/m) at approach ``delta`` >= 0 (m)."""


@generic
def curvature(law: Any, delta: float) -> float:
    """Return the derivative of the tangent stiffness, d2Q/d(delta)2 (N/m^2), at approach ``delta`` >= 0 (m)."""


@jit
def fill_law_values(law: Any, delta: Any, Q: Any, k: Any) -> None:
    """Fill ``Q`` with elastic forces (N) and ``k`` with tangent stiffnesses (N/m) at approaches ``delta`` (m)."""
    for i in range(len(delta)):
        Q[i], k[i] = elastic(law, delta[i]), tangent(law, delta[i])


def evaluate_law(law: Any, delta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return elastic forces (n,), N, and tangent stiffnesses (n,), N/m, at approaches ``delta`` (n,) > 0, m."""
    Q, k = np.empty_like(delta), np.empty_like(delta)
    fill_law_values(law, delta, Q, k)
    return Q, k
