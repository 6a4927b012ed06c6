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
from bearingsim.core.parts.cage import FreeCage, RollerGuided
from bearingsim.core.parts.cage_in_space import CageInSpace
from bearingsim.core.parts.flanges import Flanges
from bearingsim.core.parts.form import Smooth, UnequalRollers
from tests.independent.planar_bodies import FormAt, force, mu, on_pieces

UP = np.array([0.0, 0.0, 1.0])


def state_rows(Z: int) -> np.ndarray:
    """Return the cells of all coordinates, positions then velocities: (2 * 6 * (FIRST_LANE + Z),)."""
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


def tilt_vectors(a, v):
    """Vectors ``v`` after the smallest rotation that brings e_z to the axis ``a``."""
    k = np.cross(UP, a)
    return v + np.cross(k, v) + np.cross(k, np.cross(k, v)) / (1 + a[..., 2:])


class Body(NamedTuple):
    """A rigid body: centre and its velocity, axis and its rate, angle about it (rad) and its rate."""

    centre: Any
    velocity: Any
    axis: Any
    axis_rate: Any
    angle: Any
    angular_velocity: Any

    def spin(self):
        """Angular speed about the axis (rad/s)."""
        area = self.axis_rate[..., 0] * self.axis[..., 1] - self.axis[..., 0] * self.axis_rate[..., 1]
        return self.angular_velocity + area / (1 + self.axis[..., 2])

    def rotation(self):
        """Angular velocity (rad/s)."""
        return np.cross(self.axis, self.axis_rate) + times(self.spin(), self.axis)

    def speed_of(self, point):
        """Velocity (m/s) of the body's material at ``point``."""
        return self.velocity + np.cross(self.rotation(), point - self.centre)

    def angle_of(self, direction):
        """Angle (rad) about the axis at which the body's material points in ``direction``."""
        e_1 = tilt_vectors(self.axis, np.stack([np.cos(self.angle), np.sin(self.angle), 0 * self.angle], axis=-1))
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
    angular_acceleration: Any


def axes(x, y, w_x, w_y):
    """Unit vectors from two components, and their rates."""
    z = np.sqrt(1 - x**2 - y**2)
    return np.stack([x, y, z], axis=-1), np.stack([w_x, w_y, -(x * w_x + y * w_y) / z], axis=-1)


def scene(model: Any, t: np.ndarray, values: np.ndarray) -> Scene:
    """Return the bodies of ``values`` (cells, n) at ``t`` (n,), s."""
    b = model.bearing
    p, v = np.moveaxis(values.reshape(2, 6, lay.FIRST_LANE + b.Z, -1), -1, 1)
    time, rate, growth = np.array([kinematic_time(model.motion, float(x)) for x in t]).T

    def shared(x, number, angle, turns):
        positions, velocities = (np.stack([q[:, 0, x], q[:, 0, x + 1], q[:, 3, number]], axis=-1) for q in (p, v))
        axis, tips = axes(p[:, 4, number], p[:, 5, number], v[:, 4, number], v[:, 5, number])
        return Body(positions, velocities, axis, tips, angle, turns)

    ring = shared(lay.X, 0, p[:, 0, lay.PSI], v[:, 0, lay.PSI])
    cage_angle = b.theta_0 + b.omega_c * time + p[:, 0, lay.PHI_C]
    cage_turns = b.omega_c * rate + v[:, 0, lay.PHI_C]
    cage = shared(lay.X_C, 1, cage_angle, cage_turns)
    inner = shared(lay.X_I, 2, b.omega_i * time, b.omega_i * rate)
    r, w = (b.R_o + b.R_i) / 2 + p[:, 0, lay.FIRST_LANE :], cage_turns[:, None] + v[:, 1, lay.FIRST_LANE :]
    theta = cage_angle[:, None] + 2 * np.pi * np.arange(b.Z) / b.Z + p[:, 1, lay.FIRST_LANE :]
    e_r, e_t = polar_unit_vectors(theta)
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


def polar_unit_vectors(theta):
    """Directions of the angle ``theta`` (rad) and across it."""
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c, s, 0 * c], axis=-1), np.stack([-s, c, 0 * c], axis=-1)


def sliced(rollers: Body) -> Body:
    """Rollers with an axis for the slices."""
    return Body(*(np.expand_dims(part, 2) for part in rollers))


class Flow(NamedTuple):
    """Energy stored (J) and power lost (W) by contacts, at each instant."""

    stored: Any
    lost: Any

    def __add__(self, other):
        return Flow(*(a + b for a, b in zip(self, other, strict=True)))


def total(values):
    """Sum over all but the instants."""
    return np.asarray(values).reshape(len(values), -1).sum(axis=1)


def friction_power(law, N, slip, speed=1.0):
    """Power (W) that friction takes: ``slip`` (..., 3) m/s."""
    s = np.linalg.norm(slip, axis=-1)
    return mu(law, s, speed) * N * s


