"""Momentum and energy of the bodies of `planar`, and the external forces that change them."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.parts.cage import FreeCage, OilDrag
from bearingsim.core.parts.shaft import ElasticShaft, TorsionSpring
from tests.independent.planar_bodies import Body, Scene, cage_contacts, cross, dot, race


class Balance(NamedTuple):
    """Momentum and energy, and the external forces and power that change them: (n,) each.

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
    """Return all sums over the bodies and over the external forces on them.

    The balance of forces excludes a rigid shaft and a centred cage, that of torques a fixed ring.
    """
    contacts = race(s, outer=True) + race(s, outer=False) + cage_contacts(s)
    momentum, spin, energy = inertia(s)
    springs, dampers, loads = spring_forces(s), damper_forces(s), load_forces(s)
    forces = [*springs, *dampers, *loads]
    torsion, torsion_energy, torsion_loss = bracket_torsion(s)
    power = (
        sum(dot(force_.velocity, force_.force) for force_ in loads) - contacts.torque * s.inner.angular_velocity
    )
    lost = contacts.lost - sum(dot(force_.velocity, force_.force) for force_ in dampers)
    drag_torque = land_drag(s)
    drag_speed = (
        s.inner.angular_velocity if isinstance(s.model.drag, OilDrag) and s.model.drag.outer == 0.0 else 0.0
    )
    return Balance(
        momentum=momentum,
        spin=spin,
        energy=energy + contacts.stored + torsion_energy + stored_by_springs(s),
        force=sum(force_.force for force_ in forces),
        torque=sum(cross(force_.centre, force_.force) for force_ in forces)
        + torsion
        + drag_torque
        - contacts.torque,
        power=power + drag_torque * drag_speed,
        lost=lost + torsion_loss - drag_torque * (s.cage.angular_velocity - drag_speed),
    )


def masses(s: Scene) -> list[tuple[float, float, Body]]:
    """Mass (kg), moment of inertia (kg m^2) and motion of each body; 0 for what is not free to move or turn."""
    model, b = s.model, s.model.bearing
    bodies = [(b.m_r, b.I_r, Body(*(part[j] for part in s.rollers))) for j in range(b.Z)]
    bodies.append((b.m_o, model.bracket.inertia if isinstance(model.bracket, TorsionSpring) else 0.0, s.ring))
    if isinstance(model.cage, FreeCage):
        bodies.append((model.cage.m, model.cage.inertia, s.cage))
    if isinstance(model.shaft, ElasticShaft):
        bodies.append((model.shaft.m, 0.0, s.inner))
    return bodies


def inertia(s: Scene) -> tuple[Any, Any, Any]:
    """Momentum, angular momentum about the origin and kinetic energy."""
    bodies = masses(s)
    return (
        sum(m * body.velocity for m, _, body in bodies),
        sum(
            m * cross(body.centre, body.velocity) + moment_of_inertia * body.angular_velocity
            for m, moment_of_inertia, body in bodies
        ),
        sum(
            m * np.abs(body.velocity) ** 2 + moment_of_inertia * body.angular_velocity**2
            for m, moment_of_inertia, body in bodies
        )
        / 2,
    )


class AppliedForce(NamedTuple):
    """Force (N), its point of action (m), and the velocity (m/s) of this point; all complex."""

    centre: Any
    force: Any
    velocity: Any


def load_forces(s: Scene) -> list[AppliedForce]:
    """Load, gravity, unbalance: what puts work in."""
    model, support, shaft = s.model, s.model.support, s.model.shaft
    load = support.F + 1j * support.F_across
    forces = [AppliedForce(s.ring.centre, -load, s.ring.velocity)]
    forces += [
        AppliedForce(centre, model.bearing.m_r * model.gravity, velocity)
        for centre, velocity in zip(*s.rollers[:2], strict=True)
    ]
    if isinstance(model.cage, FreeCage):
        forces.append(AppliedForce(s.cage.centre, model.cage.m * model.gravity, s.cage.velocity))
    if isinstance(shaft, ElasticShaft):
        unbalance = shaft.unbalance * np.exp(1j * (s.inner.angle + shaft.angle))  # flung outwards, left behind
        unbalance_force = (s.inner.angular_velocity**2 - 1j * s.angular_acceleration) * unbalance
        forces += [
            AppliedForce(s.inner.centre, load, s.inner.velocity),
            AppliedForce(s.inner.centre, unbalance_force, s.inner.velocity),
        ]
    return forces


def spring_forces(s: Scene) -> list[AppliedForce]:
    """Bracket and shaft."""
    support, shaft = s.model.support, s.model.shaft
    forces = [
        AppliedForce(
            s.ring.centre, -support.k_b * (s.ring.centre - support.x_0 - 1j * support.y_0), s.ring.velocity
        )
    ]
    if isinstance(shaft, ElasticShaft):
        forces.append(AppliedForce(s.inner.centre, -shaft.k * s.inner.centre, s.inner.velocity))
    return forces


def stored_by_springs(s: Scene) -> Any:
    """Their energy (J)."""
    support, shaft = s.model.support, s.model.shaft
    stored = support.k_b / 2 * np.abs(s.ring.centre - support.x_0 - 1j * support.y_0) ** 2
    return stored + (shaft.k / 2 * np.abs(s.inner.centre) ** 2 if isinstance(shaft, ElasticShaft) else 0.0)


def damper_forces(s: Scene) -> list[AppliedForce]:
    """Dampers of bracket and shaft; the oil that the rollers plough through."""
    forces = [AppliedForce(s.ring.centre, -s.model.support.c_b * s.ring.velocity, s.ring.velocity)]
    if isinstance(s.model.shaft, ElasticShaft):
        forces.append(AppliedForce(s.inner.centre, -s.model.shaft.c * s.inner.velocity, s.inner.velocity))
    if isinstance(s.model.drag, OilDrag):
        direction = 1j * s.rollers.centre / np.abs(s.rollers.centre)
        v = dot(direction, s.rollers.velocity)
        drag = -s.model.drag.roller * v * np.abs(v) * direction
        forces += [
            AppliedForce(*arguments) for arguments in zip(s.rollers.centre, drag, s.rollers.velocity, strict=True)
        ]
    return forces


def land_drag(s: Scene) -> Any:
    """Torque (N m) of the oil between cage and ring on the cage; the outer ring counts as standing."""
    drag = s.model.drag
    if not isinstance(drag, OilDrag):
        return np.zeros_like(s.t)
    return -drag.land * (s.cage.angular_velocity - (0.0 if drag.outer else s.inner.angular_velocity))


def bracket_torsion(s: Scene) -> tuple[Any, Any, Any]:
    """The torsion spring and damper of the outer ring: torque (N m), energy stored (J), power lost (W)."""
    spring = s.model.bracket
    if not isinstance(spring, TorsionSpring):
        return 0.0, 0.0, 0.0
    torque = -spring.k * s.ring.angle - spring.c * s.ring.angular_velocity
    return torque, spring.k / 2 * s.ring.angle**2, spring.c * s.ring.angular_velocity**2
