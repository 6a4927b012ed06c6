"""Pits, and how far a roller sinks into them.

A roller is round and cannot follow a narrow pit: what its centre feels is the envelope of the roller over the
profile p(t) of the pit,

    h(s) = min over t of [ p(t) + (t - s)^2 / (2 R) ],    R = R_w R_o / (R_o - R_w) on the outer race,

s being the distance along the race from the pit's middle. For a box, a V groove and a parabolic bowl the
minimum has one closed form. With x = max(b - |s|, 0), the distance from the rim, split at x_e into
x_1 = min(x, x_e) and x_2 = x - x_1,

    h = min(d, x_1^2 / (2 R) + x_1 x_2 / R - kappa x_2^2 / 2)

that is: first the roller hangs on the rim, then (beyond x_e) it touches the wall, whose curvature relative to
the roller's gives kappa, and at depth d it touches the floor.

Along the roller the pit is cut into groups of weight w (their sum is 1), each with its own four numbers: one
group for the untouched length, one for a box or a V (exact), Gauss nodes for a bowl.
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import jit

NEVER = 1.0  # m: a wall met only a metre from the rim is never met

W, B, X_E, KAPPA, DEPTH = range(5)  # columns of a group
GROUP = 5


class Pits(NamedTuple):
    """Pits of the outer race.

    angle: (D,) rad from the load line; groups: (D, K, 5) rows w, b (m), x_e (m), kappa (1/m), depth (m), padded
    with rows of weight zero; used: (D,) rows in use; half_width: (D,) m, beyond which no roller feels the pit;
    R: reduced radius (m); R_o: race radius (m).
    """

    angle: np.ndarray
    groups: np.ndarray
    used: np.ndarray
    half_width: np.ndarray
    R: float
    R_o: float


def box(width: float, depth: float) -> tuple[float, float, float, float]:
    """b, x_e, kappa, depth of a rectangular section: rim, then floor."""
    return width / 2.0, NEVER, 0.0, depth


def groove(width: float, depth: float, R: float) -> tuple[float, float, float, float]:
    """The same for a V: the wall of slope 2d/w is met where the rim's slope x/R reaches it."""
    return width / 2.0, R * 2.0 * depth / width, 0.0, depth


def bowl(width: float, depth: float, R: float, zeta: float) -> tuple[float, float, float, float]:
    """The same for a parabolic bowl at zeta = 2 z/L from its middle: a smaller bowl of the same curvature.

    Flatter than the roller (its radius w^2/(8 d) above R) it is met along its wall, else on its rims only.
    """
    rest = 1.0 - zeta * zeta
    b = width / 2.0 * sqrt(rest)
    R_pit = width * width / (8.0 * depth)
    if R_pit <= R:
        return b, NEVER, 0.0, depth * rest
    return b, b * R / R_pit, 1.0 / (R_pit - R), depth * rest


def groups_of(shape: str, length: float, width: float, depth: float, L_w: float, R: float, nodes: int) -> list:
    """Groups (w, b, x_e, kappa, depth) of a centred pit; lengths in m, ``nodes`` on a bowl's half length."""
    share = length / L_w
    untouched = [(1.0 - share, 0.0, NEVER, 0.0, 0.0)] if share < 1.0 else []
    if shape == "rectangular":
        return [*untouched, (share, *box(width, depth))]
    if shape == "triangular":
        return [*untouched, (share, *groove(width, depth, R))]
    if shape == "circular":
        zeta, weight = np.polynomial.legendre.leggauss(nodes)
        bowls = [
            (share * float(w) / 2.0, *bowl(width, depth, R, (1.0 + float(z)) / 2.0))
            for z, w in zip(zeta, weight, strict=True)
        ]
        return [*untouched, *bowls]
    raise ValueError(f"no such shape: {shape}")


def pits(angles: list[float], groups: list[list], R_w: float, R_o: float) -> Pits:
    """Pack the groups of each pit (see ``groups_of``) into the arrays the core reads."""
    deepest = max([len(rows) for rows in groups], default=1)
    packed = np.zeros((len(groups), deepest, GROUP))
    for one, rows in zip(packed, groups, strict=True):
        one[: len(rows)] = rows
    used = np.array([len(rows) for rows in groups], dtype=np.int64)
    return Pits(
        angle=np.array(angles, dtype=float),
        groups=packed,
        used=used,
        half_width=packed[:, :, B].max(axis=1),
        R=outer_reduced_radius(R_w, R_o),
        R_o=float(R_o),
    )


def outer_reduced_radius(R_w: float, R_o: float) -> float:
    """Radius (m) of the roller relative to the outer race it rolls in: R_w R_o / (R_o - R_w)."""
    return R_w * R_o / (R_o - R_w)


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
def roller_over(pits, d, theta_c, Z):
    """Which of Z evenly spaced rollers is nearest to pit ``d``, and its distance s (m) from the pit's middle.

    theta_c: angle of roller 0 (rad); roller j stands at theta_c + 2 pi j/Z.
    """
    turns = (theta_c - pits.angle[d]) * Z / (2.0 * pi)
    nearest = np.floor(turns + 0.5)
    j = int(-nearest - Z * np.floor(-nearest / Z))
    return j, (turns - nearest) * (2.0 * pi / Z) * pits.R_o
