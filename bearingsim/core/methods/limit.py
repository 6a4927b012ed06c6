"""Largest stable step of an explicit method on q'' = -K q - C q', from the amplification matrix of one step.

The limit is tabulated in units of that of symplectic Euler,

    h_c = (2/omega)(sqrt(1 + zeta^2) - zeta) = 4/(C + sqrt(C^2 + 4 K)),   omega^2 = K,   zeta = C/(2 omega)

In these units it depends only on the damping ratio zeta, from no damping to no stiffness (``table_position``).
"""

from math import acos, pi, sqrt
from typing import Any

import numpy as np

from bearingsim.core.jit import jit

NODES = 129  # of the table
TRIAL_SPACING = 0.1  # spacing of trial steps for each node, in units of h_c
MAX_TRIAL_STEP = 0.8  # in units of h_c times the squared number of stages: above the limit of every method
ROUNDING = 1e-9  # a spectral radius up to 1 plus this value counts as stable
LIMIT_SAFETY = 0.999  # relative to the limit; margin for the error of linear interpolation between nodes


@jit
def critical_step(K, C):
    """Return h_c (s) of symplectic Euler; K in 1/s^2, C in 1/s, not both 0."""
    return 4.0 / (C + sqrt(C * C + 4.0 * K))


@jit
def table_position(K, C):
    """Return an oscillator's position in the table, 0 to 1.

    Up to 1/2 it follows from the angle of the complex root of the oscillator, beyond from its faster real root.
    The limit of a method whose stability depends only on the root thus has no kink at critical damping.
    """
    if C * C < 4.0 * K:
        return 0.5 - acos(0.5 * C / sqrt(K)) / pi
    return 1.0 - K / (C * C) if 1e6 * sqrt(K) < C else 1.0 - sqrt(K) / (C + sqrt(C * C - 4.0 * K))


@jit
def step_over_limit(limits, h, K, C):
    """Return the step ``h`` (s) over a method's limit; inf if K or C is not finite.

    limits: table of the method (``tabulate_limits``); K in 1/s^2, C in 1/s.
    """
    if K <= 0.0 and C <= 0.0:
        return 0.0
    position = (NODES - 1) * table_position(max(K, 0.0), max(C, 0.0))
    if not position >= 0.0:
        return np.inf
    k = min(int(position), NODES - 2)
    ratio = limits[k] + (position - k) * (limits[k + 1] - limits[k])
    return h / (ratio * critical_step(max(K, 0.0), max(C, 0.0)))


def make_oscillators() -> tuple[np.ndarray, np.ndarray]:
    """Return K (NODES,) 1/s^2 and C (NODES,) 1/s of the oscillators of the table, each with h_c = 1 s."""
    positions = np.linspace(0.0, 1.0, NODES)
    ratio = np.minimum(2.0 * (1.0 - positions), 1.0)  # omega over the faster root
    zeta = np.where(positions < 0.5, np.sin(pi * positions), 0.5 * (ratio + 1.0 / np.maximum(ratio, 1e-9)))
    C = 4.0 / (1.0 + np.sqrt(1.0 + 1.0 / np.maximum(zeta, 1e-9) ** 2))
    return np.where(zeta > 0.0, (C / np.maximum(2.0 * zeta, 1e-9)) ** 2, 4.0), C


def amplification_matrices(tableau: Any, K: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return the tableau's amplification matrices (2, 2, ...) of q and v for a step of 1 s.

    K, C: (...), of the oscillators (1/s^2, 1/s).
    """
    matrices = np.empty((2, 2, *K.shape))
    for column, (q, v) in enumerate(((1.0, 0.0), (0.0, 1.0))):
        f = np.zeros((len(tableau.c), K.size))
        for i, c in enumerate(tableau.c):
            q_i, v_i = q + c * v + tableau.A[i] @ f, v + tableau.a[i] @ f
            f[i] = -K.ravel() * q_i - C.ravel() * v_i
        matrices[0, column] = (q + v + tableau.B @ f).reshape(K.shape)
        matrices[1, column] = (v + tableau.b @ f).reshape(K.shape)
    return matrices


def spectral_radius(M: np.ndarray) -> np.ndarray:
    """Return the spectral radius of each 2 x 2 matrix (2, 2, ...)."""
    half_trace, det = 0.5 * (M[0, 0] + M[1, 1]), M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]
    D = half_trace * half_trace - det
    return np.where(D < 0.0, np.sqrt(np.abs(det)), np.abs(half_trace) + np.sqrt(np.maximum(D, 0.0)))


def tabulate_limits(tableau: Any) -> np.ndarray:
    """Return the stability limit over h_c, (NODES,), of a method at each oscillator of the table."""
    K, C = make_oscillators()

    def is_unstable(h: np.ndarray) -> np.ndarray:
        h, shape = np.broadcast_arrays(h, K[:, None])[0], (-1, 1)
        return (
            spectral_radius(amplification_matrices(tableau, h * h * K.reshape(shape), h * C.reshape(shape)))
            > 1.0 + ROUNDING
        )

    trial_steps = TRIAL_SPACING * np.arange(1, round(MAX_TRIAL_STEP * len(tableau.c) ** 2 / TRIAL_SPACING) + 1)
    unstable = is_unstable(trial_steps)
    high = trial_steps[np.where(unstable.any(axis=1), unstable.argmax(axis=1), -1)]
    low = high - trial_steps[0]
    for _ in range(30):
        midpoint = 0.5 * (low + high)
        is_above = is_unstable(midpoint[:, None])[:, 0]
        low, high = np.where(is_above, low, midpoint), np.where(is_above, midpoint, high)
    return LIMIT_SAFETY * low
