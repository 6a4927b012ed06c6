"""Scales of a case."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from bearingsim.assemble.form import PIECES_PER_UNDULATION, build_race, build_rollers
from bearingsim.assemble.scales import approach, form_bounds
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import Linear, PowerLaw, TenNinths
from bearingsim.core.parts.form import Form, Smooth

Z, CAGE_SPEED, INNER_SPEED, SPIN = 12, 70.0, 180.0, 400.0  # rollers, rad/s
BEARING = SimpleNamespace(Z=Z, omega_c=CAGE_SPEED, omega_i=INNER_SPEED, omega_b=SPIN)


@pytest.mark.parametrize("k", [1e2, 1e8, 1e14])
def test_approach_under_a_load_for_soft_and_stiff_contacts(k: float) -> None:
    assert approach(Undamped(Linear(k)), 150.0) == pytest.approx(150.0 / k, rel=1e-9)
    assert approach(Undamped(Linear(k)), 0.0) == 0.0


@pytest.mark.parametrize("load", [1e-6, 1e-3, 1.0, 150.0, 1e5])
@pytest.mark.parametrize(
    "law", [PowerLaw(1e12, 3.0), PowerLaw(1e9, 1.05), TenNinths(1e9), make_johnson(206e9, 0.3, 10e-3, 50e-3)]
)
def test_the_approach_balances_the_load(law, load: float) -> None:
    contact = Undamped(law)
    assert normal_force(contact, approach(contact, load), 0.0) == pytest.approx(load, rel=1e-13)


HARMONICS = st.dictionaries(
    st.integers(1, 40),
    st.tuples(st.floats(0.1, 10.0), st.floats(-np.pi, np.pi)).map(lambda wave: wave[0] * np.exp(1j * wave[1])),
    min_size=1,
    max_size=3,
)
BETWEEN_PIECES = np.exp(1j * np.pi / PIECES_PER_UNDULATION)
"""Coefficient of a wave of amplitude 1 whose crests and steepest points are in the middle of pieces."""


@given(HARMONICS)
@example({5: BETWEEN_PIECES})
@example({33: BETWEEN_PIECES})
def test_form_bounds_are_the_largest_deviation_and_rate(harmonics: dict[int, complex]) -> None:
    amplitudes = np.zeros(max(harmonics) + 1, complex)
    amplitudes[list(harmonics)] = list(harmonics.values())
    angles, orders = np.linspace(0.0, 2.0 * np.pi, 200 * max(harmonics)), np.arange(len(amplitudes))
    waves = np.exp(1j * np.outer(angles, orders))
    deviation = np.abs((waves @ amplitudes).real).max()
    slope = np.abs((waves @ (1j * orders * amplitudes)).real).max()
    race, rollers, smooth = build_race(amplitudes, Z), build_rollers(amplitudes[None].repeat(Z, axis=0)), Smooth()
    for form, count, speed in (
        (Form(race, smooth, smooth), 1.0, CAGE_SPEED),
        (Form(smooth, race, smooth), 1.0, INNER_SPEED - CAGE_SPEED),
        (Form(smooth, smooth, rollers), 1.0, SPIN),
        (Form(race, race, rollers), 3.0, INNER_SPEED + SPIN),
    ):
        bounds = form_bounds(SimpleNamespace(form=form, bearing=BEARING))
        assert bounds == pytest.approx((count * deviation, speed * slope), rel=1e-3)


def test_form_bounds_of_smooth_surfaces_are_zero() -> None:
    assert form_bounds(SimpleNamespace(form=Smooth(), bearing=BEARING)) == (0.0, 0.0)
    assert form_bounds(SimpleNamespace(bearing=BEARING)) == (0.0, 0.0)
