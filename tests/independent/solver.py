"""An independent solution of `rollers`, written from the pages of docs/ and nothing else.

Numbers of equations are those of model.md (M), contact.md (C) and form.md (F). Vectors of the plane are complex:
x + iy, x along e_0. Paths of rollers over defects are minima of (M4) over a grid, tabulated by the distance from
the defect's middle (``solver_scenes.py``). Time by classical Runge-Kutta steps. SI throughout.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

OUTER, INNER, ROLLER = range(3)
"""Elements; the first two also number the contacts of a roller."""
KRAEMER, HUNT_CROSSLEY, GENERAL = range(3)
MAX_GROUPS = 64


class Law(NamedTuple):
    """Stiffness of a contact: k delta^m, or Johnson's with k = pi E* L and radii = Delta R (else 0)."""

    k: float
    m: float
    radii: float


class Damping(NamedTuple):
    """Damping of a contact: kind, coefficient, exponents of rate and approach (general law)."""

    kind: int
    c: float
    of_rate: float
    of_approach: float


class Bearing(NamedTuple):
    """Geometry, masses, kinematics, load and support of the ring."""

    Z: int
    r_m: float
    R_w: float
    radius: tuple  # of the outer and the inner race
    gap: float
    m_r: float
    I_r: float
    m_o: float
    theta_0: float
    omega_i: float
    gamma: float
    load: complex  # pushes the ring with -load
    k_b: float
    c_b: float
    anchor: complex


class Contacts(NamedTuple):
    """Laws of both contacts, defects and form.

    head: (n, 5) carrier, roller, angle, reach, cell of the table; span: (n, 2) rows of its groups; table: (groups,
    contact, 3, cells) share (with the weight), h and dh/ds at |s|; rest: (n, 2) weight of the length outside of
    the defect; waves: (n, 6) element, roller or -1, order, amplitude at the outer and at the inner contact, phase;
    radii: deviations (Z,).
    """

    laws: tuple
    damping: Damping
    head: np.ndarray
    span: np.ndarray
    table: np.ndarray
    rest: np.ndarray
    waves: np.ndarray
    radii: np.ndarray


@njit
def elastic(law, delta):
    """Elastic force and its slope (contact.md, Stiffness); Johnson's y = -x (ln x + 1) by Newton's method."""
    if delta <= 0.0:
        return 0.0, 0.0
    if law.radii == 0.0:
        force = law.k * delta**law.m
        return force, law.m * force / delta
    y = delta / (4 * law.radii)
    x = y / (3.0 - np.log(y))
    change = x
    while abs(change) > 1e-14 * x:
        change = (x * (np.log(x) + 1.0) + y) / -(np.log(x) + 2.0)
        x += change
    return 4 * law.radii * law.k * x, -law.k / (np.log(x) + 2.0)


@njit
def normal_force(law, damping, delta, v):
    """Force of a contact, (C1)."""
    force, slope = elastic(law, delta)
    if delta <= 0.0:
        return 0.0
    if damping.kind == KRAEMER:
        return max(0.0, force + damping.c * v * slope)
    if damping.kind == HUNT_CROSSLEY:
        return max(0.0, force + damping.c * v * force)
    return max(0.0, force + damping.c * np.sign(v) * abs(v) ** damping.of_rate * delta**damping.of_approach)


@njit
def wrap(angle):
    return angle - 2 * np.pi * np.floor(angle / (2 * np.pi) + 0.5)


@njit
def path(table, cell, s):
    """Share, h and dh/ds at s: h and its slope by the cubic between the cells, exact for parabolas."""
    k = min(int(abs(s) / cell), table.shape[1] - 2)
    x = abs(s) / cell - k
    h0, h1, d0, d1 = table[1, k], table[1, k + 1], cell * table[2, k], cell * table[2, k + 1]
    a, b = d0 + d1 - 2 * (h1 - h0), 3 * (h1 - h0) - 2 * d0 - d1
    slope = (3 * a * x * x + 2 * b * x + d0) / cell
    share = table[0, k] + x * (table[0, k + 1] - table[0, k])
    return share, h0 + x * (d0 + x * (b + x * a)), slope if s >= 0.0 else -slope


@njit
def groups(b, c, j, side, race, roller, race_rate, roller_rate, out):
    """Groups of a contact, (M6): rows of share, h, dh/dt, dh/d(race angle), dh/d(roller angle); their number."""
    best, deepest, distance = -1, -1.0, 0.0
    for d in range(len(c.head)):
        on = c.head[d, 0]
        if on != side and not (on == ROLLER and c.head[d, 1] == j):
            continue
        s = (b.R_w * wrap(roller - c.head[d, 2])) if on == ROLLER else b.radius[side] * wrap(race - c.head[d, 2])
        if abs(s) < c.head[d, 3]:
            drop = 0.0
            for g in range(c.span[d, 0], c.span[d, 1]):
                drop = max(drop, path(c.table[g, side], c.head[d, 4], s)[1])
            if drop > deepest:  # of defects that meet only the one with the larger drop acts (defects.md)
                best, deepest, distance = d, drop, s
    out[0] = 0.0
    out[0, 0] = 1.0
    if best < 0:
        return 1
    on, n = c.head[best, 0], 0
    for g in range(c.span[best, 0], c.span[best, 1]):
        share, h, slope = path(c.table[g, side], c.head[best, 4], distance)
        by_angle = slope * (b.R_w if on == ROLLER else b.radius[side])
        out[n, 0], out[n, 1] = share, h
        out[n, 2] = by_angle * (roller_rate if on == ROLLER else race_rate)
        out[n, 3], out[n, 4] = (0.0, by_angle) if on == ROLLER else (by_angle, 0.0)
        n += 1
    out[n] = 0.0
    out[n, 0] = c.rest[best, side]
    return n + 1


