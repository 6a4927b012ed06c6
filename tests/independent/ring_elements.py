"""A free ring of rectangular section as an elastic body in plane stress: quadratic finite elements, NumPy and
SciPy.

It shares no code with the package. Quadrilaterals of eight nodes, in polar cells whose curved sides go through
the true circles, three by three Gauss points. The number of cells across the height is even, so that the
mid-line is a line of nodes, on which a line load can act.

A harmonic n has the radial displacement w = a cos n theta on the mid-line, positive outward. Its *compliance*
is a over the generalised force: a line load q cos n theta (N/m of mid-line, over the full breadth) has the
generalised force pi R_m q on a. Away from the mid-line the load is counted the same way, by its work: q pi R
for a load at R.

SI throughout.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh, splu

# corners counterclockwise from (-1, -1), then the middles of the sides in the same order: (radial, along)
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
SIDES = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]])
GAUSS = np.polynomial.legendre.leggauss(3)


class Section(NamedTuple):
    """The ring: radii and breadth in m, Young's modulus in Pa, density in kg/m3."""

    inside: float = 0.0385
    outside: float = 0.045
    breadth: float = 0.023
    young: float = 207e9
    poisson: float = 0.3
    density: float = 7850.0

    @property
    def middle(self):
        return 0.5 * (self.inside + self.outside)


NF308 = Section()


def shapes(x, y):
    """The eight shape functions at (x, y) in [-1, 1]^2, and their slopes (8, 2)."""
    p = 1 + CORNERS * [x, y]
    s = CORNERS @ [x, y] - 1
    corner = 0.25 * p[:, 0] * p[:, 1] * s
    corner_x = 0.25 * CORNERS[:, 0] * p[:, 1] * (s + p[:, 0])
    corner_y = 0.25 * CORNERS[:, 1] * p[:, 0] * (s + p[:, 1])
    across = SIDES[:, 0] == 0
    side = np.where(across, 0.5 * (1 - x * x) * (1 + SIDES[:, 1] * y), 0.5 * (1 - y * y) * (1 + SIDES[:, 0] * x))
    side_x = np.where(across, -x * (1 + SIDES[:, 1] * y), 0.5 * (1 - y * y) * SIDES[:, 0])
    side_y = np.where(across, 0.5 * (1 - x * x) * SIDES[:, 1], -y * (1 + SIDES[:, 0] * x))
    slopes = np.column_stack([np.concatenate([corner_x, side_x]), np.concatenate([corner_y, side_y])])
    return np.concatenate([corner, side]), slopes


class Mesh(NamedTuple):
    """Radius and angle of the nodes, and the eight nodes of each cell."""

    radius: np.ndarray
    angle: np.ndarray
    cells: np.ndarray


def mesh(section, across, around):
    """``across`` cells over the height, ``around`` round the ring."""
    rows, columns = 2 * across + 1, 2 * around
    is_node = np.array([[i % 2 == 0 or j % 2 == 0 for j in range(columns)] for i in range(rows)])
    number = np.where(is_node, np.cumsum(is_node).reshape(is_node.shape) - 1, -1)
    i, j = np.nonzero(is_node)
    positions = np.concatenate([CORNERS, SIDES]) + 1
    cells = [
        [number[2 * a + p, (2 * b + q) % columns] for p, q in positions]
        for a in range(across)
        for b in range(around)
    ]
    height = section.outside - section.inside
    return Mesh(section.inside + height * i / (rows - 1), 2 * np.pi * j / columns, np.array(cells))


def cell_matrices(section, points):
    """Stiffness and mass (16, 16) of a cell with the nodes ``points`` (8, 2), displacements x1 y1 x2 y2 ..."""
    plane = np.array([[1, section.poisson, 0], [section.poisson, 1, 0], [0, 0, (1 - section.poisson) / 2]])
    plane *= section.young / (1 - section.poisson**2)
    stiffness, mass = np.zeros((16, 16)), np.zeros((16, 16))
    for x, weight_x in zip(*GAUSS, strict=True):
        for y, weight_y in zip(*GAUSS, strict=True):
            n, slopes = shapes(x, y)
            jacobian = slopes.T @ points
            dx, dy = np.linalg.solve(jacobian, slopes.T)
            volume = section.breadth * np.linalg.det(jacobian) * weight_x * weight_y
            strain = np.zeros((3, 16))
            strain[0, ::2], strain[1, 1::2], strain[2, ::2], strain[2, 1::2] = dx, dy, dy, dx
            interpolation = np.zeros((2, 16))
            interpolation[0, ::2], interpolation[1, 1::2] = n, n
            stiffness += volume * strain.T @ plane @ strain
            mass += volume * section.density * interpolation.T @ interpolation
    return stiffness, mass


