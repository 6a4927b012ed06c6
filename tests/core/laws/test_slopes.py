"""Derivatives of contact and friction laws against central differences of the laws, away from their kinks."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bearingsim.core.laws.damping import HuntCrossley, Kraemer, general, normal_force
from bearingsim.core.laws.friction import KRAGELSKII, Frictionless, StaticDynamic, Traction, mu, mu_slope
from bearingsim.core.laws.johnson import cell
from bearingsim.core.laws.slopes import curvature, slopes
from bearingsim.core.laws.stiffness import Linear, PowerLaw, TenNinths, ThreeHalves, elastic, johnson, tangent
from tests.scenes.lanes import ROW, compiled, keeps_lanes, needs_vectors, rows

STEEL = TenNinths(1.58e9)
LINE = johnson(207e9, 0.3, 0.012, 0.0325)
STIFFNESSES = [STEEL, ThreeHalves(2.7e10), Linear(3e8), PowerLaw(5e9, 1.2), LINE]
DAMPINGS = [
    lambda law: HuntCrossley(law, 50.0),
    lambda law: Kraemer(law, 1e-5),
    lambda law: general(law, 1e6, 1.0, 0.0),
    lambda law: general(law, 1e9, 1.0, 1.0),
    lambda law: general(law, 1e14, 1.5, 2.0),
    lambda law: general(law, 1e12, 2.0, 1.0),
    lambda law: general(law, 1e9, 0.7, 0.9),
]
CONTACTS = [damping(law) for law in (STEEL, Linear(3e8), LINE) for damping in DAMPINGS]
LAWS = [Frictionless(), StaticDynamic(0.3, 0.15, 0.02, 0.1), KRAGELSKII, Traction(-0.02, 15.0, 200.0, 0.08)]
named = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
contacts = pytest.mark.parametrize("law", CONTACTS, ids=str)


def slope(function, x, h):
    """Central difference of fourth order."""
    near, far = function(x + h) - function(x - h), function(x + 2.0 * h) - function(x - 2.0 * h)
    return (8.0 * near - far) / (12.0 * h)


@pytest.mark.parametrize("law", STIFFNESSES, ids=lambda law: type(law).__name__)
@given(delta=st.floats(1e-9, 1e-5))
def test_curvature_is_the_slope_of_the_tangent(law, delta):
    h = 1e-4 * delta
    if law is LINE:  # it jumps from cell to cell of the table
        assume(cell((delta + 2.0 * h) / law.length)[0] == cell((delta - 2.0 * h) / law.length)[0])
    by_approach = slope(lambda d: tangent(law, d), delta, h)
    assert curvature(law, delta) == pytest.approx(by_approach, rel=1e-6, abs=1e-9 * tangent(law, delta) / delta)


@contacts
@given(delta=st.floats(1e-8, 1e-5), v=st.floats(-0.3, 0.3))
def test_slopes_are_those_of_the_force(law, delta, v):
    """The clamp's side included: what the differences straddle is left out."""
    assume(abs(v) > 1e-3)
    h, step = 1e-4 * delta, 1e-4 * abs(v)
    near = [normal_force(law, delta + i * h, v + k * step) for i in (-2, 0, 2) for k in (-2, 0, 2)]
    assume(min(near) > 0.0 or max(near) == 0.0)
    floor = 1e-9 * elastic(law.stiffness, delta)
    if law.stiffness is LINE and isinstance(law, Kraemer):
        assume(cell((delta + 2.0 * h) / LINE.length)[0] == cell((delta - 2.0 * h) / LINE.length)[0])
    found = slopes(law, delta, v)
    by_approach = slope(lambda d: normal_force(law, d, v), delta, h)
    by_rate = slope(lambda w: normal_force(law, delta, w), v, step)
    assert found[0] == pytest.approx(by_approach, rel=1e-6, abs=floor / delta)
    assert found[1] == pytest.approx(by_rate, rel=1e-6, abs=floor / abs(v))


@contacts
def test_a_contact_that_is_open_or_would_pull_has_no_slopes(law):
    assert slopes(law, -1e-7, 0.1) == (0.0, 0.0)
    assert slopes(law, 0.0, 0.1) == (0.0, 0.0)
    assert normal_force(law, 1e-7, -1e4) == 0.0
    assert slopes(law, 1e-7, -1e4) == (0.0, 0.0)


@contacts
@pytest.mark.parametrize("delta", [1e-30, 1e-9, 1e-6])
def test_slopes_are_finite_at_rest_and_at_touch_down(law, delta):
    assert np.isfinite(slopes(law, delta, 0.0)).all()
    assert np.isfinite(slopes(law, delta, 0.1)).all()


@compiled
def both(law, y, width):
    for j in range(width):
        y[2 * ROW + j], y[3 * ROW + j] = slopes(law, y[j], y[ROW + j])


@contacts
def test_slopes_from_python_equal_the_compiled_ones(law):
    y = rows(0.0, 0.0, 0.0, 0.0)
    rng = np.random.default_rng(5)
    y[:ROW], y[ROW : 2 * ROW] = rng.normal(0.0, 1e-6, ROW), rng.normal(0.0, 0.1, ROW)
    both(law, y, ROW)
    expected = np.array([slopes(law, delta, v) for delta, v in zip(y[:ROW], y[ROW : 2 * ROW], strict=True)])
    assert y[2 * ROW : 3 * ROW] == pytest.approx(expected[:, 0], rel=1e-12, abs=0.0)
    assert y[3 * ROW :] == pytest.approx(expected[:, 1], rel=1e-12, abs=0.0)


@needs_vectors
@pytest.mark.parametrize(
    "law", [HuntCrossley(STEEL, 50.0), HuntCrossley(LINE, 50.0), Kraemer(STEEL, 1e-5)], ids=str
)
def test_slopes_keep_the_vector_lanes(law):
    assert keeps_lanes(both, law, rows(1e-7, 0.1, 0.0, 0.0), ROW)


# Friction


@named
@given(v=st.floats(-5.0, 5.0) | st.floats(-0.1, 0.1), u=st.floats(0.05, 30.0))
def test_mu_slope_is_that_of_the_coefficient(law, v, u):
    """Away from a curve's joints, where its curvature jumps."""
    joints = [0.02, 0.1] if isinstance(law, StaticDynamic) else [1e-3 * u, 40.0 / getattr(law, "c", 1.0) * u]
    assume(abs(v) > 1e-6 and all(abs(abs(v) - joint) > 1e-3 * joint for joint in joints))
    by_slip, by_rolling = mu_slope(law, v, u)
    assert by_slip == pytest.approx(slope(lambda w: mu(law, w, u), v, 2e-4 * abs(v)), rel=1e-6, abs=1e-7)
    assert by_rolling == pytest.approx(slope(lambda w: mu(law, v, w), u, 2e-4 * u), rel=1e-6, abs=1e-7)


@named
def test_below_the_slowest_rolling_traction_no_longer_depends_on_it(law):
    assert mu_slope(law, 1e-4, 1e-3)[1] == 0.0


@compiled
def by_slip(law, y, width):
    for j in range(width):
        y[2 * ROW + j], y[3 * ROW + j] = mu_slope(law, y[j], y[ROW + j])


@needs_vectors
@named
def test_friction_s_slopes_keep_the_vector_lanes(law):
    if not isinstance(law, Frictionless):
        assert keeps_lanes(by_slip, law, rows(1e-3, 3.0, 0.0, 0.0), ROW)
