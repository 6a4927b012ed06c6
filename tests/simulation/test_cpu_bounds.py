"""CPU time limit of a job: it is checked in every phase of the computation."""

import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim import catalogue, cpu_time
from bearingsim.catalogue import FEATURES, Feature
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import (
    choice,
    compile_solvers,
    features,
    limits,
    simulate,
    spectral_lines,
    step_check,
    time_grid,
    warm_up,
)
from bearingsim.simulation.integration import Pace, integrate, step_usage
from bearingsim.simulation.record import Usage, make_record
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import SimulationError
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.study import load_study
from benchmarks.cpu_bounds import study_of
from tests.scenes.short_cases import SLOT, case


def stack_at_timeout(compute: Callable[[], Any], seconds: float = 0.0) -> list[str]:
    """Return the names of the functions interrupted after ``seconds`` of CPU time, from the outermost."""
    with cpu_time.at_most(seconds), pytest.raises(cpu_time.OutOfCpuTime) as caught:
        compute()
    return [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]


@pytest.fixture(scope="module")
def resolved_case() -> Case:
    return choice.resolve(case(model="rollers", defect=SLOT, periodic=False, record=["ring.velocity"]))


@pytest.fixture
def empty_caches() -> None:
    """Clear the caches of earlier cases."""
    for function in (
        limits.step_limits,
        limits._common_limits,
        limits.load_and_rates_at_rest,
        limits.fast_body_rates,
    ):
        function.cache_clear()


@pytest.mark.usefixtures("empty_caches")
def test_pricing_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    assert "find_equilibrium" in stack_at_timeout(lambda: time_grid.estimate(resolved_case))


def test_impact_estimate_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    model = set_up(resolved_case).model
    assert "impact_force" in stack_at_timeout(lambda: limits.impact_force(model, 50.0))


def test_start_of_a_run_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    setup = set_up(resolved_case)
    assert "_make_initial_buffer" in stack_at_timeout(lambda: integrate(setup))


def test_integration_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    long_case = resolved_case.model_copy(update={"duration": 60.0})
    assert "_record_steps" in stack_at_timeout(lambda: integrate(set_up(long_case)), 0.1)


def test_step_check_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    long_case = resolved_case.model_copy(update={"duration": 60.0, "step_check": True})
    assert "check_on_pilot" in stack_at_timeout(lambda: step_check.check_step(set_up(long_case)), 0.1)


def test_evaluation_of_a_record_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    setup = set_up(resolved_case)
    raw = integrate(setup)
    for compute in (
        lambda: spectral_lines.amplitudes_by_pass(resolved_case, setup.model, setup.grid, raw),
        lambda: features.compute_features(resolved_case, setup.model, setup.grid, raw, {}),
        lambda: features.compute_statistics(resolved_case, setup.grid, raw),
        lambda: make_record(Inspections(setup), raw, step_check.UNCHECKED, Usage.now()),
    ):
        assert "<lambda>" in stack_at_timeout(compute)  # not after it


def test_filter_in_parts_equals_the_whole_filter(resolved_case: Case) -> None:
    """Bit for bit; a low `sampling` needs many taps."""
    from bearingsim.simulation import recording

    setup = set_up(resolved_case)
    low = replace(integrate(setup), taps=np.ones(101) / 101).low_passed
    full = low.read(100, 500)
    with mock.patch.object(recording, "MULTIPLICATIONS", 1):
        assert np.array_equal(low.read(100, 500), full)


def test_filling_in_of_passes_stops_at_the_cpu_limit(resolved_case: Case) -> None:
    raw_case = case(model="rollers", defect=SLOT, antialias=False, step_check=False, duration="1 s")
    setup = set_up(choice.resolve(raw_case))
    with mock.patch("bearingsim.simulation.recording.Recording.fill_repeated_passes", autospec=True) as fill:
        integrate(setup)
    recording, repetition = fill.call_args.args
    fill = type(recording).fill_repeated_passes
    assert "fill_repeated_passes" in stack_at_timeout(lambda: fill(recording, repetition))


def test_timeout_in_an_extension_feature_is_not_reported_as_its_error() -> None:
    def slow(*_: Any) -> float:
        cpu_time.check()
        return 1.0

    with (
        mock.patch.dict(FEATURES, {"slow": Feature("slow", "", "slow", "its_own:slow")}, clear=True),
        mock.patch.object(catalogue, "code", return_value=slow),
    ):
        names = stack_at_timeout(lambda: features.compute_extension_features(case(), np.zeros(1), {}))
    assert names[-2:] == ["slow", "check"]


@pytest.mark.parametrize("extreme", ["load lost in rounding", "slow turn"])
def test_extreme_job_stops_at_the_cpu_limit(tmp_path: Path, extreme: str) -> None:
    """The other jobs of ``make cpu-bounds`` use models or methods that take long to compile."""
    job = load_study(study_of(extreme, tmp_path)).jobs()[0]
    start = cpu_time.now()
    with suppress(cpu_time.OutOfCpuTime, SimulationError), cpu_time.at_most(0.5):
        time_grid.estimate(job.case)
        simulate(job.case)
    assert cpu_time.now() - start < 1.0


def test_pace_starts_with_few_steps() -> None:
    pace = Pace(max_cpu=60.0)
    pace.add(1.0, pace.steps)  # eight steps, a second
    assert pace.steps == 1
    pace.add(1e-6, 1)
    assert 1 < pace.steps <= 4000
    assert pace.cpu_s == pytest.approx(1.000001)


def test_warm_up_ends_at_its_cpu_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """No machine takes the millions of steps of this ball pass within the limit."""
    monkeypatch.setattr(warm_up, "_COMPILED", set())
    monkeypatch.setattr(warm_up, "WARM_UP_LIMIT", 0.05)
    slow = case(model="rollers", method="verlet", defect=SLOT, speed="3 rpm", duration="10 s", settle="0 s")
    steps = step_usage().steps
    compile_solvers([slow])
    assert step_usage().steps - steps < time_grid.make_grid(slow).steps_per_pass > 5_000_000


def test_step_loop_contains_the_cpu_limit_of_the_job(resolved_case: Case) -> None:
    with cpu_time.at_most(1e4):
        limited = integrate(set_up(resolved_case))
    assert 0.0 < limited.y[lay.CPU_END] < 1.1e4
    unlimited = integrate(set_up(resolved_case))
    assert unlimited.y[lay.CPU_END] == np.inf
    assert np.array_equal(limited.fine, unlimited.fine)


def test_reported_cpu_time_is_that_of_the_process(resolved_case: Case) -> None:
    start = cpu_time.now()
    info = simulate(resolved_case).info
    assert 0.0 < float(info["integrator_cpu_s"]) < float(info["cpu_s"]) < cpu_time.now() - start
