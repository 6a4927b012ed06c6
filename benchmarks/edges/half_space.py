"""Half-planes as boundary elements: displacement under pressure that is linear between nodes.

A line load P (N/m) on one half-plane lowers its surface, at the distance r, by P/(pi E*) ln(D/r) (Flamant;
Johnson, Contact Mechanics 1985, section 2.2), E* = E/(2 (1 - nu^2)) being that of two bodies. Plane strain
has no natural zero: D says at which distance the surface does not move. Both bodies: twice that.
"""

from math import e, log, pi, sqrt

import numpy as np

from benchmarks.edges.pressed import Body


def johnson_datum(R_1: float, R_2: float) -> float:
    """D (m) that makes Hertz's contact give Johnson's approach, each cylinder compressed from its axis.

    Twice Flamant under Hertz's pressure is Q'/(pi E*) [2 ln(2 D/b) + 1]; Johnson's two cylinders (section 5.6):
    Q'/(pi E*) [ln(16 R_1 R_2/b^2) - 1].
    """
    return 2.0 * sqrt(R_1 * R_2) / e


def hertz_approach(force: float, b: float, E_star: float, D: float) -> float:
    """Approach (m) of two half-planes under Hertz's pressure: Q'/(pi E*) [2 ln(2 D/b) + 1]; ``force`` in N/m."""
    return force / (pi * E_star) * (2.0 * log(2.0 * D / b) + 1.0)


def hats(t: np.ndarray, breaks: tuple[int, ...] = ()) -> np.ndarray:
    """Integrals (m) of the nodes' hat functions; no pressure between nodes ``n`` and n + 1 for n in ``breaks``."""
    steps = carrying(t, breaks)
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def carrying(t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Lengths (m) of the elements, 0 where there is none."""
    steps = np.diff(t)
    steps[list(breaks)] = 0.0
    return steps


def log_integrals(x: np.ndarray, t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """(len(x), len(t)) integrals (m) of hat_j(t) ln|x_i - t| dt, lengths in m.

    Over one element, with v = t - x: of ln|v| it is v ln|v| - v, of v ln|v| it is v^2/2 ln|v| - v^2/4.
    """
    v = t[None, :] - x[:, None]
    logs = np.log(np.where(v == 0.0, 1.0, np.abs(v)))
    plain, times_v = np.diff(v * logs - v, axis=1), np.diff(v * v * (0.5 * logs - 0.25), axis=1)
    steps = carrying(t, breaks)
    rising = np.where(steps > 0.0, (times_v - v[:, :-1] * plain) / np.diff(t), 0.0)
    falling = np.where(steps > 0.0, plain - rising, 0.0)
    found = np.zeros(v.shape)
    found[:, 1:] += rising
    found[:, :-1] += falling
    return found


def half_plane(t: np.ndarray, E_star: float, D: float, breaks: tuple[int, ...] = ()) -> np.ndarray:
    """Compliance (n, n) (m/Pa) of one half-plane at the nodes ``t`` (m)."""
    return (log(D) * hats(t, breaks)[None, :] - log_integrals(t, t, breaks)) / (pi * E_star)


def two_half_planes(t: np.ndarray, E_star: float, D: float, breaks: tuple[int, ...] = ()) -> Body:
    """Roller and race, both as half-planes, for nodes ``t`` (m) in growing order."""
    return Body(t, 2.0 * half_plane(t, E_star, D, breaks), hats(t, breaks))
