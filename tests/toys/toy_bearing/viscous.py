"""A dashpot beside the contact: its force does not depend on the approach."""

from typing import Any, Literal, NamedTuple

from bearingsim.config.fields import Damping
from bearingsim.config.fields import Section as StudySection
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent

SHARE = 1.0


class Section(StudySection):
    """c v."""

    law: Literal["viscous"] = "viscous"
    c: Damping = 100.0


class Viscous(NamedTuple):
    """Q = Q_e + c v; c in N s/m."""

    stiffness: Any
    c: float


@normal_force.register(Viscous)
def _force(contact, delta, v):
    force = max(elastic(contact.stiffness, max(delta, 0.0)) + SHARE * contact.c * v, 0.0)
    return force if delta > 0.0 else 0.0


@derivatives.register(Viscous)
def _derivatives(contact, delta, v):
    pressing = 1.0 if delta > 0.0 else 0.0
    pressing = pressing if elastic(contact.stiffness, max(delta, 0.0)) + SHARE * contact.c * v > 0.0 else 0.0
    return pressing * tangent(contact.stiffness, max(delta, 0.0)), pressing * SHARE * contact.c


@stiffness_bound.register(Viscous)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta)


@damping_bound.register(Viscous)
def _damping_bound(contact, delta, v):
    return SHARE * contact.c


def build(case, section, stiffness, on_outer):
    return Viscous(stiffness, section.c)
