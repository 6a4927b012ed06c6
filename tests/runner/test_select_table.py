"""Table, notes and audits of a study with an accuracy."""

from pathlib import Path
from typing import Any

import pytest

from bearingsim import store
from bearingsim.runner.findings import findings
from bearingsim.study import load_study
from bearingsim.study.uncertainty import WITHOUT_FRICTION
from tests.scenes import trials
from tests.scenes.choices import RIGID, compute
from tests.scenes.commands import type_
from tests.scenes.study_text import Write
from tests.scenes.trials import TEXT, accuracy_study


def test_table_contains_models_and_error_bounds(write: Write, tmp_path: Path) -> None:
    compute(accuracy_study(write, TEXT + RIGID), tmp_path / "out")
    table = store.open_results(tmp_path / "out").table()
    error_columns = ["model", "error.model", "error.step", "error.scatter", "error"]
    assert [name for name in table.columns if name in error_columns] == error_columns
    cases, baselines = table[table["healthy"] != ""], table[table["healthy"] == ""]
    assert list(cases["model"]) == ["rollers"] * 3
    assert cases["error.model"].to_numpy() == pytest.approx([150 / 450 * 0.01, 300 / 450 * 0.01, 0.01], rel=1e-6)
    assert (cases["error.step"] == 0.0).all()
    assert cases["error"].to_numpy() == pytest.approx(cases["error.model"].to_numpy())
    assert (baselines["model"] == "").all()
    assert baselines[error_columns[1:]].isna().all(axis=None)


def test_table_contains_the_error_of_friction(write: Write, tmp_path: Path) -> None:
    """Two of three cases, at the ends of the curve, are tried with friction in other processes."""
    text = TEXT.replace("friction: none\n", "") + RIGID
    compute(accuracy_study(write, text), tmp_path / "out", jobs=2)
    choices = store.read_choices(tmp_path / "out").values()
    assert sorted(choice.inferred for choice in choices) == [False, False, True]
    table = store.open_results(tmp_path / "out").table()
    cases = table[table["healthy"] != ""]
    assert cases["error.friction"].to_numpy() == pytest.approx([0.002 / 3.0, 0.002, 0.002], rel=1e-6)
    assert cases["error"].to_numpy() == pytest.approx((cases["error.model"] + cases["error.friction"]).to_numpy())
    plan = store.read_plan(tmp_path / "out")
    assert f"3 of 3 cases computed {WITHOUT_FRICTION}" in plan["assumptions"]
    assert findings(plan, store.job_frame(tmp_path / "out")).assumptions[-2:] == (
        "no slip (effect: `error.friction`)",
        "no oil drag",
    )
    assert len(plan["accuracy"]["audits"]) == 3


def test_no_total_error_for_a_ring_assumed_to_be_rigid(write: Write, tmp_path: Path) -> None:
    summary = compute(accuracy_study(write), tmp_path / "out")
    table = store.open_results(tmp_path / "out").table()
    assert table["error"].isna().all()
    assert table["error.model"].notna().sum() == 3
    output = str(summary)
    assert "models for 5 %: `rollers` in 3 of 3 cases" in output
    assert (
        "3 of 3 cases are within 5 % of the reference model; relative to the largest value of the curve" in output
    )
    hint = "`error` is empty because the ring may bend: if it is rigid, add `rig: {ring: {bends: false}}`"
    assert hint in output
    assert hint in type_("show", tmp_path / "out")[0].splitlines()
    assert (
        "audit: 3 of 3 jobs recomputed with their reference are within the accuracy; largest difference 0.99 %"
        in output
    )


def test_commands_count_the_same_jobs(write: Write, tmp_path: Path) -> None:
    """Three cases with their baselines, and three audits, which have no rows."""
    study = accuracy_study(write)
    summary = compute(study, tmp_path / "out")
    assert (summary.planned, summary.done + summary.resumed) == (9, 9)
    shown = type_("show", tmp_path / "out")[0]
    assert "6 jobs: 6 done, and 3 audits" in shown.splitlines()
    checked = type_("check", study.path, "--out", tmp_path / "out")[0]
    assert checked.splitlines()[0].startswith("near: 9 jobs (3 cases, 3 healthy baselines, 3 audits)")


def test_no_accuracy_is_reported_before_the_first_job(write: Write, tmp_path: Path) -> None:
    from bearingsim.runner.promises import accuracy_notes

    compute(accuracy_study(write), tmp_path / "out")
    frame = store.job_frame(tmp_path / "out").assign(status="missing")
    assert not list(accuracy_notes(store.read_plan(tmp_path / "out"), frame))


def test_audits_compare_differences_from_the_healthy_case(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The records differ far more than the trials, so the audits fail."""
    text = TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO-healthy]}")
    text += "rig: {ring: {bends: false}}\n"
    study = load_study(write(text))

    def make_trial(case: Any, features: Any, passes: int, turn: float) -> Any:
        return trials.trial(
            (1.0 + bool(case.defects)) * case.load * trials.MODEL_FACTORS[case.model], passes, names=features
        ), None

    monkeypatch.setattr(trials, "try_out", make_trial)
    original = trials.simulate
    monkeypatch.setattr(
        trials, "simulate", lambda case: scale_line(original(case), 1.5 if case.model == "rollers" else 1.0)
    )
    summary = compute(study, tmp_path / "out")
    output = str(summary)
    assert (
        "audit: 0 of 3 jobs recomputed with their reference are within the accuracy; largest difference 34 %"
        in output
    )
    assert summary.exit_code == 0
    assert "withdrawn for 3 of 3 cases: velocity@BPFO-healthy is 34 % different" in output.splitlines()[1]
    assert "of the reference model" not in output
    table = store.open_results(tmp_path / "out").table()
    assert table["error.step"].isna().all()  # of so short a record, so that 34 % is no bound
    assert table["error"].isna().all()
    printed = type_("show", tmp_path / "out")[0]
    assert output.splitlines()[1] in printed.splitlines()


def scale_line(record: Any, factor: float) -> Any:
    record.features["velocity@BPFO"] *= factor
    return record
