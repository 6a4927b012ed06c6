"""A contact whose force grows with the square of the approach: k in N/mm^2."""

from typing import Literal, NamedTuple

from bearingsim.config.fields import PositiveCoefficient
from bearingsim.config.fields import Section as StudySection
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent


class Section(StudySection):
    """k (delta/mm)^2."""

    law: Literal["quadratic"] = "quadratic"
    coefficient: PositiveCoefficient


class Quadratic(NamedTuple):
    """Q = k delta^2; k in N/m^2."""

    k: float


@elastic.register(Quadratic)
def _elastic(law, delta):
    return law.k * delta * delta


@tangent.register(Quadratic)
def _tangent(law, delta):
    return 2.0 * law.k * delta


@curvature.register(Quadratic)
def _curvature(law, delta):
    return 2.0 * law.k


def build(case, section, on_outer):
    return Quadratic(1e6 * section.coefficient)
