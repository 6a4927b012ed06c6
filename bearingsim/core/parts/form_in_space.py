"""Form of the surfaces under the slices of the rollers: each slice meets a race at its own angle about the ring.

The angle of a slice's n is that of its roller plus the angle from e_r to n about the ring's axis. Recesses are
read as in ``parts/form.py``; waviness is the same along a roller's length, so a skewed roller meets the crest of a
race's undulation slice by slice. The angle on a roller is measured about the ring's axis, as for defects
(``defects/on_slices.py``).
"""

from math import pi, sqrt
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.plane import small_angle
from bearingsim.core.geometry.sides import InnerSide, OuterSide, side_rows
from bearingsim.core.jit import generic, inlined, jit
from bearingsim.core.parts.form import (
    Form,
    Smooth,
    form_rows,
    locate_on_race,
    locate_on_roller,
    race_on,
    read_surface,
    surface_entry,
)


@generic(absent=None)
def read_form(
    form: Any,
    model: Any,
    t: float,
    tilt_factor: float,
    zeta: float,
    b_z: tuple[float, float],
    y: np.ndarray,
    n: int,
) -> None:
    """Read recesses and slopes of the surfaces at the slices at ``zeta`` (m) of all rollers, on both sides.

    tilt_factor: 1.0, or 0.0 to leave out the slopes, as for defects; b_z: axial components of the axes of outer
    and inner ring. Requires the rows filled by ``fill_race_frame``.
    """


@read_form.register(Form)
def _read_form(form, model, t, tilt_factor, zeta, b_z, y, n):
    b, time = model.bearing, kinematic_time(model.motion, t)[0]
    cage_angle = y[lay.POSITION + lay.PHI_C]
    theta_c = b.theta_0 + b.omega_c * time + cage_angle
    roll = b.omega_b * time + cage_angle
    read_side(OuterSide(), form, b, theta_c - y[lay.POSITION + lay.PSI], roll, tilt_factor, zeta, b_z[0], y, n)
    read_side(InnerSide(), form, b, theta_c - b.omega_i * time, roll + pi, tilt_factor, zeta, b_z[1], y, n)


@jit
def read_side(side, form, bearing, race_angle, roll, tilt_factor, zeta, b_z, y, n):
    """Implement ``read_form`` on one side.

    race_angle: position of pocket 0 on the race (rad); roll: angle (rad) in contact on the surface of a roller
    that is centred in its pocket, has not slipped and whose n points along e_r.
    """
    base, R_mean, race, rollers = (
        side_rows(side),
        0.5 * (bearing.R_o + bearing.R_i),
        race_on(side, form),
        form.rollers,
    )
    of_race, race_slope, of_roller, roller_slope, _ = form_rows(side)
    for j in range(n):
        r = R_mean + y[lay.RADIAL + j] + y[base + lay.OFFSET_R + j] + zeta * y[base + lay.DIRECTION_R + j]
        t = y[base + lay.OFFSET_T + j] + zeta * y[base + lay.DIRECTION_T + j]
        z = y[base + lay.OFFSET_Z + j] + zeta * y[base + lay.DIRECTION_Z + j]
        sine = (t - y[base + lay.RING_AXIS_T + j] * (z / (1.0 + b_z))) / sqrt(r * r + t * t + z * z)
        offset = y[lay.EPS + j] + small_angle(sine)
        locate_on_race(race, race_angle, offset, bearing.Z, of_race, race_slope, y, j)
        locate_on_roller(rollers, roll + offset - y[lay.SPIN + j], of_roller, roller_slope, y, j)
    read_surface(race, bearing.Z, of_race, race_slope, y, n)
    read_surface(rollers, bearing.Z, of_roller, roller_slope, y, n)
    for j in range(n):
        y[race_slope + j], y[roller_slope + j] = tilt_factor * y[race_slope + j], tilt_factor * y[roller_slope + j]


@generic(inline="late", absent=0.0)
def recess_of_slice(form: Any, side: Any, y: np.ndarray, j: int) -> float:
    """Return the recess (m) of both surfaces at the current slice of roller ``j``."""


@recess_of_slice.register(Form)
def _recess_of_slice(form, side, y, j):
    of_race, _, of_roller, _, _ = form_rows(side)
    return surface_entry(race_on(side, form), of_race, y, j) + surface_entry(form.rollers, of_roller, y, j)


@inlined
def height_slopes(form, side, inverse_rho, y, j):
    """Return the slopes (1) of the heights of race and roller with respect to the arc length along the race.

    inverse_rho: inverse of the distance from the ring's axis (1/m).
    """
    _, race_slope, _, roller_slope, _ = form_rows(side)
    slope_of_race = -surface_entry(race_on(side, form), race_slope, y, j) * inverse_rho
    return slope_of_race, -surface_entry(form.rollers, roller_slope, y, j) * inverse_rho


@generic(inline="late", absent=0.0)
def height_slope_of_slice(form: Any, side: Any, inverse_rho: float, y: np.ndarray, j: int) -> float:
    """Return the summed height slope (1) of both surfaces at the current slice, minus the tilt of the normal."""


@height_slope_of_slice.register(Form)
def _height_slope_of_slice(form, side, inverse_rho, y, j):
    slope_of_race, slope_of_roller = height_slopes(form, side, inverse_rho, y, j)
    return slope_of_race + slope_of_roller


@generic(inline="late", absent=0.0)
def recess_rate_of_slice(
    form: Any, side: Any, inverse_rho: float, past_race: float, past_roller: float, y: np.ndarray, j: int
) -> float:
    """Return the rate (m/s) of the recess at the current slice.

    past_race, past_roller: speeds (m/s) of the contact along both surfaces. Equation (F1) of docs/form.md.
    """


@recess_rate_of_slice.register(Form)
def _recess_rate_of_slice(form, side, inverse_rho, past_race, past_roller, y, j):
    slope_of_race, slope_of_roller = height_slopes(form, side, inverse_rho, y, j)
    return -(slope_of_race * past_race + slope_of_roller * past_roller)


@generic(inline="late", absent=0.0)
def torque_of_roller_form(form: Any, side: Any, force: float, y: np.ndarray, j: int) -> float:
    """Return the torque (N m) of ``force`` (N) on the roller by its own form. Equation (F2) of docs/form.md."""


@torque_of_roller_form.register(Form)
def _torque_of_roller_form(form, side, force, y, j):
    return -surface_entry(form.rollers, form_rows(side)[3], y, j) * force


@generic(inline="late")
def versine(form: Any, base: int, normal_slope: float, y: np.ndarray, j: int) -> float:
    """Return 1 - cos of the normal's tilt, whose tangent is ``normal_slope``; base: of the rows of the side."""


@versine.register(Smooth)
def _versine_smooth(form, base, normal_slope, y, j):
    return y[base + lay.NORMAL_VERSINE + j]


@versine.register(Form)
def _versine_form(form, base, normal_slope, y, j):
    return 1.0 - 1.0 / sqrt(1.0 + normal_slope * normal_slope)
