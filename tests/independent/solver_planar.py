"""An independent solution of `planar`, written from docs/planar.md (P), form.md (F) and nothing else.

Angles are absolute, vectors of the plane complex: x + iy, x along e_0. Friction has no lag: the Runge-Kutta steps
of ``solver.march`` resolve its decay (P7). SI throughout.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from tests.independent.solver import contact


class Friction(NamedTuple):
    """Friction curve: static, dynamic and their speeds, or (traction) a, b, c, d."""

    traction: bool
    a: float
    b: float
    c: float
    d: float


class Planar(NamedTuple):
    """Bodies and laws beyond those of `rollers`; guide: 0 centred, 1 on rollers, 2 on outer, 3 on inner ring."""

    omega_end: float
    ramp: float
    friction: Friction
    cage_friction: Friction
    m_c: float
    I_c: float
    pocket: tuple  # half gap, stiffness, chi, half radial gap
    guide: int
    play: float
    land: float
    drag: float
    film: float
    film_inner: bool
    gravity: float
    shaft: tuple  # k, m, c; m = 0: rigid
    unbalance: complex
    torsion: tuple  # k, c, I; I = 0: the ring does not turn


@njit
def friction(f, slip, speed):
    """Coefficient of friction, odd in the slip (planar.md, Slip and friction); speed: U of traction."""
    v = abs(slip)
    if f.traction:
        mu = (f.a + f.b * v / speed) * np.exp(-f.c * v / speed) + f.d if v > 0.0 else 0.0
    else:
        rise, fall = min(v / f.c, 1.0), min(max((v - f.c) / (f.d - f.c), 0.0), 1.0)
        mu = f.a * rise * (3 - rise**2) / 2 - (f.a - f.b) * fall**2 * (3 - 2 * fall)
    return np.copysign(mu, slip)


@njit
def dot(a, b):
    return (a * np.conj(b)).real


@njit
def shaft_motion(t, b, s):
    """Angle, speed and acceleration of the inner ring."""
    if t < s.ramp:
        a = (s.omega_end - b.omega_i) / s.ramp
        return t * (b.omega_i + 0.5 * a * t), b.omega_i + a * t, a
    return s.ramp * (b.omega_i - s.omega_end) / 2 + s.omega_end * t, s.omega_end, 0.0


@njit
def planar_rates(t, y, b, c, s, dy, out, forces):
    """(P2) to (P6), (P10), (P11), (F2).

    y: u, du, psi, dpsi, cage angle and speed, centre and velocity of cage and inner ring, then q, dq, theta,
    dtheta, beta, dbeta of each roller; forces: (5, Z) of the races, slips at them, of the pocket.
    """
    theta_i, omega_i, _ = shaft_motion(t, b, s)
    centre = (complex(y[0], y[1]), complex(y[12], y[13]))
    velocity = (complex(y[2], y[3]), complex(y[14], y[15]))
    turn, speed = (y[4], theta_i), (y[5], omega_i)
    cage, w_cage, cage_speed = complex(y[8], y[9]), complex(y[10], y[11]), y[7]
    on_ring = [-b.load - b.k_b * (centre[0] - b.anchor) - b.c_b * velocity[0], b.load + 0j]
    torques = [0.0, 0.0]
    on_cage, cage_torque = s.gravity * s.m_c + 0j, 0.0
    for j in range(b.Z):
        k = 16 + 6 * j
        q, dq, theta, dtheta, beta, dbeta = y[k], y[k + 1], y[k + 2], y[k + 3], y[k + 4], y[k + 5]
        e, r = np.exp(1j * theta), b.r_m + q
        p, w = r * e, (dq + 1j * r * dtheta) * e
        force, torque = s.gravity * b.m_r - s.drag * r * dtheta * abs(r * dtheta) * 1j * e, 0.0
        for side in range(2):
            sign = 1 - 2 * side
            d, rate = p - centre[side], w - velocity[side]
            rho = abs(d)
            n = d / rho
            tau = 1j * n
            angle = theta + np.angle(n * np.conj(e))
            turning = dot(tau, rate) / rho
            delta = sign * (rho - b.radius[side]) + b.R_w
            normal, by_race, by_roller, approach = contact(
                b, c, j, side, angle - turn[side], angle + side * np.pi - beta,
                turning - speed[side], turning - dbeta, delta, sign * dot(n, rate), out,
            )  # fmt: skip
            across = -(by_race + by_roller) / rho
            part = -sign * normal * n + across * tau
            torques[side] += by_race
            torque += by_roller
            forces[side, j], forces[2 + side, j] = normal, 0.0
            if normal > 0.0:
                tilt = np.arctan(across / normal)
                arm, along = b.R_w - 0.5 * approach, tau * np.cos(tilt) + sign * n * np.sin(tilt)
                slip = dot(along, rate) + sign * dbeta * arm - speed[side] * (rho * np.cos(tilt) + sign * arm)
                shear = -friction(s.friction, slip, b.R_w * abs(dtheta - dbeta)) * normal
                part += shear * along
                torque += sign * shear * arm
                torques[side] -= shear * (rho * np.cos(tilt) + sign * arm)
                forces[2 + side, j] = slip
            force += part
            on_ring[side] -= part
        push, spin, back = pocket_force(b, s, p - cage, w - w_cage, y[6] + 2 * np.pi * j / b.Z, cage_speed, dbeta)
        forces[4, j] = -dot(push, 1j * np.exp(1j * (y[6] + 2 * np.pi * j / b.Z)))
        force, torque, on_cage, cage_torque = force + push, torque + spin, on_cage - push, cage_torque + back
        radial, tangential = dot(force, e), dot(force, 1j * e)
        dy[k], dy[k + 2], dy[k + 4] = dq, dtheta, dbeta
        dy[k + 1] = r * dtheta**2 + radial / b.m_r
        dy[k + 3] = (tangential / b.m_r - 2 * dq * dtheta) / r
        dy[k + 5] = torque / b.I_r
    body_rates(t, y, dy, b, s, on_ring, torques, on_cage, cage_torque)


@njit
def body_rates(t, y, dy, b, s, on_ring, torques, on_cage, cage_torque):
    """(P2), (P3), (P10), (P11): rates of rings and cage under the forces and moments of the rollers.

    on_ring, torques: of the outer and inner ring.
    """
    theta_i, omega_i, alpha_i = shaft_motion(t, b, s)
    centre = (complex(y[0], y[1]), complex(y[12], y[13]))
    velocity = (complex(y[2], y[3]), complex(y[14], y[15]))
    cage, w_cage, cage_speed, speed = complex(y[8], y[9]), complex(y[10], y[11]), y[7], (y[5], omega_i)
    cage_torque += s.film * ((omega_i if s.film_inner else 0.0) - cage_speed)
    if s.guide >= 2:
        side = s.guide - 2
        guided = land_force(s, cage - centre[side], w_cage - velocity[side], cage_speed, speed[side], 1 - 2 * side)
        on_cage, cage_torque = on_cage + guided[0], cage_torque + guided[1]
        on_ring[side] -= guided[0]
        torques[side] -= guided[2]
    k_i, m_i, c_i = s.shaft
    turned = s.unbalance * np.exp(1j * theta_i)
    on_inner = on_ring[1] - k_i * centre[1] - c_i * velocity[1] + turned * (omega_i**2 - 1j * alpha_i)
    dy[0:16] = 0.0
    dy[0], dy[1], dy[6] = y[2], y[3], y[7]
    dy[2], dy[3] = on_ring[0].real / b.m_o, on_ring[0].imag / b.m_o
    dy[7] = cage_torque / s.I_c
    if s.torsion[2] > 0.0:
        dy[4], dy[5] = y[5], (torques[0] - s.torsion[0] * y[4] - s.torsion[1] * y[5]) / s.torsion[2]
    if s.guide > 0:
        dy[8], dy[9], dy[10], dy[11] = y[10], y[11], on_cage.real / s.m_c, on_cage.imag / s.m_c
    if m_i > 0.0:
        dy[12], dy[13], dy[14], dy[15] = y[14], y[15], on_inner.real / m_i, on_inner.imag / m_i


@njit
def pocket_force(b, s, d, rate, angle, cage_speed, dbeta):
    """Force and torque of a pocket on its roller, torque on the cage (P10). d: from the cage's centre."""
    e = np.exp(1j * angle)
    radial, across = dot(d, e), dot(d, 1j * e)
    force, torque, arm = 0j, 0.0, d
    side = np.copysign(1.0, across)
    gap = abs(across) - s.pocket[0]
    if gap > 0.0:
        closing = side * (dot(rate, 1j * e) - cage_speed * radial)
        normal = max(0.0, s.pocket[1] * gap * (1.0 + s.pocket[2] * closing))
        slip = dot(rate, e) - dbeta * b.R_w * side + cage_speed * (across + b.R_w * side)
        shear = -friction(s.cage_friction, slip, 1.0) * normal
        force, torque = -side * normal * 1j * e + shear * e, -side * b.R_w * shear
        arm = d + side * b.R_w * 1j * e
    back = -(np.conj(arm) * force).imag
    outward = radial - b.r_m
    gap = abs(outward) - s.pocket[3]
    if s.guide == 1 and gap > 0.0:
        side = np.copysign(1.0, outward)
        closing = side * (dot(rate, e) + cage_speed * across)
        stop = -side * max(0.0, s.pocket[1] * gap * (1.0 + s.pocket[2] * closing)) * e
        force, back = force + stop, back - (np.conj(d) * stop).imag
    return force, torque, back


@njit
def land_force(s, d, rate, cage_speed, ring_speed, sign):
    """Force and torque of a land on the cage, of the radius ``s.land``, and torque taken from the ring.

    d: from the ring's centre.
    """
    distance = abs(d)
    if distance <= s.play:
        return 0j, 0.0, 0.0
    n = d / distance
    closing = dot(rate, n)
    normal = max(0.0, s.pocket[1] * (distance - s.play) * (1.0 + s.pocket[2] * closing))
    arm = sign * s.land
    ring_arm = arm + distance
    slip = dot(rate, 1j * n) + cage_speed * arm - ring_speed * ring_arm
    shear = -friction(s.cage_friction, slip, 1.0) * normal
    return -normal * n + shear * 1j * n, arm * shear, ring_arm * shear
