"""Damping laws: limits of their forces, their bounds, and their exact derivatives against differences."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bearingsim import assemble
from bearingsim.core.laws.damping.general import General, Power, Power0, Power1, Power2, make_general
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.octaves import cell
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.power_laws import Linear
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows
from tests.scenes.laws import LINE, STEEL, force_of_lanes, slope
from tests.scenes.nf308 import case

LAWS = [
    HuntCrossley(STEEL, 50.0),
    Undamped(STEEL),
    Kraemer(STEEL, 1e-5),
    Kraemer(Linear(1e9), 1e-5),
    Kraemer(LINE, 1e-5),
    make_general(STEEL, 1e15, 1.0, 2.0),
    make_general(STEEL, 1e14, 1.5, 2.0),
    General(STEEL, 1e15, Power(1.0), Power(2.0)),
]
INTEGER_EXPONENTS = [
    (1.0, 0.0, Power1, Power0),
    (1.0, 1.0, Power1, Power1),
    (2.0, 2.0, Power2, Power2),
    (0.0, 0.1 + 3 * 0.3, Power0, Power1),  # a sweep's arithmetic: not quite 1
]
DAMPINGS = [
    lambda law: HuntCrossley(law, 50.0),
    lambda law: Kraemer(law, 1e-5),
    lambda law: make_general(law, 1e6, 1.0, 0.0),
    lambda law: make_general(law, 1e9, 1.0, 1.0),
    lambda law: make_general(law, 1e14, 1.5, 2.0),
    lambda law: make_general(law, 1e12, 2.0, 1.0),
    lambda law: make_general(law, 1e9, 0.7, 0.9),
]
CONTACTS = [damping(law) for law in (STEEL, Linear(3e8), LINE) for damping in DAMPINGS]
contacts = pytest.mark.parametrize("law", CONTACTS, ids=str)
approaches = st.floats(1e-9, 1e-5)
rates = st.floats(-0.3, 0.3)


@pytest.mark.parametrize("law", LAWS)
@given(delta=approaches, v=rates)
def test_bounds_are_the_slopes_of_the_force_where_a_contact_closes(law, delta, v):
    force = normal_force(law, delta, v)
    if force < 1e-3 * elastic(STEEL, delta) or abs(v) < 2e-3:
        return  # clamped, or where the derivative of |v|^m2 is negligible
    h = 1e-5 * abs(v)
    by_rate = (normal_force(law, delta, v + h) - normal_force(law, delta, v - h)) / (2 * h)
    assert damping_bound(law, delta, v) == pytest.approx(by_rate, rel=1e-4, abs=0.0)
    if v > 0 and not isinstance(law, Kraemer):  # elsewhere the derivative is only bounded
        h = 1e-5 * delta
        by_approach = (normal_force(law, delta + h, v) - normal_force(law, delta - h, v)) / (2 * h)
        assert stiffness_bound(law, delta, v) == pytest.approx(by_approach, rel=1e-4, abs=0.0)


@pytest.mark.parametrize("law", LAWS)
@given(delta=st.floats(-1e-5, 1e-5), v=rates)
def test_no_contact_pulls_and_none_acts_at_a_distance(law, delta, v):
    force = normal_force(law, delta, v)
    assert force >= 0.0
    assert delta > 0.0 or force < 1e-20  # N


def test_a_dashpot_without_indentation_exponent_acts_only_in_contact():
    assert normal_force(make_general(STEEL, 1e6, 1.0, 0.0), -1e-9, 0.1) == 0.0


@pytest.mark.parametrize(("v", "sign"), [(-1e-9, -1.0), (0.0, 0.0), (-0.0, 0.0), (1e-9, 1.0)])
def test_damping_independent_of_the_rate_has_no_force_at_rest(v, sign):
    """c sgn(v) delta with c = 1e8 N/m, where the elastic force k delta^(10/9) is larger."""
    law, delta = make_general(STEEL, 1e8, 0.0, 1.0), 1e-6
    drag = 1e8 * sign
    assert normal_force(law, delta, v) == pytest.approx(elastic(STEEL, delta) + drag * delta, rel=1e-14)
    slope_at_rest = 10 / 9 * elastic(STEEL, delta) / delta + drag
    assert derivatives(law, delta, v)[0] == pytest.approx(slope_at_rest, rel=1e-12)


@pytest.mark.parametrize(("m2", "m3", "rate", "depth"), INTEGER_EXPONENTS)
def test_integer_exponents_have_types_and_equal_the_general_one(m2, m3, rate, depth):
    law, reference = make_general(STEEL, 1e9, m2, m3), General(STEEL, 1e9, Power(m2), Power(m3))
    assert isinstance(law.m2, rate)
    assert isinstance(law.m3, depth)
    assert isinstance(make_general(STEEL, 1e9, 1.0, 1.5).m3, Power)
    for function in (normal_force, damping_bound, stiffness_bound, derivatives):
        for v in (-0.1, 0.0, 2e-3, 0.3):
            for delta in (0.0, 1e-13, 1e-9, 3e-6):
                assert function(law, delta, v) == pytest.approx(function(reference, delta, v), rel=1e-13, abs=0.0)


@needs_vectors
@pytest.mark.parametrize(("m2", "m3", "rate", "depth"), [*INTEGER_EXPONENTS, (1.0, 1.5, Power1, Power)])
def test_general_damping_keeps_the_vector_lanes_with_integer_exponents(m2, m3, rate, depth):
    law, vectors = make_general(STEEL, 1e9, m2, m3), depth is not Power
    assert keeps_lanes(force_of_lanes, law, rows(1e-7, 0.1, 0.0), ROW) == vectors


def test_nan_propagates():
    assert np.isnan(normal_force(LAWS[0], float("nan"), 0.0))


@pytest.mark.parametrize(("m3", "expected"), [(0.0, 1e9), (1.0, 1e12), (2.0, 1e15)])
def test_the_papers_damping_coefficient_in_si(m3, expected):
    """1e6 N s/mm (Yang et al.) with m3 = 0 is 1e9 N s/m; each power of a millimetre adds a thousand."""
    damping = {"law": "general", "coefficient": "1e6", "indentation_exponent": str(m3)}
    assert assemble.contacts.build_outer_law(case(contact={"damping": damping})).c == pytest.approx(expected)


# Exact derivatives


@pytest.mark.parametrize("law", [*CONTACTS, Undamped(STEEL)], ids=str)
@given(delta=st.floats(1e-8, 1e-5), v=st.floats(-0.3, 0.3))
def test_slopes_are_those_of_the_force(law, delta, v):
    """Also where the force is clamped; differences across the clamp are left out."""
    assume(abs(v) > 1e-3)
    h, step = 1e-4 * delta, 1e-4 * abs(v)
    forces = [normal_force(law, delta + i * h, v + k * step) for i in (-2, 0, 2) for k in (-2, 0, 2)]
    assume(min(forces) > 0.0 or max(forces) == 0.0)
    floor = 1e-9 * elastic(law.stiffness, delta)
    if law.stiffness is LINE and isinstance(law, Kraemer):
        assume(cell((delta + 2.0 * h) / LINE.length)[0] == cell((delta - 2.0 * h) / LINE.length)[0])
    result = derivatives(law, delta, v)
    by_approach = slope(lambda d: normal_force(law, d, v), delta, h)
    by_rate = slope(lambda w: normal_force(law, delta, w), v, step)
    assert result[0] == pytest.approx(by_approach, rel=1e-6, abs=floor / delta)
    assert result[1] == pytest.approx(by_rate, rel=1e-6, abs=floor / abs(v))


@contacts
def test_a_contact_that_is_open_or_would_pull_has_no_slopes(law):
    assert derivatives(law, -1e-7, 0.1) == (0.0, 0.0)
    assert derivatives(law, 0.0, 0.1) == (0.0, 0.0)
    assert normal_force(law, 1e-7, -1e4) == 0.0
    assert derivatives(law, 1e-7, -1e4) == (0.0, 0.0)


@contacts
@pytest.mark.parametrize("delta", [1e-30, 1e-9, 1e-6])
def test_slopes_are_finite_at_rest_and_at_touch_down(law, delta):
    assert np.isfinite(derivatives(law, delta, 0.0)).all()
    assert np.isfinite(derivatives(law, delta, 0.1)).all()


@compiled
def fill_derivatives(law, y, width):
    for j in range(width):
        y[2 * ROW + j], y[3 * ROW + j] = derivatives(law, y[j], y[ROW + j])


@contacts
def test_slopes_from_python_equal_the_compiled_ones(law):
    y = rows(0.0, 0.0, 0.0, 0.0)
    rng = np.random.default_rng(5)
    y[:ROW], y[ROW : 2 * ROW] = rng.normal(0.0, 1e-6, ROW), rng.normal(0.0, 0.1, ROW)
    fill_derivatives(law, y, ROW)
    expected = np.array([derivatives(law, delta, v) for delta, v in zip(y[:ROW], y[ROW : 2 * ROW], strict=True)])
    assert y[2 * ROW : 3 * ROW] == pytest.approx(expected[:, 0], rel=1e-12, abs=0.0)
    assert y[3 * ROW :] == pytest.approx(expected[:, 1], rel=1e-12, abs=0.0)


@needs_vectors
@pytest.mark.parametrize(
    "law", [HuntCrossley(STEEL, 50.0), HuntCrossley(LINE, 50.0), Kraemer(STEEL, 1e-5)], ids=str
)
def test_slopes_keep_the_vector_lanes(law):
    assert keeps_lanes(fill_derivatives, law, rows(1e-7, 0.1, 0.0, 0.0), ROW)
