"""Surface of a race with a slot, with nodes refined where a roller may be in contact.

Lengths in m; t along rolling, y upwards, the race below y = 0. The defect begins at t = 0, where the rounding of
its edge (radius rho) begins, and ends at ``width``, where the rounding of the other edge ends. Walls are vertical,
the floor is flat.
"""

from math import acos, inf, sin, sqrt
from typing import NamedTuple

import numpy as np


class Slot(NamedTuple):
    """Slot of ``width`` (m; inf: one edge only), ``depth`` (m) and edge radius ``rho`` (m; 0: sharp)."""

    width: float
    depth: float
    rho: float

    @property
    def arc_angle(self) -> float:
        """Angle (rad) of the rounding, up to the vertical wall or the floor."""
        return acos(max(0.0, 1.0 - self.depth / self.rho)) if self.rho > 0.0 else 0.0


class Grading(NamedTuple):
    """Node spacing. finest: m, at the rim; ratio: spacing over distance; reach: range (m) of contact nodes."""

    finest: float = 2e-8
    ratio: float = 0.035
    reach: float = 2.5e-4


def graded(length: float, grading: Grading, coarsest: float = inf) -> np.ndarray:
    """Return positions 0 .. ``length`` (m) with spacing finest + ratio * position, at most ``coarsest``."""
    distances = [0.0]
    while distances[-1] < length:
        distances.append(distances[-1] + min(grading.finest + grading.ratio * distances[-1], coarsest))
    return np.array(distances) * (length / distances[-1])


class Rim(NamedTuple):
    """Edge of a slot, with the race on its left. x, y: (n,) m; is_contact: (n,) nodes that may be in contact."""

    x: np.ndarray
    y: np.ndarray
    is_contact: np.ndarray


MAX_CONTACT_ANGLE = 0.6  # rad, largest angle on the rounding with contact nodes
ARC_STEP = 0.006  # rad, largest angle between nodes up to there


def rim(slot: Slot, grading: Grading, extent: float) -> Rim:
    """Return nodes from -``extent`` to the bottom of the wall, for a rim at x = 0."""
    land = -graded(extent, grading)[::-1]
    arc = arc_nodes(slot, grading)
    x = np.append(land, slot.rho * np.sin(arc))
    y = np.append(np.zeros(len(land)), -slot.rho * (1.0 - np.cos(arc)))
    is_contact = (x >= -grading.reach) & (x <= slot.rho * sin(MAX_CONTACT_ANGLE))
    wall_height = slot.depth + y[-1]
    if wall_height > 1e-3 * slot.depth:
        wall_nodes = graded(
            wall_height, Grading(max(grading.finest, 0.15 * slot.rho), 0.3, inf), wall_height / 3.0
        )[1:]
        x, y = np.append(x, np.full(len(wall_nodes), x[-1])), np.append(y, y[-1] - wall_nodes)
        is_contact = np.append(is_contact, np.zeros(len(wall_nodes), bool))
    return Rim(x, y, is_contact)


def arc_nodes(slot: Slot, grading: Grading) -> np.ndarray:
    """Return the angles (rad) of the nodes on the rounding, without the first one, refined in the contact area."""
    if slot.rho == 0.0:
        return np.array([])
    contact_angle = min(MAX_CONTACT_ANGLE, slot.arc_angle)
    fine = graded(contact_angle, Grading(grading.finest / slot.rho, grading.ratio, inf), ARC_STEP)
    if slot.arc_angle <= contact_angle:
        return fine[1:]
    steep = contact_angle + graded(slot.arc_angle - contact_angle, Grading(ARC_STEP, 0.3, inf), 0.15)
    return np.append(fine[1:], steep[1:])


def depth_at(slot: Slot, t: np.ndarray) -> np.ndarray:
    """Compute the depth (m) of the surface of the race at ``t`` (m); that of the floor beyond its ends."""
    distance = np.minimum(t, slot.width - t)
    arc_distance = np.clip(distance, 0.0, slot.rho * sin(slot.arc_angle))
    rounding_depth = slot.rho - np.sqrt(np.maximum(slot.rho**2 - arc_distance**2, 0.0))
    is_floor = distance > slot.rho * sin(slot.arc_angle)
    return np.where(is_floor, slot.depth, rounding_depth)


def envelope(slot: Slot, R: float, s: float) -> float:
    """Compute the drop (m) of a rigid roller of radius ``R`` (m) with its centre ``s`` (m) behind the rim.

    On the rim h = x^2/(2 (R + rho)), where x is the distance from the nearer rim; at most the depth.
    """
    x = max(min(s, slot.width - s), 0.0)
    return min(x * x / (2.0 * (R + slot.rho)), slot.depth)


def slope_reach(R: float, depth: float) -> float:
    """Compute the distance (m) from a rim at which a roller touches the floor: sqrt(2 R d)."""
    return sqrt(2.0 * R * depth)
