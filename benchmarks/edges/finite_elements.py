"""The race with its defect as finite elements in plane strain, condensed to the nodes that a roller may press.

Quadratic triangles (scikit-fem). Pressure is linear between the surface's nodes and acts downwards. On the block's
far sides the displacement is Flamant's under the same force: the block goes on as a half-plane, with the datum of
``half_space.half_plane``, so that both compliances can be compared and added.
"""

from collections.abc import Callable
from math import log, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP2, ElementVector, MeshTri
from skfem.models.elasticity import lame_parameters, linear_elasticity

from benchmarks.edges.half_space import carrying, hats
from benchmarks.edges.mesh import Block
from benchmarks.edges.steel import Steel

BATCH = 64  # loads that are solved at once


def flamant(points: np.ndarray, place: float, steel: Steel, D: float) -> np.ndarray:
    """Displacement (2, n) (m per N/m) at ``points`` (2, n) under a line load downwards at (``place``, 0).

    Johnson 1985, section 2.2, with the constant that makes the surface sink by ln(D/r)/(pi E*),
    E* = E/(2 (1 - nu^2)). theta is taken from the inward normal, u_theta in its sense.
    """
    x, y = points[0] - place, points[1]
    r, theta = np.hypot(x, y), np.arctan2(x, -y)
    E, nu = steel
    depth, twist = 2.0 * (1.0 - nu**2), (1.0 - 2.0 * nu) * (1.0 + nu)
    sink = depth * log(D) + (1.0 + nu)
    c, s = np.cos(theta), np.sin(theta)
    u_r = -depth * c * np.log(r) - twist * theta * s + sink * c
    u_theta = depth * s * np.log(r) + 2.0 * nu * (1.0 + nu) * s - twist * theta * c + twist * s - sink * s
    return np.array([u_r * s + u_theta * c, u_theta * s - u_r * c]) / (pi * E)


class Race(NamedTuple):
    """A block of the race, factorised.

    basis: scikit-fem's; loads: (N, n) nodal forces of the n hats under 1 Pa; far: (held, n) motion (m) of the far
    sides under them; down: (n,) degrees of freedom of the pressed nodes' vertical motion; solve: for the free.
    """

    steel: Steel
    basis: Any
    loads: csc_matrix
    far: np.ndarray
    held: np.ndarray
    free: np.ndarray
    to_held: csc_matrix
    down: np.ndarray
    solve: Callable[[np.ndarray], np.ndarray]

    def motion(self, pressures: np.ndarray) -> np.ndarray:
        """(N, k) displacements (m) under ``pressures`` (n, k) (Pa) at the pressed nodes."""
        found = np.empty((self.basis.N, pressures.shape[1]))
        found[self.held] = self.far @ pressures
        found[self.free] = self.solve((self.loads @ pressures)[self.free] - self.to_held @ found[self.held])
        return found

    def compliance(self) -> np.ndarray:
        """(n, n) sinking (m) of the pressed nodes under 1 Pa on each one's hat."""
        n = len(self.down)
        parts = np.array_split(np.eye(n), max(1, -(-n // BATCH)), axis=1)
        return np.hstack([-self.motion(part)[self.down] for part in parts])

    def largest_mises(self, pressure: np.ndarray) -> float:
        """Largest von Mises stress (Pa) in the block under ``pressure`` (n,) (Pa)."""
        mu = lame_parameters(*self.steel)[1]
        field = self.basis.interpolate(self.motion(pressure[:, None])[:, 0])
        (a, c), (d, b) = field.grad
        shear, mean = 0.5 * (c + d), (a + b) / 3.0
        squares = (a - mean) ** 2 + (b - mean) ** 2 + mean**2 + 2.0 * shear**2
        return float((2.0 * mu * np.sqrt(1.5 * squares)).max())


def race(mesh: Block, carries: np.ndarray, breaks: tuple[int, ...], steel: Steel, D: float) -> Race:
    """The race whose surface nodes ``carries`` (indices) may be pressed.

    ``breaks``: places in ``carries`` behind which no pressure acts until the next node; D: datum (m).
    """
    basis = Basis(triangles(mesh), ElementVector(ElementTriP2()), intorder=2)
    stiffness = csc_matrix(linear_elasticity(*lame_parameters(*steel)).assemble(basis))
    held = far_sides(basis, mesh)
    free = np.setdiff1d(np.arange(basis.N), held)
    t = mesh.points[carries, 0]
    return Race(
        steel=steel,
        basis=basis,
        loads=consistent(basis, mesh, carries, breaks),
        far=far_motion(basis, held, t, breaks, steel, D),
        held=held,
        free=free,
        to_held=stiffness[free][:, held],
        down=np.asarray(basis.nodal_dofs[1][carries]),
        solve=splu(stiffness[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve,
    )


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


def far_motion(
    basis: Any, held: np.ndarray, t: np.ndarray, breaks: tuple[int, ...], steel: Steel, D: float
) -> np.ndarray:
    """(held, n) Flamant's displacement (m) of the far sides under 1 Pa on each hat, taken as a line load."""
    vertical = np.isin(held, np.concatenate([basis.nodal_dofs[1], basis.facet_dofs[1]]))
    found = np.empty((len(held), len(t)))
    for j, (weight, centre) in enumerate(zip(hats(t, breaks), centres(t, breaks), strict=True)):
        u = flamant(basis.doflocs[:, held], centre, steel, D)
        found[:, j] = weight * np.where(vertical, u[1], u[0])
    return found


def centres(t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Where (m) the resultant of each hat acts."""
    steps = carrying(t, breaks)
    left, right = np.append(0.0, steps), np.append(steps, 0.0)
    return t + (right**2 - left**2) / (3.0 * (left + right))


def consistent(basis: Any, mesh: Block, carries: np.ndarray, breaks: tuple[int, ...]) -> csc_matrix:
    """(N, n) nodal forces (N/m) of the hats under 1 Pa: a linear pressure on quadratic sides.

    The hat that is 1 at a side's end gives l/6 there, l/3 at its middle and 0 at the other end; l is the side's
    horizontal length, since the pressure acts downwards.
    """
    middle = {(int(a), int(b)): k for k, (a, b) in enumerate(np.sort(basis.mesh.facets, axis=0).T)}
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
