"""Concurrent runs in one folder, which neither lose nor repeat a job."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from bearingsim import store
from bearingsim.runner import RunSummary, run, tally, work
from bearingsim.store import journal, marker, own_files, sealed
from tests.scenes import fake_studies
from tests.scenes.fake_studies import ENGINE, FakeStudy, case_id

MM = [1e-3, 2e-3, 3e-3, 4e-3]


def compute(widths: list[float], out: Path) -> RunSummary:
    study: Any = FakeStudy(widths)
    return run(study, out, jobs=1, progress=False, engine=ENGINE)


@pytest.mark.parametrize(
    ("other_widths", "difference"),
    [
        (MM[:1], "lacks 3 of this run's 5 jobs"),
        ([*MM, 5e-3, 6e-3], "has more jobs"),
        ([7e-3, *MM[1:]], "lacks 1 of"),
    ],
    ids=["shorter", "longer", "other"],
)
def test_concurrent_run_that_replaces_the_plan_loses_no_job(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, other_widths: list[float], difference: str
) -> None:
    """The other run begins and ends during the first job of this run."""
    original, computed, other_summaries = fake_studies.simulate, list[str](), list[RunSummary]()

    def simulate(case: Any) -> Any:
        computed.append(case_id(case))
        if len(computed) == 1:
            other_summaries.append(compute(other_widths, tmp_path))
        return original(case)

    monkeypatch.setattr(fake_studies, "simulate", simulate)
    monkeypatch.setattr(work, "LISTING_INTERVAL_S", 0.0)
    summary = compute(MM, tmp_path)
    assert (summary.exit_code, other_summaries[0].exit_code) == (0, 0)
    assert (summary.done, summary.planned, summary.missing) == (5, 5, 0)
    counts = Counter(computed)
    del counts[computed[0]]  # run by both
    assert {*counts.values()} == {1}
    assert "another run has replaced the plan of this folder" in str(summary)
    assert difference in str(summary)
    shared = len({*other_widths} & {*MM[1:]}) + 1  # and the healthy baseline
    assert f"{shared} job" in str(summary)
    study: Any = FakeStudy(other_widths)
    assert store.open_results(tmp_path).jobs == tuple(job.id for job in study.jobs())
    second_summary = compute(MM, tmp_path)
    assert (second_summary.resumed, second_summary.done) == (5, 0)


def test_concurrent_equal_run_computes_each_job_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The units have the same names; the other run ends during the first job of this run."""
    original, computed = fake_studies.simulate, list[str]()

    def simulate(case: Any) -> Any:
        computed.append(case_id(case))
        if len(computed) == 1:
            compute(MM, tmp_path)
        return original(case)

    monkeypatch.setattr(fake_studies, "simulate", simulate)
    monkeypatch.setattr(work, "LISTING_INTERVAL_S", 0.0)
    summary = compute(MM, tmp_path)
    assert (summary.exit_code, summary.done) == (0, 5)
    assert len(computed) == 6  # the job run by both


def test_plan_missing_at_the_end_is_reported(tmp_path: Path) -> None:
    compute(MM, tmp_path)
    plan = store.read_plan(tmp_path)
    (tmp_path / "plan.json").unlink()
    assert "lacks 5 of this run's 5 jobs" in "".join(tally.other_run_notes(tmp_path, plan, 0))


def test_file_renamed_by_a_concurrent_run_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.Failure("0123456789abcdef", "none").write(tmp_path)
    paths = own_files.FAILURES.find(tmp_path)
    paths[0].unlink()
    sealed.mark_damaged(paths[0])
    monkeypatch.setattr(own_files.OwnFiles, "find", lambda *_: paths)
    assert journal.load_failures(tmp_path) == ({}, {})


def test_folder_marked_by_a_concurrent_run_is_claimed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original, calls = marker.owner, list[Path]()

    def owner(folder: Path) -> tuple[str, str] | None:
        calls.append(folder)
        owner_before = original(folder)
        if len(calls) == 1:  # between this read and the next
            marker.mark(tmp_path, "results", "fake")
        return owner_before

    monkeypatch.setattr(marker, "owner", owner)
    store.claim(tmp_path, "results", "fake", "elsewhere")
    assert original(tmp_path) == ("results", "fake")


def test_folder_cleared_by_another_study_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original = store.in_use

    def in_use(root: Path) -> Any:
        store.claim_results(root, "other", quick=False, fresh=True)
        store.discard(root, "other")
        return original(root)

    monkeypatch.setattr(store, "in_use", in_use)
    with pytest.raises(store.OtherStudy, match="results of the study `other`"):
        compute(MM, tmp_path)
    assert not (tmp_path / "plan.json").exists()


def test_fresh_start_names_the_deleted_results_of_an_earlier_version(tmp_path: Path) -> None:
    compute(MM, tmp_path)
    (tmp_path / marker.MARKER_FILE).unlink()
    store.claim_results(tmp_path, "other", quick=False, fresh=True)
    assert marker.owner(tmp_path) == ("results", "fake")
    assert "the results of the study `fake`" in store.discard(tmp_path, "other")
    assert marker.owner(tmp_path) == ("results", "other")


@pytest.mark.parametrize("moment", ["estimate", "simulate"])
def test_jobs_of_a_concurrent_equal_run_are_not_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    """The other run takes place after this run has checked the folder, or during its first job."""
    original, simulate = getattr(fake_studies, moment), fake_studies.simulate
    requested, computed = list[str](), list[str]()

    def run_other(case: Any) -> Any:
        requested.append(case_id(case))
        if len(requested) == 1:
            compute(MM, tmp_path)
        return original(case)

    def record(case: Any) -> Any:
        computed.append(case_id(case))
        return run_other(case) if moment == "simulate" else simulate(case)

    monkeypatch.setattr(fake_studies, "estimate", run_other if moment == "estimate" else fake_studies.estimate)
    monkeypatch.setattr(fake_studies, "simulate", record)
    monkeypatch.setattr(work, "LISTING_INTERVAL_S", 0.0)
    summary = compute(MM, tmp_path)
    repeated = {job for job, count in Counter(computed).items() if count > 1}
    assert repeated == ({computed[0]} if moment == "simulate" else set())
    assert (summary.exit_code, summary.done, summary.missing) == (0, 5, 0)
    assert "were computed by another run in this folder" in str(summary)
    assert "replaced" not in str(summary)


def test_choices_of_a_concurrent_run_are_kept(tmp_path: Path) -> None:
    from bearingsim.selection import Choice

    first, second = (Choice(candidate=name, model=name, why="", error={}) for name in ("ring", "planar"))
    store.add_choices(tmp_path, {"a": first, "b": first}, "p")
    choices, plans = store.add_choices(tmp_path, {"b": second, "c": second}, "q")
    assert {name: choice.model for name, choice in choices.items()} == {"a": "ring", "b": "ring", "c": "planar"}
    assert (plans, store.read_choices(tmp_path)) == ({"a": "p", "b": "p", "c": "q"}, choices)
