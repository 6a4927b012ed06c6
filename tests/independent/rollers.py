"""An independent solution of `rollers`, from the equations of docs/model.md, sharing no code with the package.

Radial positions of rollers relative to R_O - R_W, the defect's envelope by brute-force minimisation over a grid of
contact points, the static start by SciPy's root finder, time integration by SciPy's DOP853 at tight tolerance and
small steps. NF308, 1800 rpm, 150 N, clearance 0, one full-length box: on the outer race, on the inner race
(rotating with it), or on the first roller. Without slip, the contacts move along both races and the rollers at one
speed.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from tests.independent.planar_scene import path_depth_and_slope

Z, D_W, D_M, L_W = 13, 0.012, 0.065, 0.012
R_W, R_O, R_I = D_W / 2, (D_M + D_W) / 2, (D_M - D_W) / 2
OMEGA_C = 2 * np.pi * 30 * (1 - D_W / D_M) / 2
M_R = 7850 * np.pi * R_W**2 * L_W
M_O = 7850 * np.pi * (0.045**2 - R_O**2) * 0.023
K = 8.06e4 * 12 ** (8 / 9) * 1000 ** (10 / 9)
CHI, K_B, C_B, LOAD = 50.0, 1e7, 200.0, 150.0
THETA = np.pi / Z + 2 * np.pi * np.arange(Z) / Z
OMEGA_I = 2 * np.pi * 30
REDUCED_O, REDUCED_I = 1 / (1 / R_W - 1 / R_O), 1 / (1 / R_W + 1 / R_I)


def elastic(delta):
    return K * np.maximum(delta, 0.0) ** (10 / 9)


def roller_at_rest(u_r):
    """Equilibrium radial position (m) of a roller between the races, with the outer ring displaced by u_r."""

    def inward(r):
        return elastic(r + R_W - R_O - u_r) - elastic(R_I + R_W - r) - M_R * OMEGA_C**2 * r

    contact_radius = R_O - R_W + u_r
    return brentq(inward, contact_radius, max(contact_radius, R_I + R_W) + 1e-5, xtol=1e-19, rtol=1e-14)


def wrap_angle(angle):
    return np.remainder(angle + np.pi, 2 * np.pi) - np.pi


def defect_distances(race, angle, t):
    """Arc distances (m) of the contacts from the defect's middle, (Z,) outer and inner, and their rate (m/s).

    Contacts that cannot meet the defect get a distance of 1 m. At t = 0 the defect is at ``angle`` from the load
    line, or from the outermost point of the first roller, which turns backwards in the cage.
    """
    no_defect, theta, speed = np.ones(Z), THETA + OMEGA_C * t, R_O * OMEGA_C
    if race == "outer":
        return R_O * wrap_angle(theta - angle), no_defect, speed
    if race == "inner":
        return no_defect, -R_I * wrap_angle(theta - angle - OMEGA_I * t), speed
    on_first = np.where(np.arange(Z) == 0, 0.0, 1.0)
    roller_angle = angle - speed / R_W * t
    return on_first - R_W * wrap_angle(roller_angle), on_first - R_W * wrap_angle(roller_angle - np.pi), speed


def static_state(angles, stiffness, anchor):
    """Static displacement of the ring and radial positions of the rollers, without defect.

    stiffness, anchor: bracket spring.
    """

    def net(microns):
        u = 1e-6 * microns
        total = np.array([-LOAD, 0.0]) - stiffness * (u - anchor)
        for a in angles:
            e_r = np.array([np.cos(a), np.sin(a)])
            total += elastic(roller_at_rest(u @ e_r) + R_W - R_O - u @ e_r) * e_r
        return total / LOAD

    solution = root(net, [-0.4, 0.0], tol=1e-12)
    assert np.abs(solution.fun).max() < 1e-7
    u = 1e-6 * solution.x
    return u, np.array([roller_at_rest(u[0] * np.cos(a) + u[1] * np.sin(a)) for a in angles])


def path_depths_and_rates(arcs, speed, width, depth, reduced):
    """Path depth (m) of each roller in the defect and its rate (m/s), (Z,) each."""
    h, rates = np.zeros(Z), np.zeros(Z)
    for j in np.flatnonzero(np.abs(arcs) < width / 2):
        h[j], slope = path_depth_and_slope(arcs[j], width, depth, reduced)
        rates[j] = slope * speed
    return h, rates


def simulate(width, depth, times, race="outer", angle=0.0, max_step=1e-6, rtol=1e-9):
    """Velocity of the ring (2, n) in m/s at ``times`` (s), with a defect as in ``defect_distances``."""
    pass_angle = 2 * np.pi / Z
    phases = [THETA + pass_angle * (n + 0.5) / 16 for n in range(16)]
    anchor = np.mean([static_state(angles, 0.0, np.zeros(2))[0] for angles in phases], axis=0)
    u, r = static_state(THETA, K_B, anchor)

    def rhs(t, y):
        u, w, q, v = y[:2], y[2:4], y[4 : 4 + Z], y[4 + Z :]
        theta = THETA + OMEGA_C * t
        c, s = np.cos(theta), np.sin(theta)
        outer, inner, speed = defect_distances(race, angle, t)
        h_o, rate_o = path_depths_and_rates(outer, speed, width, depth, REDUCED_O)
        h_i, rate_i = path_depths_and_rates(inner, speed, width, depth, REDUCED_I)
        delta_o = q - (u[0] * c + u[1] * s) - h_o
        v_o = v - (w[0] * c + w[1] * s) - OMEGA_C * (u[1] * c - u[0] * s) - rate_o
        force_o = np.maximum(elastic(delta_o) * (1 + CHI * v_o), 0.0)
        force_i = np.maximum(elastic(-q - h_i) * (1 - CHI * (v + rate_i)), 0.0)
        radial = OMEGA_C**2 * (R_O - R_W + q) + (force_i - force_o) / M_R
        a_x = (-LOAD - K_B * (u[0] - anchor[0]) - C_B * w[0] + force_o @ c) / M_O
        a_y = (-K_B * (u[1] - anchor[1]) - C_B * w[1] + force_o @ s) / M_O
        return np.concatenate([w, [a_x, a_y], v, radial])

    y0 = np.concatenate([u, [0.0, 0.0], r - (R_O - R_W), np.zeros(Z)])
    scale = np.concatenate([[1e-7] * 2, [1e-4] * 2, [1e-7] * Z, [1e-3] * Z])
    out = solve_ivp(rhs, (0.0, times[-1]), y0, "DOP853", times, rtol=rtol, atol=rtol * scale, max_step=max_step)
    assert out.success, out.message
    return out.y[2:4]
