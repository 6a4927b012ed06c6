"""The largest force within a step, from its start, middle and end."""

from math import cos

import pytest

from bearingsim.core.models.extremes import largest_within
from bearingsim.simulation.simulate import simulate
from tests.scenes.short_cases import SLOT, case


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
