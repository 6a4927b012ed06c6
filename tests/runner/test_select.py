"""Choice of models before the first job, and its use by later runs and shards."""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.cli.plan import plan_of
from bearingsim.cli.remarks import model_choices as choice_remarks
from bearingsim.runner import Interrupted, RunSummary, run
from bearingsim.runner.select import MissingChoices, choose_models
from bearingsim.selection import ModelSelector
from bearingsim.selection.choices import key
from bearingsim.study import Study, case_id, load_study
from tests.scenes import trials
from tests.scenes.commands import type_
from tests.scenes.study_text import Write
from tests.scenes.trials import ENGINE, LOG, TEXT, accuracy_study

ROOT = Path(__file__).parents[2]
RIGID = "rig: {ring: {bends: false}}\n"


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the log of the calls of the engine."""
    path = tmp_path / "log"
    path.touch()
    monkeypatch.setenv(LOG, str(path))
    return path


def compute(study: Study, out: Path, **options: Any) -> RunSummary:
    defaults: dict[str, Any] = {"jobs": 1, "progress": False, "engine": ENGINE}
    return run(study, out, **defaults | options)


def take_lines(log: Path) -> list[str]:
    lines = log.read_text().splitlines()
    log.write_text("")
    return lines


def count_trials(log: Path) -> int:
    return sum(line.startswith("try") for line in take_lines(log))


def read_choices(out: Path) -> dict[str, Any]:
    choices: dict[str, Any] = json.loads((out / "choices.json").read_text())["choices"]
    return choices


def read_results(out: Path) -> pd.DataFrame:
    """Read the table, without the columns that differ between runs."""
    return pd.read_csv(out / "results.csv").drop(columns=["seconds", "unit"])


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


LOADS = "150 N, 300 N, 450 N"


def make_extended(write: Write, loads: str) -> Study:
    return accuracy_study(write, TEXT.replace(LOADS, loads))


def plan_notes(out: Path) -> list[str]:
    notes: list[str] = store.read_plan(out)["accuracy"]["notes"]
    return notes


def model_errors(out: Path) -> dict[float, float]:
    """Return the error of the model of each case by load."""
    table = store.open_results(out).table()
    cases = table[table["healthy"] != ""]
    return dict(zip(cases["load"], cases["error.model"], strict=True))


def test_quick_study_stores_choices_in_its_own_folder(
    write: Write, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Overrides on the command line lead to other choices."""
    monkeypatch.chdir(tmp_path)
    path = write(TEXT + "quick: {duration: 0.15 s, sweep: {load: [150 N, 450 N]}}\n")
    overrides = {"clearance": "5 um"}
    studies = [load_study(path), load_study(path, quick=True), load_study(path, overrides, quick=True)]
    keys = [{key(study, case) for case in study.cases()} for study in studies]
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
    assert note in [*choice_remarks(plan_of(choose_models(study, out, 1, ENGINE, shown=False), 1))]
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


# Interrupts


