"""Fastest motion of a bearing at rest, which limits the step if another body is lighter than the rollers."""

from math import pi
from typing import Any

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble.scales import approach
from bearingsim.core import layout as lay
from bearingsim.core.laws.damping.interface import damping_bound, stiffness_bound
from bearingsim.simulation import choice, limits
from bearingsim.simulation.fastest import Rates, rates_at_rest
from tests.scenes.short_cases import SLOT, case


def at_rest(**fields: Any) -> tuple[Any, np.ndarray, Rates, Rates]:
    """Return a model, its buffer at rest, its rates, and those of its monitored bodies."""
    test_case = case(contact={"damping": {"law": "kraemer", "beta": "2.5 us"}}, **fields)
    model = assemble.with_friction_lag(assemble.model(test_case), limits.LONGEST_STEP)
    t, y, K, C = next(limits.rest_states(model))
    max_approach = approach(model.outer, float(assemble.outer_forces(model, y).max()))
    original = y.copy()
    result = rates_at_rest(model, t, y, max_approach)
    assert np.array_equal(y, original)
    return model, y, result, Rates(K, C)


@pytest.mark.parametrize("model", ["ring", "rollers", "planar"])
def test_rates_of_an_ordinary_bearing_are_those_of_the_monitored_bodies(model: str) -> None:
    _, _, result, monitored = at_rest(model=model)
    min_ratio = 0.5 if model == "ring" else 0.9  # all contacts in one line are at most twice the eigenvalue
    assert min_ratio < result.K / monitored.K < 1.1
    assert min_ratio < result.C / monitored.C < 1.1
    assert limits.fast_body_rates(limits.rest_case(case(model=model))) == (0.0, 0.0)


def test_rates_of_a_light_ring_are_those_of_the_ring_on_its_contacts() -> None:
    model, y, result, _ = at_rest(model="rollers", rig={"ring_mass": "1e-6 kg"})
    approaches = np.maximum(y[lay.DELTA_O : lay.DELTA_O + model.bearing.Z], 0.0)
    normals = np.stack([y[row : row + model.bearing.Z] for row in (lay.COS, lay.SIN)])
    for value, bound, bracket in zip(
        result, (stiffness_bound, damping_bound), (model.support.k_b, model.support.c_b), strict=True
    ):
        contacts = np.array([float(bound(model.outer, float(delta), 0.0)) for delta in approaches])
        total = normals * contacts @ normals.T + bracket * np.eye(2)
        assert value == pytest.approx(np.linalg.eigvalsh(total)[-1] / model.bearing.m_o, rel=0.1)


def test_rate_of_a_ring_on_a_stiff_bracket() -> None:
    model, _, result, monitored = at_rest(model="rollers", rig={"bracket_stiffness": "1e14 N/m"})
    assert pytest.approx(1e14 / model.bearing.m_o, rel=0.02) == result.K
    assert result.fastest > limits.FASTER_RATIO * monitored.fastest


def test_rate_of_damped_motion_is_the_largest_eigenvalue() -> None:
    for K, C in ((4.0, 1.0), (4.0, 10.0), (0.0, 3.0)):
        eigenvalues = np.linalg.eigvals([[0.0, 1.0], [-K, -C]])
        assert Rates(K, C).fastest == pytest.approx(np.abs(eigenvalues).max())


def test_implicit_method_is_chosen_for_a_light_ring() -> None:
    """Steps of explicit methods would be 0.2 ns."""
    ordinary, light = (
        case(model="rollers", defect=SLOT, rig={"ring_mass": mass}, periodic=False) for mass in ("2 kg", "1e-6 kg")
    )
    ordinary_limits, light_limits = (
        limits.step_limits(choice.with_method(ring_case, "verlet")) for ring_case in (ordinary, light)
    )
    assert light_limits.at_rest < 1e-3 * ordinary_limits.at_rest
    assert light_limits.fastest_rate > 1e3 * ordinary_limits.fastest_rate
    assert light_limits.contact_frequency == pytest.approx(
        ordinary_limits.contact_frequency, rel=1e-3
    )  # of the rollers
    assert ordinary_limits.fastest_rate == pytest.approx(2.0 * pi * ordinary_limits.contact_frequency, rel=0.5)
    assert choice.choose_method(light).method == "rodas"
