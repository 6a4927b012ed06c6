"""The bodies of `planar` as vectors, for balances: written from mechanics, not from the model.

Points and vectors of the plane are complex numbers: x along e_0, y along e_90. Arrays are (Z, n) for rollers and
(n,) for what there is one of, n being instants. Contacts of Hunt and Crossley around power laws, rectangular
defects.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.pairs import (
    ANGLE,
    CARRIER,
    DEPTH,
    GROUP_COUNT,
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    HALF_WIDTH,
    RADIUS,
    REDUCED_RADIUS,
    SIDE,
)
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.laws.friction.curves import StaticDynamic, Traction
from bearingsim.core.laws.stiffness.series import as_power
from bearingsim.core.parts.cage import FreeCage, RingGuided, RollerGuided
from bearingsim.core.parts.form import Smooth, UnequalRollers


def state_rows(Z: int) -> np.ndarray:
    """Return the cells of all coordinates, positions then velocities: (2 * 3 * (FIRST_LANE + Z),)."""
    row = np.arange(lay.FIRST_LANE + Z)
    return np.concatenate([block + k * lay.ROW + row for block in (lay.POSITION, lay.VELOCITY) for k in range(3)])


def dot(a, b):
    """Inner product of two vectors."""
    return (np.conj(a) * b).real


def cross(a, b):
    """Moment of ``b`` at ``a``."""
    return (np.conj(a) * b).imag


class Body(NamedTuple):
    """Rigid body: centre and velocity (complex; m, m/s), angle (rad) and angular velocity (rad/s)."""

    centre: Any
    velocity: Any
    angle: Any
    angular_velocity: Any

    def speed_of(self, point):
        """Velocity (m/s) of the body's material at ``point``."""
        return self.velocity + 1j * self.angular_velocity * (point - self.centre)


class Scene(NamedTuple):
    """All bodies at the instants t (n,), s."""

    model: Any
    t: Any
    rollers: Body
    ring: Body
    inner: Body
    cage: Body
    angular_acceleration: Any  # the inner ring's angular acceleration, rad/s^2


def scene(model: Any, t: np.ndarray, values: np.ndarray) -> Scene:
    """Return the bodies of ``values`` (cells, n) at ``t`` (n,), s."""
    b = model.bearing
    p, v = values.reshape(2, 3, lay.FIRST_LANE + b.Z, -1)
    time, rate, growth = np.array([kinematic_time(model.motion, float(x)) for x in t]).T
    cage = Body(
        p[0, lay.X_C] + 1j * p[0, lay.Y_C],
        v[0, lay.X_C] + 1j * v[0, lay.Y_C],
        b.theta_0 + b.omega_c * time + p[0, lay.PHI_C],
        b.omega_c * rate + v[0, lay.PHI_C],
    )
    r = (b.R_o + b.R_i) / 2 + p[0, lay.FIRST_LANE :]
    along = np.exp(1j * (pockets(b, cage.angle) + p[1, lay.FIRST_LANE :]))
    rollers = Body(
        r * along,
        (v[0, lay.FIRST_LANE :] + 1j * r * (cage.angular_velocity + v[1, lay.FIRST_LANE :])) * along,
        (b.omega_c - b.omega_b) * time + p[2, lay.FIRST_LANE :],
        (b.omega_c - b.omega_b) * rate + v[2, lay.FIRST_LANE :],
    )
    ring = Body(p[0, lay.X] + 1j * p[0, lay.Y], v[0, lay.X] + 1j * v[0, lay.Y], p[0, lay.PSI], v[0, lay.PSI])
    inner = Body(
        p[0, lay.X_I] + 1j * p[0, lay.Y_I], v[0, lay.X_I] + 1j * v[0, lay.Y_I], b.omega_i * time, b.omega_i * rate
    )
    return Scene(model, t, rollers, ring, inner, cage, b.omega_i * growth)


def pockets(bearing, angle):
    """Angles (Z, n) of the pockets, the first at ``angle``."""
    return angle + 2 * np.pi * np.arange(bearing.Z)[:, np.newaxis] / bearing.Z


def mu(law, v, u):
    """Friction coefficient at the slip ``v`` (m/s) and rolling speed ``u`` (m/s)."""
    if isinstance(law, StaticDynamic):
        x = np.clip(np.abs(v) / law.v_s, 0, 1)
        y = np.clip((np.abs(v) - law.v_s) / (law.v_d - law.v_s), 0, 1)
        return np.sign(v) * (law.mu_s * (1.5 * x - 0.5 * x**3) - (law.mu_s - law.mu_d) * (3 * y**2 - 2 * y**3))
    if isinstance(law, Traction):
        s = np.abs(v) / u
        return np.sign(v) * ((law.a + law.b * s) * np.exp(-law.c * s) + law.d)
    return np.zeros_like(v)


def force(law, delta, rate):
    """Force (N), what of it is elastic (N), and the energy stored (J) of a contact."""
    (k, m), compression = as_power(law.stiffness), np.maximum(delta, 0)
    elastic = k * compression**m
    return np.maximum(elastic * (1 + law.chi * rate), 0), elastic, k * compression ** (m + 1) / (m + 1)


