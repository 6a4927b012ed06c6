"""The surface of a race with a slot, and the pair of bodies that it makes with a roller.

Two ways: both bodies as half-planes, the defect only a gap in the race, whose material still holds; or the race in
finite elements, the defect cut out.
"""

from math import inf, isinf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.edges.half_space import half_plane, hats, two_half_planes
from benchmarks.edges.mesh import Block, block
from benchmarks.edges.pressed import Body
from benchmarks.edges.race import Grading, Rim, Slot, graded, rim
from benchmarks.edges.steel import Pair

if TYPE_CHECKING:
    from benchmarks.edges.finite_elements import Race

FAR = 2e-3  # m: from the rim to the sides and bottom of the block of finite elements


class Surface(NamedTuple):
    """points: (n, 2) m, from left to right; carries: indices of the nodes that may be pressed; breaks: where
    in ``carries`` the defect lies (at most one)."""

    points: np.ndarray
    carries: np.ndarray
    breaks: tuple[int, ...]


def smooth(grading: Grading, far: float = FAR) -> Surface:
    """A race without a defect, its nodes densest at t = 0."""
    half = graded(far, grading)
    t = np.append(-half[::-1], half[1:])
    return Surface(np.column_stack([t, np.zeros(len(t))]), np.flatnonzero(np.abs(t) <= grading.reach), ())


def damaged(slot: Slot, grading: Grading, far: float = FAR) -> Surface:
    """A race with a slot: from -``far`` to ``far`` (one edge) or to ``width`` + ``far`` (two)."""
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


def meshed(made: Surface) -> Block:
    """The mesh under a surface, as deep as it is far to the left."""
    return block(made.points, -float(made.points[0, 0]))


def half_planes(made: Surface, pair: Pair) -> Body:
    """Roller and race as half-planes."""
    return two_half_planes(made.points[made.carries, 0], pair.E_star, pair.D, made.breaks)


def finite_elements(made: Surface, pair: Pair) -> Body:
    """The roller as a half-plane, the race in finite elements. Needs scikit-fem."""
    return on_race(made, pair, race_of(made, pair))


def race_of(made: Surface, pair: Pair) -> "Race":
    """The race under a surface in finite elements. Needs scikit-fem."""
    from benchmarks.edges.finite_elements import race

    return race(meshed(made), made.carries, made.breaks, pair.steel, pair.D)


def on_race(made: Surface, pair: Pair, below: "Race") -> Body:
    """The roller as a half-plane on a race that is there already."""
    t = made.points[made.carries, 0]
    roller = half_plane(t, pair.E_star, pair.D, made.breaks)
    return Body(t, roller + below.compliance(), hats(t, made.breaks))
