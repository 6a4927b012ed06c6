"""Damping proportional to the tangent stiffness, after Kraemer."""

from typing import Any, NamedTuple

from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent


class Kraemer(NamedTuple):
    """Damping proportional to the tangent stiffness: Q = Q_e + beta Q_e' v. beta in s.

    Source: Kraemer, Dynamics of Rotors and Foundations 1993: 0.25e-5 .. 2.5e-5 s for rolling bearings. At
    touch-down the damping force rises almost as a jump, as delta^(m1 - 1) with m1 = 10/9 for line contact.
    """

    stiffness: Any
    beta: float


@normal_force.register(Kraemer)
def _force(contact, delta, v):
    d = max(delta, 0.0)
    force = max(elastic(contact.stiffness, d) + contact.beta * tangent(contact.stiffness, d) * v, 0.0)
    return force if delta > 0.0 else 0.0  # for m1 = 1 the stiffness at delta = 0 is not zero


@derivatives.register(Kraemer)
def _derivatives(contact, delta, v):
    d, rate = max(delta, 0.0), contact.beta * v
    stiffness = tangent(contact.stiffness, d)
    contact_factor = 1.0 if delta > 0.0 else 0.0
    contact_factor = contact_factor if elastic(contact.stiffness, d) + stiffness * rate > 0.0 else 0.0
    K = contact_factor * (stiffness + curvature(contact.stiffness, d) * rate)
    C = contact_factor * stiffness * contact.beta
    return K, C


@stiffness_bound.register(Kraemer)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta)  # without the curvature, which is infinite at touch-down


@damping_bound.register(Kraemer)
def _damping_bound(contact, delta, v):
    return contact.beta * tangent(contact.stiffness, delta)
