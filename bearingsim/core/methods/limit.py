"""How long a step an explicit method may take on q'' = -K q - C q': from what one step makes of any (q, v).

The limit depends on the damping ratio zeta = C/(2 omega), omega^2 = K, alone once it is divided by that of symplectic
Euler, h_c = (2/omega)(sqrt(1 + zeta^2) - zeta) = 4/(C + sqrt(C^2 + 4 K)), whose product with the larger of stiffness
and damping never vanishes. The ratio is tabulated over zeta/(1 + zeta), which is 1/2 where oscillation ends.
"""

from math import sqrt
from typing import Any

import numpy as np

from bearingsim.core.jit import jit

NODES = 129
SCANNED = 4000  # steps tried for each node
ROUNDING = 1e-9  # growth below it is none


@jit
def critical_step(K, C):
    """h_c (s) of symplectic Euler; K in 1/s^2, C in 1/s, not both 0."""
    return 4.0 / (C + sqrt(C * C + 4.0 * K))


@jit
def looked_up(limits, h, K, C):
    """Step ``h`` (s) over a method's limit; ``limits``: from ``limit_over_h_c``."""
    if K <= 0.0 and C <= 0.0:
        return 0.0
    place = (NODES - 1) * C / (C + 2.0 * sqrt(max(K, 0.0)))
    k = min(int(place), NODES - 2)
    ratio = limits[k] + (place - k) * (limits[k + 1] - limits[k])
    return h / (ratio * critical_step(K, C))


def oscillator(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """K and C of the oscillator with h_c = 1 at zeta/(1 + zeta) = u (0 to 1)."""
    share = 2.0 * (1.0 - u)  # of omega in C + 2 omega = 2 omega (1 + zeta), taken as 2
    K, C = share * share / 4.0, 2.0 * u
    scale = 4.0 / (C + np.sqrt(C * C + 4.0 * K))
    return K * scale * scale, C * scale


def amplification(tableau: Any, K: np.ndarray, C: np.ndarray) -> np.ndarray:
    """What a step of 1 s makes of q and of v: (..., 2, 2), by the table itself; K, C: (...)."""
    made = np.empty((*K.shape, 2, 2))
    for column, (q, v) in enumerate(((1.0, 0.0), (0.0, 1.0))):
        f = np.zeros((len(tableau.c), *K.shape))
        for i, c in enumerate(tableau.c):
            q_i = q + c * v + np.tensordot(tableau.A[i, :i], f[:i], 1)
            v_i = v + np.tensordot(tableau.a[i, :i], f[:i], 1)
            f[i] = -K * q_i - C * v_i
        made[..., 0, column] = q + v + np.tensordot(tableau.B, f, 1)
        made[..., 1, column] = v + np.tensordot(tableau.b, f, 1)
    return made


def growth(M: np.ndarray) -> np.ndarray:
    """Spectral radius of each 2 x 2 matrix (..., 2, 2)."""
    half, det = 0.5 * (M[..., 0, 0] + M[..., 1, 1]), M[..., 0, 0] * M[..., 1, 1] - M[..., 0, 1] * M[..., 1, 0]
    below = half * half - det
    return np.where(below < 0.0, np.sqrt(np.abs(det)), np.abs(half) + np.sqrt(np.maximum(below, 0.0)))


def limit_over_h_c(tableau: Any, longest: float = 40.0) -> np.ndarray:
    """(NODES,) the step from which on motion grows, over h_c, at zeta/(1 + zeta) from 0 to 1."""
    K, C = (row[:, None] for row in oscillator(np.linspace(0.0, 1.0, NODES)))
    h = longest * np.arange(1, SCANNED + 1) / SCANNED
    grows = growth(amplification(tableau, h * h * K, h * C)) > 1.0 + ROUNDING
    first = np.where(grows.any(axis=1), grows.argmax(axis=1), SCANNED - 1)
    low, high = h[first] - h[0], h[first]
    for _ in range(40):
        middle = 0.5 * (low + high)
        over = growth(amplification(tableau, middle**2 * K[:, 0], middle * C[:, 0])) > 1.0 + ROUNDING
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return low
