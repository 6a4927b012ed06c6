"""Contact of one roller over a defect, summed over the defect's groups.

The functions are scalar, because few rollers are in a defect at the same time.
"""

from math import inf
from typing import Any

import numpy as np

from bearingsim.core.defects.excitations import defect_response
from bearingsim.core.defects.pairs import (
    GROUP_COUNT,
    GROUP_WEIGHT,
    HALF_WIDTH,
    REDUCED_RADIUS,
    SIDE,
    nearest_roller,
)
from bearingsim.core.geometry.sides import contact_rows
from bearingsim.core.jit import generic, inlined, jit
from bearingsim.core.laws.damping.interface import derivatives, normal_force
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.parameters import kinematic_angles


@inlined
def contact_stiffness(stiffness, delta):
    """Return the derivative (N/m) of the elastic force at any approach ``delta`` (m); zero out of contact."""
    return tangent(stiffness, delta) if delta > 0.0 else 0.0


@jit
def elastic_over_defect(stiffness, defects, d, s, delta):
    """Return the elastic force (N), its derivative (N/m) and the mean approach (m) of a contact in roller-defect
    pair ``d``.

    delta: approach (m) to the undamaged race; ``s``: distance (m) from the defect's centre. ``d`` = -1: no defect.

    Equation (M10) of docs/model.md, either side.
    """
    if d < 0:
        return elastic(stiffness, max(delta, 0.0)), contact_stiffness(stiffness, delta), max(delta, 0.0)
    force, spring_rate, mean_approach = 0.0, 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, _ = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, approach = share * group[GROUP_WEIGHT], max(delta - h, 0.0)
        force += weight * elastic(stiffness, approach)
        spring_rate += weight * contact_stiffness(stiffness, delta - h)
        mean_approach += weight * approach
    return force, spring_rate, mean_approach


@jit
def force_over_defect(contact, defects, d, s, speed, delta, v):
    """Return normal force (N), tangential force (N), mean approach (m) and mean closing rate (m/s) of a contact in
    roller-defect pair ``d``.

    delta, v: approach (m) to the undamaged race and its rate (m/s); speed: ds/dt (m/s). The tangential force, sum
    Q_k dh_k/ds, acts against increasing s. The means are over the groups in contact, for the step monitor; without
    contact approach and rate are those of the group closest to contact.

    Equation (M6) of docs/defects.md.
    """
    force, tangential, approach, weighted_rate, nearest, nearest_rate = 0.0, 0.0, 0.0, 0.0, -inf, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, rate = share * group[GROUP_WEIGHT], v - slope * speed
        group_force = weight * normal_force(contact, delta - h, rate)
        force += group_force
        tangential += group_force * slope
        approach += weight * max(delta - h, 0.0)
        weighted_rate += weight * max(delta - h, 0.0) * rate
        nearest_rate = rate if delta - h > nearest else nearest_rate
        nearest = max(nearest, delta - h)
    if approach > 0.0:
        return force, tangential, approach, weighted_rate / approach
    return force, tangential, nearest, nearest_rate


@jit
def correct_contact(side, contact, defects, d, j, s, speed, y):
    """Correct force, approach and rate of roller ``j`` for roller-defect pair ``d``; return the tangential force
    (N).

    The corrected approach and rate are means over the groups in contact, for the step monitor
    (``force_over_defect``).
    """
    force, approach, rate, _, _ = contact_rows(side)
    y[force + j], tangential, y[approach + j], y[rate + j] = force_over_defect(
        contact, defects, d, s, speed, y[approach + j], y[rate + j]
    )
    return tangential


@jit
def mean_drop_rate(stiffness, defects, d, s, speed, delta):
    """Return the mean rate dh/dt (m/s) over the groups of roller-defect pair ``d``, weighted by their elastic
    forces; 0 without a defect.

    Equation (M11) of docs/model.md, for a defect at the inner contact.
    """
    if d < 0:
        return 0.0
    force, weighted_rate = 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        group_force = share * group[GROUP_WEIGHT] * elastic(stiffness, max(delta - h, 0.0))
        force += group_force
        weighted_rate += group_force * slope * speed
    return weighted_rate / force if force > 0.0 else 0.0


@jit
def derivatives_over_defect(contact, defects, d, s, speed, delta, v):
    """Return the derivatives of ``force_over_defect`` with respect to the approach (N/m) and its rate (N s/m)."""
    K, C = 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        K_group, C_group = derivatives(contact, delta - h, v - slope * speed)
        K += share * group[GROUP_WEIGHT] * K_group
        C += share * group[GROUP_WEIGHT] * C_group
    return K, C


@jit
def stiffness_over_defect(stiffness, defects, d, s, delta):
    """Return the derivative (N/m) of the elastic force of the groups in contact; ``d`` = -1: no defect."""
    if d < 0:
        return contact_stiffness(stiffness, delta)
    spring_rate = 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, _ = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        spring_rate += share * group[GROUP_WEIGHT] * contact_stiffness(stiffness, delta - h)
    return spring_rate


@jit
def mean_drop_rate_derivative(stiffness, defects, d, s, speed, delta):
    """Return the derivative of ``mean_drop_rate`` with respect to the approach (1/s)."""
    force, weighted_rate, K, K_weighted_rate = 0.0, 0.0, 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, approach = share * group[GROUP_WEIGHT], max(delta - h, 0.0)
        group_force = weight * elastic(stiffness, approach)
        K_group = weight * tangent(stiffness, approach) if approach > 0.0 else 0.0
        force += group_force
        weighted_rate += group_force * slope * speed
        K += K_group
        K_weighted_rate += K_group * slope * speed
    return (K_weighted_rate - K * weighted_rate / force) / force if force > 0.0 else 0.0


@jit
def mean_response(defects, d, s):
    """Return the mean drop (m) over the roller's length, and the share (1) of the stiffness that remains."""
    drop, total_share = 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, _ = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        drop += share * group[GROUP_WEIGHT] * h
        total_share += share * group[GROUP_WEIGHT]
    return drop, total_share


@inlined
def prevails(drop, share, other_drop, other_share):
    """Check if a response acts at a contact rather than another: the deeper one, of equally deep ones the
    softer."""
    return drop > other_drop or (drop == other_drop and share < other_share)


@generic
def roller_at_defect(model: Any, d: int, t: float, y: np.ndarray) -> tuple[int, float]:
    """Return the roller nearest to the defect of pair ``d`` at time ``t`` (s), and its distance (m) from the
    defect's centre."""


def roller_at_defect_without_slip(model, d, t, y):
    """Implement ``roller_at_defect`` for rollers that are evenly spaced and roll without slip."""
    theta_c, theta_i, roll = kinematic_angles(model.bearing, t)
    return nearest_roller(model.defects, d, theta_c, theta_i, roll, model.bearing.Z)


@jit
def is_masked(model, d, j, s, t, y):
    """Check if another pair than ``d`` acts at this contact of roller ``j``.

    The other pair acts if its response prevails, or if the responses are equal and it comes first.
    """
    defects = model.defects
    for e in range(len(defects.head)):
        if e != d and defects.head[e, SIDE] == defects.head[d, SIDE]:
            other, other_s = roller_at_defect(model, e, t, y)
            if other == j and abs(other_s) < defects.head[e, HALF_WIDTH]:
                drop, share = mean_response(defects, d, s)
                other_drop, other_share = mean_response(defects, e, other_s)
                if prevails(other_drop, other_share, drop, share) or (
                    e < d and not prevails(drop, share, other_drop, other_share)
                ):
                    return True
    return False