class Flow(NamedTuple):
    """Energy stored (J) and power lost (W) by contacts, and torque (N m) on the inner ring about its centre."""

    stored: Any
    lost: Any
    torque: Any

    def __add__(self, other):
        return Flow(*(a + b for a, b in zip(self, other, strict=True)))


class PressedContacts(NamedTuple):
    """Contacts (Z, n): force (N), energy stored (J), power lost (W), approach (m), torque on the race (N m).

    ``moment``: sum of force times dh/ds times the radius of the surface that carries the defect (N m).
    """

    force: Any
    stored: Any
    lost: Any
    mean: Any
    torque: Any
    moment: Any


def press(law, delta, rate, aside, steep=0.0) -> PressedContacts:
    """Contacts with the approach ``delta`` (m), growing at ``rate`` (m/s).

    ``aside``: arm on the race (m); ``steep``: dh/ds times the radius of what carries the defect (m).
    """
    Q, Q_e, stored = force(law, delta, rate)
    return PressedContacts(Q, stored, (Q - Q_e) * rate, np.maximum(delta, 0), Q * aside, Q * steep)


def race(s: Scene, outer: bool) -> Flow:
    """All contacts of the rollers with one race."""
    model, b, rollers, ring = s.model, s.model.bearing, s.rollers, (s.ring if outer else s.inner)
    law, sign = (model.outer, 1.0) if outer else (model.inner, -1.0)
    offset, speed = rollers.centre - ring.centre, rollers.velocity - ring.velocity
    rho = np.abs(offset)
    n = offset / rho
    delta, closing = (rho + b.R_w - b.R_o if outer else b.R_i + b.R_w - rho), sign * dot(n, speed)
    form = form_at(s, ring, n, sign, dot(1j * n, speed) / rho)
    delta, closing = delta - form.depth, closing - form.rate
    contacts = press(law, delta, closing, -form.race_slope, form.slope)
    for head, groups in zip(model.defects.head, model.defects.groups, strict=True):
        if head[SIDE] == (0 if outer else 1):
            x, x_rate = defect_distance(s, head, ring, n, sign, dot(1j * n, speed) / rho)
            over_contacts = over_defect(law, delta, closing, head, groups, x, x_rate, form)
            contacts = PressedContacts(*np.where(np.abs(x) < head[HALF_WIDTH], over_contacts, contacts))
    normal = n - sign * contacts.moment / (rho * np.maximum(contacts.force, 1e-300)) * 1j * n
    normal /= np.abs(normal)
    contact_point = rollers.centre + sign * (b.R_w - contacts.mean / 2) * normal
    slip = dot(1j * normal, rollers.speed_of(contact_point) - ring.speed_of(contact_point))
    f = mu(model.friction, slip, b.R_w * np.abs(orbit(s) - rollers.angular_velocity)) * contacts.force
    torque = cross(contact_point - ring.centre, f * 1j * normal) + contacts.torque
    return Flow(
        contacts.stored.sum(axis=0), (contacts.lost + f * slip).sum(axis=0), 0.0 if outer else torque.sum(axis=0)
    )


def defect_distance(s: Scene, head, ring: Body, n, sign, sweep):
    """Distance (m) of rollers from a defect's middle, infinite if it is not theirs, and its rate (m/s)."""
    if head[CARRIER] < 0:
        x = head[RADIUS] * angle_between(ring.angle + head[ANGLE], n)
        return x, head[RADIUS] * (sweep - ring.angular_velocity)
    b, mask = s.model.bearing, np.full((s.model.bearing.Z, 1), np.inf)
    mask[int(head[CARRIER])] = 0.0
    defect = s.rollers.angle + pockets(b, b.theta_0) + head[ANGLE]
    return mask + head[RADIUS] * angle_between(defect, sign * n), head[RADIUS] * (
        sweep - s.rollers.angular_velocity
    )


class FormAt(NamedTuple):
    """Form at contacts (Z, n): depth of both surfaces (m), its rate (m/s) and slope (m/rad), that of the race."""

    depth: Any
    rate: Any
    slope: Any
    race_slope: Any


def form_at(s: Scene, ring: Body, n, sign, sweep) -> FormAt:
    """Form of race and rollers where they touch along ``n``, which turns at ``sweep`` (rad/s)."""
    flat, form, b = np.zeros(n.shape), s.model.form, s.model.bearing
    if isinstance(form, Smooth):
        return FormAt(flat, flat, flat, flat)
    race_form, depth, rate, race_slope, slope = (form.outer if sign > 0 else form.inner), flat, flat, flat, flat
    if not isinstance(race_form, Smooth):
        table = np.concatenate([race_form.pieces[:, :, 1 + sector] for sector in range(b.Z)])
        depth, race_slope = on_pieces(np.repeat(table[np.newaxis], b.Z, axis=0), angle_between(ring.angle, n))
        slope, rate = race_slope, race_slope * (sweep - ring.angular_velocity)
    if isinstance(form.rollers, UnequalRollers):
        depth = depth + form.rollers.recess[: b.Z, np.newaxis]
    elif not isinstance(form.rollers, Smooth):
        material = s.rollers.angle + pockets(b, b.theta_0)
        table = form.rollers.pieces[:, :, : b.Z].transpose(2, 0, 1)
        of_roller, roller_slope = on_pieces(table, angle_between(material, sign * n))
        depth, slope = depth + of_roller, slope + roller_slope
        rate = rate + roller_slope * (sweep - s.rollers.angular_velocity)
    return FormAt(depth, rate, slope, race_slope)


