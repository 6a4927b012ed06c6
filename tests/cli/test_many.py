"""Studies of many jobs: some are priced, and some are printed."""

import json

import pytest

from bearingsim.cli import plan, tables
from bearingsim.study import load_study
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
def many(tmp_path, monkeypatch):
    path = tmp_path / "many.yaml"
    path.write_text(STUDY)
    monkeypatch.setattr(plan, "MAX_PRICED", 20)
    return path


def test_some_jobs_stand_for_all(many, monkeypatch):
    some = plan.plan_of(load_study(many), 1)
    monkeypatch.setattr(plan, "MAX_PRICED", 1000)
    every = plan.plan_of(load_study(many), 1)
    assert (len(some.priced_jobs), len(every.priced_jobs)) == (20, 55)
    assert some.job_counts == every.job_counts
    assert some.cpu_seconds == pytest.approx(every.cpu_seconds, rel=0.3)
    assert some.bytes == every.bytes


def test_it_is_said_that_some_were_priced(many):
    said, _ = type_("check", many)
    assert "estimated from 20 of 55 jobs" in said
    assert "55 jobs (50 cases, 5 healthy twins)" in said
    told = json.loads(type_("check", many, "--json")[0])
    assert (told["cases"], len(told["jobs"])) == (50, 20)


def test_the_first_and_the_last_job_are_priced(many):
    jobs = load_study(many).jobs()
    found = plan.sample_jobs(jobs)
    assert (found[0], found[-1]) == (jobs[0], jobs[-1])
    assert len({job.id for job in found}) == 20
    assert found == plan.sample_jobs(jobs)


def test_the_ends_of_swept_ranges_are_priced(many, monkeypatch):
    """A step may be refused at one of them only."""
    monkeypatch.setattr(plan, "MAX_PRICED", 5)
    jobs = load_study(many).jobs()
    found = {id(job) for job in plan.sample_jobs(jobs)}
    for path in ("load", "defect.width"):
        values = [job.swept[path] for job in jobs if path in job.swept]
        for end in (min, max):
            first = next(job for job in jobs if job.swept.get(path) == end(values))
            assert id(first) in found


def test_fewer_are_priced_where_rollers_tilt(many, monkeypatch):
    monkeypatch.setattr(plan, "MAX_PRICED", 55)
    assert len(plan.sample_jobs(load_study(many).jobs())) == 55
    leaning = {"model": "spatial", "misalignment.inner": "0.1 mrad"}
    jobs = load_study(many, leaning).jobs()
    assert len(jobs) == 55
    assert len(plan.sample_jobs(jobs)) == 55 // plan.UNEVEN_LOAD_WEIGHT


def test_cases_share_the_healthy_twin(many):
    twins = [job.baseline for job in load_study(many).jobs() if job.baseline is not None]
    assert (len(twins), len({id(twin) for twin in twins})) == (50, 5)


def test_a_long_table_is_cut(done, monkeypatch):
    monkeypatch.setattr(tables, "MAX_ROWS", 3)
    said, _ = type_("show", done)
    assert "and 5 more jobs in results.csv (or use `--json`)" in said
    assert "8 jobs: 8 done" in said
    assert len(json.loads(type_("show", done, "--json")[0])) == 8
