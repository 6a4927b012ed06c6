"""The bearing of tests/independent/bent_static.py in motion: rollers with mass, damped contacts, a bent ring.

It shares no code with the package. Unknowns: x of the ring (u_x, u_y, a_0, a_2, b_2, ...; radial motion
s(phi).x, outward) and q_j, how far each roller is outward of the pitch circle. Rollers are at the kinematic
angles theta_j.

    delta_o = q - s(theta).x - h      v_o = q' - s(theta).x' - omega_c s'(theta).x - h' R_o omega_c
    delta_i = -q                      v_i = -q'
    Q = max(0, E(delta) + beta v dE/d(delta)) for delta > 0,       E = k delta^(10/9)    (Kraemer)

    m_r q_j'' = m_r omega_c^2 (d_m/2 + q_j) + Q_i,j - Q_o,j
    m_n x_n'' = -k_n x_n - d_n x_n' + sum_j Q_o,j s_n(theta_j) + pressed_n

The third term of v_o is there since a roller goes along the bent race, for u and for what bends. For u the mass
is the ring's; the spring, with its anchor, and the damper are the bracket's. The harmonics have k_n = 1/C_n and
m_n = k_n/omega_n^2 of the beam (tests/independent/beam_ring.py), with more mass for those faster than a cap,
and d_n = 2 zeta sqrt(k_n m_n).

A stiff carrier behind springs has no mass: at each instant it is where its springs, the bracket's spring and
the load balance. The bracket's damper stays at u.

Steps of one length, Runge and Kutta's classic four stages. SI throughout.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tests.independent import beam_ring, bent_static, rollers
from tests.independent.bent_static import PASS, R_MEAN, Scene, Springs, minimise, per_unknown, shape_functions


class Motion(NamedTuple):
    """Parameters of motion only: Kraemer's beta (s), damping ratio and cap (Hz) of the harmonics, kg, N s/m."""

    beta: float = 2.5e-6
    ratio: float = 0.01
    cap: float = np.inf
    mass: float = rollers.M_O
    damper: float = rollers.C_B


def at_rest(scene, first, anchor):
    """All unknowns with the first roller at the angle ``first``: ring, rollers, carrier."""
    equations_ = bent_static.system(scene, first + PASS * np.arange(rollers.Z), anchor)
    y = np.zeros(equations_.f.size)
    y[0] = y[bent_static.bracket_rows(scene).start] = -1e-6
    return minimise(equations_, y)


def anchor_position(scene, phases=32):
    """Compute the mean position over a ball pass of the body on the bracket, healthy and without the bracket."""
    angles = np.pi / rollers.Z + PASS * (np.arange(phases) + 0.5) / phases
    rows = bent_static.bracket_rows(scene)
    return np.mean([at_rest(scene._replace(width=0.0), first, None)[rows] for first in angles], axis=0)


def contact(delta, rate, beta):
    """Force of contacts and its rate of damping, N."""
    compression = np.maximum(delta, 0.0)
    elastic = rollers.K * compression ** (10 / 9)
    slope = rollers.K * 10 / 9 * compression ** (1 / 9)
    return np.maximum(elastic + beta * rate * slope, 0.0)


class Carrier:
    """A stiff body without mass behind springs that push only; it remembers where it was."""

    def __init__(self, scene, orders, anchor, start):
        springs, angles = scene.outside, np.array(scene.outside.angles)
        self.shapes, self.directions = shape_functions(orders, angles), shape_functions((), angles)
        self.springs, self.scene, self.anchor, self.position = springs, scene, anchor, start

    def ring_force(self, x):
        """Generalised force on the ring."""
        out = self.shapes @ x + self.springs.fit
        position = self.position
        for _ in range(50):
            forces = self.springs.stiffness * np.maximum(out - self.directions @ position, 0.0)
            residual = (
                forces @ self.directions - self.scene.bracket * (position - self.anchor) - [self.scene.load, 0.0]
            )
            if np.abs(residual).max() < 1e-9 * self.scene.load:
                self.position = position
                return -forces @ self.shapes
            active = self.directions[forces > 0]
            stiffness = self.springs.stiffness * active.T @ active + self.scene.bracket * np.eye(2)
            position = position + np.linalg.solve(stiffness, residual)
        raise AssertionError("the carrier finds no rest")


class Equations(NamedTuple):
    """y' = slope(t, y) of y = (x, q, x', q'), the state ``start`` at t = 0, and x' read by the sensor."""

    slope: Callable
    start: np.ndarray
    sensor: np.ndarray


def path_depths_and_rates(scene, theta):
    """h (m) of each roller, and its rate (m/s)."""
    arcs = rollers.R_O * rollers.wrap_angle(theta - scene.angle)
    if np.abs(arcs).min() >= scene.width / 2:
        return np.zeros(rollers.Z), np.zeros(rollers.Z)
    return rollers.path_depths_and_rates(
        arcs, rollers.R_O * rollers.OMEGA_C, scene.width, scene.depth, rollers.REDUCED_O
    )


