"""Rodas4P, a Rosenbrock method of fourth order: L-stable, stiffly accurate, six stages, without iteration.

With y = (q, v), F = (v, f), its Jacobian J and its time derivative F_t,

    (1/(h gamma) - J) u_i = F(t + c_i h, y + sum_k a_ik u_k) + sum_k (e_ik/h) u_k + d_i h F_t,   i = 1..6
    y1 = y + sum_k a_6k u_k + u_6,   error u_6

Each stage is one solution with an arrow matrix: with u_i = (p, r) and the right-hand side (g_q, g_v),

    (I - h gamma A_v - (h gamma)^2 A_q) r = h gamma g_v + (h gamma)^2 A_q g_q,   p = h gamma (r + g_q).

Source: Steinebach, Order-reduction of ROW-methods for DAEs and method of lines applications, Preprint 1741, TH
Darmstadt 1995; form and dense output: Hairer and Wanner, Solving ODEs II, sec. IV.7. It has no order reduction on
stiff forced motion, in contrast to Rodas4, whose order falls to one in the velocity (docs/methods.md).
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.adaptive import (
    END_Q,
    END_V,
    METHOD_STATES,
    START_A,
    START_Q,
    START_V,
    TIME_ROUNDING,
    error_norm,
    limit_jump_error,
    register_adaptive,
)
from bearingsim.core.methods.arrow import assemble_system, factorise, multiply, solve
from bearingsim.core.methods.interface import MethodKind, attempt, interpolate
from bearingsim.core.models.interface import accelerations, linearise, state_width

STAGES = 6
GAMMA = 0.25
# coefficients a, e, c and d of the stages
A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0, 0.0, 0.0, 0.0, 0.0],
        [1.831036793486759, 0.4955183967433795, 0.0, 0.0, 0.0],
        [2.304376582692669, -0.05249275245743001, -1.176798761832782, 0.0, 0.0],
        [-7.170454962423024, -4.741636671481785, -16.31002631330971, -1.062004044111401, 0.0],
        [-7.170454962423024, -4.741636671481785, -16.31002631330971, -1.062004044111401, 1.0],
    ]
)
E = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-12.0, 0.0, 0.0, 0.0, 0.0],
        [-8.791795173947035, -2.207865586973518, 0.0, 0.0, 0.0],
        [10.81793056857153, 6.780270611428266, 19.5348594464241, 0.0, 0.0],
        [34.19095006749676, 15.49671153725963, 54.7476087596413, 14.16005392148534, 0.0],
        [34.62605830930532, 15.30084976114473, 56.99955578662667, 18.40807009793095, -5.714285714285717],
    ]
)
C = np.array([0.0, 0.75, 0.21, 0.63, 1.0, 1.0])
D = np.array([0.25, -0.5, -0.023504, -0.0362, 0.0, 0.0])
DENSE = np.array(  # coefficients of u_k for dense output (``_interpolate``)
    [
        [25.09876703708589, 11.62013104361867, 28.49148307714626, -5.664021568594133, 0.0, 0.0],
        [1.638054557396973, -0.7373619806678748, 8.47791821923899, 15.9925314877952, -1.882352941176471, 0.0],
    ]
)
# increment for the time derivative, relative to the step; a larger one reduces the order on stiff motion
TIME_INCREMENT = 1e-6

# df/dt; right-hand side (g_q, g_v) of the current stage
TIME_DERIVATIVE, RIGHT_Q, RIGHT_V = lay.states(METHOD_STATES, "m/s^3, m, m/s", "rodas", "step")
STAGE_BLOCKS = lay.states(RIGHT_V + lay.STATE, "m, m/s", "rodas", "step", count=STAGES)[0]  # p and r of each stage


class Rodas(NamedTuple):
    """Parameters of Rodas4P; see ``Tolerances``."""

    h: float
    rtol: float
    atol_q: float
    atol_v: float
    longest: float


@jit
def time_derivative(model, t, h, y, n):
    """Store df/dt at the start of the step, from one evaluation of the same state at a slightly later time.

    The Jacobian is also that of the later time.
    """
    for j in range(n):
        y[lay.POSITION + j] = y[START_Q + j]
        y[lay.VELOCITY + j] = y[START_V + j]
    t_later = t + max(TIME_INCREMENT * h, TIME_ROUNDING * abs(t))
    accelerations(model, t_later, y)
    linearise(model, t_later, y)
    for j in range(n):
        y[TIME_DERIVATIVE + j] = (y[lay.ACCELERATION + j] - y[START_A + j]) / (t_later - t)


@jit
def begin_stage(i, h, y, n):
    """Set the state of stage ``i``, and its right-hand side except F."""
    for j in range(n):
        y[lay.POSITION + j] = y[START_Q + j]
        y[lay.VELOCITY + j] = y[START_V + j]
        y[RIGHT_Q + j] = 0.0
        y[RIGHT_V + j] = D[i] * h * y[TIME_DERIVATIVE + j]
    for k in range(i):
        a, e = A[i, k], E[i, k] / h
        block = STAGE_BLOCKS + 2 * k * lay.STATE
        p, r = y[block : block + n], y[block + lay.STATE : block + lay.STATE + n]
        for j in range(n):
            y[lay.POSITION + j] += a * p[j]
            y[lay.VELOCITY + j] += a * r[j]
            y[RIGHT_Q + j] += e * p[j]
            y[RIGHT_V + j] += e * r[j]


@jit
def end_stage(model, i, h, y, n):
    """Add F to the right-hand side of stage ``i`` and solve for p and r."""
    h_gamma = GAMMA * h
    p, r = STAGE_BLOCKS + 2 * i * lay.STATE, STAGE_BLOCKS + (2 * i + 1) * lay.STATE
    for j in range(n):
        y[RIGHT_Q + j] += y[lay.VELOCITY + j]
        y[RIGHT_V + j] += y[lay.ACCELERATION + j]
        y[r + j] = 0.0  # unused entries, too: an earlier non-finite state may have left NaN there
    multiply(model, lay.POSITION_JACOBIAN, RIGHT_Q, r, y)
    for j in range(n):
        y[r + j] = h_gamma * (y[RIGHT_V + j] + h_gamma * y[r + j])
    solve(model, r, y)
    for j in range(n):
        y[p + j] = h_gamma * (y[r + j] + y[RIGHT_Q + j])


@attempt.register(Rodas)
def _attempt(method, model, t, h, y):
    n = state_width(model)
    time_derivative(model, t, h, y, n)
    assemble_system(model, (GAMMA * h) ** 2, GAMMA * h, y)
    factorise(model, y)
    for j in range(n):
        y[lay.ACCELERATION + j] = y[START_A + j]
    for i in range(STAGES):
        begin_stage(i, h, y, n)
        if i > 0:
            accelerations(model, t + C[i] * h, y)
        end_stage(model, i, h, y, n)
    last_stage = STAGE_BLOCKS + 2 * (STAGES - 1) * lay.STATE
    for j in range(n):
        y[lay.POSITION + j] += y[last_stage + j]
        y[lay.VELOCITY + j] += y[last_stage + lay.STATE + j]
    accelerations(model, t + h, y)
    y[lay.EVALUATIONS] += STAGES + 1.0
    return limit_jump_error(error_norm(method, last_stage, last_stage + lay.STATE, y, n), h)


@interpolate.register(Rodas)
def _interpolate(method, s, h, y, n):
    """Interpolate with third order: (1 - s) y + s (y1 + (1 - s) sum_k (DENSE_0k + s DENSE_1k) u_k)."""
    for j in range(n):
        y[lay.POSITION + j] = (1.0 - s) * y[START_Q + j] + s * y[END_Q + j]
        y[lay.VELOCITY + j] = (1.0 - s) * y[START_V + j] + s * y[END_V + j]
    for k in range(STAGES):
        weight = s * (1.0 - s) * (DENSE[0, k] + s * DENSE[1, k])
        block = STAGE_BLOCKS + 2 * k * lay.STATE
        for j in range(n):
            y[lay.POSITION + j] += weight * y[block + j]
            y[lay.VELOCITY + j] += weight * y[block + lay.STATE + j]


register_adaptive(Rodas, order=4.0, weight=0.0)

KIND = MethodKind(Rodas, evaluations=STAGES + 1, fraction=1.0, per_period=1, cusp=1 / 2, order=4, lag=0.0)
