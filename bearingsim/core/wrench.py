"""Wrenches and twists: how a force on a roller changes as it moves in space relative to a body.

A twist is a displacement or velocity of the roller's centre and a turn (P, phi); a wrench a force and its moment
about that centre; both (6,) along e_r, e_theta, e_z. A force of the direction d that acts the arm X from the centre
is the wrench w = (d, X x d), and its point moves along d by w.(P, phi): so a contact of the approach's wrench w_n,
with friction N mu along w_1, changes by

    -(w_n + mu w_1) (K w_n + C k_n) - N mu' w_1 k_1 - N mu/speed w_2 k_2      per unit of place
    -(w_n + mu w_1)  C w_n          - N mu' w_1 w_1 - N mu/speed w_2 w_2      per unit of velocity

w_2 being across the slip; k_n, k_1, k_2: what the rates along the w change by with the place alone. Left out is how
the w themselves change: N over a radius beside K, some 1e-4 of it.

Each roller has room for a matrix of either kind, (6, 6) by rows, and a cell that says whether it touches.
"""

from bearingsim.core.jit import jit
from bearingsim.core.layout import WRENCHES
from bearingsim.core.vectors import cross

BY_SPEED, TOUCHES, ROOM = 36, 72, 73


@jit
def of_roller(j):
    """Where the matrices of roller ``j`` begin."""
    return WRENCHES + ROOM * j


@jit
def clear_wrenches(Z, y):
    """No roller touches anything."""
    for k in range(WRENCHES, WRENCHES + ROOM * Z):
        y[k] = 0.0


@jit
def wrench(d, arm):
    """Of a unit of force along ``d`` (3,) at ``arm`` (3,) from the centre."""
    m = cross(arm, d)
    return d[0], d[1], d[2], m[0], m[1], m[2]


@jit
def plus(p, a, q, b):
    """p a + q b of six-vectors."""
    return (
        p * a[0] + q * b[0],
        p * a[1] + q * b[1],
        p * a[2] + q * b[2],
        p * a[3] + q * b[3],
        p * a[4] + q * b[4],
        p * a[5] + q * b[5],
    )


@jit
def take(at, w, by, y):
    """Subtract the matrix w by^T from the one at ``at``."""
    for i in range(6):
        for k in range(6):
            y[at + 6 * i + k] -= w[i] * by[k]


@jit
def add_contact(j, w_n, w_1, w_2, K, C, rubs, along, across, k_n, k_1, k_2, y):
    """Add a contact of roller ``j``; rubs: mu, along: N mu' (N s/m), across: N mu/speed (N s/m)."""
    at = of_roller(j)
    push = plus(1.0, w_n, rubs, w_1)
    take(at, push, plus(K, w_n, C, k_n), y)
    take(at, w_1, plus(along, k_1, 0.0, k_1), y)
    take(at, w_2, plus(across, k_2, 0.0, k_2), y)
    take(at + BY_SPEED, push, plus(C, w_n, 0.0, w_n), y)
    take(at + BY_SPEED, w_1, plus(along, w_1, 0.0, w_1), y)
    take(at + BY_SPEED, w_2, plus(across, w_2, 0.0, w_2), y)
    y[at + TOUCHES] = 1.0


@jit
def row_times(at, x, y):
    """One row, at ``at``, times a six-vector."""
    return (
        y[at] * x[0] + y[at + 1] * x[1] + y[at + 2] * x[2] + y[at + 3] * x[3] + y[at + 4] * x[4] + y[at + 5] * x[5]
    )


@jit
def times(at, x, y):
    """The matrix at ``at`` times a six-vector."""
    return (
        row_times(at, x, y),
        row_times(at + 6, x, y),
        row_times(at + 12, x, y),
        row_times(at + 18, x, y),
        row_times(at + 24, x, y),
        row_times(at + 30, x, y),
    )


@jit
def answer(j, place, velocity, y):
    """How the wrench on roller ``j`` changes with its place and velocity relative to the body (six-vectors)."""
    at = of_roller(j)
    return plus(1.0, times(at, place, y), 1.0, times(at + BY_SPEED, velocity, y))
