"""One contact of a roller over a pit: the sum over the pit's groups; scalar, since few rollers stand in one."""

from typing import Any

import numpy as np

from bearingsim.core.geometry.sides import totals
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force, slopes
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.parameters import turns
from bearingsim.core.pits.excitations import felt
from bearingsim.core.pits.pairs import HALF_WIDTH, REDUCED, SIDE, USED, W, meeting


@jit
def elastic_over_pit(stiffness, pits, d, s, delta):
    """Elastic force (N), its slope (N/m) and the mean approach (m) of a contact that stands in meeting ``d``.

    delta: approach (m) to the undamaged race; ``s``: distance (m) from the pit's middle. ``d`` = -1: no pit.
    """
    if d < 0:
        return elastic(stiffness, max(delta, 0.0)), tangent(stiffness, max(delta, 0.0)), max(delta, 0.0)
    force, slope, mean = 0.0, 0.0, 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, _ = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        weight, here = share * group[W], max(delta - h, 0.0)
        force += weight * elastic(stiffness, here)
        slope += weight * tangent(stiffness, here)
        mean += weight * here
    return force, slope, mean


@jit
def force_over_pit(contact, pits, d, s, speed, delta, v):
    """Force (N) of a contact in meeting ``d``, its sideways part, and mean approach (m) and closing rate (m/s).

    delta, v: approach (m) to the undamaged race and its rate (m/s); speed: ds/dt (m/s). The means are over what is
    in contact, for the step watch. The sideways part is sum Q_k dh_k/ds (N): times -1 the push along growing s.
    """
    force, sideways, mean, closing = 0.0, 0.0, 0.0, 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, slope = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        weight, rate = share * group[W], v - slope * speed
        part = weight * normal_force(contact, delta - h, rate)
        force += part
        sideways += part * slope
        mean += weight * max(delta - h, 0.0)
        closing += weight * max(delta - h, 0.0) * rate
    return force, sideways, mean, (closing / mean if mean > 0.0 else 0.0)


@jit
def correct_contact(side, contact, pits, d, j, s, speed, y):
    """Correct the contact of roller ``j`` that stands in meeting ``d``; returns its force's sideways part (N).

    The approach and rate kept for the roller are means over what is in contact, for the step watch.
    """
    force, approach, rate, _, _ = totals(side)
    y[force + j], sideways, y[approach + j], y[rate + j] = force_over_pit(
        contact, pits, d, s, speed, y[approach + j], y[rate + j]
    )
    return sideways


@jit
def sinking_rate(stiffness, pits, d, s, speed, delta):
    """Mean rate (m/s) at which a contact in meeting ``d`` sinks, weighted by its elastic forces; 0 for no pit."""
    if d < 0:
        return 0.0
    force, moment = 0.0, 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, slope = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        part = share * group[W] * elastic(stiffness, max(delta - h, 0.0))
        force += part
        moment += part * slope * speed
    return moment / force if force > 0.0 else 0.0


@jit
def slopes_over_pit(contact, pits, d, s, speed, delta, v):
    """How the force of ``force_over_pit`` grows with the approach (N/m) and with its rate (N s/m)."""
    K, C = 0.0, 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, slope = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        by_approach, by_rate = slopes(contact, delta - h, v - slope * speed)
        K += share * group[W] * by_approach
        C += share * group[W] * by_rate
    return K, C


@jit
def stiffness_over_pit(stiffness, pits, d, s, delta):
    """Slope (N/m) of the elastic force of what is in contact; ``d`` = -1: no pit."""
    if d < 0:
        return tangent(stiffness, delta) if delta > 0.0 else 0.0
    slope = 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, _ = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        slope += share * group[W] * (tangent(stiffness, delta - h) if delta > h else 0.0)
    return slope


@jit
def sinking_slope(stiffness, pits, d, s, speed, delta):
    """How ``sinking_rate`` grows with the approach (1/s)."""
    force, moment, stiff, stiff_moment = 0.0, 0.0, 0.0, 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, slope = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        weight, here = share * group[W], max(delta - h, 0.0)
        part = weight * elastic(stiffness, here)
        growth = weight * tangent(stiffness, here) if here > 0.0 else 0.0
        force += part
        moment += part * slope * speed
        stiff += growth
        stiff_moment += growth * slope * speed
    return (stiff_moment - stiff * moment / force) / force if force > 0.0 else 0.0


@jit
def mean_sinking(pits, d, s):
    """Mean sinking (m) over the roller's length."""
    mean = 0.0
    for k in range(int(pits.head[d, USED])):
        group = pits.groups[d, k]
        share, h, _ = felt(pits.excitation, group, s, pits.head[d, REDUCED])
        mean += share * group[W] * h
    return mean


@generic
def standing(model: Any, d: int, t: float, y: np.ndarray) -> tuple[int, float]:
    """The roller nearest to meeting ``d`` at time ``t`` (s), and its distance (m) from the pit's middle."""


def standing_evenly(model, d, t, y):
    """``standing`` of rollers that stand evenly spaced and turn without slip."""
    theta_c, theta_i, roll = turns(model.bearing, t)
    return meeting(model.pits, d, theta_c, theta_i, roll, model.bearing.Z)


@jit
def outdone(model, d, j, s, t, y):
    """Whether another meeting counts at this contact of roller ``j``: of two pits the deeper one is felt."""
    pits = model.pits
    for e in range(len(pits.head)):
        if e != d and pits.head[e, SIDE] == pits.head[d, SIDE]:
            other, along = standing(model, e, t, y)
            if other == j and abs(along) < pits.head[e, HALF_WIDTH]:
                here, there = mean_sinking(pits, d, s), mean_sinking(pits, e, along)
                if there > here or (there == here and e < d):
                    return True
    return False
