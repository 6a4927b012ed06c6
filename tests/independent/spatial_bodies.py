"""The bodies of `spatial` as vectors in space, for balances: written from mechanics, not from the model.

Vectors are arrays (..., 3) along e_0, e_90, e_z; the first axis of all is the instant (n), then the roller (Z) and
the slice (K) where there are such. Contacts of Hunt and Crossley around power laws, rectangular defects.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.pairs import (
    ANGLE,
    CARRIER,
    DEPTH,
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    ON_INNER,
    RADIUS,
    REDUCED_RADIUS,
    SIDE,
)
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.parts.cage import FreeCage, OilDrag, RollerGuided
from bearingsim.core.parts.cage_in_space import CageInSpace
from bearingsim.core.parts.flanges import Flanges
from bearingsim.core.parts.mounts import ElasticMount
from bearingsim.core.parts.shaft import ElasticShaft, TorsionSpring
from tests.independent.planar_bodies import force, mu

UP = np.array([0.0, 0.0, 1.0])


def places(Z: int) -> np.ndarray:
    """Places in the buffer of all that moves, positions then velocities: (2 * 6 * (FIRST_LANE + Z),)."""
    row = np.arange(lay.FIRST_LANE + Z)
    return np.concatenate([block + k * lay.ROW + row for block in (lay.POSITION, lay.VELOCITY) for k in range(6)])


def dot(a, b):
    """Inner products of vectors."""
    return (a * b).sum(axis=-1)


def unit(a):
    """Vectors of length 1."""
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def times(scalars, vectors):
    """Vectors, each times its scalar."""
    return np.asarray(scalars)[..., np.newaxis] * vectors


def leant(a, v):
    """Vectors ``v`` after the smallest rotation that brings e_z to the axis ``a``."""
    k = np.cross(UP, a)
    return v + np.cross(k, v) + np.cross(k, np.cross(k, v)) / (1 + a[..., 2:])


class Body(NamedTuple):
    """A rigid body: centre and its velocity, axis and its rate, angle about it (rad) and its rate."""

    at: Any
    moves: Any
    axis: Any
    tips: Any
    angle: Any
    turns: Any

    def spin(self):
        """Angular speed about the axis (rad/s)."""
        area = self.tips[..., 0] * self.axis[..., 1] - self.axis[..., 0] * self.tips[..., 1]
        return self.turns + area / (1 + self.axis[..., 2])

    def rotation(self):
        """Angular velocity (rad/s)."""
        return np.cross(self.axis, self.tips) + times(self.spin(), self.axis)

    def speed_of(self, point):
        """Velocity (m/s) of the body's material at ``point``."""
        return self.moves + np.cross(self.rotation(), point - self.at)

    def angle_of(self, direction):
        """Angle (rad) about the axis at which the body's material points in ``direction``."""
        e_1 = leant(self.axis, np.stack([np.cos(self.angle), np.sin(self.angle), 0 * self.angle], axis=-1))
        return np.arctan2(dot(direction, np.cross(self.axis, e_1)), dot(direction, e_1))

    def spread(self, count=1):
        """The body with ``count`` more axes, one entry each, before the components."""
        return Body(*(np.expand_dims(part, tuple(range(1, 1 + count))) for part in self))


class Scene(NamedTuple):
    """All bodies at the instants t (n,), s; rollers (n, Z)."""

    model: Any
    t: Any
    rollers: Body
    ring: Body
    inner: Body
    cage: Body
    grown: Any


def axes(x, y, w_x, w_y):
    """Unit vectors from two components, and their rates."""
    z = np.sqrt(1 - x**2 - y**2)
    return np.stack([x, y, z], axis=-1), np.stack([w_x, w_y, -(x * w_x + y * w_y) / z], axis=-1)


