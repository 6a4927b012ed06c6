"""CPU clock in compiled code, and the loops that it ends."""

import time

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core import outcomes
from bearingsim.core.advance import prepare_first_step
from bearingsim.core.clock import is_over, thread_seconds
from bearingsim.core.defects.passage import free_impact, passage_peak
from bearingsim.core.jit import jit
from bearingsim.core.methods import adaptive
from bearingsim.core.models import equilibrium
from bearingsim.simulation import choice
from bearingsim.simulation.run_setup import set_up
from tests.scenes.nf308 import ROWS, SLOT, advance_recorded, at_rest, case

PAST = 1e-9  # s: CPU time that every thread has used


@jit
def read_clock():
    """Read the clock in compiled code."""
    return thread_seconds()


def test_compiled_code_reads_the_clock_of_its_thread() -> None:
    read_clock()
    start, reading, end = time.thread_time(), read_clock(), time.thread_time()
    assert start <= reading <= end


@pytest.mark.parametrize(("end", "expected"), [(PAST, True), (1e9, False), (np.inf, False), (0.0, False)])
def test_zero_and_infinity_are_never_past(end: float, expected: bool) -> None:
    """An empty buffer has the end 0."""
    assert is_over(end) == expected
    assert assemble.empty_buffer(assemble.model(case()))[lay.CPU_END] == 0.0


def test_equilibrium_search_stops_at_the_cpu_limit() -> None:
    """A ring starts 100 longest steps from its equilibrium; the search stops after 16 of them."""
    model = assemble.static_model(assemble.model(case()))
    distance = 100.0 * equilibrium.LONGEST_STEP
    remaining = {}
    for end in (np.inf, PAST):
        y = assemble.empty_buffer(model)
        y[lay.POSITION + lay.X], y[lay.CPU_END] = distance, end
        equilibrium.solve_equilibrium(model, 0.0, y)
        remaining[end] = y[lay.POSITION + lay.X]
    assert remaining[np.inf] < 0.1 * distance
    assert remaining[PAST] > 0.8 * distance


def test_adaptive_method_stops_at_the_cpu_limit_between_recorded_instants(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = set_up(choice.resolve(case(method="dop853", defect=SLOT, duration="20 ms")))
    method = setup.method._replace(h=1e-3, longest=1e-7)  # ten thousand steps to the first instant
    y = at_rest(setup.model)
    prepare_first_step(method, setup.model, 0.0, y)
    y[lay.CPU_END] = PAST
    result = advance_recorded(method, setup.model, setup.monitor, 0, y, ROWS, np.empty((len(ROWS), 3)))
    assert result[:2] == (1, outcomes.TOO_SLOW)
    assert y[lay.STEPS_TAKEN] <= adaptive.CLOCK_INTERVAL


def test_impact_estimates_stop_at_the_cpu_limit() -> None:
    slow_case = case(speed="0.01 rpm", defect=SLOT, duration="2000 s")
    model = assemble.model(slow_case)
    start = time.thread_time()
    peak = passage_peak(model, 0, 1e-6, 1e-6, PAST)
    free_impact(model.bearing.m_r, model.outer, 1e6, PAST)
    assert peak > 0.0
    assert time.thread_time() - start < 1.0
