"""The free ring, as an elastic body and as a curved beam: against closed forms and against each other."""

import numpy as np
import pytest

from tests.independent import beam_ring, ring_elements
from tests.independent.beam_ring import Beam, compliance, frequencies, matrices, modes
from tests.independent.ring_elements import NF308, compliances, free_frequencies

ORDERS = range(2, 9)
FINE = (6, 144)


def test_elements_under_pressure_are_a_thick_tube():
    """Pressure on the race: Lamé's radial displacement at the mid-line, in plane stress."""
    inside, outside, middle = NF308.inside, NF308.outside, NF308.middle
    pressure = 1 / (2 * np.pi * inside * NF308.breadth)
    share = pressure * inside**2 / (outside**2 - inside**2)
    grown = share / NF308.young * ((1 - NF308.poisson) * middle + (1 + NF308.poisson) * outside**2 / middle)
    assert compliances([0], load_at=inside) == pytest.approx(grown, rel=1e-5)


def test_elements_converge():
    """The usual mesh is within 0.1 % of one with twice as many cells each way."""
    assert compliances(ORDERS) == pytest.approx(compliances(ORDERS, NF308, None, 8, 192), rel=1e-3)
    assert free_frequencies() == pytest.approx(free_frequencies(8, NF308, 8, 192), rel=1e-3)


def test_elements_of_a_thin_ring_are_the_thin_ring():
    """h/R = 1/50: within 0.2 % of the thin ring's closed forms, n = 2 and 3."""
    thin = ring_elements.Section(inside=0.0495, outside=0.0505)
    radius, bending = thin.middle, thin.young * thin.breadth * 1e-9 / 12
    mass = np.pi * radius * thin.density * thin.breadth * 1e-3
    orders = np.array([2, 3])
    stiff = np.pi * bending * (orders**2 - 1) ** 2 / radius**3
    assert compliances(orders, thin, None, 2, 144) == pytest.approx(1 / stiff, rel=2e-3)
    own = np.sqrt(stiff / (mass * (1 + 1 / orders**2))) / (2 * np.pi)
    assert free_frequencies(4, thin, 2, 144)[::2] == pytest.approx(own, rel=2e-3)


def test_beam_agrees_with_finite_elements():
    """Frequencies n = 2 to 5 within 0.3 %, compliances n = 2 to 8 within 2.2 %, n = 0 within 0.1 %."""
    own = [frequencies(n)[0] for n in range(2, 6)]
    assert own == pytest.approx(free_frequencies(8, NF308, *FINE)[::2], rel=3e-3)
    assert [compliance(n) for n in ORDERS] == pytest.approx(compliances(ORDERS, NF308, None, *FINE), rel=2.2e-2)
    assert compliance(0) == pytest.approx(compliances([0])[0], rel=1e-3)


def test_without_shear_the_beam_misses_the_body():
    """Bending alone is 2 % too stiff at n = 2 and 30 % at n = 8: what the shear is for."""
    stiff = beam_ring.NF308._replace(shear=1e9)
    off = np.array([compliance(n, stiff) for n in ORDERS]) / compliances(ORDERS) - 1
    assert -0.04 < off[0] < -0.02
    assert -0.35 < off[-1] < -0.25


def test_a_load_on_the_race_bends_a_little_less():
    """Counted by its work on the race, 0.2 % at n = 2 and 5 % at n = 8: local compression is not in it."""
    less = 1 - compliances(ORDERS, NF308, NF308.inside) / compliances(ORDERS)
    assert less == pytest.approx([0.0024, 0.0063, 0.0117, 0.0186, 0.0270, 0.0368, 0.0480], abs=5e-4)


@pytest.mark.parametrize("curved", [True, False])
@pytest.mark.parametrize("n", [2, 5, 30])
def test_the_closed_form_is_the_matrix_turned_over(n, curved):
    ring = beam_ring.NF308._replace(curved=curved)
    assert compliance(n, ring) == pytest.approx(np.linalg.inv(matrices(n, ring)[0])[0, 0], rel=1e-8)


def test_translation_of_ring_has_no_bending():
    stiffness, mass = matrices(1)
    shift = np.array([1.0, -1.0, 0.0])
    assert np.abs(stiffness @ shift).max() < 1e-9 * np.abs(stiffness).max()
    assert shift @ mass @ shift == pytest.approx(beam_ring.NF308.mass)


def test_the_moments_are_integrals():
    z = np.linspace(-0.5, 0.5, 20001) * 0.0065
    for power, moment in enumerate(beam_ring.NF308.moments):
        expected = np.trapezoid(0.023 * z**power / (beam_ring.NF308.radius + z), z)
        assert moment == pytest.approx(expected, rel=1e-6)


def test_a_thin_beam_is_the_thin_ring():
    thin = Beam(inside=0.0499, outside=0.0501)
    bending = thin.young * thin.second_moment
    for n in (2, 3, 4):
        stiffness, mass = (mode[0] for mode in modes([n], thin))
        assert stiffness == pytest.approx(np.pi * bending * (n * n - 1) ** 2 / thin.radius**3, rel=1e-3)
        assert mass == pytest.approx(thin.mass / 2 * (1 + 1 / n**2), rel=1e-3)


def test_modes_have_rig_mass_and_are_below_the_cap():
    orders = (0, *range(2, 13))
    stiffness, mass = modes(orders)
    assert modes(orders, mass=2 * beam_ring.NF308.mass)[1] == pytest.approx(2 * mass)
    capped = np.sqrt(stiffness / modes(orders, cap=25e3)[1]) / (2 * np.pi)
    own = np.sqrt(stiffness / mass) / (2 * np.pi)
    assert capped == pytest.approx(np.minimum(own, 25e3))
    assert (own > 25e3).sum() == 7  # n = 6 to 12
