"""The race with its pit as finite elements in plane strain, condensed to the nodes that a roller may press.

Quadratic triangles (scikit-fem). Pressure is linear between the surface's nodes and acts downwards. On the block's
far sides the displacement is Flamant's under the same force: the block goes on as a half-plane, with the datum of
``half_space.half_plane``, so that both compliances can be compared and added.
"""

from math import log, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP2, ElementVector, MeshTri
from skfem.models.elasticity import lame_parameters, linear_elasticity

from bearingsim.verify.half_space import hats
from bearingsim.verify.mesh import Block

BATCH = 64  # loads that are solved at once


class Steel(NamedTuple):
    """E: Pa; nu: 1."""

    E: float = 207e9
    nu: float = 0.3

    @property
    def E_star(self) -> float:
        """E/(2 (1 - nu^2)) (Pa), of two bodies of this material."""
        return self.E / (2.0 * (1.0 - self.nu**2))


def flamant(points: np.ndarray, place: float, steel: Steel, D: float) -> np.ndarray:
    """Displacement (2, n) (m per N/m) at ``points`` (2, n) under a line load downwards at (``place``, 0).

    Johnson 1985, eq. 2.19, with the constant that makes the surface's normal displacement ln(D/r)/(pi E*).
    theta is taken from the inward normal, u_theta in its sense.
    """
    x, y = points[0] - place, points[1]
    r, theta = np.hypot(x, y), np.arctan2(x, -y)
    E, nu = steel
    depth, twist = 2.0 * (1.0 - nu**2), (1.0 - 2.0 * nu) * (1.0 + nu)
    sink = depth * log(D) + (1.0 + nu)
    c, s = np.cos(theta), np.sin(theta)
    u_r = -depth * c * np.log(r) - twist * theta * s + sink * c
    u_theta = depth * s * np.log(r) + 2.0 * nu * (1.0 + nu) * s - twist * theta * c + twist * s - sink * s
    return np.array([u_r * s + u_theta * c, -(u_r * c - u_theta * s)]) / (pi * E)


def compliance(mesh: Block, carries: np.ndarray, breaks: tuple[int, ...], steel: Steel, D: float) -> np.ndarray:
    """(n, n) sinking (m) of the surface's nodes ``carries`` (indices) under a pressure of 1 Pa on each one's hat.

    ``breaks``: places in ``carries`` behind which no pressure acts until the next node.
    """
    basis = Basis(triangles(mesh), ElementVector(ElementTriP2()), intorder=2)
    stiffness = csc_matrix(linear_elasticity(*lame_parameters(steel.E, steel.nu)).assemble(basis))
    held = far_sides(basis, mesh)
    free = np.setdiff1d(np.arange(basis.N), held)
    solve = splu(stiffness[free][:, free]).solve
    to_held = stiffness[free][:, held]
    down = node_dofs(basis, mesh, carries)
    t = mesh.points[carries, 0]
    loads = consistent(basis, mesh, carries, breaks)
    weights, centres = hats(t, breaks), loads_centres(t, breaks)
    position = np.full(basis.N, -1)
    position[free] = np.arange(len(free))
    found = np.empty((len(t), len(t)))
    for start in range(0, len(t), BATCH):
        some = range(start, min(start + BATCH, len(t)))
        far = np.stack([weights[j] * far_motion(basis, held, centres[j], steel, D) for j in some], axis=1)
        motion = solve(loads[free][:, some].toarray() - to_held @ far)
        found[:, some] = -motion[position[down]]
    return found


def triangles(mesh: Block) -> MeshTri:
    """The mesh as scikit-fem keeps it."""
    return MeshTri(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.triangles.T, dtype=np.int64))


def far_sides(basis: Any, mesh: Block) -> np.ndarray:
    """Degrees of freedom on the block's sides and bottom."""
    left, right = mesh.points[:, 0].min(), mesh.points[:, 0].max()
    bottom, slack = mesh.points[:, 1].min(), 1e-9 * (right - left)
    facets = basis.mesh.facets_satisfying(
        lambda x: (x[0] < left + slack) | (x[0] > right - slack) | (x[1] < bottom + slack), boundaries_only=True
    )
    return np.asarray(basis.get_dofs(facets).all())


def far_motion(basis: Any, held: np.ndarray, place: float, steel: Steel, D: float) -> np.ndarray:
    """Flamant's displacement (m per N/m) at the degrees of freedom ``held``."""
    u = flamant(basis.doflocs[:, held], place, steel, D)
    return np.where(vertical(basis)[held], u[1], u[0])


def vertical(basis: Any) -> np.ndarray:
    """Which degrees of freedom are displacements along y."""
    found = np.zeros(basis.N, bool)
    found[basis.nodal_dofs[1]] = True
    found[basis.facet_dofs[1]] = True
    return found


def node_dofs(basis: Any, mesh: Block, nodes: np.ndarray) -> np.ndarray:
    """Degrees of freedom of the nodes' vertical displacement."""
    return np.asarray(basis.nodal_dofs[1][nodes])


def consistent(basis: Any, mesh: Block, carries: np.ndarray, breaks: tuple[int, ...]) -> csc_matrix:
    """(N, n) nodal forces of the hats, downwards: a linear pressure on a quadratic side of horizontal length l.

    The hat that is 1 at a side's first end gives l/6 there, l/3 at its middle and 0 at the other end.
    """
    middle = facet_of(basis)
    rows, columns, values = [], [], []
    for k in range(len(carries) - 1):
        if k in breaks:
            continue
        first, last = int(carries[k]), int(carries[k + 1])
        length = mesh.points[last, 0] - mesh.points[first, 0]
        between = basis.facet_dofs[1][middle[min(first, last), max(first, last)]]
        for column, end in ((k, first), (k + 1, last)):
            rows += [basis.nodal_dofs[1][end], between]
            columns += [column, column]
            values += [-length / 6.0, -length / 3.0]
    return csc_matrix((values, (rows, columns)), shape=(basis.N, len(carries)))


def facet_of(basis: Any) -> dict[tuple[int, int], int]:
    """Number of the facet between two vertices, the lower one first."""
    return {(int(a), int(b)): k for k, (a, b) in enumerate(np.sort(basis.mesh.facets, axis=0).T)}


def loads_centres(t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Where (m) the resultant of each hat acts."""
    steps = np.diff(t)
    steps[list(breaks)] = 0.0
    left, right = np.append(0.0, steps), np.append(steps, 0.0)
    return t + (right**2 - left**2) / (3.0 * np.maximum(left + right, 1e-300))
