"""An independent solution of `planar`, from mechanics, sharing no code with the package.

Every body has absolute Cartesian coordinates: outer ring (x, y, rotation), Z rollers (x, y, rotation), cage (x, y,
rotation); the inner ring turns as prescribed about the origin. Contact forces are gradients of the approach, the
defect's envelope is a brute-force minimum over contact points, the static start comes from SciPy's root finders,
time from SciPy's DOP853. Works and losses are integrated beside the motion.

SI throughout. A vector of the plane is a complex number: x + iy, turned by +90 deg is i times it. n points from a
race's centre to the roller's centre at rho n, tau = i n. The side is +1 at the outer and -1 at the inner race:

    delta = R_w + side (rho - R) - h          contact point at the roller's centre + side (R_w - delta/2) n

Not here: short defects, tilt, a film, a moving inner ring, a guided cage.

``python -m tests.independent.planar`` writes tests/data/reference_planar.npz:
the SCENES over 20 ms, for comparison.
"""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from tests.independent.planar_contacts import (
    Contact,
    Pocket,
    cross,
    direction,
    dot,
    pocket_contact,
    race_contact,
    sinking,
    wrap_angle,
)
from tests.independent.planar_scene import INNER, OUTER, Defect, Scene, frictionless, static_dynamic


class Coordinates(NamedTuple):
    """Coordinates or their rates: centre and rotation of the ring, the rollers (Z,) and the cage."""

    ring: complex
    ring_angle: float
    rollers: np.ndarray
    roller_angles: np.ndarray
    cage: complex
    cage_angle: float


def unpack(y, Z):
    centres = y[: 4 + 2 * Z].view(complex)
    return Coordinates(centres[0], y[-2], centres[2:], y[4 + 2 * Z : -2], centres[1], y[-1])


def pack(p: Coordinates):
    centres = np.concatenate([[p.ring, p.cage], p.rollers]).astype(complex)
    return np.concatenate([centres.view(float), p.roller_angles, [p.ring_angle, p.cage_angle]])


LEDGER = ("drive", "load", "contact", "friction", "bracket", "drag")  # work put in by two, taken out by four


class Forces(NamedTuple):
    outer: Contact
    inner: Contact
    pocket: Pocket
    drag: np.ndarray  # on the rollers
    bracket: complex  # spring and damper, on the ring
    stored: float
    powers: np.ndarray  # in the order of LEDGER


def forces(scene, anchor, t, x: Coordinates, v: Coordinates) -> Forces:
    rollers = (x.roller_angles, v.roller_angles)
    ring, shaft = (x.ring_angle, v.ring_angle), (scene.speed * t, scene.speed)
    outer = race_contact(scene, OUTER, x.ring, v.ring, ring, x.rollers, v.rollers, rollers)
    inner = race_contact(scene, INNER, 0.0, 0.0, shaft, x.rollers, v.rollers, rollers)
    cage = (x.cage_angle, v.cage_angle)
    pocket = pocket_contact(scene, x.cage, v.cage, cage, x.rollers, v.rollers, v.roller_angles)
    e_theta = 1j * x.rollers / np.abs(x.rollers)
    tangential_speed = dot(v.rollers, e_theta)
    drag = -scene.roller_drag * np.abs(tangential_speed) * tangential_speed * e_theta
    spring = -scene.k_b * (x.ring - anchor)
    k_t, c_t = scene.torsion or (0.0, 0.0)
    bracket = scene.k_b * abs(x.ring - anchor) ** 2 / 2 + k_t * x.ring_angle**2 / 2
    powers = [
        -scene.speed * np.sum(inner.race_torque),
        -dot(scene.load, v.ring),
        outer.damped + inner.damped + pocket.damped,
        outer.rubbed + inner.rubbed + pocket.rubbed,
        scene.c_b * abs(v.ring) ** 2 + c_t * v.ring_angle**2,
        -np.sum(dot(drag, v.rollers)) + scene.cage_drag * v.cage_angle**2,
    ]
    stored = outer.stored + inner.stored + pocket.stored + bracket
    return Forces(outer, inner, pocket, drag, spring - scene.c_b * v.ring, stored, np.array(powers))


