"""The fastest motion of a bearing at rest: what a step is bounded by where rollers are not what is light."""

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
    """A model, its buffer at rest, the rates found of it, and those of its monitored bodies."""
    test_case = case(contact={"damping": {"law": "kraemer", "beta": "2.5 us"}}, **fields)
    model = assemble.with_friction_lag(assemble.model(test_case), limits.LONGEST_STEP)
    t, y, K, C = next(limits.rest_states(model))
    deep = approach(model.outer, float(assemble.outer_forces(model, y).max()))
    before = y.copy()
    result = rates_at_rest(model, t, y, deep)
    assert np.array_equal(y, before)
    return model, y, result, Rates(K, C)


@pytest.mark.parametrize("model", ["ring", "rollers", "planar"])
def test_of_an_ordinary_bearing_it_is_that_of_the_monitored_bodies(model: str) -> None:
    _, _, result, monitored = at_rest(model=model)
    least = 0.5 if model == "ring" else 0.9  # all contacts in one line are at most twice the eigenvalue
    assert least < result.K / monitored.K < 1.1
    assert least < result.C / monitored.C < 1.1
    assert limits.fast_body_rates(limits.rest_case(case(model=model))) == (0.0, 0.0)


def test_of_a_light_ring_it_is_that_of_the_ring_on_its_contacts() -> None:
    model, y, result, _ = at_rest(model="rollers", rig={"ring_mass": "1e-6 kg"})
    deep = np.maximum(y[lay.DELTA_O : lay.DELTA_O + model.bearing.Z], 0.0)
    normals = np.stack([y[row : row + model.bearing.Z] for row in (lay.COS, lay.SIN)])
    for value, bound, bracket in zip(
        result, (stiffness_bound, damping_bound), (model.support.k_b, model.support.c_b), strict=True
    ):
        contacts = np.array([float(bound(model.outer, float(one), 0.0)) for one in deep])
        held = normals * contacts @ normals.T + bracket * np.eye(2)
        assert value == pytest.approx(np.linalg.eigvalsh(held)[-1] / model.bearing.m_o, rel=0.1)


def test_a_ring_that_its_bracket_holds_hard_is_as_fast_as_that() -> None:
    model, _, result, monitored = at_rest(model="rollers", rig={"bracket_stiffness": "1e14 N/m"})
    assert pytest.approx(1e14 / model.bearing.m_o, rel=0.02) == result.K
    assert result.fastest > limits.FASTER_RATIO * monitored.fastest


def test_the_rate_of_a_damped_motion_is_its_largest_eigenvalue() -> None:
    for K, C in ((4.0, 1.0), (4.0, 10.0), (0.0, 3.0)):
        eigenvalues = np.linalg.eigvals([[0.0, 1.0], [-K, -C]])
        assert Rates(K, C).fastest == pytest.approx(np.abs(eigenvalues).max())


def test_a_light_ring_is_stepped_by_a_method_that_need_not_follow_it() -> None:
    """At its own rate the steps of explicit methods would go: 0.2 ns."""
    usual, light = (
        case(model="rollers", defect=SLOT, rig={"ring_mass": mass}, periodic=False) for mass in ("2 kg", "1e-6 kg")
    )
    of_usual, of_light = (limits.step_limits(choice.with_method(one, "verlet")) for one in (usual, light))
    assert of_light.at_rest < 1e-3 * of_usual.at_rest
    assert of_light.fastest_rate > 1e3 * of_usual.fastest_rate
    assert of_light.contact_frequency == pytest.approx(of_usual.contact_frequency, rel=1e-3)  # of the rollers
    assert of_usual.fastest_rate == pytest.approx(2.0 * pi * of_usual.contact_frequency, rel=0.5)
    assert choice.choice(light).method == "rodas"
