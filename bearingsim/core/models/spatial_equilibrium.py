"""Static equilibrium of a bearing in space: sliced rollers that tilt, rings that may tilt and move axially.

The unknowns are q_j and tilt_j of every roller, the outer ring's x and y, and the axial position and tilt of each
ring on springs. Friction and damping are absent. Geometry and contacts are those of ``models/spatial.py`` at zero
velocity, so that misalignment and roller profiles act as in the motion. Rollers do not skew, stay in the middle of
their pockets and between the flanges, and a defect exerts no tangential force (as in ``models/equilibrium.py``).

The residuals are minus the gradient of an energy that is convex except for the tilt of normals (1e-6 of it). For
fixed rings the two equations of each roller are solved separately. The rings are then found by Newton's method on
the remaining forces, with the stiffness condensed over the rollers (Schur complement)

    K = K_rr - sum_j K_rj K_jj^-1 K_jr.

A step s of the rings moves the rollers by -K_jj^-1 K_jr s. Steps of both are shortened so that they do not pass
the point at which the force along them vanishes.
"""

from functools import partial
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.clock import is_over
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.jit import jit
from bearingsim.core.models.bodies_in_space import set_mounted_rings
from bearingsim.core.models.equilibrium import NoEquilibrium, solve_2x2, solve_in_cpu_time
from bearingsim.core.models.spatial_residuals import (
    CELLS,
    RINGS,
    arm,
    largest_force,
    press,
    room,
    scales,
    stiffen_rings,
    stiffen_rollers,
)

RESIDUAL = 1e-10  # of the load: residual of the search, well under the 1e-8 allowed at the start of a run
MAX_STEPS = 100
HALVINGS = 40  # largest number of halvings of a step
STRICT, LOOSE = 0.1, 1e-3  # tolerance of the rollers, relative to RESIDUAL (at the end), to the rings' residual
LONGEST_STEP = 2e-5  # m; for angles, of the angle times half a roller's length


@jit
def eliminate(a):
    """Solve linear equations in place; ``a`` (n, n + 1): matrix and right-hand side, replaced by the solution."""
    n = len(a)
    for i in range(n):
        pivot = i
        for row in range(i + 1, n):
            if abs(a[row, i]) > abs(a[pivot, i]):
                pivot = row
        for column in range(i, n + 1):
            a[i, column], a[pivot, column] = a[pivot, column], a[i, column]
        for row in range(n):
            part = a[row, i] / a[i, i] if row != i else 0.0
            for column in range(i, n + 1):
                a[row, column] -= part * a[i, column]
    for i in range(n):
        a[i, n] /= a[i, i]


@jit
def move_rollers(y, steps, part, Z):
    """Move every roller by a part of its row of ``steps``."""
    for j in range(Z):
        y[lay.RADIAL + j] += part * steps[j, 0]
        y[lay.TILT + j] += part * steps[j, 1]


@jit
def step_rollers(s, arrays, Z):
    """Fill ``arrays.step`` and ``arrays.push``: Newton's step of every roller, limited to ``LONGEST_STEP``, and
    its work."""
    for j in range(Z):
        q, tilt = solve_2x2(
            arrays.pairs[j, 0], arrays.pairs[j, 1], arrays.pairs[j, 2], arrays.left[j, 0], arrays.left[j, 1]
        )
        shorter = min(1.0, LONGEST_STEP / max(abs(q), abs(tilt) * s.half, 1e-300))
        arrays.step[j, 0], arrays.step[j, 1] = shorter * q, shorter * tilt
        arrays.push[j] = arrays.left[j, 0] * arrays.step[j, 0] + arrays.left[j, 1] * arrays.step[j, 1]


@jit
def step_back(y, arrays, Z):
    """Halve the step of every roller that passed its equilibrium; return whether any did."""
    any_past = False
    for j in range(Z):
        if arrays.left[j, 0] * arrays.step[j, 0] + arrays.left[j, 1] * arrays.step[j, 1] < -0.5 * arrays.push[j]:
            any_past = True
            arrays.step[j, 0], arrays.step[j, 1], arrays.push[j] = (
                0.5 * arrays.step[j, 0],
                0.5 * arrays.step[j, 1],
                0.5 * arrays.push[j],
            )
            y[lay.RADIAL + j] -= arrays.step[j, 0]
            y[lay.TILT + j] -= arrays.step[j, 1]
    return any_past


@jit
def settle(model, t, y, s, arrays, goal):
    """Balance every roller to ``goal`` (N) for fixed rings; return the largest residual (N)."""
    return settle_on(model, t, y, s, arrays, goal, press(model, t, y, s, arrays))


@jit
def settle_on(model, t, y, s, arrays, goal, size):
    """Run ``settle`` for rollers with residuals in ``arrays``, of which the largest is ``size`` (N)."""
    Z = model.bearing.Z
    for _ in range(MAX_STEPS):
        if size <= goal or is_over(y[lay.CPU_END]):
            break
        stiffen_rollers(model, y, s, arrays)
        step_rollers(s, arrays, Z)
        before = size
        move_rollers(y, arrays.step, 1.0, Z)
        size = press(model, t, y, s, arrays)
        for _ in range(HALVINGS):
            if size <= goal or not step_back(y, arrays, Z):
                break
            size = press(model, t, y, s, arrays)
        if before <= size <= RESIDUAL * s.load:
            break  # the residual is rounding error
    return size


