"""Contact of one roller over a defect, summed over the defect's groups; scalar, because few rollers are in a
defect."""

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
    """Return the derivative (N/m) of the elastic force at any approach ``delta`` (m); zero out of contact for
    every law."""
    return tangent(stiffness, delta) if delta > 0.0 else 0.0


@jit
def elastic_over_defect(stiffness, defects, d, s, delta):
    """Return the elastic force (N), its derivative (N/m) and the mean approach (m) of a contact in roller-defect
    pair ``d``.

    delta: approach (m) to the undamaged race; ``s``: distance (m) from the defect's middle. ``d`` = -1: no defect.

    Equation (M10) of docs/model.md, either side.
    """
    if d < 0:
        return elastic(stiffness, max(delta, 0.0)), contact_stiffness(stiffness, delta), max(delta, 0.0)
    force, spring_rate, mean = 0.0, 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, _ = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, approach = share * group[GROUP_WEIGHT], max(delta - h, 0.0)
        force += weight * elastic(stiffness, approach)
        spring_rate += weight * contact_stiffness(stiffness, delta - h)
        mean += weight * approach
    return force, spring_rate, mean


@jit
def force_over_defect(contact, defects, d, s, speed, delta, v):
    """Return the force (N) of a contact in roller-defect pair ``d``, its sideways part, and mean approach (m) and
    closing rate (m/s).

    delta, v: approach (m) to the undamaged race and its rate (m/s); speed: ds/dt (m/s). The means are over the
    groups in contact, for the step monitor. The sideways part is sum Q_k dh_k/ds (N), minus the force in the
    direction of increasing s.

    Equation (M6) of docs/defects.md.
    """
    force, sideways, mean, closing, nearest, nearest_rate = 0.0, 0.0, 0.0, 0.0, -inf, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, rate = share * group[GROUP_WEIGHT], v - slope * speed
        group_force = weight * normal_force(contact, delta - h, rate)
        force += group_force
        sideways += group_force * slope
        mean += weight * max(delta - h, 0.0)
        closing += weight * max(delta - h, 0.0) * rate
        nearest_rate = rate if delta - h > nearest else nearest_rate
        nearest = max(nearest, delta - h)
    if mean > 0.0:
        return force, sideways, mean, closing / mean
    return force, sideways, nearest, nearest_rate


@jit
def correct_contact(side, contact, defects, d, j, s, speed, y):
    """Correct the contact of roller ``j`` in roller-defect pair ``d``; return the sideways part (N) of its force.

    The approach and rate stored for the roller are means over the groups in contact, for the step monitor.
    """
    force, approach, rate, _, _ = contact_rows(side)
    y[force + j], sideways, y[approach + j], y[rate + j] = force_over_defect(
        contact, defects, d, s, speed, y[approach + j], y[rate + j]
    )
    return sideways


@jit
def roller_drop_rate(stiffness, defects, d, s, speed, delta):
    """Return the mean rate (m/s) at which a contact in roller-defect pair ``d`` sinks, weighted by its elastic
    forces; 0 for no defect.

    Equation (M11) of docs/model.md, for a defect at the inner contact.
    """
    if d < 0:
        return 0.0
    force, moment = 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        group_force = share * group[GROUP_WEIGHT] * elastic(stiffness, max(delta - h, 0.0))
        force += group_force
        moment += group_force * slope * speed
    return moment / force if force > 0.0 else 0.0


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
def roller_drop_rate_derivative(stiffness, defects, d, s, speed, delta):
    """Return the derivative of ``roller_drop_rate`` with respect to the approach (1/s)."""
    force, moment, K_sum, K_moment = 0.0, 0.0, 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, slope = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        weight, approach = share * group[GROUP_WEIGHT], max(delta - h, 0.0)
        group_force = weight * elastic(stiffness, approach)
        K_group = weight * tangent(stiffness, approach) if approach > 0.0 else 0.0
        force += group_force
        moment += group_force * slope * speed
        K_sum += K_group
        K_moment += K_group * slope * speed
    return (K_moment - K_sum * moment / force) / force if force > 0.0 else 0.0


@jit
def mean_response(defects, d, s):
    """Return the mean drop (m) over the roller's length, and the share of the stiffness that remains (1)."""
    drop, total_share = 0.0, 0.0
    for k in range(int(defects.head[d, GROUP_COUNT])):
        group = defects.groups[d, k]
        share, h, _ = defect_response(defects.excitation, group, s, defects.head[d, REDUCED_RADIUS])
        drop += share * group[GROUP_WEIGHT] * h
        total_share += share * group[GROUP_WEIGHT]
    return drop, total_share


@inlined
def prevails(drop, share, other_drop, other_share):
    """Check if the first of two responses acts at a contact: the deeper one, of equally deep ones the softer."""
    return drop > other_drop or (drop == other_drop and share < other_share)


@generic
def roller_at_defect(model: Any, d: int, t: float, y: np.ndarray) -> tuple[int, float]:
    """Return the roller nearest to roller-defect pair ``d`` at time ``t`` (s), and its distance (m) from the
    defect's middle."""


def roller_at_defect_without_slip(model, d, t, y):
    """Implement ``roller_at_defect`` for rollers that are evenly spaced and turn without slip."""
    theta_c, theta_i, roll = kinematic_angles(model.bearing, t)
    return nearest_roller(model.defects, d, theta_c, theta_i, roll, model.bearing.Z)


@jit
def is_masked(model, d, j, s, t, y):
    """Check if another pair acts at this contact of roller ``j``, because its response prevails, or is equal and
    first."""
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
