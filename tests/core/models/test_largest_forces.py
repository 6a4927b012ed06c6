"""The largest force within a step, from its start, middle and end."""

from math import cos

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.core import layout as lay
from bearingsim.core.models.extremes import (
    largest_within,
    may_peak_within,
    store_forces_at_end,
    update_forces_within,
    update_largest_forces,
)
from bearingsim.simulation.recording import pop_peaks
from bearingsim.simulation.simulate import simulate
from tests.scenes.short_cases import SLOT, case

LANES = 16


@pytest.mark.parametrize("phase", [-0.6, -0.3, 0.0, 0.1, 0.5])
def test_the_maximum_of_a_smooth_force_has_fourth_order(phase: float) -> None:
    """A force 2 + cos, whose maximum is within a step of h; samples alone are off by second order."""
    errors = []
    for h in (0.8, 0.4):
        start, middle, end = (2.0 + cos(h * (x - 0.5 * phase)) for x in (-0.5, 0.0, 0.5))
        errors.append(abs(largest_within(start, middle, end) - 3.0))
    assert errors[0] < 2e-3 * 0.8**4 / 0.4
    assert errors[1] <= errors[0] / 12.0 + 1e-15


@pytest.mark.parametrize(
    ("values", "largest"),
    [((0.0, 100.0, 90.0), 100.0), ((1.0, 2.0, 3.0), 3.0), ((5.0, 5.0, 5.0), 5.0), ((9.0, 8.0, 9.0), 9.0)],
)
def test_no_extrapolation_where_a_force_jumps_or_grows(values: tuple[float, float, float], largest: float) -> None:
    assert largest_within(*values) == largest


@pytest.mark.parametrize("method", ["dormand-prince", "dop853", "rodas"])
def test_the_largest_force_does_not_depend_on_the_sampling(method: str) -> None:
    """Recorded every 20 us and every 2 us: the largest sample alone differs by several per cent."""
    fields = case(model="rollers", method=method, defect=SLOT, tolerance=1e-5, step_check=False, duration="20 ms")
    coarse, fine = (simulate(fields.model_copy(update={"step": step})).features for step in (20e-6, 2e-6))
    assert coarse["outer_force.max"] == pytest.approx(fine["outer_force.max"], rel=2e-3)


def forces_up_to(largest: float) -> st.SearchStrategy[list[float]]:
    """Return a strategy for the forces (N) Q_O, Q_I, Q_P of all rollers."""
    return st.lists(st.floats(0.0, largest), min_size=3 * LANES, max_size=3 * LANES)


def store_step(forces: list[float], y: np.ndarray) -> bool:
    """Store the forces Q_O, Q_I, Q_P of all rollers at the end of a step; return ``may_peak_within``."""
    for row, values in zip((lay.Q_O, lay.Q_I, lay.Q_P), np.reshape(forces, (3, LANES)), strict=True):
        y[row : row + LANES] = values
    update_largest_forces(y, LANES)
    store_forces_at_end(y, LANES)
    return may_peak_within(y, LANES)


@given(first=forces_up_to(1e4), start=forces_up_to(6e3), end=forces_up_to(6e3), fraction=st.floats(0.0, 2.0))
def test_a_step_whose_middle_is_skipped_holds_no_larger_force(
    first: list[float], start: list[float], end: list[float], fraction: float
) -> None:
    y = lay.buffer(LANES, 0.01)
    store_step(first, y)
    store_step(start, y)
    is_needed = store_step(end, y)
    before = peaks(y)
    middle = fraction * np.maximum(start, end)
    for row, values in zip((lay.Q_O, lay.Q_I, lay.Q_P), middle.reshape(3, LANES), strict=True):
        y[row : row + LANES] = values
    update_forces_within(y, LANES)
    assert is_needed or peaks(y) == before


def test_the_middle_is_needed_only_near_the_largest_force() -> None:
    y, static, impact = lay.buffer(LANES, 0.01), [1.0] * (3 * LANES), [40.0] + [1.0] * (LANES - 1)
    assert store_step(static, y)
    assert store_step(impact * 3, y)
    assert store_step(static, y)  # begins with the impact
    assert not store_step(static, y)
    assert store_step([21.0, *impact[1:]] * 3, y)
    pop_peaks(y)  # the next ball pass
    assert store_step(static, y)
    assert store_step(static, y)


def peaks(y: np.ndarray) -> list[float]:
    """Return the largest Q_O, Q_I and Q_P of any roller."""
    return [float(y[row : row + LANES].max()) for row in (lay.Q_O_MAX, lay.Q_I_MAX, lay.Q_P_MAX)]
