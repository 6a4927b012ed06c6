"""A roller over a race with a slot: the bodies, as half-planes or with the race in finite elements."""

from math import inf, isinf
from typing import NamedTuple

import numpy as np

from bearingsim.verify.half_space import half_plane, hats, two_half_planes
from bearingsim.verify.mesh import Block, block
from bearingsim.verify.pressed import Body
from bearingsim.verify.race import Grading, Rim, Slot, graded, rim

FAR = 2e-3  # m: half the width, and depth, of the block of finite elements


class Surface(NamedTuple):
    """points: (n, 2) m, from left to right; carries: indices of the nodes that may be pressed; breaks: where
    in ``carries`` the pit lies (at most one)."""

    points: np.ndarray
    carries: np.ndarray
    breaks: tuple[int, ...]


def surface(slot: Slot, grading: Grading, far: float = FAR) -> Surface:
    """The race's surface with the slot: from -``far`` to ``far`` (one edge) or ``width`` + ``far`` (two)."""
    left = rim(slot, grading, far)
    if isinf(slot.width):
        return one_edge(slot, left, far)
    floor = slot.width - 2.0 * left.x[-1]
    half = graded(floor / 2.0, Grading(floor_spacing(slot), 0.3, inf), floor / 6.0)
    bottom = np.append(half, floor - half[::-1][1:])[1:-1] + left.x[-1]
    x = np.concatenate([left.x, bottom, slot.width - left.x[::-1]])
    y = np.concatenate([left.y, np.full(len(bottom), left.y[-1]), left.y[::-1]])
    carries = np.flatnonzero(np.concatenate([left.carries, np.zeros(len(bottom), bool), left.carries[::-1]]))
    return Surface(np.column_stack([x, y]), carries, (int(left.carries.sum()) - 1,))


def one_edge(slot: Slot, left: Rim, far: float) -> Surface:
    """The surface with a floor that runs on to the block's side."""
    floor = left.x[-1] + graded(far - left.x[-1], Grading(floor_spacing(slot), 0.3, inf))[1:]
    x, y = np.append(left.x, floor), np.append(left.y, np.full(len(floor), left.y[-1]))
    return Surface(np.column_stack([x, y]), np.flatnonzero(left.carries), ())


def floor_spacing(slot: Slot) -> float:
    """Length (m) of the floor's first element."""
    return max(slot.depth, 0.1 * slot.rho) / 8.0


def race_block(made: Surface, far: float = FAR) -> Block:
    """The mesh under a surface."""
    return block(made.points, far)


def as_half_planes(made: Surface, E_star: float, D: float) -> Body:
    """The roller and the race as half-planes: the pit is a gap, the material in it still holds."""
    return two_half_planes(made.points[made.carries, 0], E_star, D, made.breaks)


def as_finite_elements(made: Surface, mesh: Block, steel: "Steel", D: float) -> Body:
    """The roller as a half-plane, the race in finite elements with the pit cut out. Needs scikit-fem."""
    from bearingsim.verify.finite_elements import compliance

    t = made.points[made.carries, 0]
    roller = half_plane(t, steel.E_star, D, made.breaks)
    race = compliance(mesh, made.carries, made.breaks, steel, D)
    return Body(t, roller + race, hats(t, made.breaks))
