"""Residual forces on rings and rollers of a bearing in space in static equilibrium, and their derivatives.

The unknowns are radial position and tilt of every roller, and eight coordinates of the rings (``RING_CELLS``).
Residuals are minus the gradient of an energy; stiffnesses are minus the derivatives of the residuals. The slices
of a roller lie at zeta along its axis, so their stiffness k enters only in the sums of k, k zeta and k zeta^2.
"""

from math import hypot
from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.orientation import body_at
from bearingsim.core.geometry.plane import fill_roller_directions
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.slices import WEIGHT, ZETA
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import stiffness_bound
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.models.equilibrium import solve_2x2
from bearingsim.core.models.spatial import compute_race_contacts, fill_roller_axes
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.flanges import axial_position
from bearingsim.core.parts.mounts import mount_load, mount_spring_rates
from bearingsim.core.parts.races_in_space import add_side_loads
from bearingsim.core.sums import sum_loads

# stiffness added to a roller's, relative to a contact's; keeps Newton's step of an unloaded roller finite
ADDED_STIFFNESS = 1e-3
RING_CELLS = (lay.X, lay.Y, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y)
"""Cells of the rings' coordinates in a block of the state: position and tilt of the outer ring, axial position and
tilt of the inner."""
RING_DOF, FIRST_INNER = len(RING_CELLS), 5  # number of these coordinates, and index of the first of the inner ring


class WorkArrays(NamedTuple):
    """Work arrays of the search: one row per roller, in m and rad or N and N m; rings in the order of
    ``RING_CELLS``.

    roller_residuals, roller_step (Z, 2), roller_work (Z,): residuals, a step and its work (N m); roller_stiffness
    (Z, 3): symmetric stiffness of radial position and tilt; coupling (Z, 2, 8): stiffness between rollers and
    rings; roller_start, roller_response (Z, 2): positions of the rollers before a step of the rings, and their
    displacements in it.
    ring_residuals, ring_step, ring_start (8,): residuals of the rings, their step, and their positions before it;
    ring_system (8, 9): their stiffness, with the right-hand side as last column.
    """

    roller_residuals: np.ndarray
    roller_step: np.ndarray
    roller_work: np.ndarray
    roller_stiffness: np.ndarray
    coupling: np.ndarray
    roller_start: np.ndarray
    roller_response: np.ndarray
    ring_residuals: np.ndarray
    ring_step: np.ndarray
    ring_start: np.ndarray
    ring_system: np.ndarray


def make_work_arrays(Z: int) -> WorkArrays:
    """Allocate the work arrays for a bearing of ``Z`` rollers."""
    shapes = (
        (Z, 2),
        (Z, 2),
        (Z,),
        (Z, 3),
        (Z, 2, RING_DOF),
        (Z, 2),
        (Z, 2),
        *3 * [(RING_DOF,)],
        (RING_DOF, RING_DOF + 1),
    )
    return WorkArrays(*map(np.zeros, shapes))


class Scales(NamedTuple):
    """Scales of a bearing for the search for its equilibrium, constant during the search.

    half_length: half a roller's length, m; load: N; centrifugal: centrifugal force of a roller over its distance
    from the axis, N/m; gyroscopic: gyroscopic moment over its tilt, N m/rad; added_stiffness: stiffness added to
    that of its contacts, N/m.
    """

    half_length: float
    load: float
    centrifugal: float
    gyroscopic: float
    added_stiffness: float


@jit
def make_scales(model, t):
    """Return ``Scales`` at time ``t`` (s)."""
    b, rate = model.bearing, kinematic_time(model.motion, t)[1]
    orbit, spin = b.omega_c * rate, (b.omega_c - b.omega_b) * rate
    return Scales(
        model.L_w / 2.0,
        hypot(model.support.F, model.support.F_across) + 1e-3,
        b.m_r * orbit * orbit,
        orbit * (b.I_r * spin - model.I_t * orbit),
        ADDED_STIFFNESS * tangent(model.outer.stiffness, 1e-7),
    )


# Residuals