def scene(model: Any, t: np.ndarray, values: np.ndarray) -> Scene:
    """The bodies of ``values`` (places, n) at ``t`` (n,), s."""
    b = model.bearing
    p, v = np.moveaxis(values.reshape(2, 6, lay.FIRST_LANE + b.Z, -1), -1, 1)
    time, rate, growth = np.array([kinematic_time(model.motion, float(x)) for x in t]).T

    def shared(x, number, angle, turns):
        at, moves = (np.stack([q[:, 0, x], q[:, 0, x + 1], q[:, 3, number]], axis=-1) for q in (p, v))
        axis, tips = axes(p[:, 4, number], p[:, 5, number], v[:, 4, number], v[:, 5, number])
        return Body(at, moves, axis, tips, angle, turns)

    ring = shared(lay.X, 0, p[:, 0, lay.PSI], v[:, 0, lay.PSI])
    cage_angle = b.theta_0 + b.omega_c * time + p[:, 0, lay.PHI_C]
    cage_turns = b.omega_c * rate + v[:, 0, lay.PHI_C]
    cage = shared(lay.X_C, 1, cage_angle, cage_turns)
    inner = shared(lay.X_I, 2, b.omega_i * time, b.omega_i * rate)
    r, w = (b.R_o + b.R_i) / 2 + p[:, 0, lay.FIRST_LANE :], cage_turns[:, None] + v[:, 1, lay.FIRST_LANE :]
    theta = cage_angle[:, None] + 2 * np.pi * np.arange(b.Z) / b.Z + p[:, 1, lay.FIRST_LANE :]
    e_r, e_t = around(theta)
    axis, tips = axes(*(q[:, k, lay.FIRST_LANE :] for q in (p, v) for k in (4, 5)))
    rollers = Body(
        times(r, e_r) + times(p[:, 3, lay.FIRST_LANE :], UP),
        times(v[:, 0, lay.FIRST_LANE :], e_r) + times(r * w, e_t) + times(v[:, 3, lay.FIRST_LANE :], UP),
        axis,
        tips,
        ((b.omega_c - b.omega_b) * time)[:, None] + p[:, 2, lay.FIRST_LANE :],
        ((b.omega_c - b.omega_b) * rate)[:, None] + v[:, 2, lay.FIRST_LANE :],
    )
    return Scene(model, t, rollers, ring, inner, cage, b.omega_i * growth)


def around(theta):
    """Directions of the angle ``theta`` (rad) and across it."""
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c, s, 0 * c], axis=-1), np.stack([-s, c, 0 * c], axis=-1)


def sliced(rollers: Body) -> Body:
    """Rollers with an axis for the slices."""
    return Body(*(np.expand_dims(part, 2) for part in rollers))


class Flow(NamedTuple):
    """What contacts do: energy stored (J) and power lost (W), at each instant."""

    stored: Any
    lost: Any

    def __add__(self, other):
        return Flow(*(a + b for a, b in zip(self, other, strict=True)))


def total(values):
    """Sum over all but the instants."""
    return np.asarray(values).reshape(len(values), -1).sum(axis=1)


def rubbing(law, N, slip, speed=1.0):
    """Power (W) that friction takes: ``slip`` (..., 3) m/s."""
    s = np.linalg.norm(slip, axis=-1)
    return mu(law, s, speed) * N * s


