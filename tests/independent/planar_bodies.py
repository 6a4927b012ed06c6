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
from bearingsim.core.parts.cage import FreeCage, OilDrag, RingGuided, RollerGuided
from bearingsim.core.parts.shaft import ElasticShaft, TorsionSpring


def places(Z: int) -> np.ndarray:
    """Places in the buffer of all that moves, positions then velocities, for Z rollers: (2 * 3 * (FIRST_LANE +
    Z),).
    """
    row = np.arange(lay.FIRST_LANE + Z)
    return np.concatenate([block + k * lay.ROW + row for block in (lay.POSITION, lay.VELOCITY) for k in range(3)])


def dot(a, b):
    """Inner product of two vectors."""
    return (np.conj(a) * b).real


def cross(a, b):
    """Moment of ``b`` at ``a``."""
    return (np.conj(a) * b).imag


class Body(NamedTuple):
    """A rigid body: centre and velocity (complex; m, m/s), angle (rad) and angular speed (rad/s)."""

    at: Any
    moves: Any
    angle: Any
    turns: Any

    def speed_of(self, point):
        """Velocity (m/s) of the body's material at ``point``."""
        return self.moves + 1j * self.turns * (point - self.at)


class Scene(NamedTuple):
    """All bodies at the instants t (n,), s."""

    model: Any
    t: Any
    rollers: Body
    ring: Body
    inner: Body
    cage: Body
    grown: Any  # the inner ring's angular acceleration, rad/s^2


def scene(model: Any, t: np.ndarray, values: np.ndarray) -> Scene:
    """The bodies of ``values`` (places, n) at ``t`` (n,), s."""
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
        (v[0, lay.FIRST_LANE :] + 1j * r * (cage.turns + v[1, lay.FIRST_LANE :])) * along,
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
    (k, m), d = as_power(law.stiffness), np.maximum(delta, 0)
    elastic = k * d**m
    return np.maximum(elastic * (1 + law.chi * rate), 0), elastic, k * d ** (m + 1) / (m + 1)


class Flow(NamedTuple):
    """What contacts do: energy stored (J), power lost (W), torque (N m) on the inner ring about its centre."""

    stored: Any
    lost: Any
    torque: Any

    def __add__(self, other):
        return Flow(*(a + b for a, b in zip(self, other, strict=True)))


class Press(NamedTuple):
    """Contacts (Z, n): force (N), energy stored (J), power lost (W), approach (m), torque on the race (N m).

    ``moment``: sum of force times dh/ds times the radius of the surface that carries the defect (N m).
    """

    force: Any
    stored: Any
    lost: Any
    mean: Any
    torque: Any
    moment: Any


def press(law, delta, rate, aside, steep=0.0) -> Press:
    """Contacts with the approach ``delta`` (m), growing at ``rate`` (m/s).

    ``aside``: arm on the race (m); ``steep``: dh/ds times the radius of what carries the defect (m).
    """
    Q, Q_e, stored = force(law, delta, rate)
    return Press(Q, stored, (Q - Q_e) * rate, np.maximum(delta, 0), Q * aside, Q * steep)


def race(s: Scene, outer: bool) -> Flow:
    """All contacts of the rollers with one race."""
    model, b, rollers, ring = s.model, s.model.bearing, s.rollers, (s.ring if outer else s.inner)
    law, sign = (model.outer, 1.0) if outer else (model.inner, -1.0)
    apart, speed = rollers.at - ring.at, rollers.moves - ring.moves
    rho = np.abs(apart)
    n = apart / rho
    delta, closing = (rho + b.R_w - b.R_o if outer else b.R_i + b.R_w - rho), sign * dot(n, speed)
    found = press(law, delta, closing, 0.0)
    for head, groups in zip(model.defects.head, model.defects.groups, strict=True):
        if head[SIDE] == (0 if outer else 1):
            x, x_rate = passing(s, head, ring, n, sign, dot(1j * n, speed) / rho)
            over = over_defect(law, delta, closing, head, groups, x, x_rate)
            found = Press(*np.where(np.abs(x) < head[HALF_WIDTH], over, found))
    normal = n - sign * found.moment / (rho * np.maximum(found.force, 1e-300)) * 1j * n
    normal /= np.abs(normal)
    touch = rollers.at + sign * (b.R_w - found.mean / 2) * normal
    slip = dot(1j * normal, rollers.speed_of(touch) - ring.speed_of(touch))
    f = mu(model.friction, slip, b.R_w * np.abs(orbit(s) - rollers.turns)) * found.force
    torque = cross(touch - ring.at, f * 1j * normal) + found.torque
    return Flow(
        found.stored.sum(axis=0), (found.lost + f * slip).sum(axis=0), 0.0 if outer else torque.sum(axis=0)
    )


