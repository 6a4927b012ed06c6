"""Dormand and Prince's method of order 5, with an error estimate and dense output of order 4.

Source: Dormand and Prince, J. Comput. Appl. Math. 6 (1980) 19-26; coefficients and continuous extension from
Hairer, Norsett and Wanner, Solving ODEs I, 2nd ed. 1993, table II.5.2 and sec. II.6. The last stage is the first
stage of the next step (FSAL), so a step needs six evaluations.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.methods.adaptive import METHOD_STATES, START_A, error_norm, register_adaptive
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.methods.tableau import (
    continuous_extension,
    dense_state,
    estimate_error,
    evaluate_stages,
    make_runge_kutta,
    make_stage_rows,
    weights_tuple,
)
from bearingsim.core.models.interface import state_width

ORDER, STAGES = 5, 7

a = np.zeros((STAGES, STAGES))
a[1, :1] = 1 / 5
a[2, :2] = 3 / 40, 9 / 40
a[3, :3] = 44 / 45, -56 / 15, 32 / 9
a[4, :4] = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
a[5, :5] = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
a[6, :6] = 35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
TABLE = make_runge_kutta(a, a[6])
ROWS, b = make_stage_rows(TABLE, 1, STAGES), TABLE.b  # the last stage is the new state
EMBEDDED = np.array([5179 / 57600, 0.0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40])
E_V, E_Q = weights_tuple(b - EMBEDDED), weights_tuple((b - EMBEDDED) @ a)
DENSE_ROW = np.array(
    [
        -12715105075 / 11282082432,
        0.0,
        87487479700 / 32700410799,
        -10690763975 / 1880347072,
        701980252875 / 199316789632,
        -1453857185 / 822651844,
        69997945 / 29380423,
    ]
)
EXTENSION_V = continuous_extension(b, STAGES - 1, DENSE_ROW[None, :])
EXTENSION_Q = EXTENSION_V @ a
F_Q, F_V = tuple(map(weights_tuple, EXTENSION_Q)), tuple(map(weights_tuple, EXTENSION_V))
"""Rows of the continuous extension of positions and velocities."""


class DormandPrince(NamedTuple):
    """Parameters of Dormand and Prince's method; see ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@attempt.register(DormandPrince)
def _attempt(method, model, t, h, y):
    n = state_width(model)
    for k in range(n):
        y[METHOD_STATES + k] = y[START_A + k]
    evaluate_stages(ROWS, model, t, h, y, n)
    return error_norm(method, *estimate_error(E_Q, E_V, h, y, n), y, n)


@interpolate.register(DormandPrince)
def _interpolate(method, fraction, h, y, n):
    dense_state(F_Q, F_V, fraction, h, y, n)


register_adaptive(DormandPrince, float(ORDER))

KIND = MethodKind(DormandPrince, evaluations=6, fraction=1.0, per_period=1, cusp=0.5, order=5, lag=0.0)
