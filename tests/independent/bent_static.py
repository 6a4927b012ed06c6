"""Equilibrium of a bearing with a flexible outer ring at each cage angle, by minimum energy.

It shares no code with the package. NF308, 1800 rpm, 150 N, clearance 0, one box over the whole roller on the
outer race. The radial motion of the ring at the angle phi, outward, is

    s(phi).x,   s = (cos phi, sin phi, 1, cos 2 phi, sin 2 phi, ..., cos N phi, sin N phi)

so that x = (u_x, u_y, a_0, a_2, b_2, ...): two of rigid motion, the others of bending. Roller j is q_j outward of
the pitch circle; its approaches are q_j - s(theta_j).x - h_j to the outer race, -q_j to the inner. The energy is
minimal (it is convex except for the last term, a millionth of the contacts'):

    E = x.K x/2 + k_b |held - anchor|^2/2 + sum_j [V(outer) + V(inner)] + energy of the loads on the ring
        - sum_j m_r omega_c^2 (d_m/2 + q_j)^2/2

The last term is the centrifugal force. K has the stiffness of the harmonics
(tests/independent/beam_ring.py), zero for u. The ring is loaded by

- `Forces`: given forces, inward, at given angles: F s(phi).x each. One angle is a point load, two or
  more are soft pads of constant force. `soft_pads` makes them equal with the resultant -load e_0.
- `Springs`: compression-only springs between the ring's outside and a rigid carrier at U, on which the
  load acts: load U_x + sum k c^2/2, c = max(0, s(phi).x - U.e(phi) + fit). They are at some points, or
  discretise the whole seat.

The bracket (1e7 N/m, or 0) acts on the carrier, or on u without one. Its anchor is the mean position of that body
over a ball pass of the healthy bearing without a bracket, so that its mean force is zero.

SI throughout; angles in radians from the load line.
"""

from typing import Any, NamedTuple

import numpy as np

from tests.independent import beam_ring, rollers

R_MEAN = rollers.R_O - rollers.R_W
CENTRIFUGAL = rollers.M_R * rollers.OMEGA_C**2
PASS = 2 * np.pi / rollers.Z


def harmonics(last):
    """0, 2, 3 ... ``last``, or none at all for ``last`` 0: a ring that does not bend."""
    return (0, *range(2, last + 1)) if last else ()


def shape_functions(orders, angles):
    """s at each angle, (angles, 2 + unknowns of ``orders``)."""
    angles = np.atleast_1d(np.asarray(angles, float))
    columns = [np.cos(angles), np.sin(angles)]
    for n in orders:
        columns += [np.ones_like(angles)] if n == 0 else [np.cos(n * angles), np.sin(n * angles)]
    return np.stack(columns, axis=1)


def per_unknown(orders, numbers):
    """A number of each harmonic for each of its unknowns: cosine and sine have the same."""
    return np.array([value for n, value in zip(orders, numbers, strict=True) for _ in range(1 if n == 0 else 2)])


class Forces(NamedTuple):
    """Inward forces (N) at ``angles``; ``evenly``: their n = 1 alone, a pressure as cos phi."""

    angles: tuple
    forces: tuple
    evenly: bool = False

    def vector(self, orders):
        forces = -np.array(self.forces) @ shape_functions(orders, self.angles)
        if self.evenly:
            forces[2:] = 0.0
        return forces


class Springs(NamedTuple):
    """Springs of ``stiffness`` (N/m each) at ``angles``, pressed by ``fit`` (m) when nothing has moved."""

    angles: tuple
    stiffness: float
    fit: float = 0.0


POINT = Forces((0.0,), (rollers.LOAD,))


def soft_pads(*degrees, load=rollers.LOAD):
    """Soft pads: equal inward forces at these angles, even about 0, with the resultant -``load`` e_0."""
    angles = np.radians(degrees)
    return Forces(tuple(angles), tuple(np.full(angles.size, load / np.cos(angles).sum())))


def points(*degrees, stiffness=1e8):
    """Return compression-only springs at single angles."""
    return Springs(tuple(np.radians(degrees)), stiffness)


