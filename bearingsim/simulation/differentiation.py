"""Velocity and acceleration of the ring, as finite differences of its recorded positions.

Used for adaptive methods, whose steps do not end at the recorded instants, and for models without a method, which
are solved for positions.
"""

from functools import cache
from math import factorial

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.simulation.channels import FEATURE_CELLS

MOTION_ROWS = (
    (slice(0, 2), slice(2, 4), slice(4, 6)),
    (
        slice(len(FEATURE_CELLS), len(FEATURE_CELLS) + 1),
        slice(len(FEATURE_CELLS) + 1, len(FEATURE_CELLS) + 2),
        slice(len(FEATURE_CELLS) + 2, len(FEATURE_CELLS) + 3),
    ),
)
"""Rows of position, velocity, acceleration in a recording: of the ring, and at the sensor on a flexible ring."""
STENCIL_HALF_LENGTH = 4  # columns on each side of the centre of a finite difference


def derives_velocity(case: Case) -> bool:
    """Check if velocity and acceleration of the ring are finite differences of its positions."""
    return case.method is None or assemble.is_adaptive(case)


def differentiate(values: np.ndarray, motion_rows: tuple[slice, slice, slice], column: int, h: float) -> None:
    """Write velocity and acceleration as differences of positions, from ``column`` - STENCIL_HALF_LENGTH on.

    values: (C, n) recorded rows in SI, at intervals of ``h`` s; motion_rows: an element of ``MOTION_ROWS``;
    column: at least 2 STENCIL_HALF_LENGTH.

    An adaptive method takes several steps between recorded instants, and a model without a method has an impulse
    or a cusp between them. If the velocity jumps, the mean of its samples is wrong, whereas differences of
    positions sum to the displacement. The differences are of eighth order: the velocity is accurate to 1e-3 up to
    0.15 of the column rate, the upper limit of the fine samples' pass band. The last STENCIL_HALF_LENGTH columns,
    which lack neighbours, have differences of lower order, and are overwritten in the next pass.
    """
    position, velocity, acceleration = (values[rows] for rows in motion_rows)
    n = values.shape[1]
    central = slice(column - STENCIL_HALF_LENGTH, n - STENCIL_HALF_LENGTH), STENCIL_HALF_LENGTH
    for columns, half_length in (
        central,
        *((slice(n - 1 - r, n - r), r) for r in range(STENCIL_HALF_LENGTH - 1, 0, -1)),
    ):
        first_weights, second_weights = difference_weights(half_length)
        velocity[:, columns], acceleration[:, columns] = 0.0, 0.0
        for k in range(1, half_length + 1):
            centre, after, before = (position[:, columns.start + m : columns.stop + m] for m in (0, k, -k))
            velocity[:, columns] += first_weights[k - 1] / h * (after - before)
            acceleration[:, columns] += second_weights[k - 1] / h**2 * ((after - centre) - (centre - before))
    velocity[:, -1] = (position[:, -1] - position[:, -2]) / h
    acceleration[:, -1] = acceleration[:, -2]


@cache
def difference_weights(half_length: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return weights of u(k h) - u(-k h) in h u', and of u(k h) - 2 u(0) + u(-k h) in h^2 u''.

    k: 1 to ``half_length``. The order of accuracy is 2 ``half_length``. Source: Fornberg 1988.
    """
    coefficients = [
        (-1) ** (k + 1) * factorial(half_length) ** 2 / (factorial(half_length - k) * factorial(half_length + k))
        for k in range(1, half_length + 1)
    ]
    return tuple(s / k for k, s in enumerate(coefficients, 1)), tuple(
        2.0 * s / k**2 for k, s in enumerate(coefficients, 1)
    )