def on_pieces(tables, angle):
    """Value (m) and slope (m/rad) at ``angle`` (Z, n), rad, of a turn of pieces for each roller (Z, N, 4)."""
    count, x = tables.shape[1], np.mod(angle, 2 * np.pi) / (2 * np.pi) * tables.shape[1]
    piece = np.minimum(np.floor(x).astype(int), count - 1)
    a, b, c, d = np.moveaxis(tables[np.arange(len(tables))[:, np.newaxis], piece], -1, 0)
    x = x - piece
    return a + b * x + c * x**2 + d * x**3, (b + 2 * c * x + 3 * d * x**2) * count / (2 * np.pi)


def over_defect(law, delta, closing, head, groups, x, x_rate, form) -> PressedContacts:
    """Contacts at ``x`` (m) from the middle of a rectangular defect: all its groups together."""
    total = PressedContacts(*np.zeros((6, *delta.shape)))
    for group in groups[: int(head[GROUP_COUNT])]:
        rim = np.maximum(group[GROUP_HALF_WIDTH] - np.abs(x), 0)
        on_floor = rim**2 / (2 * head[REDUCED_RADIUS]) >= group[DEPTH]
        h = np.where(on_floor, group[DEPTH], rim**2 / (2 * head[REDUCED_RADIUS]))
        slope = np.where(on_floor, 0, -np.sign(x) * rim / head[REDUCED_RADIUS])
        # a roller's own defect turns the roller, not the race
        aside = (-slope * head[RADIUS] if head[CARRIER] < 0 else 0.0) - form.race_slope
        steep = slope * head[RADIUS] + form.slope
        contact_ = press(law, delta - h, closing - slope * x_rate, aside, steep)
        total = PressedContacts(
            *(sum_ + group[GROUP_WEIGHT] * term for sum_, term in zip(total, contact_, strict=True))
        )
    return total


def angle_between(a, n):
    """Angle (rad, within half a turn) from the direction at ``a`` (rad) to the vector ``n``."""
    return np.angle(n * np.exp(-1j * a))


def orbit(s: Scene):
    """Angular speed of each roller about the origin (rad/s)."""
    return cross(s.rollers.centre, s.rollers.velocity) / np.abs(s.rollers.centre) ** 2


def cage_contacts(s: Scene) -> Flow:
    """The contacts of the cage: pockets, and whatever guides it."""
    b, cage, rollers = s.model.bearing, s.model.cage, s.rollers
    if not isinstance(cage, FreeCage):
        return Flow(0.0, 0.0, 0.0)
    e_r = np.exp(1j * pockets(b, s.cage.angle))
    offset = rollers.centre - s.cage.centre
    speed = rollers.velocity - s.cage.velocity - 1j * s.cage.angular_velocity * offset  # as seen from the cage
    e, rho = dot(1j * e_r, offset), dot(e_r, offset)
    side = np.sign(e)
    N, N_e, stored = force(cage.pocket, np.abs(e) - cage.play, side * dot(1j * e_r, speed))
    contact_point = rollers.centre + side * b.R_w * 1j * e_r
    slip = dot(e_r, rollers.speed_of(contact_point) - s.cage.speed_of(contact_point))
    lost = (N - N_e) * side * dot(1j * e_r, speed) + mu(cage.friction, slip, 1.0) * N * slip
    flow = Flow(stored.sum(axis=0), lost.sum(axis=0), 0.0)
    if isinstance(cage.guide, RollerGuided):
        excess = rho - (b.R_o + b.R_i) / 2
        rate = np.sign(excess) * dot(e_r, speed)
        N, N_e, stored = force(cage.guide.law, np.abs(excess) - cage.guide.play, rate)
        flow += Flow(stored.sum(axis=0), ((N - N_e) * rate).sum(axis=0), 0.0)
    if isinstance(cage.guide, RingGuided):
        flow += land(s, cage.guide)
    return flow


def land(s: Scene, guide: RingGuided) -> Flow:
    """The contact of the cage with the land of a ring."""
    ring = s.ring if guide.outer else s.inner
    offset = s.cage.centre - ring.centre
    n = offset / np.abs(offset)
    rate = dot(n, s.cage.velocity - ring.velocity)
    N, N_e, stored = force(guide.law, np.abs(offset) - guide.play, rate)
    contact_point = s.cage.centre + (n if guide.outer else -n) * guide.land
    slip = dot(1j * n, s.cage.speed_of(contact_point) - ring.speed_of(contact_point))
    f = mu(guide.friction, slip, 1.0) * N
    torque = 0.0 if guide.outer else cross(contact_point - ring.centre, f * 1j * n)
    return Flow(stored, (N - N_e) * rate + f * slip, torque)
