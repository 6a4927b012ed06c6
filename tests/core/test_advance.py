"""Compiled loop over steps."""

from typing import Any

import numba
import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import NoSamples, advance_and_sample, first_lane_above
from bearingsim.core.jit import OPTIONS
from bearingsim.core.methods.interface import stability_ratio
from bearingsim.core.models.interface import damping_per_mass, stiffness_per_mass
from bearingsim.core.outcomes import NO_BODY
from bearingsim.simulation import channels
from bearingsim.simulation.run_setup import set_up
from tests.scenes.lanes import compiled, keeps_lanes, needs_vectors
from tests.scenes.short_cases import case


@pytest.mark.parametrize("method", ["verlet", "dop853"])
def test_step_loop_counts_no_references(method: str) -> None:
    """Reference counting would take a third to a half of a step of `ring` and `rollers`."""
    setup = set_up(case(model="rollers", method=method))
    y, cells = assemble.start(setup.case, setup.model)[0], channels.recorded_cells(setup.case)
    loop = numba.njit(**OPTIONS)(advance_and_sample.py_func)
    out = np.empty((len(cells), 4))
    arguments = setup.method, setup.model, setup.monitor, 0, y, cells, out, NoSamples()
    loop(*arguments)
    code = loop.inspect_llvm(tuple(numba.typeof(argument) for argument in arguments))
    calls = [line for line in code.splitlines() if " call " in line and "NRT_" in line]
    assert not calls


@needs_vectors
def test_monitor_is_vectorised_over_rollers() -> None:
    """A scalar loop takes six times as long, a fifth of a step of `rollers`."""

    def ratios(method: Any, model: Any, y: np.ndarray, n: int) -> None:
        for j in range(n):
            K, C = stiffness_per_mass(model, y, j), damping_per_mass(model, y, j)
            y[lay.STEP_RATIO + j] = stability_ratio(method, K, C)

    setup = set_up(case(model="rollers", method="verlet"))
    y = assemble.start(setup.case, setup.model)[0]
    assert keeps_lanes(compiled(ratios), setup.method, setup.model, y, 16)


def test_first_lane_above_a_bound() -> None:
    y = np.zeros(400)
    y[200:216] = 1.0
    assert first_lane_above(200, 1.0, y, 16) == NO_BODY
    y[[205, 207]] = 2.0
    assert first_lane_above(200, 1.0, y, 16) == 5
    y[203] = np.nan
    assert first_lane_above(200, 1.0, y, 16) == 3
