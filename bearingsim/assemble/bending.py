"""Harmonics of a flexible outer ring, a curved Timoshenko beam of rectangular section.

A point of the cross-section at distance z outwards of its centroid (radius R) moves by w radially and by v + z phi
circumferentially. With w proportional to cos(n theta), and v and phi to sin(n theta), the elastic energy of
harmonic n is

    pi/2 E b (J_0 e^2 + 2 J_1 e c + J_2 c^2) + pi/2 kappa G b J_0 g^2,
    e = w + n v,  c = n phi,  g = R phi - v - n w,  J_i = integral of z^i/(R + z) over the height

(twice this for n = 0, where v = phi = 0). A generalised force on w alone causes the amplitude per unit of force

    1/k_n = (R^2/(E b J_2) + n^2/(kappa G b J_0)) / (pi (n^2 - 1)^2),   k_0 = 2 pi E b J_0,

and the lowest natural frequency omega_n of the free ring gives the modal mass k_n/omega_n^2. The integrals J_i are
those of Winkler's theory of curved beams (Timoshenko, Strength of Materials II, ch. 2); kappa = 5/6 follows from
the elastic energy of a parabolic shear stress.
"""

from functools import lru_cache
from math import cos, hypot, log, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.assemble import geometry
from bearingsim.config import Case
from bearingsim.config.sections.machine import Bearing, Rig
from bearingsim.config.sections.ring import FlexibleRing, RingLoad, Sensor
from bearingsim.core import layout as lay
from bearingsim.core.parts import bending as core

SHEAR_COEFFICIENT = 5.0 / 6.0
MAX_FREQUENCY = 2.0 * pi * 100e3
"""rad/s; limit of the natural frequency of a harmonic. Higher ones are lowered to it by added modal mass at
unchanged stiffness, because they would shorten the step."""
MIN_SPRINGS, MIN_SPRINGS_WITH_GAP = 64, 320
"""Minimum number of springs of a housing without and with a gap; there are also at least four per harmonic.
Doubling it changes the amplitude at the defect frequency and the RMS by less than 0.5 %. With a gap, the ends of
the contact between ring and housing need a finer resolution."""


class Section(NamedTuple):
    """Cross-section and material of a ring: height, width, mean radius R (m), E (Pa), nu, density (kg/m^3)."""

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
    """Harmonic: its order, stiffness of its amplitude (N/m), natural frequency of the free ring (rad/s)."""

    n: int
    k: float
    omega: float


def harmonic(section: Section, n: int) -> Harmonic:
    """Compute the harmonic of order ``n`` (0, 2, 3, ...) of the free ring.

    Equation (R4) of docs/ring.md: Winkler's integrals of a curved Timoshenko beam.
    """
    (k, k_shear), J = moduli(section), integrals(section)
    from scipy.linalg import eigh

    K, M = beam_matrices(section, n)
    if n == 0:
        return Harmonic(0, 2.0 * pi * k * J[0], float(np.sqrt(K[0, 0] / M[0, 0])))
    compliance = (section.R**2 / (k * J[2]) + n**2 / (k_shear * J[0])) / (pi * (n**2 - 1) ** 2)
    omega_2 = eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0]
    return Harmonic(n, 1.0 / compliance, float(np.sqrt(omega_2)))


def moduli(section: Section) -> tuple[float, float]:
    """Compute the elastic and shear moduli times the width, E b and kappa G b (N/m)."""
    G = section.E / (2.0 * (1.0 + section.nu))
    return section.E * section.width, SHEAR_COEFFICIENT * G * section.width


def integrals(section: Section) -> tuple[float, float, float]:
    """Compute the integrals of the cross-section J_0 (dimensionless), J_1 (m) and J_2 (m^2)."""
    h, R = section.height, section.R
    J_0 = log((R + h / 2.0) / (R - h / 2.0))
    return J_0, h - R * J_0, -R * (h - R * J_0)