def seat(per_metre, fit=0.0, pieces=360, radius=0.045):
    """A seat of ``per_metre`` (N/m for each metre of the circumference at ``radius``) all round, in ``pieces``."""
    angles = 2 * np.pi * np.arange(pieces) / pieces
    return Springs(tuple(angles), per_metre * 2 * np.pi * radius / pieces, fit)


class Scene(NamedTuple):
    """Scene. ``last``: highest harmonic, 0 for a rigid ring; ``width`` 0: healthy."""

    last: int = 30
    outside: Any = POINT
    width: float = 0.8e-3
    depth: float = 50e-6
    angle: float = 0.0
    load: float = rollers.LOAD
    bracket: float = rollers.K_B
    ring: beam_ring.Beam = beam_ring.NF308
    sensor: float = 0.0


class System(NamedTuple):
    """Energy y.A y/2 - f.y + sum_i c_i/(m_i + 1) max(0, B_i y - o_i)^(m_i + 1)."""

    A: np.ndarray
    f: np.ndarray
    B: np.ndarray
    o: np.ndarray
    c: np.ndarray
    m: np.ndarray

    def energy(self, y):
        compression = np.maximum(self.B @ y - self.o, 0.0)
        return y @ self.A @ y / 2 - self.f @ y + np.sum(self.c / (self.m + 1) * compression ** (self.m + 1))

    def slope(self, y):
        """Slope of the energy, and its second derivative."""
        compression = np.maximum(self.B @ y - self.o, 0.0)
        force = self.c * compression**self.m
        stiffness = np.where(
            compression > 0, self.m * self.c * np.maximum(compression, 1e-15) ** (self.m - 1), 0.0
        )
        return self.A @ y - self.f + force @ self.B, self.A + (self.B.T * stiffness) @ self.B


def minimise(system, y, tolerance=1e-9, floor=1e5):
    """Minimise the energy by Newton's method, with steps halved while they overshoot the minimum.

    floor: stiffness (N/m) added to the matrix only, for bodies without contact during the iteration.
    """
    regularisation = floor * np.eye(y.size)
    for _ in range(200):
        slope, stiffness = system.slope(y)
        if np.abs(slope).max() < tolerance:
            return y
        step = -np.linalg.solve(stiffness + regularisation, slope)
        fraction = 1.0
        while fraction > 1e-6 and system.slope(y + fraction * step)[0] @ step > 0.5 * abs(slope @ step):
            fraction *= 0.5
        y = y + fraction * step
    raise AssertionError(f"no rest: {np.abs(slope).max()} N left")


def bracket_rows(scene):
    """Return the indices in y of the body on the bracket: the carrier, which is last, or the ring."""
    return slice(-2, None) if isinstance(scene.outside, Springs) else slice(0, 2)


def system(scene, theta, anchor):
    """Unknowns: of the ring, of the rollers, of a carrier; first the outer contacts, then the inner ones.

    ``theta``: angles of the rollers. ``anchor``: None without a bracket.
    """
    orders, z = harmonics(scene.last), rollers.Z
    at_rollers = shape_functions(orders, theta)
    size = at_rollers.shape[1]
    has_carrier = isinstance(scene.outside, Springs)
    total = size + z + 2 * has_carrier
    A, f = np.zeros((total, total)), np.zeros(total)
    A[range(2, size), range(2, size)] = per_unknown(orders, beam_ring.modes(orders, scene.ring)[0])
    rows = range(size, size + z)
    A[rows, rows], f[rows] = -CENTRIFUGAL, CENTRIFUGAL * R_MEAN
    B = np.zeros((2 * z, total))
    B[:z, :size], B[:z, rows], B[z:, rows] = -at_rollers, np.eye(z), -np.eye(z)
    o, c, m = np.append(drops(scene, theta), np.zeros(z)), np.full(2 * z, rollers.K), np.full(2 * z, 10 / 9)
    if has_carrier:
        f[-2] = -scene.load
        angles = np.array(scene.outside.angles)
        springs = np.hstack(
            [shape_functions(orders, angles), np.zeros((angles.size, z)), -shape_functions((), angles)]
        )
        B, o = np.vstack([B, springs]), np.append(o, np.full(angles.size, -scene.outside.fit))
        c, m = np.append(c, np.full(angles.size, scene.outside.stiffness)), np.append(m, np.ones(angles.size))
    else:
        f[:size] = scene.outside.vector(orders)
    if anchor is not None:
        rows = bracket_rows(scene)
        f[rows] += scene.bracket * anchor
        A[rows, rows] += scene.bracket * np.eye(2)
    return System(A, f, B, o, c, m)


