"""A triangle mesh of a block under a given surface, fine where the surface's nodes are close together.

Points: the surface's nodes, and the corners of a quadtree whose cells are as small as the surface's spacing asks
at their distance from it; then Delaunay, less the triangles above the surface, and a few rounds of smoothing.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay, cKDTree

GROWTH = 0.3  # of the wanted spacing with the distance from the surface
CLEAR = 0.6  # spacings that a free point keeps from the surface
SMOOTHED = 6  # rounds of Laplace's smoothing


class Block(NamedTuple):
    """points: (n, 2) m, the surface's nodes first; triangles: (m, 3); surface: number of nodes on the surface."""

    points: np.ndarray
    triangles: np.ndarray
    surface: int


def block(surface: np.ndarray, size: float) -> Block:
    """The block below ``surface`` ((n, 2) m, from left to right); its sides and bottom lie ``size`` (m) from 0.

    The surface's first and last points must lie on the block's sides.
    """
    spacing = spacings(surface)
    wanted = Wanted(cKDTree(surface), spacing)
    left, right = surface[0, 0], surface[-1, 0]
    outline = np.vstack([surface, skirt(surface, left, right, -size, wanted)])
    free = quadtree(left, right, -size, float(surface[:, 1].max()), wanted)
    free = free[inside(outline, free) & clear_of(outline, free)]
    points = np.vstack([outline, free])
    for _ in range(SMOOTHED):
        triangles = triangulate(points, outline)
        points = smoothed(points, triangles, len(outline))
    return Block(points, triangulate(points, outline), len(surface))


class Wanted(NamedTuple):
    """The spacing wanted anywhere: that of the surface nearby, growing with the distance."""

    tree: cKDTree
    spacing: np.ndarray

    def at(self, points: np.ndarray) -> np.ndarray:
        """Spacing (m) at ``points`` (n, 2)."""
        distance, near = self.tree.query(points, k=12)
        return (self.spacing[near] + GROWTH * distance).min(axis=1)


def spacings(line: np.ndarray) -> np.ndarray:
    """Mean length (m) of the two elements at each node of ``line`` (n, 2)."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    return 0.5 * (np.append(steps, steps[-1]) + np.append(steps[0], steps))


def skirt(surface: np.ndarray, left: float, right: float, bottom: float, wanted: Wanted) -> np.ndarray:
    """Points down the right side, along the bottom and up the left side, ends of the surface left out."""
    down = side(np.array([right, surface[-1, 1]]), np.array([right, bottom]), wanted)
    back = side(np.array([right, bottom]), np.array([left, bottom]), wanted)
    up = side(np.array([left, bottom]), surface[0], wanted)
    return np.vstack([down[1:], back[1:], up[1:-1]])


def side(start: np.ndarray, end: np.ndarray, wanted: Wanted) -> np.ndarray:
    """Points from ``start`` to ``end`` as close as is wanted."""
    length = float(np.hypot(*(end - start)))
    places = [0.0]
    while places[-1] < length:
        places.append(places[-1] + float(wanted.at((start + (end - start) * places[-1] / length)[None])[0]))
    return start + np.outer(np.array(places) / places[-1], end - start)


def quadtree(left: float, right: float, bottom: float, top: float, wanted: Wanted) -> np.ndarray:
    """Middles of the cells of a quadtree that is cut until no cell is wider than wanted."""
    width = max(right - left, top - bottom)
    cells, found = np.array([[left + width / 2.0, top - width / 2.0]]), []
    while len(cells):
        small = width <= wanted.at(cells)
        found.append(cells[small])
        quarter = width / 4.0 * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        cells = (cells[~small][:, None, :] + quarter).reshape(-1, 2)
        cells = cells[(cells[:, 0] < right) & (cells[:, 1] > bottom)]
        width /= 2.0
    return np.vstack(found)


def inside(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which ``points`` lie within the closed ``outline``: an odd number of its sides pass above."""
    order = np.argsort(points[:, 0])
    x, y = points[order].T
    odd = np.zeros(len(points), bool)
    reached = np.searchsorted(x, outline[:, 0])  # by each corner: how many points lie left of it
    for k, (x_2, y_2) in enumerate(outline):
        x_1, y_1 = outline[k - 1]
        across = slice(*sorted((reached[k - 1], reached[k])))
        if x_1 != x_2:
            odd[across] ^= y_1 + (y_2 - y_1) * (x[across] - x_1) / (x_2 - x_1) > y[across]
    found = np.empty(len(points), bool)
    found[order] = odd
    return found


def clear_of(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which ``points`` keep their distance from the outline's nodes, in their spacing."""
    distance, near = cKDTree(outline).query(points)
    return distance > CLEAR * spacings(np.vstack([outline, outline[:1]]))[near]


def triangulate(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Delaunay's triangles whose middles lie within the outline."""
    triangles = Delaunay(points).simplices
    return triangles[inside(outline, points[triangles].mean(axis=1))]


def smoothed(points: np.ndarray, triangles: np.ndarray, fixed: int) -> np.ndarray:
    """Points with each free one in the middle of its neighbours."""
    ends = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = np.vstack([ends, ends[:, ::-1]])
    total = np.zeros_like(points)
    np.add.at(total, ends[:, 0], points[ends[:, 1]])
    count = np.bincount(ends[:, 0], minlength=len(points))
    moved = points.copy()
    moved[fixed:] = (total / np.maximum(count, 1)[:, None])[fixed:]
    return moved


def quality(mesh: Block) -> np.ndarray:
    """4 sqrt(3) area over the sum of the squared sides of each triangle: 1 if equilateral, 0 if flat."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    sides = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return 2.0 * np.sqrt(3.0) * np.abs(ux * vy - uy * vx) / sides