def race(s: Scene, outer: bool) -> Flow:
    """All contacts of the slices with one race."""
    model, b, sigma = s.model, s.model.bearing, 1 if outer else -1
    law = model.outer if outer else model.inner
    zeta, weight, drop = model.slices.table.T
    ring, rollers = (s.ring if outer else s.inner).spread(2), sliced(s.rollers)
    p = rollers.centre + times(zeta, rollers.axis)
    offset = p - ring.centre
    radial = offset - times(dot(offset, ring.axis), ring.axis)
    rho, n = np.linalg.norm(radial, axis=-1), unit(radial)
    tau = np.cross(ring.axis, n)
    speed = rollers.speed_of(p) - ring.speed_of(p)
    delta = sigma * (rho - (b.R_o if outer else b.R_i)) + b.R_w - drop
    rate = sigma * dot(n, speed)
    h, tilt = np.zeros(delta.shape), np.zeros(delta.shape)
    for head, groups in zip(model.defects.head, model.defects.groups, strict=True):
        if head[SIDE] == (0 if outer else 1):
            x, x_rate = defect_distance(s, head, ring, rollers, sigma * n, dot(tau, speed) / rho)
            depth, slope = box(head, groups, x)
            is_deeper = depth > h
            h, tilt = np.where(is_deeper, depth, h), np.where(is_deeper, slope * head[RADIUS] / rho, tilt)
            rate = rate - np.where(is_deeper, slope * x_rate, 0)
    form = form_at(s, ring, rollers, n, sigma, dot(tau, speed) / rho)
    delta, rate, tilt = delta - h - form.depth, rate - form.rate, tilt + form.slope / rho
    Q, Q_e, stored = force(law, delta, rate)
    normal = unit(n - sigma * times(tilt, tau))
    contact_point = p + sigma * times(b.R_w - drop - delta / 2, normal)
    slip = rollers.speed_of(contact_point) - ring.speed_of(contact_point)
    slip = slip - times(dot(slip, normal), normal)
    orbit = np.cross(s.rollers.centre, s.rollers.velocity)[..., 2] / (s.rollers.centre[..., :2] ** 2).sum(axis=-1)
    rolling = b.R_w * np.abs(orbit - s.rollers.spin())[..., None]
    return Flow(
        total(weight * stored),
        total(weight * ((Q - Q_e) * rate + friction_power(model.friction, Q, slip, rolling))),
    )


def form_at(s, ring, rollers, n, sigma, sweep) -> FormAt:
    """Form of race and rollers at slices (n, Z, K) that touch along ``n``; sweep: of n over the race (rad/s)."""
    flat, form, b = np.zeros(n.shape[:-1]), s.model.form, s.model.bearing
    if isinstance(form, Smooth):
        return FormAt(flat, flat, flat, flat)
    race_table = np.concatenate(
        [(form.outer if sigma > 0 else form.inner).pieces[:, :, 1 + k] for k in range(b.Z)]
    )
    depth, race_slope = on_tables(np.repeat(race_table[np.newaxis], b.Z, axis=0), ring.angle_of(n))
    if isinstance(form.rollers, UnequalRollers):
        recess = form.rollers.recess[: b.Z, np.newaxis]
        return FormAt(depth + recess, race_slope * sweep, race_slope, race_slope)
    starts = b.theta_0 + 2 * np.pi * np.arange(b.Z)[:, None] / b.Z
    roller_table = form.rollers.pieces[:, :, : b.Z].transpose(2, 0, 1)
    of_roller, roller_slope = on_tables(roller_table, rollers.angle_of(sigma * n) - starts)
    roller_sweep = sweep + dot(ring.rotation() - rollers.rotation(), ring.axis)
    rate = race_slope * sweep + roller_slope * roller_sweep
    return FormAt(depth + of_roller, rate, race_slope + roller_slope, race_slope)


def on_tables(tables, angle):
    """Run ``on_pieces`` for angles (n, Z, K)."""
    by_roller = np.moveaxis(angle, 1, 0)
    values = on_pieces(tables, by_roller.reshape(len(tables), -1))
    return tuple(np.moveaxis(value.reshape(by_roller.shape), 0, 1) for value in values)


def defect_distance(s, head, ring, rollers, outwards, sweep):
    """Distance (m) of slices from a defect's middle, infinite if it is not theirs, and its rate (m/s)."""
    if head[CARRIER] < 0:
        angle = ring.angle_of(outwards if head[CARRIER] != ON_INNER else -outwards)
        return head[RADIUS] * wrap_angle(angle - head[ANGLE]), head[RADIUS] * sweep
    Z = s.model.bearing.Z
    mask = np.where(np.arange(Z) == int(head[CARRIER]), 0.0, np.inf)[:, None]
    # a roller's defect is at ``angle`` from its outermost point at t = 0
    start = s.model.bearing.theta_0 + 2 * np.pi * int(head[CARRIER]) / Z
    x = mask + head[RADIUS] * wrap_angle(rollers.angle_of(outwards) - start - head[ANGLE])
    return x, head[RADIUS] * (sweep + dot(ring.rotation() - rollers.rotation(), ring.axis))


