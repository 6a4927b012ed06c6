"""Limits of failures and CPU time of a run, which change neither results nor ids."""

import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bearingsim import cpu_time, simulation, store
from bearingsim.runner import RunSummary, run
from bearingsim.runner.packing import Cost, cost_text
from bearingsim.runner.pool import compute_outcomes
from bearingsim.runner.work import Work
from tests.scenes.commands import type_
from tests.scenes.fake_studies import ENGINE, FakeStudy
from tests.scenes.short_cases import case

WIDTHS = [1e-3 * (i + 1) for i in range(9)]


def compute(study: Any, out: Path, jobs: int = 1, **options: Any) -> RunSummary:
    return run(study, out, jobs=jobs, progress=False, engine=ENGINE, **options)


def statuses(out: Path) -> list[str]:
    return list(store.open_results(out).table()["status"])


def test_fail_fast_ends_the_run_and_stores_finished_jobs(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS, actions={3: "raise", 5: "raise"})  # one unit
    summary = compute(study, tmp_path, max_failures=1)
    assert (summary.done, summary.failed, summary.missing, summary.exit_code) == (3, 1, 6, 1)
    assert statuses(tmp_path) == ["done"] * 3 + ["failed"] + ["missing"] * 6
    assert "stopped early: 1 job failed (`--fail-fast`)" in str(summary)


def test_repeated_command_continues_without_failed_jobs(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS, actions={3: "raise", 5: "raise"})
    compute(study, tmp_path, max_failures=1)
    summary = compute(study, tmp_path, max_failures=1)
    assert (summary.resumed, summary.done, summary.failed, summary.missing) == (3, 1, 2, 4)
    last = compute(study, tmp_path, max_failures=1)
    assert (last.resumed, last.done, last.failed, last.missing) == (4, 4, 2, 0)
    assert "stopped early" not in str(last)


def test_run_ends_at_the_limit_of_failures(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS, actions={1: "raise", 3: "divide", 5: "raise"})
    summary = compute(study, tmp_path, max_failures=2)
    assert (summary.done, summary.failed, summary.missing) == (2, 2, 6)
    assert "stopped early: 2 jobs failed (`--max-failures 2`)" in str(summary)


def test_failures_below_the_limit_do_not_end_the_run(tmp_path: Path) -> None:
    summary = compute(FakeStudy(WIDTHS, actions={1: "raise"}), tmp_path, max_failures=2)
    assert (summary.done, summary.failed, summary.missing) == (9, 1, 0)
    assert "stopped early" not in str(summary)


def test_failures_count_over_all_units(tmp_path: Path) -> None:
    """Units are computed one after another in a single process."""
    jobs = FakeStudy(WIDTHS, actions={1: "raise", 2: "raise", 3: "raise", 4: "raise", 5: "raise"}).jobs()
    units = (jobs[:3], jobs[3:6], jobs[6:9])
    works = [Work(tmp_path, tuple(unit), (0.0,) * 3, ENGINE, {}, max_failures=3) for unit in units]
    results = list(compute_outcomes(works, 1))
    assert [(len(outcome.done), len(outcome.failed)) for outcome in results] == [(1, 2), (0, 1), (0, 0)]


def test_workers_store_running_jobs_when_the_run_ends_early(tmp_path: Path) -> None:
    widths = [1e-3 * (i + 1) for i in range(200)]
    study = FakeStudy(widths, actions={5: "raise"}, seconds=0.1)  # not the first: the other worker may start late
    summary = compute(study, tmp_path, 2, max_failures=1)
    assert summary.failed == 1
    assert 0 < summary.done < 100  # jobs of the other unit until its worker stops
    assert summary.done + summary.missing == 200
    assert summary.exit_code == 1
    assert compute(FakeStudy(widths[:4], seconds=0.1), tmp_path, 2).missing == 0  # the next run is not stopped


def test_worker_death_counts_as_failure_before_the_next_suspect(tmp_path: Path) -> None:
    study = FakeStudy(WIDTHS, actions={0: "exit", 8: "exit"}, seconds=0.1)
    summary = compute(study, tmp_path, 2, max_failures=1)
    assert summary.failed == 1
    assert summary.exit_code == 1
    assert "stopped early" in str(summary)


def test_expensive_jobs_are_reported_and_skipped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study: Any = FakeStudy(seconds=0.2)
    summary = run(study, tmp_path, jobs=1, engine=ENGINE, max_cpu=0.1)
    note = "4 jobs are skipped: estimated at up to 0.2 s of CPU time, over 0.1 s (`--max-cpu`)"
    assert (summary.done, summary.failed, summary.missing, summary.exit_code) == (0, 0, 4, 1)
    assert note in summary.notes
    assert note in capsys.readouterr().err
    assert not store.read_failures(tmp_path)
    second = compute(study, tmp_path)  # skipped jobs leave no trace
    assert (second.done, second.exit_code) == (4, 0)


