"""What the model `impulse` is built from."""

import pytest

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.simulation.limits import loads_at_rest

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
BASE = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "impulse", "defect": SLOT}


def impulse(**fields: object) -> Case:
    return Case.model_validate(BASE | fields)


def test_the_ring_is_damped_by_its_contacts() -> None:
    """As `ring` is at rest, whose largest damping over a pass the mean is below."""
    case = impulse()
    found, ring = assemble.model(case), case.model_copy(update={"model": "ring", "method": "verlet"})
    _, _, most = loads_at_rest(ring)
    of_contacts = found.C_x - case.rig.bracket_damping
    assert 0.3 * most < of_contacts / found.m < most


def test_twice_the_damping_time_damps_twice() -> None:
    once, twice = (assemble.model(impulse(contact={"damping": {"beta": beta}})) for beta in ("2 us", "4 us"))
    bracket = impulse().rig.bracket_damping
    assert twice.C_x - bracket == pytest.approx(2.0 * (once.C_x - bracket))
    assert twice.C_y - bracket == pytest.approx(2.0 * (once.C_y - bracket))
