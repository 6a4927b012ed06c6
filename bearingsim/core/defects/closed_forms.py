"""Closed forms of the roller path over a box, a V groove or a parabolic bowl, for each group of a defect.

A roller is round and cannot follow a narrow defect: its centre moves along the roller path, the envelope of the
roller over the profile p(t) of the defect,

    h(s) = min over t of [ p(t) + (t - s)^2 / (2 R) ],

where s is the distance along rolling from the defect's centre and R the reduced radius of roller and race: R = R_w
R_o / (R_o - R_w) on the outer race, R_w R_i / (R_i + R_w) on the inner. For these three shapes the minimum has one
closed form. With the half width b and the depth d of the section, and the distance x = max(b - |s|, 0) behind the
rim, split at x_e into x_1 = min(x, x_e) and x_2 = x - x_1,

    h = min(d, x_1^2 / (2 R) + x_1 x_2 / R - kappa x_2^2 / 2)

The roller first rests on the rim, beyond x_e it touches the wall (kappa follows from the wall's curvature relative
to the roller's), and at depth d it touches the floor.

Along the roller the defect is divided into groups of weight w (the weights sum to 1), each with its own b, x_e,
kappa and d: one group for the undamaged length, one for a box or a V groove (exact), one per Gauss node for a
bowl.
"""

from collections.abc import Sequence
from math import sqrt
from typing import Any

import numpy as np

from bearingsim.core.defects.depth import Circular, Rectangular, Triangular
from bearingsim.core.defects.pairs import DEPTH, GROUP_HALF_WIDTH, KAPPA, NO_WALL, X_E
from bearingsim.core.jit import generic, jit


@jit
def roller_drop(group, s, R):
    """Return the roller path h (m) of one group at ``s`` (m) from the defect's centre, and its slope dh/ds.

    Equation (M5) of docs/defects.md: the closed form of (M4) for a box, a V groove and a bowl.
    """
    x = max(group[GROUP_HALF_WIDTH] - abs(s), 0.0)
    x_1 = min(x, group[X_E])
    x_2 = x - x_1
    h = x_1 * x_1 / (2.0 * R) + x_1 * x_2 / R - group[KAPPA] * x_2 * x_2 / 2.0
    slope = x_1 / R - group[KAPPA] * x_2  # dh/dx, towards the centre
    if h >= group[DEPTH]:
        return group[DEPTH], 0.0
    return h, (-slope if s > 0.0 else slope)


@jit
def roller_drop_curvature(group, s, R):
    """Return the second derivative of ``roller_drop`` along ``s`` (1/m): 1/R on a rim,
    -kappa on a wall, 0 on a floor and off the defect."""
    x = max(group[GROUP_HALF_WIDTH] - abs(s), 0.0)
    on_floor = group[KAPPA] <= 0.0 and roller_drop(group, s, R)[0] >= group[DEPTH]  # a bowl has none
    if x == 0.0 or on_floor:
        return 0.0
    return 1.0 / R if x <= group[X_E] else -group[KAPPA]


def box_parameters(width: float, depth: float) -> tuple[float, float, float, float]:
    """Return b, x_e, kappa, depth of a rectangular section; the roller touches only its rims and its floor."""
    return width / 2.0, NO_WALL, 0.0, depth


def groove_parameters(width: float, depth: float, R: float) -> tuple[float, float, float, float]:
    """Return b, x_e, kappa, depth of a V groove.

    The roller leaves the rim where its path, of slope x/R, is as steep as the wall, 2 d/w.
    """
    return width / 2.0, R * 2.0 * depth / width, 0.0, depth


def bowl_parameters(width: float, depth: float, R: float, zeta: float) -> tuple[float, float, float, float]:
    """Return b, x_e, kappa, depth of a parabolic bowl's section at zeta = 2 z/L from its centre.

    The section is a smaller bowl of the same curvature. If it is flatter than the roller (radius w^2/(8 d) above
    R), the roller touches its wall, otherwise only its rims.
    """
    scale = 1.0 - zeta * zeta
    b = width / 2.0 * sqrt(scale)
    R_defect = width * width / (8.0 * depth)
    if R_defect <= R:
        return b, NO_WALL, 0.0, depth * scale
    return b, b * R / R_defect, 1.0 / (R_defect - R), depth * scale