@jit
def compute_contacts_at_rest(model, t, y, n):
    """Compute the loads on rollers and rings from the race contacts at zero velocity at time ``t`` (s)."""
    b, R_mean = model.bearing, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    time, _, _ = kinematic_time(model.motion, t)
    outer = body_at(y, lay.X, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, 0.0)
    inner = body_at(y, lay.X_I, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y, 0.0)
    fill_roller_directions(b.theta_0 + b.omega_c * time, y, n)
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        tilt = y[lay.TILT + j]
        y[lay.AXIS_X + j], y[lay.AXIS_Y + j] = tilt * c, tilt * s
        r = R_mean + y[lay.RADIAL + j]
        y[lay.AXIAL + j] = axial_position(model.flanges, b, outer, inner, c, s, r, tilt)
        y[lay.FORCE_R + j], y[lay.MOMENT_T + j] = 0.0, 0.0
    fill_roller_axes(0.0, 0.0, b.R_w, y, n)
    compute_race_contacts(model, t, 0.0, outer, inner, 0.0, y, n)
    add_side_loads(OuterSide(), b, outer, y, n)
    add_side_loads(InnerSide(), b, inner, y, n)
    sum_loads(lay.F_X, lay.M_INNER, y, n)


@jit
def fill_residuals(model, t, y, scales, arrays):
    """Fill ``arrays.roller_residuals`` and ``arrays.ring_residuals``; return the rollers' largest residual (N)."""
    compute_contacts_at_rest(model, t, y, lanes(model.bearing))
    b, support, largest = model.bearing, model.support, 0.0
    for j in range(b.Z):
        arrays.roller_residuals[j, 0] = y[lay.FORCE_R + j] + scales.centrifugal * (
            0.5 * (b.R_o + b.R_i) + y[lay.RADIAL + j]
        )
        arrays.roller_residuals[j, 1] = y[lay.MOMENT_T + j] - scales.gyroscopic * y[lay.TILT + j]
        largest = max(
            largest, abs(arrays.roller_residuals[j, 0]), abs(arrays.roller_residuals[j, 1]) / scales.half_length
        )
    f = arrays.ring_residuals
    f[0] = y[lay.F_X] - support.F - support.k_b * (y[lay.POSITION + lay.X] - support.x_0)
    f[1] = y[lay.F_Y] - support.F_across - support.k_b * (y[lay.POSITION + lay.Y] - support.y_0)
    f[2], f[3], f[4] = mount_load(
        model.mount_o,
        y,
        y[lay.F_Z],
        y[lay.M_X],
        y[lay.M_Y],
        y[lay.M_RING],
        lay.Z,
        lay.RING_TILT_X,
        lay.RING_TILT_Y,
    )
    f_z, m_x, m_y, m_z = y[lay.F_Z_I], y[lay.M_X_I], y[lay.M_Y_I], y[lay.M_INNER]
    f[5], f[6], f[7] = mount_load(
        model.mount_i, y, f_z, m_x, m_y, m_z, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y
    )
    return largest


@jit
def lever_arm(i, half_length):
    """Return the lever arm of coordinate ``i`` of the rings: half a roller's length (m) for an angle, else 1."""
    return half_length if i in (3, 4, 6, 7) else 1.0


@jit
def largest_ring_residual(scales, arrays):
    """Return the largest residual (N) of the rings, with moments divided by half a roller's length."""
    largest = 0.0
    for i in range(RING_DOF):
        largest = max(largest, abs(arrays.ring_residuals[i]) / lever_arm(i, scales.half_length))
    return largest


# Stiffness


@jit
def stiffness_moments(model, y, j):
    """Return the sums of k, k zeta, k zeta^2 (N/m, N, N m) over the slices of roller ``j``, at the outer race and
    at the inner race."""
    o_0, o_1, o_2, i_0, i_1, i_2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(model.slices.table)):
        weight, zeta = model.slices.table[k, WEIGHT], model.slices.table[k, ZETA]
        outer, inner = y[lay.slice_row(k, lay.APPROACH_O) + j], y[lay.slice_row(k, lay.APPROACH_I) + j]
        k_o = weight * stiffness_bound(model.outer, outer, 0.0) if outer > 0.0 else 0.0
        k_i = weight * stiffness_bound(model.inner, inner, 0.0) if inner > 0.0 else 0.0
        o_0, o_1, o_2 = o_0 + k_o, o_1 + zeta * k_o, o_2 + zeta * zeta * k_o
        i_0, i_1, i_2 = i_0 + k_i, i_1 + zeta * k_i, i_2 + zeta * zeta * k_i
    return o_0, o_1, o_2, i_0, i_1, i_2


