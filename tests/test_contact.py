"""Contact laws against printed numbers and against their own derivatives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim import build
from bearingsim.core.contact import (
    General,
    HuntCrossley,
    Kraemer,
    TenNinths,
    damping_slope,
    elastic,
    iso16281,
    ninth_root,
    normal_force,
    palmgren,
    stiffness_slope,
    tangent,
)
from tests.scenes import case

STEEL = TenNinths(1.58e9)
LAWS = [
    HuntCrossley(STEEL, 50.0),
    Kraemer(STEEL, 1e-5),
    General(STEEL, 1e15, 1.0, 2.0),
    General(STEEL, 1e14, 1.5, 2.0),
]
approaches = st.floats(1e-9, 1e-5)
rates = st.floats(-0.3, 0.3)


def approach(law, force):
    """Approach (m) under a force (N), by bisection on the law itself."""
    low, high = 0.0, 1e-3
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if elastic(law, middle) < force else (low, middle)
    return low


def test_palmgren_approach_of_one_contact():
    """1000 N on 10 mm: 3.84e-5 Q^0.9/L^0.8 = 0.0030502 mm (Palmgren)."""
    assert 1e3 * approach(palmgren(0.010), 1000.0) == pytest.approx(0.0030502, rel=1e-3)


def test_iso16281_approach_of_both_contacts():
    """1000 N on 10 mm: 0.0063080 mm for both contacts, Q = 35948 L^(8/9) delta^(10/9) (ISO/TS 16281)."""
    assert 2e3 * approach(iso16281(0.010), 1000.0) == pytest.approx(0.0063080, rel=1e-3)


@given(st.floats(1e-30, 1e3))
def test_ninth_root_is_exact_to_rounding(x):
    assert ninth_root(x) == pytest.approx(x ** (1 / 9), rel=4e-15)


def test_ninth_root_at_and_below_zero_carries_no_force():
    assert elastic(STEEL, 0.0) == 0.0
    assert np.isfinite(ninth_root(0.0))


@given(approaches)
def test_tangent_is_the_slope_of_the_force(delta):
    h = 1e-4 * delta
    slope = (elastic(STEEL, delta + h) - elastic(STEEL, delta - h)) / (2 * h)
    assert tangent(STEEL, delta) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
@given(delta=approaches, v=rates)
def test_slopes_are_those_of_the_force(law, delta, v):
    force = normal_force(law, delta, v)
    if force < 1e-3 * elastic(STEEL, delta) or abs(v) < 2e-3:
        return  # clamped, or where |v|^m2 has no slope to speak of
    h = 1e-5 * abs(v)
    by_rate = (normal_force(law, delta, v + h) - normal_force(law, delta, v - h)) / (2 * h)
    assert damping_slope(law, delta, v) == pytest.approx(by_rate, rel=1e-4)
    if v > 0 and not isinstance(law, Kraemer):  # elsewhere the slope kept for the step limit is a bound
        h = 1e-5 * delta
        by_approach = (normal_force(law, delta + h, v) - normal_force(law, delta - h, v)) / (2 * h)
        assert stiffness_slope(law, delta, v) == pytest.approx(by_approach, rel=1e-4)


@pytest.mark.parametrize("law", LAWS)
@given(delta=st.floats(-1e-5, 1e-5), v=rates)
def test_no_contact_pulls_and_none_acts_at_a_distance(law, delta, v):
    force = normal_force(law, delta, v)
    assert force >= 0.0
    assert delta > 0.0 or force < 1e-20  # N


def test_a_dashpot_without_indentation_exponent_does_not_act_on_a_roller_that_is_not_there():
    assert normal_force(General(STEEL, 1e6, 1.0, 0.0), -1e-9, 0.1) == 0.0


def test_not_a_number_is_not_hidden():
    assert np.isnan(normal_force(LAWS[0], float("nan"), 0.0))


@pytest.mark.parametrize(("m3", "expected"), [(0.0, 1e9), (1.0, 1e12), (2.0, 1e15)])
def test_the_papers_damping_coefficient_in_si(m3, expected):
    """1e6 N s/mm (Yang et al.) with m3 = 0 is 1e9 N s/m; each power of a millimetre adds a thousand."""
    damping = {"law": "general", "coefficient": "1e6", "indentation_exponent": str(m3)}
    assert build.contact(case(contact={"damping": damping})).c == pytest.approx(expected)
