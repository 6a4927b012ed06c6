"""Two half-planes pressed together, against Hertz, Johnson and closed forms of contact at an edge."""

from math import inf, pi

import numpy as np
import pytest

from bearingsim.core.laws.hertz import line_pressure
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import make_palmgren
from benchmarks.edges.contact import press, press_to
from benchmarks.edges.edge import contact_at_approach, contact_under_force, make_body
from benchmarks.edges.half_space import half_plane, hat_integrals, two_half_planes
from benchmarks.edges.race import Slot
from benchmarks.edges.steel import Pair, Steel

PAIR, LENGTH = Pair(), 0.012
LOADS = [5.0, 47.0, 500.0]


def smooth_contact(pair, force, nodes=121):
    b = pair.half_width(force)
    body = two_half_planes(np.linspace(-1.5, 1.5, nodes) * b, pair.E_star, pair.D)
    return body, press(body, body.t**2 / (2.0 * pair.R), force)


@pytest.mark.parametrize("load", LOADS)
def test_hertz(load):
    force = load / LENGTH
    body, contact = smooth_contact(PAIR, force)
    assert contact.pressure.max() == pytest.approx(line_pressure(force, PAIR.R, PAIR.E_star), rel=5e-4)
    b = PAIR.half_width(force)
    ellipse = np.sqrt(np.maximum(1.0 - (body.t / b) ** 2, 0.0))
    assert contact.pressure / contact.pressure.max() == pytest.approx(ellipse, abs=0.03)
    moment = float((body.spread * contact.pressure) @ body.t**2) / force
    assert 2.0 * np.sqrt(moment) == pytest.approx(b, rel=2e-3)  # of a half ellipse: b^2/4
    assert contact.approach == pytest.approx(PAIR.approach(force), rel=1e-4)


def test_a_roller_on_a_flat():
    """p = 271 sqrt(F/(D L)) N/mm2 gives 2710 N/mm2 for 40 kN on a roller 20 x 20 mm (E = 210 GPa)."""
    flat = Pair(0.010, 1e6, Steel(210e9, 0.3))
    _, contact = smooth_contact(flat, 40e3 / 0.020)
    assert contact.pressure.max() == pytest.approx(2710e6, rel=2e-3)


def test_approach_equals_johnsons_law():
    law = make_johnson(207e9, 0.3, LENGTH, 0.0325)
    for load in LOADS:
        assert elastic(law, PAIR.approach(load / LENGTH)) == pytest.approx(load, rel=1e-6)


def test_the_local_exponent():
    """d ln Q/d ln delta = Lambda/(Lambda - 1) with Lambda = 2 ln(2 D/b) + 1 grows towards 10/9 with load."""
    for load, exponent in ((5.0, 1.0605), (47.0, 1.0700), (500.0, 1.0839)):
        _, contact = smooth_contact(PAIR, load / LENGTH, 241)
        assert contact.stiffness * contact.approach / contact.force == pytest.approx(exponent, abs=1.5e-3)
    near_palmgren = elastic(make_palmgren(LENGTH), PAIR.approach(47.0 / LENGTH))
    assert near_palmgren == pytest.approx(47.0, rel=0.01)


def test_a_flat_punch():
    """The stiffness of a punch of half width a is pi E*/(2 ln(2 D/a)) (Johnson, section 2.8)."""
    a, u = 1e-4, np.linspace(-1.0, 1.0, 401)
    t = a * np.sin(0.5 * pi * u)
    contact = press_to(two_half_planes(t, PAIR.E_star, PAIR.D), np.zeros(401), 1e-7)
    assert contact.force / 1e-7 == pytest.approx(pi * PAIR.E_star / (2.0 * np.log(2.0 * PAIR.D / a)), rel=1e-3)


def test_far_compliance_equals_flamants():
    t = np.array([0.0, 1e-6, 2e-6, 5e-4])
    compliance = half_plane(t, PAIR.E_star, PAIR.D)[3, 1]
    assert compliance == pytest.approx(
        hat_integrals(t)[1] * np.log(PAIR.D / 4.99e-4) / (pi * PAIR.E_star), rel=1e-5
    )


def test_given_force_and_given_approach_agree():
    body, contact = smooth_contact(PAIR, 4000.0)
    repeated = press_to(body, body.t**2 / (2.0 * PAIR.R), contact.approach)
    assert repeated.force == pytest.approx(contact.force, rel=1e-12)
    assert press_to(body, body.t**2 / (2.0 * PAIR.R), -1e-9).force == 0.0


def test_complementarity():
    """There is no negative pressure, no overlap, and no pressure across a gap."""
    slot, force = Slot(0.1e-3, 5e-5, 1e-5), 4000.0
    body = make_body(PAIR, slot, cut_out=False)
    gap = (body.t - 4.9e-5) ** 2 / (2.0 * PAIR.R) + np.where(
        np.minimum(body.t, slot.width - body.t) > 0.0, np.minimum(body.t, slot.width - body.t) ** 2 / 2e-5, 0.0
    )
    contact = press(body, gap, force)
    clearance = gap - contact.approach + body.compliance @ contact.pressure
    assert contact.pressure.min() >= 0.0
    assert clearance.min() >= -1e-9 * contact.approach
    assert np.abs(contact.pressure * clearance).max() <= 1e-9 * contact.pressure.max() * contact.approach


@pytest.mark.parametrize("width", [2e-5, 1e-4, 0.8e-3])
def test_in_the_middle_of_a_sharp_slot_two_edges_are_as_stiff_as_the_race(width):
    """Exact for half-planes: u = t^2 maps the problem with two edges onto that of the smooth race."""
    slot, force = Slot(width, 5e-5, 0.0), 47.0 / LENGTH
    body = make_body(PAIR, slot, cut_out=False)
    assert contact_under_force(PAIR, slot, body, force, width / 2.0).ratio == pytest.approx(1.0, abs=2e-3)


def test_symmetry_of_the_slot():
    slot, force = Slot(1e-4, 2e-5, 1e-5), 47.0 / LENGTH
    body = make_body(PAIR, slot, cut_out=False)
    for s in (-1e-5, 2e-5, 4.8e-5):
        left, right = (contact_under_force(PAIR, slot, body, force, position) for position in (s, slot.width - s))
        assert left.approach == pytest.approx(right.approach, rel=1e-9)
        assert left.h == pytest.approx(right.h, abs=1e-18)


def test_one_edge_at_a_given_approach():
    slot = Slot(inf, 5e-5, 1e-5)
    body = make_body(PAIR, slot, cut_out=False)
    contact = contact_under_force(PAIR, slot, body, 4000.0, 2e-5)
    assert contact_at_approach(PAIR, slot, body, contact.approach, 2e-5).force == pytest.approx(4000.0, rel=1e-9)
    assert contact.ratio > 1.1
    assert contact.stiffness < 0.95
