"""Trials that are interrupted, killed, damaged or failed: what is kept, repeated and chosen."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.runner import Interrupted
from tests.scenes import trials
from tests.scenes.choices import LOADS, compute, count_trials, log, read_choices, read_results, take_lines
from tests.scenes.study_text import Write
from tests.scenes.trials import TEXT, accuracy_study

__all__ = ["log"]

ROOT = Path(__file__).parents[2]


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