def test_interruption_keeps_finished_trials(write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original, remaining = trials.try_out, [5]

    def interrupt(*arguments: Any) -> Any:
        remaining[0] -= 1
        if remaining[0] == 0:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(trials, "try_out", interrupt)
    with pytest.raises(Interrupted) as interruption:
        compute(accuracy_study(write), tmp_path / "out")
    summary = interruption.value.summary
    assert (summary.planned, summary.resumed, summary.done, summary.missing) == (6, 0, 0, 6)
    assert (summary.exit_code, summary.interrupted) == (130, signal.SIGINT)
    assert (
        "models were being compared, before the first job: 4 trials kept" in str(interruption.value).splitlines()
    )
    assert "run the same command to continue" in str(interruption.value)
    assert len(selection.read_trials(tmp_path / "out")) == 4
    assert not (tmp_path / "out/choices.json").exists()
    remaining[0] = 0
    assert compute(accuracy_study(write), tmp_path / "out").failed == 0
    compute(accuracy_study(write), tmp_path / "whole")
    assert read_choices(tmp_path / "out") == read_choices(tmp_path / "whole")


def test_jobs_stored_by_trials_count_as_resumed(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    remaining = [2]

    def repeat(case: Any, features: Any, passes: int, turn: float) -> Any:
        remaining[0] -= 1
        if remaining[0] < 0:
            raise KeyboardInterrupt
        return trials.trial(case.load, passes, repeats=True, names=features), trials.simulate(case)

    monkeypatch.setattr(trials, "try_out", repeat)
    with pytest.raises(Interrupted) as interruption:
        compute(accuracy_study(write), tmp_path / "out")
    assert (interruption.value.summary.planned, interruption.value.summary.resumed) == (6, 2)


@pytest.mark.parametrize(
    "arguments", [("run", "--jobs", "1"), ("run", "--jobs", "2"), ("check", "--pilots", "--jobs", "2")]
)
def test_ctrl_c_during_trials(write: Write, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    """The message names the kept trials and the next command, without a traceback."""
    accuracy_study(write, TEXT.replace(LOADS, "150 N, 300 N, 450 N, 600 N, 750 N, 900 N"))
    # a process started in the background by a shell ignores SIGINT, and its children inherit that
    handler_code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{handler_code}; from tests.scenes import trials; trials.main()"
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments, str(tmp_path / "study.yaml"), "--out", str(out)],
        cwd=ROOT,
        env={**os.environ, trials.SECONDS: "0.2"},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    end = time.monotonic() + 60.0
    while len(selection.read_trials(out)) < 3:
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    output, errors = process.communicate(timeout=30)
    assert process.returncode == 130, (output, errors)
    assert "Traceback" not in errors
    assert "models were being compared, before the first job: " in errors
    assert "run the same command to continue" in errors
    assert ("0 of 12 jobs done" in errors) == (arguments[0] == "run")
    assert not [path for path in out.rglob("*") if path.suffix in (".part", ".started")]
    assert not (out / "choices.json").exists()


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


@pytest.mark.parametrize("text", ["", "{", "[]", '{"a": 3}', '{"a": {"model": "ring"}}', "\xff"])
def test_damaged_choices_are_refused(write: Write, tmp_path: Path, text: str) -> None:
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    (out / "choices.json").write_text(text, encoding="latin-1")
    with pytest.raises(store.DamagedChoices, match=r"choices.json cannot be read .*: restore it, or remove it"):
        compute(accuracy_study(write), out)


@pytest.mark.parametrize("kept_length", [0, 1, 40, -3])
def test_damaged_trial_is_repeated(write: Write, tmp_path: Path, log: Path, kept_length: int) -> None:
    out = tmp_path / "out"
    compute(accuracy_study(write), out)
    before = read_choices(out)
    take_lines(log)
    (out / "choices.json").unlink()
    path = sorted((out / "trials").glob("*.json"))[0]
    lost_count = len(json.loads(path.read_text())["trials"])
    path.write_text(path.read_text()[:kept_length])
    compute(accuracy_study(write), out)
    assert read_choices(out) == before
    assert count_trials(log) == lost_count < 12


def test_failed_trial_does_not_end_the_run(write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original = trials.try_out

    def fail_rollers(case: Any, *arguments: Any) -> Any:
        if case.model == "rollers":
            raise RuntimeError("not this one")
        return original(case, *arguments)

    monkeypatch.setattr(trials, "try_out", fail_rollers)
    summary = compute(accuracy_study(write), tmp_path / "out")
    assert summary.failed == 0
    assert {choice["candidate"] for choice in read_choices(tmp_path / "out").values()} == {"reference"}


def test_run_killed_during_trials_chooses_the_same_models(write: Write, tmp_path: Path) -> None:
    """The run is killed at different trials."""
    complete = tmp_path / "whole"
    study = accuracy_study(write)
    compute(study, complete)
    script = (
        "import os, signal, sys; from tests.scenes import trials; from bearingsim.runner import run;"
        "from bearingsim.study import load_study; plain = trials.try_out; left = [int(sys.argv[3])]\n"
        "def dying(*of):\n"
        "    left[0] -= 1\n"
        "    if left[0] < 0: os.kill(os.getpid(), signal.SIGKILL)\n"
        "    return plain(*of)\n"
        "trials.try_out = dying\n"
        "run(load_study(sys.argv[1]), sys.argv[2], jobs=1, progress=False, engine=trials.ENGINE)"
    )
    out = tmp_path / "out"
    for count in (1, 4):
        process = subprocess.run(
            [sys.executable, "-c", script, study.path, str(out), str(count)], cwd=ROOT, check=False
        )
        assert process.returncode == -signal.SIGKILL
        assert not (out / "choices.json").exists()
        assert selection.read_trials(out)
    compute(accuracy_study(write), out)
    assert read_choices(out) == read_choices(complete)
    assert not [*out.rglob("*.part")]
    pd.testing.assert_frame_equal(read_results(complete), read_results(out))


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


# The table


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
    assert "dry friction assumed" in " ".join(plan["assumptions"])
    assert len(plan["accuracy"]["audits"]) == 3


def test_no_total_error_for_a_ring_assumed_to_be_rigid(write: Write, tmp_path: Path) -> None:
    summary = compute(accuracy_study(write), tmp_path / "out")
    table = store.open_results(tmp_path / "out").table()
    assert table["error"].isna().all()
    assert table["error.model"].notna().sum() == 3
    output = str(summary)
    assert "models for 5 %: `rollers` in 3 of 3 cases" in output
    assert "3 of 3 cases are within 5 % of the reference model" in output
    assert (
        "audit: 3 of 3 jobs recomputed with their reference are within the accuracy; largest difference 0.99 %"
        in output
    )


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
    study = load_study(write(text))

    def make_trial(case: Any, features: Any, passes: int, turn: float) -> Any:
        return trials.trial(
            (1.0 + bool(case.defects)) * case.load * trials.MODEL_FACTORS[case.model], passes, names=features
        ), None

    monkeypatch.setattr(trials, "try_out", make_trial)
    original = trials.simulate
    monkeypatch.setattr(
        trials, "simulate", lambda case: _scale_line(original(case), 1.5 if case.model == "rollers" else 1.0)
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
    assert table["error"].dropna().tolist() == pytest.approx([0.34] * 3, abs=0.005)
    printed = type_("show", tmp_path / "out")[0]
    assert output.splitlines()[1] in printed.splitlines()


def _scale_line(record: Any, factor: float) -> Any:
    record.features["velocity@BPFO"] *= factor
    return record


def test_engine_log_is_off_by_default() -> None:
    assert LOG not in os.environ
