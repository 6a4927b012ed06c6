"""The harmonics of an outer ring that bends: a curved Timoshenko beam of rectangular section.

A point of the section, z outwards of its middle (radius R), moves by w along the radius and by v + z phi around
the ring. With cos(n theta) in w, sin(n theta) in v and phi the elastic energy of a harmonic n is

    pi/2 E b (J_0 e^2 + 2 J_1 e c + J_2 c^2) + pi/2 kappa G b J_0 g^2,
    e = w + n v,  c = n phi,  g = R phi - v - n w,  J_i = integral of z^i/(R + z) over the height

(twice that of n = 0, where v = phi = 0). A radial force on w alone bends it by

    1/k_n = (R^2/(E b J_2) + n^2/(kappa G b J_0)) / (pi (n^2 - 1)^2),   k_0 = 2 pi E b J_0,

and the lowest frequency of the free ring gives the mass that goes with k_n. Source of the section's integrals:
Winkler's theory of curved beams (Timoshenko, Strength of Materials II, ch. 2); kappa = 5/6 is that of the elastic
energy of a parabola of shear.
"""

from functools import lru_cache
from math import cos, hypot, log, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from bearingsim.assemble import geometry
from bearingsim.config import Case
from bearingsim.config.sections.machine import Bearing, Rig
from bearingsim.config.sections.ring import FlexibleRing, RingLoad, Sensor
from bearingsim.core import layout as lay
from bearingsim.core.parts import bending as core

SHEAR = 5.0 / 6.0
CAP = 2.0 * pi * 100e3
"""rad/s: the highest frequency of a harmonic. One that would lie above it has so much more mass: it still bends as
much, and asks for no shorter step."""


SPRINGS, SPRINGS_WITH_A_GAP = 64, 320
"""The least number of springs that stand for a housing; four for each harmonic, if that is more. Twice as many
change line and RMS at rest by less than 0.5 %: where the ring lies in a gap, where it leaves off decides."""


class Section(NamedTuple):
    """The ring's section and material: height, width, radius of the middle (m), SI."""

    height: float
    width: float
    R: float
    E: float
    nu: float
    density: float

    @property
    def mass(self) -> float:
        """Mass of the ring, kg."""
        return self.density * self.height * self.width * 2.0 * pi * self.R


class Harmonic(NamedTuple):
    """One harmonic: its number, stiffness of its amplitude (N/m), frequency of the free ring (rad/s)."""

    n: int
    k: float
    omega: float


def harmonic(section: Section, n: int) -> Harmonic:
    """Harmonic ``n`` (0, 2, 3, ...) of the free ring."""
    (k, k_shear), J = moduli(section), integrals(section)
    K, M = beam_matrices(section, n)
    if n == 0:
        return Harmonic(0, 2.0 * pi * k * J[0], float(np.sqrt(K[0, 0] / M[0, 0])))
    compliance = (section.R**2 / (k * J[2]) + n**2 / (k_shear * J[0])) / (pi * (n**2 - 1) ** 2)
    omega_2 = eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0]
    return Harmonic(n, 1.0 / compliance, float(np.sqrt(omega_2)))


def moduli(section: Section) -> tuple[float, float]:
    """E b and kappa G b, N/m."""
    G = section.E / (2.0 * (1.0 + section.nu))
    return section.E * section.width, SHEAR * G * section.width


def integrals(section: Section) -> tuple[float, float, float]:
    """J_0 (1), J_1 (m), J_2 (m^2)."""
    h, R = section.height, section.R
    J_0 = log((R + h / 2.0) / (R - h / 2.0))
    return J_0, h - R * J_0, -R * (h - R * J_0)


