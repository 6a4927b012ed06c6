"""Elastic contact without damping."""

from typing import Any, NamedTuple

from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent


class Undamped(NamedTuple):
    """No damping, Q = Q_e. Used for static equilibria, whose code is then compiled only once for all damping
    laws."""

    stiffness: Any


@normal_force.register(Undamped)
def _force(contact, delta, v):
    return elastic(contact.stiffness, max(delta, 0.0))


@derivatives.register(Undamped)
def _derivatives(contact, delta, v):
    contact_factor = 1.0 if delta > 0.0 else 0.0
    return contact_factor * tangent(contact.stiffness, max(delta, 0.0)), 0.0


@stiffness_bound.register(Undamped)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta)


@damping_bound.register(Undamped)
def _damping_bound(contact, delta, v):
    return 0.0