def passing(s: Scene, head, ring: Body, n, sign, sweep):
    """Distance (m) of rollers from a defect's middle, infinite if it is not theirs, and its rate (m/s)."""
    if head[CARRIER] < 0:
        x = head[RADIUS] * angle_between(ring.angle + head[ANGLE], n)
        return x, head[RADIUS] * (sweep - ring.turns)
    b, own = s.model.bearing, np.full((s.model.bearing.Z, 1), np.inf)
    own[int(head[CARRIER])] = 0.0
    defect = s.rollers.angle + pockets(b, b.theta_0) + head[ANGLE]
    return own + head[RADIUS] * angle_between(defect, sign * n), head[RADIUS] * (sweep - s.rollers.turns)


def over_defect(law, delta, closing, head, groups, x, x_rate) -> Press:
    """Contacts at ``x`` (m) from the middle of a rectangular defect: all its groups together."""
    total = Press(*np.zeros((6, *delta.shape)))
    for group in groups[: int(head[GROUP_COUNT])]:
        rim = np.maximum(group[GROUP_HALF_WIDTH] - np.abs(x), 0)
        on_floor = rim**2 / (2 * head[REDUCED_RADIUS]) >= group[DEPTH]
        h = np.where(on_floor, group[DEPTH], rim**2 / (2 * head[REDUCED_RADIUS]))
        slope = np.where(on_floor, 0, -np.sign(x) * rim / head[REDUCED_RADIUS])
        # a roller's own defect turns the roller, not the race
        aside = -slope * head[RADIUS] if head[CARRIER] < 0 else 0.0
        part = press(law, delta - h, closing - slope * x_rate, aside, slope * head[RADIUS])
        total = Press(*(so_far + group[GROUP_WEIGHT] * more for so_far, more in zip(total, part, strict=True)))
    return total


def angle_between(a, n):
    """Angle (rad, within half a turn) from the direction at ``a`` (rad) to the vector ``n``."""
    return np.angle(n * np.exp(-1j * a))


def orbit(s: Scene):
    """Angular speed of each roller about the origin (rad/s)."""
    return cross(s.rollers.at, s.rollers.moves) / np.abs(s.rollers.at) ** 2


def cage_contacts(s: Scene) -> Flow:
    """The contacts of the cage: pockets, and whatever guides it."""
    b, cage, rollers = s.model.bearing, s.model.cage, s.rollers
    if not isinstance(cage, FreeCage):
        return Flow(0.0, 0.0, 0.0)
    e_r = np.exp(1j * pockets(b, s.cage.angle))
    apart = rollers.at - s.cage.at
    speed = rollers.moves - s.cage.moves - 1j * s.cage.turns * apart  # as seen from the cage
    e, rho = dot(1j * e_r, apart), dot(e_r, apart)
    side = np.sign(e)
    N, N_e, stored = force(cage.pocket, np.abs(e) - cage.play, side * dot(1j * e_r, speed))
    wall = rollers.at + side * b.R_w * 1j * e_r
    slip = dot(e_r, rollers.speed_of(wall) - s.cage.speed_of(wall))
    lost = (N - N_e) * side * dot(1j * e_r, speed) + mu(cage.friction, slip, 1.0) * N * slip
    found = Flow(stored.sum(axis=0), lost.sum(axis=0), 0.0)
    if isinstance(cage.guide, RollerGuided):
        out = rho - (b.R_o + b.R_i) / 2
        rate = np.sign(out) * dot(e_r, speed)
        N, N_e, stored = force(cage.guide.law, np.abs(out) - cage.guide.play, rate)
        found += Flow(stored.sum(axis=0), ((N - N_e) * rate).sum(axis=0), 0.0)
    if isinstance(cage.guide, RingGuided):
        found += land(s, cage.guide)
    return found