def drops(scene, theta):
    """h of each roller (m)."""
    arcs = rollers.R_O * rollers.wrap_angle(theta - scene.angle)
    is_inside = np.abs(arcs) < scene.width / 2
    return np.array(
        [
            rollers.path_depth_and_slope(s, scene.width, scene.depth, rollers.REDUCED_O)[0] if inside else 0.0
            for s, inside in zip(arcs, is_inside, strict=True)
        ]
    )


class Path(NamedTuple):
    """Over a ball pass: cage angle and reading (n,), unknowns (n, size), outer forces (n, Z)."""

    turned: np.ndarray
    reading: np.ndarray
    unknowns: np.ndarray
    forces: np.ndarray


def static_path(scene, turned, anchor):
    """At rest with the first roller at each of the angles ``turned``."""
    orders = harmonics(scene.last)
    sensor = shape_functions(orders, scene.sensor)[0]
    y, unknown_rows, forces = None, [], []
    for first in turned:
        system_ = system(scene, first + PASS * np.arange(rollers.Z), anchor)
        if y is None:
            y = np.zeros(system_.f.size)
            y[0] = y[bracket_rows(scene).start] = -1e-6
        y = minimise(system_, y)
        unknown_rows.append(y)
        forces.append(rollers.elastic(system_.B @ y - system_.o)[: rollers.Z])
    unknowns = np.array(unknown_rows)
    return Path(np.asarray(turned), unknowns[:, : sensor.size] @ sensor, unknowns, np.array(forces))


def anchor_position(scene, phases=32):
    """Compute the mean position of the body on the bracket over a ball pass of the healthy bearing without it."""
    healthy = scene._replace(width=0.0)
    turned = np.pi / rollers.Z + PASS * (np.arange(phases) + 0.5) / phases
    return static_path(healthy, turned, None).unknowns[:, bracket_rows(scene)].mean(axis=0)


def path(scene, samples=1024):
    """A ball pass of the steady bearing."""
    turned = np.pi / rollers.Z + PASS * np.arange(samples) / samples
    return static_path(scene, turned, anchor_position(scene))


def line(path_, number=1):
    """Complex amplitude (m/s) of velocity at ``number`` times BPFO, phase from the first roller at 0."""
    rate = number * rollers.Z * rollers.OMEGA_C
    return 2j * rate * np.mean(path_.reading * np.exp(-1j * number * rollers.Z * path_.turned))


def defect_contribution(scene, samples=1024):
    """|line - that of the healthy bearing| at BPFO in m/s."""
    return abs(line(path(scene, samples)) - line(path(scene._replace(width=0.0), samples)))


if __name__ == "__main__":
    cases = {
        "rigid": Scene(last=0),
        "point": Scene(),
        "two pads, 45": Scene(outside=soft_pads(-45, 45)),
        "three pads, 0, 60": Scene(outside=soft_pads(-60, 0, 60)),
        "evenly": Scene(outside=POINT._replace(evenly=True)),
    }
    for stiffness in (1e7, 1e8, 1e9, 1e10):
        cases[f"three points of {stiffness:.0e} N/m"] = Scene(outside=points(-60, 0, 60, stiffness=stiffness))
    cases["seat 1e12"] = Scene(outside=seat(1e12))
    for name, scene in cases.items():
        whole = line(path(scene)), line(path(scene._replace(width=0.0)))
        print(f"{name:35} line {1e6 * abs(whole[0]):7.2f}, healthy {1e6 * abs(whole[1]):7.2f},", end="")
        print(f" less healthy {1e6 * abs(whole[0] - whole[1]):7.2f} um/s")