def wrap_angle(angle):
    """The angle (rad) within half a turn."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def box(head, groups, x):
    """Sinking (m) and its slope at ``x`` (m) from the middle of a rectangular defect that some slices meet."""
    rim = np.maximum(groups[:, GROUP_HALF_WIDTH] - np.abs(x), 0)
    h = np.minimum(rim**2 / (2 * head[REDUCED_RADIUS]), groups[:, DEPTH])
    is_floor = rim**2 / (2 * head[REDUCED_RADIUS]) >= groups[:, DEPTH]
    return h * groups[:, GROUP_WEIGHT], np.where(is_floor, 0, -np.sign(x) * rim / head[REDUCED_RADIUS]) * groups[
        :, GROUP_WEIGHT
    ]


def flanges(s: Scene) -> Flow:
    """The ends of the rollers at the flanges."""
    f, b = s.model.flanges, s.model.bearing
    flow = Flow(0 * s.t, 0 * s.t)
    if isinstance(f, Flanges):
        for outer, side, is_present in (
            (0, -1, f.inner_minus),
            (0, 1, f.inner_plus),
            (1, -1, f.outer_minus),
            (1, 1, f.outer_plus),
        ):
            ring = (s.ring if outer else s.inner).spread(1)
            face = b.R_o - f.height / 2 if outer else b.R_i + f.height / 2
            t = np.sqrt((b.R_w**2 - (b.R_w - f.height / 2) ** 2) / 3)
            for position in (t, -t):
                flow += Flow(*(is_present * part for part in end(s, ring, face, side, position)))
    return flow


def end(s: Scene, ring: Body, face, side, t) -> Flow:
    """One point of the end of every roller at a flange."""
    f, half, rollers = s.model.flanges, s.model.L_w / 2, s.rollers

    def point(offset, axis):
        radial = offset - times(dot(offset, axis), axis)
        n = unit(radial)
        return side * (half + f.play) * axis + face * n + t * np.cross(axis, n)

    offset = rollers.centre - ring.centre
    contact_point = point(offset, ring.axis)
    delta = half - side * dot(contact_point - offset, rollers.axis)
    # as seen from the ring only the roller moves; the point follows it
    speed = rollers.velocity - ring.speed_of(rollers.centre)
    h = 1e-7
    point_velocity = (point(offset + h * speed, ring.axis) - point(offset - h * speed, ring.axis)) / (2 * h)
    axis_rate = rollers.axis_rate - np.cross(ring.rotation(), rollers.axis)
    rate = -side * (dot(point_velocity - speed, rollers.axis) + dot(contact_point - offset, axis_rate))
    N, N_e, stored = force(f.law, delta, rate)
    slip = rollers.speed_of(ring.centre + contact_point) - ring.speed_of(ring.centre + contact_point)
    slip = slip - times(dot(slip, rollers.axis), rollers.axis)
    return Flow(total(stored), total((N - N_e) * rate + friction_power(f.friction, N, slip)))


def cage_contacts(s: Scene) -> Flow:
    """The pockets: their walls, slice by slice, and what stops a roller radially and axially."""
    model, b, cage = s.model, s.model.bearing, s.model.cage
    if not isinstance(cage, FreeCage):
        return Flow(0 * s.t, 0 * s.t)
    zeta, weight, drop = model.slices.table.T
    body, rollers, sliced_cage = s.cage.spread(1), sliced(s.rollers), s.cage.spread(2)
    e_r, _ = polar_unit_vectors(s.cage.angle[:, None] + 2 * np.pi * np.arange(b.Z) / b.Z)
    radial = tilt_vectors(body.axis, e_r)
    wall = np.expand_dims(np.cross(body.axis, radial), 2)
    p = rollers.centre + times(zeta, rollers.axis)
    e, rate = dot(p - sliced_cage.centre, wall), dot(rollers.speed_of(p) - sliced_cage.speed_of(p), wall)
    side = np.sign(e)
    N, N_e, stored = force(cage.pocket, np.abs(e) - cage.play, side * rate)
    contact_point = p + times(side * (b.R_w - drop), wall)
    slip = rollers.speed_of(contact_point) - sliced_cage.speed_of(contact_point)
    slip = slip - times(dot(slip, wall), wall)
    flow = Flow(
        total(weight * stored), total(weight * ((N - N_e) * side * rate + friction_power(cage.friction, N, slip)))
    )
    offset, speed = s.rollers.centre - body.centre, s.rollers.velocity - body.speed_of(s.rollers.centre)
    if isinstance(cage.guide, RollerGuided):
        middle = (b.R_o + b.R_i) / 2
        flow += stop(cage.guide.law, cage.guide.play, dot(offset, radial) - middle, dot(speed, radial))
    if isinstance(model.cage_z, CageInSpace):
        flow += stop(model.cage_z.law, model.cage_z.play_z, dot(offset, body.axis), dot(speed, body.axis))
    return flow


def stop(law, play, out, rate) -> Flow:
    """A stop to either side."""
    rate = np.sign(out) * rate
    N, N_e, stored = force(law, np.abs(out) - play, rate)
    return Flow(total(stored), total((N - N_e) * rate))
