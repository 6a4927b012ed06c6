"""Friction laws: their curves, derivatives and vectorisation."""

from math import exp

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bearingsim.core.laws.friction.curves import (
    JUMP_WIDTH,
    KRAGELSKII,
    MIN_ROLLING_SPEED,
    Frictionless,
    StaticDynamic,
    Traction,
    exp_minus,
)
from bearingsim.core.laws.friction.interface import mu, mu_derivative, mu_derivative_bound
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows
from tests.scenes.laws import slope

PAPER = StaticDynamic(0.3, 0.15, 0.02, 0.1)
BOUNDARY = Traction(-0.02, 15.0, 200.0, 0.08)  # starts from 0.06
LAWS = [Frictionless(), PAPER, StaticDynamic(0.002, 0.001, 0.1, 1.0), KRAGELSKII, BOUNDARY]
named = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
slips = st.floats(-5.0, 5.0) | st.floats(-0.1, 0.1)
speeds = st.floats(0.05, 30.0)


@named
@given(v=slips, u=speeds)
def test_friction_opposes_slip_and_is_odd(law, v, u):
    assert mu(law, -v, u) == -mu(law, v, u)
    assert mu(law, v, u) * v >= 0.0
    assert mu(law, 0.0, u) == 0.0


def test_static_dynamic_curve():
    """The paper's 0.3 and 0.15; half of a cubic step is 11/16 of the way from its middle."""
    slip = [0.01, 0.02, 0.06, 0.1, 0.5, 1e3]
    assert [mu(PAPER, v, 1.0) for v in slip] == pytest.approx(
        [0.3 * 11 / 16, 0.3, 0.225, 0.15, 0.15, 0.15], rel=1e-14
    )
    assert mu(PAPER, 0.05, 1.0) == mu(PAPER, 0.05, 20.0)


def adams_step(x, x_0, h_0, x_1, h_1):
    """The cubic STEP of the multibody codes (Adams' documentation of STEP)."""
    s = min(max((x - x_0) / (x_1 - x_0), 0.0), 1.0)
    return h_0 + (h_1 - h_0) * s * s * (3.0 - 2.0 * s)


@given(slips)
def test_static_dynamic_is_the_curve_of_the_multibody_codes(v):
    """-step(v, -v_s, -1, v_s, 1) step(|v|, v_s, mu_s, v_d, mu_d) (Adams), with the opposite sign."""
    expected = adams_step(v, -0.02, -1.0, 0.02, 1.0) * adams_step(abs(v), 0.02, 0.3, 0.1, 0.15)
    assert mu(PAPER, v, 1.0) == pytest.approx(expected, abs=1e-15)


@given(v=st.floats(0.0, 10.0), u=speeds)
def test_traction_curve(v, u):
    s = v / u
    expected = (-0.1 + 22.28 * s) * exp(-181.46 * s) + 0.1
    assert mu(KRAGELSKII, v, u) == pytest.approx(expected, rel=1e-12, abs=1e-16)


def test_traction_peaks_at_a_hundredth_and_falls_to_a_tenth():
    """The peak is at 1/c - a/b = 0.0100; there mu = d + (b/c) e^(a c/b - 1) = 0.1200."""
    values = [mu(KRAGELSKII, s, 1.0) for s in np.linspace(0.0, 0.2, 20001)]
    assert np.argmax(values) == pytest.approx(1000, abs=1)
    assert max(values) == pytest.approx(0.1200, abs=5e-5)
    assert values[-1] == pytest.approx(0.1, abs=1e-14)


def test_traction_scales_with_the_rolling_speed_down_to_standstill():
    assert mu(KRAGELSKII, 0.03, 3.0) == pytest.approx(mu(KRAGELSKII, 0.01, 1.0), rel=1e-14, abs=0.0)
    assert mu(KRAGELSKII, 1e-4, 0.0) == mu(KRAGELSKII, 1e-4, MIN_ROLLING_SPEED)
    assert mu(KRAGELSKII, 1e-4, -1.0) == mu(KRAGELSKII, 1e-4, MIN_ROLLING_SPEED)
    assert mu(KRAGELSKII, 1e9, 1.0) == pytest.approx(0.1, rel=1e-15, abs=0.0)


def test_a_traction_that_would_jump_at_zero_slip_rises_instead():
    u = 2.0
    assert mu(BOUNDARY, 1e-6, u) < 1e-3
    s = JUMP_WIDTH
    for _ in range(3):
        expected = (BOUNDARY.a + BOUNDARY.b * s) * exp(-BOUNDARY.c * s) + BOUNDARY.d
        assert mu(BOUNDARY, s * u, u) == pytest.approx(expected, rel=1e-12, abs=0.0)
        s *= 3.0