def accelerations(scene, f: Forces, x: Coordinates, v: Coordinates) -> Coordinates:
    k_t, c_t = scene.torsion or (0.0, 0.0)
    ring_torque = np.sum(f.outer.race_torque) - k_t * x.ring_angle - c_t * v.ring_angle
    cage_torque = np.sum(f.pocket.cage_torque) - scene.cage_drag * v.cage_angle
    return Coordinates(
        ring=(f.bracket - scene.load - np.sum(f.outer.force)) / scene.m_o,
        ring_angle=ring_torque / scene.ring_inertia if scene.torsion else 0.0,
        rollers=(f.outer.force + f.inner.force + f.pocket.force + f.drag) / scene.m_r,
        roller_angles=(f.outer.torque + f.inner.torque + f.pocket.torque) / scene.roller_inertia,
        cage=-np.sum(f.pocket.force) / scene.cage_mass if scene.cage_moves else 0.0,
        cage_angle=cage_torque / scene.cage_inertia,
    )


def kinetic(scene, v: Coordinates):
    ring = scene.m_o * abs(v.ring) ** 2 + scene.ring_inertia * v.ring_angle**2
    rollers = scene.m_r * np.sum(np.abs(v.rollers) ** 2) + scene.roller_inertia * np.sum(v.roller_angles**2)
    cage = scene.cage_mass * abs(v.cage) ** 2 + scene.cage_inertia * v.cage_angle**2
    return (ring + rollers + cage) / 2


def momentum_residual(scene, anchor, t, x: Coordinates, v: Coordinates):
    """Return the residual of inertia and external forces: force x, y, torque about the origin, and their scales.

    External: load, bracket, drag, and the shaft of the inner ring. All three vanish if the ring can rotate
    (``torsion``) and the cage can move.
    """
    f = forces(scene, anchor, t, x, v)
    a = accelerations(scene, f, x, v)
    k_t, c_t = scene.torsion
    external = f.bracket - scene.load + np.sum(f.drag + f.inner.force)
    inertia = scene.m_o * a.ring + scene.m_r * np.sum(a.rollers) + scene.cage_mass * a.cage
    # at the inner ring: what the shaft's torque must be, and force through its centre, without a moment
    torque = cross(x.ring, f.bracket - scene.load) - k_t * x.ring_angle - c_t * v.ring_angle
    torque += np.sum(cross(x.rollers, f.drag)) - scene.cage_drag * v.cage_angle - np.sum(f.inner.race_torque)
    spin_rate = scene.ring_inertia * a.ring_angle + scene.roller_inertia * a.roller_angles.sum()
    spin_rate += scene.cage_inertia * a.cage_angle
    orbit_rate = scene.m_o * cross(x.ring, a.ring) + scene.m_r * np.sum(cross(x.rollers, a.rollers))
    orbit_rate += scene.cage_mass * cross(x.cage, a.cage)
    scale = np.abs(f.outer.force).sum() + np.abs(f.inner.force).sum()
    residual = inertia - external
    return np.array([residual.real, residual.imag, spin_rate + orbit_rate - torque]), scale * np.array(
        [1.0, 1.0, scene.R_o]
    )


# --- the static start ------------------------------------------------------------


def static_approach(scene, side, centre, angle, r, j):
    """Return the approach of roller ``j`` at radius ``r``, ``angle`` at t = 0, and n.e_r."""
    e_r = direction(angle)
    offset = r * e_r - centre
    rho = abs(offset)
    drop = 0.0
    if scene.defects:
        angles, zeros = np.full(scene.Z, np.angle(offset)), np.zeros(scene.Z)
        drop = sinking(scene, side, angles, zeros, (zeros, zeros), (scene.angles, zeros)).depth[j]
    return scene.R_w + side * (rho - scene.radius(side)) - drop, dot(offset, e_r) / rho


def roller_at_rest(scene, u, angle, j):
    """Radius at which outer race, inner race and centrifugal load balance along e_r."""

    def outward(r):
        outer, along = static_approach(scene, OUTER, u, angle, r, j)
        inner, _ = static_approach(scene, INNER, 0.0, angle, r, j)
        held = scene.elastic.force(inner) - scene.elastic.force(outer) * along
        return held + scene.m_r * scene.orbit**2 * r

    low = scene.R_o - scene.R_w - 2e-4
    return brentq(outward, low, low + 1e-3, xtol=1e-18, rtol=1e-14)


