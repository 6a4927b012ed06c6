"""Surface of a race with a slot, and the pair of bodies that it forms with a roller.

Both bodies are half-planes, where the defect is only a gap and the missing material still supports the load; or
the race consists of finite elements with the defect cut out.
"""

from math import inf, isinf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.edges.contact import Body
from benchmarks.edges.half_space import half_plane, hat_integrals, two_half_planes
from benchmarks.edges.mesh import Block, block
from benchmarks.edges.race import Grading, Rim, Slot, graded, rim
from benchmarks.edges.steel import Pair

if TYPE_CHECKING:
    from benchmarks.edges.finite_elements import Race

BLOCK_SIZE = 2e-3  # m, from the rim to the sides and the bottom of the block of finite elements


class Surface(NamedTuple):
    """Nodes of the surface of a race.

    points: (n, 2) m, from left to right; contact_nodes: indices of the nodes that may be in contact; breaks: index
    in ``contact_nodes`` of the last node before the defect (at most one).
    """

    points: np.ndarray
    contact_nodes: np.ndarray
    breaks: tuple[int, ...]


def smooth_surface(grading: Grading, extent: float = BLOCK_SIZE) -> Surface:
    """Return the surface of a race without a defect; nodes are densest at t = 0."""
    half = graded(extent, grading)
    t = np.append(-half[::-1], half[1:])
    return Surface(np.column_stack([t, np.zeros(len(t))]), np.flatnonzero(np.abs(t) <= grading.reach), ())


def slotted_surface(slot: Slot, grading: Grading, extent: float = BLOCK_SIZE) -> Surface:
    """Return the surface of a race with a slot, from -``extent`` to ``extent`` behind its last edge."""
    left = rim(slot, grading, extent)
    if isinf(slot.width):
        return single_edge_surface(slot, left, extent)
    floor = slot.width - 2.0 * left.x[-1]
    half = graded(floor / 2.0, Grading(floor_spacing(slot), 0.3, inf), floor / 6.0)
    bottom = np.append(half, floor - half[::-1][1:])[1:-1] + left.x[-1]
    x = np.concatenate([left.x, bottom, slot.width - left.x[::-1]])
    y = np.concatenate([left.y, np.full(len(bottom), left.y[-1]), left.y[::-1]])
    contact_nodes = np.flatnonzero(
        np.concatenate([left.is_contact, np.zeros(len(bottom), bool), left.is_contact[::-1]])
    )
    return Surface(np.column_stack([x, y]), contact_nodes, (int(left.is_contact.sum()) - 1,))


def single_edge_surface(slot: Slot, left: Rim, extent: float) -> Surface:
    """Return the surface of a race with one edge, whose floor extends to the side of the block."""
    floor = left.x[-1] + graded(extent - left.x[-1], Grading(floor_spacing(slot), 0.3, inf))[1:]
    x, y = np.append(left.x, floor), np.append(left.y, np.full(len(floor), left.y[-1]))
    return Surface(np.column_stack([x, y]), np.flatnonzero(left.is_contact), ())


def floor_spacing(slot: Slot) -> float:
    """Compute the length (m) of the first element of the floor."""
    return max(slot.depth, 0.1 * slot.rho) / 8.0


def mesh_below(surface: Surface) -> Block:
    """Mesh the block under a surface; it is as deep as the surface extends to the left."""
    return block(surface.points, -float(surface.points[0, 0]))


def half_planes(surface: Surface, pair: Pair) -> Body:
    """Return roller and race as half-planes."""
    return two_half_planes(surface.points[surface.contact_nodes, 0], pair.E_star, pair.D, surface.breaks)


def finite_elements(surface: Surface, pair: Pair) -> Body:
    """Return the roller as a half-plane and the race in finite elements. Requires scikit-fem."""
    return body_on_race(surface, pair, race_below(surface, pair))


def race_below(surface: Surface, pair: Pair) -> "Race":
    """Return the race under a surface in finite elements. Requires scikit-fem."""
    from benchmarks.edges.finite_elements import race

    return race(mesh_below(surface), surface.contact_nodes, surface.breaks, pair.steel, pair.D)


def body_on_race(surface: Surface, pair: Pair, race: "Race") -> Body:
    """Return the roller as a half-plane on a given race in finite elements."""
    t = surface.points[surface.contact_nodes, 0]
    roller = half_plane(t, pair.E_star, pair.D, surface.breaks)
    return Body(t, roller + race.compliance(), hat_integrals(t, surface.breaks))
