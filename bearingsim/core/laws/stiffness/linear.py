"""A linear spring."""

from typing import NamedTuple

from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent
from bearingsim.core.laws.stiffness.series import as_power


class Linear(NamedTuple):
    """Q = k delta; k in N/m."""

    k: float


@elastic.register(Linear)
def _elastic(law, delta):
    return law.k * delta


@tangent.register(Linear)
def _tangent(law, delta):
    return law.k


@curvature.register(Linear)
def _curvature(law, delta):
    return 0.0


@as_power.register(Linear)
def _as_power(law):
    return law.k, 1.0
