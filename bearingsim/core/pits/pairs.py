"""Pits, and how far a roller sinks into them.

A roller is round and cannot follow a narrow pit: what its centre feels is the envelope of the roller over the
profile p(t) of the pit,

    h(s) = min over t of [ p(t) + (t - s)^2 / (2 R) ],

s being the distance along rolling from the pit's middle, and 1/R the curvature of roller and race relative to each
other: R = R_w R_o / (R_o - R_w) on the outer race, R_w R_i / (R_i + R_w) on the inner. For a box, a V groove and a
parabolic bowl the minimum has one closed form. With x = max(b - |s|, 0), the distance from the rim, split at x_e
into x_1 = min(x, x_e) and x_2 = x - x_1,

    h = min(d, x_1^2 / (2 R) + x_1 x_2 / R - kappa x_2^2 / 2)

that is: first the roller hangs on the rim, then (beyond x_e) it touches the wall, whose curvature relative to
the roller's gives kappa, and at depth d it touches the floor.

Along the roller the pit is cut into groups of weight w (their sum is 1), each with its own four numbers: one
group for the untouched length, one for a box or a V (exact), Gauss nodes for a bowl.
"""

from collections.abc import Sequence
from math import pi
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import jit

NEVER = 1.0  # m: a wall met only a metre from the rim is never met

W, B, X_E, KAPPA, DEPTH = range(5)  # columns of a group
GROUP = 5

OUTER, INNER = 0, 1  # sides of a roller, on which it touches a race
ON_OUTER, ON_INNER = -1, -2  # what carries a pit, if no roller


class Meeting(NamedTuple):
    """A pit as one contact meets it. A pit of a race is met on that race's side, a roller's pit on both.

    side: OUTER or INNER; on: ON_OUTER, ON_INNER, or the number of the roller that carries it; angle: rad from the
    load line (on the inner race at t = 0), or from the roller's outermost point at t = 0; radius: of the surface
    that carries it (m); R: reduced radius of roller and race (m); groups: rows (w, b, x_e, kappa, depth); paths:
    of a traced pit, one for each group (``pits/traced.py``); cusp: place (m) of the sharpest cusp; span: the
    shortest way (m) over the pit or a part of it, 0 if from rim to rim; jumps: places (m) where the force or its
    damping part jumps (``pits/jumps.py``).
    """

    side: int
    on: int
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
        """The distance (m) from the middle beyond which no group feels the pit."""
        return float(max(row[B] for row in self.groups))


SIDE, ON, ANGLE, RADIUS, REDUCED, HALF_WIDTH, USED, CUSP, SPAN, JUMPS = range(10)  # columns of a meeting's head
FIRST_JUMP = 10


class Pits(NamedTuple):
    """All meetings, packed in few arrays: each one that a function is handed costs it reference counting.

    head: (D, 10 + most jumps) as in ``Meeting``, then half_width (m), beyond which no roller feels the pit, used,
    its number of groups, cusp (m), span (m), the number of jumps and their places (m); groups: (D, K, 5), padded
    with rows of weight zero; excitation: what a roller feels of a pit (``pits/excitations.py``).
    """

    head: np.ndarray
    groups: np.ndarray
    excitation: Any


def pits(meetings: Sequence[Meeting], excitation: Any, most: int = 1) -> Pits:
    """Pack the meetings into the arrays the core reads, with room for ``most`` groups each or more."""
    deepest = max([most, *(len(one.groups) for one in meetings)])
    groups = np.zeros((len(meetings), deepest, GROUP))
    for row, one in zip(groups, meetings, strict=True):
        row[: len(one.groups)] = one.groups
    head = np.zeros((len(meetings), FIRST_JUMP + max((len(one.jumps) for one in meetings), default=0)))
    for row, one in zip(head, meetings, strict=True):
        reach, used = one.half_width, len(one.groups)
        span = one.span or 2.0 * reach
        row[:FIRST_JUMP] = (
            one.side,
            one.on,
            one.angle,
            one.radius,
            one.R,
            reach,
            used,
            one.cusp,
            span,
            len(one.jumps),
        )
        row[FIRST_JUMP : FIRST_JUMP + len(one.jumps)] = one.jumps
    return Pits(head, groups, excitation)


def outer_reduced_radius(R_w: float, R_o: float) -> float:
    """Radius (m) of the roller relative to the outer race it rolls in: R_w R_o / (R_o - R_w)."""
    return R_w * R_o / (R_o - R_w)


def inner_reduced_radius(R_w: float, R_i: float) -> float:
    """Radius (m) of the roller relative to the inner race it rolls on: R_w R_i / (R_i + R_w)."""
    return R_w * R_i / (R_i + R_w)


@jit
def depression(group, s, R):
    """Envelope h (m) of one group at ``s`` (m) from the pit's middle, and its slope dh/ds."""
    x = max(group[B] - abs(s), 0.0)
    x_1 = min(x, group[X_E])
    x_2 = x - x_1
    h = x_1 * x_1 / (2.0 * R) + x_1 * x_2 / R - group[KAPPA] * x_2 * x_2 / 2.0
    slope = x_1 / R - group[KAPPA] * x_2  # against |s|, downwards
    if h >= group[DEPTH]:
        return group[DEPTH], 0.0
    return h, (-slope if s > 0.0 else slope)


@jit
def depression_bend(group, s, R):
    """How the slope of ``depression`` grows along ``s`` (1/m): 1/R on a rim, -kappa on a wall, none on a floor."""
    x = max(group[B] - abs(s), 0.0)
    if x == 0.0 or depression(group, s, R)[0] >= group[DEPTH]:
        return 0.0
    return 1.0 / R if x <= group[X_E] else -group[KAPPA]


@jit
def meeting(pits, d, theta_c, theta_i, roll, Z):
    """Which roller is nearest to meeting ``d``, and its distance s (m) along rolling from the pit's middle.

    theta_c: angle of roller 0 (rad); the Z rollers are evenly spaced. theta_i: angle of the inner ring. roll: how
    far a roller has turned backwards relative to the line through its centre and the bearing's. Where motion has
    blown up, and angles are not finite or too large to tell rollers apart, it is roller 0: no index is ever wild.
    """
    head = pits.head[d]
    on = head[ON]
    if on >= 0.0:
        turn = (roll - head[ANGLE]) / (2.0 * pi) - 0.5 * head[SIDE]
        return int(on), (turn - np.floor(turn + 0.5)) * 2.0 * pi * head[RADIUS]
    place = head[ANGLE] + (theta_i if on == ON_INNER else 0.0)
    turn = (theta_c - place) * Z / (2.0 * pi)
    nearest = np.floor(turn + 0.5)
    number = -nearest - Z * np.floor(-nearest / Z)
    j = int(number) if 0.0 <= number < Z else 0
    return j, (turn - nearest) * (2.0 * pi / Z) * head[RADIUS]


@jit
def sliding(pits, d, bearing):
    """How fast (m/s) rollers move past the pit, ds/dt, at kinematic speeds."""
    on = pits.head[d, ON]
    if on >= 0.0:
        return pits.head[d, RADIUS] * bearing.omega_b
    return pits.head[d, RADIUS] * (bearing.omega_c - (bearing.omega_i if on == ON_INNER else 0.0))
