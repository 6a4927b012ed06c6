"""Tabulated damping and the tabulated oil film: derivatives, touch-down, and the closed forms."""

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bearingsim.assemble import contacts
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.assemble.scales import approach
from bearingsim.config import Case, Film
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.damping.tabulated import Tabulated
from bearingsim.core.laws.hertz import effective_modulus
from bearingsim.core.laws.octaves import FLOOR, tabulate, value
from bearingsim.core.laws.oil_film import (
    LubricatedLine,
    entrainment_speed,
    equivalent_line_contact,
    film_damping,
    hysteresis_damping,
)
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from tests.scenes.laws import STEEL

RISING = Tabulated(STEEL, tabulate(lambda y: (1e6 * np.sqrt(y), 0.5e6 / np.sqrt(y))))
"""c = 1e6 sqrt(delta) N s/m."""
FALLING = Tabulated(STEEL, tabulate(lambda y: (1e3 * np.exp(-y / 1e-5), -1e8 * np.exp(-y / 1e-5))))
"""c = 1000 exp(-delta/10 um) N s/m, except below 15 pm."""


def case(bearing: str = "nf308", **film: Any) -> Case:
    damping = {"law": "film", "viscosity": "30 mPa s"} | film
    base = {"bearing": bearing, "speed": "1800 rpm", "load": "150 N", "model": "rollers"}
    return Case.model_validate(base | {"contact": {"damping": damping}})


FILM = contacts.build_outer_law(case())
LAWS = pytest.mark.parametrize("law", [RISING, FALLING, FILM], ids=["rising", "falling", "film"])


def test_the_table_is_the_function() -> None:
    for delta in np.geomspace(1e-10, 2e-5, 300):
        assert value(RISING.table, delta) == pytest.approx(1e6 * np.sqrt(delta), rel=1e-7)
        assert value(FALLING.table, delta) == pytest.approx(1e3 * np.exp(-delta / 1e-5), rel=1e-6)


@LAWS
@given(delta=st.floats(1e-9, 5e-5), v=st.floats(-0.3, 0.3))
def test_slopes_are_derivatives_of_the_force(law: Tabulated, delta: float, v: float) -> None:
    """By central differences, except across the clamp of the force."""
    h, step = 1e-4 * delta, 1e-5
    forces = [normal_force(law, delta + i * h, v + k * step) for i in (-2, 0, 2) for k in (-2, 0, 2)]
    assume(min(forces) > 0.0 or max(forces) == 0.0)
    K, C = derivatives(law, delta, v)
    by_approach = (normal_force(law, delta + h, v) - normal_force(law, delta - h, v)) / (2.0 * h)
    by_rate = (normal_force(law, delta, v + step) - normal_force(law, delta, v - step)) / (2.0 * step)
    assert pytest.approx(by_approach, rel=1e-4, abs=1e-4 * tangent(law.stiffness, delta)) == K
    assert pytest.approx(by_rate, rel=1e-7, abs=1e-9) == C


@LAWS
def test_the_force_does_not_jump_as_a_contact_closes(law: Tabulated) -> None:
    for v in (-0.3, 0.0, 0.3):
        assert normal_force(law, 0.0, v) == 0.0
        assert normal_force(law, -1e-9, v) == 0.0
        assert derivatives(law, -1e-9, v) == (0.0, 0.0)
        heights = [normal_force(law, FLOOR / 2.0**n, v) for n in range(1, 30)]
        assert heights[-1] < 1e-6 * max(heights[0], 1e-3)
    assert elastic(law.stiffness, 1e-9) < normal_force(law, 1e-9, 0.3)


@LAWS
@given(delta=st.floats(0.0, 1e-4), v=st.floats(-0.3, 0.3))
def test_bounds_are_at_least_the_derivatives(law: Tabulated, delta: float, v: float) -> None:
    """Non-negative, finite at touch-down, and at least the derivatives; the contact never pulls."""
    assert normal_force(law, delta, v) >= 0.0
    K, C = derivatives(law, delta, v)
    assert np.isfinite([stiffness_bound(law, delta, v), damping_bound(law, delta, v)]).all()
    assert stiffness_bound(law, delta, v) >= max(K, 0.0) * (1.0 - 1e-12)
    assert damping_bound(law, delta, v) >= max(C, 0.0) * (1.0 - 1e-12)


def test_nan_propagates() -> None:
    assert np.isnan(normal_force(FILM, float("nan"), 0.1))


# Tabulated film


LOADS = np.geomspace(0.5, 5000.0, 25)


