"""The surface of a race with a slot in it, and nodes on it that are fine where a roller may press.

Lengths in m; t along rolling, y upwards, the race below y = 0. The defect opens at t = 0, where the rounding of
its edge (radius rho) begins, and is ``width`` wide to where the other one ends. Walls are upright, the floor flat.
"""

from math import acos, inf, sin, sqrt
from typing import NamedTuple

import numpy as np


class Slot(NamedTuple):
    """A slot of ``width`` (m, inf: one edge alone), ``depth`` (m) and edge radius ``rho`` (m; 0: sharp)."""

    width: float
    depth: float
    rho: float

    @property
    def turn(self) -> float:
        """Angle (rad) through which the edge's rounding goes on, until it is upright or meets the floor."""
        return acos(max(0.0, 1.0 - self.depth / self.rho)) if self.rho > 0.0 else 0.0


class Grading(NamedTuple):
    """finest: m, at the rim; ratio: spacing over distance from the rim; reach: m, how far nodes carry pressure."""

    finest: float = 2e-8
    ratio: float = 0.035
    reach: float = 2.5e-4


def graded(length: float, grading: Grading, coarsest: float = inf) -> np.ndarray:
    """Places 0 .. ``length`` (m) with spacing finest + ratio * place, at most ``coarsest``."""
    places = [0.0]
    while places[-1] < length:
        places.append(places[-1] + min(grading.finest + grading.ratio * places[-1], coarsest))
    return np.array(places) * (length / places[-1])


class Rim(NamedTuple):
    """One edge of a slot, the land on its left. x, y: (n,) m; carries: (n,) whether pressure may act there."""

    x: np.ndarray
    y: np.ndarray
    carries: np.ndarray


STEEPEST = 0.6  # rad: how far round the edge a roller may press on it
FINE_TURN = 0.006  # rad between nodes up to there


def rim(slot: Slot, grading: Grading, far: float) -> Rim:
    """Nodes from -``far`` to the bottom of the wall at the rim that stands at x = 0."""
    land = -graded(far, grading)[::-1]
    arc = turns(slot, grading)
    x = np.append(land, slot.rho * np.sin(arc))
    y = np.append(np.zeros(len(land)), -slot.rho * (1.0 - np.cos(arc)))
    carries = (x >= -grading.reach) & (x <= slot.rho * sin(STEEPEST))
    wall = slot.depth + y[-1]
    if wall > 1e-3 * slot.depth:
        down = graded(wall, Grading(max(grading.finest, 0.15 * slot.rho), 0.3, inf), wall / 3.0)[1:]
        x, y = np.append(x, np.full(len(down), x[-1])), np.append(y, y[-1] - down)
        carries = np.append(carries, np.zeros(len(down), bool))
    return Rim(x, y, carries)


def turns(slot: Slot, grading: Grading) -> np.ndarray:
    """Angles (rad) of the nodes on the rounding, the first one left out: fine where a roller presses."""
    if slot.rho == 0.0:
        return np.array([])
    pressed = min(STEEPEST, slot.turn)
    fine = graded(pressed, Grading(grading.finest / slot.rho, grading.ratio, inf), FINE_TURN)
    if slot.turn <= pressed:
        return fine[1:]
    beyond = pressed + graded(slot.turn - pressed, Grading(FINE_TURN, 0.3, inf), 0.15)
    return np.append(fine[1:], beyond[1:])


def depth_at(slot: Slot, t: np.ndarray) -> np.ndarray:
    """Depth (m) of the race's surface at ``t`` (m); beyond the floor's ends that of the floor."""
    inside = np.minimum(t, slot.width - t)
    on_arc = np.clip(inside, 0.0, slot.rho * sin(slot.turn))
    drop = slot.rho - np.sqrt(np.maximum(slot.rho**2 - on_arc**2, 0.0))
    past = inside > slot.rho * sin(slot.turn)
    return np.where(past, slot.depth, drop)


def envelope(slot: Slot, R: float, s: float) -> float:
    """How far (m) a rigid roller of radius ``R`` (m), its middle ``s`` (m) behind the rim, sinks.

    On the rim h = x^2/(2 (R + rho)), x the distance from the nearer rim; at most the depth.
    """
    x = max(min(s, slot.width - s), 0.0)
    return min(x * x / (2.0 * (R + slot.rho)), slot.depth)


def slope_reach(R: float, depth: float) -> float:
    """Distance (m) from a rim at which a roller touches the floor: sqrt(2 R d)."""
    return sqrt(2.0 * R * depth)
