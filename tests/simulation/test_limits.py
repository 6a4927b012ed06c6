"""Step limits of the methods, crossing times of defects, and the largest forces of impacts."""

from itertools import pairwise
from math import inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.assemble import contacts
from bearingsim.core import layout as lay
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.methods.interface import step
from bearingsim.core.models.interface import accelerations, state_width
from bearingsim.core.parameters import Bearing
from bearingsim.simulation import limits as limiting
from bearingsim.simulation import settling
from bearingsim.simulation.choice import limits
from tests.scenes.nf308 import SLOT
from tests.scenes.oscillators import UNIT
from tests.scenes.slots import HEAVY, NARROW, SLOTS, case


class Oscillator(NamedTuple):
    """q'' = -K q - C q': the simplest thing a method can be unstable on."""

    K: float
    C: float
    bearing: Bearing = UNIT


@state_width.register(Oscillator)
def _state_width(model: Oscillator) -> int:
    return 1


@accelerations.register(Oscillator)
def _accelerations(model: Oscillator, t: float, y: np.ndarray) -> None:
    y[lay.ACCELERATION] = -model.K * y[lay.POSITION] - model.C * y[lay.VELOCITY]


def growth(method: Any, model: Oscillator) -> float:
    """Largest factor by which a step multiplies a part of the motion: spectral radius of the step, as coded."""
    rows = [lay.POSITION, lay.VELOCITY, lay.ACCELERATION]
    columns = []
    for row in rows:
        y = assemble.empty_buffer(assemble.model(case(model="ring")))
        y[row] = 1.0
        step(method, model, 0.0, y)
        columns.append(y[rows])
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())


def measured_limit(name: str, K: float, C: float) -> float:
    """Step (s) from which the solution of the oscillator grows, by bisection."""
    low, high = 0.0, 4.0 / sqrt(K)
    while high - low > 1e-4 * high:
        h = 0.5 * (low + high)
        if growth(assemble.kind_of_method(name).parameters(h), Oscillator(K, C)) > 1.0 + 1e-9:
            high = h
        else:
            low = h
    return low


@pytest.mark.parametrize("zeta", [0.01, 0.1, 0.3, 0.54, 0.7, 0.99, 1.01, 3.0, 10.0])
@pytest.mark.parametrize(("method", "least"), [("verlet", 0.98), ("rk4", 0.98)])
def test_step_limit_is_where_the_method_diverges(method: str, least: float, zeta: float) -> None:
    omega = 2.0 * pi * 20e3
    K, C = omega**2, 2.0 * zeta * omega
    true = measured_limit(method, K, C)
    assert least * true <= limiting.step_limit(method, K, C) <= 1.0002 * true


def test_zero_stiffness_and_damping_have_no_step_limit() -> None:
    assert limiting.step_limit("verlet", 0.0, 0.0) == inf
    assert limiting.step_limit(None, 1e9, 1e4) == inf


@pytest.mark.parametrize("model", ["ring", "rollers"])
@pytest.mark.parametrize(("method", "rise"), [("verlet", 1.0), ("rk4", 1.07)])
@pytest.mark.parametrize("defects", SLOTS)
def test_limits_decrease_with_load_for_load_dependent_damping(
    model: str, method: str, rise: float, defects: tuple
) -> None:
    """Up to 7 % of increase for RK4, whose stability limit is larger above half the critical damping."""
    by_load = [
        limits(case(model=model, method=method, defects=defects, load=load, **HEAVY))
        for load in (50, 150, 300, 1000, 5000)
    ]
    for name in ("at_rest", "at_impact"):
        series = [getattr(entry, name) for entry in by_load]
        assert all(after < rise * before for before, after in pairwise(series))
        assert series[-1] < 0.7 * series[0]
        assert len(set(series)) == len(series)
    assert all(entry.at_impact <= entry.at_rest for entry in by_load)
    assert [entry.rest_load for entry in by_load] == sorted(entry.rest_load for entry in by_load)


