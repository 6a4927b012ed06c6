"""Studies with many jobs: estimates from a sample, and truncated tables."""

import json
from unittest import mock

import pytest

from bearingsim.cli import plan, tables
from bearingsim.cli.remarks import unvaried_damping
from bearingsim.runner.progress import duration
from bearingsim.study import Study, load_study
from bearingsim.text.announcer import Announcer
from tests.scenes.commands import type_

STUDY = """\
study: many
bearing: nf308
model: ring
speed: 1800 rpm
load: 150 N
duration: 0.1 s
defect: {race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}
sweep:
  load: {linspace: [150 N, 300 N, 5]}
  defect.width: {linspace: [0.2 mm, 1 mm, 10]}
"""


@pytest.fixture
def study_file(tmp_path, monkeypatch):
    path = tmp_path / "many.yaml"
    path.write_text(STUDY)
    monkeypatch.setattr(plan, "MAX_PRICED", 20)
    return path


def test_cost_is_estimated_from_a_sample_of_jobs(study_file, monkeypatch):
    sampled = plan.price_study(load_study(study_file), 1)
    monkeypatch.setattr(plan, "MAX_PRICED", 1000)
    complete = plan.price_study(load_study(study_file), 1)
    assert (len(sampled.priced_jobs), len(complete.priced_jobs)) == (20, 55)
    assert sampled.job_counts == complete.job_counts
    assert sampled.cpu_seconds == pytest.approx(complete.cpu_seconds, rel=0.3)
    assert sampled.bytes == complete.bytes


@pytest.mark.parametrize(("step", "evaluated"), [("auto", [plan.ESTIMATING]), ("1 ms", [])])
def test_assumptions_are_evaluated_while_the_estimate_is_announced(study_file, step, evaluated):
    """They may compile code, which takes seconds; with refused jobs they are not printed."""
    announcements, messages = Announcer(enabled=False), []
    evaluation = mock.PropertyMock(side_effect=lambda: messages.append(announcements.message))
    with mock.patch.object(Study, "assumptions", evaluation):
        plan.price_study(load_study(study_file, {"step": step}), 1, announcements)
    assert messages == evaluated


def test_sampled_estimate_is_reported(study_file):
    stdout, _ = type_("check", study_file)
    assert "estimated from 20 of 55 jobs" in stdout
    assert "55 jobs (50 cases, 5 healthy baselines)" in stdout
    plan_json = json.loads(type_("check", study_file, "--json")[0])
    assert (plan_json["cases"], len(plan_json["jobs"])) == (50, 20)


def test_refused_jobs_are_counted_as_those_of_the_sample(study_file, monkeypatch):
    words = ["check", study_file, "--set", "step=1 ms", "--set", "model=rollers", "--set", "method=verlet"]
    stdout, stderr = type_(*words, code=2)
    assert "55 jobs (50 cases, 5 healthy baselines), 20 of 20 sampled refused; " in stdout
    assert f"{study_file}: 20 of 20 sampled jobs refused, the first at " in stderr
    plan_json = json.loads(type_(*words, "--json", code=2)[0])
    assert (plan_json["cases"], plan_json["sampled_jobs"], plan_json["refused_jobs"]) == (50, 20, 20)
    monkeypatch.setattr(plan, "MAX_PRICED", 1000)
    assert "55 jobs (50 cases, 5 healthy baselines), 55 refused; " in type_(*words, code=2)[0]


def test_cost_of_unvaried_damping_is_that_of_all_cases(study_file):
    """Each of the 50 cases would have three variations, each about as long as a case."""
    over = "{lhs: {n: 50, seed: 1, over: {load: {uniform: [150 N, 300 N]}}}}"
    study_file.write_text(f"{STUDY.partition('sweep:')[0]}sweep: {over}\n")
    sampled = plan.price_study(load_study(study_file), 1)
    assert 0 < len(sampled.cases) < 20
    mean = sum(priced.estimate.cpu_seconds for priced in sampled.cases) / len(sampled.cases)
    [remark] = unvaried_damping(sampled)
    assert remark.endswith(f" adds 150 jobs, {duration(150 * mean)}")


def test_the_first_and_the_last_job_are_priced(study_file):
    jobs = load_study(study_file).jobs()
    sample = plan.sample_jobs(jobs)
    assert (sample[0], sample[-1]) == (jobs[0], jobs[-1])
    assert len({job.id for job in sample}) == 20
    assert sample == plan.sample_jobs(jobs)


def test_extremes_of_swept_ranges_are_priced(study_file, monkeypatch):
    """A step may be refused at one of the ends only."""
    monkeypatch.setattr(plan, "MAX_PRICED", 5)
    jobs = load_study(study_file).jobs()
    sampled_ids = {id(job) for job in plan.sample_jobs(jobs)}
    for path in ("load", "defect.width"):
        values = [job.swept[path] for job in jobs if path in job.swept]
        for pick in (min, max):
            job = next(job for job in jobs if job.swept.get(path) == pick(values))
            assert id(job) in sampled_ids


def test_fewer_jobs_are_priced_with_tilting_rollers(study_file, monkeypatch):
    monkeypatch.setattr(plan, "MAX_PRICED", 55)
    assert len(plan.sample_jobs(load_study(study_file).jobs())) == 55
    overrides = {"model": "spatial", "misalignment.inner": "0.1 mrad"}
    jobs = load_study(study_file, overrides).jobs()
    assert len(jobs) == 55
    assert len(plan.sample_jobs(jobs)) == 55 // plan.UNEVEN_LOAD_WEIGHT


def test_cases_share_the_healthy_baseline(study_file):
    baselines = [job.baseline for job in load_study(study_file).jobs() if job.baseline is not None]
    assert (len(baselines), len({id(baseline) for baseline in baselines})) == (50, 5)


def test_long_table_is_truncated(done, monkeypatch):
    monkeypatch.setattr(tables, "MAX_ROWS", 3)
    stdout, _ = type_("show", done)
    assert "and 5 more jobs in results.csv (or use `--json`)" in stdout
    assert "8 jobs: 8 done" in stdout
    assert len(json.loads(type_("show", done, "--json")[0])) == 8
