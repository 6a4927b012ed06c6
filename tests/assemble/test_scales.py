"""Scales of a case."""

import pytest

from bearingsim.assemble.scales import approach
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.stiffness.power_laws import Linear


@pytest.mark.parametrize("k", [1e2, 1e8, 1e14])
def test_approach_under_a_load_for_soft_and_stiff_contacts(k: float) -> None:
    assert approach(Undamped(Linear(k)), 150.0) == pytest.approx(150.0 / k, rel=1e-9)
    assert approach(Undamped(Linear(k)), 0.0) == 0.0
