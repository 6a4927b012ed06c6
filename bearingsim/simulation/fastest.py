"""Largest eigenvalues of stiffness and damping over mass of a bearing at rest.

The accelerations are linearised:

    a(q + dq, v + dv) = a(q, v) - K dq - C dv

Usually the monitored bodies (``core/advance.py``) limit the step, because the rollers are the lightest. A ring
that is lighter, or more stiffly supported by its bracket or shaft, has larger eigenvalues. The largest eigenvalues
of K and C of all bodies are computed by power iteration, with matrix products from differences of two evaluations
of the model.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.interface import harmonics, state_width

# power iterations that detect an eigenvalue four times larger, and that converge to it
SEARCH_ITERATIONS, REFINE_ITERATIONS = 3, 24
RELATIVE_DISPLACEMENT = 1e-3  # displacement over the approach at rest, small enough for linear contacts


class Rates(NamedTuple):
    """Largest eigenvalues of stiffness (1/s^2) and damping (1/s) over mass."""

    K: float
    C: float

    @property
    def fastest(self) -> float:
        """Largest eigenvalue magnitude (1/s) of an oscillator of K and C, which limits explicit steps."""
        omega = sqrt(self.K)
        return fastest_rate(omega, self.C / (2.0 * omega)) if omega > 0.0 else self.C


def fastest_rate(omega: float, zeta: float) -> float:
    """Return the largest eigenvalue magnitude (1/s) of an oscillator; omega: rad/s, zeta: damping ratio."""
    return omega * (zeta + sqrt(zeta * zeta - 1.0) if zeta > 1.0 else 1.0)


def rates_at_rest(
    model: Any, t: float, y: np.ndarray, approach: float, iterations: int = REFINE_ITERATIONS
) -> Rates:
    """Compute the rates of a bearing at rest at time ``t`` (s).

    y: buffer in equilibrium, changed and restored; approach: that of the most loaded contact (m).
    """
    position_scales, velocity_scales = length_factors(model).reshape(2, lay.STATE)
    displacement = RELATIVE_DISPLACEMENT * approach
    K = _largest(model, t, y, lay.POSITION, position_scales, displacement, iterations)
    return Rates(K, _largest(model, t, y, lay.VELOCITY, velocity_scales, displacement * sqrt(K), iterations))


def _largest(
    model: Any, t: float, y: np.ndarray, block: int, scales: np.ndarray, size: float, iterations: int
) -> float:
    """Return the largest eigenvalue of minus the Jacobian of the accelerations in a block of the state.

    block: offset of the block in the buffer; scales: (STATE,) as from ``length_factors``; size: largest change of
    an entry as a length or speed (m or m/s).
    """
    cells = np.flatnonzero(scales)
    scales, state_cells, acceleration_cells = scales[cells], block + cells, lay.ACCELERATION + cells
    rest_state, rest_acceleration = y[state_cells].copy(), y[acceleration_cells].copy()
    product, value = np.random.default_rng(0).standard_normal(len(cells)), 0.0
    for _ in range(iterations):
        step = product * (size / (float(np.abs(product).max()) or 1.0))
        y[state_cells] = rest_state + step / scales
        start_at_rest(model, t, y)
        product = scales * (rest_acceleration - y[acceleration_cells])
        value = float(np.linalg.norm(product)) / (float(np.linalg.norm(step)) or 1.0)
    y[state_cells] = rest_state
    start_at_rest(model, t, y)
    return value


def length_factors(model: Any) -> np.ndarray:
    """Return the factors (2 STATE,), m or 1, that convert positions and velocities into lengths and speeds.

    The factor is 0 for the rotation angle of a roller, which is unbounded (only its speed is used), and for
    entries outside of the model's state.
    """
    cells = np.full((2, 6, lay.ROW), model.bearing.R_o)
    cells[:, 0, lay.FIRST_LANE :] = 1.0
    cells[:, 3] = 1.0
    cells[:, 0, [lay.X, lay.Y, lay.X_C, lay.Y_C, lay.X_I, lay.Y_I]] = 1.0
    cells[0, 2, lay.FIRST_LANE :] = 0.0
    if harmonics(model) > 0:  # bending modes, in the cells of roller angles
        cells[:, 1:3] = 1.0
    cells.reshape(2, -1)[:, state_width(model) :] = 0.0
    return cells.ravel()