def beam_matrices(section: Section, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Compute the stiffness and mass matrices (3, 3) of w, v and R phi, both divided by pi (N/m, kg)."""
    h, R, (k, k_shear), (J_0, J_1, J_2) = section.height, section.R, moduli(section), integrals(section)
    e, c, g = np.array([1.0, n, 0.0]), np.array([0.0, 0.0, n / R]), np.array([-n, -1.0, 1.0])
    K = k * (J_0 * np.outer(e, e) + J_1 * (np.outer(e, c) + np.outer(c, e)) + J_2 * np.outer(c, c))
    K += k_shear * J_0 * np.outer(g, g)
    I = h**3 / 12.0  # noqa: E741
    M = np.array([[h * R, 0.0, 0.0], [0.0, h * R, I / R], [0.0, I / R, I / R]])
    return K, section.density * section.width * M


class RingParameters(NamedTuple):
    """Parameters that determine the bending of a ring: loads in N, mass in kg.

    bracket: stiffness (N/m), damping (N s/m) and anchor (m, m) of a bracket that acts on a carrier.
    """

    bearing: Bearing
    ring: FlexibleRing
    load_path: RingLoad
    sensor: Sensor
    ring_mass: float
    load: float
    load_across: float
    bracket: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def ring_parameters(case: Case) -> RingParameters:
    """Collect the parameters of the case's flexible ring, without a bracket."""
    rig = case.rig
    assert rig.ring is not None
    assert rig.load is not None
    return RingParameters(
        case.bearing, rig.ring, rig.load, rig.sensor, geometry.ring_mass(case), case.load, case.load_across
    )


def has_carrier(rig: Rig) -> bool:
    """Check if springs connect the ring to a carrier on which load and bracket act."""
    return rig.ring is not None and rig.load is not None and rig.load.has_carrier


def ring_section(ring: RingParameters) -> Section:
    """Return the cross-section and material of a ring."""
    material, height, width = ring.bearing.material, ring.ring.section.height, ring.ring.section.width
    assert height is not None
    assert width is not None
    R = 0.5 * (ring.bearing.outside_diameter - height)
    return Section(height, width, R, material.young_modulus, material.poisson_ratio, material.density)


class Harmonics(NamedTuple):
    """Harmonics of a ring, padded to (H,) with zeros.

    n: order; k: stiffness of an amplitude (N/m); omega: natural frequency (rad/s); per_mass_c, per_mass_s: inverse
    modal mass of the cosine and the sine (1/kg); mode_count: number of harmonics without padding.
    """

    n: np.ndarray
    k: np.ndarray
    omega: np.ndarray
    per_mass_c: np.ndarray
    per_mass_s: np.ndarray
    mode_count: int


def harmonics(ring: RingParameters) -> Harmonics:
    """Compute the harmonics of a ring, with padding that leaves room for a carrier."""
    section = ring_section(ring)
    modes = [harmonic(section, n) for n in (*range(2, int(ring.ring.harmonics) + 1), 0)]
    H = -(-(len(modes) + ring.load_path.has_carrier) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    n, k, omega = (pad_with_zeros([getattr(mode, name) for mode in modes], H) for name in ("n", "k", "omega"))
    omega = np.minimum(omega * np.sqrt(section.mass / ring.ring_mass), MAX_FREQUENCY)
    per_mass = np.divide(omega**2, k, out=np.zeros(H), where=k > 0.0)
    return Harmonics(n, k, omega, per_mass, np.where(n > 0.0, per_mass, 0.0), len(modes))


@lru_cache(maxsize=256)
def build_bending(ring: RingParameters) -> core.Bending:
    """Build the bending of a ring. It is cached, so callers must not modify its arrays."""
    modes = harmonics(ring)
    angles = 2.0 * pi * np.arange(ring.bearing.rollers) / ring.bearing.rollers
    at_rollers = np.stack([evaluate_at_rollers(function, modes.n, angles) for function in (np.cos, np.sin)])
    at_rollers[:, modes.mode_count :] = 0.0
    harmonic_table = build_harmonic_table(ring, modes)
    if ring.load_path.has_carrier:
        add_carrier(harmonic_table, ring, modes.mode_count)
    springs = build_springs(ring, modes) if ring.load_path.has_carrier else core.NoSprings()
    max_stiffness, max_damping = largest_eigenvalues(ring.ring_mass, harmonic_table, springs)
    on_ring, alpha = ring.sensor.on_ring, ring.sensor.angle or 0.0
    return core.Bending(
        harmonic_table=harmonic_table,
        shapes=np.ascontiguousarray(at_rollers[:, : modes.mode_count]),
        transposed_shapes=np.ascontiguousarray(at_rollers.transpose(0, 2, 1)[:, : ring.bearing.rollers]),
        breathing_index=modes.mode_count - 1,
        accelerance=largest_accelerance(ring, modes, angles),
        max_stiffness=max_stiffness,
        max_damping=max_damping,
        sensor_x=cos(alpha) * on_ring,
        sensor_y=sin(alpha) * on_ring,
        load=hypot(ring.load, ring.load_across),
        springs=springs,
    )


def largest_accelerance(ring: RingParameters, modes: Harmonics, angles: np.ndarray) -> float:
    """Compute the largest eigenvalue (1/kg) of the race's accelerance matrix at the rollers.

    The rollers are evenly spaced, so the matrix is circulant and its eigenvalues are the Fourier transform of a
    row.
    """
    row = np.cos(angles) / ring.ring_mass + np.cos(np.outer(angles, modes.n)) @ modes.per_mass_c
    return float(np.fft.fft(row).real.max())


def build_harmonic_table(ring: RingParameters, modes: Harmonics) -> np.ndarray:
    """Build ``harmonic_table`` of ``core.Bending``, without a carrier."""
    alpha, rows = ring.sensor.angle or 0.0, np.zeros((10, len(modes.n)))
    rows[core.ORDER], rows[core.STIFFNESS], rows[core.STIFFNESS_PER_MASS] = modes.n, modes.k, modes.omega**2
    rows[core.DAMPING_PER_MASS] = 2.0 * ring.ring.damping * modes.omega
    rows[core.INVERSE_MASS_C], rows[core.INVERSE_MASS_S] = modes.per_mass_c, modes.per_mass_s
    if not ring.load_path.has_carrier:
        rows[core.LOAD_C], rows[core.LOAD_S] = load_amplitudes(ring.load_path, ring.load, modes.n)
    if ring.sensor.on_ring:
        rows[core.SENSOR_C], rows[core.SENSOR_S] = np.cos(modes.n * alpha), np.sin(modes.n * alpha)
    rows[core.SENSOR_S, modes.n == 0.0] = 0.0
    rows[:, modes.mode_count :] = 0.0
    return rows


def add_carrier(rows: np.ndarray, ring: RingParameters, i: int) -> None:
    """Fill column ``i`` of a harmonic table with the parameters of the carrier, on which load and bracket act.

    The core treats the carrier's x and y as the amplitudes of this column.
    """
    mass, alpha, (k_b, c_b, x_0, y_0) = ring.load_path.mass or 0.0, ring.sensor.angle or 0.0, ring.bracket
    rows[core.STIFFNESS, i], rows[core.STIFFNESS_PER_MASS, i], rows[core.DAMPING_PER_MASS, i] = (
        k_b,
        k_b / mass,
        c_b / mass,
    )
    rows[core.INVERSE_MASS_C, i] = rows[core.INVERSE_MASS_S, i] = 1.0 / mass
    rows[core.LOAD_C, i], rows[core.LOAD_S, i] = k_b * x_0 - ring.load, k_b * y_0 - ring.load_across
    if not ring.sensor.on_ring:
        rows[core.SENSOR_C, i], rows[core.SENSOR_S, i] = cos(alpha), sin(alpha)


def build_springs(ring: RingParameters, modes: Harmonics) -> core.Springs:
    """Build the springs around the ring.

    The rigid ring on its springs has the damping ratio of the bending modes in the direction in which the springs
    are stiffest.
    """
    angles, k, fit = spring_properties(ring)
    P = -(-len(angles) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    assert lay.MAX_SPRINGS >= P
    directions = np.stack([np.cos(angles), np.sin(angles)])
    stiffness = np.linalg.eigvalsh(k * directions @ directions.T)[-1]
    c = 2.0 * ring.ring.damping * k * sqrt(ring.ring_mass / stiffness)
    transposed_shapes = np.zeros((2, len(angles), len(modes.n)))
    transposed_shapes[0, :, : modes.mode_count] = np.cos(np.outer(angles, modes.n[: modes.mode_count]))
    transposed_shapes[1, :, : modes.mode_count] = np.sin(np.outer(angles, modes.n[: modes.mode_count]))
    # the compression decreases if the carrier moves outwards
    transposed_shapes[:, :, modes.mode_count] = -np.cos(angles), -np.sin(angles)
    shapes = np.zeros((2, modes.mode_count + 1, P))
    shapes[:, :, : len(angles)] = transposed_shapes[:, :, : modes.mode_count + 1].transpose(0, 2, 1)
    spring_table = np.array([pad_with_zeros(row, P) for row in (np.cos(angles), np.sin(angles), k, c, fit)])
    return core.Springs(spring_table, shapes, transposed_shapes, modes.mode_count)


def spring_properties(ring: RingParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the angle (rad), stiffness (N/m) and fit (m) of each spring, (P,) each."""
    load = ring.load_path
    if load.by == "points":
        points = load.at or ()
        angles, k = (np.array([getattr(point, name) for point in points]) for name in ("angle", "stiffness"))
        return angles, k, np.zeros(len(angles))
    P = max(MIN_SPRINGS if (load.fit or 0.0) >= 0.0 else MIN_SPRINGS_WITH_GAP, 4 * int(ring.ring.harmonics))
    k_spring = (load.stiffness or 0.0) * pi * ring.bearing.outside_diameter / P
    return 2.0 * pi * np.arange(P) / P, np.full(P, k_spring), np.full(P, load.fit or 0.0)


def largest_eigenvalues(ring_mass: float, rows: np.ndarray, springs: Any) -> tuple[float, float]:
    """Compute the largest eigenvalues of stiffness over mass (1/s^2) and of damping over mass (1/s) of a ring.

    All springs are in contact. rows: harmonic table of the ring.
    """
    per_mass = np.r_[1.0 / ring_mass, 1.0 / ring_mass, rows[core.INVERSE_MASS_C], rows[core.INVERSE_MASS_S]]
    K = np.diag(np.r_[0.0, 0.0, rows[core.STIFFNESS_PER_MASS], rows[core.STIFFNESS_PER_MASS]])
    C = np.diag(np.r_[0.0, 0.0, rows[core.DAMPING_PER_MASS], rows[core.DAMPING_PER_MASS]])
    if isinstance(springs, core.Springs):
        cosines, sines, k, c, _ = springs.spring_table[:, : springs.transposed_shapes.shape[1]]
        shapes = np.column_stack(
            [cosines, sines, *springs.transposed_shapes.transpose(0, 2, 1).reshape(-1, len(k))]
        )
        shapes = shapes * np.sqrt(per_mass)
        K, C = K + shapes.T @ (k[:, np.newaxis] * shapes), C + shapes.T @ (c[:, np.newaxis] * shapes)
    return float(np.linalg.eigvalsh(K)[-1]), float(np.linalg.eigvalsh(C)[-1])


def undamped_bending(bending: Any) -> Any:
    """Return the bending of a ring with undamped springs, for static equilibrium.

    A bending without springs is returned unchanged.
    """
    if not (isinstance(bending, core.Bending) and isinstance(bending.springs, core.Springs)):
        return bending
    spring_table = bending.springs.spring_table.copy()
    spring_table[core.SPRING_DAMPING] = 0.0
    return bending._replace(springs=bending.springs._replace(spring_table=spring_table))


def pad_with_zeros(values: Any, length: int) -> np.ndarray:
    """Append zeros to values up to the shape (length,)."""
    return np.concatenate([np.array(values, dtype=float), np.zeros(length - len(values))])


def evaluate_at_rollers(function: Any, n: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Evaluate ``function`` at ``n`` (H,) times the rollers' ``angles`` (rad), (H, lanes); zero in lanes without a
    roller.
    """
    lanes = -(-len(angles) // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH
    values = np.zeros((len(n), lanes))
    values[:, : len(angles)] = function(np.outer(n, angles))
    return values


def load_amplitudes(load: RingLoad, F: float, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Compute the generalised forces (N) of an inward load ``F`` (N) on cosines and sines, (H,) each."""
    angles = np.array(load.angles or (0.0,))
    force = F / np.cos(angles).sum()
    return -force * np.cos(np.outer(n, angles)).sum(axis=1), -force * np.sin(np.outer(n, angles)).sum(axis=1)
