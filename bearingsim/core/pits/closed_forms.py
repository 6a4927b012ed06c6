"""Pits whose roller's path has a closed form: boxes, V grooves and parabolic bowls, cut into groups.

A group is a part of the contact over one section of the pit: its weight w, half width b (m), the distance x_e (m)
from the rim at which the roller meets wall or floor, the path's curvature kappa there beyond the rim's, and its
depth (m); ``pairs.py`` says how the path follows from them.
"""

from collections.abc import Sequence
from math import sqrt
from typing import Any

import numpy as np

from bearingsim.core.jit import generic
from bearingsim.core.pits.depth import Circular, Rectangular, Triangular
from bearingsim.core.pits.pairs import NEVER


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


UNTOUCHED = (0.0, NEVER, 0.0, 0.0)
"""b, x_e, kappa, depth where there is no pit."""


@generic
def section_of(pit: Any, R: float, zeta: float) -> tuple[float, float, float, float]:
    """b, x_e, kappa, depth of a shape's section at zeta = 2 z/L from its middle, |zeta| < 1."""


@section_of.register(Rectangular)
def _section_rectangular(pit, R, zeta):
    return box(pit.width, pit.depth)


@section_of.register(Triangular)
def _section_triangular(pit, R, zeta):
    return groove(pit.width, pit.depth, R)


@section_of.register(Circular)
def _section_circular(pit, R, zeta):
    return bowl(pit.width, pit.depth, R, zeta)


def groups_of(pit: Any, L_w: float, R: float, nodes: int, offset: float = 0.0) -> list:
    """Groups (w, b, x_e, kappa, depth) of a pit; lengths in m, ``nodes`` on a bowl's half length.

    offset: of the pit's middle along the roller (m). What lies beyond the contact (``L_w``) is not felt.
    """
    low, high = max(-pit.length / 2.0, -L_w / 2.0 - offset), min(pit.length / 2.0, L_w / 2.0 - offset)
    share = min(1.0, max(high - low, 0.0) / L_w)
    untouched = [(1.0 - share, *UNTOUCHED)] if share < 1.0 else []
    if share == 0.0:
        return untouched
    if not isinstance(pit, Circular):
        return [*untouched, (share, *section_of(pit, R, 0.0))]
    halves = [(0.0, high, share)] if low == -high else _halves(low, high, L_w)
    return [*untouched, *(row for half in halves for row in _bowls(half, pit, R, nodes))]


def _halves(low: float, high: float, L_w: float) -> list[tuple[float, float, float]]:
    """From where to where (m, from the middle) either half of a pit is felt, and its share of the contact."""
    if low >= 0.0 or high <= 0.0:
        a, b = sorted((abs(low), abs(high)))
        return [(a, b, (b - a) / L_w)]
    return [(0.0, -low, -low / L_w), (0.0, high, high / L_w)]


def _bowls(half: tuple[float, float, float], pit: Any, R: float, nodes: int) -> list:
    low, high = 2.0 * half[0] / pit.length, 2.0 * half[1] / pit.length
    zeta, weight = np.polynomial.legendre.leggauss(nodes)
    return [
        (half[2] * float(w) / 2.0, *bowl(pit.width, pit.depth, R, low + (high - low) * (1.0 + float(z)) / 2.0))
        for z, w in zip(zeta, weight, strict=True)
    ]


def slices_of(pit: Any, R: float, zetas: Sequence[float] | np.ndarray, offset: float = 0.0) -> list:
    """A group of weight 1 for each slice of a roller whose middle is at zeta (m), the pit's at ``offset`` (m)."""
    places = [2.0 * (zeta - offset) / pit.length for zeta in zetas]
    return [(1.0, *(section_of(pit, R, place) if abs(place) < 1.0 else UNTOUCHED)) for place in places]
