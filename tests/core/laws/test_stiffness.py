"""Elastic laws against printed numbers and against their own derivatives."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bearingsim.assemble.contacts import build_power_law
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.octaves import cell
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent
from bearingsim.core.laws.stiffness.power_laws import (
    Linear,
    PowerLaw,
    TenNinths,
    ThreeHalves,
    make_iso16281,
    make_palmgren,
    ninth_root,
)
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows
from tests.scenes.laws import LINE, STEEL, every_stiffness, force_of_lanes, slope


def approach(law, force):
    """Return the approach (m) under a force (N), by bisection."""
    low, high = 0.0, 1e-3
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if elastic(law, middle) < force else (low, middle)
    return low


def test_palmgren_approach_of_one_contact():
    """1000 N on 10 mm: 3.84e-5 Q^0.9/L^0.8 = 0.0030502 mm (Palmgren)."""
    assert 1e3 * approach(make_palmgren(0.010), 1000.0) == pytest.approx(0.0030502, rel=1e-3, abs=0.0)


def test_iso16281_approach_of_both_contacts():
    """1000 N on 10 mm: 0.0063080 mm for both contacts, Q = 35948 L^(8/9) delta^(10/9) (ISO/TS 16281)."""
    assert 2e3 * approach(make_iso16281(0.010), 1000.0) == pytest.approx(0.0063080, rel=1e-3, abs=0.0)


@given(st.floats(1e-30, 1e3))
def test_ninth_root_is_exact_to_rounding(x):
    assert ninth_root(x) == pytest.approx(x ** (1 / 9), rel=4e-15, abs=0.0)


def test_the_ninth_root_of_zero():
    assert elastic(STEEL, 0.0) == 0.0
    assert np.isfinite(ninth_root(0.0))


@every_stiffness
@given(delta=st.floats(1e-9, 1e-5))
def test_tangent_is_the_slope_of_the_force(law, delta):
    h = 1e-4 * delta
    expected = (elastic(law, delta + h) - elastic(law, delta - h)) / (2 * h)
    assert tangent(law, delta) == pytest.approx(expected, rel=1e-6, abs=0.0)


@every_stiffness
@given(delta=st.floats(1e-9, 1e-5))
def test_curvature_is_the_slope_of_the_tangent(law, delta):
    h = 1e-4 * delta
    if law is LINE:  # it jumps from cell to cell of the table
        assume(cell((delta + 2.0 * h) / law.length)[0] == cell((delta - 2.0 * h) / law.length)[0])
    expected = slope(lambda d: tangent(law, d), delta, h)
    assert curvature(law, delta) == pytest.approx(expected, rel=1e-6, abs=1e-9 * tangent(law, delta) / delta)


@every_stiffness
def test_elastic_laws_start_from_zero_grow_and_propagate_nan(law):
    assert elastic(law, 0.0) == pytest.approx(0.0, abs=1e-250)
    forces = [elastic(law, delta) for delta in np.geomspace(1e-15, 1e-2, 300)]
    assert np.all(np.diff(forces) > 0.0)
    assert np.isnan(elastic(law, float("nan")))


@every_stiffness
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


@needs_vectors
@every_stiffness
def test_all_but_the_general_power_keep_the_vector_lanes(law):
    vectors = not isinstance(law, PowerLaw)
    assert keeps_lanes(force_and_slope, law, rows(1e-7, 0.0, 0.0), ROW) == vectors
    assert keeps_lanes(force_of_lanes, HuntCrossley(law, 50.0), rows(1e-7, 0.1, 0.0), ROW) == vectors


# Given exponents


@pytest.mark.parametrize(
    ("m", "law"), [(1, Linear), (10 / 9, TenNinths), (1.5, ThreeHalves), (1.11, PowerLaw), (1.1111, PowerLaw)]
)
def test_an_exponent_selects_its_law(m, law):
    result = build_power_law(5e9, m)
    assert type(result) is law
    assert elastic(result, 3e-6) == pytest.approx(5e9 * 3e-6**m, rel=1e-13, abs=0.0)


def test_an_exponent_below_one_is_refused():
    with pytest.raises(ValueError, match="infinitely stiff"):
        build_power_law(5e9, 0.9)
