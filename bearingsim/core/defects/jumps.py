"""Time of the next jump of the force on a roller: at a cusp of its path, or at the start or end of a pulse.

At a cusp the slope of the path drops, so the closing rate and with it the damping force jump; under a pulse the
approach itself jumps. In a step across a jump a method loses its order, so adaptive methods end a step there. The
positions are computed when a roller-defect pair is built (``jump_positions``) and stored in its head
(``defects/pairs.py``).
"""

from collections.abc import Sequence
from math import inf, pi
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.envelope import SLOPE, Path, S, piece_ends
from bearingsim.core.defects.excitations import defect_response
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.pairs import (
    CARRIER,
    DEPTH,
    FIRST_JUMP,
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    JUMP_COUNT,
    ON_INNER,
    RADIUS,
    X_E,
    passing_speed,
)
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.jit import generic, jit

PROBE = 1e-9  # m: distance to either side of a position for evaluating its jump
MIN_RELATIVE_JUMP = 0.05  # relative to the largest jump of a pair; the error control handles smaller ones
NEAR_JUMP = 1e-8  # m: below this distance from a jump its predicted time is not reduced
JUMP_GAP = 1e-12  # s: distance from a jump at which a step ends or begins
MAX_JUMPS = 32  # per roller-defect pair; a rough defect has hundreds of small ones


# Positions of jumps, computed once in plain Python


def jump_positions(
    excitation: Any, groups: Sequence[Sequence[float]], paths: Sequence[Path], R: float
) -> list[float]:
    """Return in order the positions (m) along rolling where the force over a pair's groups, or its damping part,
    jumps.

    paths: one per group of a traced defect, else empty. Jumps of several groups at one position add up.
    """
    jump_at: dict[float, np.ndarray] = {}
    for k, row in enumerate(groups):
        jumps_of_group = path_cusps(paths[k]) if paths else group_jumps(excitation, np.array([*row]), R)
        for position, jump in jumps_of_group:
            rounded = round(position, 9) + 0.0
            jump_at[rounded] = jump_at.get(rounded, np.zeros(3)) + row[GROUP_WEIGHT] * jump
    positions, jumps = np.array([*jump_at]), np.array([*jump_at.values()]).reshape(-1, 3)
    largest = np.maximum(jumps.max(axis=0, initial=0.0), 1e-30)  # each kind of jump has its own scale
    relative_jumps = (jumps / largest).max(axis=1)
    selected = np.argsort(-relative_jumps, kind="stable")[:MAX_JUMPS]
    return sorted(float(positions[i]) for i in selected if relative_jumps[i] > MIN_RELATIVE_JUMP)


def group_jumps(excitation: Any, group: np.ndarray, R: float) -> list[tuple[float, np.ndarray]]:
    """Return the positions (m) of jumps, and the jumps of share (1), drop (m) and slope (1) there."""
    positions = {
        0.0,
        float(group[GROUP_HALF_WIDTH]),
        float(group[GROUP_HALF_WIDTH] - group[X_E]),
        full_depth_half_width(excitation, group, R),
    }
    jumps = []
    for position in {
        sign * position
        for position in positions
        if 0.0 <= position <= group[GROUP_HALF_WIDTH]
        for sign in (-1.0, 1.0)
    }:
        before, after = (np.array(defect_response(excitation, group, position + d, R)) for d in (-PROBE, PROBE))
        jump = np.abs(after - before)
        smooth_change = (
            10.0 * PROBE * np.array([1.0 / group[GROUP_HALF_WIDTH], 1.0, 1.0 / R])
            if group[GROUP_HALF_WIDTH] > 0.0
            else np.full(3, inf)
        )
        if (jump > smooth_change).any():
            jumps.append((position, np.where(jump > smooth_change, jump, 0.0)))
    return jumps


def full_depth_half_width(excitation: Any, group: np.ndarray, R: float) -> float:
    """Return the largest distance (m) from the centre at which a group acts with its full depth; -1 if there is
    none."""
    if defect_response(excitation, group, 0.0, R)[1] < group[DEPTH]:
        return -1.0
    low, high = 0.0, float(group[GROUP_HALF_WIDTH])
    for _ in range(60):
        midpoint = 0.5 * (low + high)
        if defect_response(excitation, group, midpoint, R)[1] >= group[DEPTH]:
            low = midpoint
        else:
            high = midpoint
    return low


