"""Momentum and energy of the bodies of `spatial`, and the external forces that change them."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.parts.cage import FreeCage, OilDrag
from bearingsim.core.parts.mounts import ElasticMount
from bearingsim.core.parts.shaft import ElasticShaft, TorsionSpring
from tests.independent.spatial_bodies import (
    UP,
    Body,
    Scene,
    cage_contacts,
    dot,
    flanges,
    polar_unit_vectors,
    race,
    times,
    unit,
)


class Balance(NamedTuple):
    """Momentum, angular momentum about the origin and energy, and the external forces and power that change them.

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
    applied, moments = outside_forces(s)
    stored = 0.0
    forces = [entry[:2] for entry in applied]
    return Balance(
        momentum,
        spin,
        energy + contacts.stored + stored,
        sum(force for _, force in forces),
        sum(np.cross(centre, force) for centre, force in forces) + sum(moment for moment, _ in moments),
        sum(dot(force, velocity) for _, force, velocity in applied) + sum(dot(moment, w) for moment, w in moments),
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
        p = np.array([m, m, m_z]) * body.velocity
        momentum = momentum + p
        spin = spin + np.cross(body.centre, p) + I_t * np.cross(body.axis, body.axis_rate)
        spin = spin + times(I_a * body.spin(), body.axis)
        energy = (
            energy
            + (dot(p, body.velocity) + I_t * dot(body.axis_rate, body.axis_rate) + I_a * body.spin() ** 2) / 2
        )
    return momentum, spin, energy


def outside_forces(s: Scene):
    """Forces as (at, force, velocity) and moments as (moment, angular velocity): loads, springs, dampers, oil."""
    model, support, shaft = s.model, s.model.support, s.model.shaft
    flat = np.array([1.0, 1.0, 0.0])
    load = np.array([support.F, support.F_across, 0.0])
    anchor = np.array([support.x_0, support.y_0, 0.0])
    bracket = -support.k_b * flat * (s.ring.centre - anchor) - support.c_b * flat * s.ring.velocity
    forces = [(s.ring.centre, bracket - load, s.ring.velocity)]
    moments = []
    if isinstance(shaft, ElasticShaft):
        direction, normal = polar_unit_vectors(s.inner.angle + shaft.angle)
        unbalance_force = shaft.unbalance * (
            times(s.inner.angular_velocity**2, direction) - times(s.angular_acceleration, normal)
        )
        shaft_force = -shaft.k * flat * s.inner.centre - shaft.c * flat * s.inner.velocity
        forces.append((s.inner.centre, load + unbalance_force + shaft_force, s.inner.velocity))
    for mount, ring in ((model.mount_o, s.ring), (model.mount_i, s.inner)):
        if isinstance(mount, ElasticMount):
            tilt = ring.axis - np.array([mount.tilt_x, mount.tilt_y, 0.0])
            tilt_force = flat * (-mount.k_tilt * tilt - mount.c_tilt * ring.axis_rate)
            moments.append((np.cross(ring.axis, tilt_force), ring.rotation()))
            axial_force = times(-mount.k_z * ring.centre[:, 2] - mount.c_z * ring.velocity[:, 2], UP)
            forces.append((ring.centre, axial_force, ring.velocity))
    if isinstance(model.bracket, TorsionSpring):
        torque = -model.bracket.k * s.ring.angle - model.bracket.c * s.ring.angular_velocity
        moments.append((times(torque, s.ring.axis), s.ring.rotation()))
    g = model.gravity * np.array([1.0, 0.0, 0.0])
    b, r = model.bearing, s.rollers
    for j in range(b.Z):
        forces.append((r.centre[:, j], b.m_r * g + 0 * r.centre[:, j], r.velocity[:, j]))
        if isinstance(model.drag, OilDrag):
            tangent = np.cross(UP, unit(r.centre[:, j] * flat))
            v = dot(tangent, r.velocity[:, j])
            forces.append((r.centre[:, j], times(-model.drag.roller * v * np.abs(v), tangent), r.velocity[:, j]))
    if isinstance(model.cage, FreeCage):
        forces.append((s.cage.centre, model.cage.m * g + 0 * s.cage.centre, s.cage.velocity))
        if isinstance(model.drag, OilDrag):
            slower = s.cage.angular_velocity - (0.0 if model.drag.outer else s.inner.angular_velocity)
            moments.append((times(-model.drag.land * slower, s.cage.axis), s.cage.rotation()))
    return forces, moments
