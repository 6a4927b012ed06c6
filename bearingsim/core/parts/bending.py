"""Bending of the outer ring as harmonics of its radial displacement.

    w(theta) = sum_n a_n cos(n theta) + b_n sin(n theta),   n = 0, 2, 3, ...

n = 1 is the rigid motion of the ring. The amplitudes satisfy

    m_n a_n'' + c_n a_n' + k_n a_n = f_n + sum_j Q_o,j cos(n theta_j)

and likewise b_n with sines; f_n is the generalised force of the applied load. The rollers are evenly spaced, so
cos and sin of n phi_j are tabulated, with theta_j = theta_c + phi_j and

    w(theta_j) = sum_n A_n cos(n phi_j) + B_n sin(n phi_j),   A_n + i B_n = (a_n + i b_n) exp(-i n theta_c).

A roller moves along the deformed race, so the closing rate of its outer contact is w_t + omega_c w_theta less than
on a rigid race. The forces on the amplitudes follow from virtual work. The term omega_c w_theta of the rate
accounts for the power that the cage supplies to move a roller along the deformed race (docs/ring.md).
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic, inlined
from bearingsim.core.sums import lane_sum
from bearingsim.core.vectors import sum_harmonics, sum_rollers


@absent
class RigidRing(NamedTuple):
    """Rigid outer ring."""


class Bending(NamedTuple):
    """Flexible ring with H harmonics: n = 2, 3, ..., then n = 0, a carrier if any, and padding to a multiple of 8.

    harmonic_table: (10, H), rows as named below; shapes: (2, harmonics of the ring, lanes) cos(n phi_j) and
    sin(n phi_j); transposed_shapes: (2, Z, H), the same; breathing_index: index of harmonic n = 0; accelerance:
    largest eigenvalue (1/kg) of the accelerance matrix of the race, from forces to accelerations at the rollers;
    max_stiffness, max_damping: largest stiffness (1/s^2) and damping (1/s) over mass of any motion of the ring
    with its springs; sensor_x, sensor_y: cosine and sine of the angle of a sensor on the ring; load: magnitude of
    the load (N); springs: springs around the ring.
    """

    harmonic_table: np.ndarray
    shapes: np.ndarray
    transposed_shapes: np.ndarray
    breathing_index: int
    accelerance: float
    max_stiffness: float
    max_damping: float
    sensor_x: float
    sensor_y: float
    load: float
    springs: Any


# rows of ``Bending.harmonic_table``: n; stiffness of an amplitude (N/m), and over its mass (1/s^2); damping over
# mass (1/s); 1/mass (1/kg) of cosines and sines, 0 for amplitudes that do not exist; generalised force of the load
# (N); cos and sin of n times the sensor's angle
(
    ORDER,
    STIFFNESS,
    STIFFNESS_PER_MASS,
    DAMPING_PER_MASS,
    INVERSE_MASS_C,
    INVERSE_MASS_S,
    LOAD_C,
    LOAD_S,
    SENSOR_C,
    SENSOR_S,
) = range(10)


@absent
class NoSprings(NamedTuple):
    """No springs around the ring: prescribed forces load it, and the bracket acts on its centre."""


class Springs(NamedTuple):
    """P compression-only springs between the ring and a rigid carrier, whose position is stored as a harmonic.

    spring_table: (5, P padded to a multiple of 8), rows as named below; shapes: (2, N, P padded), compression of a
    spring per amplitude, for N harmonics including the carrier; transposed_shapes: (2, P, H), the same; carrier:
    index of the carrier among the H harmonics of ``Bending``.
    """

    spring_table: np.ndarray
    shapes: np.ndarray
    transposed_shapes: np.ndarray
    carrier: int


# rows of ``Springs.spring_table``: cosine and sine of a spring's angle, its stiffness (N/m), damping (N s/m), and
# its compression (m) with the undeformed ring centred in the carrier
SPRING_COS, SPRING_SIN, SPRING_STIFFNESS, SPRING_DAMPING, SPRING_FIT = range(5)


@generic(inline="late", absent=0)
def harmonics(bending: Any) -> int:
    """Return the padded number of harmonics of the ring."""


@harmonics.register(Bending)
def _harmonics(bending):
    return bending.harmonic_table.shape[1]


@generic(inline="late", absent=None)
def fill_race_deflection(bending: Any, C: float, S: float, omega_c: float, y: np.ndarray, lanes: int) -> None:
    """Fill the rows DEFLECTION and DEFLECTION_V, the displacement of the race at every roller and its rate.

    C, S: cosine and sine of the first roller's angle; omega_c: speed of the cage, rad/s; lanes: number of lanes.

    Equation (R1) of docs/ring.md: w at every roller.
    """


@generic(inline="late", absent=0.0)
def race_deflection(bending: Any, y: np.ndarray, j: int) -> float:
    """Return the outward displacement of the race at roller ``j``, m."""


@generic(inline="late", absent=0.0)
def race_deflection_rate(bending: Any, y: np.ndarray, j: int) -> float:
    """Return the rate of ``race_deflection`` along the roller's path, m/s."""


