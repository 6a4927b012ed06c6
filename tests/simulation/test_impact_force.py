"""Estimated impact force, compared with the largest contact force of a run.

Five scenes of benchmarks/impact_force.py in which an element strikes; all sixty are within a factor 2.
"""

import pytest

from benchmarks.impact_force import FACTOR, forces, scene

STRIKING = (19, 28, 37, 49, 52)
"""NF308 with chi, NF308 of the catalogue with 25 us, 209 twice with chi, NF308 of the catalogue with 25 us."""


@pytest.mark.parametrize("number", STRIKING)
def test_impact_force_is_estimated_within_a_factor_of_2(number: int) -> None:
    estimated, largest = forces(scene(number, duration="60 ms"))
    assert 1.0 / FACTOR < estimated / largest < FACTOR