def path_cusps(path: Path) -> list[tuple[float, np.ndarray]]:
    """Return the positions (m) where the slope of a path drops, with the jumps as in ``group_jumps``."""
    if len(path.pieces) == 0:
        return []
    positions, next_slopes = np.append(path.pieces[1:, S], path.end), np.append(path.pieces[1:, SLOPE], 0.0)
    slope_drops = piece_ends(path)[:, 1] - next_slopes
    return [
        (float(position), np.array([0.0, 0.0, drop]))
        for position, drop in zip(positions, slope_drops, strict=True)
        if drop > 1e-6
    ]


# Times at which contacts reach these positions


@generic
def next_jump(model: Any, t: float, y: np.ndarray) -> float:
    """Return the time (s) of the next jump of a force after ``t`` (s); inf if there is none.

    For freely moving rollers the time is predicted from the state in ``y``; it is too early until the jump is
    near. For rollers without slip the result is ``NEXT_STOP`` in ``y`` if that is later than ``t``, so
    ``NEXT_STOP`` must be the result for an earlier time.
    """


@jit
def distance_to_jump(defects, d, s, forwards):
    """Return the distance (m) from ``s`` to the next jump of roller-defect pair ``d``, in the direction of
    increasing s if ``forwards``; inf if there is none ahead.
    """
    shortest = inf
    for k in range(int(defects.head[d, JUMP_COUNT])):
        distance = defects.head[d, FIRST_JUMP + k] - s
        distance = distance if forwards else -distance
        shortest = min(shortest, distance if distance >= 0.0 else inf)
    return shortest


@jit
def spacing(defects, d, Z):
    """Return the distance (m) along rolling between successive contacts at roller-defect pair ``d``."""
    return 2.0 * pi * defects.head[d, RADIUS] / (1 if defects.head[d, CARRIER] >= 0.0 else Z)


def next_jump_without_slip(model, t, y):
    """Implement ``next_jump`` for rollers that are evenly spaced and roll without slip.

    The time is exact, so the stored time is valid until it is passed.
    """
    if y[lay.NEXT_STOP] > t + JUMP_GAP:
        return y[lay.NEXT_STOP]
    defects, b = model.defects, model.bearing
    t_jump = inf
    for d in range(len(defects.head)):
        speed = passing_speed(defects, d, b)
        if speed != 0.0:
            _, s = roller_at_defect(model, d, t, y)
            roller_spacing = spacing(defects, d, b.Z)
            next_distance = distance_to_jump(
                defects, d, s - roller_spacing if speed > 0.0 else s + roller_spacing, speed > 0.0
            )
            distance = min(distance_to_jump(defects, d, s, speed > 0.0), next_distance)
            t_jump = min(t_jump, t + distance / abs(speed))
    return t_jump


def next_jump_with_slip(model, t, y):
    """Implement ``next_jump`` for rollers at any position, from the velocity of the roller nearest to each defect.

    The transverse motion of the rings, a thousandth of the speed, is neglected. The predicted distance is
    therefore reduced by a hundredth until it is below ``NEAR_JUMP``. For a skewed roller the position of its
    centre is used.
    """
    defects, b = model.defects, model.bearing
    _, rate, _ = kinematic_time(model.motion, t)
    t_jump = inf
    for d in range(len(defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        carrier = defects.head[d, CARRIER]
        angular_speed = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C] + y[lay.EPS_V + j]
        if carrier >= 0.0:
            angular_speed -= (b.omega_c - b.omega_b) * rate + y[lay.SPIN_V + j]
        else:
            angular_speed -= b.omega_i * rate if carrier == ON_INNER else y[lay.VELOCITY + lay.PSI]
        speed = defects.head[d, RADIUS] * angular_speed
        if speed != 0.0:
            distance = distance_to_jump(defects, d, s, speed > 0.0)
            t_jump = min(t_jump, t + (distance if distance < NEAR_JUMP else 0.99 * distance) / abs(speed))
    return t_jump
