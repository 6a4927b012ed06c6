"""Wrenches and twists: how a force on a roller changes as it moves in space relative to a body.

A twist is a displacement or velocity of the roller's centre and a turn, (P, phi); a wrench a force and its moment
about that centre; both (6,), along e_r, e_theta, e_z. A force along d that acts the arm X from the centre is the
wrench w = (d, X x d), and its point moves along d by w.(P, phi). So a contact with the approach's wrench w_n, and
with friction N mu along w_1, changes per unit of place and of velocity by

    -(w_n + mu w_1) (K w_n + C k_n)^T - N mu' w_1 k_1^T - N mu/speed w_2 k_2^T
    -(w_n + mu w_1)  C w_n^T          - N mu' w_1 w_1^T - N mu/speed w_2 w_2^T

w_2 being across the slip; k_n, k_1, k_2: how the rates along the w change with the place alone. Besides, forces
that stand turn with what they act on: N over a radius, some 1e-4 of K.

Each roller has room for a matrix of either kind, (6, 6) by rows, for the wrench itself, for how it changes with
the rolling speed, and for a cell that says whether it touches.
"""

from bearingsim.core import layout as lay
from bearingsim.core.geometry.vectors import cross, dot
from bearingsim.core.jit import jit

BY_SPEED, WRENCH, BY_ROLLING, IN_CONTACT, MATRICES_SIZE = 36, 72, 78, 84, 85


@jit
def matrix_of(j):
    """Where the matrices of roller ``j`` begin."""
    return lay.WRENCHES + MATRICES_SIZE * j


@jit
def clear_wrenches(Z, y):
    """No roller touches anything."""
    for k in range(lay.WRENCHES, lay.WRENCHES + MATRICES_SIZE * Z):
        y[k] = 0.0


@jit
def six(a, b):
    """Two vectors as one of six."""
    return a[0], a[1], a[2], b[0], b[1], b[2]


@jit
def wrench(d, arm):
    """Of a unit of force along ``d`` (3,) at ``arm`` (3,) from the centre."""
    return six(d, cross(arm, d))


@jit
def combine_six(p, a, q, b):
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
def subtract_outer(at, a, by_a, b, by_b, c, by_c, y):
    """Subtract a by_a^T + b by_b^T + c by_c^T from the matrix at ``at``."""
    for i in range(6):
        for k in range(6):
            y[at + 6 * i + k] -= a[i] * by_a[k] + b[i] * by_b[k] + c[i] * by_c[k]


@jit
def add_contact(j, w_n, w_1, w_2, K, C, rubs, along, across, k_n, k_1, k_2, y):
    """Add a contact of roller ``j``; rubs: mu, along: N mu' (N s/m), across: N mu/speed (N s/m)."""
    at = matrix_of(j)
    push = combine_six(1.0, w_n, rubs, w_1)
    of_1 = combine_six(along, w_1, 0.0, w_1)
    of_2 = combine_six(across, w_2, 0.0, w_2)
    subtract_outer(at, push, combine_six(K, w_n, C, k_n), of_1, k_1, of_2, k_2, y)
    subtract_outer(at + BY_SPEED, push, combine_six(C, w_n, 0.0, w_n), of_1, w_1, of_2, w_2, y)
    y[at + IN_CONTACT] = 1.0


@jit
def add_force(j, F, M, y):
    """Add a force (3,) that stands, and its moment (3,) about the centre, to the wrench on roller ``j``."""
    at = matrix_of(j) + WRENCH
    for i in range(3):
        y[at + i] += F[i]
        y[at + 3 + i] += M[i]


@jit
def add_rolling(j, w, N_mu_u, y):
    """Friction along ``w`` grows with the rolling speed: N d(mu)/du (N s/m)."""
    at = matrix_of(j) + BY_ROLLING
    for i in range(6):
        y[at + i] -= N_mu_u * w[i]


@jit
def rolling_wrench(j, y):
    """How the wrench on roller ``j`` changes with the rolling speed."""
    at = matrix_of(j) + BY_ROLLING
    return y[at], y[at + 1], y[at + 2], y[at + 3], y[at + 4], y[at + 5]


@jit
def turn_moment_arm(j, X, F, y):
    """The arm ``X`` (3,) of a force ``F`` (3,) turns with roller ``j``: its moment grows by (phi x X) x F."""
    at = matrix_of(j) + 6 * 3 + 3
    for i in range(3):
        for k in range(3):
            y[at + 6 * i + k] += X[i] * F[k]
        y[at + 7 * i] -= dot(X, F)


@jit
def constant_wrench(j, y):
    """Force and moment (3,) each of what stands on roller ``j``."""
    at = matrix_of(j) + WRENCH
    return (y[at], y[at + 1], y[at + 2]), (y[at + 3], y[at + 4], y[at + 5])


@jit
def row_times(at, x, y):
    """One row, at ``at``, times a six-vector."""
    return (
        y[at] * x[0] + y[at + 1] * x[1] + y[at + 2] * x[2] + y[at + 3] * x[3] + y[at + 4] * x[4] + y[at + 5] * x[5]
    )


@jit
def matrix_times(at, x, y):
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
def wrench_change(j, place, velocity, y):
    """How the wrench on roller ``j`` changes with its place and velocity relative to the body (six-vectors)."""
    at = matrix_of(j)
    return combine_six(1.0, matrix_times(at, place, y), 1.0, matrix_times(at + BY_SPEED, velocity, y))
