"""Ends of a run, and its restart from an extrapolated state."""

from typing import Any

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.simulation import choice, integration
from bearingsim.simulation.integration import Inspection, Pace, integrate
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import RECORD_CRITERION
from bearingsim.simulation.run_setup import Setup, TooCostly, set_up
from tests.scenes.short_cases import SLOT, case


@pytest.fixture(scope="module")
def setup() -> Setup:
    return set_up(choice.resolve(case(model="rollers", defect=SLOT, method="verlet", periodic=False)))


def test_run_ends_after_the_largest_number_of_passes(setup: Setup) -> None:
    assert integrate(setup, max_passes=3).repetition.computed == 3 < setup.grid.passes
    assert integrate(setup).repetition.computed == setup.grid.passes


def test_run_ends_at_the_first_inspection_that_suffices(setup: Setup) -> None:
    inspected: list[int] = []

    def suffices(raw: RawRecord) -> bool:
        inspected.append(raw.repetition.computed)
        return raw.repetition.computed >= 4

    raw = integrate(setup, inspector=Inspection((2, 4, 6), suffices))
    assert (inspected, raw.repetition.computed) == ([2, 4], 4)


def test_run_without_a_period_is_too_costly_after_its_patience(setup: Setup) -> None:
    with pytest.raises(TooCostly, match="no ball pass of 5 repeats another") as caught:
        integrate(setup, max_search_passes=5)
    assert not caught.value.periodic


def test_periodic_run_is_not_too_costly() -> None:
    periodic = set_up(choice.resolve(case(model="rollers", defect=SLOT, method="verlet")))
    raw = integrate(periodic)
    assert 1 < raw.repetition.computed < periodic.grid.passes
    assert integrate(periodic, max_search_passes=raw.repetition.computed).repetition == raw.repetition


def test_forces_before_the_start_are_no_extremes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A model without memory also gives samples before t = 0, for filters."""
    record_steps = integration._record_steps

    def record_large_force(setup: Setup, samples: Any, start: int, y: np.ndarray, *others: Any) -> None:
        record_steps(setup, samples, start, y, *others)
        y[lay.Q_O_MAX] = 1e9 if start < 0 else y[lay.Q_O_MAX]

    monkeypatch.setattr(integration, "_record_steps", record_large_force)
    raw = integrate(set_up(choice.resolve(case(model="static", defect=SLOT))))
    assert 150.0 / 13.0 < raw.peaks.max() < 1e3


def test_run_begins_at_rest_unless_its_steady_motion_is_reached() -> None:
    """Two ball passes are too few to extrapolate the steady motion of a heavy ring."""
    fields = {
        "model": "rollers",
        "defect": SLOT,
        "rig": {"ring_mass": "20 kg"},
        "settle": "auto",
        "method": "verlet",
        "duration": "0.3 s",
    }
    heavy = set_up(choice.resolve(case(**fields)))
    pace = Pace(max_cpu=60.0)
    assert integration._find_steady_start(heavy, pace, None, RECORD_CRITERION, max_passes=2) is None
    steady = integration._find_steady_start(heavy, pace, None, RECORD_CRITERION, max_passes=None)
    assert steady is not None
    assert steady.shape == (2, 6, lay.ROW)


def test_restart_from_a_new_state_equals_a_start_from_it(setup: Setup) -> None:
    """Accelerations follow from the new positions and velocities, not from those before."""
    y, motion = integration._make_initial_buffer(setup, 0.0), slice(lay.POSITION, lay.POSITION + 2 * lay.STATE)
    accelerations = slice(lay.ACCELERATION, lay.ACCELERATION + lay.STATE)
    at_rest = y[accelerations].copy()
    y[motion] *= 1.01
    integration._restart_at(setup, 0.0, y)
    new_start = integration._make_initial_buffer(setup, 0.0, y[motion].reshape(2, 6, lay.ROW))
    assert np.array_equal(y[accelerations], new_start[accelerations])
    assert np.abs(y[accelerations] - at_rest).max() > 1.0