@pytest.mark.parametrize(
    ("until", "costs", "text"),
    [
        ([None, None], [Cost(1.0, 0.0), Cost(2.0, 0.0, max_seconds=2.1)], "3 s of CPU time, 2 s on 2 workers"),
        (
            [None, None],
            [Cost(1.0, 0.0, max_seconds=12.0), Cost(1.0, 0.0)],
            "2 s of CPU time if the responses are periodic, up to 13 s if not; 1 s to 12 s on 2 workers",
        ),
        (
            [0.01, None],
            [Cost(1.0, 0.0, max_seconds=4.0), Cost(1.0, 0.0, max_seconds=4.0)],
            "2 s of CPU time if the responses are periodic and the records end early, up to 8 s if not; 1 s to 4 s"
            " on 2 workers",
        ),
    ],
)
def test_cost_is_a_range_where_it_depends_on_the_response(
    until: list[float | None], costs: list[Cost], text: str
) -> None:
    assert cost_text([SimpleNamespace(until=value) for value in until], costs, workers=2) == text


def test_run_announces_its_cost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study: Any = FakeStudy(seconds=0.001)
    run(study, tmp_path, jobs=1, engine=ENGINE)
    assert "4 jobs: about 0.004 s of CPU time, 0.004 s on 1 worker\n" in capsys.readouterr().err


def test_job_that_exceeds_its_cpu_limit_fails(tmp_path: Path) -> None:
    study = FakeStudy(actions={1: "spin"}, seconds=0.3)
    optimistic_engine = ENGINE.__class__(ENGINE.simulate, "tests.runner.test_bounds:cheap", ENGINE.warm)
    summary = run(study, tmp_path, jobs=1, progress=False, engine=optimistic_engine, max_cpu=0.1)  # type: ignore
    assert (summary.done, summary.failed) == (3, 1)
    [group] = summary.failures
    assert group.reason == "the job exceeded its limit of 0.1 s of CPU time (`--max-cpu`)"
    assert "--retry-failed" in group.advice
    assert run(study, tmp_path, jobs=1, progress=False, engine=ENGINE, retry_failed=True).exit_code == 0  # type: ignore


def cheap(case: Any) -> Any:
    return type("Estimate", (), {"cpu_seconds": 0.001, "bytes": 0.0, "max_memory": 0.0, "max_seconds": 0.0})


def test_cpu_time_of_the_estimate_counts_for_the_job(tmp_path: Path) -> None:
    """An estimate that finds no equilibrium may take longer than the job."""
    study: Any = FakeStudy(actions={1: "spin"}, seconds=0.15)
    slow = replace(ENGINE, estimate="tests.runner.test_bounds:thoughtful")
    summary = run(study, tmp_path, jobs=1, progress=False, engine=slow, max_cpu=0.2)
    assert (summary.done, summary.failed) == (3, 1)  # the others sleep
    summary = run(study, tmp_path, jobs=1, progress=False, engine=slow, max_cpu=0.5, retry_failed=True)
    assert (summary.done, summary.failed) == (1, 0)


def test_job_whose_estimate_exceeds_the_limit_is_skipped(tmp_path: Path) -> None:
    slow = replace(ENGINE, estimate="tests.runner.test_bounds:thoughtful")
    began = time.thread_time()
    study: Any = FakeStudy([1e-3])
    summary = run(study, tmp_path, jobs=1, progress=False, engine=slow, max_cpu=0.05)
    assert (summary.failed, summary.missing, summary.exit_code) == (0, 2, 1)  # the case and its healthy case
    assert "2 jobs are skipped: estimated at over 0.05 s (`--max-cpu`)" in summary.notes
    assert time.thread_time() - began < 1.0


def thoughtful(case: Any) -> Any:
    end = cpu_time.now() + 0.1
    while cpu_time.now() < end:
        cpu_time.check()
    return cheap(case)


def test_simulation_stops_at_the_cpu_limit_without_another_method() -> None:
    long = case(duration="5 s", periodic="false")
    short = simulation.simulate(case())  # compiled
    with pytest.raises(cpu_time.OutOfCpuTime, match="exceeded its limit"), cpu_time.at_most(0.02):
        simulation.simulate(long)
    with cpu_time.at_most(1e4):
        bounded = simulation.simulate(case())
    assert bounded.features == pytest.approx(short.features, rel=0.0, abs=0.0, nan_ok=True)
    cpu_time.check()  # the limit ends with its context


@pytest.mark.parametrize("options", [{"max_failures": 0}, {"max_cpu": 0.0}])
def test_limits_that_no_job_satisfies_are_refused(tmp_path: Path, options: Any) -> None:
    with pytest.raises(ValueError, match="expected"):
        compute(FakeStudy(), tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--max-cpu", "5"], "expected a time such as `50 ms`"),
        (["--max-cpu", "5 mm"], "expected a time such as `50 ms`"),
        (["--max-cpu", "0 s"], "expected a time above zero"),
        (["--max-failures", "0"], "should be greater than or equal to 1"),
        (["--fail-fast", "--max-failures", "3"], "omit `--max-failures`"),
    ],
)
def test_command_refuses_invalid_limits(study_folder: Path, arguments: list[str], message: str) -> None:
    _, error = type_("run", "small.yaml", *arguments, code=2)
    assert message in " ".join(error.replace("│", " ").split())


def test_command_skips_expensive_jobs(study_folder: Path) -> None:
    message, errors = type_("run", "small.yaml", "--jobs", "1", "--max-cpu", "1 ns", code=1)
    assert "0 of 8 jobs done" in message
    assert "8 jobs are skipped: estimated at" in errors
    assert "(`--max-cpu`)" in errors
