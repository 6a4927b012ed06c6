"""Explicit methods defined by a table of coefficients, with one step function for all.

For q'' = f(t, q, v), with f_j the accelerations at the stages,

    q_i = q + c_i h v + h^2 sum_j A_ij f_j,   v_i = v + h sum_j a_ij f_j,   f_i = f(t + c_i h, q_i, v_i)

and the new state likewise with B and b (Nystrom 1925; Hairer, Norsett and Wanner, Solving ODEs I, sec. II.14). A
Runge-Kutta method has A = a a and B = b a; the results are the same except for rounding errors, without storing
rates of q. A step ends with the evaluation of the accelerations at its end, which are the first stage of the next.
"""

from typing import NamedTuple

import numpy as np
from numba import literal_unroll
from numba.cpython.unsafe.tuple import tuple_setitem

from bearingsim.core import layout as lay
from bearingsim.core.jit import inlined, jit
from bearingsim.core.methods.adaptive import METHOD_STATES, START_Q, START_V
from bearingsim.core.methods.interface import no_preparation, prepare, stability_ratio, step
from bearingsim.core.methods.limit import step_over_limit, tabulate_limits
from bearingsim.core.models.interface import accelerations, state_width

MAX_STAGES = 47
lay.states(METHOD_STATES, "m/s^2", "tableau", "step", count=MAX_STAGES)  # f_j of stage j in block j
ERROR_Q, ERROR_V = lay.states(METHOD_STATES + MAX_STAGES * lay.STATE, "m, m/s", "tableau", "step")


class Tableau(NamedTuple):
    """Coefficients. c: (s,); a, A: (s, s), strictly lower triangular; b, B: (s,). All dimensionless."""

    c: np.ndarray
    a: np.ndarray
    A: np.ndarray
    b: np.ndarray
    B: np.ndarray


StageRow = tuple[float, tuple[float, ...], tuple[float, ...]]
"""Stage: c_i, and the weights A_ij and a_ij of the preceding stages."""


def make_stage_rows(tableau: Tableau, begin: int, end: int) -> tuple[StageRow, ...]:
    """Return the rows of stages ``begin`` to ``end`` (excluded) as tuples, over which the compiler unrolls
    loops."""
    c, a, A, _, _ = tableau
    return tuple((float(c[i]), weights_tuple(A[i, :i]), weights_tuple(a[i, :i])) for i in range(begin, end))


def weights_tuple(values: np.ndarray) -> tuple[float, ...]:
    """Return weights (n,) as a tuple, whose length is a constant for the compiler."""
    return tuple(float(value) for value in values)


def make_runge_kutta(a: np.ndarray, b: np.ndarray) -> Tableau:
    """Return the table of a Runge-Kutta method."""
    return Tableau(a.sum(axis=1), a, a @ a, b, b @ a)


@inlined
def weighted_acceleration(weights, y, k):
    """Return sum_j weights[j] f_j of entry ``k`` of the state; weights: tuple.

    The number of terms is a constant, so the compiler unrolls the sum and vectorises loops over entries. If a loop
    contains the sums of positions and of velocities, the compiler does not unroll beyond about ten terms.
    """
    total, cell = 0.0, METHOD_STATES + k
    for j in range(len(weights)):
        total += weights[j] * y[cell]
        cell += lay.STATE
    return total


@inlined
def stage_state(c, weights_q, weights_v, h, y, n):
    """Set the state of a stage at the fraction ``c`` of the step from START, from the preceding stages."""
    dt, h_2 = c * h, h * h
    for k in range(n):
        y[lay.POSITION + k] = y[START_Q + k] + dt * y[START_V + k] + h_2 * weighted_acceleration(weights_q, y, k)
        y[lay.VELOCITY + k] = y[START_V + k] + h * weighted_acceleration(weights_v, y, k)


@jit
def save_accelerations(block, y, n):
    """Copy the accelerations into the block of a stage at ``block``."""
    for k in range(n):
        y[block + k] = y[lay.ACCELERATION + k]