@named
@pytest.mark.parametrize("u", [0.3, 3.0, 20.0])
def test_curves_are_smooth_and_within_their_bound(law, u):
    """Values and slopes by differences on a fine grid through every joint, the slope's jumps included."""
    bound = mu_derivative_bound(law, u)
    joints = [0.0]
    joints += [law.v_s, law.v_d] if isinstance(law, StaticDynamic) else [JUMP_WIDTH * u, 40.0 / KRAGELSKII.c * u]
    for joint in joints:
        h = 1e-7 * max(joint, 1e-2)
        before, middle, after = (mu(law, joint + n * h, u) for n in (-1, 0, 1))
        assert (after - middle) / h == pytest.approx((middle - before) / h, abs=1e-4 * bound + 1e-12)
    v = np.linspace(-0.5, 0.5, 40001)
    slopes = np.diff([mu(law, x, u) for x in v]) / np.diff(v)
    assert slopes.max() <= bound * (1.0 + 1e-9)
    assert slopes.max() == pytest.approx(bound, rel=0.05, abs=0.0)
    slope_at_zero = (mu(law, 1e-9, u) - mu(law, -1e-9, u)) / 2e-9
    assert slope_at_zero == pytest.approx(bound, rel=1e-5, abs=0.0)


def test_known_slopes():
    assert mu_derivative_bound(PAPER, 3.0) == pytest.approx(1.5 * 0.3 / 0.02)
    assert mu_derivative_bound(KRAGELSKII, 3.0) == pytest.approx(40.426 / 3.0, rel=1e-6, abs=0.0)
    assert mu_derivative_bound(KRAGELSKII, 0.0) == pytest.approx(40.426 / MIN_ROLLING_SPEED, rel=1e-6, abs=0.0)


def test_the_exponential():
    for x in np.linspace(0.0, 40.0, 4001):
        assert exp_minus(x) == pytest.approx(exp(-x), rel=2e-14, abs=0.0)
        assert exp_minus.py_func(x) == pytest.approx(exp(-x), rel=2e-14, abs=0.0)


@pytest.mark.parametrize("law", LAWS[1:], ids=lambda law: type(law).__name__)
def test_nan_propagates(law):
    y = rows(float("nan"), 3.0, 1.0, 0.0)
    friction(law, y, ROW)
    assert np.isnan(y[3 * ROW :]).all()
    assert np.isnan(mu(law, float("nan"), 3.0))


# Compiled


@compiled
def friction(law, y, width):
    for j in range(width):
        y[3 * ROW + j] = mu(law, y[j], y[ROW + j]) * y[2 * ROW + j]


@compiled
def compiled_bound(law, u):
    return mu_derivative_bound(law, u)


@named
def test_friction_from_python_equals_the_compiled_one(law):
    y = rows(0.0, 3.0, 2.0, 0.0)
    y[:ROW] = np.append(0.0, np.random.default_rng(2).normal(size=ROW - 1) * 10.0 ** np.linspace(-6, 1, ROW - 1))
    friction(law, y, ROW)
    assert y[3 * ROW :] == pytest.approx([2.0 * mu(law, v, 3.0) for v in y[:ROW]], rel=1e-13, abs=1e-16)
    assert compiled_bound(law, 3.0) == pytest.approx(mu_derivative_bound(law, 3.0), rel=1e-15, abs=0.0)


@needs_vectors
@named
def test_friction_keeps_the_vector_lanes(law):
    assert keeps_lanes(friction, law, rows(0.01, 3.0, 100.0, 0.0), ROW)


# Exact slopes


@named
@given(v=slips, u=speeds)
def test_mu_derivative_is_that_of_the_coefficient(law, v, u):
    """Away from a curve's joints, where its curvature jumps."""
    ends = [1e-3 * u, 40.0 / getattr(law, "c", 1.0) * u]
    joints = [law.v_s, law.v_d] if isinstance(law, StaticDynamic) else ends
    assume(abs(v) > 1e-6 and all(abs(abs(v) - joint) > 1e-3 * joint for joint in joints))
    mu_v, mu_u = mu_derivative(law, v, u)
    assert mu_v == pytest.approx(slope(lambda w: mu(law, w, u), v, 2e-4 * abs(v)), rel=1e-6, abs=1e-7)
    assert mu_u == pytest.approx(slope(lambda w: mu(law, v, w), u, 2e-4 * u), rel=1e-6, abs=1e-7)


@named
def test_traction_is_constant_below_the_least_rolling_speed(law):
    assert mu_derivative(law, 1e-4, 1e-3)[1] == 0.0


@compiled
def fill_derivatives(law, y, width):
    for j in range(width):
        y[2 * ROW + j], y[3 * ROW + j] = mu_derivative(law, y[j], y[ROW + j])


@needs_vectors
@named
def test_friction_derivatives_keep_the_vector_lanes(law):
    if not isinstance(law, Frictionless):
        assert keeps_lanes(fill_derivatives, law, rows(1e-3, 3.0, 0.0, 0.0), ROW)
