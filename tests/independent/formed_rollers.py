"""An independent solution of `rollers` and `static` with form, from docs/form.md.

It shares no code with the package. NF308 as in ``rollers``. Heights are summed order by order at each contact,
without a table; the ring and the rollers are at rest at each instant by bisection and SciPy's root finder, or move
by fourth-order Runge-Kutta steps. A slot in the outer race, if any, is so deep that a roller rests on its rims
only: h = (w/2 - |s|)^2/(2 R).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import quad
from scipy.optimize import root

from tests.independent.rollers import (
    C_B,
    CHI,
    D_M,
    D_W,
    K_B,
    L_W,
    M_O,
    M_R,
    OMEGA_C,
    OMEGA_I,
    R_I,
    R_O,
    R_W,
    REDUCED_O,
    K,
    Z,
)

OMEGA_B = OMEGA_I * (1 - (D_W / D_M) ** 2) / (2 * D_W / D_M)
E_STAR = 207e9 / (2 * (1 - 0.3**2))
OUTER, INNER, ROLLER = 0, 1, 2


class Scene(NamedTuple):
    """Clearance (m), load (N), waves, diameters (Z,) of the rollers less the nominal one (m), width of a slot (m).

    waves: rows of element (OUTER, INNER or ROLLER), order, amplitude (m), phase (rad), roller or -1; the slot is
    on the outer race.
    """

    clearance: float = 0.0
    load: float = 150.0
    waves: np.ndarray = np.zeros((0, 5))
    diameters: np.ndarray = np.zeros(Z)
    slot: float = 0.0


def averaged(k, half_width):
    """Part of a wave k (1/m) that acts on a line contact: its mean weighted by 1/(pi sqrt(b^2 - x^2))."""
    return quad(lambda angle: np.cos(k * half_width * np.cos(angle)), 0.0, np.pi)[0] / np.pi


def with_contact_average(scene, load):
    """The scene with its waves averaged over the contacts under the largest force (N) of the outer race."""
    waves, inner_load = scene.waves.copy(), load - M_R * OMEGA_C**2 * D_M / 2
    outer, inner = (
        np.sqrt(4 * force / L_W * R_W * R / (R - sign * R_W) / (np.pi * E_STAR))
        for force, R, sign in ((load, R_O, 1), (inner_load, R_I, -1))
    )
    for wave in waves:
        radius, b = ((R_O, outer), (R_I, inner), (R_W, (outer + inner) / 2))[int(wave[0])]
        wave[2] *= averaged(wave[1] / radius, b)
    return scene._replace(waves=waves)


@njit
def heights(waves, diameters, t):
    """Heights at the outer and inner contact of each roller (Z,), m, and their rates, m/s."""
    w_o, w_i, v_o, v_i = np.zeros(Z), np.zeros(Z), np.zeros(Z), np.zeros(Z)
    for j in range(Z):
        angle = np.pi / Z + 2 * np.pi * j / Z + OMEGA_C * t
        w_o[j], w_i[j] = diameters[j] / 2, diameters[j] / 2
        for n in range(len(waves)):
            element, order, a, phase, roller = waves[n]
            if element == OUTER:
                x = order * angle - phase
                w_o[j] += a * np.cos(x)
                v_o[j] -= a * order * OMEGA_C * np.sin(x)
            elif element == INNER:
                x = order * (angle - OMEGA_I * t) - phase
                w_i[j] += a * np.cos(x)
                v_i[j] -= a * order * (OMEGA_C - OMEGA_I) * np.sin(x)
            elif roller == -1 or roller == j:
                x = order * OMEGA_B * t - phase
                w_o[j] += a * np.cos(x)
                v_o[j] -= a * order * OMEGA_B * np.sin(x)
                w_i[j] += a * np.cos(x + order * np.pi)
                v_i[j] -= a * order * OMEGA_B * np.sin(x + order * np.pi)
    return w_o, w_i, v_o, v_i


@njit
def slot_drops(slot, t):
    """Drop of each roller into the slot at the load line (Z,), m, and its rate, m/s."""
    h, v = np.zeros(Z), np.zeros(Z)
    for j in range(Z):
        angle = np.pi / Z + 2 * np.pi * j / Z + OMEGA_C * t
        s = R_O * (angle - 2 * np.pi * np.floor(angle / (2 * np.pi) + 0.5))
        x = slot / 2 - abs(s)
        if x > 0.0:
            h[j] = x * x / (2 * REDUCED_O)
            v[j] = -np.sign(s) * x / REDUCED_O * R_O * OMEGA_C
    return h, v


@njit
def elastic(delta):
    return K * max(delta, 0.0) ** (10 / 9)


@njit
def positions(u_r, w_o, w_i, gap):
    """Positions (Z,), m, of the rollers in balance with the race displaced by u_r (Z,), by bisection."""
    q = np.zeros(Z)
    for j in range(Z):
        low = u_r[j] + gap - w_o[j]
        high = low + 1e-4
        for _ in range(200):
            middle = 0.5 * (low + high)
            inward = elastic(middle - u_r[j] - gap + w_o[j]) - elastic(-gap - middle + w_i[j])
            if inward > M_R * OMEGA_C**2 * (D_M / 2 + middle):
                high = middle
            else:
                low = middle
        q[j] = 0.5 * (low + high)
    return q


def at_rest(scene, t, stiffness=0.0, anchor=0j, guess=-0.4):
    """Return the equilibrium at ``t``: ring (complex, m) and rollers (Z,), m; stiffness: of the bracket, N/m."""
    w_o, w_i, _, _ = heights(scene.waves, scene.diameters, t)
    w_o = w_o - slot_drops(scene.slot, t)[0]
    direction = np.exp(1j * (np.pi / Z + 2 * np.pi * np.arange(Z) / Z + OMEGA_C * t))
    gap = scene.clearance / 4

    def balance(microns):
        u = 1e-6 * complex(*microns)
        u_r = (np.conj(u) * direction).real
        q = positions(u_r, w_o, w_i, gap)
        force = sum(elastic(d) * e for d, e in zip(q - u_r - gap + w_o, direction, strict=True))
        net = (force - scene.load - stiffness * (u - anchor)) / scene.load
        return [net.real, net.imag]

    solution = root(balance, [guess, 0.0], tol=1e-13)
    assert np.abs(solution.fun).max() < 1e-6, solution.message
    u = 1e-6 * complex(*solution.x)
    return u, positions((np.conj(u) * direction).real, w_o, w_i, gap)


def anchor_of(scene, count=377, generator=233):
    """Return the mean position (complex, m) of the ring without slot and bracket, over angles of cage and shaft.

    Of ``count`` cage angles spread evenly over a turn, each has the shaft turned by ``generator``/``count`` of a
    turn more than the one before, and the rollers by 0.414 (two Fibonacci numbers give an even cover).
    """
    formed = scene._replace(slot=0.0)
    guess = -0.4 - 1e6 * max(scene.clearance, 0.0) / 2
    places = []
    for n in range(count):
        t, waves = n / count * 2 * np.pi / OMEGA_C, scene.waves.copy()
        for wave in waves:
            turned = {OUTER: 0.0, INNER: 2 * np.pi * generator * n / count - OMEGA_I * t}
            wave[3] += wave[1] * turned.get(int(wave[0]), 2 * np.pi * 2**0.5 * n)
        places.append(at_rest(formed._replace(waves=waves), t, guess=guess)[0])
    return np.mean(places)


@njit
def slope(state, t, clearance, load, waves, diameters, slot, anchor):
    """Derivative of the state: u, u', q (Z,), q' (Z,)."""
    gap, out = clearance / 4, np.zeros(len(state))
    w_o, w_i, v_o, v_i = heights(waves, diameters, t)
    h, h_v = slot_drops(slot, t)
    a_x = -load - K_B * (state[0] - anchor.real) - C_B * state[2]
    a_y = -K_B * (state[1] - anchor.imag) - C_B * state[3]
    for j in range(Z):
        angle = np.pi / Z + 2 * np.pi * j / Z + OMEGA_C * t
        c, s = np.cos(angle), np.sin(angle)
        q, v = state[4 + j], state[4 + Z + j]
        delta = q - state[0] * c - state[1] * s - gap + w_o[j] - h[j]
        rate = v - state[2] * c - state[3] * s - OMEGA_C * (state[1] * c - state[0] * s) + v_o[j] - h_v[j]
        Q_o = max(elastic(delta) * (1 + CHI * rate), 0.0)
        Q_i = max(elastic(-gap - q + w_i[j]) * (1 + CHI * (v_i[j] - v)), 0.0)
        a_x, a_y = a_x + Q_o * c, a_y + Q_o * s
        out[4 + j], out[4 + Z + j] = v, OMEGA_C**2 * (D_M / 2 + q) + (Q_i - Q_o) / M_R
    out[0], out[1], out[2], out[3] = state[2], state[3], a_x / M_O, a_y / M_O
    return out


@njit
def march(state, h, steps, stride, clearance, load, waves, diameters, slot, anchor):
    """Velocity of the ring along the load every ``stride`` steps of length ``h`` (s)."""
    velocity = np.zeros(steps // stride)
    for n in range(steps):
        t = n * h
        k_1 = slope(state, t, clearance, load, waves, diameters, slot, anchor)
        k_2 = slope(state + h / 2 * k_1, t + h / 2, clearance, load, waves, diameters, slot, anchor)
        k_3 = slope(state + h / 2 * k_2, t + h / 2, clearance, load, waves, diameters, slot, anchor)
        k_4 = slope(state + h * k_3, t + h, clearance, load, waves, diameters, slot, anchor)
        state = state + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        if (n + 1) % stride == 0:
            velocity[n // stride] = state[2]
    return velocity


def simulate(scene, h, steps, stride):
    """Velocity of the ring along the load (m/s) every ``stride`` of ``steps`` steps ``h`` (s), from rest."""
    anchor = anchor_of(scene)
    u, q = at_rest(scene, 0.0, K_B, anchor, guess=1e6 * anchor.real)
    state = np.concatenate([[u.real, u.imag, 0.0, 0.0], q, np.zeros(Z)])
    return march(
        state, h, steps, stride, scene.clearance, scene.load, scene.waves, scene.diameters, scene.slot, anchor
    )
