"""The outer ring on one spring, pushed once a ball pass."""

from math import cos
from typing import NamedTuple

from bearingsim.core.layout import ACCELERATION, LANES, POSITION, VELOCITY, X
from bearingsim.core.models.interface import (
    ModelKind,
    accelerations,
    begin,
    damping_per_mass,
    keep_extremes,
    stiffness_per_mass,
    watched,
    width,
)
from bearingsim.core.parameters import Bearing, Support, turns
from bearingsim.core.pits.crossings import spot

STIFFNESS, DAMPING, PUSH = 1e8, 1e3, 1.0  # N/m, N s/m, N


class OneMass(NamedTuple):
    """Parameters of the model."""

    bearing: Bearing
    support: Support


@width.register(OneMass)
def _width(model):
    return LANES


@accelerations.register(OneMass)
def _accelerations(model, t, y):
    theta_c, _, _ = turns(model.bearing, t)
    push = PUSH * cos(model.bearing.Z * theta_c)
    y[ACCELERATION + X] = (push - STIFFNESS * y[POSITION + X] - DAMPING * y[VELOCITY + X]) / model.bearing.m_o


@begin.register(OneMass)
def _begin(model, t, y):
    accelerations(model, t, y)


@keep_extremes.register(OneMass)
def _keep_extremes(model, y):
    return None


@spot.register(OneMass)
def _spot(model, t, y):
    return None


@watched.register(OneMass)
def _watched(model):
    return 1


@stiffness_per_mass.register(OneMass)
def _stiffness_per_mass(model, y, j):
    return STIFFNESS / model.bearing.m_o


@damping_per_mass.register(OneMass)
def _damping_per_mass(model, y, j):
    return DAMPING / model.bearing.m_o


KIND = ModelKind(OneMass, per_crossing=8)
