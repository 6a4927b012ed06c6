"""Two contacts in series: every pair of laws, including one that is defined here."""

from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT, PowerLaw
from bearingsim.core.laws.stiffness.series import as_power, inner_approach, inner_approach_by_newton
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows
from tests.scenes.laws import LINE, STEEL, STIFFNESSES, every_stiffness


class Hardening(NamedTuple):
    """Q = k delta (1 + delta/d), no power law, with ``elastic`` and ``tangent`` only."""

    k: float
    d: float


@elastic.register(Hardening)
def _elastic(law, delta):
    return law.k * delta * (1.0 + delta / law.d)


@tangent.register(Hardening)
def _tangent(law, delta):
    return law.k * (1.0 + 2.0 * delta / law.d)


PAIRS = [
    pytest.param(outer, inner, id=f"{type(outer).__name__}-{type(inner).__name__}")
    for outer, inner in product([*STIFFNESSES, Hardening(3e8, 1e-5)], repeat=2)
]


def scaled(law, factor):
    """Return the law with its stiffness times ``factor``."""
    return law._replace(**{law._fields[0]: factor * law[0]})


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
@given(delta=st.floats(1e-9, 1e-5), factor=st.sampled_from([1.0, 0.7, 30.0]))
def test_a_share_balances_the_two_forces(outer, inner, delta, factor):
    inner = scaled(inner, factor)
    share = inner_approach(outer, inner, delta)
    assert 0.0 <= share <= delta
    assert elastic(inner, share) == pytest.approx(elastic(outer, delta - share), rel=3e-9, abs=0.0)


@every_stiffness
@pytest.mark.parametrize("delta", [0.0, 1e-9, 1.234e-7, 1e-5])
def test_equal_contacts_share_equally(law, delta):
    assert inner_approach(law, law, delta) == delta / 2.0


def test_johnson_share_equals_newton():
    inner = make_johnson(150e9, 0.3, 0.009, 0.020)
    for delta in np.geomspace(1e-10, 1e-4, 50):
        assert inner_approach(LINE, inner, delta) == pytest.approx(
            inner_approach_by_newton(LINE, inner, delta), rel=1e-9, abs=0.0
        )


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
def test_no_share_without_contact_and_nan_propagates(outer, inner):
    assert inner_approach(outer, inner, 0.0) == 0.0
    assert inner_approach(outer, inner, -1e-6) == 0.0
    assert np.isnan(inner_approach(outer, inner, float("nan")))


@compiled
def fill_shares(outer, inner, y, width):
    for j in range(width):
        y[ROW + j] = inner_approach(outer, inner, y[j])


@pytest.mark.parametrize(("outer", "inner"), PAIRS)
def test_shares_from_python_equal_the_compiled_ones(outer, inner):
    y = rows(0.0, 0.0)
    y[:ROW] = np.append(0.0, np.geomspace(1e-12, 1e-5, ROW - 1))
    fill_shares(outer, scaled(inner, 2.0), y, ROW)
    expected = [inner_approach(outer, scaled(inner, 2.0), delta) for delta in y[:ROW]]
    assert y[ROW:] == pytest.approx(expected, rel=1e-12, abs=0.0)


@needs_vectors
@pytest.mark.parametrize("law", [law for law in STIFFNESSES if not isinstance(law, PowerLaw)])
def test_shares_of_like_contacts_keep_the_vector_lanes(law):
    assert keeps_lanes(fill_shares, law, scaled(law, 2.0), rows(1e-7, 0.0), ROW)


def test_power_laws_have_a_coefficient_and_an_exponent():
    assert as_power(STEEL) == (STEEL.k, LINE_CONTACT_EXPONENT)
    assert as_power(PowerLaw(5e9, 1.2)) == (5e9, 1.2)
    assert as_power(LINE) == as_power(Hardening(3e8, 1e-5)) == (0.0, 0.0)
