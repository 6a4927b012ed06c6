"""Johnson's line contact: his formula, and the table that solves it."""

from math import e, log, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.core.laws.octaves import COEFFICIENTS, cell
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.laws.stiffness.johnson import TABLE, make_johnson
from bearingsim.core.laws.stiffness.power_laws import make_palmgren
from tests.scenes.laws import LINE


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
    total = half_approach(per_length, E, nu, R_w, a) + half_approach(per_length, E, nu, R, a)
    assert line_approach(per_length * 0.012, E, nu, 0.012, dR) == pytest.approx(total, rel=1e-12, abs=0.0)


@given(delta=st.floats(-10, -4).map(lambda power: 10.0**power), dR=st.floats(0.002, 0.25), L=st.floats(0.005, 0.1))
def test_johnson_solves_his_formula(delta, dR, L):
    force = elastic(make_johnson(207e9, 0.3, L, dR), delta)
    assert line_approach(force, 207e9, 0.3, L, dR) == pytest.approx(delta, rel=1e-9, abs=0.0)


def test_johnson_table_in_every_cell():
    """Seven points in every cell, down to 2^-36 and up to 2^-6 of 4 dR, where the table ends."""
    for y in 2.0 ** np.linspace(-36, -6, 7 * 960):
        delta = y * LINE.length
        assert line_approach(elastic(LINE, delta), 207e9, 0.3, 0.012, 0.0325) == pytest.approx(
            delta, rel=1e-9, abs=0.0
        )


@pytest.mark.parametrize("end", [2.0**-36, 2.0**-6])
def test_johnson_law_is_smooth_at_the_ends_of_its_table(end):
    delta, h = end * LINE.length, 1e-9 * end * LINE.length
    assert elastic(LINE, delta - h) == pytest.approx(elastic(LINE, delta + h), rel=1e-8, abs=0.0)
    assert tangent(LINE, delta - h) == pytest.approx(tangent(LINE, delta + h), rel=1e-7, abs=0.0)


def test_johnson_law_is_a_straight_line_beyond_its_table():
    end, last = 2.0**-6 * LINE.length, e**-2 * LINE.length
    assert elastic(LINE, last) == pytest.approx(
        elastic(LINE, end) + tangent(LINE, end) * (last - end), rel=1e-12, abs=0.0
    )
    assert tangent(LINE, last) == tangent(LINE, end)


@pytest.mark.parametrize("y", [float("nan"), -1.0, 0.0, 1.0, float("inf")])
def test_johnson_table_is_never_read_outside(y):
    for result in (cell(y), cell.py_func(y)):
        assert 0 <= result[0] <= len(TABLE) - COEFFICIENTS
        assert result[1] == pytest.approx(y - (2.0**-6 if y > 0.0 else 0.0), nan_ok=True)


def test_johnson_law_is_hashable_and_its_repr_has_its_numbers():
    assert len({LINE, make_johnson(207e9, 0.3, 0.012, 0.0325), make_johnson(207e9, 0.3, 0.012, 0.0326)}) == 2
    assert "0.13" in repr(LINE)


def test_johnson_and_palmgren_agree_on_steel_rollers():
    """Within 15 % for 25 to 4000 N on a 12 mm roller: Palmgren's is a fit to measured rollers of finite length."""
    for delta in (1e-7, 1e-6, 1e-5):
        assert elastic(LINE, delta) == pytest.approx(elastic(make_palmgren(0.012), delta), rel=0.15, abs=0.0)
