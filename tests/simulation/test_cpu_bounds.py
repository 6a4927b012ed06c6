"""A job ends by its CPU time in whatever phase it is: nothing is computed for long without a look at the clock."""

import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim import catalogue, cpu_time
from bearingsim.catalogue import FEATURES, Feature
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import choice, features, limits, simulate, step_check, time_grid, warm
from bearingsim.simulation.integration import Pace, integrate
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import SimulationError, Usage, _record
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.warm_up import WARM_UP_LIMIT
from bearingsim.study import load_study
from benchmarks.cpu_bounds import study_of
from tests.scenes.short_cases import SLOT, case


def ended_in(compute: Callable[[], Any], seconds: float = 0.0) -> list[str]:
    """The functions in which a job ends that may take so much CPU time (s), from the outermost."""
    with cpu_time.at_most(seconds), pytest.raises(cpu_time.OutOfCpuTime) as caught:
        compute()
    return [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]


@pytest.fixture(scope="module")
def given() -> Case:
    return choice.resolve(case(model="rollers", defect=SLOT, periodic=False, record=["ring.velocity"]))


@pytest.fixture
def forgetful() -> None:
    """Nothing is remembered of earlier cases."""
    for remembered in (limits._common_limits, limits.loads_at_rest, limits.fast_body_rates):
        remembered.cache_clear()


@pytest.mark.usefixtures("forgetful")
def test_as_it_is_priced(given: Case) -> None:
    assert "find_equilibrium" in ended_in(lambda: time_grid.estimate(given))


def test_as_the_impact_of_a_roller_is_estimated(given: Case) -> None:
    model = set_up(given).model
    assert "impact_force" in ended_in(lambda: limits.impact_force(model, 50.0))


def test_as_it_begins(given: Case) -> None:
    setup = set_up(given)
    assert "_start" in ended_in(lambda: integrate(setup))


def test_as_it_is_stepped(given: Case) -> None:
    long = given.model_copy(update={"duration": 60.0})
    assert "_record_steps" in ended_in(lambda: integrate(set_up(long)), 0.1)


def test_as_its_step_is_checked(given: Case) -> None:
    long = given.model_copy(update={"duration": 60.0, "step_check": True})
    assert "check_on_pilot" in ended_in(lambda: step_check.check_step(set_up(long)), 0.1)


def test_as_features_are_read_and_series_filtered(given: Case) -> None:
    setup = set_up(given)
    raw = integrate(setup)
    for compute in (
        lambda: features.features(given, setup.model, setup.cut, raw),
        lambda: features.statistics(given, setup.cut, raw),
        lambda: _record(Inspections(setup), raw, step_check.UNCHECKED, Usage.now()),
    ):
        ended_in(compute)


def test_a_filter_is_applied_a_part_at_a_time(given: Case) -> None:
    """Of a low `sampling` it has many taps; in parts it gives the same, bit for bit."""
    from bearingsim.simulation import recording

    setup = set_up(given)
    low = integrate(setup).low_pass(np.ones(101) / 101)
    full = low.read(100, 500)
    with mock.patch.object(recording, "MULTIPLICATIONS", 1):
        assert np.array_equal(low.read(100, 500), full)


def test_as_raw_values_are_picked_of_what_repeats(given: Case) -> None:
    raw = case(model="rollers", defect=SLOT, antialias=False, step_check=False, duration="1 s")
    setup = set_up(choice.resolve(raw))
    with mock.patch("bearingsim.simulation.recording.Recording.fill_repeated_passes", autospec=True) as picks:
        integrate(setup)
    kept, repetition = picks.call_args.args
    picks = type(kept).fill_repeated_passes
    assert "fill_repeated_passes" in ended_in(lambda: picks(kept, repetition))


def test_a_feature_of_another_package_that_runs_out_of_time_is_no_fault_of_it() -> None:
    def slow(*_: Any) -> float:
        cpu_time.check()
        return 1.0

    with (
        mock.patch.dict(FEATURES, {"slow": Feature("slow", "", "slow", "its_own:slow")}, clear=True),
        mock.patch.object(catalogue, "code", return_value=slow),
    ):
        ended = ended_in(lambda: features.extension_features(case(), np.zeros(1), {}))
    assert ended[-2:] == ["slow", "check"]


@pytest.mark.parametrize("extreme", ["load lost in rounding", "slow turn"])
def test_an_extreme_job_ends_by_its_time(tmp_path: Path, extreme: str) -> None:
    """The others of ``make cpu-bounds`` take models or methods that compile for long."""
    job = load_study(study_of(extreme, tmp_path)).jobs()[0]
    began = cpu_time.now()
    with suppress(cpu_time.OutOfCpuTime, SimulationError), cpu_time.at_most(0.5):
        time_grid.estimate(job.case)
        simulate(job.case)
    assert cpu_time.now() - began < 1.0


def test_few_steps_are_taken_until_it_is_known_what_they_take() -> None:
    pace = Pace()
    pace.add(1.0, pace.steps)  # eight steps, a second
    assert pace.steps == 1
    pace.add(1e-6, 1)
    assert 1 < pace.steps <= 4000
    assert pace.cpu_s == pytest.approx(1.000001)


def test_what_compiles_code_beforehand_is_not_computed_for_long() -> None:
    """A ball pass of it takes millions of steps."""
    slow = case(model="rollers", method="verlet", defect=SLOT, speed="3 rpm", duration="10 s", settle="0 s")
    began = cpu_time.now()
    warm([slow])
    assert cpu_time.now() - began < WARM_UP_LIMIT + 0.5


def test_what_takes_steps_carries_the_end_of_the_job(given: Case) -> None:
    with cpu_time.at_most(1e4):
        bounded = integrate(set_up(given))
    assert 0.0 < bounded.y[lay.CPU_END] < 1.1e4
    free = integrate(set_up(given))
    assert free.y[lay.CPU_END] == np.inf
    assert np.array_equal(bounded.fine, free.fine)


def test_the_time_that_a_job_took_is_that_of_its_clock(given: Case) -> None:
    began = cpu_time.now()
    info = simulate(given).info
    assert 0.0 < float(info["integrator_cpu_s"]) < float(info["cpu_s"]) < cpu_time.now() - began