def static_state(scene, angles, k_b, anchor):
    """Return ring position and roller radii (Z,) in equilibrium, with a bracket of ``k_b`` at ``anchor``."""

    def net(microns):
        u = 1e-6 * complex(*microns)
        total = -scene.load - k_b * (u - anchor)
        for j, angle in enumerate(angles):
            r = roller_at_rest(scene, u, angle, j)
            c = r * direction(angle)
            total += scene.elastic.force(static_approach(scene, OUTER, u, angle, r, j)[0]) * (c - u) / abs(c - u)
        return [total.real / abs(scene.load), total.imag / abs(scene.load)]

    guess = -(0.4 + 1e6 * scene.clearance / 2) * scene.load / abs(scene.load)
    solution = root(net, [guess.real, guess.imag], tol=1e-13)
    assert np.abs(solution.fun).max() < 1e-8, solution.message
    u = 1e-6 * complex(*solution.x)
    return u, np.array([roller_at_rest(scene, u, angle, j) for j, angle in enumerate(angles)])


@lru_cache(maxsize=32)
def healthy_position(scene, phases=16):
    """Return the mean position of the healthy ring over a ball pass, supported by the rollers only."""
    angles = 2 * np.pi / scene.Z * (np.arange(phases) + 0.5) / phases
    return np.mean([static_state(scene, scene.angles + shift, 0.0, 0.0)[0] for shift in angles])


def anchor_of(scene):
    return healthy_position(replace(scene, defects=(), friction=frictionless, eps=(), damping=None))


def start(scene, anchor):
    """Return the state at t = 0 as (positions, rates): static equilibrium, kinematic rates."""
    u, r = static_state(scene, scene.angles, scene.k_b, anchor)
    c = r * direction(scene.angles)
    x = Coordinates(u, 0.0, c, scene.angles.copy(), 0.0, scene.theta_0)
    spins = np.full(scene.Z, scene.spin)
    v = Coordinates(0.0, 0.0, 1j * scene.orbit * c, spins, 0.0, scene.orbit)
    return x, v


# --- in time ------------------------------------------------------------


class Motion(NamedTuple):
    """All over ``time`` (n,): ring (2, n), rollers (Z, n), works and losses a dict of (n,), see LEDGER."""

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    cage_speed: np.ndarray
    roller_spin: np.ndarray
    roller_angle: np.ndarray  # of the centre, about the origin, less theta_0, the pocket's angle and orbit * t
    outer_force: np.ndarray
    inner_force: np.ndarray
    cage_force: np.ndarray
    outer_slip: np.ndarray
    inner_slip: np.ndarray
    energy: np.ndarray
    works: dict

    @property
    def imbalance(self):
        """Stored energy less what was put in, plus what was lost: constant."""
        w = self.works
        lost = w["contact"] + w["friction"] + w["bracket"] + w["drag"]
        return self.energy - w["drive"] - w["load"] + lost


def longest_step(scene):
    """An eighth of the time in which a roller crosses the narrowest defect: none is stepped over."""
    narrowest = min((defect.width for defect in scene.defects), default=np.inf)
    return narrowest / (8 * (scene.speed - scene.orbit) * scene.R_i)


def simulate(scene: Scene, times, rtol=1e-7, initial=None) -> Motion:
    """Return the motion at ``times`` (s, from 0). ``given``: (positions, rates) at t = 0, not the static start.

    Against ``rtol`` 1e-9 the ring's displacement differed by 3e-7 of its range, the velocity by 1e-6 (2 mm slot).
    """
    anchor = anchor_of(scene)
    x, v = initial or start(scene, anchor)
    n = pack(x).size

    def rhs(t, y):
        x, v = unpack(y[:n], scene.Z), unpack(y[n : 2 * n], scene.Z)
        f = forces(scene, anchor, t, x, v)
        return np.concatenate([y[n : 2 * n], pack(accelerations(scene, f, x, v)), f.powers])

    y0 = np.concatenate([pack(x), pack(v), np.zeros(len(LEDGER))])
    # the tolerance is relative to 0.1 um, 1 mm/s, the same at a roller's skin, 1 uJ
    turn = 1 / scene.R_w
    lengths = pack(Coordinates(1 + 1j, turn, np.full(scene.Z, 1 + 1j), np.full(scene.Z, turn), 1 + 1j, turn))
    atol = rtol * np.concatenate([1e-7 * lengths, 1e-3 * lengths, np.full(len(LEDGER), 1e-6)])
    span = (0.0, times[-1])
    limits = {"rtol": 1e-5 * rtol, "atol": atol, "max_step": longest_step(scene), "first_step": 1e-8}
    out = solve_ivp(rhs, span, y0, "DOP853", times, **limits)
    assert out.success, out.message
    return motion(scene, anchor, out.t, out.y, n)