class Body(NamedTuple):
    section: Section
    mesh: Mesh
    stiffness: sparse.csc_matrix
    mass: sparse.csc_matrix


@lru_cache(maxsize=4)
def body(section=NF308, across=4, around=96):
    """The assembled ring. Cells at one radius are alike but for a turn: each is computed once and turned."""
    grid = mesh(section, across, around)
    rows, columns, k, m = [], [], [], []
    for index, cell in enumerate(grid.cells):
        step = index % around
        if step == 0:
            r, a = grid.radius[cell], grid.angle[cell]
            k_0, m_0 = cell_matrices(section, np.column_stack([r * np.cos(a), r * np.sin(a)]))
        turn = 2 * np.pi * step / around
        c, s = np.cos(turn), np.sin(turn)
        rotation = np.kron(np.eye(8), np.array([[c, -s], [s, c]]))
        unknowns = np.column_stack([2 * cell, 2 * cell + 1]).ravel()
        rows.append(np.repeat(unknowns, 16))
        columns.append(np.tile(unknowns, 16))
        k.append((rotation @ k_0 @ rotation.T).ravel())
        m.append((rotation @ m_0 @ rotation.T).ravel())
    indices = (np.concatenate(rows), np.concatenate(columns))
    size = 2 * grid.radius.size
    matrices = [sparse.coo_matrix((np.concatenate(v), indices), (size, size)).tocsc() for v in (k, m)]
    return Body(section, grid, *matrices)


def radial_field(ring, values, nodes):
    """A field that points outward with ``values`` on ``nodes`` and vanishes elsewhere."""
    field = np.zeros(2 * ring.mesh.radius.size)
    field[2 * nodes] = values * np.cos(ring.mesh.angle[nodes])
    field[2 * nodes + 1] = values * np.sin(ring.mesh.angle[nodes])
    return field


def circle_nodes(ring, radius):
    """Return the nodes on a circle and their arc lengths (m): Simpson's weights, for quadratic sides."""
    nodes = np.flatnonzero(np.abs(ring.mesh.radius - radius) < 1e-9)
    nodes = nodes[np.argsort(ring.mesh.angle[nodes])]
    weights = np.where(np.arange(nodes.size) % 2 == 0, 2 / 3, 4 / 3)
    return nodes, weights * 2 * np.pi * radius / nodes.size


def compliances(harmonics, section=NF308, load_at=None, across=4, around=96):
    """a_n (m) on the mid-line for a generalised force of 1 N of a load at ``load_at`` (m; the mid-line)."""
    ring = body(section, across, around)
    nodes, arcs = circle_nodes(ring, section.middle if load_at is None else load_at)
    sensor_nodes, sensor_arcs = circle_nodes(ring, section.middle)
    factorised = splu((ring.stiffness + 1e-9 * section.young / section.density * ring.mass).tocsc())
    amplitudes = []
    for n in harmonics:
        scale = 2 if n == 0 else 1
        load = radial_field(ring, arcs * np.cos(n * ring.mesh.angle[nodes]), nodes) / (scale * arcs.sum() / 2)
        probe = radial_field(ring, sensor_arcs * np.cos(n * ring.mesh.angle[sensor_nodes]), sensor_nodes) / (
            scale * sensor_arcs.sum() / 2
        )
        amplitudes.append(probe @ factorised.solve(load))
    return np.array(amplitudes)


def free_frequencies(number=8, section=NF308, across=4, around=96):
    """The lowest ``number`` free frequencies in Hz above the three rigid motions; each harmonic has two."""
    ring = body(section, across, around)
    shift = -((2 * np.pi * 500.0) ** 2)
    squares = eigsh(ring.stiffness, number + 3, ring.mass, sigma=shift, return_eigenvectors=False)
    return np.sqrt(np.sort(squares)[3:]) / (2 * np.pi)


if __name__ == "__main__":
    for cells in ((2, 64), (4, 96), (6, 144)):
        frequencies = free_frequencies(8, NF308, *cells)
        print(*cells, "f, Hz", frequencies)
        print("   mid-line, m/N", compliances(range(2, 9), NF308, None, *cells))
        print("   race,     m/N", compliances(range(2, 9), NF308, NF308.inside, *cells))
