"""The closed forms of the oil film against integrals, printed numbers and solutions (tests/independent/ehl.py)."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from bearingsim.core.laws.hertz import effective_modulus, half_width, line_pressure, make_ball_contact
from bearingsim.core.laws.oil_film import (
    MARTIN,
    TIME_CONSTANT,
    LubricatedLine,
    entrainment_damping,
    entrainment_speed,
    equivalent_line_contact,
    film_compliance,
    film_damping,
    film_thickness,
    half_widths,
    hysteresis_damping,
    inlet_squeeze,
    moes_numbers,
    roll_off,
    squeeze_damping,
)
from bearingsim.core.laws.oil_viscosity import iso_viscosity, oil_density, walther
from tests.independent.ehl import Contact, at_rest, light_contact, loss_in_time, stiffness

E, NU = 207e9, 0.3
STEEL = effective_modulus(E, NU)
NF308 = LubricatedLine(0.012, 7.1e-3, STEEL, 0.03, 2.0e-8, 2.96)
LOADS = (20.0, 60.0, 150.0, 500.0, 1500.0, 5000.0)


def palmgren(Q, line):
    """Return dQ/d(delta) of delta = 3.84e-5 Q^0.9/L^0.8 mm, N and mm."""
    return 1e3 * Q**0.1 * (line.L * 1e3) ** 0.8 / (0.9 * 3.84e-5)


def film_solution(Q, line, cells=100):
    return at_rest(Contact(Q, *line), cells, growth=1.0 + 4.0 / cells)


# Rigid cylinders


def steady_film(exit):
    """Return pressure at the exit (zero where the film ends) and load over eta u R/h of a rigid film."""

    def slope(t):
        return (t * t - exit * exit) / (1.0 + t * t) ** 3

    return quad(slope, -np.inf, exit)[0], -12.0 * 2.0 * quad(lambda t: t * slope(t), -np.inf, exit)[0]


EXIT = brentq(lambda t: steady_film(t)[0], 0.1, 1.0)


def test_martins_film():
    """dp/dx = 12 eta u (h - h_exit)/h^3 with h = h_0 (1 + t^2), x = sqrt(2 R h_0) t: load 4.896 eta u R/h_0."""
    assert pytest.approx(0.4751, abs=1e-4) == EXIT
    assert steady_film(EXIT)[1] == pytest.approx(MARTIN, rel=1e-3, abs=0.0)


def test_squeezing_rigid_cylinders():
    """(h^3 dp')' = -12 eta V between the inlet and the exit at rest."""

    def moment(n):
        return quad(lambda t: t**n / (1.0 + t * t) ** 3, -np.inf, EXIT)[0]

    exact = 12.0 * 2.0**1.5 * (moment(2) - moment(1) ** 2 / moment(0))
    h = 1e-6
    assert inlet_squeeze(h, NF308) == pytest.approx(exact * 0.03 * 0.012 * 7.1e3**1.5, rel=1e-3, abs=0.0)
    assert exact == pytest.approx(1.5 * sqrt(2.0) * pi, rel=0.02, abs=0.0)  # half-Sommerfeld


def test_solution_agrees_with_rigid_cylinders():
    line = NF308._replace(alpha=1e-10)
    Q = 1.2 * light_contact(Contact(1.0, *line)).Q
    film = film_solution(Q, line)
    h = MARTIN * line.eta * line.u * line.R * line.L / Q
    assert film.thinnest == pytest.approx(h, rel=0.02, abs=0.0)
    assert film_thickness(Q, line).minimum == pytest.approx(h, rel=0.02, abs=0.0)
    assert stiffness(film, 1e15, 1.0)[0].imag == pytest.approx(inlet_squeeze(h, line), rel=0.05, abs=0.0)


def test_a_soft_film_has_the_damping_of_rigid_cylinders():
    Q = 1.0
    h = film_thickness(Q, NF308).minimum
    assert film_damping(Q, palmgren(Q, NF308), NF308) == pytest.approx(inlet_squeeze(h, NF308), rel=0.02, abs=0.0)


# Film thickness


@pytest.mark.parametrize(
    ("M", "L", "central", "minimum"),
    [
        (1e-3, 0.01, 3.0e3, 2.45e3),
        (1e4, 1e-4, 2.621 * 1e4**-0.2, 2.05 * 1e4**-0.2),
        (1e-3, 1e9, 1.287e6, 1.05e6),
        (1e9, 1e4, 1.311 * 1e9**-0.125 * 1e3, 0.96 * 1e9**-0.125 * 1e3),
    ],
)
def test_the_four_asymptotes_of_moes(M, L, central, minimum):
    line = NF308._replace(alpha=1.0)
    line = line._replace(alpha=L / moes_numbers(1.0, line)[1])
    Q = M / moes_numbers(1.0, line)[0]
    scale = line.R * sqrt(line.eta * line.u / (line.E_star * line.R))
    film = film_thickness(Q, line)
    assert film.central / scale == pytest.approx(central, rel=0.03, abs=0.0)
    assert film.minimum / scale == pytest.approx(minimum, rel=0.03, abs=0.0)


@pytest.mark.parametrize("Q", LOADS)
def test_film_and_damping_against_solutions(Q):
    film, k, omega = film_solution(Q, NF308), palmgren(Q, NF308), 10.0
    assert film_thickness(Q, NF308).central == pytest.approx(film.flow, rel=0.07, abs=0.0)
    assert film_thickness(Q, NF308).minimum == pytest.approx(film.thinnest, rel=0.07, abs=0.0)
    c = stiffness(film, k, omega)[0].imag / omega
    assert 0.8 * c < film_damping(Q, k, NF308) < 1.25 * c


def test_the_solution_converges():
    c = [stiffness(film_solution(500.0, NF308, cells), 4e8, 10.0)[0].imag for cells in (50, 100, 200)]
    assert c[0] == pytest.approx(c[2], rel=0.03, abs=0.0)
    assert c[1] == pytest.approx(c[2], rel=0.003, abs=0.0)


@pytest.mark.parametrize(("Q", "omega_T"), [(47.0, 0.1), (500.0, 1.0)])
def test_an_oscillation_of_a_nanometre_loses_pi_c_omega_X2(Q, omega_T):
    """The equations in time against those in frequency."""
    film, k = film_solution(Q, NF308, 60), palmgren(Q, NF308)
    omega = omega_T * NF308.u / (2.0 * film.contact.b)
    loss = pi * stiffness(film, k, omega)[0].imag * 1e-9**2
    assert loss_in_time(film, k, omega, 1e-9) == pytest.approx(loss, rel=0.01, abs=0.0)


# Damping


def test_the_film_is_a_spring_and_a_damper_in_series_with_the_contact():
    """At a load so light that both are rigid: 1/k + 1/(k_f + i omega c_f), except for the roll-off factor."""
    Q, k, omega = 20.0, 3e8, 2e4
    k_f = 1.0 / film_compliance(Q, NF308)
    tau = TIME_CONSTANT * sqrt(2.0 * NF308.R * film_thickness(Q, NF308).minimum) / NF308.u
    slow = 1.0 / (1.0 / k + 1.0 / (k_f * (1.0 + 1e-4j * tau)))
    assert squeeze_damping(Q, k, NF308) == pytest.approx(slow.imag / 1e-4, rel=1e-6, abs=0.0)
    fast = 1.0 / (1.0 / k + 1.0 / (k_f * (1.0 + 0.79j * omega * tau)))
    assert squeeze_damping(Q, k, NF308, omega) == pytest.approx(fast.imag / (0.79 * omega), rel=1e-6, abs=0.0)


def test_entrainment_damping_of_a_growing_contact():
    """n (h/u) k db/d(delta) with db/d(delta) from the half widths of two loads."""
    Q, k = 2e3, 4e8
    db = (half_widths(Q + 1.0, NF308) - half_widths(Q - 1.0, NF308)) / (2.0 / k)
    n = entrainment_damping(Q, k, NF308) / (film_thickness(Q, NF308).central / NF308.u * k * db)
    assert 0.6 < n < 0.9
    assert entrainment_damping(Q, k, NF308, exponent=1 / 3) == pytest.approx(
        2 / 3 * entrainment_damping(Q, k, NF308), rel=1e-12, abs=0.0
    )
    assert half_widths(Q, NF308) == pytest.approx(half_width(Q, NF308.L, NF308.R, E, NU), rel=1e-12, abs=0.0)


def test_no_load_no_damping():
    assert film_damping(0.0, 3e8, NF308) == 0.0
    assert film_damping(-1.0, 3e8, NF308) == 0.0
    damping = film_damping(np.array([1e-3, 4e-3]), 3e8, NF308)
    assert damping[1] / damping[0] == pytest.approx(8.0, rel=1e-3, abs=0.0)  # Q^(3/2)


def test_loads_and_frequencies_in_arrays():
    Q, k = np.array([0.0, 10.0, 300.0, 5000.0]), np.array([1.0, 2.0, 3.0, 4.0]) * 1e8
    omega = np.array([0.0, 1e3, 1e4, 1e5])
    one_by_one = [film_damping(*case[:2], NF308, case[2]) for case in zip(Q, k, omega, strict=True)]
    assert film_damping(Q, k, NF308, omega) == pytest.approx(one_by_one, rel=1e-12, abs=0.0)


def test_roll_off_of_film_damping():
    share = roll_off(np.array([0.0, 0.5, 1.4, 10.0, 30.0]))
    assert share[0] == 1.0
    assert share[2] == 0.5
    assert np.all(np.diff(share) < 0.0)
    assert share[3] < 0.1


def test_hysteresis_has_the_same_loss_at_any_frequency():
    assert hysteresis_damping(3e8, 1e3, 0.015) * 1e3 == pytest.approx(
        hysteresis_damping(3e8, 7.0, 0.015) * 7.0, rel=1e-12, abs=0.0
    )
    assert hysteresis_damping(3e8, 1e3, 0.015) == pytest.approx(4500.0, rel=1e-12, abs=0.0)


def test_the_strip_equivalent_to_an_ellipse():
    ball = make_ball_contact(207e9, 0.3, 7.94e-3, 4.1e-3, 15.5e-3)
    a, b = ball.semi_axes(100.0)
    L, R = equivalent_line_contact(a, b, ball.pressure(100.0), STEEL)
    assert half_width(100.0, L, R, E, NU) == pytest.approx(b, rel=1e-9, abs=0.0)
    assert line_pressure(100.0 / L, R, STEEL) == pytest.approx(ball.pressure(100.0), rel=1e-9, abs=0.0)
    assert pytest.approx(1.0 / (2.0 / 7.94e-3 + 1.0 / 15.5e-3), rel=0.25, abs=0.0) == R


# Speed


def test_the_speed_of_the_contacts():
    """A rolling element whose surface has the races' speeds; both rings turn."""
    inner, outer, D_m, D_w = 300.0, -40.0, 0.065, 0.012
    r_i, r_o = (D_m - D_w) / 2, (D_m + D_w) / 2
    cage = (inner * r_i + outer * r_o) / D_m
    u = entrainment_speed(inner, D_m, D_w, outer)
    assert u == pytest.approx((inner - cage) * r_i, rel=1e-12, abs=0.0)
    assert u == pytest.approx((cage - outer) * r_o, rel=1e-12, abs=0.0)
    assert entrainment_speed(-inner, D_m, D_w, -outer) == u


# Viscosity


def vi(nu_40, L, H):
    return 100.0 * (L - nu_40) / (L - H)


@pytest.mark.parametrize(
    ("grade", "nu_100", "L", "H"),  # rows of ISO 2909 on both sides: their viscosity index brackets 95
    [(32, (5.2, 5.3), (43.76, 45.53), (30.43, 31.40)), (68, (8.5, 8.6), (111.5, 113.9), (65.32, 66.48))],
)
def test_the_grades_have_the_viscosity_index_95(grade, nu_100, L, H):
    nu = iso_viscosity(grade, 100.0) / oil_density(100.0) * 1e6
    assert nu_100[0] < nu < nu_100[1]
    assert vi(grade, np.interp(nu, nu_100, L), np.interp(nu, nu_100, H)) == pytest.approx(95.0, abs=0.1)


def test_an_oil_of_vg_68():
    """68 mm2/s at 40 C by definition. With 8.5 mm2/s at 100 C mineral VG 68 is read at about 20 mm2/s at 70 C."""
    assert iso_viscosity(68, 40.0) / oil_density(40.0) == pytest.approx(68e-6, rel=1e-12, abs=0.0)
    assert iso_viscosity(68, 40.0) == pytest.approx(0.0588, rel=2e-3, abs=0.0)
    assert iso_viscosity(68, 70.0) / oil_density(70.0) == pytest.approx(19.8e-6, rel=0.03, abs=0.0)


def test_walthers_line_through_printed_viscosities():
    """SAE 140 gear oil: 404 mm2/s at 40 C, 28 at 100 C, so 132.1 at 60 C (olezol.com, calculator of ASTM D341)."""
    assert walther(404.0, 28.0, 60.0) == pytest.approx(132.126, rel=1e-3, abs=0.0)


def test_density():
    assert oil_density(15.0) == 880.0
    assert oil_density(75.0) == pytest.approx(880.0 - 0.6278 * 60.0, rel=2e-3, abs=0.0)


@pytest.mark.parametrize("grade", [0, 40, 69, -68])
def test_other_grades_are_refused(grade):
    with pytest.raises(ValueError, match=f"ISO VG {grade} is not a grade of ISO 3448, which has 2, 3, 5"):
        iso_viscosity(grade, 40.0)


@pytest.mark.parametrize("celsius", [-20.1, 150.1, float("nan"), 313.15])
def test_other_temperatures_are_refused(celsius):
    with pytest.raises(ValueError, match="defined from -20 to 150 C"):
        iso_viscosity(68, celsius)
