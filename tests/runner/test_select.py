"""Choice of models before the first job, and its use by later runs and shards."""

import os
import shlex
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.cli.plan import price_study
from bearingsim.cli.remarks import model_choices as choice_remarks
from bearingsim.runner import run
from bearingsim.runner.select import MissingChoices, choose_models
from bearingsim.selection import ModelSelector
from bearingsim.selection.choices import choice_key
from bearingsim.study import case_id, load_study
from tests.scenes import trials
from tests.scenes.choices import (
    LOADS,
    compute,
    count_trials,
    log,
    make_extended,
    model_errors,
    plan_notes,
    read_choices,
    read_results,
    take_lines,
)
from tests.scenes.commands import type_
from tests.scenes.study_text import Write
from tests.scenes.trials import ENGINE, LOG, TEXT, accuracy_study

__all__ = ["log"]


def test_choices_are_stored_before_the_first_job(
    write: Write, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, has_choices = tmp_path / "out", list[bool]()
    original = trials.simulate

    def simulate(case: Any) -> Any:
        has_choices.append((out / "choices.json").is_file())
        return original(case)

    monkeypatch.setattr(trials, "simulate", simulate)
    summary = compute(accuracy_study(write), out)
    assert (summary.done, summary.failed) == (9, 0)  # three jobs, their healthy cases, three audits
    assert has_choices == [True] * len(has_choices)
    assert {choice["candidate"] for choice in read_choices(out).values()} == {"rollers"}
    calls = take_lines(log)
    last_try = max(n for n, line in enumerate(calls) if line.startswith("try"))
    assert last_try < min(n for n, line in enumerate(calls) if line.startswith("simulate"))
    assert sum(line.startswith("try planar") for line in calls) == 3


def test_later_runs_and_shards_read_the_choices(write: Write, tmp_path: Path, log: Path) -> None:
    study, out = accuracy_study(write), tmp_path / "out"
    compute(study, out)
    assert count_trials(log) > 0
    before = (out / "choices.json").read_bytes()
    compute(accuracy_study(write), out)
    compute(accuracy_study(write), out, shard=(2, 3))
    assert count_trials(log) == 0
    assert (out / "choices.json").read_bytes() == before


def test_shard_without_choices_is_refused(write: Write, tmp_path: Path, log: Path) -> None:
    """The message contains the command to be run first."""
    quick = load_study(write(TEXT + "quick: {duration: 0.1 s}\n"), {"load": "[150 N, 300 N]"}, quick=True)
    with pytest.raises(
        MissingChoices, match=r"no choice of a model for 2 of 2 cases: run `bearingsim check "
    ) as error:
        compute(quick, tmp_path / "out", shard=(1, 3))
    arguments = shlex.split(str(error.value).split("`")[1])
    assert arguments[1:] == [
        *(
            "check",
            str(quick.path),
            "--out",
            str(tmp_path / "out"),
            "--set",
            "load=[150 N, 300 N]",
            "--quick",
            "--pilots",
        )
    ]
    assert take_lines(log) == []


def test_shards_choose_as_a_single_run(write: Write, tmp_path: Path) -> None:
    single, shared = tmp_path / "one", tmp_path / "shared"
    compute(accuracy_study(write), single)
    store.claim_results(shared, "near", quick=False)
    choose_models(accuracy_study(write), shared, 1, ENGINE, shown=False)  # as `check --pilots` does
    for number in (1, 2, 3):
        compute(accuracy_study(write), shared, shard=(number, 3))
    assert read_choices(single) == read_choices(shared)
    pd.testing.assert_frame_equal(read_results(single), read_results(shared))


def test_extended_study_keeps_earlier_choices(write: Write, tmp_path: Path, log: Path, monkeypatch) -> None:
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    before = read_choices(out)
    take_lines(log)
    monkeypatch.setitem(trials.MODEL_FACTORS, "rollers", 1.3)  # for new cases the model is wrong
    study = accuracy_study(write, TEXT.replace("450 N", "450 N, 600 N"))
    compute(study, out)
    after = read_choices(out)
    assert {name: after[name] for name in before} == before
    assert [choice["candidate"] for name, choice in after.items() if name not in before] == ["reference"]
    assert {line.split()[2] for line in take_lines(log) if line.startswith("try")} == {"600"}


def test_quick_study_stores_choices_in_its_own_folder(
    write: Write, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Overrides on the command line lead to other choices."""
    monkeypatch.chdir(tmp_path)
    path = write(TEXT + "quick: {duration: 0.15 s, sweep: {load: [150 N, 450 N]}}\n")
    overrides = {"clearance": "5 um"}
    studies = [load_study(path), load_study(path, quick=True), load_study(path, overrides, quick=True)]
    keys = [{choice_key(study, case) for case in study.cases()} for study in studies]
    assert list(map(len, keys)) == [3, 2, 2]
    assert len(set().union(*keys)) == 7
    for study in studies[:2]:
        run(study, jobs=1, progress=False, engine=ENGINE)
    assert read_choices(Path("results/near")).keys() == keys[0]
    assert read_choices(Path("results/near-quick")).keys() == keys[1]
    take_lines(log)
    run(studies[2], jobs=1, progress=False, engine=ENGINE)
    assert read_choices(Path("results/near-quick")).keys() == keys[1] | keys[2]
    assert plan_notes(Path("results/near-quick")) == []  # another value: all cases are new
    assert count_trials(log) > 0
    run(studies[1], shard=(2, 2), jobs=1, progress=False, engine=ENGINE)
    assert count_trials(log) == 0


def test_error_of_a_new_case_is_relative_to_the_current_curve(write: Write, tmp_path: Path) -> None:
    """The curve contains old and new cases; the errors of old cases do not change."""
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    expected = {150.0: 1.5 / 450.0, 300.0: 3.0 / 450.0, 450.0: 0.01}
    for loads, new_errors in (
        ("200 N", {200.0: 2.0 / 450.0}),
        ("200 N, 4500 N", {4500.0: 0.01}),
        ("200 N, 4500 N, 250 N", {250.0: 125.0 / 4500.0}),
    ):
        compute(make_extended(write, f"{LOADS}, {loads}"), out)
        expected |= new_errors
        assert model_errors(out) == pytest.approx(expected, rel=1e-6)


def test_extension_reports_the_number_of_kept_choices(write: Write, tmp_path: Path) -> None:
    out, study = tmp_path / "out", make_extended(write, f"{LOADS}, 600 N")
    compute(accuracy_study(write), out)
    assert plan_notes(out) == []
    summary = compute(study, out)
    note = "3 of 4 cases keep the model chosen for an earlier plan (remove choices.json to choose all again)"
    assert plan_notes(out) == [note]
    assert note in str(summary).splitlines()
    assert note in type_("show", out)[0].splitlines()
    assert note in str(compute(study, out)).splitlines()  # repeated by later runs
    assert note in [*choice_remarks(price_study(choose_models(study, out, 1, ENGINE, shown=False), 1))]
    (out / "choices.json").unlink()
    assert note not in str(compute(study, out))
    assert plan_notes(out) == []


def test_reduction_reports_the_number_of_kept_choices(write: Write, tmp_path: Path) -> None:
    compute(accuracy_study(write), tmp_path / "out")
    compute(make_extended(write, "150 N"), tmp_path / "out")
    assert len(plan_notes(tmp_path / "out")) == 1
    assert plan_notes(tmp_path / "out")[0].startswith("1 of 1 cases keeps the model")


def test_settings_without_influence_on_choices_keep_the_plan(write: Write, tmp_path: Path) -> None:
    compute(accuracy_study(write), tmp_path / "out")
    before = (tmp_path / "out/choices.json").read_bytes()
    compute(make_extended(write, "450 N, 300 N, 150 N"), tmp_path / "out")
    compute(accuracy_study(write, TEXT + "uncertainty: none\n"), tmp_path / "out")
    assert plan_notes(tmp_path / "out") == []
    assert (tmp_path / "out/choices.json").read_bytes() == before
    compute(
        accuracy_study(write, TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: velocity@BPFO}")),
        tmp_path / "out",
    )
    assert plan_notes(tmp_path / "out") == []
    text = TEXT.replace("5 %", "{within: 5 %, of: velocity@BPFO}").replace("y: velocity@BPFO", "y: velocity.rms")
    compute(accuracy_study(write, text), tmp_path / "out")  # without a curve other choices are possible
    assert plan_notes(tmp_path / "out")[0].startswith("3 of 3 cases keep the model")


def test_change_of_the_model_along_an_extended_curve_is_reported(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cases chosen together use one model per curve, unless several models cost less than a third."""
    compute(accuracy_study(write), tmp_path / "out")
    monkeypatch.setitem(trials.MODEL_FACTORS, "rollers", 1.3)
    summary = compute(make_extended(write, f"{LOADS}, 600 N"), tmp_path / "out")
    note = (
        "the choice of the model changes along 1 of 1 curves, which may cause a step:"
        " `rollers`, `planar` (reference)"
    )
    assert plan_notes(tmp_path / "out")[1:] == [note]
    assert note in str(summary).splitlines()
    assert note in type_("show", tmp_path / "out")[0].splitlines()


def test_other_accuracy_leads_to_other_choices(write: Write, tmp_path: Path, log: Path) -> None:
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    take_lines(log)
    compute(accuracy_study(write, TEXT.replace("5 %", "0.5 %")), out)
    assert (
        sorted(choice["candidate"] for choice in read_choices(out).values()) == ["reference"] * 3 + ["rollers"] * 3
    )
    assert count_trials(log) == 0  # of the same trials


def test_fresh_start_repeats_the_trials(write: Write, tmp_path: Path, log: Path) -> None:
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    trial_count = count_trials(log)
    compute(accuracy_study(write), out, fresh=True)
    assert count_trials(log) == trial_count > 0


def test_choices_do_not_depend_on_the_number_of_processes(write: Write, tmp_path: Path) -> None:
    compute(accuracy_study(write), tmp_path / "one")
    compute(accuracy_study(write), tmp_path / "two", jobs=2)
    assert read_choices(tmp_path / "one") == read_choices(tmp_path / "two")


def test_periodic_reference_is_not_computed_again(
    write: Write, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = trials.try_out

    def repeat(case: Any, features: Any, passes: int, turn: float) -> Any:
        original(case, features, passes, turn)
        return trials.trial(case.load, passes, repeats=True, names=features), trials.simulate(case)

    monkeypatch.setattr(trials, "try_out", repeat)
    study, out = accuracy_study(write), tmp_path / "out"
    assert len(ModelSelector(study, range(3)).next_trials({})) == 3
    summary = compute(study, out)
    assert (summary.planned, summary.resumed, summary.done) == (6, 0, 6)  # none by an earlier run
    trials_found = selection.read_trials(out)
    assert len(trials_found) == 3
    assert ModelSelector(study, range(3)).next_trials(trials_found) == []
    assert [job.id for job in study.planned()][:3] == [case_id(case) for case in study.cases()]


def test_engine_log_is_off_by_default() -> None:
    assert LOG not in os.environ