@generic(inline="late", absent=None)
def accelerate_harmonics(bending: Any, m_o: float, y: np.ndarray) -> None:
    """Fill the accelerations of the amplitudes, and add the springs' forces divided by ``m_o`` (kg) to the ring's
    acceleration.

    Requires the rows Q_O and those filled by ``fill_race_deflection``.

    Equation (R2) of docs/ring.md.
    """


@generic(inline="late", absent=None)
def load_springs(springs: Any, y: np.ndarray) -> None:
    """Fill SPRING_FORCE, the generalised forces of the ring on the springs (SPRING_FORCE_C, SPRING_FORCE_S), and
    the forces of the springs on the ring's centre (SPRINGS_X, SPRINGS_Y).
    """


def ring_position(springs, y):
    """Implement ``supported_position`` for a ring without springs: that of the ring's centre."""
    return y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]


@generic(absent=ring_position)
def supported_position(springs: Any, y: np.ndarray) -> tuple[float, float]:
    """Return the position (m, m) of the body supported by the bracket: the ring, or the carrier around it."""


@supported_position.register(Springs)
def _supported_position(springs, y):
    i = springs.carrier
    return y[lay.POSITION + lay.MODES_C + i], y[lay.POSITION + lay.MODES_S + i]


@generic(inline="late", absent=0.0)
def spring_load(springs: Any, row: int, y: np.ndarray, i: int) -> float:
    """Return entry ``i`` of a row that ``load_springs`` fills (N): SPRING_FORCE_C, SPRING_FORCE_S, SPRINGS_X or
    SPRINGS_Y.
    """


@generic(inline="late", absent=None)
def read_sensor(bending: Any, y: np.ndarray) -> None:
    """Fill the cells SENSOR, SENSOR_V, SENSOR_A with the radial motion at the sensor."""


def _rigid_race_bound(bending, K, inverse_mass, k):
    """Implement ``race_stiffness_bound`` for a rigid ring."""
    return K


@generic(inline="late", absent=_rigid_race_bound)
def race_stiffness_bound(bending: Any, K: float, inverse_mass: float, k: float) -> float:
    """Bound the stiffness over mass (1/s^2) of a roller on a flexible race.

    K: stiffness over mass of the roller on a rigid race, 1/s^2; inverse_mass: of the roller, 1/kg; k: stiffness of
    its outer contact, N/m.
    """


@generic(inline="late", absent=0.0)
def race_damping(bending: Any, c: float) -> float:
    """Return the damping over mass (1/s) that a flexible race adds to a roller's.

    c: damping of the roller's outer contact, N s/m.
    """


@race_stiffness_bound.register(Bending)
def _flexible_race_bound(bending, K, inverse_mass, k):
    k = k if inverse_mass > 0.0 else 0.0  # no stiffness in padded lanes
    race_stiffness = bending.max_stiffness + k * bending.accelerance
    half = 0.5 * (K - race_stiffness)
    return 0.5 * (K + race_stiffness) + sqrt(half * half + k * k * bending.accelerance * inverse_mass)


@race_damping.register(Bending)
def _race_damping(bending, c):
    return bending.max_damping + bending.accelerance * c


@race_deflection.register(Bending)
def _race_deflection_flexible(bending, y, j):
    return y[lay.DEFLECTION + j]


@race_deflection_rate.register(Bending)
def _race_deflection_rate_flexible(bending, y, j):
    return y[lay.DEFLECTION_V + j]