def motion(scene, anchor, times, y, n):
    rows = []
    for t, column in zip(times, np.ascontiguousarray(y.T), strict=True):
        x, v = unpack(column[:n], scene.Z), unpack(column[n : 2 * n], scene.Z)
        f = forces(scene, anchor, t, x, v)
        angle = np.angle(x.rollers) - scene.theta_0 - scene.pockets - scene.orbit * t
        states = [
            (x.ring.real, x.ring.imag),
            (v.ring.real, v.ring.imag),
            v.cage_angle,
            v.roller_angles,
            wrap_angle(angle),
        ]
        contacts = [f.outer.Q, f.inner.Q, f.pocket.N, f.outer.slip, f.inner.slip]
        rows.append([*states, *contacts, f.stored + kinetic(scene, v)])
    columns = [np.array(c).T for c in zip(*rows, strict=True)]
    return Motion._make([times, *columns, dict(zip(LEDGER, y[2 * n :], strict=True))])


# --- kept numbers ------------------------------------------------------------

RESULTS = Path(__file__).parents[1] / "data" / "reference_planar.npz"
RESULT_TIMES = np.linspace(0.0, 0.02, 1001)
WITH_FRICTION: dict[str, Any] = {
    "friction": static_dynamic(),
    "friction_tilts": True,
    "pocket_stiffness": 1e7,
    "pocket_friction": static_dynamic(static=0.002, dynamic=0.001),
}
SCENES = {
    "healthy": Scene(),
    "friction": Scene(**WITH_FRICTION),
    "slot": Scene(defects=(Defect(OUTER, 2e-3, 0.5e-3),)),
    "slot-friction": Scene(**WITH_FRICTION, defects=(Defect(OUTER, 2e-3, 0.5e-3),)),
    "inner-pit": Scene(**WITH_FRICTION, defects=(Defect(INNER, 0.8e-3, 0.05e-3),)),
    "roller-pit": Scene(**WITH_FRICTION, defects=(Defect(("roller", 0), 0.8e-3, 0.05e-3, np.pi / 2),)),
    "drag": Scene(**WITH_FRICTION, roller_drag=86.0 * 0.012**2 / 2, cage_drag=2e-4),
}


def load_results(name) -> dict:
    """Return the stored ring_x, ring_y (m), velocity_x, velocity_y (m/s), cage_speed (rad/s), at RESULT_TIMES."""
    with np.load(RESULTS) as data:
        columns = {key.split("/")[1]: data[key] for key in data.files if key.startswith(name + "/")}
    return columns | {axis: columns[axis] + columns["middle_" + axis] for axis in ("ring_x", "ring_y")}


def store_results():
    columns = {}
    for name, scene in SCENES.items():
        m = simulate(scene, RESULT_TIMES)
        print(f"{name:14} books open by {np.ptp(m.imbalance):.1e} J of {m.works['contact'][-1]:.1e} J damped")
        mean = m.displacement.mean(axis=1)  # kept apart: the ring moves by a thousandth of where it stands
        values = dict(zip(("ring_x", "ring_y"), m.displacement - mean[:, None], strict=True))
        values |= dict(zip(("velocity_x", "velocity_y"), m.velocity, strict=True), cage_speed=m.cage_speed)
        columns |= {f"{name}/{key}": value.astype(np.float32) for key, value in values.items()}
        columns |= {f"{name}/middle_ring_x": mean[0], f"{name}/middle_ring_y": mean[1]}
    RESULTS.parent.mkdir(exist_ok=True)
    np.savez_compressed(RESULTS, **columns)


if __name__ == "__main__":
    store_results()
