"""Fastest rates of a bearing at rest: the largest eigenvalues of stiffness and damping over mass.

    a(q + dq, v + dv) = a(q, v) - K dq - C dv

The monitored bodies (``core/advance.py``), usually the rollers as the lightest, bound a step. A ring that is
lighter, or that its bracket or shaft holds harder, is faster. The largest eigenvalues of K and C are found by
power iteration, each product a difference of two evaluations of the model, so that no body is left out.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.interface import harmonics, state_width

# rounds of the power iteration: to detect a body four times faster; to converge to its rate
SEARCH, REFINE = 3, 24
SMALL = 1e-3  # of the approach at rest: a displacement in which the contacts are straight


class Rates(NamedTuple):
    """Largest eigenvalues of stiffness (1/s^2) and damping (1/s) over mass."""

    K: float
    C: float

    @property
    def fastest(self) -> float:
        """Largest eigenvalue (1/s) of a motion with both, which limits the step of an explicit method."""
        omega = sqrt(self.K)
        return fastest_rate(omega, self.C / (2.0 * omega)) if omega > 0.0 else self.C


def fastest_rate(omega: float, zeta: float) -> float:
    """Return the largest eigenvalue (1/s) of a motion by its angular frequency (1/s) and damping ratio."""
    return omega * (zeta + sqrt(zeta * zeta - 1.0) if zeta > 1.0 else 1.0)


def rates_at_rest(model: Any, t: float, y: np.ndarray, approach: float, rounds: int = REFINE) -> Rates:
    """Find the rates of a bearing at rest at time ``t`` (s), whose buffer ``y`` is left as it is.

    approach: of its most loaded contact (m).
    """
    position_scales, velocity_scales = lengths(model).reshape(2, lay.STATE)
    small = SMALL * approach
    K = _largest(model, t, y, lay.POSITION, position_scales, small, rounds)
    return Rates(K, _largest(model, t, y, lay.VELOCITY, velocity_scales, small * sqrt(K), rounds))


def _largest(model: Any, t: float, y: np.ndarray, block: int, arms: np.ndarray, size: float, rounds: int) -> float:
    """Return the largest eigenvalue of minus the Jacobian of the accelerations in a block of the state.

    arms: (STATE,) of each entry, m per unit, 0 if it is no state; size: largest change of an entry, m or m/s.
    """
    cells = np.flatnonzero(arms)
    arms, changed, accelerated = arms[cells], block + cells, lay.ACCELERATION + cells
    rest, still = y[changed].copy(), y[accelerated].copy()
    product, value = np.random.default_rng(0).standard_normal(len(cells)), 0.0
    for _ in range(rounds):
        step = product * (size / (float(np.abs(product).max()) or 1.0))
        y[changed] = rest + step / arms
        start_at_rest(model, t, y)
        product = arms * (still - y[accelerated])
        value = float(np.linalg.norm(product)) / (float(np.linalg.norm(step)) or 1.0)
    y[changed] = rest
    start_at_rest(model, t, y)
    return value


def lengths(model: Any) -> np.ndarray:
    """Return the factors (2 STATE,), m or 1, that turn positions and velocities into lengths and speeds.

    A roller's rotation grows without end and counts by its speed alone; entries that are no state of the model get
    0.
    """
    cells = np.full((2, 6, lay.ROW), model.bearing.R_o)
    cells[:, 0, lay.FIRST_LANE :] = 1.0
    cells[:, 3] = 1.0
    cells[:, 0, [lay.X, lay.Y, lay.X_C, lay.Y_C, lay.X_I, lay.Y_I]] = 1.0
    cells[0, 2, lay.FIRST_LANE :] = 0.0
    if harmonics(model) > 0:  # lengths, where other models have the rollers' angles
        cells[:, 1:3] = 1.0
    cells.reshape(2, -1)[:, state_width(model) :] = 0.0
    return cells.ravel()
