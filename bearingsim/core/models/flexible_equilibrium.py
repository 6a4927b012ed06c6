"""Static equilibrium of a bearing with a flexible outer ring.

The unknowns p are the ring's position and the amplitudes of its harmonics. The balance of each roller is solved
separately, as with a rigid ring (``equilibrium.py``), and Newton's method with a line search solves

    g_k(p) = f_k - K_k p_k + sum_j Q_o,j(p) phi_k(theta_j) = 0,   phi: cos, sin of theta_j and of n theta_j,

which is minus the gradient of a convex energy. The matrix diag(K) + sum_j k_j phi phi^T is factorised by Cholesky.
"""

from math import sqrt
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import generic, inlined, jit
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.models.equilibrium import (
    K_SERIES,
    MAX_STEPS,
    RESIDUAL_TOLERANCE,
    STEPS_PER_CHECK,
    balance_ring,
    balance_rollers,
    is_futile,
    net_force,
)
from bearingsim.core.parts.bending import (
    INVERSE_MASS_C,
    INVERSE_MASS_S,
    SPRING_COS,
    SPRING_SIN,
    SPRING_STIFFNESS,
    STIFFNESS,
    Bending,
    Springs,
    fill_roller_forces,
    force_on_harmonic,
    harmonics,
    load_springs,
    spring_load,
)
from bearingsim.core.rows import declare

# rows of unknowns, as in a block of the state: start of a line search (m), its step (m), force at the present
# position (N)
START, STEP, FORCE = declare(
    lay.JACOBIAN_WORK + 62 * lay.ROW, "m, m, N", "bent bent-search", "start", size=3 * lay.ROW, step=3 * lay.ROW
)
# derivative of a contact's approach with respect to each unknown, and right-hand side of ``solve``; overwrites
# SPRING_FORCE_C and SPRING_FORCE_S, which are not needed once FORCE is filled
(PHI,) = declare(lay.SPRING_FORCE_C, "1", "bent-search", "start", size=2 * lay.ROW, step=0)
# stiffness matrix by rows, in the cells of POSITION_JACOBIAN, because implicit methods have no flexible ring
(MATRIX,) = declare(lay.POSITION_JACOBIAN, "N/m", "bent bent-search", "start", size=lay.ARROW_SIZE, step=0)
LONGEST_STEP = 1e-4  # m, of any unknown in an iteration
# stiffness added to each unknown, relative to that of a contact; keeps the step finite if one roller supports the
# ring
ADDED_STIFFNESS = 1e-8


@inlined
def unknown_count(bending):
    """Return the number of unknowns: the ring's x and y, and two amplitudes of each harmonic."""
    return 2 + 2 * harmonics(bending)


@inlined
def cell(bending, k):
    """Return the index of unknown ``k`` in a block of the state."""
    n = harmonics(bending)
    return k if k < 2 else (lay.MODES_C + k - 2 if k < 2 + n else lay.MODES_S + k - 2 - n)


@jit
def fill_force(bending, model, y):
    """Fill FORCE from the rows filled by ``balance_rollers``; return its norm (N)."""
    f_x, f_y = net_force(model, y)
    fill_roller_forces(bending, y)
    load_springs(bending.springs, y)
    y[FORCE + lay.X] = f_x + spring_load(bending.springs, lay.SPRINGS_X, y, 0)
    y[FORCE + lay.Y] = f_y + spring_load(bending.springs, lay.SPRINGS_Y, y, 0)
    for i in range(harmonics(bending)):
        f_c, f_s = force_on_harmonic(bending, y, i)
        has_cosine, has_sine = (
            bending.harmonic_table[INVERSE_MASS_C, i] > 0.0,
            bending.harmonic_table[INVERSE_MASS_S, i] > 0.0,
        )
        y[FORCE + lay.MODES_C + i] = (
            f_c - bending.harmonic_table[STIFFNESS, i] * y[lay.POSITION + lay.MODES_C + i] if has_cosine else 0.0
        )
        y[FORCE + lay.MODES_S + i] = (
            f_s - bending.harmonic_table[STIFFNESS, i] * y[lay.POSITION + lay.MODES_S + i] if has_sine else 0.0
        )
    norm_squared = 0.0
    for k in range(unknown_count(bending)):
        norm_squared += y[FORCE + cell(bending, k)] ** 2
    return sqrt(norm_squared)


@jit
def fill_matrix(bending, model, y):
    """Fill the lower triangle of MATRIX, of the ring, the rollers and the springs."""
    N, H = unknown_count(bending), harmonics(bending)
    for k in range(N):
        for m in range(k + 1):
            y[MATRIX + k * N + m] = 0.0
    added = ADDED_STIFFNESS * tangent(model.outer.stiffness, 1e-7)
    y[MATRIX] = y[MATRIX + N + 1] = model.support.k_b + added
    for i in range(H):
        k = bending.harmonic_table[STIFFNESS, i] + added
        y[MATRIX + (2 + i) * (N + 1)] = k if bending.harmonic_table[INVERSE_MASS_C, i] > 0.0 else 1.0
        y[MATRIX + (2 + H + i) * (N + 1)] = k if bending.harmonic_table[INVERSE_MASS_S, i] > 0.0 else 1.0
    for j in range(model.bearing.Z):
        if y[K_SERIES + j] > 0.0:
            add_roller(bending, y, j, N)
    add_springs(bending.springs, y, N)


@generic(absent=None)
def add_springs(springs: Any, y: np.ndarray, N: int) -> None:
    """Add the stiffness of the springs in contact to MATRIX of ``N`` rows."""


