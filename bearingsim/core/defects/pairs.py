"""Roller-defect pairs: which contacts each defect acts on, and the arrays that store a case's defects for compiled
code.

A defect of a race forms one pair, with the rollers' contacts on that race. A defect of a roller forms two, one
with each race. ``head`` stores the properties of a pair, ``groups`` the path over it (``defects/closed_forms.py``,
``defects/traced.py``).
"""

from collections.abc import Sequence
from math import pi
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import jit

NO_WALL = 1.0  # m; stands for no wall: a wall at this distance is never reached

GROUP_WEIGHT, GROUP_HALF_WIDTH, X_E, KAPPA, DEPTH = range(5)  # columns of a group
GROUP_COLUMNS = 5  # number of columns

OUTER, INNER = 0, 1  # sides of a roller, on which it touches a race
ON_OUTER, ON_INNER = -1, -2  # carrier of a defect of a race; that of a roller is its number


class RollerDefectPair(NamedTuple):
    """A defect and the side of the rollers on which it acts: that of its race, or one of the two for a defect of a
    roller.

    side: OUTER or INNER; carrier: ON_OUTER, ON_INNER, or the number of the roller that carries it; angle: rad from
    the load line (on the inner race at t = 0), or from the roller's outermost point at t = 0; radius: of the
    surface that carries it (m); R: reduced radius of roller and race (m); groups: rows (w, b, x_e, kappa, depth);
    paths: of a traced defect, one for each group (``defects/traced.py``); cusp: position (m) of the sharpest cusp;
    span: shortest extent (m) along rolling of the defect or of one of its parts, or 0 if the whole width counts;
    jumps: positions (m) where the force or its damping part jumps (``defects/jumps.py``).
    """

    side: int
    carrier: int
    angle: float
    radius: float
    R: float
    groups: Sequence[tuple[float, ...]]
    paths: Sequence[Any] = ()
    cusp: float = 0.0
    span: float = 0.0
    jumps: Sequence[float] = ()

    @property
    def half_width(self) -> float:
        """Distance (m) from the centre beyond which no group of the defect acts."""
        return float(max(row[GROUP_HALF_WIDTH] for row in self.groups))


# columns of a roller-defect pair's head
SIDE, CARRIER, ANGLE, RADIUS, REDUCED_RADIUS, HALF_WIDTH, GROUP_COUNT, CUSP, SPAN, JUMP_COUNT = range(10)
FIRST_JUMP = 10


class Defects(NamedTuple):
    """All roller-defect pairs, in two arrays, because every array argument of a function costs reference counting.

    head: (D, 10 + largest number of jumps), first five as in ``RollerDefectPair``, then half_width (m), number of
    groups used, cusp (m), span (m), number of jumps and their positions (m); groups: (D, K, 5), padded with rows
    of weight zero; excitation: response of a roller to a defect (``defects/excitations.py``).
    """

    head: np.ndarray
    groups: np.ndarray
    excitation: Any


def pack_defects(pairs: Sequence[RollerDefectPair], excitation: Any, min_groups: int = 1) -> Defects:
    """Pack the roller-defect pairs into ``Defects``, with space for at least ``min_groups`` groups per pair."""
    group_count = max([min_groups, *(len(pair.groups) for pair in pairs)])
    groups = np.zeros((len(pairs), group_count, GROUP_COLUMNS))
    for row, pair in zip(groups, pairs, strict=True):
        row[: len(pair.groups)] = pair.groups
    head = np.zeros((len(pairs), FIRST_JUMP + max((len(pair.jumps) for pair in pairs), default=0)))
    for row, pair in zip(head, pairs, strict=True):
        half_width, count = pair.half_width, len(pair.groups)
        span = pair.span or 2.0 * half_width
        row[:FIRST_JUMP] = (
            pair.side,
            pair.carrier,
            pair.angle,
            pair.radius,
            pair.R,
            half_width,
            count,
            pair.cusp,
            span,
            len(pair.jumps),
        )
        row[FIRST_JUMP : FIRST_JUMP + len(pair.jumps)] = pair.jumps
    return Defects(head, groups, excitation)


def outer_reduced_radius(R_w: float, R_o: float) -> float:
    """Return the reduced radius (m) of roller and outer race: R_w R_o / (R_o - R_w)."""
    return R_w * R_o / (R_o - R_w)


def inner_reduced_radius(R_w: float, R_i: float) -> float:
    """Return the reduced radius (m) of roller and inner race: R_w R_i / (R_i + R_w)."""
    return R_w * R_i / (R_i + R_w)


@jit
def nearest_roller(defects, d, theta_c, theta_i, roll, Z):
    """Return the roller nearest to the defect of pair ``d``, and its distance s (m) along rolling from the
    defect's centre.

    theta_c: angle of roller 0 (rad); the Z rollers are evenly spaced. theta_i: angle of the inner ring. roll:
    angle by which a roller has rotated backwards relative to the line through its centre and the bearing's.
    Returns roller 0 if the motion has diverged and the angles are not finite or too large to resolve, so that the
    index is always valid.
    """
    head = defects.head[d]
    carrier = head[CARRIER]
    if carrier >= 0.0:
        revolutions = (roll - head[ANGLE]) / (2.0 * pi) - 0.5 * head[SIDE]
        return int(carrier), (revolutions - np.floor(revolutions + 0.5)) * 2.0 * pi * head[RADIUS]
    angle = head[ANGLE] + (theta_i if carrier == ON_INNER else 0.0)
    passages = (theta_c - angle) * Z / (2.0 * pi)
    nearest = np.floor(passages + 0.5)
    number = -nearest - Z * np.floor(-nearest / Z)
    j = int(number) if 0.0 <= number < Z else 0
    return j, (passages - nearest) * (2.0 * pi / Z) * head[RADIUS]


@jit
def passing_speed(defects, d, bearing):
    """Return the speed ds/dt (m/s) of rollers past the defect of pair ``d``, without slip."""
    carrier = defects.head[d, CARRIER]
    if carrier >= 0.0:
        return defects.head[d, RADIUS] * bearing.omega_b
    return defects.head[d, RADIUS] * (bearing.omega_c - (bearing.omega_i if carrier == ON_INNER else 0.0))