@inlined
def fill_phases(bending, C, S, y):
    """Fill PHASE_C, PHASE_S: cosine and sine of n times the angle with cosine ``C`` and sine ``S``."""
    c_2, s_2 = C * C - S * S, 2.0 * S * C
    c_4, s_4 = c_2 * c_2 - s_2 * s_2, 2.0 * s_2 * c_2
    c_8, s_8 = c_4 * c_4 - s_4 * s_4, 2.0 * s_4 * c_4
    y[lay.PHASE_C], y[lay.PHASE_S] = c_2, s_2
    y[lay.PHASE_C + 1], y[lay.PHASE_S + 1] = c_2 * C - s_2 * S, s_2 * C + c_2 * S
    for i in range(2, 8):  # (i + 2) theta = (i - 2) theta + 4 theta
        c = C if i == 3 else (1.0 if i == 2 else y[lay.PHASE_C + i - 4])
        s = S if i == 3 else (0.0 if i == 2 else y[lay.PHASE_S + i - 4])
        y[lay.PHASE_C + i], y[lay.PHASE_S + i] = c * c_4 - s * s_4, s * c_4 + c * s_4
    for i in range(8, bending.harmonic_table.shape[1]):
        c, s = y[lay.PHASE_C + i - 8], y[lay.PHASE_S + i - 8]
        y[lay.PHASE_C + i], y[lay.PHASE_S + i] = c * c_8 - s * s_8, s * c_8 + c * s_8
    y[lay.PHASE_C + bending.breathing_index], y[lay.PHASE_S + bending.breathing_index] = 1.0, 0.0


@inlined
def rotate_amplitudes(bending, omega_c, y):
    """Fill AMPLITUDE_C to AMPLITUDE_V_S: amplitudes in the frame of the rollers, rates along a roller's path."""
    for i in range(bending.harmonic_table.shape[1]):
        c, s, n_omega = y[lay.PHASE_C + i], y[lay.PHASE_S + i], omega_c * bending.harmonic_table[ORDER, i]
        a, b = y[lay.POSITION + lay.MODES_C + i], y[lay.POSITION + lay.MODES_S + i]
        a_v = y[lay.VELOCITY + lay.MODES_C + i] + n_omega * b
        b_v = y[lay.VELOCITY + lay.MODES_S + i] - n_omega * a
        y[lay.AMPLITUDE_C + i], y[lay.AMPLITUDE_S + i] = a * c + b * s, b * c - a * s
        y[lay.AMPLITUDE_V_C + i], y[lay.AMPLITUDE_V_S + i] = a_v * c + b_v * s, b_v * c - a_v * s


@fill_race_deflection.register(Bending)
def _fill_race_deflection_flexible(bending, C, S, omega_c, y, lanes):
    fill_phases(bending, C, S, y)
    rotate_amplitudes(bending, omega_c, y)
    for lane in range(0, lanes, lay.VECTOR_WIDTH):
        cells = (lay.DEFLECTION + lane, lay.DEFLECTION_V + lane)
        sum_harmonics(
            bending.shapes,
            (lay.AMPLITUDE_C, lay.AMPLITUDE_V_C),
            (lay.AMPLITUDE_S, lay.AMPLITUDE_V_S),
            y,
            lane,
            cells,
        )


@inlined
def fill_roller_forces(bending, y):
    """Fill ROLLER_FORCE_C, ROLLER_FORCE_S: generalised forces of Q_O on the amplitudes, in the rollers' frame."""
    for lane in range(0, bending.harmonic_table.shape[1], lay.VECTOR_WIDTH):
        sum_rollers(
            bending.transposed_shapes, lay.Q_O, y, lane, (lay.ROLLER_FORCE_C + lane, lay.ROLLER_FORCE_S + lane)
        )


@load_springs.register(Springs)
def _load_springs(springs, y):
    compress_springs(springs, y)
    shape, f_x, f_y = springs.transposed_shapes.shape, 0.0, 0.0
    for lane in range(0, shape[2], lay.VECTOR_WIDTH):
        sum_rollers(
            springs.transposed_shapes,
            lay.SPRING_FORCE,
            y,
            lane,
            (lay.SPRING_FORCE_C + lane, lay.SPRING_FORCE_S + lane),
        )
    for p in range(shape[1]):
        f_x -= springs.spring_table[SPRING_COS, p] * y[lay.SPRING_FORCE + p]
        f_y -= springs.spring_table[SPRING_SIN, p] * y[lay.SPRING_FORCE + p]
    y[lay.SPRINGS_X], y[lay.SPRINGS_Y] = f_x, f_y