@add_springs.register(Springs)
def _add_springs(springs, y, N):
    H = (N - 2) // 2
    for p in range(springs.transposed_shapes.shape[1]):
        if y[lay.COMPRESSION + p] > 0.0:
            y[PHI], y[PHI + 1] = springs.spring_table[SPRING_COS, p], springs.spring_table[SPRING_SIN, p]
            for i in range(H):
                y[PHI + 2 + i], y[PHI + 2 + H + i] = (
                    springs.transposed_shapes[0, p, i],
                    springs.transposed_shapes[1, p, i],
                )
            add_contact(springs.spring_table[SPRING_STIFFNESS, p], y, N)


@jit
def add_roller(bending, y, j, N):
    """Add the stiffness of roller ``j`` to MATRIX of ``N`` rows."""
    y[PHI], y[PHI + 1] = y[lay.COS + j], y[lay.SIN + j]
    H = harmonics(bending)
    for i in range(H):
        c, s = bending.transposed_shapes[0, j, i], bending.transposed_shapes[1, j, i]
        C, S = y[lay.PHASE_C + i], y[lay.PHASE_S + i]
        y[PHI + 2 + i] = c * C - s * S if bending.harmonic_table[INVERSE_MASS_C, i] > 0.0 else 0.0
        y[PHI + 2 + H + i] = s * C + c * S if bending.harmonic_table[INVERSE_MASS_S, i] > 0.0 else 0.0
    add_contact(y[K_SERIES + j], y, N)


@jit
def add_contact(k, y, N):
    """Add k PHI PHI^T to MATRIX of ``N`` rows."""
    for i in range(N):
        k_phi = k * y[PHI + i]
        for m in range(i + 1):
            y[MATRIX + i * N + m] += k_phi * y[PHI + m]


@jit
def solve(y, N):
    """Replace MATRIX by its Cholesky factor, and the right-hand side in PHI (``N`` numbers) by the solution."""
    for k in range(N):
        for m in range(k + 1):
            total = y[MATRIX + k * N + m]
            for i in range(m):
                total -= y[MATRIX + k * N + i] * y[MATRIX + m * N + i]
            y[MATRIX + k * N + m] = sqrt(total) if m == k else total / y[MATRIX + m * N + m]
    for k in range(N):
        for m in range(k):
            y[PHI + k] -= y[MATRIX + k * N + m] * y[PHI + m]
        y[PHI + k] /= y[MATRIX + k * N + k]
    for k in range(N - 1, -1, -1):
        for m in range(k + 1, N):
            y[PHI + k] -= y[MATRIX + m * N + k] * y[PHI + m]
        y[PHI + k] /= y[MATRIX + k * N + k]


@jit
def fill_newton_step(bending, model, y):
    """Fill STEP with Newton's step (m), limited to LONGEST_STEP; return the work of the force along it (N m)."""
    N = unknown_count(bending)
    fill_matrix(bending, model, y)
    for k in range(N):
        y[PHI + k] = y[FORCE + cell(bending, k)]
    solve(y, N)
    longest = 0.0
    for k in range(N):
        longest = max(longest, abs(y[PHI + k]))
    scale = min(1.0, LONGEST_STEP / max(longest, 1e-300))
    for k in range(N):
        y[STEP + cell(bending, k)] = scale * y[PHI + k]
    return work_along(bending, y)


@jit
def work_along(bending, y):
    """Return the work of the force along STEP (N m)."""
    work = 0.0
    for k in range(unknown_count(bending)):
        work += y[FORCE + cell(bending, k)] * y[STEP + cell(bending, k)]
    return work


@jit
def move_ring(bending, model, t, y, fraction):
    """Set the ring to START plus ``fraction`` of STEP; return the norm of the force (N) there."""
    for k in range(unknown_count(bending)):
        i = cell(bending, k)
        y[lay.POSITION + i] = y[START + i] + fraction * y[STEP + i]
    balance_rollers(model, t, y)
    return fill_force(bending, model, y)


@jit
def line_search(bending, model, t, y, initial_work):
    """Apply STEP, or a fraction of it if the force along it would reverse.

    initial_work: work of the force along STEP (N m) at the start; the fraction is chosen so that this work falls
    to at most half of its initial magnitude.
    Returns the norm of the force (N) at the end.
    """
    for k in range(unknown_count(bending)):
        i = cell(bending, k)
        y[START + i] = y[lay.POSITION + i]
    norm = move_ring(bending, model, t, y, 1.0)
    work = work_along(bending, y)
    if abs(work) <= 0.5 * initial_work or work > 0.0:
        return norm
    low, high = 0.0, 1.0
    for _ in range(60):
        fraction = 0.5 * (low + high)
        norm = move_ring(bending, model, t, y, fraction)
        work = work_along(bending, y)
        if abs(work) <= 0.5 * initial_work:
            break
        if work > 0.0:
            low = fraction
        else:
            high = fraction
    return norm


@balance_ring.register(Bending)
def _balance_ring(bending, model, t, y):
    tolerance = RESIDUAL_TOLERANCE * (bending.load + 1e-3)
    balance_rollers(model, t, y)
    norm = fill_force(bending, model, y)
    for n in range(MAX_STEPS):
        if norm <= tolerance or (n % STEPS_PER_CHECK == STEPS_PER_CHECK - 1 and is_futile(norm, y)):
            break
        work = fill_newton_step(bending, model, y)
        norm = line_search(bending, model, t, y, work)
    return norm