@pytest.mark.parametrize(("model", "bracket"), [("ring", 0.06), ("rollers", 0.0)])
def test_default_damping_is_proportional_to_stiffness_at_every_load(model: str, bracket: float) -> None:
    """c/k is 2.5 us; 100 times the load makes a contact 1.58 times as stiff, and the damping ratio 1.26 times.

    The bracket adds the fraction ``bracket`` or less to the ratio of a ring.
    """
    light, heavy = (limits(case(model=model, method="verlet", load=load)) for load in (50, 5000))
    assert light.damping_time == pytest.approx(2.5e-6, rel=1e-9)
    assert heavy.damping_time == pytest.approx(2.5e-6, rel=1e-9)
    assert heavy.damping_ratio == pytest.approx(100**0.05 * light.damping_ratio, rel=0.03 + bracket)
    assert 0.7 * light.at_rest < heavy.at_rest < 0.8 * light.at_rest


OWN_FILM = {"damping": {"law": "film", "oil": "VG 68", "temperature": "55 C", "at": "own"}}


@pytest.mark.parametrize("model", ["rollers", "planar"])
def test_damping_ratio_is_that_of_the_most_loaded_roller(model: str) -> None:
    """A film at the natural frequency damps a lightly loaded roller most, eight times as much as the heaviest."""
    loaded = case(model=model, method="verlet", load="2 kN", contact=OWN_FILM)
    b, found = assemble.model(loaded).bearing, limiting.step_limits(loaded)
    loads = found.rest_load, found.rest_load - b.m_r * b.omega_c**2 * loaded.bearing.pitch_diameter / 2.0
    k, c = 0.0, 0.0
    for law, load in zip((contacts.build_outer_law(loaded), contacts.build_inner_law(loaded)), loads, strict=True):
        delta = brentq(lambda d, law=law, load=load: normal_force(law, d, 0.0) - load, 0.0, 1e-4, xtol=1e-18)
        k += (normal_force(law, delta + 1e-11, 0.0) - normal_force(law, delta - 1e-11, 0.0)) / 2e-11
        c += (normal_force(law, delta, 1e-3) - normal_force(law, delta, -1e-3)) / 2e-3
    assert found.damping_ratio == pytest.approx(c / (2.0 * sqrt(k * loaded.bearing.element_mass)), rel=1e-4)


@pytest.mark.parametrize("fields", [{}, {"contact": {"damping": {"law": "hunt-crossley", "chi": "20 s/m"}}}])
def test_damping_ratio_of_a_ring_is_that_of_its_modes(fields: dict[str, Any]) -> None:
    """Not of the sum of its two directions, which is 1.3 times as large."""
    ring = case(model="ring", method="verlet", **fields)
    assert limiting.step_limits(ring).damping_ratio == pytest.approx(
        max(-mode.real / abs(mode) for mode in settling.mode_eigenvalues(ring)), rel=0.02
    )


def test_limits_do_not_depend_on_record_or_duration() -> None:
    base = case(defect=SLOT)
    other = case(defect=SLOT, record=[], duration="3 s", settle="0 s", step="0.1 us")
    assert limits(base) == limits(other)
    assert limits(case(defect=SLOT, load="151 N")) != limits(base)


def test_crossing_is_the_time_over_the_narrowest_defect() -> None:
    result = limits(case(defects=[SLOT | {"angle": "30 deg"}, NARROW]))
    cage = 2 * pi * 30 * (1 - 12 / 65) / 2
    assert result.crossing == pytest.approx(0.2e-3 / (0.0385 * cage), rel=1e-12)
    assert limits(case()).crossing == inf


