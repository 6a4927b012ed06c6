"""Dormand and Prince's method of order 8, with its estimate of orders 5 and 3 and dense output of order 7.

Source: Hairer, Norsett and Wanner, Solving ODEs I, 2nd ed. 1993, sec. II.5 (method), II.10 (estimate, here eq.
10.17 with the norm of ``adaptive``), II.6 (dense output). Twelve evaluations a step; three more if a recorded
instant lies within it.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.layout import EVALUATED, H_TAKEN, STATE, T_START
from bearingsim.core.methods.adaptive import SLOPES, START_A, drive, error_norm
from bearingsim.core.methods.dop853_table import B_3, DENSE_ROWS, E_5, STAGE_ROWS
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.methods.tableau import (
    continuous_extension,
    estimate,
    find_slopes,
    keep_slopes,
    reach,
    runge_kutta,
    within,
)
from bearingsim.core.models.interface import accelerations, width

ORDER, STAGES, DENSE_STAGES = 8, 12, 16  # stages of a step, and with those of dense output


def full(rows: dict[int, dict[int, float]], count: int, columns: int) -> np.ndarray:
    """(count, columns) of a table's rows."""
    found = np.zeros((count, columns))
    for i, row in rows.items():
        found[i, list(row)] = list(row.values())
    return found


TABLE = runge_kutta(full(STAGE_ROWS, DENSE_STAGES, DENSE_STAGES), np.zeros(DENSE_STAGES))
c, a, A, _, _ = TABLE
b, B = a[STAGES], A[STAGES]
E_5_V = full({0: E_5}, 1, DENSE_STAGES)[0]
E_3_V = b - full({0: B_3}, 1, DENSE_STAGES)[0]
E_5_Q, E_3_Q = E_5_V @ a, E_3_V @ a
EXTENSION_V = continuous_extension(b, STAGES, full(DENSE_ROWS, len(DENSE_ROWS), DENSE_STAGES))
EXTENSION_Q = EXTENSION_V @ a


class Dop853(NamedTuple):
    """As ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@attempt.register(Dop853)
def _attempt(method, model, t, h, y):
    n = width(model)
    for k in range(n):
        y[SLOPES + k] = y[START_A + k]
    find_slopes(c, A, a, 1, STAGES, model, t, h, y, n)
    reach(1.0, B, b, STAGES, h, y, n)
    fifth = error_norm(method, *estimate(E_5_Q, E_5_V, STAGES, h, y, n), y, n)
    third = error_norm(method, *estimate(E_3_Q, E_3_V, STAGES, h, y, n), y, n)
    scale = sqrt(fifth * fifth + 0.01 * third * third)
    error = fifth * fifth / scale if scale != 0.0 else 0.0
    if error <= 1.0:
        accelerations(model, t + h, y)
        keep_slopes(SLOPES + STAGES * STATE, y, n)
        y[EVALUATED] += 1.0
    return error


def more_stages(method, model, y):
    """``complete``: the stages of the continuous extension."""
    find_slopes(c, A, a, STAGES + 1, DENSE_STAGES, model, y[T_START], y[H_TAKEN], y, width(model))


@interpolate.register(Dop853)
def _interpolate(method, part, h, y, n):
    within(EXTENSION_Q, EXTENSION_V, part, h, y, n)


drive(Dop853, float(ORDER), more_stages)

KIND = MethodKind(Dop853, evaluations=12, fraction=1.0, per_period=1, cusp=0.5, order=8, lag=0.0)
