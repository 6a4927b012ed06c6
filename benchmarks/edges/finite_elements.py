"""Race with a defect in finite elements (plane strain), condensed to the nodes that may be in contact.

Quadratic triangles (scikit-fem). The pressure is linear between surface nodes and acts downwards. The displacement
of the far sides of the block is that of Flamant under the same force, as if the block continued as a half-plane,
with the datum of ``half_space.half_plane``, so that both compliances can be compared and added.
"""

from collections.abc import Callable
from math import log, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP2, ElementVector, MeshTri
from skfem.models.elasticity import lame_parameters, linear_elasticity

from benchmarks.edges.half_space import element_lengths, hat_integrals
from benchmarks.edges.mesh import Block
from benchmarks.edges.steel import Steel

BATCH = 64  # number of load cases solved at once


def flamant(points: np.ndarray, position: float, steel: Steel, D: float) -> np.ndarray:
    """Compute the displacement (2, n) (m per N/m) at ``points`` (2, n) for a downward line load at ``position``.

    Johnson 1985, section 2.2, with the constant for which the surface sinks by ln(D/r)/(pi E*), E* = E/(2 (1 -
    nu^2)). theta is measured from the inward normal; u_theta is positive in its direction.
    """
    x, y = points[0] - position, points[1]
    r, theta = np.hypot(x, y), np.arctan2(x, -y)
    E, nu = steel
    radial, twist = 2.0 * (1.0 - nu**2), (1.0 - 2.0 * nu) * (1.0 + nu)
    constant = radial * log(D) + (1.0 + nu)
    c, s = np.cos(theta), np.sin(theta)
    u_r = -radial * c * np.log(r) - twist * theta * s + constant * c
    u_theta = radial * s * np.log(r) + 2.0 * nu * (1.0 + nu) * s - twist * theta * c + twist * s - constant * s
    return np.array([u_r * s + u_theta * c, u_theta * s - u_r * c]) / (pi * E)