@jit
def step_rings(model, y, s, arrays):
    """Fill ``arrays.move``, Newton's step of the rings, and ``arrays.follow``, that of the rollers; return the
    work (N m) of the rings' step."""
    stiffen_rollers(model, y, s, arrays)
    stiffen_rings(model, y, arrays)
    for i in range(RINGS):
        arrays.stiff[i, RINGS] = arrays.forces[i]
    eliminate(arrays.stiff)
    longest, push = 1e-300, 0.0
    for i in range(RINGS):
        longest = max(longest, abs(arrays.stiff[i, RINGS]) * arm(i, s.half))
    for i in range(RINGS):
        arrays.move[i] = arrays.stiff[i, RINGS] * min(1.0, LONGEST_STEP / longest)
        arrays.start[i] = y[lay.POSITION + CELLS[i]]
        push += arrays.forces[i] * arrays.move[i]
    for j in range(model.bearing.Z):
        arrays.held[j, 0], arrays.held[j, 1] = y[lay.RADIAL + j], y[lay.TILT + j]
        q, tilt = 0.0, 0.0
        for i in range(RINGS):
            q, tilt = q - arrays.crossed[j, 0, i] * arrays.move[i], tilt - arrays.crossed[j, 1, i] * arrays.move[i]
        arrays.follow[j, 0], arrays.follow[j, 1] = solve_2x2(
            arrays.pairs[j, 0], arrays.pairs[j, 1], arrays.pairs[j, 2], q, tilt
        )
    return push


@jit
def move_all(y, arrays, part, Z):
    """Move rings and rollers by ``part`` of the step from their stored positions."""
    for i in range(RINGS):
        y[lay.POSITION + CELLS[i]] = arrays.start[i] + part * arrays.move[i]
    for j in range(Z):
        y[lay.RADIAL + j] = arrays.held[j, 0] + part * arrays.follow[j, 0]
        y[lay.TILT + j] = arrays.held[j, 1] + part * arrays.follow[j, 1]


@jit
def search(model, t, y, s, arrays, goal):
    """Apply a step of the rings, halved until it does not pass their equilibrium; return ``settle``'s result."""
    push, part, size = step_rings(model, y, s, arrays), 1.0, 0.0
    for _ in range(HALVINGS):
        move_all(y, arrays, part, model.bearing.Z)
        size = settle(model, t, y, s, arrays, goal)
        past = 0.0
        for i in range(RINGS):
            past += arrays.forces[i] * arrays.move[i]
        if past >= -0.5 * push:
            break
        part *= 0.5
    return size


@jit
def balance(arrays, model, t, y):
    """Find the equilibrium near the state in ``y``; return the largest residual (N).

    Moments are divided by half a roller's length.
    """
    set_mounted_rings(model, y)
    s = scales(model, t)
    goal = LOOSE * s.load
    size = settle(model, t, y, s, arrays, goal)
    for _ in range(MAX_STEPS):
        left = largest_force(s, arrays)
        wanted = max(LOOSE * left, STRICT * RESIDUAL * s.load)
        if goal > wanted:  # the rings' residual is no more accurate than the rollers'
            goal = wanted
            size = settle_on(model, t, y, s, arrays, goal, size)
        elif left <= RESIDUAL * s.load:
            break
        else:
            size = search(model, t, y, s, arrays, goal)
    return max(size, largest_force(s, arrays))


def solve_spatial_equilibrium(model: Any, t: float, y: np.ndarray, tilted: bool = False) -> float:
    """Find the static equilibrium of rings and rollers at time ``t`` (s), starting from an equilibrium in ``y``.

    tilted: whether ``y`` is an equilibrium in space, with tilted rollers, not one in the plane.
    Returns the largest residual (N). Velocities are zero except those of the rollers' axes, which rotate with the
    cage.
    """
    b = model.bearing
    for row in (lay.EPS, lay.SPIN):
        y[row : row + b.Z] = 0.0
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    if not tilted:
        y[lay.TILT : lay.TILT + b.Z] = 0.0
    left = float(solve_in_cpu_time(partial(balance, room(b.Z)), model, t, y))
    orbit = b.omega_c * kinematic_time(model.motion, t)[1]
    y[lay.AXIS_X_V : lay.AXIS_X_V + b.Z] = -orbit * y[lay.AXIS_Y : lay.AXIS_Y + b.Z]
    y[lay.AXIS_Y_V : lay.AXIS_Y_V + b.Z] = orbit * y[lay.AXIS_X : lay.AXIS_X + b.Z]
    return left


class MeanSpatialEquilibrium(NamedTuple):
    """Static equilibrium over a ball pass: mean position of the ring (m), largest force on a roller (N)."""

    x: float
    y: float
    load: float


def mean_spatial_equilibrium(model: Any, y: np.ndarray, samples: int = 32) -> MeanSpatialEquilibrium:
    """Return ``MeanSpatialEquilibrium`` from ``samples`` equilibria over a ball pass.

    ``y``: a buffer in plane equilibrium.

    Raises ``NoEquilibrium`` if an equilibrium is not found to 1e-8 of the load.
    """
    b = model.bearing
    pass_time = 2.0 * np.pi / (b.Z * b.omega_c)
    load, rests = hypot(model.support.F, model.support.F_across), []
    for n in range(samples):
        residual = solve_spatial_equilibrium(model, (n + 0.5) / samples * pass_time, y, tilted=n > 0)
        if not residual <= 1e-8 * load:
            raise NoEquilibrium(f"no static equilibrium in space: {residual:g} N left of {load:g} N")
        rests.append((y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y], y[lay.Q_O : lay.Q_O + b.Z].max()))
    x, across, _ = (float(value) for value in np.mean(rests, axis=0))
    return MeanSpatialEquilibrium(x, across, float(max(most for _, _, most in rests)))
