"""Scales of a case."""

import pytest

from bearingsim.assemble.scales import approach
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import Linear, PowerLaw, TenNinths


@pytest.mark.parametrize("k", [1e2, 1e8, 1e14])
def test_approach_under_a_load_for_soft_and_stiff_contacts(k: float) -> None:
    assert approach(Undamped(Linear(k)), 150.0) == pytest.approx(150.0 / k, rel=1e-9)
    assert approach(Undamped(Linear(k)), 0.0) == 0.0


@pytest.mark.parametrize("load", [1e-6, 1e-3, 1.0, 150.0, 1e5])
@pytest.mark.parametrize(
    "law", [PowerLaw(1e12, 3.0), PowerLaw(1e9, 1.05), TenNinths(1e9), make_johnson(206e9, 0.3, 10e-3, 50e-3)]
)
def test_the_approach_balances_the_load(law, load: float) -> None:
    contact = Undamped(law)
    assert normal_force(contact, approach(contact, load), 0.0) == pytest.approx(load, rel=1e-13)