NO_DEFECT = (0.0, NO_WALL, 0.0, 0.0)
"""b, x_e, kappa, depth where there is no defect."""


@generic
def section_parameters(defect: Any, R: float, zeta: float) -> tuple[float, float, float, float]:
    """Return b (m), x_e (m), kappa (1/m) and depth (m) of a section of a shape.

    R: reduced radius (m); zeta: 2 z/L of the section from the defect's centre,
    |zeta| < 1.
    """


@section_parameters.register(Rectangular)
def _section_rectangular(defect, R, zeta):
    return box_parameters(defect.width, defect.depth)


@section_parameters.register(Triangular)
def _section_triangular(defect, R, zeta):
    return groove_parameters(defect.width, defect.depth, R)


@section_parameters.register(Circular)
def _section_circular(defect, R, zeta):
    return bowl_parameters(defect.width, defect.depth, R, zeta)


def make_groups(defect: Any, L_w: float, R: float, nodes: int, offset: float = 0.0) -> list:
    """Return the groups (w, b, x_e, kappa, depth) of a defect with a closed form.

    L_w: contact length (m), beyond which the defect is ignored; R: reduced radius (m); nodes: Gauss nodes on half
    the length of a bowl; offset: position of the defect's centre along the roller (m).
    """
    low, high = max(-defect.length / 2.0, -L_w / 2.0 - offset), min(defect.length / 2.0, L_w / 2.0 - offset)
    share = min(1.0, max(high - low, 0.0) / L_w)
    undamaged = [(1.0 - share, *NO_DEFECT)] if share < 1.0 else []
    if share == 0.0:
        return undamaged
    if not isinstance(defect, Circular):
        return [*undamaged, (share, *section_parameters(defect, R, 0.0))]
    halves = [(0.0, high, share)] if low == -high else _split_at_centre(low, high, L_w)
    return [
        *undamaged,
        *(row for near, far, weight in halves for row in _make_bowl_groups(near, far, weight, defect, R, nodes)),
    ]


def _split_at_centre(low: float, high: float, L_w: float) -> list[tuple[float, float, float]]:
    """Return the range (m, m) of |z| over which each half of a defect acts, and its share (1) of the contact.

    low, high: range of z (m) from the defect's centre over which the defect acts.
    """
    if low >= 0.0 or high <= 0.0:
        a, b = sorted((abs(low), abs(high)))
        return [(a, b, (b - a) / L_w)]
    return [(0.0, -low, -low / L_w), (0.0, high, high / L_w)]


def _make_bowl_groups(near: float, far: float, share: float, defect: Any, R: float, nodes: int) -> list:
    """Return groups at Gauss nodes of a bowl, from ``near`` to ``far`` (m) from its centre, with ``share`` as the
    sum of their weights."""
    low, high = 2.0 * near / defect.length, 2.0 * far / defect.length
    zeta, weight = np.polynomial.legendre.leggauss(nodes)
    return [
        (
            share * float(w) / 2.0,
            *bowl_parameters(defect.width, defect.depth, R, low + (high - low) * (1.0 + float(z)) / 2.0),
        )
        for z, w in zip(zeta, weight, strict=True)
    ]


def make_slice_groups(defect: Any, R: float, centres: Sequence[float] | np.ndarray, offset: float = 0.0) -> list:
    """Return a group of weight 1 for each slice of a roller.

    centres: positions (m) of the slices' centres along the roller; offset: that of the defect's centre.
    """
    zetas = [2.0 * (z - offset) / defect.length for z in centres]
    return [(1.0, *(section_parameters(defect, R, zeta) if abs(zeta) < 1.0 else NO_DEFECT)) for zeta in zetas]
