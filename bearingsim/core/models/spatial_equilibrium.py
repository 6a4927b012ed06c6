"""Static equilibrium of a bearing in space: sliced rollers that tilt, rings that may tilt and move axially.

The unknowns are q_j and tilt_j of every roller, the outer ring's x and y, and axial position and tilt of each ring
on an elastic mount. Friction and damping are absent. Geometry and contacts are those of ``models/spatial.py`` at
zero velocity, so that misalignment and roller profiles act as in the dynamic model. Rollers do not skew, stay
centred in their pockets and between the flanges, and a defect exerts no tangential force (as in
``models/equilibrium.py``).

The residuals are minus the gradient of an energy that is convex except for the normals' tilt, a share of 1e-6. For
fixed rings the two equations of each roller are solved separately. The rings are then found by Newton's method on
the remaining forces, with the stiffness condensed over the rollers (Schur complement)

    K = K_rr - sum_j K_rj K_jj^-1 K_jr.

A step s of the rings moves the rollers by -K_jj^-1 K_jr s. A step of rings or rollers is halved as long as the
force along it reverses to more than half of its initial magnitude.
"""

from functools import partial
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.clock import is_over
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.slices import WEIGHT
from bearingsim.core.jit import jit
from bearingsim.core.models.bodies_in_space import set_mounted_rings
from bearingsim.core.models.equilibrium import NoEquilibrium, solve_2x2, solve_in_cpu_time
from bearingsim.core.models.spatial_residuals import (
    RING_CELLS,
    RING_DOF,
    fill_residuals,
    fill_ring_stiffness,
    fill_roller_stiffness,
    largest_ring_residual,
    lever_arm,
    make_scales,
    make_work_arrays,
)

RESIDUAL_TOLERANCE = 1e-10  # relative to the load; well under the 1e-8 allowed at the start of a run
MAX_STEPS = 100  # iterations of a search
MAX_HALVINGS = 40  # largest number of halvings of a step
# tolerance of the rollers' residuals: at the end relative to RESIDUAL_TOLERANCE, before relative to the rings'
# residual
FINAL_TOLERANCE, RELATIVE_TOLERANCE = 0.1, 1e-3
LONGEST_STEP = 2e-5  # m, in an iteration; an angle is multiplied by half a roller's length


@jit
def solve_linear(a):
    """Solve linear equations by Gauss-Jordan elimination with pivoting.

    a: (n, n + 1), matrix and right-hand side, overwritten; the last column becomes the solution.
    """
    n = len(a)
    for i in range(n):
        pivot = i
        for row in range(i + 1, n):
            if abs(a[row, i]) > abs(a[pivot, i]):
                pivot = row
        for column in range(i, n + 1):
            a[i, column], a[pivot, column] = a[pivot, column], a[i, column]
        for row in range(n):
            factor = a[row, i] / a[i, i] if row != i else 0.0
            for column in range(i, n + 1):
                a[row, column] -= factor * a[i, column]
    for i in range(n):
        a[i, n] /= a[i, i]


@jit
def move_rollers(y, steps, fraction, Z):
    """Move every roller by ``fraction`` of its row of ``steps`` (Z, 2)."""
    for j in range(Z):
        y[lay.RADIAL + j] += fraction * steps[j, 0]
        y[lay.TILT + j] += fraction * steps[j, 1]


@jit
def fill_roller_step(scales, arrays, Z):
    """Fill ``arrays.roller_step``, Newton's step of every roller, limited to ``LONGEST_STEP``, and
    ``arrays.roller_work``, the work of the residual along it."""
    for j in range(Z):
        q, tilt = solve_2x2(
            arrays.roller_stiffness[j, 0],
            arrays.roller_stiffness[j, 1],
            arrays.roller_stiffness[j, 2],
            arrays.roller_residuals[j, 0],
            arrays.roller_residuals[j, 1],
        )
        scale = min(1.0, LONGEST_STEP / max(abs(q), abs(tilt) * scales.half_length, 1e-300))
        arrays.roller_step[j, 0], arrays.roller_step[j, 1] = scale * q, scale * tilt
        arrays.roller_work[j] = (
            arrays.roller_residuals[j, 0] * arrays.roller_step[j, 0]
            + arrays.roller_residuals[j, 1] * arrays.roller_step[j, 1]
        )


