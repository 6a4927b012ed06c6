"""Boundary elements of half-planes: displacement under a pressure that is linear between nodes.

A line load P (N/m) on a half-plane lowers its surface at the distance r by P/(pi E*) ln(D/r) (Flamant; Johnson,
Contact Mechanics 1985, section 2.2), where E* = E/(2 (1 - nu^2)) is that of two bodies. In plane strain the
displacement is defined up to a constant; D is the distance at which it is zero. For both bodies it doubles.
"""

from math import e, log, pi, sqrt

import numpy as np

from benchmarks.edges.contact import Body


def johnson_datum(R_1: float, R_2: float) -> float:
    """Compute D (m) for which Hertz's contact gives Johnson's approach of two cylinder axes.

    Under Hertz's pressure two half-planes approach by Q'/(pi E*) [2 ln(2 D/b) + 1], Johnson's two cylinders
    (section 5.6) by Q'/(pi E*) [ln(16 R_1 R_2/b^2) - 1].
    """
    return 2.0 * sqrt(R_1 * R_2) / e


def hertz_approach(force: float, b: float, E_star: float, D: float) -> float:
    """Compute the approach (m) of two half-planes under Hertz's pressure: Q'/(pi E*) [2 ln(2 D/b) + 1].

    ``force`` in N/m.
    """
    return force / (pi * E_star) * (2.0 * log(2.0 * D / b) + 1.0)


def hat_integrals(t: np.ndarray, breaks: tuple[int, ...] = ()) -> np.ndarray:
    """Integrate the hat functions (m) of the nodes; zero pressure between n and n + 1 for n in ``breaks``."""
    lengths = element_lengths(t, breaks)
    return 0.5 * (np.append(lengths, 0.0) + np.append(0.0, lengths))


def element_lengths(t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Compute the lengths (m) of the elements; 0 at breaks."""
    lengths = np.diff(t)
    lengths[list(breaks)] = 0.0
    return lengths


def log_integrals(x: np.ndarray, t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Integrate hat_j(t) ln|x_i - t| dt, (len(x), len(t)) in m, for lengths in m.

    Antiderivatives with v = t - x: v ln|v| - v of ln|v|, and v^2/2 ln|v| - v^2/4 of v ln|v|.
    """
    v = t[None, :] - x[:, None]
    logs = np.log(np.where(v == 0.0, 1.0, np.abs(v)))
    log_integral, v_log_integral = np.diff(v * logs - v, axis=1), np.diff(v * v * (0.5 * logs - 0.25), axis=1)
    lengths = element_lengths(t, breaks)
    rising = np.where(lengths > 0.0, (v_log_integral - v[:, :-1] * log_integral) / np.diff(t), 0.0)
    falling = np.where(lengths > 0.0, log_integral - rising, 0.0)
    integrals = np.zeros(v.shape)
    integrals[:, 1:] += rising
    integrals[:, :-1] += falling
    return integrals


def half_plane(t: np.ndarray, E_star: float, D: float, breaks: tuple[int, ...] = ()) -> np.ndarray:
    """Compute the compliance (n, n) (m/Pa) of one half-plane at the nodes ``t`` (m)."""
    return (log(D) * hat_integrals(t, breaks)[None, :] - log_integrals(t, t, breaks)) / (pi * E_star)


def two_half_planes(t: np.ndarray, E_star: float, D: float, breaks: tuple[int, ...] = ()) -> Body:
    """Return roller and race as half-planes with nodes ``t`` (m) in ascending order."""
    return Body(t, 2.0 * half_plane(t, E_star, D, breaks), hat_integrals(t, breaks))
