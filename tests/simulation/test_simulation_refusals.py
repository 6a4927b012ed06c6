"""Cases that are refused before a run, and runs that are stopped."""

import importlib
import pickle
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, advance_and_sample
from bearingsim.simulation import choice, limits, refinement, time_grid
from bearingsim.simulation.simulate import SimulationError, simulate
from tests.scenes.short_cases import RATE, SLOT, case

MODULE = importlib.import_module("bearingsim.simulation.integration")


def test_step_over_the_limit_is_refused_with_advice() -> None:
    with pytest.raises(SimulationError, match="of the method's limit") as caught:
        simulate(case(model="rollers", method="verlet", defect=SLOT, step="2 us"))
    assert caught.value.time is None
    assert "step: auto" in caught.value.advice


@pytest.mark.parametrize("factor", [2.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize(("model", "defects"), [("rollers", ()), ("rollers", (SLOT,)), ("ring", ())])
def test_run_over_the_step_limit_is_stopped(model: str, defects: tuple, factor: float) -> None:
    """``time_grid``, which would refuse these steps, is bypassed."""
    test_case = case(model=model, defects=defects, sampling=100.0, step="0.1 us")
    forced = min(factor * choice.limits(test_case).at_impact, 0.99 / RATE / time_grid.MIN_FINE)
    with (
        mock.patch.object(time_grid, "requested_step", return_value=forced),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(test_case)
    assert caught.value.time is not None
    assert 0.0 < caught.value.time < 0.12
    if model == "rollers":
        assert "roller " in caught.value.reason
    assert "step under" in caught.value.advice


@pytest.mark.parametrize("factor", [2.0, 4.0])
def test_an_automatic_step_that_is_too_long_is_refined(factor: float) -> None:
    """The estimate of the impacts is replaced by a wrong one; the line stays at 9.30 um/s."""
    test_case = case(model="rollers", method="verlet", defect=SLOT, sampling=1000.0)
    limit = choice.limits(test_case).at_impact
    with (
        mock.patch.object(time_grid, "requested_step", return_value=factor * limit),
        mock.patch.object(refinement, "requested_step", return_value=factor * limit),
    ):
        result = simulate(test_case)
    stable = limits.SAFETY * limit
    assert result.info["step_s"] in [pytest.approx(stable / 5.0 ** (k / 2.0), rel=0.05) for k in (1, 2, 3)]
    assert 1e6 * result.features["velocity@BPFO"] == pytest.approx(9.30, abs=0.05)


def test_refinement_of_an_automatic_step_is_limited() -> None:
    test_case = case(model="rollers", method="verlet", defect=SLOT, sampling=100.0)
    forced = 30.0 * choice.limits(test_case).at_impact
    with (
        mock.patch.object(time_grid, "requested_step", return_value=forced),
        pytest.raises(SimulationError) as caught,
    ):
        simulate(test_case)
    assert "step under" in caught.value.advice
    assert type(pickle.loads(pickle.dumps(caught.value))) is SimulationError


def test_run_with_nan_is_stopped() -> None:
    def broken(method: Any, model: Any, monitor: Monitor, start: int, y: np.ndarray, *rest: Any) -> tuple:
        y[lay.POSITION] = np.nan
        return advance_and_sample(method, model, monitor, start, y, *rest)

    with mock.patch.object(MODULE, "advance_and_sample", broken), pytest.raises(SimulationError, match="finite"):
        simulate(case(method="verlet"))


def test_load_without_equilibrium_is_refused_with_a_reason() -> None:
    with pytest.raises(SimulationError, match="no static equilibrium") as caught:
        simulate(case(load=1e-9))
    assert "load" in caught.value.advice


def test_error_can_be_pickled() -> None:
    again = pickle.loads(pickle.dumps(SimulationError("why", "what", 0.5)))
    assert (again.reason, again.advice, again.time, str(again)) == ("why", "what", 0.5, "why; what")