def expected(bearing_case: Case, on_outer: bool, Q: float) -> tuple[float, float]:
    """Return damping (N s/m) of film and hysteresis of one contact at a load, from the closed forms."""
    b, film = bearing_case.bearing, bearing_case.contact.damping
    assert isinstance(film, Film)
    stiffness, other_stiffness = (
        contacts.build_stiffness_law(bearing_case, side) for side in (on_outer, not on_outer)
    )
    k = _tangent(stiffness, Q)
    omega = np.sqrt((k + _tangent(other_stiffness, Q)) / b.element_mass)
    E_star = effective_modulus(b.material.young_modulus, b.material.poisson_ratio)
    u = entrainment_speed(bearing_case.speed, b.pitch_diameter, b.roller_diameter)
    R_w, race = b.roller_diameter / 2.0, outer_radius(bearing_case) if on_outer else inner_radius(bearing_case)
    L, R, exponent = float(b.roller_length or 0.0), 1.0 / (1.0 / R_w + (-1.0 if on_outer else 1.0) / race), 0.5
    if b.element == "ball":
        point = contacts.point_contact(bearing_case, on_outer)
        a, b_axis = point.semi_axes(Q)
        (L, R), exponent = equivalent_line_contact(a, b_axis, 1.5 * Q / (pi * a * b_axis), E_star), 1.0 / 3.0
    line = LubricatedLine(L, R, E_star, film.inlet_viscosity, film.pressure_coefficient, u)
    oil = film_damping(Q, k, line, omega if film.at == "own" else 0.0, exponent)
    return float(oil), float(hysteresis_damping(k, omega, film.loss_factor))


def _tangent(stiffness: Any, Q: float) -> float:
    low, high = 0.0, 1e-3
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if elastic(stiffness, middle) < Q else (low, middle)
    return float(tangent(stiffness, high))


@pytest.mark.parametrize("at", ["low", "own"])
@pytest.mark.parametrize("bearing", ["nf308", "6205"])
@pytest.mark.parametrize("on_outer", [True, False], ids=["outer", "inner"])
def test_the_tabulated_film_equals_the_closed_forms(bearing: str, on_outer: bool, at: str) -> None:
    bearing_case = case(bearing, at=at)
    law = contacts.build_contact_law(bearing_case, on_outer)
    damping = np.array([derivatives(law, approach(law, Q), 0.0)[1] for Q in LOADS])
    errors = np.abs(damping / [sum(expected(bearing_case, on_outer, Q)) for Q in LOADS] - 1.0)
    assert np.sort(errors)[-4] < 1e-6
    # where pressure begins to thicken the oil: at 157 N in the NF308, 1.4 N in the 6205
    assert errors.max() < 1e-5


def test_each_race_has_its_own_film() -> None:
    """Balls also have different stiffnesses: at 300 N the inner race of the 6205 has more damping."""
    for bearing in ("nf308", "6205"):
        laws = [contacts.build_contact_law(case(bearing), on_outer) for on_outer in (True, False)]
        outer, inner = (derivatives(law, approach(law, 300.0), 0.0)[1] for law in laws)
        assert outer != pytest.approx(inner, rel=0.02)


def test_at_the_elements_natural_frequency_a_film_damps_less() -> None:
    slow, natural = (contacts.build_outer_law(case(at=at)) for at in ("low", "own"))
    for Q in LOADS:
        assert derivatives(natural, approach(natural, Q), 0.0)[1] < derivatives(slow, approach(slow, Q), 0.0)[1]


def test_more_oil_and_more_loss_damp_more() -> None:
    def damping(**film: Any) -> float:
        law = contacts.build_outer_law(case(**film))
        return float(derivatives(law, approach(law, 100.0), 0.0)[1])

    reference = damping()
    assert damping(viscosity="60 mPa s") > 1.05 * reference
    assert damping(loss_factor="3 %") - reference == pytest.approx(
        reference - damping(loss_factor="0 %"), rel=1e-6
    )
    assert damping(loss_factor="0 %") < reference
    assert damping(pressure_coefficient="10 1/GPa") != pytest.approx(reference, rel=1e-3)


def test_an_oil_has_the_viscosity_of_its_grade() -> None:
    """VG 68 at 55 C has 29.8 mPa s."""
    law = contacts.build_outer_law(case(viscosity=None, oil="VG 68", temperature="55 C"))
    film: Any = case(viscosity=None, oil="ISO VG 68", temperature="328.15 K").contact.damping
    viscosity = film.inlet_viscosity
    assert contacts.build_outer_law(case(viscosity=viscosity)).table == pytest.approx(law.table, rel=1e-12)
    assert viscosity == pytest.approx(0.0298, rel=0.02)


def test_damping_is_constant_beyond_the_table() -> None:
    law = contacts.build_outer_law(case())
    deepest = derivatives(law, 1e-4, 0.0)[1]
    assert derivatives(law, 1e-3, 0.0)[1] == pytest.approx(deepest, rel=1e-3)