def shape_derivatives(orders, angles):
    """ds/dphi at each angle, in the order of ``shape_functions``."""
    columns = [-np.sin(angles), np.cos(angles)]
    for n in orders:
        columns += [np.zeros_like(angles)] if n == 0 else [-n * np.sin(n * angles), n * np.cos(n * angles)]
    return np.stack(columns, axis=1)


def approaches(scene, t, x, q, w, v):
    """s at the rollers (Z, unknowns), outer approaches (m) and rates (m/s): ring at x, w, rollers at q, v."""
    orders = bent_static.harmonics(scene.last)
    theta = rollers.THETA + rollers.OMEGA_C * t
    s = shape_functions(orders, theta)
    h, rates = path_depths_and_rates(scene, theta)
    return s, q - s @ x - h, v - s @ w - rollers.OMEGA_C * (shape_derivatives(orders, theta) @ x) - rates


def equations(scene: Scene, motion: Motion = Motion()) -> Equations:  # noqa: B008
    """The bearing in motion, from rest at t = 0."""
    orders = bent_static.harmonics(scene.last)
    ring, z = shape_functions(orders, 0.0).shape[1], rollers.Z
    anchor = anchor_position(scene)
    first = at_rest(scene, np.pi / z, anchor)
    stiffness, mass = beam_ring.modes(orders, scene.ring, motion.mass, motion.cap)
    k = np.concatenate([[0.0, 0.0], per_unknown(orders, stiffness)])
    m = np.concatenate([[motion.mass] * 2, per_unknown(orders, mass)])
    d = np.concatenate([[motion.damper] * 2, per_unknown(orders, 2 * motion.ratio * np.sqrt(stiffness * mass))])
    constant_force = np.zeros(ring)
    carrier = None
    if isinstance(scene.outside, Springs):
        carrier = Carrier(scene, orders, anchor, first[-2:])
    else:
        k[:2] = scene.bracket
        constant_force[:] = scene.outside.vector(orders)
        constant_force[:2] += scene.bracket * anchor

    def slope(t, y):
        x, q, w, v = y[:ring], y[ring : ring + z], y[ring + z : 2 * ring + z], y[2 * ring + z :]
        s, delta, rate = approaches(scene, t, x, q, w, v)
        outer, inner = contact(delta, rate, motion.beta), contact(-q, -v, motion.beta)
        ring_force = constant_force if carrier is None else carrier.ring_force(x)
        ring_rate = (outer @ s + ring_force - k * x - d * w) / m
        roller_rate = rollers.OMEGA_C**2 * (R_MEAN + q) + (inner - outer) / rollers.M_R
        return np.concatenate([w, v, ring_rate, roller_rate])

    start = np.concatenate([first[: ring + z], np.zeros(ring + z)])
    sensor = np.zeros(start.size)
    sensor[ring + z : 2 * ring + z] = shape_functions(orders, scene.sensor)[0]
    return Equations(slope, start, sensor)


class Record(NamedTuple):
    """Velocity (m/s) at the sensor at ``per_pass`` instants of each ball pass (passes, per_pass)."""

    velocity: np.ndarray

    def lines(self, number=1):
        """Complex amplitude (m/s) of each pass at ``number`` times BPFO, phase from the first roller at 0."""
        per_pass = self.velocity.shape[1]
        angle = rollers.Z * (np.pi / rollers.Z + PASS * np.arange(per_pass) / per_pass)
        return 2 * np.mean(self.velocity * np.exp(-1j * number * angle), axis=1)

    def rms(self):
        """Of each pass, its mean removed, the whole band that the steps resolve."""
        return self.velocity.std(axis=1)

    def rms_below(self, band=4096.0):
        """RMS of each pass under ``band`` Hz."""
        spectrum = np.fft.rfft(self.velocity, axis=1)[:, 1:] / self.velocity.shape[1]
        is_below = np.arange(1, spectrum.shape[1] + 1) * rollers.Z * rollers.OMEGA_C / (2 * np.pi) < band
        return np.sqrt(2 * np.sum(np.abs(spectrum[:, is_below]) ** 2, axis=1))

    def pass_difference(self):
        """Compute the RMS of the difference between the last two passes over their RMS."""
        return np.sqrt(np.mean((self.velocity[-1] - self.velocity[-2]) ** 2)) / self.velocity[-1].std()


def run(equations_: Equations, passes=12, steps=12582) -> Record:
    """``steps`` to each ball pass: 12582 are 0.5 us each."""
    step = PASS / rollers.OMEGA_C / steps
    y, t, half = equations_.start.copy(), 0.0, 0.5 * step
    velocity = np.empty((passes, steps))
    for n in range(passes * steps):
        velocity.flat[n] = equations_.sensor @ y
        a = equations_.slope(t, y)
        b = equations_.slope(t + half, y + half * a)
        c = equations_.slope(t + half, y + half * b)
        d = equations_.slope(t + step, y + step * c)
        y += step / 6 * (a + 2 * (b + c) + d)
        t = (n + 1) * step
    return Record(velocity)


def defect_contribution(damaged: Record, healthy: Record):
    """|line - that of the healthy bearing| at BPFO in m/s, of the last pass."""
    return abs(damaged.lines()[-1] - healthy.lines()[-1])