@pytest.mark.parametrize(
    ("defect", "reach"),
    [
        (SLOT, 0.4e-3),  # the roller meets the far rim
        (SLOT | {"depth": "1 um"}, sqrt(2 * 6e-3 * 38.5e-3 / 32.5e-3 * 1e-6)),  # the floor before the middle
        (SLOT | {"shape": "triangular", "depth": "5 um"}, 6e-3 * 38.5e-3 / 32.5e-3 * 2 * 5 / 800),  # the wall
    ],
)
def test_closing_speed_is_the_steepest_slope_times_the_speed_along_the_race(defect: dict, reach: float) -> None:
    cage = 2 * pi * 30 * (1 - 12 / 65) / 2
    expected = reach / (6e-3 * 38.5e-3 / 32.5e-3) * 38.5e-3 * cage
    assert limits(case(defect=defect)).closing_speed == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("race", ["inner", "roller"])
def test_crossing_and_closing_speed_on_inner_race_and_roller(race: str) -> None:
    """Rolling: 2.959 m/s everywhere. On the inner race 1/R is 1/6 + 1/26.5 per mm: the edge is steeper there."""
    result, speed = limits(case(defect=SLOT | {"race": race})), 0.0385 * 2 * pi * 30 * (1 - 12 / 65) / 2
    assert result.crossing == pytest.approx(0.8e-3 / speed, rel=1e-12)
    assert result.closing_speed == pytest.approx(0.4e-3 * (1 / 6e-3 + 1 / 26.5e-3) * speed, rel=1e-12)


def test_only_outer_race_defects_are_aligned_with_steps() -> None:
    models = [assemble.model(case(defect=SLOT | {"race": race})) for race in ("outer", "inner", "roller")]
    moved = [
        assemble.align_with_cusp(model, 12345, 0.3).bearing.theta_0 != model.bearing.theta_0 for model in models
    ]
    assert moved == [True, False, False]


def test_undamped_impact_stores_all_energy_in_the_contact() -> None:
    model = assemble.model(case(contact={"damping": {"chi": "0 s/m"}}))
    speed, m, k = 0.05, model.bearing.m_r, model.outer.stiffness.k
    deepest = (19.0 / 9.0 * 0.5 * m * speed**2 / k) ** (9.0 / 19.0)
    peak, K, C = limiting.free_impact_response(m, model.outer, speed)
    assert peak == pytest.approx(k * deepest ** (10.0 / 9.0), rel=2e-3)
    assert m * K == pytest.approx(10.0 / 9.0 * k * deepest ** (1.0 / 9.0), rel=2e-3)
    assert C == 0.0


def test_impact_on_constant_damping_has_its_peak_at_contact() -> None:
    damping = {"law": "general", "coefficient": 1e6, "indentation_exponent": 0.0}
    model = assemble.model(case(contact={"damping": damping}))
    peak, _, C = limiting.free_impact_response(model.bearing.m_r, model.outer, 0.05)
    assert peak == pytest.approx(1e9 * 0.05, rel=1e-6)
    assert C * model.bearing.m_r == pytest.approx(1e9)


def test_impact_force_increases_with_speed() -> None:
    model = assemble.model(case())
    result = [
        limiting.free_impact_response(model.bearing.m_r, model.outer, speed) for speed in (0.01, 0.03, 0.1, 0.3)
    ]
    assert (np.diff(result, axis=0) > 0.0).all()
    assert limiting.free_impact_response(model.bearing.m_r, model.outer, 0.0) == (0.0, 0.0, 0.0)
    assert limiting.free_impact_response(0.0, model.outer, 0.1) == (0.0, 0.0, 0.0)


def test_laws_with_equal_coefficients_are_distinguished() -> None:
    laws = (
        case(contact={"damping": {"law": "hunt-crossley", "chi": 1e-4}}),
        case(contact={"damping": {"law": "kraemer", "beta": 1e-4}}),
    )
    soft, hard = (
        limiting.free_impact_response(0.01, assemble.contacts.build_outer_law(law), 0.05) for law in laws
    )
    assert hard[2] > 10.0 * soft[2]
