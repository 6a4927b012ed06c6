"""Contacts of the independent solution of `planar`: rollers against races, defects and cage."""

from typing import NamedTuple

import numpy as np

from tests.independent.planar_scene import OUTER, path_depth_and_slope


def direction(angle):
    return np.exp(1j * angle)


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


def cross(a, b):
    return a.real * b.imag - a.imag * b.real


class Sinking(NamedTuple):
    """Effect of defects at a race, all (Z,). position_derivative: dh/dbeta, beta: roller angle about the race."""

    depth: np.ndarray
    rate: np.ndarray
    position_derivative: np.ndarray
    race_torque: np.ndarray  # dh/d(race angle) and dh/d(roller angle): what turns by the defect
    roller_torque: np.ndarray


def sinking(scene, side, beta, beta_rate, race, roller):
    """``race`` and ``roller``: (angle, speed) of the bodies that may carry a defect."""
    result = Sinking(*np.zeros((5, scene.Z)))
    for defect in scene.defects:
        on_race = defect.on == side
        if not on_race and not isinstance(defect.on, tuple):
            continue
        R_s = scene.radius(side) if on_race else scene.R_w
        carrier, speed = race if on_race else roller
        phase = 0.0 if on_race or side == OUTER else np.pi  # the inner race is met half a turn later
        s = R_s * wrap_angle(beta + phase - carrier - defect.angle)
        is_near = np.abs(s) < defect.width / 2
        if not on_race:
            is_near &= np.arange(scene.Z) == defect.on[1]
        for j in np.flatnonzero(is_near):
            h, slope = path_depth_and_slope(s[j], defect.width, defect.depth, scene.reduced(side))
            result.depth[j] += h
            result.rate[j] += slope * R_s * (beta_rate - speed)[j]
            result.position_derivative[j] += slope * R_s
            (result.race_torque if on_race else result.roller_torque)[j] -= slope * R_s
    return result


def wrap_angle(angle):
    return np.remainder(angle + np.pi, 2 * np.pi) - np.pi


class Contact(NamedTuple):
    """One race against all rollers. Forces act on the rollers; their opposite and ``race_torque`` on the race."""

    force: np.ndarray
    torque: np.ndarray
    race_torque: np.ndarray
    Q: np.ndarray
    slip: np.ndarray
    stored: float
    damped: float
    rubbed: float


def race_contact(scene, side, centre, velocity, race, c, v, roller):
    """``race`` and ``roller``: (angle, speed) of the race and of the rollers."""
    offset, relative = c - centre, v - velocity
    rho = np.abs(offset)
    n = offset / rho
    tau = 1j * n
    beta_rate = dot(relative, tau) / rho
    defects = sinking(scene, side, np.angle(offset), beta_rate, race, roller)
    delta = scene.R_w + side * (rho - scene.radius(side)) - defects.depth
    rate = side * dot(relative, n) - defects.rate
    elastic = scene.elastic.force(delta)
    Q = elastic + np.where(delta > 0.0, scene.damping(elastic, rate), 0.0)
    Q = np.maximum(Q, 0.0) if scene.clamp else Q
    gradient = side * n - defects.position_derivative / rho * tau  # of delta, by the roller's place
    arm = (scene.R_w - delta / 2) * (gradient / np.abs(gradient) if scene.friction_tilts else side * n)
    tangent = 1j * side * arm / np.abs(arm)
    slip = dot(relative + 1j * roller[1] * arm - 1j * race[1] * (offset + arm), tangent)
    friction = -scene.friction(slip) * Q
    return Contact(
        force=-Q * gradient + friction * tangent,
        torque=friction * cross(arm, tangent) + Q * defects.roller_torque,
        race_torque=-friction * cross(offset + arm, tangent) + Q * defects.race_torque,
        Q=Q,
        slip=slip,
        stored=np.sum(scene.elastic.energy(delta)),
        damped=np.sum((Q - elastic) * rate),
        rubbed=-np.sum(friction * slip),
    )


class Pocket(NamedTuple):
    """The cage against all rollers. Forces act on the rollers; their opposite and ``cage_torque`` on the cage."""

    force: np.ndarray
    torque: np.ndarray
    cage_torque: np.ndarray
    N: np.ndarray  # along e_theta, on the roller
    stored: float
    damped: float
    rubbed: float


def pocket_contact(scene, centre, velocity, cage, c, v, roller_speed):
    """``cage``: (angle, speed). The walls are straight, clearance/2 from a roller in the pocket's middle."""
    e_r = direction(cage[0] + scene.pockets)
    e_theta = 1j * e_r
    from_cage, relative = c - centre, v - velocity
    across, along = dot(from_cage, e_theta), dot(from_cage, e_r)
    across_rate = dot(relative, e_theta) - cage[1] * along
    side = np.sign(across)
    compression = np.maximum(np.abs(across) - scene.pocket_clearance / 2, 0.0)
    elastic = scene.pocket_stiffness * compression
    N = np.maximum(elastic * (1.0 + scene.pocket_chi * side * across_rate), 0.0)
    arm = side * (scene.R_w - compression / 2)
    slip = dot(relative, e_r) - roller_speed * arm + cage[1] * (across + arm)
    friction = -scene.pocket_friction(slip) * N
    return Pocket(
        force=-side * N * e_theta + friction * e_r,
        torque=-friction * arm,
        cage_torque=side * N * along + friction * (across + arm),
        N=-side * N,
        stored=np.sum(scene.pocket_stiffness * compression**2) / 2,
        damped=np.sum((N - elastic) * side * across_rate),
        rubbed=-np.sum(friction * slip),
    )
