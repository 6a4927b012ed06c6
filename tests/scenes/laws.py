"""Elastic laws to test with, one of each; forces of a row of contacts; derivatives by differences."""

from collections.abc import Callable
from typing import Any

import pytest

from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import Linear, PowerLaw, TenNinths, ThreeHalves
from bearingsim.core.models.ring import DampedRates
from tests.scenes.lanes import ROW, compiled

STEEL = TenNinths(1.58e9)
LINE = make_johnson(207e9, 0.3, 0.012, 0.0325)  # NF308: 12 mm roller, R_i + R_w = R_o - R_w = 32.5 mm
STIFFNESSES = [STEEL, ThreeHalves(2.7e10), Linear(3e8), PowerLaw(5e9, 1.2), LINE]
every_stiffness = pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)


@compiled
def force_of_lanes(law, y, width):
    for j in range(width):
        y[2 * ROW + j] = normal_force(law, y[j], y[ROW + j])


def slope(function: Callable[[float], float], x: float, h: float) -> float:
    """Central difference of fourth order."""
    near, far = function(x + h) - function(x - h), function(x + 2.0 * h) - function(x - 2.0 * h)
    return (8.0 * near - far) / (12.0 * h)


def with_laws(model: Any, outer: Any, inner: Any) -> Any:
    """Return a model with other contact laws at its races."""
    division = {"rate_division": DampedRates()} if "rate_division" in model._fields else {}
    return model._replace(outer=outer, inner=inner, **division)
