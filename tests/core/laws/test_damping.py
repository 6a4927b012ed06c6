"""Contact laws against printed numbers and against their own derivatives."""

from itertools import product
from math import e, log, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim import assemble
from bearingsim.core.laws.damping import (
    General,
    HuntCrossley,
    Kraemer,
    Power,
    Power0,
    Power1,
    Power2,
    Undamped,
    damping_slope,
    general,
    normal_force,
    stiffness_slope,
)
from bearingsim.core.laws.johnson import COEFFICIENTS, TABLE, cell
from bearingsim.core.laws.slopes import slopes
from bearingsim.core.laws.stiffness import (
    Linear,
    PowerLaw,
    TenNinths,
    ThreeHalves,
    constant,
    elastic,
    iso16281,
    johnson,
    ninth_root,
    palmgren,
    share,
    share_by_newton,
    tangent,
)
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows
from tests.scenes.nf308 import case

STEEL = TenNinths(1.58e9)
LINE = johnson(207e9, 0.3, 0.012, 0.0325)  # NF308: 12 mm roller, R_i + R_w = R_o - R_w = 32.5 mm
STIFFNESSES = [STEEL, ThreeHalves(2.7e10), Linear(3e8), PowerLaw(5e9, 1.2), LINE]
LAWS = [
    HuntCrossley(STEEL, 50.0),
    Undamped(STEEL),
    Kraemer(STEEL, 1e-5),
    Kraemer(Linear(1e9), 1e-5),
    Kraemer(LINE, 1e-5),
    general(STEEL, 1e15, 1.0, 2.0),
    general(STEEL, 1e14, 1.5, 2.0),
    General(STEEL, 1e15, Power(1.0), Power(2.0)),
]
WHOLE = [
    (1.0, 0.0, Power1, Power0),
    (1.0, 1.0, Power1, Power1),
    (2.0, 2.0, Power2, Power2),
    (0.0, 0.1 + 3 * 0.3, Power0, Power1),  # a sweep's arithmetic: not quite 1
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
    assert 1e3 * approach(palmgren(0.010), 1000.0) == pytest.approx(0.0030502, rel=1e-3, abs=0.0)


def test_iso16281_approach_of_both_contacts():
    """1000 N on 10 mm: 0.0063080 mm for both contacts, Q = 35948 L^(8/9) delta^(10/9) (ISO/TS 16281)."""
    assert 2e3 * approach(iso16281(0.010), 1000.0) == pytest.approx(0.0063080, rel=1e-3, abs=0.0)


@given(st.floats(1e-30, 1e3))
def test_ninth_root_is_exact_to_rounding(x):
    assert ninth_root(x) == pytest.approx(x ** (1 / 9), rel=4e-15, abs=0.0)


def test_ninth_root_at_and_below_zero_carries_no_force():
    assert elastic(STEEL, 0.0) == 0.0
    assert np.isfinite(ninth_root(0.0))


@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
@given(delta=approaches)
def test_tangent_is_the_slope_of_the_force(law, delta):
    h = 1e-4 * delta
    slope = (elastic(law, delta + h) - elastic(law, delta - h)) / (2 * h)
    assert tangent(law, delta) == pytest.approx(slope, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
def test_elastic_laws_start_from_nothing_grow_and_pass_on_what_is_not_a_number(law):
    assert elastic(law, 0.0) == pytest.approx(0.0, abs=1e-250)
    forces = [elastic(law, delta) for delta in np.geomspace(1e-15, 1e-2, 300)]
    assert np.all(np.diff(forces) > 0.0)
    assert np.isnan(elastic(law, float("nan")))


@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
def test_elastic_laws_from_python_equal_the_compiled_ones(law):
    deltas = np.append(0.0, np.geomspace(1e-15, 1e-2, 100))  # a multiple of the vector's length and one over
    y = rows(0.0, 0.0, 0.0)
    y[:ROW] = deltas[:ROW]
    force_and_slope(law, y, ROW)
    assert y[ROW : 2 * ROW] == pytest.approx([elastic(law, delta) for delta in deltas[:ROW]], rel=1e-13, abs=0.0)
    assert y[2 * ROW :] == pytest.approx([tangent(law, delta) for delta in deltas[:ROW]], rel=1e-13, abs=0.0)


@compiled
def force_and_slope(law, y, width):
    for j in range(width):
        y[ROW + j] = elastic(law, y[j])
        y[2 * ROW + j] = tangent(law, y[j])


@compiled
def force_of_lanes(law, y, width):
    for j in range(width):
        y[2 * ROW + j] = normal_force(law, y[j], y[ROW + j])


@needs_vectors
@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
def test_all_but_the_general_power_keep_the_vector_lanes(law):
    vectors = not isinstance(law, PowerLaw)
    assert keeps_lanes(force_and_slope, law, rows(1e-7, 0.0, 0.0), ROW) == vectors
    assert keeps_lanes(force_of_lanes, HuntCrossley(law, 50.0), rows(1e-7, 0.1, 0.0), ROW) == vectors


# Given exponents


@pytest.mark.parametrize(
    ("m", "law"), [(1, Linear), (10 / 9, TenNinths), (1.5, ThreeHalves), (1.11, PowerLaw), (1.1111, PowerLaw)]
)
def test_a_given_exponent_takes_the_law_that_has_it(m, law):
    found = constant(5e9, m)
    assert type(found) is law
    assert elastic(found, 3e-6) == pytest.approx(5e9 * 3e-6**m, rel=1e-13, abs=0.0)


def test_an_exponent_below_one_is_refused():
    with pytest.raises(ValueError, match="infinitely stiff"):
        constant(5e9, 0.9)


# Johnson's line contact


def line_approach(Q, E, nu, L, dR):
    """Johnson's approach (m) of a roller and a race under the force ``Q`` (N)."""
    per_length, modulus = Q / L, E / (2.0 * (1.0 - nu**2))
    return per_length / (pi * modulus) * (log(4.0 * pi * modulus * dR / per_length) - 1.0)


def half_approach(per_length, E, nu, R, a):
    """Johnson, section 5.6: approach (m) of a cylinder's axis to its contact of half width ``a`` (m)."""
    return per_length * (1.0 - nu**2) / (pi * E) * (2.0 * log(4.0 * R / a) - 1.0)


@pytest.mark.parametrize("sign", [1, -1], ids=["inner race", "outer race"])
def test_the_pair_formula_is_the_sum_of_two_half_approaches(sign):
    E, nu, R_w, R = 207e9, 0.3, 0.006, 0.0325 - sign * 0.006
    dR = R + sign * R_w
    modulus, per_length = E / (2.0 * (1.0 - nu**2)), 1e4
    a = (4.0 * per_length * R_w * R / dR / (pi * modulus)) ** 0.5
    both = half_approach(per_length, E, nu, R_w, a) + half_approach(per_length, E, nu, R, a)
    assert line_approach(per_length * 0.012, E, nu, 0.012, dR) == pytest.approx(both, rel=1e-12, abs=0.0)


@given(delta=st.floats(-10, -4).map(lambda power: 10.0**power), dR=st.floats(0.002, 0.25), L=st.floats(0.005, 0.1))
def test_johnson_solves_his_formula(delta, dR, L):
    force = elastic(johnson(207e9, 0.3, L, dR), delta)
    assert line_approach(force, 207e9, 0.3, L, dR) == pytest.approx(delta, rel=1e-9, abs=0.0)


def test_johnson_s_table_all_over():
    """Seven points in every cell, down to 2^-36 and up to 2^-6 of 4 dR, where the table ends."""
    for y in 2.0 ** np.linspace(-36, -6, 7 * 960):
        delta = y * LINE.length
        assert line_approach(elastic(LINE, delta), 207e9, 0.3, 0.012, 0.0325) == pytest.approx(
            delta, rel=1e-9, abs=0.0
        )


@pytest.mark.parametrize("end", [2.0**-36, 2.0**-6])
def test_johnson_s_law_is_smooth_at_the_ends_of_its_table(end):
    at, h = end * LINE.length, 1e-9 * end * LINE.length
    assert elastic(LINE, at - h) == pytest.approx(elastic(LINE, at + h), rel=1e-8, abs=0.0)
    assert tangent(LINE, at - h) == pytest.approx(tangent(LINE, at + h), rel=1e-7, abs=0.0)


def test_johnson_s_law_beyond_its_table_is_a_straight_line_below_the_formula_s_end():
    end, last = 2.0**-6 * LINE.length, e**-2 * LINE.length
    assert elastic(LINE, last) == pytest.approx(
        elastic(LINE, end) + tangent(LINE, end) * (last - end), rel=1e-12, abs=0.0
    )
    assert tangent(LINE, last) == tangent(LINE, end)


@pytest.mark.parametrize("y", [float("nan"), -1.0, 0.0, 1.0, float("inf")])
def test_johnson_s_table_is_never_read_outside(y):
    for found in (cell(y), cell.py_func(y)):
        assert 0 <= found[0] <= len(TABLE) - COEFFICIENTS
        assert found[1] == pytest.approx(y - (2.0**-6 if y > 0.0 else 0.0), nan_ok=True)


def test_johnson_s_law_is_hashable_and_named_by_its_numbers():
    assert len({LINE, johnson(207e9, 0.3, 0.012, 0.0325), johnson(207e9, 0.3, 0.012, 0.0326)}) == 2
    assert "0.13" in repr(LINE)


def test_johnson_and_palmgren_agree_on_steel_rollers():
    """Within 15 % for 25 to 4000 N on a 12 mm roller: Palmgren's is a fit to measured rollers, which end."""
    for delta in (1e-7, 1e-6, 1e-5):
        assert elastic(LINE, delta) == pytest.approx(elastic(palmgren(0.012), delta), rel=0.15, abs=0.0)


# Two contacts in series


PAIRS = [
    pytest.param(outer, inner, id=f"{type(outer).__name__}-{type(inner).__name__}")
    for outer, inner in product(STIFFNESSES, STIFFNESSES)
]


def softer(law, factor):
    """The law with its stiffness times ``factor``."""
    return law._replace(**{law._fields[0]: factor * law[0]})


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
@pytest.mark.parametrize("factor", [1.0, 0.7, 30.0])
@given(delta=st.floats(1e-9, 1e-5))
def test_a_share_balances_the_two_forces(outer, inner, factor, delta):
    inner = softer(inner, factor)
    part = share(outer, inner, delta)
    assert 0.0 <= part <= delta
    assert elastic(inner, part) == pytest.approx(elastic(outer, delta - part), rel=3e-9, abs=0.0)


@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("delta", [0.0, 1e-9, 1.234e-7, 1e-5])
def test_equal_contacts_share_alike(law, delta):
    assert share(law, law, delta) == delta / 2.0


def test_johnson_s_share_is_that_of_newton():
    inner = johnson(150e9, 0.3, 0.009, 0.020)
    for delta in np.geomspace(1e-10, 1e-4, 50):
        assert share(LINE, inner, delta) == pytest.approx(share_by_newton(LINE, inner, delta), rel=1e-9, abs=0.0)


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
def test_nothing_is_shared_where_nothing_touches_and_not_a_number_is_passed_on(outer, inner):
    assert share(outer, inner, 0.0) == 0.0
    assert share(outer, inner, -1e-6) == 0.0
    assert np.isnan(share(outer, inner, float("nan")))


@compiled
def shares(outer, inner, y, width):
    for j in range(width):
        y[ROW + j] = share(outer, inner, y[j])


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
def test_shares_from_python_equal_the_compiled_ones(outer, inner):
    y = rows(0.0, 0.0)
    y[:ROW] = np.append(0.0, np.geomspace(1e-12, 1e-5, ROW - 1))
    shares(outer, softer(inner, 2.0), y, ROW)
    expected = [share(outer, softer(inner, 2.0), delta) for delta in y[:ROW]]
    assert y[ROW:] == pytest.approx(expected, rel=1e-12, abs=0.0)


@needs_vectors
@pytest.mark.parametrize("law", [law for law in STIFFNESSES if not isinstance(law, PowerLaw)])
def test_shares_of_like_contacts_keep_the_vector_lanes(law):
    assert keeps_lanes(shares, law, softer(law, 2.0), rows(1e-7, 0.0), ROW)


# Damping


@pytest.mark.parametrize("law", LAWS)
@given(delta=approaches, v=rates)
def test_slopes_are_those_of_the_force(law, delta, v):
    force = normal_force(law, delta, v)
    if force < 1e-3 * elastic(STEEL, delta) or abs(v) < 2e-3:
        return  # clamped, or where |v|^m2 has no slope to speak of
    h = 1e-5 * abs(v)
    by_rate = (normal_force(law, delta, v + h) - normal_force(law, delta, v - h)) / (2 * h)
    assert damping_slope(law, delta, v) == pytest.approx(by_rate, rel=1e-4, abs=0.0)
    if v > 0 and not isinstance(law, Kraemer):  # elsewhere the slope kept for the step limit is a bound
        h = 1e-5 * delta
        by_approach = (normal_force(law, delta + h, v) - normal_force(law, delta - h, v)) / (2 * h)
        assert stiffness_slope(law, delta, v) == pytest.approx(by_approach, rel=1e-4, abs=0.0)


@pytest.mark.parametrize("law", LAWS)
@given(delta=st.floats(-1e-5, 1e-5), v=rates)
def test_no_contact_pulls_and_none_acts_at_a_distance(law, delta, v):
    force = normal_force(law, delta, v)
    assert force >= 0.0
    assert delta > 0.0 or force < 1e-20  # N


def test_a_dashpot_without_indentation_exponent_does_not_act_on_a_roller_that_is_not_there():
    assert normal_force(general(STEEL, 1e6, 1.0, 0.0), -1e-9, 0.1) == 0.0


@pytest.mark.parametrize(("m2", "m3", "rate", "depth"), WHOLE)
def test_whole_exponents_are_types_and_equal_any_exponent(m2, m3, rate, depth):
    law, slow = general(STEEL, 1e9, m2, m3), General(STEEL, 1e9, Power(m2), Power(m3))
    assert isinstance(law.m2, rate)
    assert isinstance(law.m3, depth)
    assert isinstance(general(STEEL, 1e9, 1.0, 1.5).m3, Power)
    for value in (normal_force, damping_slope, stiffness_slope, slopes):
        for v in (-0.1, 0.0, 2e-3, 0.3):
            for delta in (0.0, 1e-13, 1e-9, 3e-6):
                assert value(law, delta, v) == pytest.approx(value(slow, delta, v), rel=1e-13, abs=0.0)


@needs_vectors
@pytest.mark.parametrize(("m2", "m3", "rate", "depth"), [*WHOLE, (1.0, 1.5, Power1, Power)])
def test_general_damping_keeps_the_vector_lanes_with_whole_exponents(m2, m3, rate, depth):
    law, vectors = general(STEEL, 1e9, m2, m3), depth is not Power
    assert keeps_lanes(force_of_lanes, law, rows(1e-7, 0.1, 0.0), ROW) == vectors


def test_not_a_number_is_not_hidden():
    assert np.isnan(normal_force(LAWS[0], float("nan"), 0.0))


@pytest.mark.parametrize(("m3", "expected"), [(0.0, 1e9), (1.0, 1e12), (2.0, 1e15)])
def test_the_papers_damping_coefficient_in_si(m3, expected):
    """1e6 N s/mm (Yang et al.) with m3 = 0 is 1e9 N s/m; each power of a millimetre adds a thousand."""
    damping = {"law": "general", "coefficient": "1e6", "indentation_exponent": str(m3)}
    assert assemble.contacts.outer(case(contact={"damping": damping})).c == pytest.approx(expected)
