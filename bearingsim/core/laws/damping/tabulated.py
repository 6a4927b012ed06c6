"""Damping as any function of the approach: Q = Q_e + c(delta) v."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.octaves import derivative, value
from bearingsim.core.laws.stiffness.interface import elastic, tangent


class Tabulated(NamedTuple):
    """Damping c (N s/m) tabulated over the approach (``laws/octaves.py``), from 15 pm to 16 mm.

    c tends to zero with the approach, so the force does not jump when a contact closes. Loops over rollers are not
    vectorised, because the compiler cannot prove that the table is not modified.
    """

    stiffness: Any
    table: np.ndarray


@normal_force.register(Tabulated)
def _force(contact, delta, v):
    d = max(delta, 0.0)
    return max(elastic(contact.stiffness, d) + value(contact.table, d) * v, 0.0)


@derivatives.register(Tabulated)
def _derivatives(contact, delta, v):
    d = max(delta, 0.0)
    c = value(contact.table, d)
    contact_factor = 1.0 if delta > 0.0 else 0.0
    contact_factor = contact_factor if elastic(contact.stiffness, d) + c * v > 0.0 else 0.0
    return contact_factor * (tangent(contact.stiffness, d) + derivative(contact.table, d) * v), contact_factor * c


@stiffness_bound.register(Tabulated)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta) + max(derivative(contact.table, delta) * v, 0.0)


@damping_bound.register(Tabulated)
def _damping_bound(contact, delta, v):
    return value(contact.table, delta)