class Race(NamedTuple):
    """Factorised stiffness of a block of the race.

    basis: of scikit-fem; loads: (N, n) nodal forces of the n hat functions at 1 Pa; side_displacement: (fixed, n)
    displacement (m) of the far sides at the same pressures; coupling: stiffness between free and fixed degrees of
    freedom; vertical: (n,) degrees of freedom of the vertical displacement of the contact nodes; solve: solver for
    the free degrees of freedom.
    """

    steel: Steel
    basis: Any
    loads: csc_matrix
    side_displacement: np.ndarray
    fixed: np.ndarray
    free: np.ndarray
    coupling: csc_matrix
    vertical: np.ndarray
    solve: Callable[[np.ndarray], np.ndarray]

    def displacement(self, pressures: np.ndarray) -> np.ndarray:
        """Compute the displacements (N, k) (m) under ``pressures`` (n, k) (Pa) at the contact nodes."""
        displacement = np.empty((self.basis.N, pressures.shape[1]))
        displacement[self.fixed] = self.side_displacement @ pressures
        displacement[self.free] = self.solve(
            (self.loads @ pressures)[self.free] - self.coupling @ displacement[self.fixed]
        )
        return displacement

    def compliance(self) -> np.ndarray:
        """Compute the displacements (n, n) (m) of the contact nodes into the race at 1 Pa on each hat function."""
        n = len(self.vertical)
        parts = np.array_split(np.eye(n), max(1, -(-n // BATCH)), axis=1)
        return np.hstack([-self.displacement(part)[self.vertical] for part in parts])

    def largest_mises(self, pressure: np.ndarray) -> float:
        """Compute the largest von Mises stress (Pa) in the block under ``pressure`` (n,) (Pa)."""
        mu = lame_parameters(*self.steel)[1]
        field = self.basis.interpolate(self.displacement(pressure[:, None])[:, 0])
        (a, c), (d, b) = field.grad
        shear, mean = 0.5 * (c + d), (a + b) / 3.0
        squares = (a - mean) ** 2 + (b - mean) ** 2 + mean**2 + 2.0 * shear**2
        return float((2.0 * mu * np.sqrt(1.5 * squares)).max())


def race(mesh: Block, contact_nodes: np.ndarray, breaks: tuple[int, ...], steel: Steel, D: float) -> Race:
    """Assemble and factorise a race whose surface nodes ``contact_nodes`` (indices) may be in contact.

    ``breaks``: indices in ``contact_nodes`` after which the pressure is zero up to the next node; D: datum (m).
    """
    basis = Basis(triangles(mesh), ElementVector(ElementTriP2()), intorder=2)
    stiffness = csc_matrix(linear_elasticity(*lame_parameters(*steel)).assemble(basis))
    fixed = far_sides(basis, mesh)
    free = np.setdiff1d(np.arange(basis.N), fixed)
    t = mesh.points[contact_nodes, 0]
    return Race(
        steel=steel,
        basis=basis,
        loads=nodal_loads(basis, mesh, contact_nodes, breaks),
        side_displacement=far_motion(basis, fixed, t, breaks, steel, D),
        fixed=fixed,
        free=free,
        coupling=stiffness[free][:, fixed],
        vertical=np.asarray(basis.nodal_dofs[1][contact_nodes]),
        solve=splu(stiffness[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve,
    )


def triangles(mesh: Block) -> MeshTri:
    """Convert a mesh to scikit-fem."""
    return MeshTri(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.triangles.T, dtype=np.int64))


def far_sides(basis: Any, mesh: Block) -> np.ndarray:
    """Return the degrees of freedom on the sides and the bottom of the block."""
    left, right = mesh.points[:, 0].min(), mesh.points[:, 0].max()
    bottom, slack = mesh.points[:, 1].min(), 1e-9 * (right - left)
    facets = basis.mesh.facets_satisfying(
        lambda x: (x[0] < left + slack) | (x[0] > right - slack) | (x[1] < bottom + slack), boundaries_only=True
    )
    return np.asarray(basis.get_dofs(facets).all())


def far_motion(
    basis: Any, fixed: np.ndarray, t: np.ndarray, breaks: tuple[int, ...], steel: Steel, D: float
) -> np.ndarray:
    """Compute Flamant's displacement (fixed, n) (m) of the far sides at 1 Pa on each hat, as line loads."""
    vertical = np.isin(fixed, np.concatenate([basis.nodal_dofs[1], basis.facet_dofs[1]]))
    displacement = np.empty((len(fixed), len(t)))
    for j, (weight, centre) in enumerate(zip(hat_integrals(t, breaks), centres(t, breaks), strict=True)):
        u = flamant(basis.doflocs[:, fixed], centre, steel, D)
        displacement[:, j] = weight * np.where(vertical, u[1], u[0])
    return displacement


def centres(t: np.ndarray, breaks: tuple[int, ...]) -> np.ndarray:
    """Compute the position (m) of the resultant of each hat function."""
    lengths = element_lengths(t, breaks)
    left, right = np.append(0.0, lengths), np.append(lengths, 0.0)
    return t + (right**2 - left**2) / (3.0 * (left + right))


def nodal_loads(basis: Any, mesh: Block, contact_nodes: np.ndarray, breaks: tuple[int, ...]) -> csc_matrix:
    """Compute the nodal forces (N, n) (N/m) of the hat functions at 1 Pa.

    The pressure is linear, the sides are quadratic. The hat function of one end of a side gives l/6 at this end,
    l/3 at the middle and 0 at the other end, where l is the horizontal length of the side, since the pressure acts
    downwards.
    """
    midside = {(int(a), int(b)): k for k, (a, b) in enumerate(np.sort(basis.mesh.facets, axis=0).T)}
    rows, columns, values = [], [], []
    for k in range(len(contact_nodes) - 1):
        if k in breaks:
            continue
        first, last = int(contact_nodes[k]), int(contact_nodes[k + 1])
        length = mesh.points[last, 0] - mesh.points[first, 0]
        midside_dof = basis.facet_dofs[1][midside[min(first, last), max(first, last)]]
        for column, end in ((k, first), (k + 1, last)):
            rows += [basis.nodal_dofs[1][end], midside_dof]
            columns += [column, column]
            values += [-length / 6.0, -length / 3.0]
    return csc_matrix((values, (rows, columns)), shape=(basis.N, len(contact_nodes)))
