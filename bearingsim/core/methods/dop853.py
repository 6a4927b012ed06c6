"""DOP853: Dormand and Prince's method of order 8, with error estimates of orders 5 and 3 and dense output of order
7.

Source: Hairer, Norsett and Wanner, Solving ODEs I, 2nd ed. 1993, sec. II.5 (method), II.10 (error, here eq. 10.17
with the norm of ``adaptive``), II.6 (dense output). A step needs twelve evaluations, and three more if a recorded
instant lies within it.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.methods.adaptive import METHOD_STATES, START_A, error_norm, register_adaptive
from bearingsim.core.methods.dop853_table import B_3, E_5, EXTENSION_ROWS, STAGE_ROWS
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.methods.tableau import (
    continuous_extension,
    dense_state,
    estimate_error,
    evaluate_stages,
    make_runge_kutta,
    make_stage_rows,
    save_accelerations,
    stage_state,
    weights_tuple,
)
from bearingsim.core.models.interface import accelerations, state_width

ORDER, STAGES, DENSE_STAGES = 8, 12, 16  # order, stages of a step, stages including those for dense output


def expand_rows(rows: dict[int, dict[int, float]], count: int, columns: int) -> np.ndarray:
    """Return the sparse ``rows`` of a table, {row: {column: number}}, as an array (count, columns)."""
    table = np.zeros((count, columns))
    for i, row in rows.items():
        table[i, list(row)] = list(row.values())
    return table


TABLE = make_runge_kutta(expand_rows(STAGE_ROWS, DENSE_STAGES, DENSE_STAGES), np.zeros(DENSE_STAGES))
_, a, A, _, _ = TABLE
ROWS, DENSE_ROWS = make_stage_rows(TABLE, 1, STAGES), make_stage_rows(TABLE, STAGES + 1, DENSE_STAGES)
b, B = weights_tuple(a[STAGES, :STAGES]), weights_tuple(A[STAGES, :STAGES])
ERROR_5 = expand_rows({0: E_5}, 1, DENSE_STAGES)[0]
ERROR_3 = a[STAGES] - expand_rows({0: B_3}, 1, DENSE_STAGES)[0]
E_5_V, E_5_Q = weights_tuple(ERROR_5[:STAGES]), weights_tuple((ERROR_5 @ a)[:STAGES])
E_3_V, E_3_Q = weights_tuple(ERROR_3[:STAGES]), weights_tuple((ERROR_3 @ a)[:STAGES])
EXTENSION_V = continuous_extension(
    a[STAGES], STAGES, expand_rows(EXTENSION_ROWS, len(EXTENSION_ROWS), DENSE_STAGES)
)
EXTENSION_Q = EXTENSION_V @ a
F_Q, F_V = tuple(map(weights_tuple, EXTENSION_Q)), tuple(map(weights_tuple, EXTENSION_V))
"""Rows of the continuous extension of positions and velocities."""


class Dop853(NamedTuple):
    """Parameters of DOP853; see ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@attempt.register(Dop853)
def _attempt(method, model, t, h, y):
    n = state_width(model)
    for k in range(n):
        y[METHOD_STATES + k] = y[START_A + k]
    evaluate_stages(ROWS, model, t, h, y, n)
    stage_state(1.0, B, b, h, y, n)
    norm_5 = error_norm(method, *estimate_error(E_5_Q, E_5_V, h, y, n), y, n)
    norm_3 = error_norm(method, *estimate_error(E_3_Q, E_3_V, h, y, n), y, n)
    scale = sqrt(norm_5 * norm_5 + 0.01 * norm_3 * norm_3)
    error = norm_5 * norm_5 / scale if scale != 0.0 else 0.0
    if error <= 1.0:
        accelerations(model, t + h, y)
        save_accelerations(METHOD_STATES + STAGES * lay.STATE, y, n)
        y[lay.EVALUATIONS] += 1.0
    return error


def evaluate_dense_stages(method, model, y):
    """Evaluate the stages for dense output only (``complete_dense_output``)."""
    evaluate_stages(DENSE_ROWS, model, y[lay.T_START], y[lay.H_TAKEN], y, state_width(model))


@interpolate.register(Dop853)
def _interpolate(method, fraction, h, y, n):
    dense_state(F_Q, F_V, fraction, h, y, n)


register_adaptive(Dop853, float(ORDER), evaluate_dense_stages)

KIND = MethodKind(Dop853, evaluations=12, fraction=1.0, per_period=1, cusp=0.5, order=8, lag=0.0)
