"""Scales of a case: approach and damping of its contacts, time and speed of crossing its defects.

The tolerances of adaptive methods are fractions of these.
"""

from math import exp, inf, log, pi, sqrt
from typing import Any

import numpy as np

from bearingsim.assemble import contacts, geometry, rest
from bearingsim.config import Case
from bearingsim.core.defects.excitations import STEP_EXCITATIONS
from bearingsim.core.defects.pairs import (
    DEPTH,
    GROUP_COUNT,
    GROUP_HALF_WIDTH,
    REDUCED_RADIUS,
    SPAN,
    X_E,
    passing_speed,
)
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.methods.interface import Tolerances
from bearingsim.core.parts.form import Race, Smooth, UnequalRollers

MIN_STEPS_PER_CROSSING = 8  # with fewer steps per crossing, a method may miss a defect
DAMPER_TOLERANCE = 1e-3  # largest damping-force error caused by the velocity error, relative to the load


def full_speed_case(case: Case) -> Case:
    """Return the case at the highest speed of its ramp, without the ramp."""
    if case.ramp is None:
        return case
    return case.model_copy(update={"speed": max(case.speed, case.ramp.to), "ramp": None})


def crossing_time(model: Any) -> float:
    """Compute the shortest time (s) in which a contact crosses a defect or merged defects; inf without defects."""
    defects = model.defects
    times = [
        defects.head[d, SPAN] / abs(passing_speed(defects, d, model.bearing)) for d in range(len(defects.head))
    ]
    return float(min(times, default=inf))


def undulation_time(case: Case) -> float:
    """Compute the shortest time (s) in which a contact passes an undulation; inf for smooth surfaces."""
    b = geometry.build_bearing(case)
    speeds = {"outer": b.omega_c, "inner": b.omega_i - b.omega_c, "roller": b.omega_b}
    orders = {} if case.surfaces is None else case.surfaces.highest_orders
    return min((2.0 * pi / (order * speeds[element]) for element, order in orders.items()), default=inf)


def closing_speed(model: Any) -> float:
    """Estimate the closing speed (m/s) of a roller at the end of the steepest defect, plus the rate of the form.

    It is the passing speed times the slope x/R of the roller path, with x the distance from the rim at which the
    roller touches the wall or the floor, but at most half of the width.
    """
    defects = model.defects
    speeds = [
        min(group[GROUP_HALF_WIDTH], group[X_E], sqrt(2.0 * defects.head[d, REDUCED_RADIUS] * group[DEPTH]))
        / defects.head[d, REDUCED_RADIUS]
        * abs(passing_speed(defects, d, model.bearing))
        for d in range(len(defects.head))
        for group in defects.groups[d, : int(defects.head[d, GROUP_COUNT])]
    ]
    return float(max(speeds, default=0.0)) + form_bounds(model)[1]


def form_bounds(model: Any) -> tuple[float, float]:
    """Compute upper bounds of the form deviation at a contact (m) and of its rate at kinematic speeds (m/s).

    Both are 0 for smooth surfaces.
    """
    form, b = getattr(model, "form", None), model.bearing
    surfaces = () if form is None or isinstance(form, Smooth) else form
    height, rate = 0.0, 0.0
    for surface, omega in zip(surfaces, (b.omega_c, b.omega_i - b.omega_c, b.omega_b), strict=False):
        if isinstance(surface, Smooth):
            continue
        if isinstance(surface, UnequalRollers):
            height += float(np.abs(surface.recess).max())
            continue
        count = len(surface.pieces) * (b.Z if isinstance(surface, Race) else 1)
        largest_value, largest_slope = piece_maxima(surface.pieces)
        height += largest_value
        rate += largest_slope * count / (2.0 * pi) * omega
    return height, rate