@jit
def halve_overshoots(y, arrays, Z):
    """Halve the step of every roller that overshot its equilibrium; return whether any did."""
    any_overshoot = False
    for j in range(Z):
        if (
            arrays.roller_residuals[j, 0] * arrays.roller_step[j, 0]
            + arrays.roller_residuals[j, 1] * arrays.roller_step[j, 1]
            < -0.5 * arrays.roller_work[j]
        ):
            any_overshoot = True
            arrays.roller_step[j, 0], arrays.roller_step[j, 1], arrays.roller_work[j] = (
                0.5 * arrays.roller_step[j, 0],
                0.5 * arrays.roller_step[j, 1],
                0.5 * arrays.roller_work[j],
            )
            y[lay.RADIAL + j] -= arrays.roller_step[j, 0]
            y[lay.TILT + j] -= arrays.roller_step[j, 1]
    return any_overshoot


@jit
def balance_rollers(model, t, y, scales, arrays, tolerance):
    """Balance every roller to ``tolerance`` (N) for fixed rings; return the largest residual (N)."""
    return continue_balance(model, t, y, scales, arrays, tolerance, fill_residuals(model, t, y, scales, arrays))


@jit
def continue_balance(model, t, y, scales, arrays, tolerance, residual):
    """Run ``balance_rollers`` for residuals in ``arrays``, of which the largest is ``residual`` (N)."""
    Z = model.bearing.Z
    for _ in range(MAX_STEPS):
        if residual <= tolerance or is_over(y[lay.CPU_END]):
            break
        fill_roller_stiffness(model, y, scales, arrays)
        fill_roller_step(scales, arrays, Z)
        previous = residual
        move_rollers(y, arrays.roller_step, 1.0, Z)
        residual = fill_residuals(model, t, y, scales, arrays)
        for _ in range(MAX_HALVINGS):
            if residual <= tolerance or not halve_overshoots(y, arrays, Z):
                break
            residual = fill_residuals(model, t, y, scales, arrays)
        if previous <= residual <= RESIDUAL_TOLERANCE * scales.load:
            break  # the residual is rounding error
    return residual


@jit
def fill_ring_step(model, y, scales, arrays):
    """Fill ``arrays.ring_step``, Newton's step of the rings, and ``arrays.roller_response``, that of the rollers;
    return the work (N m) of the rings' step."""
    fill_roller_stiffness(model, y, scales, arrays)
    fill_ring_stiffness(model, y, arrays)
    for i in range(RING_DOF):
        arrays.ring_system[i, RING_DOF] = arrays.ring_residuals[i]
    solve_linear(arrays.ring_system)
    longest, work = 1e-300, 0.0
    for i in range(RING_DOF):
        longest = max(longest, abs(arrays.ring_system[i, RING_DOF]) * lever_arm(i, scales.half_length))
    for i in range(RING_DOF):
        arrays.ring_step[i] = arrays.ring_system[i, RING_DOF] * min(1.0, LONGEST_STEP / longest)
        arrays.ring_start[i] = y[lay.POSITION + RING_CELLS[i]]
        work += arrays.ring_residuals[i] * arrays.ring_step[i]
    for j in range(model.bearing.Z):
        arrays.roller_start[j, 0], arrays.roller_start[j, 1] = y[lay.RADIAL + j], y[lay.TILT + j]
        q, tilt = 0.0, 0.0
        for i in range(RING_DOF):
            q, tilt = (
                q - arrays.coupling[j, 0, i] * arrays.ring_step[i],
                tilt - arrays.coupling[j, 1, i] * arrays.ring_step[i],
            )
        arrays.roller_response[j, 0], arrays.roller_response[j, 1] = solve_2x2(
            arrays.roller_stiffness[j, 0], arrays.roller_stiffness[j, 1], arrays.roller_stiffness[j, 2], q, tilt
        )
    return work


@jit
def apply_step(y, arrays, fraction, Z):
    """Move rings and rollers by ``fraction`` of the step from their stored positions."""
    for i in range(RING_DOF):
        y[lay.POSITION + RING_CELLS[i]] = arrays.ring_start[i] + fraction * arrays.ring_step[i]
    for j in range(Z):
        y[lay.RADIAL + j] = arrays.roller_start[j, 0] + fraction * arrays.roller_response[j, 0]
        y[lay.TILT + j] = arrays.roller_start[j, 1] + fraction * arrays.roller_response[j, 1]