def land(s: Scene, guide: RingGuided) -> Flow:
    """The contact of the cage with the land of a ring."""
    ring = s.ring if guide.outer else s.inner
    apart = s.cage.at - ring.at
    n = apart / np.abs(apart)
    rate = dot(n, s.cage.moves - ring.moves)
    N, N_e, stored = force(guide.law, np.abs(apart) - guide.play, rate)
    touch = s.cage.at + (n if guide.outer else -n) * guide.land
    slip = dot(1j * n, s.cage.speed_of(touch) - ring.speed_of(touch))
    f = mu(guide.friction, slip, 1.0) * N
    torque = 0.0 if guide.outer else cross(touch - ring.at, f * 1j * n)
    return Flow(stored, (N - N_e) * rate + f * slip, torque)


class Balance(NamedTuple):
    """What there is of momentum and energy, and what changes it from outside: (n,) each.

    momentum (N s, complex), spin (N m s, about the origin; without the inner ring's own), energy (J); force (N,
    complex), torque (N m, about the origin), power put in (W), power lost (W).
    """

    momentum: Any
    spin: Any
    energy: Any
    force: Any
    torque: Any
    power: Any
    lost: Any


def balance(s: Scene) -> Balance:
    """All sums over the bodies and over what acts on them from outside.

    The force does not hold for a rigid shaft or a cage whose centre is held, the torque not for a ring that is.
    """
    contacts = race(s, outer=True) + race(s, outer=False) + cage_contacts(s)
    momentum, spin, energy = inertia(s)
    springs, dampers, loads = from_springs(s), from_dampers(s), from_loads(s)
    acting = [*springs, *dampers, *loads]
    twist, twist_stored, twist_lost = twists(s)
    power = sum(dot(push.moves, push.force) for push in loads) - contacts.torque * s.inner.turns
    lost = contacts.lost - sum(dot(push.moves, push.force) for push in dampers)
    oil = land_drag(s)
    dragged = s.inner.turns if isinstance(s.model.drag, OilDrag) and s.model.drag.outer == 0.0 else 0.0
    return Balance(
        momentum=momentum,
        spin=spin,
        energy=energy + contacts.stored + twist_stored + stored_by_springs(s),
        force=sum(push.force for push in acting),
        torque=sum(cross(push.at, push.force) for push in acting) + twist + oil - contacts.torque,
        power=power + oil * dragged,
        lost=lost + twist_lost - oil * (s.cage.turns - dragged),
    )


def masses(s: Scene) -> list[tuple[float, float, Body]]:
    """Mass (kg), moment of inertia (kg m^2) and motion of each body; 0 for what is not free to move or turn."""
    model, b = s.model, s.model.bearing
    found = [(b.m_r, b.I_r, Body(*(part[j] for part in s.rollers))) for j in range(b.Z)]
    found.append((b.m_o, model.bracket.inertia if isinstance(model.bracket, TorsionSpring) else 0.0, s.ring))
    if isinstance(model.cage, FreeCage):
        found.append((model.cage.m, model.cage.inertia, s.cage))
    if isinstance(model.shaft, ElasticShaft):
        found.append((model.shaft.m, 0.0, s.inner))
    return found


