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
from math import cos, log, pi, sin
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from bearingsim.assemble import geometry
from bearingsim.config import Case
from bearingsim.config.sections.machine import Bearing, Rig
from bearingsim.core import layout as lay
from bearingsim.core.parts.bending import Bending, Stiff

SHEAR = 5.0 / 6.0
CAP = 2.0 * pi * 35e3
"""rad/s: the highest frequency of a harmonic. One that would lie above it has so much more mass: it still bends as
much, and asks for no shorter step."""


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
    """All that the bending of a ring depends on."""

    bearing: Bearing
    rig: Rig
    outer_radius: float
    ring_mass: float
    load: float


def bending(case: Case) -> Any:
    """The bending of the case's outer ring, for the core."""
    if case.rig.ring is None:
        return Stiff()
    return made(of_ring(case))


def of_ring(case: Case) -> OfRing:
    """All that the bending of the case's ring depends on."""
    return OfRing(case.bearing, case.rig, geometry.outer_radius(case), geometry.ring_mass(case), case.load)


def section_of(given: OfRing) -> Section:
    """The section of a ring and its material."""
    known, material = given.rig.ring.section, given.bearing.material
    R = given.bearing.outside_diameter / 2.0 - known.height / 2.0
    return Section(known.height, known.width, R, material.young_modulus, material.poisson_ratio, material.density)


@lru_cache(maxsize=256)
def made(given: OfRing) -> Bending:
    """``bending``, made once for all that ask for it."""
    section, ring = section_of(given), given.rig.ring
    heavier = given.ring_mass / section.mass
    found = [harmonic(section, n) for n in (*range(2, ring.harmonics + 1), 0)]
    H = -(-len(found) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    n, k, omega = (padded([getattr(one, name) for one in found], H) for name in ("n", "k", "omega"))
    omega = np.minimum(omega / np.sqrt(heavier), CAP)
    per_mass = np.divide(omega**2, k, out=np.zeros(H), where=k > 0.0)
    breathing = len(found) - 1
    of_sines = per_mass.copy()
    of_sines[breathing] = 0.0
    places = 2.0 * pi * np.arange(given.bearing.rollers) / given.bearing.rollers
    at_rollers = np.stack([table(np.cos, n, places), table(np.sin, n, places)])
    alpha = given.rig.sensor.angle
    rows = [n, k, omega**2, 2.0 * ring.damping * omega, per_mass, of_sines]
    rows += [*given_forces(given.rig.load, given.load, n), np.cos(n * alpha), np.sin(n * alpha)]
    return Bending(
        of_harmonic=np.array(rows) * (k > 0.0),
        at_rollers=np.ascontiguousarray(at_rollers[:, : len(found)]),
        by_roller=np.ascontiguousarray(at_rollers.transpose(0, 2, 1)[:, : given.bearing.rollers]),
        breathing=breathing,
        mobility=float(per_mass.sum()),
        highest=float(omega.max() ** 2),
        sensor_x=cos(alpha),
        sensor_y=sin(alpha),
    )


def padded(values: list[float], length: int) -> np.ndarray:
    """The values (length,), zeros behind them."""
    return np.concatenate([np.array(values, dtype=float), np.zeros(length - len(values))])


def table(function: Any, n: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The ``function`` of n times the rollers' places (H, lanes); zeros in lanes without a roller."""
    lanes = -(-len(places) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    found = np.zeros((len(n), lanes))
    found[:, : len(places)] = function(np.outer(n, places))
    return found


def given_forces(load: Any, F: float, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a given load of ``F`` (N) does to the amplitudes of cosines and sines (H,), N: it pushes inwards."""
    angles = np.array(getattr(load, "angles", (0.0,)))
    each = F / np.cos(angles).sum()
    return -each * np.cos(np.outer(n, angles)).sum(axis=1), -each * np.sin(np.outer(n, angles)).sum(axis=1)