@inlined
def compress_springs(springs, y):
    """Fill COMPRESSION, COMPRESSION_V (rate due to bending) and SPRING_FORCE; springs act in compression only."""
    lanes = springs.spring_table.shape[1]
    rows_c = (lay.POSITION + lay.MODES_C, lay.VELOCITY + lay.MODES_C)
    rows_s = (lay.POSITION + lay.MODES_S, lay.VELOCITY + lay.MODES_S)
    for lane in range(0, lanes, lay.VECTOR_WIDTH):
        sum_harmonics(springs.shapes, rows_c, rows_s, y, lane, (lay.COMPRESSION + lane, lay.COMPRESSION_V + lane))
    u_x, u_y = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
    w_x, w_y = y[lay.VELOCITY + lay.X], y[lay.VELOCITY + lay.Y]
    for p in range(lanes):
        c, s = springs.spring_table[SPRING_COS, p], springs.spring_table[SPRING_SIN, p]
        compression = springs.spring_table[SPRING_FIT, p] + y[lay.COMPRESSION + p] + u_x * c + u_y * s
        rate = y[lay.COMPRESSION_V + p] + w_x * c + w_y * s
        force = (
            springs.spring_table[SPRING_STIFFNESS, p] * compression
            + springs.spring_table[SPRING_DAMPING, p] * rate
        )
        y[lay.COMPRESSION + p] = compression
        y[lay.SPRING_FORCE + p] = max(force, 0.0) if compression > 0.0 else 0.0


@spring_load.register(Springs)
def _spring_load(springs, row, y, i):
    return y[row + i]


@inlined
def force_on_harmonic(bending, y, i):
    """Return the forces (N) of rollers, load and springs on the cosine and the sine amplitude of harmonic
    ``i``."""
    c, s = y[lay.PHASE_C + i], y[lay.PHASE_S + i]
    roller_c, roller_s = y[lay.ROLLER_FORCE_C + i], y[lay.ROLLER_FORCE_S + i]
    f_c = bending.harmonic_table[LOAD_C, i] + roller_c * c - roller_s * s
    f_s = bending.harmonic_table[LOAD_S, i] + roller_c * s + roller_s * c
    return f_c - spring_load(bending.springs, lay.SPRING_FORCE_C, y, i), f_s - spring_load(
        bending.springs, lay.SPRING_FORCE_S, y, i
    )


@accelerate_harmonics.register(Bending)
def _accelerate_harmonics(bending, m_o, y):
    fill_roller_forces(bending, y)
    load_springs(bending.springs, y)
    y[lay.ACCELERATION + lay.X] += spring_load(bending.springs, lay.SPRINGS_X, y, 0) / m_o
    y[lay.ACCELERATION + lay.Y] += spring_load(bending.springs, lay.SPRINGS_Y, y, 0) / m_o
    for i in range(bending.harmonic_table.shape[1]):
        f_c, f_s = force_on_harmonic(bending, y, i)
        k, c = bending.harmonic_table[STIFFNESS_PER_MASS, i], bending.harmonic_table[DAMPING_PER_MASS, i]
        y[lay.ACCELERATION + lay.MODES_C + i] = (
            bending.harmonic_table[INVERSE_MASS_C, i] * f_c
            - k * y[lay.POSITION + lay.MODES_C + i]
            - c * y[lay.VELOCITY + lay.MODES_C + i]
        )
        y[lay.ACCELERATION + lay.MODES_S + i] = (
            bending.harmonic_table[INVERSE_MASS_S, i] * f_s
            - k * y[lay.POSITION + lay.MODES_S + i]
            - c * y[lay.VELOCITY + lay.MODES_S + i]
        )


@inlined
def rigid_motion_at_sensor(bending, block, y):
    """Return the radial component of the ring's rigid-body motion at the sensor, from a block of the state."""
    return bending.sensor_x * y[block + lay.X] + bending.sensor_y * y[block + lay.Y]


@read_sensor.register(Bending)
def _read_sensor(bending, y):
    n = harmonics(bending)
    for i in range(n):  # the AMPLITUDE rows, not needed after the evaluation, serve as work space
        c, s = bending.harmonic_table[SENSOR_C, i], bending.harmonic_table[SENSOR_S, i]
        y[lay.AMPLITUDE_C + i] = c * y[lay.POSITION + lay.MODES_C + i] + s * y[lay.POSITION + lay.MODES_S + i]
        y[lay.AMPLITUDE_S + i] = c * y[lay.VELOCITY + lay.MODES_C + i] + s * y[lay.VELOCITY + lay.MODES_S + i]
        y[lay.AMPLITUDE_V_C + i] = (
            c * y[lay.ACCELERATION + lay.MODES_C + i] + s * y[lay.ACCELERATION + lay.MODES_S + i]
        )
    y[lay.SENSOR] = rigid_motion_at_sensor(bending, lay.POSITION, y) + lane_sum(lay.AMPLITUDE_C, y, n)
    y[lay.SENSOR_V] = rigid_motion_at_sensor(bending, lay.VELOCITY, y) + lane_sum(lay.AMPLITUDE_S, y, n)
    y[lay.SENSOR_A] = rigid_motion_at_sensor(bending, lay.ACCELERATION, y) + lane_sum(lay.AMPLITUDE_V_C, y, n)