def race(s: Scene, outer: bool) -> Flow:
    """All contacts of the slices with one race."""
    model, b, sigma = s.model, s.model.bearing, 1 if outer else -1
    law = model.outer if outer else model.inner
    zeta, weight, drop = model.slices.table.T
    ring, rollers = (s.ring if outer else s.inner).spread(2), sliced(s.rollers)
    p = rollers.at + times(zeta, rollers.axis)
    away = p - ring.at
    across = away - times(dot(away, ring.axis), ring.axis)
    rho, n = np.linalg.norm(across, axis=-1), unit(across)
    tau = np.cross(ring.axis, n)
    speed = rollers.speed_of(p) - ring.speed_of(p)
    delta = sigma * (rho - (b.R_o if outer else b.R_i)) + b.R_w - drop
    rate = sigma * dot(n, speed)
    h, lean = np.zeros(delta.shape), np.zeros(delta.shape)
    for head, groups in zip(model.defects.head, model.defects.groups, strict=True):
        if head[SIDE] == (0 if outer else 1):
            x, x_rate = passing(s, head, ring, rollers, sigma * n, dot(tau, speed) / rho)
            deep, slope = box(head, groups, x)
            deeper = deep > h
            h, lean = np.where(deeper, deep, h), np.where(deeper, slope * head[RADIUS] / rho, lean)
            rate = rate - np.where(deeper, slope * x_rate, 0)
    delta = delta - h
    Q, Q_e, stored = force(law, delta, rate)
    normal = unit(n - sigma * times(lean, tau))
    touch = p + sigma * times(b.R_w - drop - delta / 2, normal)
    slip = rollers.speed_of(touch) - ring.speed_of(touch)
    slip = slip - times(dot(slip, normal), normal)
    orbit = np.cross(s.rollers.at, s.rollers.moves)[..., 2] / (s.rollers.at[..., :2] ** 2).sum(axis=-1)
    rolling = b.R_w * np.abs(orbit - s.rollers.spin())[..., None]
    return Flow(
        total(weight * stored), total(weight * ((Q - Q_e) * rate + rubbing(model.friction, Q, slip, rolling)))
    )


def passing(s, head, ring, rollers, outwards, sweep):
    """Distance (m) of slices from a defect's middle, infinite if it is not theirs, and its rate (m/s)."""
    if head[CARRIER] < 0:
        about = ring.angle_of(outwards if head[CARRIER] != ON_INNER else -outwards)
        return head[RADIUS] * wrapped(about - head[ANGLE]), head[RADIUS] * sweep
    Z = s.model.bearing.Z
    theirs = np.where(np.arange(Z) == int(head[CARRIER]), 0.0, np.inf)[:, None]
    # a roller's defect is at ``angle`` from its outermost point at t = 0
    start = s.model.bearing.theta_0 + 2 * np.pi * int(head[CARRIER]) / Z
    x = theirs + head[RADIUS] * wrapped(rollers.angle_of(outwards) - start - head[ANGLE])
    return x, head[RADIUS] * (sweep + dot(ring.rotation() - rollers.rotation(), ring.axis))