@njit
def contact(b, c, j, side, race, roller, race_rate, roller_rate, delta, v, out):
    """Force, its sums with d(delta)/d(race angle) and d(delta)/d(roller angle), and the mean approach (F1, M6)."""
    height, at_race, at_roller = c.radii[j], 0.0, 0.0
    for wave in c.waves:
        on = wave[0]
        if on == side or (on == ROLLER and (wave[1] < 0 or wave[1] == j)):
            phase = wave[2] * (roller if on == ROLLER else race) - wave[5]
            height += wave[3 + side] * np.cos(phase)
            slope = -wave[3 + side] * wave[2] * np.sin(phase)
            if on == ROLLER:
                at_roller += slope
            else:
                at_race += slope
    v += at_race * race_rate + at_roller * roller_rate
    force, by_race, by_roller, mean = 0.0, 0.0, 0.0, 0.0
    for g in range(groups(b, c, j, side, race, roller, race_rate, roller_rate, out)):
        approach = delta + height - out[g, 1]
        part = out[g, 0] * normal_force(c.laws[side], c.damping, approach, v - out[g, 2])
        force += part
        by_race += part * (at_race - out[g, 3])
        by_roller += part * (at_roller - out[g, 4])
        mean += out[g, 0] * max(approach, 0.0)
    return force, by_race, by_roller, mean


@njit
def rest_forces(b, c, u, turns, centrifugal, out, q, forces):
    """Balance of each roller by bisection with the ring at u; the net force of the rollers on the ring (M12).

    turns: angles of cage, inner ring and rollers beyond those at t = 0.
    """
    total = 0j
    for j in range(b.Z):
        theta = b.theta_0 + turns[0] + 2 * np.pi * j / b.Z
        e = np.exp(1j * theta)
        shift = (u * np.conj(e)).real
        low, high = -4e-4, 4e-4
        for _ in range(46):
            q[j] = 0.5 * (low + high)
            forces[0, j] = contact(b, c, j, 0, theta, turns[2], 0.0, 0.0, q[j] - shift - b.gap, 0.0, out)[0]
            race, roller = theta - turns[1], turns[2] + np.pi
            forces[1, j] = contact(b, c, j, 1, race, roller, 0.0, 0.0, -q[j] - b.gap, 0.0, out)[0]
            if forces[0, j] - forces[1, j] > centrifugal * (b.r_m + q[j]):
                high = q[j]
            else:
                low = q[j]
        total += forces[0, j] * e
    return total


@njit
def rollers_rates(t, y, b, c, s, dy, out, forces):
    """(M7) and (M8). y: u, its rate, q and its rate of each roller."""
    omega_c = b.omega_i * (1 - b.gamma) / 2
    omega_b = b.omega_i * (1 - b.gamma**2) / (2 * b.gamma)
    u, w = complex(y[0], y[1]), complex(y[2], y[3])
    total = -b.load - b.k_b * (u - b.anchor) - b.c_b * w
    for j in range(b.Z):
        q, rate, theta = y[4 + 2 * j], y[5 + 2 * j], b.theta_0 + omega_c * t + 2 * np.pi * j / b.Z
        e, spun = np.exp(1j * theta), omega_b * t
        delta = q - (u * np.conj(e)).real - b.gap
        v = rate - (w * np.conj(e)).real - omega_c * (u * np.conj(e)).imag
        forces[0, j] = contact(b, c, j, 0, theta, spun, omega_c, omega_b, delta, v, out)[0]
        race, speed = theta - b.omega_i * t, omega_c - b.omega_i
        forces[1, j] = contact(b, c, j, 1, race, spun + np.pi, speed, omega_b, -b.gap - q, -rate, out)[0]
        dy[4 + 2 * j] = rate
        dy[5 + 2 * j] = omega_c**2 * (b.r_m + q) + (forces[1, j] - forces[0, j]) / b.m_r
        total += forces[0, j] * e
    dy[0], dy[1], dy[2], dy[3] = y[2], y[3], total.real / b.m_o, total.imag / b.m_o


@njit
def march(rates, t, y, h, steps, every, b, c, s):
    """Classical Runge-Kutta steps; the state and the forces at every ``every``-th, (samples, state + 5 Z)."""
    n, out, forces = len(y), np.zeros((MAX_GROUPS, 5)), np.zeros((5, b.Z))
    k, record = np.zeros((4, n)), np.zeros((steps // every + 1, n + 5 * b.Z))
    for i in range(steps + 1):
        rates(t + i * h, y, b, c, s, k[0], out, forces)
        if i % every == 0:
            record[i // every, :n] = y
            record[i // every, n:] = forces.ravel()
        rates(t + (i + 0.5) * h, y + 0.5 * h * k[0], b, c, s, k[1], out, forces)
        rates(t + (i + 0.5) * h, y + 0.5 * h * k[1], b, c, s, k[2], out, forces)
        rates(t + (i + 1.0) * h, y + h * k[2], b, c, s, k[3], out, forces)
        y = y + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
    return record
