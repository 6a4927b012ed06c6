"""The CPU clock in compiled code, and the loops that end by it."""

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
from tests.scenes.nf308 import PLACES, SLOT, at_rest, case, recorded

PAST = 1e-9  # s: CPU time that every thread has used


@jit
def read_clock():
    """Read the clock in compiled code."""
    return thread_seconds()


def test_compiled_code_reads_the_clock_of_its_thread() -> None:
    read_clock()
    before, read, after = time.thread_time(), read_clock(), time.thread_time()
    assert before <= read <= after


@pytest.mark.parametrize(("end", "over"), [(PAST, True), (1e9, False), (np.inf, False), (0.0, False)])
def test_a_buffer_without_an_end_is_never_past_it(end: float, over: bool) -> None:
    """Which is one of zeros."""
    assert is_over(end) == over
    assert assemble.empty_buffer(assemble.model(case()))[lay.CPU_END] == 0.0


def test_the_search_for_an_equilibrium_ends_by_the_clock() -> None:
    """Of a ring that stands 100 of its longest steps away: after the first 16 of them."""
    model = assemble.static_model(assemble.model(case()))
    far = 100.0 * equilibrium.LONGEST_STEP
    left = {}
    for end in (np.inf, PAST):
        y = assemble.empty_buffer(model)
        y[lay.POSITION + lay.X], y[lay.CPU_END] = far, end
        equilibrium.solve_equilibrium(model, 0.0, y)
        left[end] = y[lay.POSITION + lay.X]
    assert left[np.inf] < 0.1 * far
    assert left[PAST] > 0.8 * far


def test_an_adaptive_method_ends_by_the_clock_between_two_recorded_instants(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    setup = set_up(choice.resolve(case(method="dop853", defect=SLOT, duration="20 ms")))
    method = setup.method._replace(h=1e-3, longest=1e-7)  # ten thousand steps to the first instant
    y = at_rest(setup.model)
    prepare_first_step(method, setup.model, 0.0, y)
    y[lay.CPU_END] = PAST
    found = recorded(method, setup.model, setup.monitor, 0, y, PLACES, np.empty((len(PLACES), 3)))
    assert found[:2] == (1, outcomes.TOO_SLOW)
    assert y[lay.STEPS_TAKEN] <= adaptive.CLOCK_INTERVAL


def test_estimates_of_an_impact_end_by_the_clock() -> None:
    given = case(speed="0.01 rpm", defect=SLOT, duration="2000 s")
    model = assemble.model(given)
    began = time.thread_time()
    peak = passage_peak(model, 0, 1e-6, 1e-6, PAST)
    free_impact(model.bearing.m_r, model.outer, 1e6, PAST)
    assert peak > 0.0
    assert time.thread_time() - began < 1.0