def wrapped(angle):
    """The angle (rad) within half a turn."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def box(head, groups, x):
    """Sinking (m) and its slope at ``x`` (m) from the middle of a rectangular defect that some slices meet."""
    rim = np.maximum(groups[:, GROUP_HALF_WIDTH] - np.abs(x), 0)
    h = np.minimum(rim**2 / (2 * head[REDUCED_RADIUS]), groups[:, DEPTH])
    floor = rim**2 / (2 * head[REDUCED_RADIUS]) >= groups[:, DEPTH]
    return h * groups[:, GROUP_WEIGHT], np.where(floor, 0, -np.sign(x) * rim / head[REDUCED_RADIUS]) * groups[
        :, GROUP_WEIGHT
    ]


def flanges(s: Scene) -> Flow:
    """The ends of the rollers at the flanges."""
    f, b = s.model.flanges, s.model.bearing
    found = Flow(0 * s.t, 0 * s.t)
    if isinstance(f, Flanges):
        for outer, side, there in (
            (0, -1, f.inner_minus),
            (0, 1, f.inner_plus),
            (1, -1, f.outer_minus),
            (1, 1, f.outer_plus),
        ):
            ring = (s.ring if outer else s.inner).spread(1)
            face = b.R_o - f.height / 2 if outer else b.R_i + f.height / 2
            t = np.sqrt((b.R_w**2 - (b.R_w - f.height / 2) ** 2) / 3)
            for along in (t, -t):
                found += Flow(*(there * part for part in end(s, ring, face, side, along)))
    return found


def end(s: Scene, ring: Body, face, side, t) -> Flow:
    """One point of the end of every roller at a flange."""
    f, half, rollers = s.model.flanges, s.model.L_w / 2, s.rollers

    def point(away, axis):
        across = away - times(dot(away, axis), axis)
        n = unit(across)
        return side * (half + f.play) * axis + face * n + t * np.cross(axis, n)

    away = rollers.at - ring.at
    here = point(away, ring.axis)
    delta = half - side * dot(here - away, rollers.axis)
    # as seen from the ring only the roller moves; the point follows it
    speed = rollers.moves - ring.speed_of(rollers.at)
    h = 1e-7
    follows = (point(away + h * speed, ring.axis) - point(away - h * speed, ring.axis)) / (2 * h)
    tips = rollers.tips - np.cross(ring.rotation(), rollers.axis)
    rate = -side * (dot(follows - speed, rollers.axis) + dot(here - away, tips))
    N, N_e, stored = force(f.law, delta, rate)
    slip = rollers.speed_of(ring.at + here) - ring.speed_of(ring.at + here)
    slip = slip - times(dot(slip, rollers.axis), rollers.axis)
    return Flow(total(stored), total((N - N_e) * rate + rubbing(f.friction, N, slip)))


def cage_contacts(s: Scene) -> Flow:
    """The pockets: their walls, slice by slice, and what stops a roller radially and axially."""
    model, b, cage = s.model, s.model.bearing, s.model.cage
    if not isinstance(cage, FreeCage):
        return Flow(0 * s.t, 0 * s.t)
    zeta, weight, drop = model.slices.table.T
    body, rollers, wide = s.cage.spread(1), sliced(s.rollers), s.cage.spread(2)
    e_r, _ = around(s.cage.angle[:, None] + 2 * np.pi * np.arange(b.Z) / b.Z)
    radial = leant(body.axis, e_r)
    wall = np.expand_dims(np.cross(body.axis, radial), 2)
    p = rollers.at + times(zeta, rollers.axis)
    e, rate = dot(p - wide.at, wall), dot(rollers.speed_of(p) - wide.speed_of(p), wall)
    side = np.sign(e)
    N, N_e, stored = force(cage.pocket, np.abs(e) - cage.play, side * rate)
    touch = p + times(side * (b.R_w - drop), wall)
    slip = rollers.speed_of(touch) - wide.speed_of(touch)
    slip = slip - times(dot(slip, wall), wall)
    found = Flow(
        total(weight * stored), total(weight * ((N - N_e) * side * rate + rubbing(cage.friction, N, slip)))
    )
    apart, speed = s.rollers.at - body.at, s.rollers.moves - body.speed_of(s.rollers.at)
    if isinstance(cage.guide, RollerGuided):
        middle = (b.R_o + b.R_i) / 2
        found += stop(cage.guide.law, cage.guide.play, dot(apart, radial) - middle, dot(speed, radial))
    if isinstance(model.cage_z, CageInSpace):
        found += stop(model.cage_z.law, model.cage_z.play_z, dot(apart, body.axis), dot(speed, body.axis))
    return found


def stop(law, play, out, rate) -> Flow:
    """A stop to either side."""
    rate = np.sign(out) * rate
    N, N_e, stored = force(law, np.abs(out) - play, rate)
    return Flow(total(stored), total((N - N_e) * rate))


class Balance(NamedTuple):
    """What there is of momentum, angular momentum about the origin and energy, and what changes it from outside.

    ``power`` and ``torque`` without the inner ring's drive.
    """

    momentum: Any
    spin: Any
    energy: Any
    force: Any
    torque: Any
    power: Any
    lost: Any


def balance(s: Scene) -> Balance:
    """All sums over the bodies, and over what acts on them from outside."""
    contacts = race(s, True) + race(s, False) + flanges(s) + cage_contacts(s)
    momentum, spin, energy = inertia(s)
    pushes, twists = outside(s)
    stored = 0.0
    acting = [push[:2] for push in pushes]
    return Balance(
        momentum,
        spin,
        energy + contacts.stored + stored,
        sum(force for _, force in acting),
        sum(np.cross(at, force) for at, force in acting) + sum(moment for moment, _ in twists),
        sum(dot(force, moves) for _, force, moves in pushes) + sum(dot(moment, w) for moment, w in twists),
        contacts.lost,
    )


def inertia(s: Scene):
    """Momentum, angular momentum about the origin and kinetic energy."""
    model, b = s.model, s.model.bearing
    bodies = [(b.m_r, b.m_r, b.I_r, model.I_t, Body(*(part[:, j] for part in s.rollers))) for j in range(b.Z)]
    turning = model.bracket.inertia if isinstance(model.bracket, TorsionSpring) else model.mount_o.I_a
    bodies.append((b.m_o, model.mount_o.m, turning, model.mount_o.I_t, s.ring))
    bodies.append((model.shaft.m, model.mount_i.m, model.mount_i.I_a, model.mount_i.I_t, s.inner))
    if isinstance(model.cage, FreeCage):
        bodies.append((model.cage.m, model.cage.m, model.cage.inertia, model.cage_z.I_t, s.cage))
    momentum = spin = energy = 0.0
    for m, m_z, I_a, I_t, body in bodies:
        p = np.array([m, m, m_z]) * body.moves
        momentum = momentum + p
        spin = spin + np.cross(body.at, p) + I_t * np.cross(body.axis, body.tips)
        spin = spin + times(I_a * body.spin(), body.axis)
        energy = energy + (dot(p, body.moves) + I_t * dot(body.tips, body.tips) + I_a * body.spin() ** 2) / 2
    return momentum, spin, energy


def outside(s: Scene):
    """Forces as (at, force, velocity) and moments as (moment, angular velocity): loads, springs, dampers, oil."""
    model, support, shaft = s.model, s.model.support, s.model.shaft
    flat = np.array([1.0, 1.0, 0.0])
    load = np.array([support.F, support.F_across, 0.0])
    anchor = np.array([support.x_0, support.y_0, 0.0])
    held = -support.k_b * flat * (s.ring.at - anchor) - support.c_b * flat * s.ring.moves
    pushes = [(s.ring.at, held - load, s.ring.moves)]
    twists = []
    if isinstance(shaft, ElasticShaft):
        heavy, behind = around(s.inner.angle + shaft.angle)
        flung = shaft.unbalance * (times(s.inner.turns**2, heavy) - times(s.grown, behind))
        sprung = -shaft.k * flat * s.inner.at - shaft.c * flat * s.inner.moves
        pushes.append((s.inner.at, load + flung + sprung, s.inner.moves))
    for mount, ring in ((model.mount_o, s.ring), (model.mount_i, s.inner)):
        if isinstance(mount, ElasticMount):
            lean = ring.axis - np.array([mount.tilt_x, mount.tilt_y, 0.0])
            pull = flat * (-mount.k_tilt * lean - mount.c_tilt * ring.tips)
            twists.append((np.cross(ring.axis, pull), ring.rotation()))
            along = times(-mount.k_z * ring.at[:, 2] - mount.c_z * ring.moves[:, 2], UP)
            pushes.append((ring.at, along, ring.moves))
    if isinstance(model.bracket, TorsionSpring):
        twist = -model.bracket.k * s.ring.angle - model.bracket.c * s.ring.turns
        twists.append((times(twist, s.ring.axis), s.ring.rotation()))
    g = model.gravity * np.array([1.0, 0.0, 0.0])
    b, r = model.bearing, s.rollers
    for j in range(b.Z):
        pushes.append((r.at[:, j], b.m_r * g + 0 * r.at[:, j], r.moves[:, j]))
        if isinstance(model.drag, OilDrag):
            ahead = np.cross(UP, unit(r.at[:, j] * flat))
            v = dot(ahead, r.moves[:, j])
            pushes.append((r.at[:, j], times(-model.drag.roller * v * np.abs(v), ahead), r.moves[:, j]))
    if isinstance(model.cage, FreeCage):
        pushes.append((s.cage.at, model.cage.m * g + 0 * s.cage.at, s.cage.moves))
        if isinstance(model.drag, OilDrag):
            slower = s.cage.turns - (0.0 if model.drag.outer else s.inner.turns)
            twists.append((times(-model.drag.land * slower, s.cage.axis), s.cage.rotation()))
    return pushes, twists
