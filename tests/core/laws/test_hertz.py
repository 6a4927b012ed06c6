"""Hertz's constants against printed numbers, SciPy's elliptic integrals and each other."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe, ellipkm1

from bearingsim.core.laws.hertz import (
    axis_ratio,
    curvature_ratio,
    effective_modulus,
    elliptic_integrals,
    half_width,
    line_pressure,
    make_ball_contact,
    make_elliptic_contact,
)

E, NU = 207e9, 0.3
STEEL = effective_modulus(E, NU)

HARRIS = [  # F(rho), a*, b*, delta* from T. A. Harris, Rolling Bearing Analysis, dimensionless contact parameters
    (0.0, 1.0, 1.0, 1.0),
    (0.1075, 1.0760, 0.9318, 0.9974),
    (0.93657, 3.738, 0.4166, 0.6112),
    (0.990902, 8.062, 0.2814, 0.3745),
    (0.995112, 10.222, 0.2497, 0.3176),
]


def test_roller_on_a_flat():
    """p = 271 sqrt(F/(D L)) N/mm2 for steel, E = 210 GPa: 2710 N/mm2 for 40 kN on a roller 20 x 20 mm."""
    modulus = effective_modulus(210e9, 0.3)
    assert line_pressure(40e3 / 0.020, 0.010, modulus) == pytest.approx(2710e6, rel=1e-3, abs=0.0)


def test_line_pressure_carries_the_load():
    """A half ellipse of pressure over the strip: Q' = pi b p/2."""
    Q, R = 3e4, 7.1e-3
    assert 1.5707963 * half_width(Q, 1.0, R, E, NU) * line_pressure(Q, R, STEEL) == pytest.approx(
        Q, rel=1e-7, abs=0.0
    )


@pytest.mark.parametrize(("F", "a", "b", "delta"), HARRIS)
def test_the_ellipses_of_harris(F, a, b, delta):
    """a = a* (3 Q/(2 E* S))^(1/3), delta = delta* (3 Q/(2 E* S))^(2/3) S/2, S the sum of curvatures, here 1."""
    contact = make_elliptic_contact(1.0, (1.0 + F) / 2.0, (1.0 - F) / 2.0)
    assert contact.a / 1.5 ** (1 / 3) == pytest.approx(a, rel=2e-4, abs=0.0)
    assert contact.b / 1.5 ** (1 / 3) == pytest.approx(b, rel=2e-4, abs=0.0)
    assert contact.k ** (-2 / 3) / (1.5 ** (2 / 3) / 2.0) == pytest.approx(delta, rel=2e-4, abs=0.0)


@pytest.mark.parametrize(("F", "delta"), [(row[0], row[3]) for row in HARRIS])
def test_the_stiffness_of_harris(F, delta):
    """k = 2.15e5 S^(-1/2) delta*^(-3/2) N/mm^1.5 for steel, S the sum of curvatures in 1/mm (Harris)."""
    S = 0.3
    contact = make_elliptic_contact(STEEL, 500.0 * S * (1.0 + F), 500.0 * S * (1.0 - F))
    assert contact.k * 1e-3**1.5 == pytest.approx(2.15e5 * S**-0.5 * delta**-1.5, rel=3e-3, abs=0.0)


def test_two_spheres():
    """A circle: Q = 4/3 E* sqrt(R) delta^(3/2), a^3 = 3 Q R/(4 E*) (Johnson, eqs 4.22 and 4.23)."""
    contact = make_elliptic_contact(STEEL, 100.0, 100.0)
    assert contact.k == pytest.approx(4.0 / 3.0 * STEEL * 0.01**0.5, rel=1e-14, abs=0.0)
    assert contact.a == pytest.approx((0.75 * 0.01 / STEEL) ** (1 / 3), rel=1e-14, abs=0.0)
    assert contact.a == contact.b


@given(st.floats(0.0, 9.0).map(lambda x: 1.0 + 10.0 ** (x - 6.0)))
def test_elliptic_integrals_equal_scipy(kappa):
    K, deficit = elliptic_integrals(kappa)
    assert pytest.approx(ellipkm1(1.0 / kappa**2), rel=1e-13, abs=0.0) == K
    assert K * (1.0 - deficit) == pytest.approx(ellipe(1.0 - 1.0 / kappa**2), rel=1e-12, abs=0.0)


@given(st.floats(-8.0, 6.0).map(lambda x: 1.0 + 10.0**x))
def test_axis_ratio_inverts_curvature_ratio(ratio):
    kappa = axis_ratio(ratio)
    assert kappa >= 1.0
    assert curvature_ratio(kappa) == pytest.approx(ratio, rel=1e-11, abs=0.0)


def test_the_limit_of_a_circle_is_smooth():
    contact = make_elliptic_contact(STEEL, 100.0, 100.0 * (1.0 + 1e-9))
    assert contact.k == pytest.approx(make_elliptic_contact(STEEL, 100.0, 100.0).k, rel=1e-9, abs=0.0)


def test_the_order_of_the_curvatures_does_not_matter():
    assert make_elliptic_contact(STEEL, 300.0, 8.0) == make_elliptic_contact(STEEL, 8.0, 300.0)


def test_pressure_carries_the_load():
    contact = make_ball_contact(207e9, 0.3, 7.94e-3, 4.1e-3, 15.55e-3)
    a, b = contact.semi_axes(500.0)
    assert 2.0 / 3.0 * contact.pressure(500.0) * 3.14159265 * a * b == pytest.approx(500.0, rel=1e-8, abs=0.0)


def test_a_6206_against_a_published_calculation():
    """6206 under 1000 N, inner race: 1.368 x 0.112 mm and 1728 MPa (eng-tools.dev, series A2, from the fits of
    Hamrock and Brewe, which explain the 2 %)."""
    contact = make_ball_contact(210e9, 0.3, 9.525e-3, 4.89e-3, (46e-3 - 9.525e-3) / 2.0)
    a, b = contact.semi_axes(5.0 * 1000.0 / 9.0)
    assert (a, b) == pytest.approx((1.368e-3, 0.112e-3), rel=0.03, abs=0.0)
    assert contact.pressure(5.0 * 1000.0 / 9.0) == pytest.approx(1728e6, rel=0.03, abs=0.0)


def test_a_ball_on_an_outer_race_is_stiffer():
    """6205, 7.94 mm on 39.04 mm: the outer race curves round the ball, so its contact is the stiffer one."""
    inner = make_ball_contact(207e9, 0.3, 7.94e-3, 4.1e-3, 15.55e-3)
    outer = make_ball_contact(207e9, 0.3, 7.94e-3, 4.1e-3, -23.49e-3)
    assert 1.03 < outer.k / inner.k < 1.10


@pytest.mark.parametrize(
    ("r_g", "R", "message"),
    [(3.9e-3, 15e-3, "fit"), (4.1e-3, -3.9e-3, "fit"), (3.97e-3 * (1 + 1e-12), 15e-3, "line")],
)
def test_a_ball_that_does_not_fit_is_refused(r_g, R, message):
    with pytest.raises(ValueError, match=message):
        make_ball_contact(207e9, 0.3, 7.94e-3, r_g, R)
