"""The largest force within a step, from its start, middle and end."""

from collections.abc import Sequence
from math import cos

import numpy as np
import pytest
from hypothesis import event, given
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


LARGEST = (500.0, 400.0, 5.0)  # N: Q_O, Q_I, |Q_P|
FRACTIONS = st.lists(st.floats(0.0, 0.6), min_size=3 * LANES, max_size=3 * LANES)


def scaled(fractions: Sequence[float]) -> np.ndarray:
    """Return forces (3, LANES) from their fractions of LARGEST."""
    return np.reshape(fractions, (3, LANES)) * np.reshape(LARGEST, (3, 1))


def alone(*forces: float) -> np.ndarray:
    """Return the forces (3, LANES) of one roller, the others being unloaded."""
    return np.pad(np.reshape(forces, (3, 1)), ((0, 0), (0, LANES - 1)))


def store_step(forces: np.ndarray, y: np.ndarray) -> bool:
    """Store the forces Q_O, Q_I, Q_P (3, LANES) at the end of a step; return ``may_peak_within``."""
    for row, values in zip((lay.Q_O, lay.Q_I, lay.Q_P), forces, strict=True):
        y[row : row + LANES] = values
    update_largest_forces(y, LANES)
    store_forces_at_end(y, LANES)
    return may_peak_within(y, LANES)


@given(start=FRACTIONS, end=FRACTIONS, fraction=st.floats(0.0, 2.0), scale=st.sampled_from((0.5, 0.8, 1.0)))
def test_a_step_whose_middle_is_skipped_holds_no_larger_force(
    start: list[float], end: list[float], fraction: float, scale: float
) -> None:
    """Middles of up to twice the larger end; many examples are skipped, because all their forces are small."""
    y = lay.make_buffer(LANES, 0.01)
    store_step(alone(*LARGEST), y)
    store_step(scale * scaled(start), y)
    is_needed = store_step(scale * scaled(end), y)
    event(f"skipped: {not is_needed}")
    before = peaks(y)
    middle = fraction * scale * np.maximum(scaled(start), scaled(end))
    for row, values in zip((lay.Q_O, lay.Q_I, lay.Q_P), middle, strict=True):
        y[row : row + LANES] = values
    update_forces_within(y, LANES)
    assert is_needed or peaks(y) == before


@pytest.mark.parametrize("kind", range(3))
def test_the_middle_is_needed_near_the_largest_force_of_each_kind(kind: int) -> None:
    y, low = lay.make_buffer(LANES, 0.01), alone(*(0.1 * force for force in LARGEST))
    near = alone(*((0.6 if i == kind else 0.1) * force for i, force in enumerate(LARGEST)))
    assert store_step(alone(*LARGEST), y)
    assert store_step(low, y)  # begins with the largest
    assert not store_step(low, y)
    assert store_step(near, y)  # ends near it
    assert store_step(low, y)  # begins near it
    assert not store_step(low, y)
    pop_peaks(y)  # the next ball pass
    assert store_step(low, y)


def peaks(y: np.ndarray) -> list[float]:
    """Return the largest Q_O, Q_I and Q_P of any roller."""
    return [float(y[row : row + LANES].max()) for row in (lay.Q_O_MAX, lay.Q_I_MAX, lay.Q_P_MAX)]
