"""Triangle mesh of a block under a given surface, refined where the surface nodes are close together.

The points are the surface nodes, and centres of quadtree cells, whose size follows the spacing of the surface and
the distance from it. They are connected by a Delaunay triangulation without the triangles above the surface, and
smoothed a few times.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay, cKDTree

GROWTH = 0.3  # increase of the spacing per distance from the surface
CLEARANCE = 0.6  # minimum distance of a free point from the surface, in spacings
SMOOTHING_ROUNDS = 6  # of Laplacian smoothing


class Block(NamedTuple):
    """Mesh. points: (n, 2) m, surface nodes first; triangles: (m, 3); surface: number of surface nodes."""

    points: np.ndarray
    triangles: np.ndarray
    surface: int


def block(surface: np.ndarray, size: float) -> Block:
    """Mesh the block below ``surface`` ((n, 2) m, from left to right); sides and bottom are ``size`` (m) from 0.

    The first and last points of the surface must be on the sides of the block.
    """
    spacing = spacings(surface)
    field = SpacingField(cKDTree(surface), spacing)
    left, right = surface[0, 0], surface[-1, 0]
    outline = np.vstack([surface, sides_and_bottom(surface, left, right, -size, field)])
    free = quadtree(left, right, -size, float(surface[:, 1].max()), field)
    free = free[is_inside(outline, free) & is_clear_of(outline, free)]
    points = np.vstack([outline, free])
    for _ in range(SMOOTHING_ROUNDS):
        triangles = triangulate(points, outline)
        points = smooth(points, triangles, len(outline))
    return Block(points, triangulate(points, outline), len(surface))


class SpacingField(NamedTuple):
    """Required spacing of points: that of the nearby surface, increasing with distance."""

    tree: cKDTree
    spacing: np.ndarray

    def spacing_at(self, points: np.ndarray) -> np.ndarray:
        """Compute the spacing (m) at ``points`` (n, 2)."""
        distance, near = self.tree.query(points, k=12)
        return (self.spacing[near] + GROWTH * distance).min(axis=1)


def spacings(line: np.ndarray) -> np.ndarray:
    """Compute the mean length (m) of the two elements at each node of ``line`` (n, 2)."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    return 0.5 * (np.append(steps, steps[-1]) + np.append(steps[0], steps))


def sides_and_bottom(
    surface: np.ndarray, left: float, right: float, bottom: float, field: SpacingField
) -> np.ndarray:
    """Return points down the right side, along the bottom and up the left side, without the surface's ends."""
    down = side(np.array([right, surface[-1, 1]]), np.array([right, bottom]), field)
    back = side(np.array([right, bottom]), np.array([left, bottom]), field)
    up = side(np.array([left, bottom]), surface[0], field)
    return np.vstack([down[1:], back[1:], up[1:-1]])


def side(start: np.ndarray, end: np.ndarray, field: SpacingField) -> np.ndarray:
    """Return points from ``start`` to ``end`` with the required spacing."""
    length = float(np.hypot(*(end - start)))
    distances = [0.0]
    while distances[-1] < length:
        distances.append(
            distances[-1] + float(field.spacing_at((start + (end - start) * distances[-1] / length)[None])[0])
        )
    return start + np.outer(np.array(distances) / distances[-1], end - start)


def quadtree(left: float, right: float, bottom: float, top: float, field: SpacingField) -> np.ndarray:
    """Return the centres of quadtree cells, refined until no cell is wider than the required spacing."""
    width = max(right - left, top - bottom)
    cells, centres = np.array([[left + width / 2.0, top - width / 2.0]]), []
    while len(cells):
        is_small = width <= field.spacing_at(cells)
        centres.append(cells[is_small])
        quarter = width / 4.0 * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        cells = (cells[~is_small][:, None, :] + quarter).reshape(-1, 2)
        cells = cells[(cells[:, 0] < right) & (cells[:, 1] > bottom)]
        width /= 2.0
    return np.vstack(centres)


def is_inside(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Check which ``points`` are within the closed ``outline``: those with an odd number of sides above."""
    order = np.argsort(points[:, 0])
    x, y = points[order].T
    parity = np.zeros(len(points), bool)
    left_counts = np.searchsorted(x, outline[:, 0])  # number of points left of each corner
    for k, (x_2, y_2) in enumerate(outline):
        x_1, y_1 = outline[k - 1]
        columns = slice(*sorted((left_counts[k - 1], left_counts[k])))
        if x_1 != x_2:
            parity[columns] ^= y_1 + (y_2 - y_1) * (x[columns] - x_1) / (x_2 - x_1) > y[columns]
    result = np.empty(len(points), bool)
    result[order] = parity
    return result


def is_clear_of(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Check which ``points`` keep the minimum distance from the nodes of the outline."""
    distance, near = cKDTree(outline).query(points)
    return distance > CLEARANCE * spacings(np.vstack([outline, outline[:1]]))[near]


def triangulate(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Return the Delaunay triangles with centres within the outline."""
    triangles = Delaunay(points).simplices
    return triangles[is_inside(outline, points[triangles].mean(axis=1))]


def smooth(points: np.ndarray, triangles: np.ndarray, fixed: int) -> np.ndarray:
    """Move each free point to the mean of its neighbours."""
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.vstack([edges, edges[:, ::-1]])
    total = np.zeros_like(points)
    np.add.at(total, edges[:, 0], points[edges[:, 1]])
    count = np.bincount(edges[:, 0], minlength=len(points))
    moved = points.copy()
    moved[fixed:] = (total / np.maximum(count, 1)[:, None])[fixed:]
    return moved


def quality(mesh: Block) -> np.ndarray:
    """Compute 4 sqrt(3) area over the sum of squared sides of each triangle (1: equilateral, 0: degenerate)."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    sides = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return 2.0 * np.sqrt(3.0) * np.abs(ux * vy - uy * vx) / sides
