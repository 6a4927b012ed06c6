"""Damping proportional to the elastic force, after Hunt and Crossley."""

from typing import Any, NamedTuple

from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent


class HuntCrossley(NamedTuple):
    """Damping proportional to the elastic force: Q = Q_e (1 + chi v). chi in s/m.

    Continuous at touch-down. Source: Hunt and Crossley 1975. chi is the most uncertain parameter of the model:
    0.1-0.5 s/m for dry steel, far more for a lubricated contact.
    """

    stiffness: Any
    chi: float


@normal_force.register(HuntCrossley)
def _force(contact, delta, v):
    return max(elastic(contact.stiffness, max(delta, 0.0)) * (1.0 + contact.chi * v), 0.0)


@derivatives.register(HuntCrossley)
def _derivatives(contact, delta, v):
    d, damping_factor = max(delta, 0.0), 1.0 + contact.chi * v
    contact_factor = 1.0 if delta > 0.0 else 0.0
    contact_factor = contact_factor if damping_factor > 0.0 else 0.0
    K = contact_factor * tangent(contact.stiffness, d) * damping_factor
    C = contact_factor * elastic(contact.stiffness, d) * contact.chi
    return K, C


@stiffness_bound.register(HuntCrossley)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta) * max(1.0 + contact.chi * v, 0.0)


@damping_bound.register(HuntCrossley)
def _damping_bound(contact, delta, v):
    return contact.chi * elastic(contact.stiffness, delta)
