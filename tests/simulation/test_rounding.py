"""Motion within rounding errors counts as zero, and a small motion does not."""

import math
from typing import Any

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import comparison
from bearingsim.simulation.rounding import Rounding
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import simulate

BASE: dict[str, Any] = {"bearing": "nu206", "speed": "1800 rpm", "load": "500 N", "model": "rollers"}


def preloaded(clearance: str, **fields: Any) -> Case:
    """A healthy bearing all of whose rollers are loaded, so that its stiffness hardly varies."""
    return Case.model_validate(BASE | {"clearance": clearance, "duration": "60 ms", "settle": "30 ms"} | fields)


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"periodic": False},
        {"load": "5 kN", "step_check": "strict"},
        {"model": "ring"},
        {"bearing": "6309", "clearance": "-60 um"},
        {"antialias": False, "record": ["ring.velocity", "ring.displacement", "roller.1.outer_force"]},
    ],
)
def test_motion_within_rounding_is_neither_chaotic_nor_in_error(fields: dict[str, Any]) -> None:
    """Two runs of it differ by as much as they move."""
    record = simulate(preloaded(**{"clearance": "-50 um"} | fields))
    values = record.features
    assert values["velocity.rms"] < values["velocity.rounding"] < 1e-14
    assert values["chaotic"] == values["rms_scatter"] == 0.0
    assert math.isnan(values["step_error.line"])
    assert math.isnan(values["step_error.rms"])
    assert values["step_error.force"] < 1e-3
    assert values["step_error.record"] < 1e-3
    assert values["error.start"] == values["error.start.rms"] == 0.0
    assert math.isnan(values["velocity.crest"])
    assert math.isnan(values["velocity.kurtosis"])
    if fields.get("periodic", True) and "step_check" not in fields:
        assert record.info["period_passes"] == 1


def test_small_motion_is_not_zero() -> None:
    """The varying compliance moves the ring by 1e-15 m, at 1e-12 m/s: as static equilibrium, solved at each
    instant, does."""
    values, static = (simulate(preloaded("-2 um", **fields)).features for fields in ({}, {"model": "static"}))
    assert values["velocity.rms"] == pytest.approx(static["velocity.rms"], rel=0.02)
    assert 5e-13 < values["velocity.rms"] < 2e-12
    assert values["velocity.rounding"] < 1e-3 * values["velocity.rms"]
    assert static["velocity.rounding"] < static["velocity.rms"]
    assert values["chaotic"] == 0.0
    assert max(values["step_error.line"], values["step_error.rms"]) < 0.01


def test_small_motion_is_not_chaotic_because_its_perturbation_is_notable() -> None:
    """1e-10 of the displacement is 3 % of the slow, hardly damped motion of a heavy ring, and does not grow."""
    fields = {"rig": {"ring_mass": "100 kg"}, "contact": {"damping": {"law": "kraemer", "beta": "0.1 us"}}}
    values = simulate(preloaded("-2 um", model="ring", duration="100 ms", **fields)).features
    assert 1e-12 < values["velocity.rms"] < 1e-10
    assert values["chaotic"] == 0.0
    assert values["step_error.line"] < 0.01


def test_errors_of_a_motion_near_rounding_contain_it() -> None:
    """Four times the bound of rounding; before, the difference of two runs at rest passed for chaos."""
    values = simulate(preloaded("-3.5 um")).features
    share = values["velocity.rounding"] / values["velocity.rms"]
    assert 0.05 < share < 1.0
    assert values["chaotic"] == 0.0
    assert values["step_error.rms"] >= share
    assert values["step_error.line"] >= values["velocity.rounding"] / values["velocity@BPFO"]


def test_bound_of_rounding_is_that_of_position_and_force() -> None:
    """A step of 10 ns moves a ring with eps u/(2 h) or more; the forces kick it with eps sum(Q)/m."""
    case = preloaded("-50 um", method="verlet", step="10 ns", step_check=False)
    setup = set_up(case)
    position = 0.5 * 2.0**-52 * 4.04e-7 / setup.grid.step  # m, displacement of the ring under 500 N
    assert position < setup.rounding.velocity < 1.1 * position
    assert setup.rounding.acceleration == pytest.approx(2.0**-52 * 5.6e4 / setup.model.bearing.m_o, rel=0.02)


def test_bound_belongs_to_the_motion_of_rings() -> None:
    cells = np.array(
        [lay.POSITION + lay.X, lay.VELOCITY + lay.Y_I, lay.SENSOR_A, lay.RADIAL, lay.POSITION + lay.PSI]
    )
    assert Rounding(1.0, 2.0, 3.0).of_cells(cells).tolist() == [1.0, 2.0, 3.0, 0.0, 0.0]


@pytest.mark.parametrize(("rounding", "change"), [(4e-6, 0.02), (1e-2, 0.01), (0.05, 0.0)])
def test_change_is_that_beyond_rounding_if_rounding_is_notable(rounding: float, change: float) -> None:
    series = np.array([1.0, -1.0] * 8)
    assert comparison.rms_change(1.02 * series, series, rounding) == pytest.approx(change)
    assert comparison.pass_changes(0.02 * series, 3, 1.0, rounding) == pytest.approx(change)


def test_change_of_a_constant_without_rounding_counts() -> None:
    """The force of a roller at rest has no bound of rounding; before, 5 N passed for 7 N."""
    assert comparison.raw_value_change(np.full(8, 5.0), np.full(8, 7.0)) > 1.0
    assert comparison.raw_value_change(np.zeros(8), np.zeros(8)) == 0.0