@jit
def added_moments(model, scales):
    """Return the sums of k, k zeta, k zeta^2 (N/m, N, N m) of the stiffness added to every roller."""
    moment, moment_2, count = 0.0, 0.0, len(model.slices.table)
    for k in range(count):
        zeta = model.slices.table[k, ZETA]
        moment, moment_2 = moment + zeta, moment_2 + zeta * zeta
    return (
        scales.added_stiffness,
        scales.added_stiffness * moment / count,
        scales.added_stiffness * moment_2 / count,
    )


@jit
def fill_roller_stiffness(model, y, scales, arrays):
    """Fill ``arrays.roller_stiffness`` from the approaches of the slices and the centrifugal and gyroscopic
    terms."""
    s_0, s_1, s_2 = added_moments(model, scales)
    for j in range(model.bearing.Z):
        o_0, o_1, o_2, i_0, i_1, i_2 = stiffness_moments(model, y, j)
        arrays.roller_stiffness[j, 0] = o_0 + i_0 + s_0 - scales.centrifugal
        arrays.roller_stiffness[j, 1] = o_1 + i_1 + s_1
        arrays.roller_stiffness[j, 2] = o_2 + i_2 + s_2 + scales.gyroscopic


@jit
def fill_ring_stiffness(model, y, arrays):
    """Fill ``arrays.coupling`` and ``arrays.ring_system``, the rings' stiffness condensed over the rollers."""
    arrays.ring_system[:], arrays.coupling[:] = 0.0, 0.0
    for j in range(model.bearing.Z):
        o_0, o_1, o_2, _, i_1, i_2 = stiffness_moments(model, y, j)
        radial, tilting = arrays.coupling[j, 0], arrays.coupling[j, 1]
        for axis in range(2):
            along = y[lay.COS + j] if axis == 0 else y[lay.SIN + j]
            radial[axis], radial[3 + axis], radial[6 + axis] = -o_0 * along, -o_1 * along, -i_1 * along
            tilting[axis], tilting[3 + axis], tilting[6 + axis] = -o_1 * along, -o_2 * along, -i_2 * along
        for axis in range(2):
            along = y[lay.COS + j] if axis == 0 else y[lay.SIN + j]
            for m in range(FIRST_INNER):
                arrays.ring_system[axis, m] -= along * radial[m]
                arrays.ring_system[3 + axis, m] -= along * tilting[m]
            for m in range(FIRST_INNER, RING_DOF):
                arrays.ring_system[6 + axis, m] -= along * tilting[m]
        for m in range(RING_DOF):
            q, tilt = solve_2x2(
                arrays.roller_stiffness[j, 0],
                arrays.roller_stiffness[j, 1],
                arrays.roller_stiffness[j, 2],
                radial[m],
                tilting[m],
            )
            for i in range(RING_DOF):
                arrays.ring_system[i, m] -= radial[i] * q + tilting[i] * tilt
    add_mount_stiffness(model, arrays)


@jit
def add_mount_stiffness(model, arrays):
    """Add the stiffness of the rings' supports to ``arrays.ring_system``; fix the coordinates without a spring."""
    k_b = model.support.k_b + 1e-8 * tangent(model.outer.stiffness, 1e-7)
    (z_o, tilt_o), (z_i, tilt_i) = mount_spring_rates(model.mount_o), mount_spring_rates(model.mount_i)
    stiffness = (k_b, k_b, z_o, tilt_o, tilt_o, z_i, tilt_i, tilt_i)
    for i in range(RING_DOF):
        if stiffness[i] == 0.0:
            arrays.ring_system[i, :], arrays.ring_system[:, i] = 0.0, 0.0
            arrays.ring_system[i, i] = 1.0
        arrays.ring_system[i, i] += stiffness[i]