def inertia(s: Scene) -> tuple[Any, Any, Any]:
    """Momentum, angular momentum about the origin and kinetic energy."""
    bodies = masses(s)
    return (
        sum(m * body.moves for m, _, body in bodies),
        sum(m * cross(body.at, body.moves) + turning * body.turns for m, turning, body in bodies),
        sum(m * np.abs(body.moves) ** 2 + turning * body.turns**2 for m, turning, body in bodies) / 2,
    )


class Push(NamedTuple):
    """A force (N) on what moves at ``moves`` (m/s), where it acts (m); all complex."""

    at: Any
    force: Any
    moves: Any


def from_loads(s: Scene) -> list[Push]:
    """Load, gravity, unbalance: what puts work in."""
    model, support, shaft = s.model, s.model.support, s.model.shaft
    load = support.F + 1j * support.F_across
    found = [Push(s.ring.at, -load, s.ring.moves)]
    found += [Push(at, model.bearing.m_r * model.gravity, moves) for at, moves in zip(*s.rollers[:2], strict=True)]
    if isinstance(model.cage, FreeCage):
        found.append(Push(s.cage.at, model.cage.m * model.gravity, s.cage.moves))
    if isinstance(shaft, ElasticShaft):
        heavy = shaft.unbalance * np.exp(1j * (s.inner.angle + shaft.angle))  # flung outwards, left behind
        flung = (s.inner.turns**2 - 1j * s.grown) * heavy
        found += [Push(s.inner.at, load, s.inner.moves), Push(s.inner.at, flung, s.inner.moves)]
    return found


def from_springs(s: Scene) -> list[Push]:
    """Bracket and shaft."""
    support, shaft = s.model.support, s.model.shaft
    found = [Push(s.ring.at, -support.k_b * (s.ring.at - support.x_0 - 1j * support.y_0), s.ring.moves)]
    if isinstance(shaft, ElasticShaft):
        found.append(Push(s.inner.at, -shaft.k * s.inner.at, s.inner.moves))
    return found


def stored_by_springs(s: Scene) -> Any:
    """Their energy (J)."""
    support, shaft = s.model.support, s.model.shaft
    stored = support.k_b / 2 * np.abs(s.ring.at - support.x_0 - 1j * support.y_0) ** 2
    return stored + (shaft.k / 2 * np.abs(s.inner.at) ** 2 if isinstance(shaft, ElasticShaft) else 0.0)


def from_dampers(s: Scene) -> list[Push]:
    """Dampers of bracket and shaft; the oil that the rollers plough through."""
    found = [Push(s.ring.at, -s.model.support.c_b * s.ring.moves, s.ring.moves)]
    if isinstance(s.model.shaft, ElasticShaft):
        found.append(Push(s.inner.at, -s.model.shaft.c * s.inner.moves, s.inner.moves))
    if isinstance(s.model.drag, OilDrag):
        ahead = 1j * s.rollers.at / np.abs(s.rollers.at)
        v = dot(ahead, s.rollers.moves)
        oil = -s.model.drag.roller * v * np.abs(v) * ahead
        found += [Push(*of_one) for of_one in zip(s.rollers.at, oil, s.rollers.moves, strict=True)]
    return found


def land_drag(s: Scene) -> Any:
    """Torque (N m) of the oil between cage and ring on the cage; the outer ring counts as standing."""
    drag = s.model.drag
    if not isinstance(drag, OilDrag):
        return np.zeros_like(s.t)
    return -drag.land * (s.cage.turns - (0.0 if drag.outer else s.inner.turns))


def twists(s: Scene) -> tuple[Any, Any, Any]:
    """The torsion spring and damper of the outer ring: torque (N m), energy stored (J), power lost (W)."""
    spring = s.model.bracket
    if not isinstance(spring, TorsionSpring):
        return 0.0, 0.0, 0.0
    torque = -spring.k * s.ring.angle - spring.c * s.ring.turns
    return torque, spring.k / 2 * s.ring.angle**2, spring.c * s.ring.turns**2