def beam_matrices(section: Section, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass (3, 3) of w, v, R phi, over pi."""
    h, R, (k, k_shear), (J_0, J_1, J_2) = section.height, section.R, moduli(section), integrals(section)
    e, c, g = np.array([1.0, n, 0.0]), np.array([0.0, 0.0, n / R]), np.array([-n, -1.0, 1.0])
    K = k * (J_0 * np.outer(e, e) + J_1 * (np.outer(e, c) + np.outer(c, e)) + J_2 * np.outer(c, c))
    K += k_shear * J_0 * np.outer(g, g)
    I = h**3 / 12.0  # noqa: E741
    M = np.array([[h * R, 0.0, 0.0], [0.0, h * R, I / R], [0.0, I / R, I / R]])
    return K, section.density * section.width * M


class OfRing(NamedTuple):
    """All that the bending of a ring depends on: loads in N, masses in kg, lengths in m.

    bracket: stiffness (N/m), damping (N s/m) and place at rest of what holds the carrier, if there is one.
    """

    bearing: Bearing
    ring: FlexibleRing
    load_path: RingLoad
    sensor: Sensor
    ring_mass: float
    load: float
    load_across: float
    bracket: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def of_ring(case: Case) -> OfRing:
    """All that the bending of the case's ring, which bends, depends on, without a bracket."""
    rig = case.rig
    assert rig.ring is not None
    assert rig.load is not None
    return OfRing(
        case.bearing, rig.ring, rig.load, rig.sensor, geometry.ring_mass(case), case.load, case.load_across
    )


def has_carrier(rig: Rig) -> bool:
    """Whether springs stand between the ring and a carrier, on which load and bracket act."""
    return rig.ring is not None and rig.load is not None and rig.load.carried


def section_of(given: OfRing) -> Section:
    """The section of a ring and its material."""
    material, height, width = given.bearing.material, given.ring.section.height, given.ring.section.width
    assert height is not None
    assert width is not None
    R = 0.5 * (given.bearing.outside_diameter - height)
    return Section(height, width, R, material.young_modulus, material.poisson_ratio, material.density)


class Harmonics(NamedTuple):
    """All harmonics, padded (H,): number, stiffness (N/m), frequency (rad/s), 1/mass of cosines and sines (1/kg).

    real: how many are.
    """

    n: np.ndarray
    k: np.ndarray
    omega: np.ndarray
    per_mass_c: np.ndarray
    per_mass_s: np.ndarray
    real: int


def harmonics(given: OfRing) -> Harmonics:
    """The harmonics of a ring, with room for a carrier."""
    section = section_of(given)
    found = [harmonic(section, n) for n in (*range(2, int(given.ring.harmonics) + 1), 0)]
    H = -(-(len(found) + given.load_path.carried) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    n, k, omega = (padded([getattr(one, name) for one in found], H) for name in ("n", "k", "omega"))
    omega = np.minimum(omega * np.sqrt(section.mass / given.ring_mass), CAP)
    per_mass = np.divide(omega**2, k, out=np.zeros(H), where=k > 0.0)
    return Harmonics(n, k, omega, per_mass, np.where(n > 0.0, per_mass, 0.0), len(found))


@lru_cache(maxsize=256)
def made(given: OfRing) -> core.Bending:
    """The bending of a ring, made once for all that ask for it."""
    of = harmonics(given)
    places = 2.0 * pi * np.arange(given.bearing.rollers) / given.bearing.rollers
    at_rollers = np.stack([table(np.cos, of.n, places), table(np.sin, of.n, places)])
    at_rollers[:, of.real :] = 0.0
    rows = with_carrier(rows_of(given, of), given, of.real) if given.load_path.carried else rows_of(given, of)
    springs = springs_of(given, of) if given.load_path.carried else core.NoSprings()
    highest, highest_damping = fastest(given.ring_mass, rows, springs)
    on_ring, alpha = given.sensor.on_ring, given.sensor.angle or 0.0
    return core.Bending(
        of_harmonic=rows,
        at_rollers=np.ascontiguousarray(at_rollers[:, : of.real]),
        by_roller=np.ascontiguousarray(at_rollers.transpose(0, 2, 1)[:, : given.bearing.rollers]),
        breathing=of.real - 1,
        mobility=mobility(given, of, places),
        highest=highest,
        highest_damping=highest_damping,
        sensor_x=cos(alpha) * on_ring,
        sensor_y=sin(alpha) * on_ring,
        load=hypot(given.load, given.load_across),
        springs=springs,
    )


def mobility(given: OfRing, of: Harmonics, places: np.ndarray) -> float:
    """The largest eigenvalue (1/kg) of what forces at all rollers give the race's acceleration at them.

    They stand evenly, so the matrix is circulant: its eigenvalues are the Fourier transform of a row.
    """
    row = np.cos(places) / given.ring_mass + np.cos(np.outer(places, of.n)) @ of.per_mass_c
    return float(np.fft.fft(row).real.max())


def rows_of(given: OfRing, of: Harmonics) -> np.ndarray:
    """``core.Bending.of_harmonic`` of the ring itself."""
    alpha, rows = given.sensor.angle or 0.0, np.zeros((10, len(of.n)))
    rows[core.N], rows[core.K], rows[core.K_M] = of.n, of.k, of.omega**2
    rows[core.C_M] = 2.0 * given.ring.damping * of.omega
    rows[core.PER_MASS_C], rows[core.PER_MASS_S] = of.per_mass_c, of.per_mass_s
    if not given.load_path.carried:
        rows[core.LOAD_C], rows[core.LOAD_S] = given_forces(given.load_path, given.load, of.n)
    if given.sensor.on_ring:
        rows[core.SENSOR_C], rows[core.SENSOR_S] = np.cos(of.n * alpha), np.sin(of.n * alpha)
    rows[core.SENSOR_S, of.n == 0.0] = 0.0
    rows[:, of.real :] = 0.0
    return rows


def with_carrier(rows: np.ndarray, given: OfRing, i: int) -> np.ndarray:
    """The rows with the carrier's place as harmonic ``i``: load and bracket act on it."""
    mass, alpha, (k_b, c_b, x_0, y_0) = given.load_path.mass or 0.0, given.sensor.angle or 0.0, given.bracket
    rows[core.K, i], rows[core.K_M, i], rows[core.C_M, i] = k_b, k_b / mass, c_b / mass
    rows[core.PER_MASS_C, i] = rows[core.PER_MASS_S, i] = 1.0 / mass
    rows[core.LOAD_C, i], rows[core.LOAD_S, i] = k_b * x_0 - given.load, k_b * y_0 - given.load_across
    if not given.sensor.on_ring:
        rows[core.SENSOR_C, i], rows[core.SENSOR_S, i] = cos(alpha), sin(alpha)
    return rows


def springs_of(given: OfRing, of: Harmonics) -> core.Springs:
    """The springs around the ring, each damped by ``ring.damping`` at the frequency of the ring between them."""
    angles, k, fit = places_of_springs(given)
    P = -(-len(angles) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    assert lay.MAX_SPRINGS >= P
    across = max((k * np.cos(angles) ** 2).sum(), (k * np.sin(angles) ** 2).sum())
    c = 2.0 * given.ring.damping * k * sqrt(given.ring_mass / across)
    by_spring = np.zeros((2, len(angles), len(of.n)))
    by_spring[0, :, : of.real] = np.cos(np.outer(angles, of.n[: of.real]))
    by_spring[1, :, : of.real] = np.sin(np.outer(angles, of.n[: of.real]))
    by_spring[0, :, of.real], by_spring[1, :, of.real] = -np.cos(angles), -np.sin(angles)
    at = np.zeros((2, of.real + 1, P))
    at[:, :, : len(angles)] = by_spring[:, :, : of.real + 1].transpose(0, 2, 1)
    values = np.cos(angles), np.sin(angles), k, c, fit
    return core.Springs(np.array([padded(value, P) for value in values]), at, by_spring, of.real)


def places_of_springs(given: OfRing) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles (rad), stiffness (N/m) and fit (m) of the springs."""
    load = given.load_path
    if load.by == "points":
        at = load.at or ()
        angles, k = (np.array([getattr(point, name) for point in at]) for name in ("angle", "stiffness"))
        return angles, k, np.zeros(len(angles))
    P = max(SPRINGS if (load.fit or 0.0) >= 0.0 else SPRINGS_WITH_A_GAP, 4 * int(given.ring.harmonics))
    each = (load.stiffness or 0.0) * pi * given.bearing.outside_diameter / P
    return 2.0 * pi * np.arange(P) / P, np.full(P, each), np.full(P, load.fit or 0.0)


def fastest(ring_mass: float, rows: np.ndarray, springs: Any) -> tuple[float, float]:
    """The largest stiffness (1/s^2) and damping (1/s) over mass of a ring whose springs are all pressed."""
    per_mass = np.r_[1.0 / ring_mass, 1.0 / ring_mass, rows[core.PER_MASS_C], rows[core.PER_MASS_S]]
    K = np.diag(np.r_[0.0, 0.0, rows[core.K_M], rows[core.K_M]])
    C = np.diag(np.r_[0.0, 0.0, rows[core.C_M], rows[core.C_M]])
    if isinstance(springs, core.Springs):
        cosines, sines, k, c, _ = springs.of_spring[:, : springs.by_spring.shape[1]]
        shapes = np.column_stack([cosines, sines, *springs.by_spring.transpose(0, 2, 1).reshape(-1, len(k))])
        shapes = shapes * np.sqrt(per_mass)
        K, C = K + shapes.T @ (k[:, np.newaxis] * shapes), C + shapes.T @ (c[:, np.newaxis] * shapes)
    return float(np.linalg.eigvalsh(K)[-1]), float(np.linalg.eigvalsh(C)[-1])


def at_rest(found: Any) -> Any:
    """The bending of a ring that stands: its springs without their dampers."""
    if not (isinstance(found, core.Bending) and isinstance(found.springs, core.Springs)):
        return found
    undamped = found.springs.of_spring.copy()
    undamped[core.C_S] = 0.0
    return found._replace(springs=found.springs._replace(of_spring=undamped))


def padded(values: Any, length: int) -> np.ndarray:
    """The values (length,), zeros behind them."""
    return np.concatenate([np.array(values, dtype=float), np.zeros(length - len(values))])


def table(function: Any, n: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The ``function`` of n times the rollers' places (H, lanes); zeros in lanes without a roller."""
    lanes = -(-len(places) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    found = np.zeros((len(n), lanes))
    found[:, : len(places)] = function(np.outer(n, places))
    return found


def given_forces(load: RingLoad, F: float, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a given load of ``F`` (N) does to the amplitudes of cosines and sines (H,), N: it pushes inwards."""
    angles = np.array(load.angles or (0.0,))
    each = F / np.cos(angles).sum()
    return -each * np.cos(np.outer(n, angles)).sum(axis=1), -each * np.sin(np.outer(n, angles)).sum(axis=1)