@jit
def evaluate_stages(rows, model, t, h, y, n):
    """Evaluate the stages of ``rows`` (``make_stage_rows``) of the step of ``h`` (s) from ``t`` (s)."""
    for row in literal_unroll(rows):
        stage_state(row[0], row[1], row[2], h, y, n)
        accelerations(model, t + row[0] * h, y)
        save_accelerations(METHOD_STATES + len(row[1]) * lay.STATE, y, n)
    y[lay.EVALUATIONS] += len(rows)


@inlined
def estimate_error(weights_q, weights_v, h, y, n):
    """Compute the errors of positions and velocities from the weights (tuples) of the stages; return their
    blocks."""
    h_2 = h * h
    for k in range(n):
        y[ERROR_Q + k] = h_2 * weighted_acceleration(weights_q, y, k)
        y[ERROR_V + k] = h * weighted_acceleration(weights_v, y, k)
    return ERROR_Q, ERROR_V


def continuous_extension(b: np.ndarray, last: int, own_rows: np.ndarray) -> np.ndarray:
    """Return the rows F (3 + m, s) of a continuous extension.

    v(x) = v + h x (F_0 + (1 - x) (F_1 + x (F_2 + (1 - x) (F_3 + ...)))) f, x from 0 to 1. The first three rows are
    those of cubic Hermite interpolation. b: (s,), weights of the step; last: index of the stage at the end of the
    step; own_rows: (m, s), further rows of the method. Source: Hairer, Norsett and Wanner, Solving ODEs I, sec.
    II.6.
    """
    start_row, end_row = np.eye(len(b))[0], np.eye(len(b))[last]
    return np.array([b, start_row - b, 2.0 * b - start_row - end_row, *own_rows])


@inlined
def weights_at(F, fraction):
    """Return the weights of a continuous extension at ``fraction`` (0 to 1) of the step; F: its rows, tuples."""
    result = F[0]
    for j in range(len(result)):
        weight = 0.0
        for i in range(len(F) - 1, -1, -1):
            weight = (weight + F[i][j]) * (fraction if i % 2 == 0 else 1.0 - fraction)
        result = tuple_setitem(result, j, weight)
    return result


@inlined
def dense_state(F_q, F_v, fraction, h, y, n):
    """Set the state at ``fraction`` (0 to 1) of the step of ``h`` (s) from START, by a continuous extension."""
    stage_state(fraction, weights_at(F_q, fraction), weights_at(F_v, fraction), h, y, n)


def cusp_fraction(tableau: Tableau) -> float:
    """Return the last fraction of a step at which a jump of the force causes no first-order error.

    At this fraction the weights of later stages sum to the remaining time. If there is none, the result is 0.99, a
    jump at the end of the step; not 1, because rounding errors might then put the jump into the next step.
    """
    nodes = np.unique(np.append(tableau.c, 1.0))
    fractions = [float(1.0 - tableau.b[tableau.c > node + 1e-12].sum()) for node in nodes[:-1]]
    valid = [
        fraction
        for fraction, low, high in zip(fractions, nodes[:-1], nodes[1:], strict=True)
        if low < fraction < high
    ]
    return max(valid, default=0.99)


def register_fixed_step(parameters: type, tableau: Tableau) -> None:
    """Register a fixed-step method by its table; parameters: its ``NamedTuple`` with the field h."""
    rows, limits = make_stage_rows(tableau, 1, len(tableau.c)), tabulate_limits(tableau)
    b, B = weights_tuple(tableau.b), weights_tuple(tableau.B)

    def take_step(method, model, t, y):
        h, n = method.h, state_width(model)
        for k in range(n):
            y[START_Q + k] = y[lay.POSITION + k]
            y[START_V + k] = y[lay.VELOCITY + k]
        save_accelerations(METHOD_STATES, y, n)
        evaluate_stages(rows, model, t, h, y, n)
        stage_state(1.0, B, b, h, y, n)
        accelerations(model, t + h, y)
        y[lay.EVALUATIONS] += 1.0

    step.register(parameters)(take_step)
    prepare.register(parameters)(no_preparation)
    stability_ratio.register(parameters)(lambda method, K, C: step_over_limit(limits, method.h, K, C))
