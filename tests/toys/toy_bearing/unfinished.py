"""The same dashpot, whose author has forgotten the derivatives."""

from typing import Any, Literal, NamedTuple

from bearingsim.config.fields import Damping
from bearingsim.config.fields import Section as StudySection
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, stiffness_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent


class Section(StudySection):
    """c v."""

    law: Literal["unfinished"] = "unfinished"
    c: Damping = 100.0


class Unfinished(NamedTuple):
    """Q = Q_e + c v; c in N s/m."""

    stiffness: Any
    c: float


@normal_force.register(Unfinished)
def _force(contact, delta, v):
    force = max(elastic(contact.stiffness, max(delta, 0.0)) + contact.c * v, 0.0)
    return force if delta > 0.0 else 0.0


@stiffness_bound.register(Unfinished)
def _stiffness_bound(contact, delta, v):
    return tangent(contact.stiffness, delta)


@damping_bound.register(Unfinished)
def _damping_bound(contact, delta, v):
    return contact.c


def build(case, section, stiffness, on_outer):
    return Unfinished(stiffness, section.c)