def piece_maxima(pieces: np.ndarray) -> tuple[float, float]:
    """Compute the largest absolute value and derivative of cubic pieces (M, 4, ...), x from 0 to 1 on each."""
    c_0, c_1, c_2, c_3 = np.moveaxis(pieces, 1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -c_2 - np.copysign(np.sqrt(c_2 * c_2 - 3.0 * c_1 * c_3), c_2)
        roots = q / (3.0 * c_3), c_1 / q  # of the derivative; nan if it has none
        inflection = -c_2 / (3.0 * c_3)
    extremes, steepest = (
        [0.0, 1.0, *(np.clip(np.nan_to_num(x), 0.0, 1.0) for x in places)] for places in (roots, [inflection])
    )
    values = [c_0 + x * (c_1 + x * (c_2 + x * c_3)) for x in extremes]
    slopes = [c_1 + x * (2.0 * c_2 + x * (3.0 * c_3)) for x in steepest]
    return max(float(np.abs(v).max()) for v in values), max(float(np.abs(v).max()) for v in slopes)


INITIAL_APPROACH = 1e-5  # m, of the order of approaches in bearings
MAX_ITERATIONS = 50
APPROACH_TOLERANCE = 1e-14  # relative change of the last iteration: a few times the rounding error


def approach(law: Any, load: float) -> float:
    """Compute the static approach (m) of a contact under ``load`` (N); 0 for a load that is not positive.

    Uses Newton's method for ln Q as a function of ln delta, a straight line for a power law.
    """
    if load <= 0.0:
        return 0.0
    delta = INITIAL_APPROACH
    for _ in range(MAX_ITERATIONS):
        Q = normal_force(law, delta, 0.0)
        change = log(load / Q) * Q / (delta * tangent(law.stiffness, delta))
        delta *= exp(change)
        if abs(change) < APPROACH_TOLERANCE:
            return delta
    raise ArithmeticError(f"no static approach of {law} under {load:g} N within {MAX_ITERATIONS} iterations")


def load_exponent(law: Any, load: float) -> float:
    """Compute d(ln Q)/d(ln delta) of a static contact under ``load`` > 0 (N): m of a power law k delta^m."""
    delta = approach(law, load)
    return float(delta * tangent(law.stiffness, delta) / elastic(law.stiffness, delta))


def damping_ratio(case: Case, load: float) -> float:
    """Compute the damping ratio of a roller between its races under the load ``load`` (N) of the outer race.

    It includes the damping of the contacts with the races, but neither friction nor the contacts with cage and
    flanges, which affect the step limit, too.
    """
    b, laws = geometry.build_bearing(case), (contacts.build_outer_law(case), contacts.build_inner_law(case))
    inner_load = max(0.0, load - b.m_r * b.omega_c**2 * 0.5 * (b.R_o + b.R_i))
    approaches = [approach(law, force) for law, force in zip(laws, (load, inner_load), strict=True)]
    C, K = (
        sum(bound(law, delta, 0.0) for law, delta in zip(laws, approaches, strict=True))
        for bound in (damping_bound, stiffness_bound)
    )
    return float(C / (2.0 * sqrt(K * b.m_r)))


def damping_time(case: Case, load: float) -> float:
    """Compute c/k (s), dQ/dv over dQ/d(delta), of static contacts under ``load`` (N): the larger of both races."""
    laws = contacts.build_outer_law(case), contacts.build_inner_law(case)
    return float(max(damping_over_stiffness(law, approach(law, load)) for law in laws))


def damping_over_stiffness(law: Any, delta: float) -> float:
    """Compute c/k (s) of a static contact at the approach ``delta`` (m)."""
    K, C = stiffness_bound(law, delta, 0.0), damping_bound(law, delta, 0.0)  # every law has these bounds
    return float(C / K) if K > 0.0 else 0.0


def largest_roller_drop(model: Any) -> float:
    """Compute an upper bound of the drop (m) of a roller into a defect, plus the largest form deviation.

    The roller is stopped by the rims or the floor.
    """
    defects = model.defects
    has_steps = isinstance(defects.excitation, STEP_EXCITATIONS)
    drops = [
        group[DEPTH] if has_steps else min(group[DEPTH], rim_drop(group, defects.head[d, REDUCED_RADIUS]))
        for d in range(len(defects.head))
        for group in defects.groups[d, : int(defects.head[d, GROUP_COUNT])]
    ]
    return float(max(drops, default=0.0)) + form_bounds(model)[0]


def rim_drop(group: np.ndarray, reduced_radius: float) -> float:
    """Compute the drop (m) of a roller onto the rims of a group."""
    return float(group[GROUP_HALF_WIDTH] * group[GROUP_HALF_WIDTH] / (2.0 * reduced_radius))


def tolerances(case: Case, model: Any, full_speed_model: Any, h: float, tolerance: float) -> Tolerances:
    """Compute the parameters of an adaptive method with output every ``h`` (s).

    The tolerance of positions is ``tolerance`` times the static approach delta under the largest load. That of
    velocities is ``tolerance`` times the larger of the closing speed and Z omega_c delta, but limited by
    ``DAMPER_TOLERANCE``, because the damping force is the dominant error with a damper of 1e6 N s/m.
    full_speed_model: model at the highest speed of a ramp, which limits the steps.
    """
    F = rest.largest_load(case)
    laws = (contacts.build_outer_law(case), contacts.build_inner_law(case))
    delta = max(approach(law, F) for law in laws)
    c = max(damping_bound(law, approach(law, F), 0.0) for law in laws)
    speed = max(closing_speed(model), model.bearing.Z * model.bearing.omega_c * delta)
    atol_v = min(tolerance * speed, DAMPER_TOLERANCE * F / c if c > 0.0 else inf)
    shortest_time = min(
        crossing_time(full_speed_model), ball_pass_time(full_speed_model), undulation_time(full_speed_case(case))
    )
    longest_step = shortest_time / MIN_STEPS_PER_CROSSING
    return Tolerances(h, tolerance, tolerance * delta, atol_v, longest_step)


def ball_pass_time(model: Any) -> float:
    """Compute the time (s) between passes of adjacent rollers over a point of the outer race, without slip."""
    return 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