@jit
def move_rings(model, t, y, scales, arrays, tolerance):
    """Apply a step of the rings, halved until it does not overshoot; return the largest residual (N) of the
    rollers."""
    initial_work, fraction, residual = fill_ring_step(model, y, scales, arrays), 1.0, 0.0
    for _ in range(MAX_HALVINGS):
        apply_step(y, arrays, fraction, model.bearing.Z)
        residual = balance_rollers(model, t, y, scales, arrays, tolerance)
        work = 0.0
        for i in range(RING_DOF):
            work += arrays.ring_residuals[i] * arrays.ring_step[i]
        if work >= -0.5 * initial_work:
            break
        fraction *= 0.5
    return residual


@jit
def balance(arrays, model, t, y):
    """Find the equilibrium from the state in ``y`` as initial guess; return the largest residual (N).

    Moments are divided by half a roller's length.
    """
    set_mounted_rings(model, y)
    scales = make_scales(model, t)
    tolerance = RELATIVE_TOLERANCE * scales.load
    residual = balance_rollers(model, t, y, scales, arrays, tolerance)
    for _ in range(MAX_STEPS):
        ring_residual = largest_ring_residual(scales, arrays)
        required = max(RELATIVE_TOLERANCE * ring_residual, FINAL_TOLERANCE * RESIDUAL_TOLERANCE * scales.load)
        if tolerance > required:  # the rings' residual is no more accurate than the rollers'
            tolerance = required
            residual = continue_balance(model, t, y, scales, arrays, tolerance, residual)
        elif ring_residual <= RESIDUAL_TOLERANCE * scales.load:
            break
        else:
            residual = move_rings(model, t, y, scales, arrays, tolerance)
    return max(residual, largest_ring_residual(scales, arrays))


def solve_spatial_equilibrium(model: Any, t: float, y: np.ndarray, tilted: bool = False) -> float:
    """Find the static equilibrium of rings and rollers at time ``t`` (s), starting from an equilibrium in ``y``.

    tilted: True if ``y`` is an equilibrium in space, with tilted rollers, False if it is one in the plane.
    Returns the largest residual (N). Velocities are zero except those of the rollers' axes, which rotate with the
    cage.
    """
    b = model.bearing
    for row in (lay.EPS, lay.SPIN):
        y[row : row + b.Z] = 0.0
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    if not tilted:
        y[lay.TILT : lay.TILT + b.Z] = 0.0
    residual = float(solve_in_cpu_time(partial(balance, make_work_arrays(b.Z)), model, t, y))
    orbit = b.omega_c * kinematic_time(model.motion, t)[1]
    y[lay.AXIS_X_V : lay.AXIS_X_V + b.Z] = -orbit * y[lay.AXIS_Y : lay.AXIS_Y + b.Z]
    y[lay.AXIS_Y_V : lay.AXIS_Y_V + b.Z] = orbit * y[lay.AXIS_X : lay.AXIS_X + b.Z]
    return residual


class MeanSpatialEquilibrium(NamedTuple):
    """Static equilibrium over a ball pass: mean position of the ring (m), largest force of the outer race on a
    roller (N), largest line loads of a slice at the outer and inner race (N/m)."""

    x: float
    y: float
    load: float
    outer_line_load: float
    inner_line_load: float


def mean_spatial_equilibrium(model: Any, y: np.ndarray, samples: int = 32) -> MeanSpatialEquilibrium:
    """Return ``MeanSpatialEquilibrium`` from ``samples`` equilibria over a ball pass.

    y: a buffer in equilibrium in the plane.

    Raises ``NoEquilibrium`` if an equilibrium is not found to 1e-8 of the load.
    """
    b, widths = model.bearing, model.L_w * model.slices.table[:, WEIGHT]
    load_rows = [[lay.slice_row(k, race) for k in range(len(widths))] for race in (lay.LOAD_O, lay.LOAD_I)]
    pass_time = 2.0 * np.pi / (b.Z * b.omega_c)
    load, rows = hypot(model.support.F, model.support.F_across), []
    for n in range(samples):
        residual = solve_spatial_equilibrium(model, (n + 0.5) / samples * pass_time, y, tilted=n > 0)
        if not residual <= 1e-8 * load:
            raise NoEquilibrium(f"no static equilibrium in space: residual {residual:g} N at a load of {load:g} N")
        slice_loads = np.array([[y[row : row + b.Z].max() for row in of_race] for of_race in load_rows])
        position = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
        rows.append((*position, y[lay.Q_O : lay.Q_O + b.Z].max(), *(slice_loads / widths).max(axis=1)))
    x_mean, y_mean = np.mean(rows, axis=0)[:2].tolist()
    return MeanSpatialEquilibrium(x_mean, y_mean, *np.max(rows, axis=0)[2:].tolist())
