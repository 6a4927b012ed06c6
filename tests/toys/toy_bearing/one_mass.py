"""The outer ring on one spring, pushed once a ball pass."""

from math import cos
from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.crossings import count_crossings
from bearingsim.core.models.interface import (
    ModelKind,
    accelerations,
    begin,
    damping_per_mass,
    monitored_bodies,
    state_width,
    stiffness_per_mass,
    update_extremes,
)
from bearingsim.core.parameters import Bearing, Support, kinematic_angles

STIFFNESS, DAMPING, PUSH = 1e8, 1e3, 1.0  # N/m, N s/m, N


class OneMass(NamedTuple):
    """Parameters of the model."""

    bearing: Bearing
    support: Support


@state_width.register(OneMass)
def _state_width(model):
    return lay.FIRST_LANE


@accelerations.register(OneMass)
def _accelerations(model, t, y):
    theta_c, _, _ = kinematic_angles(model.bearing, t)
    push = PUSH * cos(model.bearing.Z * theta_c)
    y[lay.ACCELERATION + lay.X] = (
        push - STIFFNESS * y[lay.POSITION + lay.X] - DAMPING * y[lay.VELOCITY + lay.X]
    ) / model.bearing.m_o


@begin.register(OneMass)
def _begin(model, t, y):
    accelerations(model, t, y)


@update_extremes.register(OneMass)
def _update_extremes(model, y):
    return None


@count_crossings.register(OneMass)
def _count_crossings(model, t, y):
    return None


@monitored_bodies.register(OneMass)
def _monitored(model):
    return 1


@stiffness_per_mass.register(OneMass)
def _stiffness_per_mass(model, y, j):
    return STIFFNESS / model.bearing.m_o


@damping_per_mass.register(OneMass)
def _damping_per_mass(model, y, j):
    return DAMPING / model.bearing.m_o


KIND = ModelKind(OneMass, per_crossing=8)
