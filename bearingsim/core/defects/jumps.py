"""When the force on a roller jumps next: at the cusp of a roller path, or where a pulse begins or ends.

At a cusp the slope of a roller's path falls, so its closing rate and with it the damping force jump; under a
pulse the approach itself jumps. A step that looks across loses its order there, so adaptive methods stop on these
positions. They lie in the head of each roller-defect pair (``defects/pairs.py``), found when it is built
(``jumps_of``).
"""

from collections.abc import Sequence
from math import inf, pi
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.envelope import Path, S, ends_of
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

PROBE = 1e-9  # m: distance to either side of a position over which jumps are sought
LEAST_SHARPNESS = 0.05  # of a roller-defect pair's sharpest jump: duller ones are left to the control of the error
NEAR_JUMP = 1e-8  # m: from so near a roller comes straight to a jump
MAX_JUMPS = 32  # kept of a roller-defect pair; a rough defect has hundreds of small ones


# Where things jump: found once, in plain Python


def jumps_of(excitation: Any, groups: Sequence[Sequence[float]], paths: Sequence[Path], R: float) -> list[float]:
    """Return the positions (m) along rolling where the force over a pair's groups jumps, or its damping part, in
    order.

    paths: of a traced defect, one for each group, else none. Jumps of several groups at one position add up.
    """
    jump_at: dict[float, np.ndarray] = {}
    for k, row in enumerate(groups):
        jumps = cusps_of(paths[k]) if paths else jumps_of_group(excitation, np.array([*row]), R)
        for position, jump in jumps:
            rounded = round(position, 9) + 0.0
            jump_at[rounded] = jump_at.get(rounded, np.zeros(3)) + row[GROUP_WEIGHT] * jump
    positions, sizes = np.array([*jump_at]), np.array([*jump_at.values()]).reshape(-1, 3)
    largest = np.maximum(sizes.max(axis=0, initial=0.0), 1e-30)  # each kind beside its like
    sharpness = (sizes / largest).max(axis=1)
    sharpest = np.argsort(-sharpness, kind="stable")[:MAX_JUMPS]
    return sorted(float(positions[i]) for i in sharpest if sharpness[i] > LEAST_SHARPNESS)


def jumps_of_group(excitation: Any, group: np.ndarray, R: float) -> list[tuple[float, np.ndarray]]:
    """Return the positions (m) of jumps, and the jumps of share (1), drop (m) and slope (1) there."""
    positions = {
        0.0,
        float(group[GROUP_HALF_WIDTH]),
        float(group[GROUP_HALF_WIDTH] - group[X_E]),
        floor_reach(excitation, group, R),
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
        smooth = (
            10.0 * PROBE * np.array([1.0 / group[GROUP_HALF_WIDTH], 1.0, 1.0 / R])
            if group[GROUP_HALF_WIDTH] > 0.0
            else np.full(3, inf)
        )
        if (jump > smooth).any():
            jumps.append((position, np.where(jump > smooth, jump, 0.0)))
    return jumps


def floor_reach(excitation: Any, group: np.ndarray, R: float) -> float:
    """Return the greatest distance (m) from the middle at which a group acts in its full depth; -1 if nowhere."""
    if defect_response(excitation, group, 0.0, R)[1] < group[DEPTH]:
        return -1.0
    low, high = 0.0, float(group[GROUP_HALF_WIDTH])
    for _ in range(60):
        middle = 0.5 * (low + high)
        if defect_response(excitation, group, middle, R)[1] >= group[DEPTH]:
            low = middle
        else:
            high = middle
    return low


def cusps_of(path: Path) -> list[tuple[float, np.ndarray]]:
    """Return the positions (m) where the slope of a path falls, and by how much, as ``jumps_of_group``."""
    if len(path.pieces) == 0:
        return []
    positions, after = np.append(path.pieces[1:, S], path.end), np.append(path.pieces[1:, 2], 0.0)
    falls = ends_of(path)[:, 1] - after
    return [
        (float(position), np.array([0.0, 0.0, fall]))
        for position, fall in zip(positions, falls, strict=True)
        if fall > 1e-6
    ]


# When a contact comes to one


@generic
def next_jump(model: Any, t: float, y: np.ndarray) -> float:
    """Return the time (s) of the next jump of a force, from ``t`` (s) on; inf where there is none.

    Of rollers that move freely it is a prediction from the state in ``y``, which falls short until it is near.
    """


@jit
def distance_to_jump(defects, d, s, forwards):
    """Return the way (m) from ``s`` to the next jump of roller-defect pair ``d``, s growing if ``forwards``; inf
    if none is ahead.
    """
    least = inf
    for k in range(int(defects.head[d, JUMP_COUNT])):
        way = defects.head[d, FIRST_JUMP + k] - s
        way = way if forwards else -way
        least = min(least, way if way >= 0.0 else inf)
    return least


@jit
def spacing(defects, d, Z):
    """Return the way (m) along rolling between two contacts that come to roller-defect pair ``d`` one after the
    other."""
    return 2.0 * pi * defects.head[d, RADIUS] / (1 if defects.head[d, CARRIER] >= 0.0 else Z)


def next_jump_evenly(model, t, y):
    """Implement ``next_jump`` for rollers that are evenly spaced and turn without slip: exact."""
    defects, b = model.defects, model.bearing
    soonest = inf
    for d in range(len(defects.head)):
        speed = passing_speed(defects, d, b)
        if speed != 0.0:
            _, s = roller_at_defect(model, d, t, y)
            follows = spacing(defects, d, b.Z)
            next_one = distance_to_jump(defects, d, s - follows if speed > 0.0 else s + follows, speed > 0.0)
            way = min(distance_to_jump(defects, d, s, speed > 0.0), next_one)
            soonest = min(soonest, t + way / abs(speed))
    return soonest


def next_jump_freely(model, t, y):
    """Implement ``next_jump`` for rollers at any position: of the one nearest to each pair, from its velocity.

    Left out of its speed: that the rings move across, a thousandth of it. So the time falls short by a hundredth
    of the way, until that is ``NEAR_JUMP``. Of a skewed roller its middle counts.
    """
    defects, b = model.defects, model.bearing
    _, rate, _ = kinematic_time(model.motion, t)
    soonest = inf
    for d in range(len(defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        on = defects.head[d, CARRIER]
        turning = b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C] + y[lay.EPS_V + j]
        if on >= 0.0:
            turning -= (b.omega_c - b.omega_b) * rate + y[lay.SPIN_V + j]
        else:
            turning -= b.omega_i * rate if on == ON_INNER else y[lay.VELOCITY + lay.PSI]
        speed = defects.head[d, RADIUS] * turning
        if speed != 0.0:
            way = distance_to_jump(defects, d, s, speed > 0.0)
            soonest = min(soonest, t + (way if way < NEAR_JUMP else 0.99 * way) / abs(speed))
    return soonest
