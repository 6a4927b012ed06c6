"""``impulse``: the ring as two oscillators, along e_0 and e_90, driven by impulses at defect crossings.

    m x'' + C_x x' + K_x x = sum_k J_x,k delta(t - t_k),      and the same in y

x and y are displacements from the static equilibrium of the healthy bearing. After McFadden and Smith (J. Sound
Vib. 96, 1984, 69-82, one point defect; 98, 1985, 263-273, several): a train of impulses, each proportional to the
load at its position, acts on a linear system. In their papers the system is a resonance of the machine; here it is
the rigid ring on its rollers. Times and strengths: ``defects/impulse_train.py``.

Neglected: the rollers (no contact forces), the variation of stiffness as they pass, its drop while a roller is
unloaded, and the coupling of the two directions, whose mean over a ball pass vanishes.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.crossings import count_crossings
from bearingsim.core.jit import jit
from bearingsim.core.models.interface import ModelKind, register_solved_model, state_width, update_extremes
from bearingsim.core.parameters import Bearing


class Impulse(NamedTuple):
    """Parameters of the model: a mode along each axis, and the train of impulses.

    m: moving mass (kg); K_x, K_y: its stiffness at the static equilibrium (N/m), > 0; C_x, C_y: damping (N s/m),
    >= 0; times: (n,) s, ascending; J_x, J_y: (n,) N s.
    """

    bearing: Bearing
    m: float
    K_x: float
    K_y: float
    C_x: float
    C_y: float
    times: np.ndarray
    J_x: np.ndarray
    J_y: np.ndarray


@jit
def free_response(m, K, C, t):
    """Return the functions c (1) and s (s) of ``free_motion`` at ``t`` >= 0 (s).

    With beta = C/2m and D = K/m - beta^2: c = e^(-beta t) cos(sqrt(D) t), s = e^(-beta t) sin(sqrt(D) t)/sqrt(D),
    their hyperbolic continuation for D < 0, and a series around D = 0.
    """
    beta = C / (2.0 * m)
    D = K / m - beta * beta
    Dt2 = D * t * t
    if abs(Dt2) < 1e-4:
        decay = np.exp(-beta * t)
        return decay * (1.0 - Dt2 / 2.0 + Dt2 * Dt2 / 24.0), decay * t * (1.0 - Dt2 / 6.0 + Dt2 * Dt2 / 120.0)
    if D > 0.0:
        decay, omega = np.exp(-beta * t), np.sqrt(D)
        return decay * np.cos(omega * t), decay * np.sin(omega * t) / omega
    root = np.sqrt(-D)
    slow_decay = np.exp(-K / m / (beta + root) * t)  # (beta - root) without cancellation
    return 0.5 * slow_decay * (1.0 + np.exp(-2.0 * root * t)), -0.5 * slow_decay * np.expm1(-2.0 * root * t) / root


@jit
def free_motion(m, K, C, t, x, v):
    """Return exact displacement (m) and velocity (m/s) after ``t`` (s) of free motion from ``x`` and ``v``."""
    beta = C / (2.0 * m)
    c, s = free_response(m, K, C, t)
    return x * (c + beta * s) + v * s, v * (c - beta * s) - x * K / m * s


register_solved_model(Impulse)


@state_width.register(Impulse)
def _state_width(model):
    return lay.FIRST_LANE


@update_extremes.register(Impulse)
def _update_extremes(model, y):
    return None


@count_crossings.register(Impulse)
def _count_crossings(model, t, y):
    return None  # the train of impulses already contains every crossing


KIND = ModelKind(Impulse, per_crossing=8)
