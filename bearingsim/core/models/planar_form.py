"""Contacts of ``planar`` between smooth surfaces, and between surfaces with form.

Forces between smooth surfaces are computed in the vectorised loop over rollers. Recesses are read from tables, one
roller at a time, so forces between surfaces with form are computed after that loop.
"""

from math import pi
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.geometry.plane import small_angle
from bearingsim.core.geometry.sides import InnerSide, OuterSide, contact_rows, normal_rows, sign
from bearingsim.core.jit import generic, inlined
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.models.planar_forces import compute_roller_forces
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.form import (
    RACE_I,
    RACE_O,
    RACE_SLOPE_I,
    RACE_SLOPE_O,
    ROLLER_I,
    ROLLER_O,
    ROLLER_SLOPE_I,
    ROLLER_SLOPE_O,
    Form,
    Smooth,
    form_rows,
    locate_on_race,
    locate_on_roller,
    race_on,
    read_surface,
    surface_entry,
)
from bearingsim.core.sums import sum_addends


@generic(inline="late")
def load_contacts(form: Any, model: Any, common: Any, y: np.ndarray, j: int) -> None:
    """Compute the forces on roller ``j`` if all surfaces are smooth, so that no table is read."""


@generic(inline="late", absent=0.0)
def load_contacts_with_form(form: Any, model: Any, common: Any, y: np.ndarray) -> float:
    """Compute the forces on all rollers if a surface has form; return the torque (N m) on the outer ring due to
    the form of its race."""


@load_contacts.register(Smooth)
def _load_contacts_smooth(form, model, common, y, j):
    y[lay.Q_O + j] = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
    y[lay.Q_I + j] = normal_force(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])
    y[lay.DEFECT_TORQUE + j] = 0.0
    compute_roller_forces(model, common, 0.0, 0.0, y, j)


@load_contacts.register(Form)
def _load_contacts_of_form(form, model, common, y, j):
    """Do nothing, because tables are read roller by roller, after the vectorised loop."""


@load_contacts_with_form.register(Form)
def _load_contacts_with_form(form, model, common, y):
    b, n = model.bearing, lanes(model.bearing)
    angle_o = common.theta_c - y[lay.POSITION + lay.PSI]
    angle_i = common.theta_c - b.omega_i * common.time
    roll = b.omega_b * common.time + y[lay.POSITION + lay.PHI_C]
    for j in range(n):
        locate_on_surfaces(OuterSide(), form.outer, form.rollers, angle_o, roll, b.Z, y, j)
        locate_on_surfaces(InnerSide(), form.inner, form.rollers, angle_i, roll + pi, b.Z, y, j)
    read_surface(form.outer, b.Z, RACE_O, RACE_SLOPE_O, y, n)
    read_surface(form.inner, b.Z, RACE_I, RACE_SLOPE_I, y, n)
    read_surface(form.rollers, b.Z, ROLLER_O, ROLLER_SLOPE_O, y, n)
    read_surface(form.rollers, b.Z, ROLLER_I, ROLLER_SLOPE_I, y, n)
    for j in range(n):
        beta_v = common.spin + y[lay.SPIN_V + j]
        tilt_o = subtract_recesses(OuterSide(), form.outer, form.rollers, common.omega_o, beta_v, y, j)
        tilt_i = subtract_recesses(InnerSide(), form.inner, form.rollers, common.omega_i, beta_v, y, j)
        Q_o = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
        Q_i = normal_force(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])
        y[lay.Q_O + j], y[lay.Q_I + j] = Q_o, Q_i
        y[lay.DEFECT_FORCE_O + j], y[lay.DEFECT_FORCE_I + j] = tilt_o * Q_o, tilt_i * Q_i
        slope_o = surface_entry(form.rollers, ROLLER_SLOPE_O, y, j)
        slope_i = surface_entry(form.rollers, ROLLER_SLOPE_I, y, j)
        y[lay.DEFECT_TORQUE + j] = -(slope_o * Q_o + slope_i * Q_i)
        y[lay.ADDENDS + j] = -surface_entry(form.outer, RACE_SLOPE_O, y, j) * Q_o
        compute_roller_forces(model, common, tilt_o, tilt_i, y, j)
    return sum_addends(y, n)


@inlined
def locate_on_surfaces(side, race, rollers, race_angle, roll, Z, y, j):
    """Fill the positions of one contact of roller ``j`` in the tables of race and roller.

    race_angle: position of pocket 0 on the race (rad); roll: angle (rad) in contact on the surface of a roller
    that is centred in its pocket, has not slipped and whose normal points along e_r.
    """
    _, normal_t, _, _, _ = normal_rows(side)
    of_race, race_slope, of_roller, roller_slope, _ = form_rows(side)
    offset = y[lay.EPS + j] + small_angle(y[normal_t + j])
    locate_on_race(race, race_angle, offset, Z, of_race, race_slope, y, j)
    locate_on_roller(rollers, roll + offset - y[lay.SPIN + j], of_roller, roller_slope, y, j)


@inlined
def subtract_recesses(side, race, rollers, omega_race, beta_v, y, j):
    """Subtract the recesses at one contact of roller ``j`` from its approach, and their rates from its rate.

    Returns the tangent of the normal's tilt.

    omega_race, beta_v: speeds of the race and of the roller about its axis (rad/s). Equation (F2) of docs/form.md.
    """
    _, approach, rate, _, _ = contact_rows(side)
    _, _, distance, transverse_speed, rho_v = normal_rows(side)
    of_race, race_slope, of_roller, roller_slope, rates = form_rows(side)
    omega = y[transverse_speed + j] / y[distance + j]
    slope_of_race, slope_of_roller = (
        surface_entry(race, race_slope, y, j),
        surface_entry(rollers, roller_slope, y, j),
    )
    y[rho_v + j] = sign(side) * y[rate + j]
    y[rates + j] = slope_of_race * (omega - omega_race) + slope_of_roller * (omega - beta_v)
    y[approach + j] -= surface_entry(race, of_race, y, j) + surface_entry(rollers, of_roller, y, j)
    y[rate + j] -= y[rates + j]
    return (slope_of_race + slope_of_roller) / y[distance + j]


@generic(absent=0.0)
def add_form(form: Any, side: Any, Q: float, y: np.ndarray, j: int) -> float:
    """Add the normal's tilt and the torques due to form at a contact over a defect.

    Q: contact force without the defect (N). Returns the change of the torque (N m) on the ring due to the form of
    its race.
    """


@add_form.register(Form)
def _add_form(form, side, Q, y, j):
    _, _, rho, _, rho_v = normal_rows(side)
    force, _, _, _, tilt_row = contact_rows(side)
    _, race_slope, _, roller_slope, rates = form_rows(side)
    slope_of_race = surface_entry(race_on(side, form), race_slope, y, j)
    slope_of_roller = surface_entry(form.rollers, roller_slope, y, j)
    change = y[force + j] - Q
    y[rho_v + j] += sign(side) * y[rates + j]
    y[tilt_row + j] += (slope_of_race + slope_of_roller) / y[rho + j] * y[force + j]
    y[lay.DEFECT_TORQUE + j] -= slope_of_roller * change
    return -slope_of_race * change
